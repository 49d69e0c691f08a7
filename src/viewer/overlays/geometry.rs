//! Shapes on the ground, as pure functions.

use bevy::math::ops;
use bevy::prelude::*;

use crate::belief::PlaceCovariance;
use crate::geometry::unit;

/// Within so many standard deviations lies a place with a probability of 95 %: the root of χ² with two degrees of
/// freedom.
pub const SIGMAS_95: f32 = 2.447_7;

/// The half axes of the ellipse of one standard deviation, the greater first, m, and the direction of the greater, radians.
/// None of what is no covariance.
pub fn ellipse([xx, xy, yy]: PlaceCovariance) -> Option<([f32; 2], f32)> {
    let middle = (xx + yy) / 2.0;
    let half_difference = (xx - yy) / 2.0;
    let offset = (half_difference * half_difference + xy * xy).sqrt();
    let variances = [middle + offset, middle - offset];
    if !variances.iter().all(|variance| variance.is_finite()) || variances[0] <= 0.0 {
        return None;
    }
    let direction = 0.5 * ops::atan2(xy, half_difference);
    // Rounding may leave a line's breadth below nothing.
    Some((variances.map(|variance| variance.max(0.0).sqrt()), direction))
}

/// Points of an arc about a centre, from an angle to another, radians.
pub fn arc(centre: Vec2, radius: f32, [from, to]: [f32; 2]) -> impl Iterator<Item = Vec2> {
    /// Of a whole circle.
    const CORNERS: f32 = 64.0;
    let count = (CORNERS * (to - from).abs() / core::f32::consts::TAU).ceil().max(1.0) as u32;
    (0..=count).map(move |index| centre + radius * unit(from + (to - from) * index as f32 / count as f32))
}

/// The outline of the part of a ring between two angles, radians.
pub fn sector(centre: Vec2, [inner, outer]: [f32; 2], [from, to]: [f32; 2]) -> Vec<Vec2> {
    arc(centre, inner, [from, to]).chain(arc(centre, outer, [to, from])).collect()
}

/// The corners of a rectangle.
pub fn corners(rectangle: Rect) -> [Vec2; 4] {
    let Rect { min, max } = rectangle;
    [min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use core::f32::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_6, PI};

    #[test]
    fn an_ellipse_has_the_axes_that_were_turned_into_the_covariance() {
        // R diag(0.09, 0.01) Rᵀ with R a turn by 30°.
        let (sin, cos) = ops::sin_cos(FRAC_PI_6);
        let covariance =
            [0.09 * cos * cos + 0.01 * sin * sin, (0.09 - 0.01) * sin * cos, 0.09 * sin * sin + 0.01 * cos * cos];
        let (axes, direction) = ellipse(covariance).unwrap();
        assert_abs_diff_eq!(axes[0], 0.3, epsilon = 1e-4);
        assert_abs_diff_eq!(axes[1], 0.1, epsilon = 1e-4);
        assert_abs_diff_eq!(direction, FRAC_PI_6, epsilon = 1e-4);
        assert_abs_diff_eq!(ellipse([0.01, 0.0, 0.04]).unwrap().1.abs(), FRAC_PI_2, epsilon = 1e-6);
        assert_eq!(ellipse([0.0, 0.0, 0.0]), None);
        assert_eq!(ellipse([f32::NAN, 0.0, 1.0]), None);
    }

    #[test]
    fn a_sector_goes_out_along_one_edge_and_back_along_the_other() {
        let outline = sector(Vec2::new(1.0, 0.0), [0.5, 2.0], [-FRAC_PI_4, FRAC_PI_4]);
        let count = outline.len() / 2;
        let edge = unit(-FRAC_PI_4);
        assert!(outline[0].abs_diff_eq(Vec2::X + 0.5 * edge, 1e-5));
        assert!(outline[2 * count - 1].abs_diff_eq(Vec2::X + 2.0 * edge, 1e-5));
        for (index, point) in outline.iter().enumerate() {
            assert_abs_diff_eq!(point.distance(Vec2::X), if index < count { 0.5 } else { 2.0 }, epsilon = 1e-5);
        }
        assert_eq!(arc(Vec2::ZERO, 1.0, [0.0, 2.0 * PI]).count(), 65);
    }
}
