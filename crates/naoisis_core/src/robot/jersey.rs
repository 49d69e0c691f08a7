//! The jerseys of robots.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A jersey: the shell of the trunk in one colour, with the robot's number on chest and back. The colours but `team` are those of the
/// GameController.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Jersey {
    /// The colour of the team's waistband: blue or pink.
    Team,
    /// Blue.
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
