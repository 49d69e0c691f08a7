//! What is wrong with a GameController, said once: as an event, and to the user.

use core::fmt;

use naoisis_core::events::{CycleEvents, MatchEvent};

/// A function that receives messages about what is heard.
pub type HeardNotes = Box<dyn Fn(&str) + Send + Sync>;

/// Messages that are said once.
#[derive(Default)]
pub struct Complaints {
    /// All messages so far; the first [`published`](Self::publish) ones are events already.
    said: Vec<String>,
    published: usize,
    pub notes: Option<HeardNotes>,
}

impl fmt::Debug for Complaints {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Complaints").field("said", &self.said).finish_non_exhaustive()
    }
}

impl Complaints {
    /// Adds a message, unless it was said before.
    pub fn add(&mut self, message: String) {
        if !self.said.contains(&message) {
            self.note(&message);
            self.said.push(message);
        }
    }

    /// Tells the user.
    pub fn note(&self, message: &str) {
        self.notes.iter().for_each(|note| note(message));
    }

    /// Adds the new messages to the events of the cycle.
    pub fn publish(&mut self, events: &mut CycleEvents) {
        let new =
            self.said[self.published..].iter().map(|message| MatchEvent::GameController { message: message.clone() });
        events.extend(new);
        self.published = self.said.len();
    }
}
