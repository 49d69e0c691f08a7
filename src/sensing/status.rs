//! What a robot knows of its own body and of the game.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::knowledge::Knowledge;

/// What the robot's body is doing.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
#[serde(rename_all = "snake_case")]
pub enum BodyStatus {
    /// Standing, free to act.
    #[default]
    Standing,
    /// Walking.
    Walking,
    /// Swinging the leg for a kick.
    Kicking,
    /// Regaining balance after a kick.
    Recovering,
    /// Taken off the pitch by the referee.
    Penalised,
}
