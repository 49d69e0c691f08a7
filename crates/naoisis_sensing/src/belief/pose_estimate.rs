//! The estimate of the robot's own pose: predicted from odometry, corrected by landmarks.
//!
//! The estimator is an extended Kalman filter over (x, y, heading). Its measurements are the positions of known landmarks in the robot
//! frame, and lines.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::innovation::{Innovation, Measured};
use super::line_sighting::{PitchLine, SeenLine};
use super::sighting::{Residual, Sighting};
use crate::sensing::odometry::OdometryNoise;
use naoisis_core::geometry::{Pose, angle_of, unit, unrotate, wrap_angle};
use naoisis_core::robot::motion_settings::{Gait, Slip};

/// The greatest standard deviations of position, m, and heading, radians. They represent no knowledge at all; greater ones would overflow
/// in the long run.
const LARGEST_SD: [f32; 2] = [1000.0, core::f32::consts::PI];

/// The distance within which landmarks correct a pose, m. A systematic error is treated as a random one that is redrawn after this
/// distance.
const REMEMBERED_M: f32 = 2.0;

/// A pose and its covariance.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub(crate) struct PoseEstimate {
    /// The pose, team frame.
    pub pose: Pose,
    /// Covariance of (x, y, heading), m and radians.
    pub covariance: Mat3,
}

/// The growth of the uncertainty of a pose by walking.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StepError {
    /// Variance of the position per metre walked, m.
    pub place_per_metre: f32,
    /// Variance of the heading per metre walked, rad²/m.
    pub heading_per_metre: f32,
    /// Variance of the heading per radian turned, rad.
    pub heading_per_radian: f32,
}

impl Default for StepError {
    /// Much more than the simulated odometry's default (5 cm and 2° after 1 m, 3° after 1 rad), because a robot that pushes another is not
    /// moved by its steps.
    fn default() -> Self {
        Self { place_per_metre: 0.02, heading_per_metre: 0.005, heading_per_radian: 0.011 }
    }
}

impl StepError {
    /// The error that follows from the robot's gait and odometry noise, but at least `self`, which includes pushes.
    #[must_use]
    pub(crate) fn with_known(self, gait: Option<&Gait>, odometry: &OdometryNoise) -> Self {
        let slip = gait.map_or_else(Slip::default, |gait| gait.slip);
        let square = |value: f32| value * value;
        // Systematic errors grow with the distance, up to that within which landmarks correct them.
        let place = square(odometry.translation_sd_m)
            + square(slip.error.translation_sd_m)
            + square(slip.scale_sd) * REMEMBERED_M;
        let heading = square(odometry.heading_per_metre_sd)
            + square(slip.error.heading_per_metre_sd)
            + square(slip.drift_sd) * REMEMBERED_M;
        let turn = square(odometry.rotation_sd) + square(slip.error.rotation_sd);
        Self {
            place_per_metre: self.place_per_metre.max(place),
            heading_per_metre: self.heading_per_metre.max(heading),
            heading_per_radian: self.heading_per_radian.max(turn),
        }
    }

    /// The covariance of (x, y, heading) that a step adds, m and radians.
    pub(super) fn covariance(&self, step: Pose) -> Mat3 {
        let length = step.position.length();
        let place = self.place_per_metre * length;
        let heading = self.heading_per_metre * length + self.heading_per_radian * step.heading.abs();
        Mat3::from_diagonal(Vec3::new(place, place, heading))
    }
}

impl PoseEstimate {
    /// A pose with independent errors with these standard deviations, m and radians.
    pub(crate) fn new(pose: Pose, place_sd: f32, heading_sd: f32) -> Self {
        let place = place_sd * place_sd;
        Self { pose, covariance: Mat3::from_diagonal(Vec3::new(place, place, heading_sd * heading_sd)) }
    }

    /// Rotates the pose and its covariance by half a turn about the centre mark.
    #[must_use]
    pub(crate) fn turned_half(&self) -> Self {
        let turn = Mat3::from_diagonal(Vec3::new(-1.0, -1.0, 1.0));
        Self { pose: self.pose.turned_half(), covariance: turn * self.covariance * turn }
    }

    /// Predicts the estimate after a measured step (in the robot frame before it).
    pub(crate) fn moved_by(&self, step: Pose, error: &StepError) -> Self {
        if step == Pose::default() {
            return *self;
        }
        let forward = self.pose.forward();
        let way = forward.rotate(step.position);
        // x' = x + way(heading), so that F = I + [0 0 -way.y; 0 0 way.x; 0 0 0].
        let [mut x, mut y, mut heading] = [self.covariance.x_axis, self.covariance.y_axis, self.covariance.z_axis];
        let turned = Vec3::new(-way.y, way.x, 0.0);
        for column in [&mut x, &mut y, &mut heading] {
            *column += turned * column.z;
        }
        x += heading * turned.x;
        y += heading * turned.y;
        let moved = Self {
            pose: Pose { position: self.pose.position + way, heading: wrap_angle(self.pose.heading + step.heading) },
            covariance: Mat3::from_cols(x, y, heading) + error.covariance(step),
        };
        moved.with_bounded_covariance()
    }

    /// Limits the uncertainty; correlations do not change.
    #[must_use]
    pub(super) fn with_bounded_covariance(self) -> Self {
        let variances = self.covariance.diagonal();
        let most = Vec3::new(LARGEST_SD[0], LARGEST_SD[0], LARGEST_SD[1]);
        let scale = (most / variances.map(f32::sqrt)).min(Vec3::ONE);
        if variances.cmple(most * most).all() {
            return self;
        }
        let scale = Mat3::from_diagonal(scale);
        Self { covariance: scale * self.covariance * scale, ..self }
    }

    /// Whether every number in the estimate is finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.pose.is_finite() && self.covariance.is_finite()
    }

    /// The innovation of a sighting of `landmark` (m, team frame).
    pub(crate) fn innovation(&self, forward: Vec2, landmark: Vec2, sighting: &Sighting) -> Innovation {
        self.measured_point(forward, landmark, sighting).innovation()
    }

    /// A sighting of `landmark` (m, team frame), compared with its expectation.
    #[inline(always)]
    pub(super) fn measured_point(&self, forward: Vec2, landmark: Vec2, sighting: &Sighting) -> Measured {
        let expected = unrotate(forward, landmark - self.pose.position);
        // h(p) = R(-heading) (landmark - position), with these derivatives as rows:
        let rows = [Vec3::new(-forward.x, -forward.y, expected.y), Vec3::new(forward.y, -forward.x, -expected.x)];
        self.measured(sighting.residual(expected), rows)
    }

    /// A seen segment of `line` (m, team frame), compared with its expectation.
    #[inline(always)]
    pub(super) fn measured_line(&self, forward: Vec2, line: &PitchLine, seen: &SeenLine) -> Measured {
        self.measured(seen.residual(line, self.pose.position, forward), seen.slopes(line, forward))
    }

    /// A measurement with this residual, given the derivatives of its expectation with respect to the pose.
    #[inline(always)]
    fn measured(&self, residual: Residual, rows: [Vec3; 2]) -> Measured {
        let Residual { difference, noise } = residual;
        // Written without `map`, as mapped arrays are slow.
        let cross = [self.covariance * rows[0], self.covariance * rows[1]];
        let spread = noise
            + Mat2::from_cols(
                Vec2::new(rows[0].dot(cross[0]), rows[1].dot(cross[0])),
                Vec2::new(rows[0].dot(cross[1]), rows[1].dot(cross[1])),
            );
        Measured { difference, rows, cross, spread, camera_cross: None }
    }

    /// Corrects the estimate by an innovation.
    pub(crate) fn corrected(&self, innovation: &Innovation) -> Self {
        let Innovation { difference, gain, cross, .. } = innovation;
        let change = gain[0] * difference.x + gain[1] * difference.y;
        // P - K (P Hᵀ)ᵀ, column by column.
        let column = |index: usize| self.covariance.col(index) - gain[0] * cross[0][index] - gain[1] * cross[1][index];
        let (x, y, heading) = (column(0), column(1), column(2));
        // Removes the asymmetry of rounding.
        let covariance = Mat3::from_cols(x, Vec3::new(x.y, y.y, y.z), Vec3::new(x.z, y.z, heading.z));
        Self {
            pose: Pose {
                position: self.pose.position + change.truncate(),
                heading: wrap_angle(self.pose.heading + change.z),
            },
            covariance,
        }
    }

    /// The covariance that the uncertainty of the pose adds to the position of an object at `offset` (m, along the axes of the team frame)
    /// from the robot, m².
    pub(crate) fn covariance_at(&self, offset: Vec2) -> Mat2 {
        // p' = p + R(heading) place, so that J = [1 0 -offset.y; 0 1 offset.x], and the covariance is J P Jᵀ.
        let rows = [Vec3::new(1.0, 0.0, -offset.y), Vec3::new(0.0, 1.0, offset.x)];
        let (x, y) = (self.covariance * rows[0], self.covariance * rows[1]);
        let mixed = rows[0].dot(y);
        Mat2::from_cols(Vec2::new(rows[0].dot(x), mixed), Vec2::new(mixed, rows[1].dot(y)))
    }

    /// Adds independent errors with these standard deviations, m and radians.
    pub(crate) fn inflated(&self, place_sd: f32, heading_sd: f32) -> Self {
        let added = PoseEstimate::new(self.pose, place_sd, heading_sd).covariance;
        Self { pose: self.pose, covariance: self.covariance + added }
    }
}

/// The pose from which two landmarks (m, team frame) are seen at the positions `seen` (m, robot frame).
pub(crate) fn pose_from_two(landmarks: [Vec2; 2], seen: [Vec2; 2]) -> Pose {
    let heading = wrap_angle(angle_of(landmarks[1] - landmarks[0]) - angle_of(seen[1] - seen[0]));
    let forward = unit(heading);
    let middle = (landmarks[0] + landmarks[1]) / 2.0;
    Pose { position: middle - forward.rotate((seen[0] + seen[1]) / 2.0), heading }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use core::f32::consts::FRAC_PI_2;

    fn sighting_from(pose: Pose, landmark: Vec2) -> Sighting {
        Sighting::new(pose.inverse_transform_point(landmark), 0.005)
    }

    fn see(estimate: PoseEstimate, landmark: Vec2, sighting: &Sighting) -> PoseEstimate {
        let forward = estimate.pose.forward();
        estimate.corrected(&estimate.innovation(forward, landmark, sighting))
    }

    #[test]
    fn steps_add_up_as_poses_do() {
        let start = PoseEstimate::new(Pose::new(1.0, 2.0, FRAC_PI_2), 0.1, 0.1);
        let moved = start.moved_by(Pose::new(0.5, 0.1, 0.2), &StepError::default());
        assert_abs_diff_eq!(moved.pose.position, Vec2::new(0.9, 2.5), epsilon = 1e-6);
        assert_abs_diff_eq!(moved.pose.heading, FRAC_PI_2 + 0.2, epsilon = 1e-6);
    }

    #[test]
    fn an_uncertain_heading_makes_the_place_uncertain_across_the_way() {
        // After 2 m along x with a heading error of 0.1 rad: y varies by (2 m * 0.1)² more, and yθ by 2 m * 0.1².
        let error = StepError { place_per_metre: 0.0, heading_per_metre: 0.0, heading_per_radian: 0.0 };
        let moved = PoseEstimate::new(Pose::default(), 0.0, 0.1).moved_by(Pose::new(2.0, 0.0, 0.0), &error);
        let [xx, xy, yy, xt, yt, tt] = crate::belief::pose_covariance(moved.covariance);
        assert_abs_diff_eq!(Vec3::new(xx, xy, xt), Vec3::ZERO, epsilon = 1e-7);
        assert_abs_diff_eq!(Vec3::new(yy, yt, tt), Vec3::new(0.04, 0.02, 0.01), epsilon = 1e-6);
    }

    #[test]
    fn two_landmarks_seen_again_and_again_correct_the_pose() {
        let truth = Pose::new(0.7, -0.4, 0.3);
        let posts = [Vec2::new(3.0, 0.7), Vec2::new(3.0, -0.7)];
        let mut estimate = PoseEstimate::new(Pose::new(0.4, 0.0, 0.1), 0.5, 0.3);
        for _ in 0..20 {
            for post in posts {
                estimate = see(estimate, post, &sighting_from(truth, post));
            }
        }
        assert_abs_diff_eq!(estimate.pose.position, truth.position, epsilon = 0.05);
        assert_abs_diff_eq!(estimate.pose.heading, truth.heading, epsilon = 0.02);
        let covariance = crate::belief::pose_covariance(estimate.covariance);
        assert!(covariance[0] < 0.01 && covariance[2] < 0.01 && covariance[5] < 0.001, "{covariance:?}");
    }

    #[test]
    fn what_is_far_away_is_where_the_heading_says() {
        // 3 m ahead, along x, a heading error of 0.1 rad is 0.3 m across; the position's own 0.2 m are added.
        let covariance = PoseEstimate::new(Pose::new(1.0, 2.0, 0.4), 0.2, 0.1).covariance_at(Vec2::new(3.0, 0.0));
        assert_abs_diff_eq!(covariance, Mat2::from_diagonal(Vec2::new(0.04, 0.04 + 0.09)), epsilon = 1e-6);
        // An error along x that is correlated with the heading: at (0, 1) they cancel each other.
        let together = Mat3::from_cols(Vec3::new(0.01, 0.0, 0.01), Vec3::ZERO, Vec3::new(0.01, 0.0, 0.01));
        let estimate = PoseEstimate { pose: Pose::default(), covariance: together };
        assert_abs_diff_eq!(estimate.covariance_at(Vec2::Y), Mat2::ZERO, epsilon = 1e-6);
    }

    #[test]
    fn a_correction_weighs_both_variances() {
        // A landmark straight ahead at 2 m, the heading known, and an error of the angle for which the measurement's deviation along the
        // line of sight, (4 + 0.25) / 0.5 σ, is 0.1 m. As the estimate's variance is 0.04, 0.04 / (0.04 + 0.01) = 80 % of the difference
        // are applied, and a variance of 0.04 * 0.01 / (0.04 + 0.01) remains.
        let estimate = PoseEstimate::new(Pose::default(), 0.2, 0.0);
        let sighting = Sighting::new(Vec2::new(1.99, 0.0), 0.1 * 0.5 / 4.25);
        let corrected = see(estimate, Vec2::new(2.0, 0.0), &sighting);
        assert_abs_diff_eq!(corrected.pose.position.x, 0.008, epsilon = 1e-4);
        assert_abs_diff_eq!(corrected.covariance.x_axis.x, 0.008, epsilon = 1e-5);
    }

    #[test]
    fn the_distance_tells_likely_from_unlikely() {
        let estimate = PoseEstimate::new(Pose::default(), 0.1, 0.05);
        let forward = estimate.pose.forward();
        let sighting = sighting_from(Pose::new(0.1, 0.0, 0.0), Vec2::new(2.0, 0.7));
        let distance = |landmark| estimate.innovation(forward, landmark, &sighting).distance_squared;
        assert!(distance(Vec2::new(2.0, 0.7)) < 2.0);
        assert!(distance(Vec2::new(2.0, -0.7)) > 20.0);
    }

    #[test]
    fn two_posts_tell_the_whole_pose() {
        let truth = Pose::new(1.0, -0.5, 2.5);
        let posts = [Vec2::new(-3.0, 0.7), Vec2::new(-3.0, -0.7)];
        let pose = pose_from_two(posts, posts.map(|post| truth.inverse_transform_point(post)));
        assert_abs_diff_eq!(pose.position, truth.position, epsilon = 1e-5);
        assert_abs_diff_eq!(pose.heading, truth.heading, epsilon = 1e-5);
    }
}
