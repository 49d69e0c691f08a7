//! Meshes put together from coloured primitives: one mesh, and one material for all of them, instead of one each.

use bevy::mesh::MeshMergeError;
use bevy::prelude::*;
use core::f32::consts::FRAC_PI_2;

/// A mesh under construction. Its colours are in the vertices.
#[derive(Default)]
pub struct Sculpture {
    mesh: Option<Mesh>,
}

impl Sculpture {
    /// Adds a shape at a place.
    pub fn add(mut self, shape: impl Into<Mesh>, colour: Color, place: Transform) -> Self {
        let part = shape.into().transformed_by(place);
        let colours = vec![LinearRgba::from(colour).to_f32_array(); part.count_vertices()];
        let part = part.with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours);
        match &mut self.mesh {
            None => self.mesh = Some(part),
            Some(mesh) => report(mesh.merge(&part)),
        }
        self
    }

    /// Adds a box of this size, centred at `centre`.
    pub fn cuboid(self, size: Vec3, centre: Vec3, colour: Color) -> Self {
        self.add(Cuboid::from_size(size), colour, Transform::from_translation(centre))
    }

    /// Adds a rod with round ends between two points.
    pub fn rod(self, from: Vec3, to: Vec3, radius: f32, colour: Color) -> Self {
        let along = to - from;
        let place = Transform {
            translation: (from + to) / 2.0,
            rotation: Quat::from_rotation_arc(Vec3::Y, along.normalize_or(Vec3::Y)),
            scale: Vec3::ONE,
        };
        self.add(Capsule3d::new(radius, along.length()).mesh().longitudes(16).latitudes(8), colour, place)
    }

    /// Adds a cylinder that stands on its end, its centre at `centre`.
    pub fn upright_cylinder(self, radius: f32, height: f32, centre: Vec3, colour: Color) -> Self {
        self.add(Cylinder::new(radius, height), colour, upright(centre))
    }

    /// Adds a ball.
    pub fn ball(self, radius: f32, centre: Vec3, colour: Color) -> Self {
        self.add(Sphere::new(radius), colour, Transform::from_translation(centre))
    }

    /// The mesh; a speck without any part.
    pub fn finish(self) -> Mesh {
        self.mesh.unwrap_or_else(|| Cuboid::from_length(0.0).into())
    }
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

    #[test]
    fn a_sculpture_is_the_sum_of_its_parts() {
        let parts = [
            Sculpture::default().cuboid(Vec3::ONE, Vec3::ZERO, Color::WHITE).finish(),
            Sculpture::default().ball(1.0, Vec3::Z, Color::WHITE).finish(),
            Sculpture::default().rod(Vec3::ZERO, Vec3::X, 0.1, Color::WHITE).finish(),
        ];
        let whole = Sculpture::default()
            .cuboid(Vec3::ONE, Vec3::ZERO, Color::WHITE)
            .ball(1.0, Vec3::Z, Color::WHITE)
            .rod(Vec3::ZERO, Vec3::X, 0.1, Color::WHITE)
            .finish();
        assert_eq!(whole.count_vertices(), parts.iter().map(Mesh::count_vertices).sum::<usize>());
    }

    #[test]
    fn what_is_upright_points_to_the_sky() {
        let up = upright(Vec3::ZERO).transform_point(Vec3::Y);
        assert!(up.abs_diff_eq(Vec3::Z, 1e-6), "{up}");
    }
}
