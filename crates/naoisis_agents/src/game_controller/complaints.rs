//! Reports of faults of a GameController. Each is made once: as an event, and to the user.

use core::fmt;

use naoisis_core::events::{CycleEvents, MatchEvent};

/// A function that receives messages about the GameController and its teams.
pub type HeardNotes = Box<dyn Fn(&str) + Send + Sync>;

/// The greatest number of messages: senders can cause any number of them.
const MOST_MESSAGES: usize = 50;

/// Messages that are reported once.
#[derive(Default)]
pub struct Complaints {
    /// All messages so far; the first `published` of them are events already.
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
    /// Adds a message, unless it was added before or there are too many.
    pub fn add(&mut self, message: String) {
        if self.said.len() < MOST_MESSAGES && !self.said.contains(&message) {
            self.note(&message);
            self.said.push(message);
        }
    }

    /// Passes a message to the user.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_message_is_an_event_once_and_there_are_no_more_than_so_many() {
        let (mut complaints, mut events) = (Complaints::default(), CycleEvents::default());
        for port in 0..200 {
            complaints.add(format!("a second GameController at 10.0.0.1:{port}"));
            complaints.add("a second GameController at 10.0.0.1:0".to_owned());
            complaints.publish(&mut events);
        }
        assert_eq!(events.iter().count(), MOST_MESSAGES);
    }
}
