//! The primitive shapes of robots, goals and posts.

use bevy::math::{Affine3A, Mat3, Quat, Vec2, Vec3};

use super::Label;
use super::colours::Colour;

/// A body about the origin of its own frame, m.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Shape {
    /// A box.
    Box {
        /// Half its size along x, y and z.
        half_size: Vec3,
    },
    /// An ellipsoid, or a sphere where all radii are the same.
    Ellipsoid {
        /// Half its size along x, y and z.
        radii: Vec3,
    },
    /// A frustum of a cone around z, or a cylinder where both ends are the same. Its ends are ellipses.
    Frustum {
        /// Radii along x and y of the end at -z.
        bottom: Vec2,
        /// Radii along x and y of the end at +z.
        top: Vec2,
        /// Half its height.
        half_height: f32,
    },
    /// A rod along z with round ends.
    Capsule {
        /// Radius of the rod and of its ends.
        radius: f32,
        /// Half the distance between the centres of its ends.
        half_length: f32,
    },
}

impl Shape {
    /// A sphere.
    pub const fn sphere(radius: f32) -> Self {
        Shape::Ellipsoid { radii: Vec3::splat(radius) }
    }

    /// A round cylinder around z.
    pub const fn cylinder(radius: f32, height: f32) -> Self {
        Shape::Frustum { bottom: Vec2::splat(radius), top: Vec2::splat(radius), half_height: height / 2.0 }
    }

    /// The greatest distance of a point of the shape from its origin, m.
    pub fn reach(self) -> f32 {
        match self {
            Shape::Box { half_size } => half_size.length(),
            Shape::Ellipsoid { radii } => radii.max_element(),
            Shape::Frustum { bottom, top, half_height } => {
                Vec2::new(bottom.max_element().max(top.max_element()), half_height).length()
            }
            Shape::Capsule { radius, half_length } => radius + half_length,
        }
    }
}

/// A shape with its place, colour and label.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Part<Frame> {
    /// The frame in which it is placed: the limb of a robot, or the pitch.
    pub frame: Frame,
    /// Its label.
    pub label: Label,
    /// Its colour.
    pub colour: Colour,
    /// Its shape.
    pub shape: Shape,
    /// Its transform in the frame. Rotation and translation only.
    pub frame_from_shape: Affine3A,
}

impl<Frame> Part<Frame> {
    /// A part at `centre`, without rotation.
    pub fn at(frame: Frame, label: Label, colour: Colour, shape: Shape, centre: Vec3) -> Self {
        Self { frame, label, colour, shape, frame_from_shape: Affine3A::from_translation(centre) }
    }

    /// A rod with round ends between two points.
    pub fn rod(frame: Frame, label: Label, colour: Colour, radius: f32, [from, to]: [Vec3; 2]) -> Self {
        let (frame_from_shape, half_length) = along(from, to);
        Self { frame, label, colour, shape: Shape::Capsule { radius, half_length }, frame_from_shape }
    }

    /// A round cylinder between two points.
    pub fn pipe(frame: Frame, label: Label, colour: Colour, radius: f32, [from, to]: [Vec3; 2]) -> Self {
        let (frame_from_shape, half_length) = along(from, to);
        Self { frame, label, colour, shape: Shape::cylinder(radius, 2.0 * half_length), frame_from_shape }
    }
}

/// The frame whose z axis runs from one point to another with its origin between them, and half their distance.
fn along(from: Vec3, to: Vec3) -> (Affine3A, f32) {
    let axis = to - from;
    let rotation = Mat3::from_quat(Quat::from_rotation_arc(Vec3::Z, axis.normalize_or(Vec3::Z)));
    (Affine3A::from_mat3_translation(rotation, (from + to) / 2.0), axis.length() / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::colours;

    #[test]
    fn a_rod_ends_where_it_should() {
        let [from, to] = [Vec3::new(0.1, 0.2, 0.3), Vec3::new(-0.4, 0.2, 0.7)];
        let rod = Part::rod((), Label::Ball, colours::BALL, 0.05, [from, to]);
        let Shape::Capsule { half_length, .. } = rod.shape else { panic!() };
        let ends = [-1.0, 1.0].map(|end| rod.frame_from_shape.transform_point3(Vec3::Z * end * half_length));
        assert!(ends[0].abs_diff_eq(from, 1e-6) && ends[1].abs_diff_eq(to, 1e-6), "{ends:?}");
    }

    #[test]
    fn no_point_of_a_shape_is_beyond_its_reach() {
        let half_size = Vec3::new(0.3, 0.4, 1.2);
        // The diagonal of 0.3, 0.4 and 1.2 is 1.3.
        assert!((Shape::Box { half_size }.reach() - 1.3).abs() < 1e-6);
        assert_eq!(Shape::sphere(2.0).reach(), 2.0);
        assert_eq!(Shape::cylinder(3.0, 8.0).reach(), 5.0);
        assert_eq!(Shape::Capsule { radius: 0.5, half_length: 2.0 }.reach(), 2.5);
    }
}
