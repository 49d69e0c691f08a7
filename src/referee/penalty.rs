//! Penalties of robots.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::knowledge::Knowledge;

/// The penalty that a robot serves, if any. A penalised robot cannot act, is no obstacle, and is not seen.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct Penalty(pub Option<ActivePenalty>);

impl Penalty {
    /// Whether the robot is off the pitch.
    pub fn is_active(&self) -> bool {
        self.0.is_some()
    }
}

/// A penalty that is being served.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct ActivePenalty {
    /// What for.
    pub reason: PenaltyReason,
    /// Cycles until the robot may come back.
    pub cycles_left: u64,
}

/// What a robot can be penalised for.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PenaltyReason {
    /// It is responsible for a collision with another robot.
    Pushing,
    /// It stood near the ball for too long.
    Stalling,
}
