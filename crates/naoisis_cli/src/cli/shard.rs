//! Parts of a batch.

use core::str::FromStr;

/// One of several parts of a batch.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Shard {
    /// The number of this part, from 1.
    pub part: usize,
    /// The number of parts.
    pub parts: usize,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let numbers = word.split_once('/').and_then(|(part, parts)| Some((part.parse().ok()?, parts.parse().ok()?)));
        match numbers {
            Some((part, parts)) if (1..=parts).contains(&part) => Ok(Self { part, parts }),
            _ => Err("expected a part and the number of parts, from 1/4 to 4/4".to_owned()),
        }
    }
}
