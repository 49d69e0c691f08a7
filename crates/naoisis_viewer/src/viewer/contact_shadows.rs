//! Soft shadows on the ground below robots and balls, where they keep the light of the hall away. They are drawn with
//! and without fine drawing, and show where a robot stands and how high a ball is.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use core::f32::consts::TAU;

use super::pitch_frame::PitchFrameSystems;
use super::shared::{RobotsWorld, shows_truth};
use naoisis_core::ball::{Ball, BallPhysics};
use naoisis_core::geometry::unit;
use naoisis_core::robot::body::Body;
use naoisis_core::team::RobotId;

/// The height of shadows above the carpet, m: above the lines.
const HEIGHT_M: f32 = 0.005;
/// The opacity in the middle of a shadow.
const DARKEST: f32 = 0.5;
/// Distances from the middle, as a share of the radius, and the shares of [`DARKEST`] there.
const RINGS: [(f32, f32); 4] = [(0.35, 0.85), (0.6, 0.45), (0.8, 0.15), (1.0, 0.0)];
/// The number of corners of a ring.
const CORNERS: u32 = 24;
/// The radius of shadows, as a multiple of the half width of a robot's torso and of the radius of a ball.
const ROBOT_RADIUS: f32 = 1.6;
const BALL_RADIUS: f32 = 1.5;

/// Adds shadows to robots and balls when these enter the match.
pub struct ContactShadowsPlugin;

impl Plugin for ContactShadowsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ShadowModel>()
            .add_observer(add_to_robot)
            .add_observer(add_to_ball)
            .add_systems(PostUpdate, keep_on_ground.after(PitchFrameSystems).before(TransformSystems::Propagate));
    }
}

/// A shadow, which is a child of the robot or ball.
#[derive(Component)]
struct ContactShadow;

/// The mesh of radius 1 and the material of all shadows.
#[derive(Resource)]
struct ShadowModel(Mesh3d, MeshMaterial3d<StandardMaterial>);

impl FromWorld for ShadowModel {
    fn from_world(world: &mut World) -> Self {
        let mesh = world.resource_mut::<Assets<Mesh>>().add(disc());
        let material = StandardMaterial { unlit: true, alpha_mode: AlphaMode::Blend, ..default() };
        let material = world.resource_mut::<Assets<StandardMaterial>>().add(material);
        Self(Mesh3d(mesh), MeshMaterial3d(material))
    }
}

impl ShadowModel {
    fn of_radius(&self, radius_m: f32) -> impl Bundle {
        let scale = Vec3::new(radius_m, radius_m, 1.0);
        let place = Transform::from_xyz(0.0, 0.0, HEIGHT_M).with_scale(scale);
        (ContactShadow, self.0.clone(), self.1.clone(), place)
    }
}

fn add_to_robot(added: On<Add, RobotId>, bodies: Query<&Body>, model: Res<ShadowModel>, mut commands: Commands) {
    if let Ok(body) = bodies.get(added.entity) {
        commands.spawn((ChildOf(added.entity), model.of_radius(ROBOT_RADIUS * body.torso.half_width_m)));
    }
}

fn add_to_ball(
    added: On<Add, BallPhysics>,
    balls: Query<&BallPhysics>,
    model: Res<ShadowModel>,
    mut commands: Commands,
) {
    if let Ok(physics) = balls.get(added.entity) {
        commands.spawn((ChildOf(added.entity), model.of_radius(BALL_RADIUS * physics.radius_m)));
    }
}

/// Leaves the shadow of a flying ball on the ground, and hides all shadows while only one robot's world is shown.
fn keep_on_ground(
    world: Option<Res<RobotsWorld>>,
    balls: Query<&Transform, (With<Ball>, Without<ContactShadow>)>,
    mut shadows: Query<(&ChildOf, &mut Transform, &mut Visibility), With<ContactShadow>>,
) {
    let wanted = if shows_truth(world) { Visibility::Inherited } else { Visibility::Hidden };
    for (of, place, mut visibility) in &mut shadows {
        visibility.set_if_neq(wanted);
        if let Ok(ball) = balls.get(of.parent()) {
            let height = HEIGHT_M - ball.translation.z;
            place.map_unchanged(|place| &mut place.translation.z).set_if_neq(height);
        }
    }
}

/// A black disc of radius 1 that is dark in the middle and transparent at its edge.
fn disc() -> Mesh {
    let mut corners = vec![[0.0; 3]];
    let mut colours = vec![[0.0, 0.0, 0.0, DARKEST]];
    for (radius, share) in RINGS {
        let ring = (0..CORNERS).map(|corner| radius * unit(TAU * corner as f32 / CORNERS as f32));
        corners.extend(ring.map(|corner| corner.extend(0.0).to_array()));
        colours.extend([[0.0, 0.0, 0.0, DARKEST * share]; CORNERS as usize]);
    }
    let at = |ring: u32, corner: u32| 1 + CORNERS * ring + corner % CORNERS;
    let middle = (0..CORNERS).flat_map(|corner| [0, at(0, corner), at(0, corner + 1)]);
    let between = (1..RINGS.len() as u32).flat_map(|ring| (0..CORNERS).map(move |corner| (ring, corner)));
    let indices = middle.chain(between.flat_map(|(ring, corner)| {
        let [a, b] = [at(ring - 1, corner), at(ring - 1, corner + 1)];
        let [c, d] = [at(ring, corner + 1), at(ring, corner)];
        [a, d, c, a, c, b]
    }));
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; corners.len()])
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners)
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours)
        .with_inserted_indices(Indices::U32(indices.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::mesh::VertexAttributeValues;

    #[test]
    fn all_triangles_of_a_shadow_face_up_and_cover_the_disc() {
        let mesh = disc();
        let Some(VertexAttributeValues::Float32x3(corners)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
            panic!("corners")
        };
        let indices: Vec<usize> = mesh.indices().unwrap().iter().collect();
        let areas = indices.chunks(3).map(|triangle| {
            let [a, b, c] = [0, 1, 2].map(|index| Vec3::from(corners[triangle[index]]));
            (b - a).cross(c - a).z / 2.0
        });
        let areas: Vec<f32> = areas.collect();
        assert!(areas.iter().all(|area| *area > 0.0));
        // The area of a regular polygon with so many corners.
        let polygon = 0.5 * CORNERS as f32 * unit(TAU / CORNERS as f32).y;
        assert!((areas.iter().sum::<f32>() - polygon).abs() < 1e-4);
    }
}
