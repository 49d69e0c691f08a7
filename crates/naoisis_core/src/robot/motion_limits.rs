//! How robots walk: the settings.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::{file_units, to_radians};
use crate::knowledge::Knowledge;

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
    /// Walks step by step; without, commands are followed at once, as in the paper. In place of the error above, its slip is what
    /// errs.
    pub gait: Option<Gait>,
}

impl Default for MotionLimits {
    fn default() -> Self {
        Self {
            max_linear_mps: 0.2,
            max_angular: core::f32::consts::FRAC_PI_2,
            error_sd: MotionError::default(),
            gait: None,
        }
    }
}

/// How a robot walks step by step. By default as a NAO V6 of 2025 on ground that does not slip.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gait {
    /// Duration of a step, s: as long it keeps its velocity.
    pub step_s: f32,
    /// Greatest speed backwards, m/s; forwards it is [`MotionLimits::max_linear_mps`].
    pub backward_mps: f32,
    /// Greatest speed to either side, m/s.
    pub sideways_mps: f32,
    /// By how much the speed changes from step to step, m/s².
    pub acceleration_mps2: f32,
    /// By how much the turn changes from step to step, rad/s² (degrees/s² in files).
    #[serde(rename = "angular_acceleration_degps2", with = "file_units::degrees")]
    pub angular_acceleration: f32,
    /// More slowly it does not get ahead, m/s.
    pub least_mps: f32,
    /// More slowly it does not turn, rad/s (degrees per second in files).
    #[serde(rename = "least_degps", with = "file_units::degrees")]
    pub least_angular: f32,
    /// What the ground makes of the steps.
    pub slip: Slip,
}

impl Default for Gait {
    fn default() -> Self {
        Self {
            step_s: 0.25,
            backward_mps: 0.15,
            sideways_mps: 0.19,
            acceleration_mps2: 0.3,
            angular_acceleration: to_radians(180.0),
            least_mps: 0.02,
            least_angular: to_radians(5.0),
            slip: Slip::default(),
        }
    }
}

/// How the ground differs from one that holds. By default not at all.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Slip {
    /// The way that a robot gets on average, as a share of that of its legs.
    pub scale: f32,
    /// Standard deviation of that share from robot to robot and match to match.
    pub scale_sd: f32,
    /// Standard deviation, from robot to robot and match to match, of the heading's drift on a straight way, rad/m (degrees
    /// a metre in files).
    #[serde(rename = "drift_sd_degpm", with = "file_units::degrees")]
    pub drift_sd: f32,
    /// What is random in each step.
    pub error: StepNoise,
}

impl Default for Slip {
    fn default() -> Self {
        Self { scale: 1.0, scale_sd: 0.0, drift_sd: 0.0, error: StepNoise::default() }
    }
}

/// Random errors of steps, of a variance that grows with the way walked and with the angle turned, so that they depend neither on
/// the length of a step nor on the duration of a cycle. None by default.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StepNoise {
    /// Standard deviation of the place after 1 m of way, along it and across it, m. Grows with the way's root.
    pub translation_sd_m: f32,
    /// Standard deviation of the heading after 1 m of way, radians (degrees in files). Grows with the way's root.
    #[serde(rename = "heading_per_metre_sd_deg", with = "file_units::degrees")]
    pub heading_per_metre_sd: f32,
    /// Standard deviation of the heading after a turn of 1 radian, radians (degrees in files). Grows with the angle's root.
    #[serde(rename = "rotation_sd_deg", with = "file_units::degrees")]
    pub rotation_sd: f32,
}
