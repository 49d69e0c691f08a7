//! Settings of the walk.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::geometry::{file_units, to_radians};
use crate::knowledge::Knowledge;

/// Standard deviations of the error that is added to every non-zero command.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MotionError {
    /// Forward, m per cycle.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub dx_m: f32,
    /// To the left, m per cycle.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub dy_m: f32,
    /// Turn, radians per cycle (degrees in files).
    #[serde(rename = "dtheta_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 360.0))]
    pub dtheta: f32,
}

/// How a robot walks: its greatest speeds, its errors and its gait.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct MotionSettings {
    /// Greatest speed of translation in any direction, m/s. Default 0.2: rUNSWift's FastWalk of 2010 reached 0.22.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub max_linear_mps: f32,
    /// Greatest turning speed, rad/s (degrees per second in files). Default 90 degrees per second.
    #[serde(rename = "max_angular_degps", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 1080.0))]
    pub max_angular: f32,
    /// Standard deviation of the error of each command. Zero by default.
    pub error_sd: MotionError,
    /// The gait of a robot that walks step by step, with errors from its slip instead of `error_sd`. If absent, commands are executed at
    /// once, as in the paper.
    pub gait: Option<Gait>,
}

impl Default for MotionSettings {
    fn default() -> Self {
        Self {
            max_linear_mps: 0.2,
            max_angular: core::f32::consts::FRAC_PI_2,
            error_sd: MotionError::default(),
            gait: None,
        }
    }
}

/// A gait in steps. The default is a NAO V6 of 2025 on ground without slip.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Gait {
    /// Duration of a step, during which the velocity is constant, s.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub step_s: f32,
    /// Greatest speed backwards, m/s; forwards it is [`MotionSettings::max_linear_mps`].
    #[schemars(range(min = 0.001, max = 5.0))]
    pub backward_mps: f32,
    /// Greatest speed to either side, m/s.
    #[schemars(range(min = 0.001, max = 5.0))]
    pub sideways_mps: f32,
    /// Greatest change of the speed from step to step, m/s².
    #[schemars(range(min = 0.01, max = 1000.0))]
    pub acceleration_mps2: f32,
    /// Greatest change of the turning speed from step to step, rad/s² (degrees/s² in files).
    #[serde(rename = "angular_acceleration_degps2", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 1.0, max = 100_000.0))]
    pub angular_acceleration: f32,
    /// Lowest speed that the gait can walk, m/s. Slower commands become zero.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub least_mps: f32,
    /// Lowest turning speed of the gait, rad/s (degrees per second in files). Slower commands become zero.
    #[serde(rename = "least_degps", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 180.0))]
    pub least_angular: f32,
    /// Which speeds can be combined.
    pub volume: WalkVolume,
    /// Slip of the feet.
    pub slip: Slip,
    /// Touches of the ball in walking.
    pub touch: BallTouch,
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
            volume: WalkVolume::default(),
            slip: Slip::default(),
            touch: BallTouch::default(),
        }
    }
}

/// Which speeds a gait can combine. With the speeds ahead x, sideways y and of turning z as shares of their limits, the size
/// ((x^r + y^r)^(t/r) + z^t)^(1/t) is at most 1, where r is the exponent of translation and t that of rotation.
///
/// By default both exponents are 1: the shares add up to at most 1, as in rUNSWift's `FastWalk` of 2010. With 2 and 2 the combined speeds
/// lie in an ellipsoid.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct WalkVolume {
    /// The exponent for walking ahead and sideways at once.
    #[schemars(range(min = 1.0, max = 10.0))]
    pub translation_exponent: f32,
    /// The exponent for walking and turning at once.
    #[schemars(range(min = 1.0, max = 10.0))]
    pub rotation_exponent: f32,
}

impl Default for WalkVolume {
    fn default() -> Self {
        Self { translation_exponent: 1.0, rotation_exponent: 1.0 }
    }
}

/// How a robot that walks into the ball pushes it: the foot that meets the ball swings faster than the body walks.
///
/// By default the ball is met by the body alone, as in the paper.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BallTouch {
    /// Mean speed of the swinging foot, as a multiple of the walking speed. In the middle of a step the foot is faster, at its start and
    /// end as fast as the body.
    #[schemars(range(min = 1.0, max = 5.0), extend("unit" = " times the walking speed"))]
    pub foot_speed: f32,
    /// Standard deviation of the ball's direction, radians (degrees in files).
    #[serde(rename = "direction_sd_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 90.0))]
    pub direction_sd: f32,
}

impl Default for BallTouch {
    fn default() -> Self {
        Self { foot_speed: 1.0, direction_sd: 0.0 }
    }
}

/// Slip of the feet on the ground. By default none.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Slip {
    /// Mean displacement after slip, as a share of that of the legs.
    #[schemars(range(min = 0.1, max = 2.0))]
    pub scale: f32,
    /// Standard deviation of that share from robot to robot and match to match.
    #[schemars(range(min = 0.0, max = 0.3))]
    pub scale_sd: f32,
    /// Standard deviation, from robot to robot and match to match, of the heading drift in straight walking, rad/m (degrees per
    /// metre in files).
    #[serde(rename = "drift_sd_degpm", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 90.0))]
    pub drift_sd: f32,
    /// Noise of each step.
    pub error: StepNoise,
}

impl Default for Slip {
    fn default() -> Self {
        Self { scale: 1.0, scale_sd: 0.0, drift_sd: 0.0, error: StepNoise::default() }
    }
}

/// Noise of steps. Its variance is proportional to the distance walked and the angle turned, so that it depends neither on the
/// length of a step nor on the duration of a cycle. None by default.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct StepNoise {
    /// Standard deviation of the position after 1 m, along and across the path, m. Grows with the square root of the distance.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub translation_sd_m: f32,
    /// Standard deviation of the heading after 1 m, radians (degrees in files). Grows with the square root of the distance.
    #[serde(rename = "heading_per_metre_sd_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 180.0))]
    pub heading_per_metre_sd: f32,
    /// Standard deviation of the heading after a turn of 1 radian, radians (degrees in files). Grows with the square root of the
    /// angle.
    #[serde(rename = "rotation_sd_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 180.0))]
    pub rotation_sd: f32,
}
