//! Shapes converted to faces and ellipsoids, in the frames of their parts.

use bevy::math::{Affine3A, Mat3, Vec2, Vec3};

use super::light::Paint;
use crate::appearance::shapes::{Part, Shape};
use naoisis_core::geometry::unit;

/// A corner of a face, with the normal of the surface there.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct ModelCorner {
    pub(super) position: Vec3,
    pub(super) normal: Vec3,
}

/// A flat convex face.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct ModelFace<Frame> {
    pub(super) frame: Frame,
    pub(super) paint: Paint,
    /// The normal of the face.
    pub(super) normal: Vec3,
    /// Whether all its corners have the normal of the face.
    pub(super) is_flat: bool,
    pub(super) first: u32,
    pub(super) count: u32,
}

/// An ellipsoid: the unit sphere, stretched and placed.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct ModelRound<Frame> {
    pub(super) frame: Frame,
    pub(super) paint: Paint,
    pub(super) reach: f32,
    pub(super) frame_from_unit: Affine3A,
}

/// Parts prepared for drawing.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Model<Frame> {
    pub(super) corners: Vec<ModelCorner>,
    pub(super) faces: Vec<ModelFace<Frame>>,
    pub(super) rounds: Vec<ModelRound<Frame>>,
}

/// Points on the unit circle, counter-clockwise.
pub(super) fn unit_circle(count: usize) -> impl Iterator<Item = Vec2> {
    (0..count).map(move |index| unit(core::f32::consts::TAU * index as f32 / count as f32))
}

impl<Frame: Copy> Model<Frame> {
    /// Prepares parts, with `segments` faces around a cylinder.
    pub(super) fn new(parts: &[Part<Frame>], segments: usize) -> Self {
        let mut model = Model { corners: Vec::new(), faces: Vec::new(), rounds: Vec::new() };
        for part in parts {
            model.add(part, segments);
        }
        model
    }

    fn add(&mut self, part: &Part<Frame>, segments: usize) {
        match part.shape {
            Shape::Box { half_size } => self.add_box(part, half_size),
            Shape::Ellipsoid { radii } => self.add_round(part, Vec3::ZERO, radii),
            Shape::Frustum { bottom, top, half_height } => {
                self.add_side(part, [bottom, top], half_height, segments);
                for (radii, up) in [(top, 1.0), (bottom, -1.0)] {
                    self.add_end(part, radii, up * half_height, segments);
                }
            }
            Shape::Capsule { radius, half_length } => {
                self.add_side(part, [Vec2::splat(radius); 2], half_length, segments);
                for end in [-half_length, half_length] {
                    self.add_round(part, Vec3::Z * end, Vec3::splat(radius));
                }
            }
        }
    }

    fn add_face(&mut self, part: &Part<Frame>, corners: &[(Vec3, Vec3)], is_flat: bool) {
        let place = part.frame_from_shape;
        let first = self.corners.len() as u32;
        self.corners.extend(corners.iter().map(|&(position, normal)| ModelCorner {
            position: place.transform_point3(position),
            normal: place.transform_vector3(normal).normalize_or(Vec3::Z),
        }));
        let [a, b, c] = [0, 1, 2].map(|index| corners[index].0);
        // Two of the four corners of a face may coincide.
        let d = corners[corners.len() - 1].0;
        let normal = (c - a).cross(d - b).normalize_or((b - a).cross(c - a).normalize_or(Vec3::Z));
        self.faces.push(ModelFace {
            frame: part.frame,
            paint: Paint::new(part.colour, part.label),
            normal: place.transform_vector3(normal),
            is_flat,
            first,
            count: corners.len() as u32,
        });
    }

    fn add_box(&mut self, part: &Part<Frame>, half: Vec3) {
        for axis in 0..3 {
            let (across, up) = ((axis + 1) % 3, (axis + 2) % 3);
            for side in [-1.0, 1.0] {
                let normal = Vec3::AXES[axis] * side;
                let corner = |x: f32, y: f32| {
                    let position = normal * half[axis]
                        + Vec3::AXES[across] * (x * side * half[across])
                        + Vec3::AXES[up] * (y * half[up]);
                    (position, normal)
                };
                let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                self.add_face(part, &corners, true);
            }
        }
    }

    fn add_side(&mut self, part: &Part<Frame>, [bottom, top]: [Vec2; 2], half_height: f32, segments: usize) {
        let slant = (bottom - top) / (2.0 * half_height).max(1e-6);
        let corner = |around: Vec2, radii: Vec2, height: f32| {
            // The normal of an ellipse is that of the circle, scaled by the inverse radii.
            let across = Vec2::new(around.x * radii.y, around.y * radii.x).normalize_or(around);
            let rise = (slant * around * around).element_sum();
            ((around * radii).extend(height), across.extend(rise))
        };
        let mut previous = None;
        for around in unit_circle(segments).chain(core::iter::once(Vec2::X)) {
            if let Some(before) = previous {
                let corners = [
                    corner(before, bottom, -half_height),
                    corner(around, bottom, -half_height),
                    corner(around, top, half_height),
                    corner(before, top, half_height),
                ];
                self.add_face(part, &corners, false);
            }
            previous = Some(around);
        }
    }

    fn add_end(&mut self, part: &Part<Frame>, radii: Vec2, height: f32, segments: usize) {
        let normal = Vec3::Z * height.signum();
        let mut corners: Vec<(Vec3, Vec3)> =
            unit_circle(segments).map(|around| ((around * radii).extend(height), normal)).collect();
        if height < 0.0 {
            corners.reverse();
        }
        self.add_face(part, &corners, true);
    }

    fn add_round(&mut self, part: &Part<Frame>, centre: Vec3, radii: Vec3) {
        let stretch = Affine3A::from_mat3_translation(Mat3::from_diagonal(radii), centre);
        self.rounds.push(ModelRound {
            frame: part.frame,
            paint: Paint::new(part.colour, part.label),
            reach: radii.max_element(),
            frame_from_unit: part.frame_from_shape * stretch,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::{Label, colours};

    fn model(shape: Shape) -> Model<()> {
        Model::new(&[Part::at((), Label::Ball, colours::BALL, shape, Vec3::new(1.0, 2.0, 3.0))], 12)
    }

    #[test]
    fn faces_look_outwards() {
        let half_size = Vec3::new(0.1, 0.2, 0.3);
        let frustum = Shape::Frustum { bottom: Vec2::new(0.1, 0.2), top: Vec2::new(0.3, 0.1), half_height: 0.2 };
        for shape in [Shape::Box { half_size }, Shape::cylinder(0.1, 0.4), frustum] {
            let model = model(shape);
            assert!(model.faces.len() >= 6);
            for face in &model.faces {
                let corners = &model.corners[face.first as usize..(face.first + face.count) as usize];
                let middle = corners.iter().map(|corner| corner.position).sum::<Vec3>() / corners.len() as f32;
                assert!(face.normal.is_normalized());
                assert!(face.normal.dot(middle - Vec3::new(1.0, 2.0, 3.0)) > 0.0, "{shape:?} {face:?}");
                assert!(corners.iter().all(|corner| corner.normal.dot(face.normal) > 0.5), "{shape:?} {face:?}");
            }
        }
    }
}
