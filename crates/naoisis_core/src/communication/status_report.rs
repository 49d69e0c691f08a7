//! The status report of a robot to the GameController.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::geometry::{Pose, file_units};
use crate::knowledge::Knowledge;

/// The last status report of a robot's program to the GameController, which is not checked.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Belief)]
pub struct StatusReport {
    /// Time of the report, s since the start.
    pub time_s: f64,
    /// Whether the robot reports that it has fallen.
    pub fallen: bool,
    /// Reported pose in the team frame: `[x m, y m, heading deg]` in files.
    #[serde(with = "file_units::pose")]
    #[schemars(with = "[f32; 3]")]
    pub pose: Pose,
    /// Time since the ball was seen, s; `None` if it has not been seen.
    pub ball_age_s: Option<f32>,
    /// Reported position of the ball, m, robot frame.
    #[schemars(with = "Option<[f32; 2]>")]
    pub ball_m: Option<Vec2>,
}
