//! Settings of falls and of getting up.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::knowledge::Knowledge;
use crate::robot::posture::LyingOn;

/// How often a robot falls, and how it gets up. By default only the rules apply.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct FallModel {
    /// Falls per minute of walking at full speed; proportional to the square of the speed.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub falls_per_min: f32,
    /// Falls per minute of contact with another robot.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub contact_falls_per_min: f32,
    /// Probability of a fall in a kick at full speed; proportional to the speed of the kick.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub kick_probability: f32,
    /// Falls in collisions with robots, instead of those in the rules.
    pub collisions: Option<CollisionFalls>,
    /// Probability of a fall on walking into a robot that lies, instead of that of other collisions.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub trip_probability: Option<f32>,
    /// Standard deviation of the natural logarithm of a robot's own factor of `falls_per_min` and `contact_falls_per_min`. The
    /// factor is drawn once per match, and 1 on average.
    #[schemars(range(min = 0.0, max = 3.0))]
    pub spread: f32,
    /// Share of the falls after which the robot lies on its back.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub on_back_share: f32,
    /// Duration of getting up, s, instead of that in the rules.
    #[schemars(range(min = 0.0, max = 600.0))]
    pub get_up_s: Option<f32>,
    /// Duration of getting up from the back, s, instead of `get_up_s`.
    #[schemars(range(min = 0.0, max = 600.0))]
    pub get_up_from_back_s: Option<f32>,
    /// Probability that getting up fails.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub get_up_failure: f32,
    /// Probability that getting up fails because another robot touches this one at the end.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub get_up_failure_in_contact: f32,
}

impl FallModel {
    /// Duration of getting up for a robot that lies on the side `on`, s; `None` if that in the rules applies.
    pub fn get_up_time_s(&self, on: LyingOn) -> Option<f32> {
        match on {
            LyingOn::Front => self.get_up_s,
            LyingOn::Back => self.get_up_from_back_s.or(self.get_up_s),
        }
    }
}

/// The probability of a fall in a collision, by its speed.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CollisionFalls {
    /// Greatest speed at which the robot never falls, m/s.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub from_mps: f32,
    /// Least speed at which it always falls, m/s. In between the probability grows linearly.
    pub certain_mps: f32,
}

impl CollisionFalls {
    /// The probability of a fall in a collision at `speed_mps`.
    pub fn probability(self, speed_mps: f32) -> f32 {
        if speed_mps <= self.from_mps {
            0.0
        } else if speed_mps >= self.certain_mps {
            1.0
        } else {
            (speed_mps - self.from_mps) / (self.certain_mps - self.from_mps)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_probability_of_a_fall_grows_with_the_speed() {
        let falls = CollisionFalls { from_mps: 0.1, certain_mps: 0.5 };
        assert_eq!(falls.probability(0.1), 0.0);
        assert_abs_diff_eq!(falls.probability(0.3), 0.5, epsilon = 1e-6);
        assert_eq!(falls.probability(0.5), 1.0);
        // The same speed for both: a step.
        let step = CollisionFalls { from_mps: 0.2, certain_mps: 0.2 };
        assert_eq!([step.probability(0.2), step.probability(0.21)], [0.0, 1.0]);
    }

    #[test]
    fn getting_up_from_the_back_may_take_its_own_time() {
        let model = FallModel { get_up_s: Some(3.2), ..FallModel::default() };
        assert_eq!([LyingOn::Front, LyingOn::Back].map(|on| model.get_up_time_s(on)), [Some(3.2); 2]);
        let model = FallModel { get_up_from_back_s: Some(12.2), ..model };
        assert_eq!([LyingOn::Front, LyingOn::Back].map(|on| model.get_up_time_s(on)), [Some(3.2), Some(12.2)]);
    }
}
