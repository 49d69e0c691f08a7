//! Carpet, lines, goals and nets, as the scenario's pitch has them.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use core::f32::consts::TAU;

use super::palette;
use super::sculpture::{self, Sculpture, upright};
use super::stage::PitchRoot;
use crate::geometry::unit;
use crate::pitch::{End, GoalDimensions, LineSegment, Pitch};

/// The lines lie on the carpet, m.
const LINE_HEIGHT: f32 = 0.003;
/// Corners of the centre circle's polygon.
const CIRCLE_CORNERS: u32 = 96;
/// Width of the nets' meshes, m.
const NET_MESH: f32 = 0.08;

/// Shows the pitch, and shows it anew when it changes.
pub struct FieldPlugin;

impl Plugin for FieldPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Update, lay_out_field.run_if(resource_exists_and_changed::<Pitch>));
    }
}

/// Marks what belongs to the pitch.
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
    spawn(Plane3d::new(Vec3::Z, pitch.carpet_half_extents()).into(), matt(palette::CARPET), Vec3::ZERO);
    spawn(lines(&pitch), matt(palette::CHALK), Vec3::Z * LINE_HEIGHT);
    for end in End::BOTH {
        spawn(goal_frame(&pitch, end), sculpture::material(), Vec3::ZERO);
        let net = StandardMaterial {
            base_color: palette::CHALK.with_alpha(0.45),
            alpha_mode: AlphaMode::Blend,
            unlit: true,
            ..default()
        };
        spawn(net_lines(&net_panels(&pitch, end)), net, Vec3::ZERO);
    }
}

/// All line markings as one flat mesh that looks up.
fn lines(pitch: &Pitch) -> Mesh {
    let mut flat = FlatMesh::default();
    let half = pitch.line_width_m / 2.0;
    for segment in pitch.line_segments() {
        flat.strip(segment, half);
    }
    for mark in pitch.marks() {
        let reach = pitch.penalty_mark_size_m / 2.0;
        for along in [Vec2::X, Vec2::Y] {
            // The strip adds half a line's width at each end.
            let end = along * (reach - half).max(0.0);
            flat.strip(LineSegment { start: mark - end, end: mark + end }, half);
        }
    }
    flat.ring(pitch.centre_circle_diameter_m / 2.0, half);
    flat.finish()
}

/// Quadrilaterals on the ground.
#[derive(Default)]
struct FlatMesh {
    corners: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

impl FlatMesh {
    /// Four corners, counter-clockwise as seen from above.
    fn quadrilateral(&mut self, corners: [Vec2; 4]) {
        let first = self.corners.len() as u32;
        self.corners.extend(corners.map(|corner| [corner.x, corner.y, 0.0]));
        self.indices.extend([0, 1, 2, 0, 2, 3].map(|index| first + index));
    }

    /// A line of this half width, which also extends as much beyond both ends, so that corners are full.
    fn strip(&mut self, segment: LineSegment, half_width: f32) {
        let along = (segment.end - segment.start).normalize_or(Vec2::X) * half_width;
        let aside = along.perp();
        let (start, end) = (segment.start - along, segment.end + along);
        self.quadrilateral([start - aside, end - aside, end + aside, start + aside]);
    }

    /// A circle of this half width around the origin.
    fn ring(&mut self, radius: f32, half_width: f32) {
        let direction = |corner: u32| unit(TAU * (corner % CIRCLE_CORNERS) as f32 / CIRCLE_CORNERS as f32);
        let (inner, outer) = (radius - half_width, radius + half_width);
        for corner in 0..CIRCLE_CORNERS {
            let (here, next) = (direction(corner), direction(corner + 1));
            self.quadrilateral([inner * here, outer * here, outer * next, inner * next]);
        }
    }

    fn finish(self) -> Mesh {
        let count = self.corners.len();
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, self.corners)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; count])
            .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0, 0.0]; count])
            .with_inserted_indices(Indices::U32(self.indices))
    }
}

/// Corners of a goal's frame, m, pitch frame: the ends of the bar and of the rear bar on the ground, -y first.
fn goal_corners(pitch: &Pitch, end: End) -> ([Vec3; 2], [Vec3; 2]) {
    let GoalDimensions { width_m, height_m, depth_m, bar_diameter_m, .. } = pitch.goal;
    let front = end.sign() * pitch.goal_post_x();
    let rear = end.sign() * (pitch.goal_post_x() + depth_m);
    let half_bar = bar_diameter_m / 2.0;
    let bar = [-0.5, 0.5].map(|side| Vec3::new(front, side * width_m, height_m - half_bar));
    let ground = [-0.5, 0.5].map(|side| Vec3::new(rear, side * width_m, half_bar));
    (bar, ground)
}

/// The bar in the goal's colour, and the white frame behind that carries the net. Posts are things of their own.
fn goal_frame(pitch: &Pitch, end: End) -> Mesh {
    let (bar, ground) = goal_corners(pitch, end);
    let radius = pitch.goal.bar_diameter_m / 2.0;
    let post = |bar_end: Vec3| bar_end.with_z(ground[0].z);
    let length = pitch.goal.width_m;
    let along_y = upright((bar[0] + bar[1]) / 2.0).with_rotation(Quat::IDENTITY);
    let mut frame = Sculpture::default()
        .add(Cylinder::new(radius, length), palette::goal(pitch.goal_colour(end)), along_y)
        .rod(ground[0], ground[1], radius * 0.8, palette::CHALK);
    for side in 0..2 {
        frame = frame.rod(post(bar[side]), ground[side], radius * 0.8, palette::CHALK).rod(
            bar[side],
            ground[side],
            radius * 0.4,
            palette::CHALK,
        );
    }
    frame.finish()
}

/// The faces of a goal's net, m, pitch frame; a triangle has two equal corners.
fn net_panels(pitch: &Pitch, end: End) -> [[Vec3; 4]; 3] {
    let (bar, ground) = goal_corners(pitch, end);
    let foot = |bar_end: Vec3| bar_end.with_z(0.0);
    [
        [bar[0], bar[1], ground[1], ground[0]],
        [bar[0], bar[0], ground[0], foot(bar[0])],
        [bar[1], bar[1], ground[1], foot(bar[1])],
    ]
}

/// The strings of a net, as lines.
fn net_lines(panels: &[[Vec3; 4]]) -> Mesh {
    let mut ends: Vec<[f32; 3]> = Vec::new();
    for [a, b, c, d] in panels {
        let across = (a.distance(*b).max(c.distance(*d)) / NET_MESH).round().max(1.0) as u32;
        let down = (b.distance(*c).max(d.distance(*a)) / NET_MESH).round().max(1.0) as u32;
        for step in 0..=across {
            let share = step as f32 / across as f32;
            ends.extend([a.lerp(*b, share), d.lerp(*c, share)].map(|end| end.to_array()));
        }
        for step in 0..=down {
            let share = step as f32 / down as f32;
            ends.extend([a.lerp(*d, share), b.lerp(*c, share)].map(|end| end.to_array()));
        }
    }
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
        flat.strip(LineSegment { start: Vec2::new(1.0, 2.0), end: Vec2::new(-1.0, 0.5) }, 0.025);
        flat.ring(0.6, 0.025);
        for triangle in flat.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|index| Vec3::from(flat.corners[triangle[index] as usize]));
            assert!((b - a).cross(c - a).z > 0.0);
        }
    }

    #[test]
    fn a_strip_covers_its_corners() {
        let mut flat = FlatMesh::default();
        flat.strip(LineSegment { start: Vec2::ZERO, end: Vec2::X }, 0.1);
        let least = flat.corners.iter().fold(f32::MAX, |least, corner| least.min(corner[0]));
        let greatest = flat.corners.iter().fold(f32::MIN, |greatest, corner| greatest.max(corner[0]));
        assert_eq!([least, greatest], [-0.1, 1.1]);
    }

    #[test]
    fn nets_hang_between_bar_and_ground_behind_the_posts() {
        let pitch = Pitch::default();
        for end in End::BOTH {
            for corner in net_panels(&pitch, end).into_iter().flatten() {
                assert!(end.sign() * corner.x >= pitch.goal_post_x() - 1e-6);
                assert!((0.0..=pitch.goal.height_m).contains(&corner.z));
            }
        }
    }
}
