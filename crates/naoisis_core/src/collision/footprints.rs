//! Overlaps of rectangles, discs and points on the ground.
//!
//! Robots are upright boxes that never tilt, so all contacts are contacts of footprints.

use bevy::prelude::*;

use crate::robot::body::Footprint;

/// Least depth of an overlap, m.
const TOUCH_DEPTH: f32 = 1e-6;

/// The overlap of two shapes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Overlap {
    /// Unit vector from the first shape to the second, along which the penetration is least.
    pub normal: Vec2,
    /// Penetration depth along it, m.
    pub depth: f32,
}

impl Footprint {
    /// The corners, counter-clockwise.
    pub fn corners(&self) -> [Vec2; 4] {
        let along = self.forward * self.half_extents.x;
        let across = self.forward.perp() * self.half_extents.y;
        [
            self.centre + along + across,
            self.centre - along + across,
            self.centre - along - across,
            self.centre + along - across,
        ]
    }

    /// Radius of the circle about the centre that contains the rectangle, m.
    pub(crate) fn bounding_radius(&self) -> f32 {
        self.half_extents.length()
    }

    /// The overlap of this rectangle with another, by the separating axis theorem.
    pub fn overlap(&self, other: &Footprint) -> Option<Overlap> {
        let offset = other.centre - self.centre;
        let reach = self.bounding_radius() + other.bounding_radius();
        if offset.length_squared() > reach * reach {
            return None;
        }
        let mut least: Option<Overlap> = None;
        for axis in [self.forward, self.forward.perp(), other.forward, other.forward.perp()] {
            let distance = offset.dot(axis);
            let depth = self.half_width_along(axis) + other.half_width_along(axis) - distance.abs();
            if depth <= TOUCH_DEPTH {
                return None;
            }
            if least.is_none_or(|overlap| depth < overlap.depth) {
                least = Some(Overlap { normal: if distance < 0.0 { -axis } else { axis }, depth });
            }
        }
        least
    }

    /// The overlap of this rectangle with a disc.
    pub fn overlap_disc(&self, centre: Vec2, radius: f32) -> Option<Overlap> {
        let (distance, normal) = self.signed_distance(centre);
        let depth = radius - distance;
        (depth > TOUCH_DEPTH).then_some(Overlap { normal, depth })
    }

    /// The distance of a point from the rectangle's edge, negative inside, and the outward unit normal at the nearest point of the edge.
    pub fn signed_distance(&self, point: Vec2) -> (f32, Vec2) {
        let left = self.forward.perp();
        let offset = point - self.centre;
        let local = Vec2::new(offset.dot(self.forward), offset.dot(left));
        let outside = local.abs() - self.half_extents;
        let side = Vec2::new(local.x.signum(), local.y.signum());
        if outside.x <= 0.0 && outside.y <= 0.0 {
            return if outside.x >= outside.y {
                (outside.x, self.forward * side.x)
            } else {
                (outside.y, left * side.y)
            };
        }
        let nearest = outside.max(Vec2::ZERO);
        let distance = nearest.length();
        let direction = nearest * side / distance;
        (distance, self.forward * direction.x + left * direction.y)
    }

    fn half_width_along(&self, axis: Vec2) -> f32 {
        self.half_extents.x * self.forward.dot(axis).abs() + self.half_extents.y * self.forward.perp_dot(axis).abs()
    }
}

/// The distance of a point from a straight segment, and the unit vector from the segment to the point.
pub(crate) fn distance_from_segment(start: Vec2, end: Vec2, point: Vec2) -> (f32, Vec2) {
    let along = end - start;
    let share = ((point - start).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    let offset = point - (start + along * share);
    let distance = offset.length();
    let normal = offset.try_normalize().unwrap_or_else(|| along.perp().normalize_or(Vec2::X));
    (distance, normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Pose, unit};
    use crate::robot::body::Body;
    use approx::assert_abs_diff_eq;
    use parry3d::query::intersection_test;
    use proptest::prelude::*;

    fn torso(pose: Pose) -> Footprint {
        Body::default().torso.footprint(pose)
    }

    #[test]
    fn face_to_face_robots_overlap_by_the_missing_distance() {
        // Fronts are 5 cm ahead of the origins: at 9 cm apart they overlap by 1 cm.
        let left = torso(Pose::new(0.0, 0.0, 0.0));
        let right = torso(Pose::new(0.09, 0.0, core::f32::consts::PI));
        let overlap = left.overlap(&right).unwrap();
        assert_abs_diff_eq!(overlap.depth, 0.01, epsilon = 1e-6);
        assert_abs_diff_eq!(overlap.normal, Vec2::X, epsilon = 1e-6);
        assert!(left.overlap(&torso(Pose::new(0.1, 0.0, core::f32::consts::PI))).is_none());
    }

    #[test]
    fn signed_distance_inside_beside_and_at_a_corner() {
        let square = Footprint { centre: Vec2::ZERO, forward: unit(0.0), half_extents: Vec2::splat(1.0) };
        assert_eq!(square.signed_distance(Vec2::new(0.75, 0.0)), (-0.25, Vec2::X));
        assert_eq!(square.signed_distance(Vec2::new(0.0, -3.0)), (2.0, -Vec2::Y));
        let (distance, normal) = square.signed_distance(Vec2::new(4.0, 5.0));
        assert_abs_diff_eq!(distance, 5.0, epsilon = 1e-6);
        assert_abs_diff_eq!(normal, Vec2::new(0.6, 0.8), epsilon = 1e-6);
    }

    proptest! {
        #[test]
        fn overlap_agrees_with_parry_and_its_depth_separates(
            x in -0.4f32..0.4, y in -0.4f32..0.4, first in -3.2f32..3.2, second in -3.2f32..3.2,
        ) {
            let bounds = Body::default().torso;
            let (a, b) = (Pose::new(0.0, 0.0, first), Pose::new(x, y, second));
            let expected =
                intersection_test(&bounds.isometry(a), &bounds.shape(), &bounds.isometry(b), &bounds.shape()).unwrap();
            match bounds.footprint(a).overlap(&bounds.footprint(b)) {
                None => {
                    // Parry may call a touch an intersection.
                    let mut apart = bounds.footprint(b);
                    apart.centre += (apart.centre - bounds.footprint(a).centre).normalize_or(Vec2::X) * 1e-3;
                    prop_assert!(!expected || bounds.footprint(a).overlap(&apart).is_none());
                }
                Some(overlap) => {
                    prop_assert!(expected);
                    let mut apart = bounds.footprint(b);
                    apart.centre += overlap.normal * (overlap.depth + 1e-5);
                    prop_assert!(bounds.footprint(a).overlap(&apart).is_none());
                    // The other robot sees the same overlap, the other way round.
                    let mirrored = bounds.footprint(b).overlap(&bounds.footprint(a)).unwrap();
                    prop_assert!((mirrored.depth - overlap.depth).abs() < 1e-6);
                }
            }
        }
    }
}
