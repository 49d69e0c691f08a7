//! The jerseys of robots.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::team::Team;

/// A jersey: the shell of the trunk in one colour, with the robot's number on chest and back. The colours but `team` are those of the
/// GameController.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Jersey {
    /// The colour of the team's waistband: blue or pink.
    Team,
    /// Blue.
    #[default]
    Blue,
    /// Red.
    Red,
    /// Yellow.
    Yellow,
    /// Black.
    Black,
    /// White.
    White,
    /// Green.
    Green,
    /// Orange.
    Orange,
    /// Purple.
    Purple,
    /// Brown.
    Brown,
    /// Grey.
    Grey,
}

impl Jersey {
    /// The colours of the GameController with their names, in the order of their codes.
    pub const COLOURS: [(&'static str, Jersey); 10] = [
        ("blue", Jersey::Blue),
        ("red", Jersey::Red),
        ("yellow", Jersey::Yellow),
        ("black", Jersey::Black),
        ("white", Jersey::White),
        ("green", Jersey::Green),
        ("orange", Jersey::Orange),
        ("purple", Jersey::Purple),
        ("brown", Jersey::Brown),
        ("grey", Jersey::Grey),
    ];

    /// The colour of the GameController for a robot of `team`: blue or red if it wears `team`, since the GameController has no pink.
    #[must_use]
    pub const fn colour_of(self, team: Team) -> Self {
        match (self, team) {
            (Jersey::Team, Team::Blue) => Jersey::Blue,
            (Jersey::Team, Team::Pink) => Jersey::Red,
            (colour, _) => colour,
        }
    }

    /// The code of the GameController for this colour; `None` for `team`.
    pub fn code(self) -> Option<u8> {
        (0..).zip(Self::COLOURS).find_map(|(code, (_, colour))| (colour == self).then_some(code))
    }

    /// The name of the colour; `None` for `team`.
    pub fn name(self) -> Option<&'static str> {
        Self::COLOURS.iter().find_map(|(name, colour)| (*colour == self).then_some(*name))
    }

    /// The colour with this code of the GameController. Unknown codes are grey.
    pub fn of_code(code: u8) -> Self {
        Self::COLOURS.get(usize::from(code)).map_or(Jersey::Grey, |(_, colour)| *colour)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_have_the_codes_of_the_game_controller_and_their_names_in_files() {
        for (code, (name, colour)) in (0..).zip(Jersey::COLOURS) {
            assert_eq!((colour.code(), Jersey::of_code(code)), (Some(code), colour));
            assert_eq!(colour.name(), Some(name));
            assert_eq!(serde_json::to_value(colour).unwrap(), name);
        }
        assert_eq!((Jersey::Team.code(), Jersey::of_code(77)), (None, Jersey::Grey));
    }
}
