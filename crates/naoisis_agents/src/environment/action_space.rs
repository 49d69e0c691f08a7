//! The numbers of an action: those of its kind, and what the robot says.

use super::action::{ActionKind, NotAnAction};
use super::extras::MOST_WORDS;

/// The numbers of a continuous action that say something: whether a message is sent, and its words.
pub const SAYS: [(&str, &str); 1 + MOST_WORDS as usize] = [
    ("say.send", "above 0.5 the robot sends its words to its team-mates"),
    ("say.word1", "a word of the message"),
    ("say.word2", "a word of the message"),
    ("say.word3", "a word of the message"),
    ("say.word4", "a word of the message"),
    ("say.word5", "a word of the message"),
    ("say.word6", "a word of the message"),
    ("say.word7", "a word of the message"),
    ("say.word8", "a word of the message"),
];

/// The choices of what to say, for actions that are choices: nothing, or one of the words.
pub const SPOKEN: [&str; 1 + MOST_WORDS as usize] = [
    "say_nothing", "say_word1", "say_word2", "say_word3", "say_word4", "say_word5", "say_word6", "say_word7",
    "say_word8",
];

/// An action space cannot have this number of words.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WordsError {
    /// There are too many words.
    #[error("{0} words; expected 0 to {MOST_WORDS}")]
    TooMany(u8),
    /// The action is one choice, which has no place for words.
    #[error("an action `discrete` is one choice; expected another kind of action, or no words")]
    OneChoice,
}

naoisis_core::debug_as_displayed!(WordsError);

/// The kind of an action, and the number of words that a robot can say with it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ActionSpace {
    kind: ActionKind,
    words: u8,
}

impl From<ActionKind> for ActionSpace {
    fn from(kind: ActionKind) -> Self {
        Self { kind, words: 0 }
    }
}

impl ActionSpace {
    /// Creates the space of actions of a kind with `words` to say.
    ///
    /// # Errors
    /// If there are more than [`MOST_WORDS`] words, or any with [`ActionKind::Discrete`].
    pub fn new(kind: ActionKind, words: u8) -> Result<Self, WordsError> {
        match (kind, words) {
            (_, 1..) if words > MOST_WORDS => Err(WordsError::TooMany(words)),
            (ActionKind::Discrete, 1..) => Err(WordsError::OneChoice),
            _ => Ok(Self { kind, words }),
        }
    }

    /// The kind.
    pub fn kind(self) -> ActionKind {
        self.kind
    }

    /// The number of values of an action.
    pub fn len(self) -> usize {
        self.kind.len() + self.numbers_said()
    }

    /// Whether an action has no values; always false.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The number of values that say something.
    fn numbers_said(self) -> usize {
        match (self.words, self.kind) {
            (0, _) => 0,
            (words, ActionKind::Continuous) => 1 + usize::from(words),
            _ => 1,
        }
    }

    /// The names of the values of a continuous action, or of the choices, one list per choice.
    pub fn names(self) -> Vec<Vec<&'static str>> {
        let mut names = self.kind.names();
        let last = usize::from(self.words);
        match (self.words, self.kind) {
            (0, _) => {}
            (_, ActionKind::Continuous) => names[0].extend(SAYS.iter().take(1 + last).map(|(name, _)| name)),
            _ => names.push(SPOKEN.iter().take(1 + last).copied().collect()),
        }
        names
    }

    /// Checks that `action` is valid.
    ///
    /// # Errors
    /// The first value that is not valid.
    pub fn check(self, action: &[f32]) -> Result<(), NotAnAction> {
        let (body, said) = action.split_at_checked(self.kind.len()).unwrap_or((action, &[]));
        self.kind.check(body)?;
        for (value, (name, _)) in said.iter().zip(&SAYS) {
            let is_choice = self.kind != ActionKind::Continuous;
            let is_valid = if is_choice {
                (0.0..=f32::from(self.words)).contains(value) && value.fract() == 0.0
            } else {
                value.is_finite()
            };
            if !is_valid {
                let (name, expected) = match is_choice {
                    true => ("choice of words", format!("a whole number from 0 to {}", self.words)),
                    false => (*name, "a number from -1 to 1".to_owned()),
                };
                return Err(NotAnAction::new(name, *value, expected));
            }
        }
        Ok(())
    }

    /// Returns the words that a [checked](Self::check) action says; `None` if it says nothing.
    pub(crate) fn said(self, action: &[f32]) -> Option<Vec<f32>> {
        let said = action.get(self.kind.len()..)?;
        let (first, words) = said.split_first()?;
        if self.kind == ActionKind::Continuous {
            return (*first > 0.5).then(|| words.iter().map(|word| word.clamp(-1.0, 1.0)).collect());
        }
        let chosen = (*first as usize).checked_sub(1)?;
        Some((0..usize::from(self.words)).map(|word| f32::from(u8::from(word == chosen))).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_more_numbers_or_one_more_choice() {
        let space = ActionSpace::new(ActionKind::Continuous, 2).unwrap();
        assert_eq!((space.len(), space.names()[0].last()), (11, Some(&"say.word2")));
        let mut action = [0.0; 11];
        assert_eq!((space.check(&action), space.said(&action)), (Ok(()), None));
        action[8..].copy_from_slice(&[0.6, -3.0, 0.5]);
        assert_eq!((space.check(&action), space.said(&action)), (Ok(()), Some(vec![-1.0, 0.5])));
        action[10] = f32::INFINITY;
        assert_eq!(
            space.check(&action).unwrap_err().to_string(),
            "the action has inf for say.word2; expected a number from -1 to 1"
        );
        let space = ActionSpace::new(ActionKind::Velocities, 3).unwrap();
        assert_eq!((space.len(), space.names()[4].len()), (5, 4));
        assert_eq!(space.said(&[0.0, 0.0, 0.0, 0.0, 2.0]), Some(vec![0.0, 1.0, 0.0]));
        assert_eq!(space.said(&[0.0; 5]), None);
        assert!(space.check(&[0.0, 0.0, 0.0, 0.0, 3.0]).is_ok() && space.check(&[0.0, 0.0, 0.0, 0.0, 4.0]).is_err());
    }

    #[test]
    fn one_choice_has_no_place_for_words() {
        assert_eq!(ActionSpace::new(ActionKind::Discrete, 1), Err(WordsError::OneChoice));
        assert_eq!(ActionSpace::new(ActionKind::Velocities, 9), Err(WordsError::TooMany(9)));
        assert_eq!(ActionSpace::new(ActionKind::Discrete, 0).map(ActionSpace::len), Ok(1));
    }
}
