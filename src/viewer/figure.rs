//! Robots: a NAO of simple shapes with the team's waistband and a number.
//!
//! The joints are where a NAO's are (Aldebaran's documentation of the V4: hips at 0.248 m, thigh 0.100 m, shank 0.1029 m,
//! ankle 0.0452 m above the ground, shoulders at (0, ±0.098, 0.4335) m with the neck at 0.4595 m).

use bevy::prelude::*;

use super::palette;
use super::sculpture::{self, Sculpture};
use crate::robot::{RobotId, Team};
use crate::sensing::camera::model::NECK;

/// The left hip in the robot frame, m; the right one mirrored.
pub const HIP: Vec3 = Vec3::new(0.0, 0.05, 0.2481);
/// From hip to knee, m.
pub const THIGH: f32 = 0.1;
/// From knee to ankle, m.
pub const SHANK: f32 = 0.1029;
/// The left shoulder in the robot frame, m; the right one mirrored.
pub const SHOULDER: Vec3 = Vec3::new(0.0, 0.098, 0.4335);
/// From the ankle to the sole, m.
const ANKLE_HEIGHT: f32 = 0.0452;

/// Shows robots as they come into the match.
pub struct FigurePlugin;

impl Plugin for FigurePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<FigureParts>().add_observer(show_robot);
    }
}

/// The parts of a robot's figure that move.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug)]
pub struct Figure {
    /// The head, about the neck.
    pub head: Entity,
    /// Left and right leg.
    pub legs: [Leg; 2],
    /// Left and right arm, about the shoulders.
    pub arms: [Entity; 2],
}

/// The parts of a leg, each a child of the one before.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Leg {
    /// About the hip.
    pub thigh: Entity,
    /// About the knee.
    pub shank: Entity,
    /// About the ankle.
    pub foot: Entity,
}

/// The meshes that all robots share.
#[derive(Resource)]
struct FigureParts {
    material: Handle<StandardMaterial>,
    /// Blue, pink.
    trunks: [Handle<Mesh>; 2],
    head: Handle<Mesh>,
    /// Left, right.
    arms: [Handle<Mesh>; 2],
    thigh: Handle<Mesh>,
    shank: Handle<Mesh>,
    /// Left, right.
    feet: [Handle<Mesh>; 2],
}

impl FromWorld for FigureParts {
    fn from_world(world: &mut World) -> Self {
        let material = world.resource_mut::<Assets<StandardMaterial>>().add(sculpture::material());
        let mut meshes = world.resource_mut::<Assets<Mesh>>();
        Self {
            material,
            trunks: Team::BOTH.map(|team| meshes.add(trunk(team))),
            head: meshes.add(head()),
            arms: [1.0, -1.0].map(|side| meshes.add(arm(side))),
            thigh: meshes.add(thigh()),
            shank: meshes.add(shank()),
            feet: [1.0, -1.0].map(|side| meshes.add(foot(side))),
        }
    }
}

fn show_robot(
    added: On<Add, RobotId>,
    ids: Query<&RobotId>,
    parts: Res<FigureParts>,
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    let Ok(id) = ids.get(added.entity) else { return };
    let mut spawn = |parent: Entity, mesh: &Handle<Mesh>, place: Vec3| {
        commands
            .spawn((
                ChildOf(parent),
                Mesh3d(mesh.clone()),
                MeshMaterial3d(parts.material.clone()),
                Transform::from_translation(place),
            ))
            .id()
    };
    let robot = added.entity;
    spawn(robot, &parts.trunks[id.team as usize], Vec3::ZERO);
    spawn(robot, &meshes.add(number(id.number)), Vec3::ZERO);
    let head = spawn(robot, &parts.head, NECK);
    let arms = [0, 1].map(|side| spawn(robot, &parts.arms[side], on_side(SHOULDER, side)));
    let legs = [0, 1].map(|side| {
        let thigh = spawn(robot, &parts.thigh, on_side(HIP, side));
        let shank = spawn(thigh, &parts.shank, Vec3::NEG_Z * THIGH);
        let foot = spawn(shank, &parts.feet[side], Vec3::NEG_Z * SHANK);
        Leg { thigh, shank, foot }
    });
    commands.entity(robot).insert(Figure { head, legs, arms });
}

/// A point of the left side, or its mirror image on the right.
fn on_side(left: Vec3, side: usize) -> Vec3 {
    if side == 0 { left } else { left * Vec3::new(1.0, -1.0, 1.0) }
}

/// A place for a round shape along z, wider than deep.
fn flattened(centre: Vec3, depth_per_width: f32) -> Transform {
    // The shape's own x and z lie along the robot's x and y once it stands upright.
    sculpture::upright(centre).with_scale(Vec3::new(depth_per_width, 1.0, 1.0))
}

fn trunk(team: Team) -> Mesh {
    let band = palette::team(team);
    let cone = |radius_bottom, radius_top, height| ConicalFrustum { radius_bottom, radius_top, height };
    Sculpture::default()
        // Pelvis, waist, chest, collar.
        .cuboid(Vec3::new(0.075, 0.13, 0.055), Vec3::new(0.0, 0.0, 0.258), palette::JOINT)
        .add(cone(0.066, 0.074, 0.075), band, flattened(Vec3::new(0.0, 0.0, 0.315), 0.72))
        .add(cone(0.072, 0.088, 0.085), palette::SHELL, flattened(Vec3::new(0.0, 0.0, 0.392), 0.68))
        .add(cone(0.088, 0.045, 0.022), palette::SHELL, flattened(Vec3::new(0.0, 0.0, 0.4455), 0.68))
        .upright_cylinder(0.022, 0.03, Vec3::new(0.0, 0.0, 0.463), palette::JOINT)
        // Plates for the number, front and back.
        .cuboid(Vec3::new(0.012, 0.088, 0.074), Vec3::new(PLATE_X - 0.006, 0.0, PLATE_Z), band)
        .cuboid(Vec3::new(0.012, 0.088, 0.074), Vec3::new(0.006 - PLATE_X, 0.0, PLATE_Z), band)
        .finish()
}

/// Where the number's plates are: ±x of their surface and z of their middle, m, robot frame.
const PLATE_X: f32 = 0.062;
const PLATE_Z: f32 = 0.392;

/// A head about the neck.
fn head() -> Mesh {
    let middle = Vec3::new(0.0, 0.0, 0.055);
    let skull = Transform::from_translation(middle).with_scale(Vec3::new(0.98, 1.08, 0.92));
    let mut head = Sculpture::default()
        .add(Sphere::new(0.058), palette::SHELL, skull)
        // The cameras in forehead and chin.
        .ball(0.008, middle + Vec3::new(0.052, 0.0, 0.024), palette::JOINT)
        .ball(0.008, middle + Vec3::new(0.051, 0.0, -0.024), palette::JOINT);
    for side in [-1.0, 1.0] {
        let ear = Transform::from_translation(middle + Vec3::new(-0.004, side * 0.058, 0.0));
        head = head.add(Cylinder::new(0.03, 0.018), palette::JOINT, ear).ball(
            0.0135,
            middle + Vec3::new(0.0465, side * 0.024, 0.006),
            palette::EYE,
        );
    }
    head.finish()
}

/// An arm about the shoulder, bent at the elbow; `side` is 1 for the left one.
fn arm(side: f32) -> Mesh {
    let elbow = Vec3::new(0.0, side * 0.022, -0.098);
    let wrist = Vec3::new(0.062, side * 0.012, -0.142);
    Sculpture::default()
        .ball(0.036, Vec3::ZERO, palette::SHELL)
        .rod(Vec3::new(0.0, side * 0.008, -0.01), elbow, 0.025, palette::SHELL)
        .ball(0.028, elbow, palette::JOINT)
        .rod(elbow, wrist, 0.022, palette::SHELL)
        .ball(0.023, wrist + Vec3::new(0.016, 0.0, -0.01), palette::JOINT)
        .finish()
}

/// A thigh about the hip.
fn thigh() -> Mesh {
    Sculpture::default()
        .ball(0.04, Vec3::ZERO, palette::JOINT)
        .rod(Vec3::NEG_Z * 0.018, Vec3::NEG_Z * (THIGH - 0.02), 0.038, palette::SHELL)
        .finish()
}

/// A shank about the knee.
fn shank() -> Mesh {
    Sculpture::default()
        .ball(0.036, Vec3::ZERO, palette::JOINT)
        .rod(Vec3::NEG_Z * 0.02, Vec3::NEG_Z * (SHANK - 0.03), 0.035, palette::SHELL)
        .finish()
}

/// A foot about the ankle; `side` is 1 for the left one.
fn foot(side: f32) -> Mesh {
    let height = 0.036;
    let centre = Vec3::new(0.028, side * 0.003, height / 2.0 - ANKLE_HEIGHT);
    Sculpture::default()
        .ball(0.03, Vec3::ZERO, palette::JOINT)
        .cuboid(Vec3::new(0.118, 0.084, height), centre, palette::SHELL)
        .upright_cylinder(0.042, height, centre + Vec3::X * 0.059, palette::SHELL)
        .finish()
}

/// Which of a digit's seven segments are lit: top, upper left, upper right, middle, lower left, lower right, bottom.
const SEGMENTS: [[u8; 7]; 10] = [
    [1, 1, 1, 0, 1, 1, 1],
    [0, 0, 1, 0, 0, 1, 0],
    [1, 0, 1, 1, 1, 0, 1],
    [1, 0, 1, 1, 0, 1, 1],
    [0, 1, 1, 1, 0, 1, 0],
    [1, 1, 0, 1, 0, 1, 1],
    [1, 1, 0, 1, 1, 1, 1],
    [1, 0, 1, 0, 0, 1, 0],
    [1, 1, 1, 1, 1, 1, 1],
    [1, 1, 1, 1, 0, 1, 1],
];

/// A jersey number on the plates of chest and back.
fn number(number: u8) -> Mesh {
    /// Half width and half height of a digit between the middles of its segments, m.
    const HALF: Vec2 = Vec2::new(0.011, 0.022);
    /// Thickness of the segments, m.
    const STROKE: f32 = 0.009;
    let digits = number.to_string();
    let spacing = 0.036_f32.min(0.075 / digits.len() as f32);
    // Centre and whether it lies, of each segment; x to the reader's right.
    let places = [
        (Vec2::new(0.0, 1.0), true),
        (Vec2::new(-1.0, 0.5), false),
        (Vec2::new(1.0, 0.5), false),
        (Vec2::new(0.0, 0.0), true),
        (Vec2::new(-1.0, -0.5), false),
        (Vec2::new(1.0, -0.5), false),
        (Vec2::new(0.0, -1.0), true),
    ];
    let mut mesh = Sculpture::default();
    for (index, digit) in digits.bytes().enumerate() {
        let middle = (index as f32 - (digits.len() - 1) as f32 / 2.0) * spacing;
        let lit = SEGMENTS[usize::from(digit - b'0')];
        for ((place, lies), _) in places.iter().zip(lit).filter(|(_, lit)| *lit == 1) {
            let size = if *lies { Vec2::new(2.0 * HALF.x, 0.0) } else { Vec2::new(0.0, HALF.y) } + STROKE;
            let right = middle + place.x * HALF.x;
            let height = PLATE_Z + place.y * HALF.y;
            // Whoever reads the chest has the robot's left, +y, on the right.
            for facing in [1.0, -1.0] {
                mesh = mesh.cuboid(
                    Vec3::new(0.002, size.x, size.y),
                    Vec3::new(facing * (PLATE_X + 0.0005), facing * right, height),
                    palette::CHALK,
                );
            }
        }
    }
    mesh.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::camera::primitives::MeshAabb;

    #[test]
    fn a_robot_stands_on_the_ground() {
        let sole = foot(1.0).compute_aabb().map(|bounds| Vec3::from(bounds.min()).z).unwrap();
        let ankle = HIP.z - THIGH - SHANK;
        assert!((ankle + sole).abs() < 1e-4, "{}", ankle + sole);
    }

    #[test]
    fn a_robot_is_as_high_as_a_nao() {
        let top = head().compute_aabb().map(|bounds| Vec3::from(bounds.max()).z).unwrap();
        // Aldebaran: 573 mm.
        assert!((NECK.z + top - 0.573).abs() < 0.01, "{}", NECK.z + top);
    }

    #[test]
    fn numbers_are_on_chest_and_back() {
        let vertices = |id| number(id).count_vertices();
        // A box has 24 vertices, a 1 two segments, an 8 seven; twice for chest and back.
        assert_eq!([vertices(1), vertices(8)], [2 * 2 * 24, 2 * 7 * 24]);
        assert_eq!(vertices(18), vertices(1) + vertices(8));
    }
}
