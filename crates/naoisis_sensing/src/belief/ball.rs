//! The ball estimate: position and velocity in the robot frame, in which the ball is seen and kicked.
//!
//! The estimator is a Kalman filter. An unlikely sighting is ignored once; if the next sighting confirms it, the ball has been kicked or
//! carried, and the filter is reset.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::covariance::inverse;
use super::pose_estimate::StepError;
use super::sighting::{Residual, Sighting};
use naoisis_core::ball::{BallPhysics, Rolling};
use naoisis_core::geometry::{Pose, unit, unrotate};

/// The ball in the robot frame.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct BallEstimate {
    /// The position, m, robot frame.
    pub position: Vec2,
    /// The velocity over the ground, m/s, along the axes of the robot frame.
    pub velocity: Vec2,
    /// Covariance of the position, m².
    pub position_covariance: Mat2,
    /// Covariance of position and velocity, m²/s: symmetric, as all noise except that of the measurement is isotropic.
    cross_covariance: Mat2,
    /// Covariance of the velocity, (m/s)².
    pub velocity_covariance: Mat2,
    /// The time since the ball was last seen, s.
    pub age_s: f32,
    /// The time for which the ball should have been in view but was not seen, s.
    pub missing_s: f32,
    /// The last sighting that was ignored as too unlikely, robot frame.
    doubted: Option<Vec2>,
}

/// The model of the ball's motion.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BallModel {
    /// The ball's radius, m.
    pub radius_m: f32,
    /// The deceleration of a rolling ball.
    pub rolling: Rolling,
    /// Process noise of the velocity while the ball is watched: variance per second, (m/s)²/s.
    pub velocity_noise: f32,
    /// Process noise while the ball is not watched and robots may kick it: one kick of 2 to 3 m/s in some seconds.
    pub unseen_velocity_noise: f32,
    /// The greatest time since the last sighting of a watched ball, s.
    pub watched_s: f32,
    /// Standard deviation of the initial velocity along each axis, m/s.
    pub start_speed_sd: f32,
    /// Standard deviation of the velocity of a ball that has been kicked, m/s.
    pub kicked_speed_sd: f32,
    /// The gate: a sighting further from the expectation than this is ignored at first. Squared Mahalanobis distance.
    pub gate: f32,
    /// The distance within which two ignored sightings confirm each other, m, at a distance of one metre.
    pub confirmation_m: f32,
    /// The speed below which a ball counts as at rest, m/s.
    pub rest_speed_mps: f32,
    /// The distance of the velocity from zero above which a ball counts as rolling: squared Mahalanobis distance.
    pub rolling_gate: f32,
}

impl Default for BallModel {
    fn default() -> Self {
        Self {
            radius_m: BallPhysics::default().radius_m,
            rolling: Rolling::default(),
            velocity_noise: 0.1,
            unseen_velocity_noise: 1.5,
            watched_s: 0.15,
            start_speed_sd: 0.5,
            kicked_speed_sd: 1.7,
            gate: 16.0,
            confirmation_m: 0.15,
            rest_speed_mps: 0.05,
            // With this gate, a ball at rest seems to roll in one of ninety cases.
            rolling_gate: 9.0,
        }
    }
}

impl BallModel {
    /// The share of its velocity that a ball with this `speed` (m/s) keeps after `duration` seconds, to first order.
    fn kept(&self, speed: f32, duration: f32) -> f32 {
        let lost = match self.rolling {
            Rolling::ExponentialPerS(drag) => drag * duration,
            Rolling::ConstantMps2(deceleration) => deceleration * duration / speed.max(self.rest_speed_mps),
        };
        (1.0 - lost).max(0.0)
    }
}

impl BallEstimate {
    /// The estimate after a first sighting.
    pub fn first_seen(sighting: &Sighting, model: &BallModel) -> Self {
        let speed_variance = model.start_speed_sd * model.start_speed_sd;
        Self {
            position: sighting.place,
            velocity: Vec2::ZERO,
            position_covariance: sighting.noise_at(sighting.place),
            cross_covariance: Mat2::ZERO,
            velocity_covariance: Mat2::from_diagonal(Vec2::splat(speed_variance)),
            age_s: 0.0,
            missing_s: 0.0,
            doubted: None,
        }
    }

    /// The estimate after a sighting at a position to which the ball cannot have rolled: it has been kicked.
    fn kicked(sighting: &Sighting, model: &BallModel) -> Self {
        let speed_variance = model.kicked_speed_sd * model.kicked_speed_sd;
        let velocity_covariance = Mat2::from_diagonal(Vec2::splat(speed_variance));
        Self { velocity_covariance, ..Self::first_seen(sighting, model) }
    }

    /// The estimate of a ball at rest at `position`, m, robot frame, with a standard deviation, m.
    pub fn at_rest(position: Vec2, position_sd: f32) -> Self {
        Self {
            position,
            velocity: Vec2::ZERO,
            position_covariance: Mat2::from_diagonal(Vec2::splat(position_sd * position_sd)),
            cross_covariance: Mat2::ZERO,
            velocity_covariance: Mat2::ZERO,
            age_s: 0.0,
            missing_s: 0.0,
            doubted: None,
        }
    }

    /// Predicts the ball `duration` seconds later, in the robot frame after a measured `step` (in the frame before it).
    pub fn advanced(&self, step: Pose, duration: f32, model: &BallModel, walk: &StepError) -> Self {
        let kept = model.kept(self.velocity.length(), duration);
        let is_watched = self.age_s <= model.watched_s;
        let noise = if is_watched { model.velocity_noise } else { model.unseen_velocity_noise } * duration;
        let mut ahead = Self {
            position: self.position + self.velocity * duration - step.position,
            velocity: self.velocity * kept,
            position_covariance: self.position_covariance
                + self.cross_covariance * (2.0 * duration)
                + self.velocity_covariance * (duration * duration),
            cross_covariance: (self.cross_covariance + self.velocity_covariance * duration) * kept,
            velocity_covariance: self.velocity_covariance * (kept * kept) + Mat2::from_diagonal(Vec2::splat(noise)),
            age_s: self.age_s + duration,
            doubted: self.doubted.map(|doubted| doubted - step.position),
            ..*self
        };
        // The errors of the step; that of the turn grows with the distance of the ball.
        let of_walk = walk.covariance(step);
        let across = self.position.perp();
        ahead.position_covariance += Mat2::from_diagonal(Vec2::splat(of_walk.x_axis.x))
            + Mat2::from_cols(across * across.x, across * across.y) * of_walk.z_axis.z;
        if step.heading != 0.0 {
            ahead.turn_frame(step.heading);
        }
        ahead
    }

    fn turn_frame(&mut self, angle: f32) {
        let forward = unit(angle);
        let back = Mat2::from_cols(Vec2::new(forward.x, -forward.y), Vec2::new(forward.y, forward.x));
        let ahead = back.transpose();
        self.position = unrotate(forward, self.position);
        self.velocity = unrotate(forward, self.velocity);
        self.doubted = self.doubted.map(|doubted| unrotate(forward, doubted));
        for covariance in [&mut self.position_covariance, &mut self.cross_covariance, &mut self.velocity_covariance] {
            *covariance = back * *covariance * ahead;
        }
    }

    /// Whether every number in the estimate is finite.
    pub(super) fn is_finite(&self) -> bool {
        let places = [self.position, self.velocity, self.doubted.unwrap_or_default()];
        let covariances = [self.position_covariance, self.cross_covariance, self.velocity_covariance];
        places.into_iter().all(Vec2::is_finite)
            && covariances.iter().all(Mat2::is_finite)
            && (self.age_s + self.missing_s).is_finite()
    }

    /// Corrects the ball by a sighting that is `late_s` seconds old and has been moved on by the velocity since.
    pub fn seen(&self, sighting: &Sighting, model: &BallModel, late_s: f32) -> Self {
        let Residual { difference, noise } = sighting.residual(self.position);
        let noise = noise + self.velocity_covariance * (late_s * late_s);
        let inverse = inverse(self.position_covariance + noise);
        if difference.dot(inverse * difference) > model.gate {
            let near = model.confirmation_m * sighting.place.length_squared().max(1.0);
            return match self.doubted {
                Some(before) if before.distance(sighting.place) < near => Self::kicked(sighting, model),
                _ => Self { doubted: Some(sighting.place), ..*self },
            };
        }
        let gain = self.position_covariance * inverse;
        let velocity_gain = self.cross_covariance * inverse;
        Self {
            position: self.position + gain * difference,
            velocity: self.velocity + velocity_gain * difference,
            position_covariance: symmetric(self.position_covariance - gain * self.position_covariance),
            cross_covariance: symmetric(self.cross_covariance - gain * self.cross_covariance),
            velocity_covariance: symmetric(self.velocity_covariance - velocity_gain * self.cross_covariance),
            age_s: 0.0,
            missing_s: 0.0,
            doubted: None,
        }
    }

    /// The velocity, or zero if it does not differ significantly from rest.
    pub fn credible_velocity(&self, model: &BallModel) -> Vec2 {
        let stands_out = self.velocity.dot(inverse(self.velocity_covariance) * self.velocity) > model.rolling_gate;
        let is_fast = self.velocity.length_squared() > model.rest_speed_mps * model.rest_speed_mps;
        if stands_out && is_fast { self.velocity } else { Vec2::ZERO }
    }
}

/// Removes the asymmetry that rounding causes in a covariance.
fn symmetric(matrix: Mat2) -> Mat2 {
    let mixed = (matrix.x_axis.y + matrix.y_axis.x) / 2.0;
    Mat2::from_cols(Vec2::new(matrix.x_axis.x, mixed), Vec2::new(mixed, matrix.y_axis.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use core::f32::consts::FRAC_PI_2;

    const PERIOD: f32 = 1.0 / 30.0;
    const STEADY: StepError = StepError { place_per_metre: 0.0, heading_per_metre: 0.0, heading_per_radian: 0.0 };

    fn sighting(place: Vec2) -> Sighting {
        Sighting::new(place, 0.004)
    }

    fn watched(start: Vec2, velocity: Vec2, cycles: u32) -> BallEstimate {
        let drag = 0.5;
        let model = BallModel { rolling: Rolling::ExponentialPerS(drag), ..default() };
        let mut estimate = BallEstimate::first_seen(&sighting(start), &model);
        for cycle in 1..=cycles {
            // The closed form of exponential drag: s = v0 (1 - exp(-k t)) / k.
            let time = cycle as f32 * PERIOD;
            let place = start + velocity * (1.0 - (-drag * time).exp()) / drag;
            estimate = estimate.advanced(Pose::default(), PERIOD, &model, &STEADY).seen(&sighting(place), &model, 0.0);
        }
        estimate
    }

    #[test]
    fn the_velocity_of_a_rolling_ball_is_found_within_half_a_second() {
        let estimate = watched(Vec2::new(2.0, 0.5), Vec2::new(-1.0, 0.2), 15);
        // v0 exp(-0.5 * 0.5 s) = 0.78 v0.
        assert_abs_diff_eq!(estimate.velocity, Vec2::new(-0.78, 0.156), epsilon = 0.1);
        assert!(estimate.credible_velocity(&BallModel::default()) != Vec2::ZERO);
        let rest = watched(Vec2::new(2.0, 0.5), Vec2::ZERO, 15);
        assert_eq!(rest.credible_velocity(&BallModel::default()), Vec2::ZERO);
    }

    #[test]
    fn an_unseen_ball_rolls_on_and_gets_uncertain() {
        let model = BallModel::default();
        let mut estimate = watched(Vec2::new(3.0, 0.0), Vec2::new(-1.0, 0.0), 30);
        let (start, speed, variance) =
            (estimate.position.x, estimate.velocity.x, estimate.position_covariance.x_axis.x);
        for _ in 0..30 {
            estimate = estimate.advanced(Pose::default(), PERIOD, &model, &STEADY);
        }
        // v (1 - exp(-k 1 s)) / k = 0.787 v.
        assert_abs_diff_eq!(estimate.position.x - start, 0.787 * speed, epsilon = 0.02);
        assert!(estimate.position_covariance.x_axis.x > 2.0 * variance);
        assert_abs_diff_eq!(estimate.age_s, 1.0, epsilon = 1e-4);
    }

    #[test]
    fn a_turn_of_the_robot_turns_the_ball_the_other_way() {
        let estimate = watched(Vec2::new(1.0, 0.0), Vec2::new(1.0, 0.0), 10);
        let place = estimate.position;
        let turned = estimate.advanced(Pose::new(0.0, 0.0, FRAC_PI_2), 0.0, &BallModel::default(), &STEADY);
        assert_abs_diff_eq!(turned.position, Vec2::new(0.0, -place.x), epsilon = 1e-5);
        assert!(turned.velocity.y < -0.5 && turned.velocity.x.abs() < 1e-3);
        assert_abs_diff_eq!(turned.position_covariance.y_axis.y, estimate.position_covariance.x_axis.x, epsilon = 1e-6);
        let walked = estimate.advanced(Pose::new(0.1, 0.0, 0.0), 0.0, &BallModel::default(), &STEADY);
        assert_abs_diff_eq!(walked.position.x, place.x - 0.1, epsilon = 1e-6);
    }

    #[test]
    fn one_sighting_elsewhere_is_an_error_and_two_are_a_kick() {
        let model = BallModel::default();
        let estimate = watched(Vec2::new(1.0, 0.0), Vec2::ZERO, 30);
        let elsewhere = sighting(Vec2::new(2.0, 1.0));
        let once = estimate.seen(&elsewhere, &model, 0.0);
        assert_eq!(once.position, estimate.position);
        let twice = once.seen(&elsewhere, &model, 0.0);
        assert_eq!(twice.position, elsewhere.place);
        // The doubted sighting is forgotten when the ball is seen again at its old position.
        assert_eq!(once.seen(&sighting(estimate.position), &model, 0.0).doubted, None);
    }
}
