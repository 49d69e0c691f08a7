//! What an observation has beside the entries of its kind, and what robots can say.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The greatest number of words in a message of an agent.
pub const MOST_WORDS: u8 = 8;

/// Options of observations and actions. By default there are none.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Extras {
    /// Whether set plays, drop balls and stops are observed, as the robot was told of them.
    #[serde(skip_serializing_if = "core::ops::Not::not")]
    pub set_plays: bool,
    /// Whether the penalties of the other robots are observed, as the robot was told of them.
    #[serde(skip_serializing_if = "core::ops::Not::not")]
    pub penalties: bool,
    /// Whether the last message of each team-mate is observed.
    #[serde(skip_serializing_if = "core::ops::Not::not")]
    pub messages: bool,
    /// Whether other robots keep their numbers in the observation while they are followed from step to step. Otherwise the nearest is first.
    #[serde(skip_serializing_if = "core::ops::Not::not")]
    pub tracked: bool,
    /// The number of words that a robot can say to its team-mates as a part of its action, from 0 to 8.
    #[serde(skip_serializing_if = "is_zero")]
    pub words: u8,
}

impl Extras {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

fn is_zero(words: &u8) -> bool {
    *words == 0
}
