//! The pitch frame in Bevy's world, the light, and smooth motion between cycles.
//!
//! In the simulation z points up, in Bevy y. The pitch root carries the one rotation between the two; robots, ball,
//! posts, camera and light are its children and all use the pitch frame. `Pose` is the truth; `Transform` follows it,
//! for display only.

use bevy::camera::Exposure;
use bevy::light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap};
use bevy::prelude::*;
use bevy::render::render_resource::ShaderType;
use core::f32::consts::{FRAC_PI_2, PI};

use super::palette;
use super::shared::{DisplayFraction, DrawnWhenSensed};
use naoisis_core::ball::flight::BallFlight;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Penalty;
use naoisis_core::geometry::{Pose, angle_of, wrap_angle};
use naoisis_core::robot::PreviousPose;
use naoisis_sim::simulation::MatchEntity;

/// The greatest speed on a pitch, m/s. A larger displacement means that an object was placed.
const FASTEST_MPS: f32 = 12.0;
/// The light from one side, lux, and the direction to it, m, pitch frame.
const SUN_LUX: f32 = 4_800.0;
const SUN_M: Vec3 = Vec3::new(-3.0, -4.0, 9.0);
/// The light from all sides, cd/m².
const AMBIENT: f32 = 700.0;

/// Spawns the pitch root, light and sky, and makes simulated entities children of the pitch root.
pub struct PitchFramePlugin;

impl Plugin for PitchFramePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<PitchRoot>()
            .init_resource::<DrawnWhenSensed>()
            .insert_resource(ClearColor(palette::HALL))
            .insert_resource(GlobalAmbientLight { brightness: AMBIENT, color: palette::SKY, ..default() })
            .insert_resource(DirectionalLightShadowMap { size: 2048 })
            .add_observer(enter_stage)
            .add_systems(Startup, light_stage)
            .add_systems(
                PostUpdate,
                (place_entities, hide_penalised).in_set(PitchFrameSystems).before(TransformSystems::Propagate),
            );
    }
}

/// The systems that set the displayed transforms.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PitchFrameSystems;

/// The entity whose children are in the pitch frame.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug)]
pub struct PitchRoot(pub Entity);

impl FromWorld for PitchRoot {
    fn from_world(world: &mut World) -> Self {
        let root = (Name::new("pitch"), Transform::from_rotation(world_from_pitch()), Visibility::default());
        Self(world.spawn(root).id())
    }
}

/// Returns the rotation from the pitch frame (z up) to Bevy's world (y up).
pub fn world_from_pitch() -> Quat {
    Quat::from_rotation_x(-FRAC_PI_2)
}

/// Returns the rotation from Bevy's world (y up) to the pitch frame (z up).
pub fn pitch_from_world() -> Quat {
    world_from_pitch().inverse()
}

/// The light of the hall for shaders that compute it themselves, with the exposure of the camera.
#[derive(Clone, Copy, PartialEq, Debug, ShaderType)]
pub struct HallLight {
    /// The light from all sides that a matt surface sends back, as a multiple of its colour.
    ambient: LinearRgba,
    /// The light of the sun that a matt surface facing it sends back, as a multiple of its colour.
    direct: LinearRgba,
    /// The direction to the sun, in Bevy's world.
    to_sun: Vec4,
}

impl Default for HallLight {
    fn default() -> Self {
        let exposure = Exposure::default().exposure();
        Self {
            ambient: (LinearRgba::from(palette::SKY) * AMBIENT * exposure).with_alpha(1.0),
            direct: (LinearRgba::WHITE * (SUN_LUX / PI * exposure)).with_alpha(0.0),
            to_sun: (world_from_pitch() * SUN_M.normalize()).extend(0.0),
        }
    }
}

fn light_stage(mut commands: Commands, root: Res<PitchRoot>) {
    let shadows = CascadeShadowConfigBuilder { num_cascades: 2, maximum_distance: 20.0, ..default() };
    commands.spawn((
        ChildOf(root.0),
        DirectionalLight { illuminance: SUN_LUX, shadow_maps_enabled: true, ..default() },
        shadows.build(),
        Transform::from_translation(SUN_M).looking_at(Vec3::ZERO, Vec3::Z),
    ));
}

/// Adds an entity that enters the match to the pitch frame.
fn enter_stage(added: On<Add, MatchEntity>, poses: Query<&Pose>, root: Res<PitchRoot>, mut commands: Commands) {
    let transform = poses.get(added.entity).map(|pose| transform_of(*pose)).unwrap_or_default();
    commands.entity(added.entity).insert((ChildOf(root.0), transform, Visibility::default()));
}

fn place_entities(
    (fraction, when_sensed): (Res<DisplayFraction>, Res<DrawnWhenSensed>),
    clock: Res<CycleClock>,
    mut entities: Query<(&Pose, Option<&PreviousPose>, Option<&BallFlight>, &mut Transform), With<MatchEntity>>,
) {
    let fraction = if when_sensed.0 { 0.0 } else { fraction.0 };
    for (pose, previous, flight, mut transform) in &mut entities {
        let shown = previous.map_or(*pose, |previous| between(previous.0, *pose, fraction, clock.period()));
        let mut place = transform_of(shown);
        place.translation.z = flight.map_or(0.0, |flight| flight.height_m);
        transform.set_if_neq(place);
    }
}

/// Hides penalised robots.
fn hide_penalised(mut robots: Query<(&Penalty, &mut Visibility), Changed<Penalty>>) {
    for (penalty, mut visibility) in &mut robots {
        *visibility = if penalty.is_off_pitch() { Visibility::Hidden } else { Visibility::Inherited };
    }
}

/// Returns the displayed pose, pitch frame.
pub fn pose_of(transform: &Transform) -> Pose {
    let forward = transform.rotation * Vec3::X;
    Pose { position: transform.translation.truncate(), heading: angle_of(forward.truncate()) }
}

pub(super) fn transform_of(pose: Pose) -> Transform {
    Transform::from_translation(pose.position.extend(0.0)).with_rotation(Quat::from_rotation_z(pose.heading))
}

/// Interpolates a pose at a fraction of a cycle of `period` seconds. Objects that were placed jump at once.
pub fn between(start: Pose, end: Pose, fraction: f32, period: f32) -> Pose {
    if start.position.distance(end.position) > FASTEST_MPS * period {
        return end;
    }
    Pose {
        position: start.position.lerp(end.position, fraction),
        heading: start.heading + fraction * wrap_angle(end.heading - start.heading),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use bevy::ecs::system::RunSystemOnce;
    use core::f32::consts::PI;

    #[test]
    fn the_pitch_lies_flat_with_the_yellow_goal_to_the_right() {
        let world_from_pitch = world_from_pitch();
        assert!((world_from_pitch * Vec3::Z).abs_diff_eq(Vec3::Y, 1e-6));
        assert!((world_from_pitch * Vec3::X).abs_diff_eq(Vec3::X, 1e-6));
        // The direction away from the viewer, who looks along -z.
        assert!((world_from_pitch * Vec3::Y).abs_diff_eq(Vec3::NEG_Z, 1e-6));
    }

    #[test]
    fn through_a_camera_everything_is_where_it_was_when_the_robots_sensed() {
        let mut world = World::new();
        world.init_resource::<DisplayFraction>();
        world.insert_resource(CycleClock { period_s: 1.0 / 30.0, ..default() });
        let poses = (Pose::new(0.1, 0.0, 0.2), PreviousPose(Pose::default()));
        let robot = world.spawn((MatchEntity, poses, Transform::default())).id();
        for (when_sensed, expected) in [(false, poses.0), (true, Pose::default())] {
            world.insert_resource(DrawnWhenSensed(when_sensed));
            world.run_system_once(place_entities).unwrap();
            let shown = pose_of(world.get(robot).unwrap());
            assert_abs_diff_eq!(shown.position.x, expected.position.x, epsilon = 1e-6);
            assert_abs_diff_eq!(shown.heading, expected.heading, epsilon = 1e-6);
        }
    }

    #[test]
    fn motion_is_smooth_across_the_half_turn() {
        let shown = between(Pose::new(0.0, 0.0, PI - 0.1), Pose::new(0.1, 0.0, 0.1 - PI), 0.5, 1.0 / 30.0);
        // Half of 0.1 m, and half of the angle of 0.2 rad across ±180°.
        assert_abs_diff_eq!(shown.position.x, 0.05, epsilon = 1e-6);
        assert_abs_diff_eq!(shown.heading, PI, epsilon = 1e-6);
    }

    #[test]
    fn what_is_put_elsewhere_does_not_fly_there() {
        // At 12 m/s the robot would move 0.4 m in 1/30 s.
        let end = Pose::new(3.0, 0.0, 0.0);
        assert_eq!(between(Pose::default(), end, 0.5, 1.0 / 30.0), end);
    }
}
