//! Shapes on the ground as plain functions.

use bevy::prelude::*;

use naoisis_core::geometry::unit;

/// Returns the points of an arc between two angles, radians.
pub fn arc(centre: Vec2, radius: f32, [from, to]: [f32; 2]) -> impl Iterator<Item = Vec2> {
    /// The number of corners of a whole circle.
    const CORNERS: f32 = 64.0;
    let count = (CORNERS * (to - from).abs() / core::f32::consts::TAU).ceil().max(1.0) as u32;
    (0..=count).map(move |index| centre + radius * unit(from + (to - from) * index as f32 / count as f32))
}

/// Returns the outline of a sector of a ring between two angles, radians.
pub fn sector(centre: Vec2, [inner, outer]: [f32; 2], [from, to]: [f32; 2]) -> Vec<Vec2> {
    arc(centre, inner, [from, to]).chain(arc(centre, outer, [to, from])).collect()
}

/// Returns the corners of a rectangle.
pub fn corners(rectangle: Rect) -> [Vec2; 4] {
    let Rect { min, max } = rectangle;
    [min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use core::f32::consts::{FRAC_PI_4, PI};

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
