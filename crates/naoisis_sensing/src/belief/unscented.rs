//! The unscented Kalman filter: steps and measurements are applied to six sigma points with the mean and the covariance of the estimate,
//! instead of being linearised at its mean as in the [extended filter](super::pose_estimate).
//!
//! The method is that of Julier, Uhlmann: A new extension of the Kalman filter to nonlinear systems (1997), with n + κ = 3: six points at
//! √3 standard deviations, and none at the mean. It is exact to the third order instead of the first, which matters if the heading is
//! uncertain and landmarks are near; it is about three times as costly.

use bevy::math::{DMat3, DVec3, Mat3};
use bevy::prelude::*;

use super::innovation::Measured;
use super::pose_estimate::{PoseEstimate, StepError};
use super::sighting::Residual;
use naoisis_core::geometry::{Pose, wrap_angle};

/// The number of points: two for each of x, y and heading.
const COUNT: usize = 6;
/// The distance of the points from the mean in standard deviations: √3.
const SPREAD: f32 = 1.732_050_8;
/// The least variance, m² and rad²: a singular matrix has no Cholesky root.
const LEAST_VARIANCE: f32 = 1e-10;

/// The sigma points of an estimate.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct SigmaPoints {
    mean: Pose,
    covariance: Mat3,
    /// The deviation of each point from the mean: x, y and heading.
    deviations: [Vec3; COUNT],
}

impl SigmaPoints {
    /// The sigma points of `estimate`.
    pub(crate) fn of(estimate: &PoseEstimate) -> Self {
        let columns = root(&estimate.covariance).map(|column| SPREAD * column);
        let [x, y, heading] = columns;
        Self { mean: estimate.pose, covariance: estimate.covariance, deviations: [x, -x, y, -y, heading, -heading] }
    }

    /// The poses of the sigma points.
    fn poses(&self) -> [Pose; COUNT] {
        self.deviations.map(|deviation| Pose {
            position: self.mean.position + deviation.truncate(),
            heading: self.mean.heading + deviation.z,
        })
    }

    /// A measurement compared with its expectation. `residual` returns the residual for a robot at a pose.
    pub(super) fn measured(&self, residual: impl Fn(Pose) -> Residual) -> Measured {
        let residuals = self.poses().map(|pose| residual(pose).difference);
        let mean = residuals.iter().sum::<Vec2>() / COUNT as f32;
        let mut spread = residual(self.mean).noise;
        let mut cross = [Vec3::ZERO; 2];
        for (deviation, residual) in self.deviations.iter().zip(residuals) {
            // The expectation has the opposite sign of the residual.
            let expected = mean - residual;
            spread += Mat2::from_cols(expected * expected.x, expected * expected.y) * (1.0 / COUNT as f32);
            cross[0] += *deviation * (expected.x / COUNT as f32);
            cross[1] += *deviation * (expected.y / COUNT as f32);
        }
        // The derivatives H are computed from P Hᵀ.
        let information = self.covariance.inverse();
        let rows = cross.map(|column| if information.is_finite() { information * column } else { Vec3::ZERO });
        Measured { difference: mean, rows, cross, spread, camera_cross: None }
    }
}

/// Predicts the estimate after a measured step (in the robot frame before it).
pub(crate) fn moved_by(estimate: &PoseEstimate, step: Pose, error: &StepError) -> PoseEstimate {
    if step == Pose::default() {
        return *estimate;
    }
    let points = SigmaPoints::of(estimate);
    let centre = estimate.pose.compose(step);
    // Relative to the moved mean, so that headings can be averaged.
    let moved = points.poses().map(|pose| {
        let pose = pose.compose(step);
        (pose.position - centre.position).extend(wrap_angle(pose.heading - centre.heading))
    });
    let mean = moved.iter().sum::<Vec3>() / COUNT as f32;
    let mut covariance = error.covariance(step);
    for deviation in moved.map(|moved| moved - mean) {
        covariance += Mat3::from_cols(deviation * deviation.x, deviation * deviation.y, deviation * deviation.z)
            * (1.0 / COUNT as f32);
    }
    let pose = Pose { position: centre.position + mean.truncate(), heading: wrap_angle(centre.heading + mean.z) };
    PoseEstimate { pose, covariance }.with_bounded_covariance()
}

/// The columns of a square root of a covariance.
fn root(covariance: &Mat3) -> [Vec3; 3] {
    let floor = DMat3::from_diagonal(DVec3::splat(f64::from(LEAST_VARIANCE)));
    match cholesky(&(covariance.as_dmat3() + floor)) {
        Some(lower) => [lower.x_axis, lower.y_axis, lower.z_axis].map(|column| column.as_vec3()),
        // Not positive definite because of rounding: only the variances are reliable.
        None => [0, 1, 2].map(|axis| {
            let variance = covariance.col(axis)[axis].max(LEAST_VARIANCE);
            Vec3::AXES[axis] * variance.sqrt()
        }),
    }
}

/// The Cholesky factor: the lower triangular L with L Lᵀ = A, from the lower triangle of A; `None` if A is not positive definite.
fn cholesky(matrix: &DMat3) -> Option<DMat3> {
    let root = |square: f64| (square > 0.0).then(|| square.sqrt());
    let (first, second, third) = (matrix.x_axis, matrix.y_axis, matrix.z_axis);
    let xx = root(first.x)?;
    let (yx, zx) = (first.y / xx, first.z / xx);
    let yy = root(second.y - yx * yx)?;
    let zy = (second.z - yx * zx) / yy;
    let zz = root(third.z - zx * zx - zy * zy)?;
    Some(DMat3::from_cols(DVec3::new(xx, yx, zx), DVec3::new(0.0, yy, zy), DVec3::new(0.0, 0.0, zz)))
}

#[cfg(test)]
mod tests {
    use super::super::sighting::Sighting;
    use super::*;
    use approx::assert_abs_diff_eq;
    use naoisis_core::geometry::unrotate;

    fn see(estimate: &PoseEstimate, landmark: Vec2, truth: Pose) -> PoseEstimate {
        let sighting = Sighting::new(truth.inverse_transform_point(landmark), 0.005);
        let residual = |pose: Pose| sighting.residual(unrotate(pose.forward(), landmark - pose.position));
        estimate.corrected(&SigmaPoints::of(estimate).measured(residual).innovation())
    }

    #[test]
    fn points_have_the_mean_and_the_covariance_of_the_estimate() {
        let covariance = Mat3::from_cols(
            Vec3::new(0.04, 0.01, 0.002),
            Vec3::new(0.01, 0.09, -0.003),
            Vec3::new(0.002, -0.003, 0.01),
        );
        let points = SigmaPoints::of(&PoseEstimate { pose: Pose::new(1.0, 2.0, 0.5), covariance });
        let mean = points.deviations.iter().sum::<Vec3>() / 6.0;
        assert_abs_diff_eq!(mean, Vec3::ZERO, epsilon = 1e-6);
        for row in 0..3 {
            for column in 0..3 {
                let entry = points.deviations.iter().map(|point| point[row] * point[column]).sum::<f32>() / 6.0;
                assert_abs_diff_eq!(entry, covariance.col(column)[row], epsilon = 1e-5);
            }
        }
    }

    #[test]
    fn a_root_is_lower_triangular_and_its_square_is_the_matrix() {
        // (2 0 0; 6 1 0; -8 5 3) times its transpose.
        let matrix = DMat3::from_cols_array(&[4.0, 12.0, -16.0, 12.0, 37.0, -43.0, -16.0, -43.0, 98.0]);
        let lower = DMat3::from_cols_array(&[2.0, 6.0, -8.0, 0.0, 1.0, 5.0, 0.0, 0.0, 3.0]);
        assert_eq!(cholesky(&matrix), Some(lower));
        for indefinite in [DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, -1e-9, 1.0), DVec3::new(1.0, 1.0, f64::NAN)] {
            assert_eq!(cholesky(&DMat3::from_diagonal(indefinite)), None);
        }
    }

    #[test]
    fn an_uncertain_heading_shortens_the_way() {
        // The mean of cos θ for a normal θ with deviation σ is exp(-σ²/2): after 2 m with σ = 0.4, 1.846 m, and the variance
        // across is 4 (1 - exp(-2σ²)) / 2 = 0.548 m². Slopes would say 2 m and 4 σ² = 0.64 m².
        let error = StepError { place_per_metre: 0.0, heading_per_metre: 0.0, heading_per_radian: 0.0 };
        let moved = moved_by(&PoseEstimate::new(Pose::default(), 0.0, 0.4), Pose::new(2.0, 0.0, 0.0), &error);
        assert_abs_diff_eq!(moved.pose.position, Vec2::new(1.846, 0.0), epsilon = 2e-3);
        assert_abs_diff_eq!(moved.covariance.y_axis.y, 0.548, epsilon = 2e-2);
    }

    #[test]
    fn it_agrees_with_the_extended_filter_where_all_is_nearly_linear() {
        let estimate = PoseEstimate::new(Pose::new(0.4, -0.2, 0.3), 0.02, 0.01);
        let (step, error) = (Pose::new(0.02, 0.005, 0.03), StepError::default());
        let (extended, unscented) = (estimate.moved_by(step, &error), moved_by(&estimate, step, &error));
        assert_abs_diff_eq!(unscented.pose.position, extended.pose.position, epsilon = 1e-4);
        assert_abs_diff_eq!(unscented.covariance, extended.covariance, epsilon = 1e-5);
        let (landmark, truth) = (Vec2::new(3.0, 0.7), Pose::new(0.42, -0.19, 0.305));
        let sighting = Sighting::new(truth.inverse_transform_point(landmark), 0.005);
        let by_slopes = estimate.corrected(&estimate.innovation(estimate.pose.forward(), landmark, &sighting));
        let by_points = see(&estimate, landmark, truth);
        assert_abs_diff_eq!(by_points.pose.position, by_slopes.pose.position, epsilon = 1e-3);
        assert_abs_diff_eq!(by_points.covariance, by_slopes.covariance, epsilon = 2e-5);
    }

    #[test]
    fn two_landmarks_seen_again_and_again_correct_the_pose() {
        let truth = Pose::new(0.7, -0.4, 0.3);
        let mut estimate = PoseEstimate::new(Pose::new(0.4, 0.0, 0.1), 0.5, 0.3);
        for _ in 0..20 {
            for post in [Vec2::new(3.0, 0.7), Vec2::new(3.0, -0.7)] {
                estimate = see(&estimate, post, truth);
            }
        }
        assert_abs_diff_eq!(estimate.pose.position, truth.position, epsilon = 0.05);
        assert_abs_diff_eq!(estimate.pose.heading, truth.heading, epsilon = 0.02);
    }

    #[test]
    fn a_covariance_without_rank_is_no_trouble() {
        for covariance in [Mat3::ZERO, Mat3::from_diagonal(Vec3::new(-1e-9, 1e-3, 0.0))] {
            let estimate = PoseEstimate { pose: Pose::new(0.1, 0.2, 3.1), covariance };
            let seen = see(&estimate, Vec2::new(3.0, 0.7), estimate.pose);
            assert_abs_diff_eq!(seen.pose.position, estimate.pose.position, epsilon = 1e-3);
            assert!(seen.covariance.is_finite());
        }
    }
}
