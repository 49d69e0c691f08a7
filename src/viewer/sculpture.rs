//! Meshes of the [appearance's](crate::appearance) parts: one mesh with colours in its vertices, and one material for all of
//! them, instead of one each.

use bevy::mesh::{MeshMergeError, VertexAttributeValues};
use bevy::prelude::*;
use core::f32::consts::FRAC_PI_2;

use super::palette;
use crate::appearance::shapes::{Part, Shape};

/// A mesh under construction. Its colours are in the vertices.
#[derive(Default)]
pub struct Sculpture {
    mesh: Option<Mesh>,
}

impl Sculpture {
    /// All these parts, each in its own frame.
    pub fn of<'a, Frame: 'a>(parts: impl IntoIterator<Item = &'a Part<Frame>>) -> Mesh {
        parts.into_iter().fold(Self::default(), Self::add).finish()
    }

    /// Adds a part.
    fn add<Frame>(mut self, part: &Part<Frame>) -> Self {
        let place = Transform::from_matrix(part.frame_from_shape.into());
        let mesh = mesh_of(part.shape).transformed_by(place);
        let colour = LinearRgba::from(palette::from_appearance(part.colour)).to_f32_array();
        let colours = vec![colour; mesh.count_vertices()];
        let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours);
        match &mut self.mesh {
            None => self.mesh = Some(mesh),
            Some(whole) => report(whole.merge(&mesh)),
        }
        self
    }

    /// The mesh; a speck without any part.
    fn finish(self) -> Mesh {
        self.mesh.unwrap_or_else(|| Cuboid::from_length(0.0).into())
    }
}

/// The mesh of a shape about its own frame.
fn mesh_of(shape: Shape) -> Mesh {
    match shape {
        Shape::Box { half_size } => Cuboid { half_size }.into(),
        Shape::Ellipsoid { radii } => {
            let sphere = Sphere::new(1.0).mesh().uv(20, 12);
            sphere.transformed_by(Transform::from_scale(radii))
        }
        Shape::Frustum { bottom, top, half_height } => frustum(bottom, top, half_height),
        Shape::Capsule { radius, half_length } => {
            let rod = Capsule3d::new(radius, 2.0 * half_length).mesh().longitudes(16).latitudes(8).build();
            rod.transformed_by(upright(Vec3::ZERO))
        }
    }
}

/// A cylinder of radius 1, with its ends stretched.
fn frustum(bottom: Vec2, top: Vec2, half_height: f32) -> Mesh {
    let mut mesh = Cylinder::new(1.0, 2.0 * half_height).mesh().resolution(24).build();
    let slant = (bottom - top) / (2.0 * half_height).max(1e-6);
    // Bevy's cylinder is around y.
    let places: Vec<Vec3> = match mesh.attribute(Mesh::ATTRIBUTE_POSITION) {
        Some(VertexAttributeValues::Float32x3(places)) => places.iter().map(|&[x, y, z]| Vec3::new(x, -z, y)).collect(),
        _ => Vec::new(),
    };
    let stretched = places.iter().map(|place| {
        let radii = bottom.lerp(top, (place.z + half_height) / (2.0 * half_height).max(1e-6));
        (place.truncate() * radii).extend(place.z).to_array()
    });
    let stretched: Vec<[f32; 3]> = stretched.collect();
    if let Some(VertexAttributeValues::Float32x3(normals)) = mesh.attribute_mut(Mesh::ATTRIBUTE_NORMAL) {
        for (normal, place) in normals.iter_mut().zip(&places) {
            let [x, y, z] = *normal;
            // The ends look up and down, the side outwards and by its slant.
            *normal = if y.abs() > 0.5 {
                [0.0, 0.0, y.signum()]
            } else {
                let radii = (bottom + top) / 2.0;
                let outwards = Vec2::new(x * radii.y, -z * radii.x).normalize_or(place.truncate());
                let rise = (slant * outwards * outwards).element_sum();
                outwards.extend(rise).normalize_or(Vec3::X).to_array()
            };
        }
    }
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, stretched);
    mesh
}

/// Stands a shape with its axis along y up along z.
pub fn upright(centre: Vec3) -> Transform {
    Transform::from_translation(centre).with_rotation(Quat::from_rotation_x(FRAC_PI_2))
}

/// The material of all sculptures.
pub fn material() -> StandardMaterial {
    StandardMaterial { perceptual_roughness: 0.5, reflectance: 0.3, ..default() }
}

/// All primitives have the same attributes, so this does not happen; if it does, a part is missing in the picture.
fn report(merged: Result<(), MeshMergeError>) {
    if let Err(problem) = merged {
        error!("a part of a figure cannot be shown: {problem}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::{Label, colours};
    use bevy::camera::primitives::MeshAabb;

    fn part(shape: Shape, centre: Vec3) -> Part<()> {
        Part::at((), Label::Ball, colours::BALL, shape, centre)
    }

    #[test]
    fn a_sculpture_is_the_sum_of_its_parts() {
        let parts = [
            part(Shape::Box { half_size: Vec3::ONE }, Vec3::ZERO),
            part(Shape::sphere(1.0), Vec3::Z),
            Part::rod((), Label::Ball, colours::BALL, 0.1, [Vec3::ZERO, Vec3::X]),
            part(Shape::cylinder(0.1, 1.0), Vec3::Y),
        ];
        let each = parts.iter().map(|part| Sculpture::of([part]).count_vertices()).sum::<usize>();
        assert_eq!(Sculpture::of(&parts).count_vertices(), each);
    }

    #[test]
    fn shapes_are_as_large_as_they_say() {
        let frustum = Shape::Frustum { bottom: Vec2::new(0.1, 0.2), top: Vec2::new(0.3, 0.1), half_height: 0.5 };
        for (shape, half_size) in [
            (Shape::Box { half_size: Vec3::new(0.1, 0.2, 0.3) }, Vec3::new(0.1, 0.2, 0.3)),
            (Shape::Ellipsoid { radii: Vec3::new(0.1, 0.2, 0.3) }, Vec3::new(0.1, 0.2, 0.3)),
            (frustum, Vec3::new(0.3, 0.2, 0.5)),
            (Shape::Capsule { radius: 0.1, half_length: 0.4 }, Vec3::new(0.1, 0.1, 0.5)),
        ] {
            let bounds = mesh_of(shape).compute_aabb().unwrap();
            assert!(Vec3::from(bounds.half_extents).abs_diff_eq(half_size, 0.01), "{shape:?}: {bounds:?}");
        }
    }

    #[test]
    fn what_is_upright_points_to_the_sky() {
        let up = upright(Vec3::ZERO).transform_point(Vec3::Y);
        assert!(up.abs_diff_eq(Vec3::Z, 1e-6), "{up}");
    }
}
