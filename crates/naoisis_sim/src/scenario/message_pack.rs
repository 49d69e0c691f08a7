//! Checks the structure of MessagePack, without its meaning: whether lists, maps and texts are as long as they claim.
//!
//! A reader allocates memory for as many values as a list claims to have. In a damaged file this may be billions, so the file is checked
//! first.

/// A fault of the structure of MessagePack.
#[derive(Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MessagePackError {
    /// The bytes end in the middle of a value.
    #[error("it ends in the middle of the value at byte {at}")]
    EndsEarly {
        /// Index of the byte at which the value begins.
        at: usize,
    },
    /// A byte cannot begin a value.
    #[error("there is no MessagePack at byte {at}")]
    NoValue {
        /// Index of the byte.
        at: usize,
    },
    /// A value claims more content than there are bytes.
    #[error("what is at byte {at} says that it has more than there is")]
    TooLong {
        /// Index of the byte at which the value begins.
        at: usize,
    },
}

naoisis_core::debug_as_displayed!(MessagePackError);

/// Checks the first value of the bytes, and all values in it.
///
/// # Errors
/// The fault, and the index of its byte.
pub fn check(bytes: &[u8]) -> Result<(), MessagePackError> {
    let mut rest = bytes;
    // Each value has at least one byte, so the number of missing values must be less than that of the bytes left.
    let mut values = 1_u64;
    while values > 0 {
        let at = bytes.len() - rest.len();
        let item = next_item(rest).ok_or(MessagePackError::EndsEarly { at })?;
        let item = item.ok_or(MessagePackError::NoValue { at })?;
        let left = rest.len() as u64 - item.header;
        values = values - 1 + item.values;
        if item.content > left || values > left - item.content {
            return Err(MessagePackError::TooLong { at });
        }
        rest = &rest[(item.header + item.content) as usize..];
    }
    Ok(())
}

/// The information in the first bytes of a value.
struct Item {
    /// Number of bytes for the type and the length.
    header: u64,
    /// Number of bytes of the number or text after them.
    content: u64,
    /// Number of values in the list or map, keys included.
    values: u64,
}

/// Reads the value that begins here. The outer `None`: the bytes end; the inner one: the byte is not valid MessagePack.
fn next_item(bytes: &[u8]) -> Option<Option<Item>> {
    let (&marker, rest) = bytes.split_first()?;
    // A big-endian length with this number of bytes.
    let length = |size: usize| Some(rest.get(..size)?.iter().fold(0, |sum, byte| sum << 8 | u64::from(*byte)));
    let of = |size: usize, content: u64, values: u64| Some(Item { header: 1 + size as u64, content, values });
    let size = |first: u8| 1 << (marker - first);
    Some(match marker {
        // Small integers, nil, false and true.
        0x00..=0x7f | 0xe0..=0xff | 0xc0 | 0xc2 | 0xc3 => of(0, 0, 0),
        // Short maps, lists and texts.
        0x80..=0x8f => of(0, 0, 2 * u64::from(marker & 0x0f)),
        0x90..=0x9f => of(0, 0, u64::from(marker & 0x0f)),
        0xa0..=0xbf => of(0, u64::from(marker & 0x1f), 0),
        // Binary data, then extensions, which also have a type.
        0xc4..=0xc6 => of(size(0xc4), length(size(0xc4))?, 0),
        0xc7..=0xc9 => of(size(0xc7), length(size(0xc7))? + 1, 0),
        // Floating-point numbers, unsigned and signed integers, then extensions of a fixed length.
        0xca | 0xcb => of(0, 4 * size(0xca) as u64, 0),
        0xcc..=0xcf => of(0, size(0xcc) as u64, 0),
        0xd0..=0xd3 => of(0, size(0xd0) as u64, 0),
        0xd4..=0xd8 => of(0, size(0xd4) as u64 + 1, 0),
        // Strings, arrays, maps.
        0xd9..=0xdb => of(size(0xd9), length(size(0xd9))?, 0),
        0xdc | 0xdd => of(2 * size(0xdc), 0, length(2 * size(0xdc))?),
        0xde | 0xdf => of(2 * size(0xde), 0, 2 * length(2 * size(0xde))?),
        0xc1 => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Serialize;

    #[derive(Serialize, Default)]
    struct Everything {
        nothing: Option<u8>,
        yes: bool,
        counts: Vec<u64>,
        integers: Vec<i64>,
        numbers: (f32, f64),
        texts: Vec<String>,
        map: std::collections::BTreeMap<u32, String>,
        nested: Vec<Everything>,
    }

    fn everything() -> Vec<u8> {
        let thing = |length: usize| Everything {
            yes: true,
            counts: (0..64).map(|bits| (1 << bits) - 1).collect(),
            integers: (0..63).map(|bits| -(1 << bits)).collect(),
            numbers: (0.5, 1e300),
            texts: [3, 40, 300, 70_000].map(|length| "x".repeat(length)).to_vec(),
            map: (0..length as u32).map(|key| (key, key.to_string())).collect(),
            ..Everything::default()
        };
        let nested = [2, 15, 16, 70_000].map(thing).into();
        rmp_serde::to_vec_named(&Everything { nested, ..thing(0) }).unwrap()
    }

    #[test]
    fn what_a_program_writes_is_walked_through_to_its_end() {
        let mut whole = everything();
        assert_eq!(check(&whole), Ok(()));
        for length in (0..whole.len()).step_by(997) {
            assert!(check(&whole[..length]).is_err(), "{length} bytes");
        }
        whole.truncate(whole.len() - 1);
        assert!(check(&whole).is_err());
        let bytes = [&[0x94, 0xc4, 3][..], &[0; 3], &[0xc7, 2, 9, 0, 0], &[0xd8], &[0; 17], &[0xd4, 0, 0]].concat();
        assert_eq!(check(&bytes), Ok(()));
    }

    #[test]
    fn nothing_says_that_it_has_more_than_there_is() {
        let more = "says that it has more than there is";
        for (bytes, expected) in [
            (&[0xdd, 0xff, 0xff, 0xff, 0xff, 1, 2][..], more),
            (&[0xdf, 0, 0, 0, 1, 1], more),
            (&[0xdb, 0xff, 0xff, 0xff, 0xff, b'x'], more),
            // Each of the lists alone could be complete, but not all of them together.
            (&[0x93, 0x93, 0x93, 1, 2, 3], more),
            (&[0x91, 0xcb, 1, 2], more),
            (&[0x91, 0xc1], "there is no MessagePack at byte 1"),
            (&[0xdd, 0xff], "it ends in the middle of the value at byte 0"),
            (&[], "it ends in the middle of the value at byte 0"),
        ] {
            let message = check(bytes).unwrap_err().to_string();
            assert!(message.contains(expected), "{bytes:?}: {message}");
        }
    }
}
