//! What a robot reports of itself to the GameController.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::{Pose, file_units};
use crate::knowledge::Knowledge;

/// What a robot has last reported of itself to the GameController, if it has: it takes whoever decides for it at its word.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Belief)]
pub struct StatusReport {
    /// When it came, s since the start.
    pub time_s: f64,
    /// Whether it says that it has fallen.
    pub fallen: bool,
    /// Where it says that it is, in the frame of its team: `[x m, y m, heading deg]` in files.
    #[serde(with = "file_units::pose")]
    pub pose: Pose,
    /// How long ago it has seen the ball, s; none if it has not.
    pub ball_age_s: Option<f32>,
    /// Where it saw it, m, in its own frame.
    pub ball_m: Option<Vec2>,
}
