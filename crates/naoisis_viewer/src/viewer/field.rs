//! The models of carpet, lines, goals and nets, for the pitch of the scenario.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use core::f32::consts::TAU;

use super::palette;
use super::part_mesh::{mesh_of_parts, part_material};
use super::pitch_frame::PitchRoot;
use naoisis_core::geometry::unit;
use naoisis_core::pitch::{End, Pitch};
use naoisis_gpu::mesh::carpet_triangles;
use naoisis_sensing::appearance::field::{self, GroundShape};
use naoisis_sensing::appearance::people::{Person, people};
use naoisis_sensing::appearance::shapes::Part;
use naoisis_sensing::appearance::{Label, colours};

/// The height of the lines above the carpet, m.
const LINE_HEIGHT: f32 = 0.003;
/// The number of corners of the centre circle.
const CIRCLE_CORNERS: u32 = 96;

/// Spawns the model of the pitch, and replaces it when the pitch changes.
pub struct FieldPlugin;

impl Plugin for FieldPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Update, lay_out_field.run_if(resource_exists_and_changed::<Pitch>));
    }
}

/// Marks the parts of the model.
#[derive(Component)]
struct FieldPart;

fn lay_out_field(
    mut commands: Commands,
    pitch: Res<Pitch>,
    root: Res<PitchRoot>,
    old: Query<Entity, With<FieldPart>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for part in &old {
        commands.entity(part).despawn();
    }
    let matt =
        |colour| StandardMaterial { base_color: colour, perceptual_roughness: 0.95, reflectance: 0.1, ..default() };
    let mut spawn = |mesh: Mesh, material: StandardMaterial, place: Vec3| {
        commands.spawn((
            FieldPart,
            ChildOf(root.0),
            Mesh3d(meshes.add(mesh)),
            MeshMaterial3d(materials.add(material)),
            Transform::from_translation(place),
        ));
    };
    for (label, colour, height) in [(Label::Carpet, colours::CARPET, 0.0), (Label::Line, colours::CHALK, LINE_HEIGHT)] {
        spawn(ground(&pitch, label), matt(palette::from_appearance(colour)), Vec3::Z * height);
    }
    let people: Vec<Part<()>> = people(&pitch).iter().flat_map(Person::parts).collect();
    if !people.is_empty() {
        spawn(mesh_of_parts(&people), part_material(), Vec3::ZERO);
    }
    for end in End::BOTH {
        spawn(mesh_of_parts(&field::goal_frame(&pitch, end)), part_material(), Vec3::ZERO);
        let net = StandardMaterial {
            base_color: palette::NET.with_alpha(0.45),
            alpha_mode: AlphaMode::Blend,
            unlit: true,
            ..default()
        };
        spawn(net_lines(&field::net_strings(&pitch, end)), net, Vec3::ZERO);
    }
}

/// All ground of one kind as one flat mesh that faces up.
fn ground(pitch: &Pitch, label: Label) -> Mesh {
    let mut flat = FlatMesh::default();
    for mark in field::ground(pitch).into_iter().filter(|mark| mark.label == label) {
        match mark.shape {
            GroundShape::Quadrilateral(corners) if label == Label::Carpet && pitch.unevenness > 0.0 => {
                flat.carpet(corners, pitch.unevenness);
            }
            GroundShape::Quadrilateral(corners) => flat.quadrilateral(corners),
            GroundShape::Ring { centre, inner, outer } => flat.ring(centre, inner, outer),
        }
    }
    flat.finish()
}

/// A mesh of quadrilaterals on the ground.
#[derive(Default)]
struct FlatMesh {
    corners: Vec<[f32; 3]>,
    indices: Vec<u32>,
    /// The brightness of each corner; 1 for those beyond the end of the list.
    brightness: Vec<f32>,
}

impl FlatMesh {
    /// Adds four corners, counter-clockwise from above.
    fn quadrilateral(&mut self, corners: [Vec2; 4]) {
        let first = self.corners.len() as u32;
        self.corners.extend(corners.map(|corner| [corner.x, corner.y, 0.0]));
        self.indices.extend([0, 1, 2, 0, 2, 3].map(|index| first + index));
    }

    /// Adds a carpet with this uneven colour, whose corners run from the least one counter-clockwise.
    fn carpet(&mut self, corners: [Vec2; 4], unevenness: f32) {
        self.brightness.resize(self.corners.len(), 1.0);
        for (place, brightness) in carpet_triangles(corners, unevenness) {
            self.indices.push(self.corners.len() as u32);
            self.corners.push([place.x, place.y, 0.0]);
            self.brightness.push(brightness);
        }
    }

    /// Adds the ring between two circles.
    fn ring(&mut self, centre: Vec2, inner: f32, outer: f32) {
        let direction = |corner: u32| unit(TAU * (corner % CIRCLE_CORNERS) as f32 / CIRCLE_CORNERS as f32);
        for corner in 0..CIRCLE_CORNERS {
            let (here, next) = (direction(corner), direction(corner + 1));
            let corners = [inner * here, outer * here, outer * next, inner * next];
            self.quadrilateral(corners.map(|corner| centre + corner));
        }
    }

    fn finish(mut self) -> Mesh {
        let count = self.corners.len();
        self.brightness.resize(count, 1.0);
        // Colours of vertices are linear, the brightness is that of the file's colour.
        let linear = |level: &f32| [level * level, level * level, level * level, 1.0];
        let colours: Vec<[f32; 4]> = self.brightness.iter().map(linear).collect();
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, self.corners)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; count])
            .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0, 0.0]; count])
            .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours)
            .with_inserted_indices(Indices::U32(self.indices))
    }
}

/// The strings of a net as lines.
fn net_lines(strings: &[[Vec3; 2]]) -> Mesh {
    let ends: Vec<[f32; 3]> = strings.as_flattened().iter().map(|end| end.to_array()).collect();
    let count = ends.len();
    Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, ends)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; count])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_on_the_ground_look_up() {
        let mut flat = FlatMesh::default();
        flat.quadrilateral([Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
        flat.ring(Vec2::ONE, 0.6, 0.65);
        for triangle in flat.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|index| Vec3::from(flat.corners[triangle[index] as usize]));
            assert!((b - a).cross(c - a).z > 0.0);
        }
    }
}
