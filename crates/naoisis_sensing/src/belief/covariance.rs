//! Covariances in single precision: confidence ellipses, and a robust inverse.
//!
//! A position seen from far away is known well across the line of sight and hardly along it: from some hundred metres on, the matrix loses
//! its rank by rounding.

use bevy::math::ops;
use bevy::prelude::*;

use super::PlaceCovariance;
use naoisis_core::geometry::unit;

/// The squared Mahalanobis distance of a pose at the edge of the ellipsoid of 95 %: χ² with three degrees of freedom.
pub const ELLIPSOID_95: f32 = 7.815;
/// The squared Mahalanobis distance of a position at the edge of the ellipse of 95 %: χ² with two degrees of freedom, -2 ln 0.05.
pub const ELLIPSE_95: f32 = 5.991;

/// The half axes of the 95 % ellipse of a position, m, the longer one first; `None` if the matrix is not a covariance.
pub fn half_axes_95([xx, xy, yy]: PlaceCovariance) -> Option<[Vec2; 2]> {
    let mean = (xx + yy) / 2.0;
    let difference = (xx - yy) / 2.0;
    let radius = Vec2::new(difference, xy).length();
    let variances = [mean + radius, mean - radius];
    if !variances.iter().all(|variance| variance.is_finite()) || variances[0] <= 0.0 {
        return None;
    }
    // The direction of the longer axis is at half the angle of (xx - yy, 2 xy).
    let direction = unit(ops::atan2(xy, difference) / 2.0);
    // Rounding may make the smaller variance negative.
    let [long, short] = variances.map(|variance| (ELLIPSE_95 * variance.max(0.0)).sqrt());
    Some([direction * long, direction.perp() * short])
}

/// The least determinant that is significant despite rounding, as a share of the square of the trace.
const LEAST_DETERMINANT: f32 = 1e-6;
/// The least variance, m².
const LEAST_VARIANCE: f32 = 1e-10;

/// The inverse of a covariance, always finite. The narrow direction of a nearly singular matrix is widened to the limit of rounding.
pub(super) fn inverse(covariance: Mat2) -> Mat2 {
    let trace = covariance.x_axis.x + covariance.y_axis.y;
    let least = (LEAST_DETERMINANT * trace * trace).max(LEAST_VARIANCE * LEAST_VARIANCE);
    let has_rank = |matrix: &Mat2| matrix.determinant() > least;
    if has_rank(&covariance) {
        return covariance.inverse();
    }
    let widened = covariance + Mat2::from_diagonal(Vec2::splat(4.0 * LEAST_DETERMINANT * trace));
    if has_rank(&widened) {
        return widened.inverse();
    }
    // Rounding has made the matrix indefinite: only the variances are reliable.
    let variances = Vec2::new(covariance.x_axis.x, covariance.y_axis.y);
    Mat2::from_diagonal(variances.max(Vec2::splat(LEAST_VARIANCE)).recip())
}

#[cfg(test)]
mod tests {
    use super::super::sighting::Sighting;
    use super::*;
    use approx::assert_abs_diff_eq;
    use core::f32::consts::FRAC_PI_6;
    use naoisis_core::geometry::unit;
    use proptest::prelude::*;

    #[test]
    fn an_ellipse_has_the_axes_that_were_turned_into_the_covariance() {
        // R diag(0.09, 0.01) Rᵀ with R a turn by 30°.
        let (sin, cos) = ops::sin_cos(FRAC_PI_6);
        let covariance =
            [0.09 * cos * cos + 0.01 * sin * sin, (0.09 - 0.01) * sin * cos, 0.09 * sin * sin + 0.01 * cos * cos];
        let [long, short] = half_axes_95(covariance).unwrap().map(|axis| axis / ELLIPSE_95.sqrt());
        assert_abs_diff_eq!(long, 0.3 * unit(FRAC_PI_6), epsilon = 1e-4);
        assert_abs_diff_eq!(short, 0.1 * unit(FRAC_PI_6).perp(), epsilon = 1e-4);
        assert_abs_diff_eq!(half_axes_95([0.01, 0.0, 0.04]).unwrap()[0].x, 0.0, epsilon = 1e-6);
        assert_eq!(half_axes_95([0.0, 0.0, 0.0]), None);
        assert_eq!(half_axes_95([f32::NAN, 0.0, 1.0]), None);
    }

    #[test]
    fn the_ellipse_holds_19_of_20() {
        // The chance to be within k standard deviations in both of two dimensions is 1 - exp(-k² / 2).
        assert_abs_diff_eq!(1.0 - ops::exp(-ELLIPSE_95 / 2.0), 0.95, epsilon = 1e-4);
    }

    #[test]
    fn what_has_a_rank_is_inverted_as_it_is() {
        let covariance = Mat2::from_cols(Vec2::new(0.04, 0.01), Vec2::new(0.01, 0.09));
        assert_eq!(inverse(covariance), covariance.inverse());
    }

    #[test]
    fn a_flat_one_tells_nothing_along_and_much_across() {
        // Along (1, 1) with variance 2, and zero across: all information is across, none along.
        let information = inverse(Mat2::from_cols(Vec2::ONE, Vec2::ONE));
        let [along, across] = [Vec2::ONE, Vec2::new(1.0, -1.0)].map(Vec2::normalize);
        assert_abs_diff_eq!(along.dot(information * along), 0.5, epsilon = 0.1);
        assert!(across.dot(information * across) > 1e4);
    }

    proptest! {
        #[test]
        fn whatever_is_seen_from_however_far_away_is_worth_something_finite(
            distance in 0.0f32..2000.0, angle in -3.2f32..3.2, angle_sd in 0.001f32..0.1, entries: [f32; 3],
        ) {
            let covariance = Sighting::new(Vec2::ZERO, angle_sd).noise_at(unit(angle) * distance);
            let information = inverse(covariance);
            prop_assert!(information.is_finite());
            // Errors along the line of sight are likelier than errors across it.
            let [along, across] = [unit(angle), unit(angle).perp()].map(|axis| axis.dot(information * axis));
            prop_assert!(distance < 1.0 || across > along, "{across} {along}");
            let [xx, xy, yy] = entries;
            prop_assume!(entries.iter().all(|entry| entry.abs() < 1e9));
            prop_assert!(inverse(Mat2::from_cols(Vec2::new(xx, xy), Vec2::new(xy, yy))).is_finite());
        }
    }
}
