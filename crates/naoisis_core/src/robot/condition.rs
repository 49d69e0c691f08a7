//! The condition of a robot's hardware and program, and how often it breaks down.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::motion_settings::MotionSettings;
use crate::knowledge::Knowledge;

/// How often a robot breaks down. By default it never does.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct Breakdowns {
    /// Requests for pick-up per hour of play.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "/h"))]
    pub pick_ups_per_hour: f32,
    /// Stops of the program per hour of play.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "/h"))]
    pub restarts_per_hour: f32,
    /// Duration of a restart of the program, s: 30.
    #[schemars(range(min = 0.0, max = 600.0))]
    pub restart_s: f32,
    /// Time of walking at full speed until the motors are hot, s; if absent, they do not get hot. Standing cools them as fast.
    #[schemars(range(min = 1.0, max = 100_000.0))]
    pub hot_after_s: Option<f32>,
    /// Speed of a hot robot, as a share of its full speed: 0.7.
    #[schemars(range(min = 0.05, max = 1.0))]
    pub hot_speed_share: f32,
}

impl Default for Breakdowns {
    fn default() -> Self {
        Self {
            pick_ups_per_hour: 0.0,
            restarts_per_hour: 0.0,
            restart_s: 30.0,
            hot_after_s: None,
            hot_speed_share: 0.7,
        }
    }
}

/// The condition of a robot's hardware and program.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct Condition {
    /// Heat of the motors, as the time of walking at full speed that causes it, s.
    pub heat_s: f32,
    /// Cycles until the robot's program runs again; 0 while it runs.
    pub restart_cycles_left: u32,
}

impl Condition {
    /// The limits of the robot's walk in this condition.
    pub(super) fn motion(&self, motion: &MotionSettings, breakdowns: &Breakdowns) -> MotionSettings {
        let is_hot = breakdowns.hot_after_s.is_some_and(|hot_after_s| self.heat_s >= hot_after_s);
        let mut motion = *motion;
        if is_hot {
            motion.max_linear_mps *= breakdowns.hot_speed_share;
            motion.max_angular *= breakdowns.hot_speed_share;
            if let Some(gait) = &mut motion.gait {
                gait.backward_mps *= breakdowns.hot_speed_share;
                gait.sideways_mps *= breakdowns.hot_speed_share;
            }
        }
        motion
    }

    /// Updates the heat after `period` seconds of walking with `speed_share` of the full speed. The heat exceeds `hot_after_s` by at most a
    /// tenth.
    pub(super) fn warm_up(&mut self, speed_share: f32, hot_after_s: f32, period: f32) {
        let change = if speed_share > 0.0 { speed_share.min(1.0) } else { -1.0 };
        self.heat_s = (self.heat_s + change * period).clamp(0.0, 1.1 * hot_after_s);
    }
}

impl Condition {
    /// Whether the robot's program runs.
    pub fn is_running(&self) -> bool {
        self.restart_cycles_left == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_robot_that_walks_gets_hot_and_cools_down_as_it_stands() {
        let breakdowns = Breakdowns { hot_after_s: Some(60.0), ..Breakdowns::default() };
        let motion = MotionSettings { max_linear_mps: 0.3, ..MotionSettings::default() };
        let mut condition = Condition::default();
        for _ in 0..59 {
            condition.warm_up(1.0, 60.0, 1.0);
        }
        assert_eq!(condition.motion(&motion, &breakdowns).max_linear_mps, 0.3);
        condition.warm_up(1.0, 60.0, 1.0);
        assert_abs_diff_eq!(condition.motion(&motion, &breakdowns).max_linear_mps, 0.21, epsilon = 1e-6);
        for _ in 0..100 {
            condition.warm_up(1.0, 60.0, 1.0);
        }
        // The heat is bounded, so that the robot cools down soon even after a long walk.
        for _ in 0..7 {
            condition.warm_up(0.0, 60.0, 1.0);
        }
        assert_eq!(condition.motion(&motion, &breakdowns).max_linear_mps, 0.3);
    }
}
