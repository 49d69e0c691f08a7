//! Covariances in single precision.
//!
//! What is seen from far away is known well across the line of sight and hardly along it: from some hundred metres on,
//! rounding takes the difference, and with it the rank of the matrix.

use bevy::prelude::*;

/// The least determinant, as a share of the square of the trace, that rounding leaves something of.
const LEAST_DETERMINANT: f32 = 1e-6;
/// Variances are at least this, m²: nothing is known more exactly.
const LEAST_VARIANCE: f32 = 1e-10;

/// The inverse of a covariance, finite whatever that is. Of one that rounding has made all but flat, the narrow direction
/// is taken to be as wide as rounding can tell.
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
    // By rounding it is no covariance at all: what is certain of it are the variances.
    let variances = Vec2::new(covariance.x_axis.x, covariance.y_axis.y);
    Mat2::from_diagonal(variances.max(Vec2::splat(LEAST_VARIANCE)).recip())
}

#[cfg(test)]
mod tests {
    use super::super::sighting::Sighting;
    use super::*;
    use crate::geometry::unit;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    #[test]
    fn what_has_a_rank_is_inverted_as_it_is() {
        let covariance = Mat2::from_cols(Vec2::new(0.04, 0.01), Vec2::new(0.01, 0.09));
        assert_eq!(inverse(covariance), covariance.inverse());
    }

    #[test]
    fn a_flat_one_tells_nothing_along_and_much_across() {
        // Along (1, 1) with variance 2, across nothing: information there, and none along.
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
            // To err along the line of sight is likelier than to err across it.
            let [along, across] = [unit(angle), unit(angle).perp()].map(|axis| axis.dot(information * axis));
            prop_assert!(distance < 1.0 || across > along, "{across} {along}");
            let [xx, xy, yy] = entries;
            prop_assume!(entries.iter().all(|entry| entry.abs() < 1e9));
            prop_assert!(inverse(Mat2::from_cols(Vec2::new(xx, xy), Vec2::new(xy, yy))).is_finite());
        }
    }
}
