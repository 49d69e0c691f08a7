//! A list of repeated texts, which are referred to by their index.

use std::collections::BTreeMap;

/// The list of all texts so far. Index 0 is the empty text.
#[derive(Clone, Default)]
pub(super) struct Strings {
    places: BTreeMap<String, i32>,
    /// Texts that no part of the page has yet.
    new: Vec<String>,
}

impl Strings {
    /// Returns the index of `words`, and adds them if they are new.
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

    /// Removes and returns the texts that were added since the last call, and the index of the first of them.
    pub(super) fn take_new(&mut self) -> (usize, Vec<String>) {
        (self.places.len() + 1 - self.new.len(), core::mem::take(&mut self.new))
    }
}
