//! Sightings: positions on the ground measured by a camera, and their errors.
//!
//! A camera measures two angles with about the same error σ. The position of an object at distance d, seen from height h, has an error of d
//! σ across the line of sight, and of (d² + h²) / h σ along it: at 4 m from 0.5 m, eight times as much. The error along the line of sight
//! is not symmetric: measured distances may be much too great, but only a little too small. So errors are linearised at the *expected*
//! position; linearised at the measured position, near measurements would have too much weight.

use bevy::prelude::*;

/// The height of a NAO's lenses, between those of its two cameras (paper, Table 1a), m.
pub const LENS_HEIGHT_M: f32 = 0.5;
/// The least expected distance, m.
const LEAST_DISTANCE_M: f32 = 0.05;

/// The sighting of an object on the ground.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sighting {
    /// The measured position, m, robot frame.
    pub place: Vec2,
    /// Standard deviation of the measured angles, radians.
    pub angle_sd: f32,
    /// The factor on the error of the distance; 1 if the distance was measured by the foot.
    pub distance_factor: f32,
    /// The height of the lens, m.
    pub lens_height_m: f32,
}

/// The difference of a sighting from its expectation.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Residual {
    /// Measured minus expected position, m, robot frame; along the line of sight, in proportion to the difference of the angles.
    pub difference: Vec2,
    /// Covariance of the measurement, m², robot frame.
    pub noise: Mat2,
}

impl Sighting {
    /// The sighting of an object whose foot was seen at `place` from the height of a NAO's lenses.
    pub fn new(place: Vec2, angle_sd: f32) -> Self {
        Self { place, angle_sd, distance_factor: 1.0, lens_height_m: LENS_HEIGHT_M }
    }

    /// The sighting from another height, m.
    #[must_use]
    pub fn from_height(self, lens_height_m: f32) -> Self {
        Self { lens_height_m, ..self }
    }

    /// The residual of the sighting of an object at `expected`, m, robot frame.
    pub fn residual(&self, expected: Vec2) -> Residual {
        let distance = expected.length().max(LEAST_DISTANCE_M);
        let direction = expected / distance;
        let measured = self.place.length().max(LEAST_DISTANCE_M);
        let height_squared = self.lens_height_m * self.lens_height_m;
        // For small differences, that of the angles atan(h / d) is h (d' - d) / (d d' + h²); it is multiplied by (d² + h²) / h.
        let along =
            (measured - distance) * (distance * distance + height_squared) / (distance * measured + height_squared);
        let across = direction.perp_dot(self.place) * distance / measured;
        Residual { difference: direction * along + direction.perp() * across, noise: self.noise_at(expected) }
    }

    /// The covariance of the measurement of an object at `expected`, m², robot frame.
    pub fn noise_at(&self, expected: Vec2) -> Mat2 {
        let distance = expected.length().max(LEAST_DISTANCE_M);
        let direction = expected / distance;
        let across_sd = distance * self.angle_sd;
        let along_sd = (distance * distance + self.lens_height_m * self.lens_height_m) / self.lens_height_m
            * self.angle_sd
            * self.distance_factor;
        let across = across_sd * across_sd;
        let difference = along_sd * along_sd - across;
        let mixed = difference * direction.x * direction.y;
        Mat2::from_cols(
            Vec2::new(across + difference * direction.x * direction.x, mixed),
            Vec2::new(mixed, across + difference * direction.y * direction.y),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn errors_along_the_line_of_sight_grow_with_the_square_of_the_distance() {
        // 0.01 rad at 2 m: 2 cm across and (4 + 0.25) / 0.5 * 0.01 = 8.5 cm along.
        let noise = Sighting::new(Vec2::new(0.0, 2.1), 0.01).noise_at(Vec2::new(0.0, 2.0));
        assert_abs_diff_eq!(noise.y_axis.y.sqrt(), 0.085, epsilon = 1e-6);
        assert_abs_diff_eq!(noise.x_axis.x.sqrt(), 0.02, epsilon = 1e-6);
        assert_abs_diff_eq!(noise.x_axis.y, 0.0, epsilon = 1e-6);
    }

    #[test]
    fn equal_errors_of_the_angle_are_equal_residuals_whether_near_or_far() {
        let expected = Vec2::new(4.0, 0.0);
        let depression = (LENS_HEIGHT_M / 4.0).atan();
        let seen_at = |error: f32| Vec2::new(LENS_HEIGHT_M / (depression + error).tan(), 0.0);
        let residual = |error: f32| Sighting::new(seen_at(error), 0.01).residual(expected).difference.x;
        // 0.02 rad: seen at 3.44 m or at 4.78 m, 0.56 m or 0.78 m off; as residuals 0.02 * (16 + 0.25) / 0.5 = 0.65 m.
        assert_abs_diff_eq!(residual(0.02), -0.65, epsilon = 0.01);
        assert_abs_diff_eq!(residual(-0.02), 0.65, epsilon = 0.01);
    }

    #[test]
    fn a_place_beside_the_expectation_is_that_far_across() {
        let residual = Sighting::new(Vec2::new(3.0, 0.3), 0.01).residual(Vec2::new(3.0, 0.0));
        // At the same distance within half a percent.
        assert_abs_diff_eq!(residual.difference, Vec2::new(0.015, 0.3), epsilon = 0.005);
    }
}
