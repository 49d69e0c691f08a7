//! The geometry of a sonar's sector: the nearest point of a disc or a box inside the sector.
//!
//! All coordinates are in the sonar's own frame: the apex of the sector is the origin, its axis is +x.

use bevy::prelude::*;

use naoisis_core::geometry::unit;

/// A sector of the plane with its apex at the origin and its axis along +x, edges included, of at most a half turn.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sector {
    /// The unit vector along the left edge; the right edge is mirrored.
    left_edge: Vec2,
}

impl Sector {
    /// The sector with this half opening angle, radians; at most a quarter turn.
    pub fn new(half_angle: f32) -> Self {
        let left_edge = unit(half_angle.clamp(0.0, core::f32::consts::FRAC_PI_2));
        Self { left_edge }
    }

    /// The distance of a point from the left edge and from the right edge, m: positive inside, negative outside.
    fn margins(self, point: Vec2) -> [f32; 2] {
        let mirrored = Vec2::new(point.x, -point.y);
        [-self.left_edge.perp_dot(point), -self.left_edge.perp_dot(mirrored)]
    }

    /// Whether the sector contains `point`.
    pub fn contains(self, point: Vec2) -> bool {
        self.margins(point).into_iter().all(|margin| margin >= 0.0)
    }

    /// Whether a part of a disc may be inside. False if the whole disc is outside one of the edges.
    pub fn may_contain(self, centre: Vec2, radius: f32) -> bool {
        self.margins(centre).into_iter().all(|margin| margin >= -radius)
    }

    /// The distance from the apex to the nearest point of a disc inside the sector: `None` if the whole disc is outside, zero if the apex
    /// is inside the disc.
    pub fn distance_to_disc(self, centre: Vec2, radius: f32) -> Option<f32> {
        let distance = centre.length();
        if distance <= radius {
            return Some(0.0);
        }
        if self.contains(centre) {
            return Some(distance - radius);
        }
        // The centre is outside, so the nearest point lies on an edge: |t e - c| = r, the smaller root.
        let nearest_on = |edge: Vec2| {
            let along = edge.dot(centre);
            let across = edge.perp_dot(centre);
            let half_chord_squared = radius * radius - across * across;
            (along > 0.0 && half_chord_squared >= 0.0).then(|| along - half_chord_squared.sqrt())
        };
        let right_edge = Vec2::new(self.left_edge.x, -self.left_edge.y);
        nearer(nearest_on(self.left_edge), nearest_on(right_edge))
    }

    /// The distance from the apex to the nearest point of a convex polygon inside the sector: `None` if the whole polygon is outside, zero
    /// if the apex is inside the polygon. The corners are in counter-clockwise order.
    pub fn distance_to_polygon<const CORNERS: usize>(self, corners: [Vec2; CORNERS]) -> Option<f32> {
        let edges = || (0..CORNERS).map(|index| (corners[index], corners[(index + 1) % CORNERS]));
        if edges().all(|(start, end)| (end - start).perp_dot(-start) >= 0.0) {
            return Some(0.0);
        }
        // A nearest point inside the sector is always on the polygon's outline: along an edge of the sector, the point
        // nearer to the apex is where that edge enters the polygon.
        edges().filter_map(|(start, end)| self.distance_to_segment(start, end)).reduce(f32::min)
    }

    /// The distance from the apex to the nearest point of a segment inside the sector.
    fn distance_to_segment(self, start: Vec2, end: Vec2) -> Option<f32> {
        let mut part = [0.0f32, 1.0];
        for (at_start, at_end) in self.margins(start).into_iter().zip(self.margins(end)) {
            if at_start < 0.0 && at_end < 0.0 {
                return None;
            }
            if at_start < 0.0 {
                part[0] = part[0].max(at_start / (at_start - at_end));
            } else if at_end < 0.0 {
                part[1] = part[1].min(at_start / (at_start - at_end));
            }
        }
        if part[0] > part[1] {
            return None;
        }
        let along = end - start;
        let length_squared = along.length_squared();
        let nearest = if length_squared > 0.0 { -start.dot(along) / length_squared } else { 0.0 };
        Some((start + nearest.clamp(part[0], part[1]) * along).length())
    }
}

/// The smaller of two distances, of which either may be absent.
pub fn nearer(a: Option<f32>, b: Option<f32>) -> Option<f32> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use naoisis_core::geometry::to_radians;
    use proptest::prelude::*;

    fn sector() -> Sector {
        Sector::new(to_radians(18.0))
    }

    fn at(distance: f32, degrees: f32) -> Vec2 {
        distance * unit(to_radians(degrees))
    }

    #[test]
    fn a_disc_inside_is_as_far_as_its_near_side() {
        for degrees in [-17.9, -5.0, 0.0, 17.9] {
            assert_abs_diff_eq!(sector().distance_to_disc(at(0.5, degrees), 0.05).unwrap(), 0.45, epsilon = 1e-6);
        }
        assert_eq!(sector().distance_to_disc(at(0.04, 150.0), 0.05), Some(0.0));
    }

    #[test]
    fn a_disc_across_an_edge_is_as_far_as_where_the_edge_meets_it() {
        // Centre 4° outside the edge at 0.5 m: along the edge 0.5 cos 4° = 0.498782, beside it 0.5 sin 4° = 0.034878;
        // half the chord is sqrt(0.05² - 0.034878²) = 0.035827, so 0.462955 m.
        for degrees in [22.0, -22.0] {
            let distance = sector().distance_to_disc(at(0.5, degrees), 0.05).unwrap();
            assert_abs_diff_eq!(distance, 0.462_955, epsilon = 1e-5);
        }
        // asin(0.05 / 0.5) = 5.739° outside the edge it only touches.
        assert!(sector().distance_to_disc(at(0.5, 18.0 + 5.70), 0.05).is_some());
        assert_eq!(sector().distance_to_disc(at(0.5, 18.0 + 5.78), 0.05), None);
        assert_eq!(sector().distance_to_disc(at(0.5, 180.0), 0.05), None);
    }

    #[test]
    fn the_nearest_point_of_a_box_may_be_on_a_side_a_corner_or_an_edge_of_the_sector() {
        let square = |centre: Vec2, half: f32| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| centre + half * Vec2::new(x, y))
        };
        // Ahead: its near side.
        assert_abs_diff_eq!(sector().distance_to_polygon(square(Vec2::new(0.5, 0.0), 0.1)).unwrap(), 0.4);
        // Its near corner (0.4, 0.05).
        let corner = sector().distance_to_polygon(square(Vec2::new(0.5, 0.15), 0.1)).unwrap();
        assert_abs_diff_eq!(corner, Vec2::new(0.4, 0.05).length(), epsilon = 1e-6);
        // The near corner (0.4, 0.14) is at 19.3°, outside; the lower side y = 0.14 enters at x = 0.14 / tan 18°
        // = 0.430876: 0.14 / sin 18° = 0.453049 m.
        let clipped = sector().distance_to_polygon(square(Vec2::new(0.5, 0.24), 0.1)).unwrap();
        assert_abs_diff_eq!(clipped, 0.453_049, epsilon = 1e-5);
        // The lower far corner (0.6, 0.1949) is the first inside: tan 18° * 0.6 = 0.194952.
        assert!(sector().distance_to_polygon(square(Vec2::new(0.5, 0.294_9), 0.1)).is_some());
        assert_eq!(sector().distance_to_polygon(square(Vec2::new(0.5, 0.295_1), 0.1)), None);
        assert_eq!(sector().distance_to_polygon(square(Vec2::new(-0.5, 0.0), 0.1)), None);
        assert_eq!(sector().distance_to_polygon(square(Vec2::new(0.0, 0.05), 0.1)), Some(0.0));
    }

    proptest! {
        /// Compared with brute force: the nearest point of a fine grid that is in the polygon and in the sector.
        #[test]
        fn the_nearest_point_of_a_box_agrees_with_a_search(
            x in -0.4f32..0.9, y in -0.7f32..0.7, degrees in 0.0f32..180.0, half_angle in 2.0f32..80.0,
        ) {
            let sector = Sector::new(to_radians(half_angle));
            let (centre, forward, half) = (Vec2::new(x, y), unit(to_radians(degrees)), Vec2::new(0.04, 0.15));
            let point = |u: f32, v: f32| centre + forward.rotate(Vec2::new(u, v) * half);
            let corners = [point(-1.0, -1.0), point(1.0, -1.0), point(1.0, 1.0), point(-1.0, 1.0)];
            let searched = (-100..=100)
                .flat_map(|u| (-200..=200).map(move |v| point(u as f32 / 100.0, v as f32 / 200.0)))
                .filter(|&point| sector.contains(point))
                .map(Vec2::length)
                .reduce(f32::min);
            // The corners are within 15.6 cm of the middle.
            prop_assert!(searched.is_none() || sector.may_contain(centre, 0.156));
            let computed = sector.distance_to_polygon(corners);
            match (computed, searched) {
                // The grid's points are at most 0.75 mm apart; near the apex of a narrow sector the grid misses more.
                (Some(computed), Some(searched)) => {
                    prop_assert!(computed <= searched + 1e-5 && searched - computed < 0.012, "{computed} {searched}");
                }
                (None, Some(searched)) => prop_assert!(false, "missed {searched}"),
                // A sliver between the grid's points.
                (Some(_), None) | (None, None) => {}
            }
        }
    }
}
