//! A mesh of coloured quadrilaterals.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use core::f32::consts::TAU;

use super::super::palette;
use naoisis_core::geometry::unit;
use naoisis_sensing::appearance::colours::Colour;

/// The number of corners of a circle.
const CIRCLE_CORNERS: u32 = 96;

/// Quadrilaterals that become one mesh, m, pitch frame.
#[derive(Default)]
pub(super) struct QuadMesh {
    corners: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    colours: Vec<[f32; 4]>,
}

impl QuadMesh {
    /// Adds a quadrilateral, whose corners are counter-clockwise for those who see it.
    pub(super) fn add(&mut self, corners: [Vec3; 4], colour: Colour) {
        self.shaded(corners, colour, [1.0; 4]);
    }

    /// Adds a quadrilateral like [`QuadMesh::add`], with a brightness of each corner, as a multiple of `colour`.
    pub(super) fn shaded(&mut self, corners: [Vec3; 4], colour: Colour, brightness: [f32; 4]) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or(Vec3::Z);
        let linear = LinearRgba::from(palette::from_appearance(colour));
        self.corners.extend(corners.map(|corner| corner.to_array()));
        self.normals.extend([normal.to_array(); 4]);
        self.colours.extend(brightness.map(|level| (linear * level).with_alpha(1.0).to_f32_array()));
    }

    /// Adds the ring between two circles on the ground, which is seen from above.
    pub(super) fn ring(&mut self, centre: Vec2, inner: f32, outer: f32, colour: Colour) {
        let direction = |corner: u32| unit(TAU * (corner % CIRCLE_CORNERS) as f32 / CIRCLE_CORNERS as f32);
        for corner in 0..CIRCLE_CORNERS {
            let (here, next) = (direction(corner), direction(corner + 1));
            let corners = [inner * here, outer * here, outer * next, inner * next];
            self.add(corners.map(|corner| (centre + corner).extend(0.0)), colour);
        }
    }

    /// Returns the mesh.
    pub(super) fn finish(self) -> Mesh {
        let quads = 0..self.corners.len() as u32 / 4;
        let indices = quads.flat_map(|quad| [0, 1, 2, 0, 2, 3].map(|corner| 4 * quad + corner)).collect();
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, self.corners)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, self.normals)
            .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, self.colours)
            .with_inserted_indices(Indices::U32(indices))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sensing::appearance::colours;

    #[test]
    fn faces_on_the_ground_look_up() {
        let mut quads = QuadMesh::default();
        quads.add([Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y].map(|corner| corner.extend(0.0)), colours::CHALK);
        quads.ring(Vec2::ONE, 0.6, 0.65, colours::CHALK);
        assert!(quads.normals.iter().all(|normal| normal[2] > 0.999));
    }
}
