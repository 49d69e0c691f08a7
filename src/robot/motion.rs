//! Walking: what a behaviour commands, and what the robot's limits and errors make of it.
//!
//! The paper's motion engine (section 3.2, equation 1) accepts a desired displacement (dx, dy, dθ) in the robot's
//! current frame, for the coming cycle. What exceeds the robot's maximum linear or angular velocity is scaled down;
//! then a random error with its own spread in each dimension is added.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::file_units;
use crate::knowledge::Knowledge;

/// A displacement larger than this in metres or radians is refused as an error of the behaviour, where a merely
/// ambitious one is scaled down.
pub const LARGEST_COMMAND: f32 = 1000.0;

/// The displacement wanted in this cycle. Null again after every cycle.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct WalkCommand {
    /// Forward, m, in the robot frame before the turn.
    pub dx: f32,
    /// To the left, m, in the robot frame before the turn.
    pub dy: f32,
    /// Counter-clockwise turn, radians.
    pub dtheta: f32,
}

impl WalkCommand {
    /// A command of these displacements: metres, metres and radians.
    pub const fn new(dx: f32, dy: f32, dtheta: f32) -> Self {
        Self { dx, dy, dtheta }
    }

    /// Whether it asks for no motion at all.
    pub fn is_null(self) -> bool {
        self == WalkCommand::default()
    }

    /// The translation, m, in the robot frame before the turn.
    pub fn translation(self) -> Vec2 {
        Vec2::new(self.dx, self.dy)
    }
}

/// What the robot really walked in the last cycle, after limits, error and collisions: the displacement in the robot
/// frame as it was before. Being carried by the referee does not count.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct ExecutedStep(pub WalkCommand);

/// Standard deviations of the error that is added to every command that is not null.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotionError {
    /// Forward, m per cycle.
    pub dx_m: f32,
    /// To the left, m per cycle.
    pub dy_m: f32,
    /// Turn, radians per cycle (degrees in files).
    #[serde(rename = "dtheta_deg", with = "file_units::degrees")]
    pub dtheta: f32,
}

/// How fast a robot walks and turns, and how exactly.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct MotionLimits {
    /// Greatest speed of translation in any direction, m/s. Default 0.2: rUNSWift's FastWalk of 2010 reached 0.22.
    pub max_linear_mps: f32,
    /// Greatest turning speed, rad/s (degrees per second in files). Default 90 degrees per second.
    #[serde(rename = "max_angular_degps", with = "file_units::degrees")]
    pub max_angular: f32,
    /// The spread of the error of each command. None by default.
    pub error_sd: MotionError,
}

impl Default for MotionLimits {
    fn default() -> Self {
        Self { max_linear_mps: 0.2, max_angular: core::f32::consts::FRAC_PI_2, error_sd: MotionError::default() }
    }
}
