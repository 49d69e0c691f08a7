//! Meshes of the parts of the [appearance](naoisis_sensing::appearance): one mesh with vertex colours, and one material
//! for all, instead of one each.

use bevy::mesh::MeshMergeError;
use bevy::prelude::*;

use super::palette;
use naoisis_gpu::mesh::mesh_of;
use naoisis_sensing::appearance::shapes::Part;

/// Merges parts into one mesh with vertex colours. Without parts, the mesh is a tiny triangle.
pub fn mesh_of_parts<'a, Frame: 'a>(parts: impl IntoIterator<Item = &'a Part<Frame>>) -> Mesh {
    let mut meshes = parts.into_iter().map(coloured_mesh);
    let mut whole = meshes.next().unwrap_or_else(|| Cuboid::from_length(0.0).into());
    for mesh in meshes {
        report(whole.merge(&mesh));
    }
    whole
}

/// The mesh of a part, in its frame.
fn coloured_mesh<Frame>(part: &Part<Frame>) -> Mesh {
    let place = Transform::from_matrix(part.frame_from_shape.into());
    let mesh = mesh_of(part.shape).transformed_by(place);
    let colour = LinearRgba::from(palette::from_appearance(part.colour)).to_f32_array();
    let colours = vec![colour; mesh.count_vertices()];
    mesh.with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours)
}

/// Returns the material of all merged meshes: white, because vertices have the colours.
pub fn part_material() -> StandardMaterial {
    StandardMaterial { perceptual_roughness: 0.5, reflectance: 0.3, ..default() }
}

/// Logs a failure to merge, which should not happen because all primitives have the same attributes. The part is then
/// missing.
fn report(merged: Result<(), MeshMergeError>) {
    if let Err(problem) = merged {
        error!("a part of a body cannot be drawn: {problem}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sensing::appearance::shapes::Shape;
    use naoisis_sensing::appearance::{Label, colours};

    fn part(shape: Shape, centre: Vec3) -> Part<()> {
        Part::at((), Label::Ball, colours::BALL, shape, centre)
    }

    #[test]
    fn a_mesh_is_the_sum_of_its_parts() {
        let parts = [
            part(Shape::Box { half_size: Vec3::ONE }, Vec3::ZERO),
            part(Shape::sphere(1.0), Vec3::Z),
            Part::rod((), Label::Ball, colours::BALL, 0.1, [Vec3::ZERO, Vec3::X]),
            part(Shape::cylinder(0.1, 1.0), Vec3::Y),
        ];
        let each = parts.iter().map(|part| mesh_of_parts([part]).count_vertices()).sum::<usize>();
        assert_eq!(mesh_of_parts(&parts).count_vertices(), each);
    }
}
