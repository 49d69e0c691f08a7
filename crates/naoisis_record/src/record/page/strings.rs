//! Words that come again and again, by their places in one list.

use std::collections::BTreeMap;

/// The list of all words so far. Place 0 has none.
#[derive(Clone, Default)]
pub(super) struct Strings {
    places: BTreeMap<String, i32>,
    /// Those that no part has yet.
    new: Vec<String>,
}

impl Strings {
    /// The place of `words`, which are added if they are new.
    pub(super) fn place(&mut self, words: &str) -> i32 {
        if words.is_empty() {
            return 0;
        }
        if let Some(place) = self.places.get(words) {
            return *place;
        }
        let place = self.places.len() as i32 + 1;
        self.places.insert(words.to_owned(), place);
        self.new.push(words.to_owned());
        place
    }

    /// Takes the words that came since this was asked last.
    pub(super) fn take_new(&mut self) -> Vec<String> {
        core::mem::take(&mut self.new)
    }
}
