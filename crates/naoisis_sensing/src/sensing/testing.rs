//! A small world for the tests of the sensors.

use bevy::prelude::*;

use super::camera::{CameraPlugin, CameraSettings};
use super::odometry::{OdometryPlugin, OdometrySettings};
use super::rendering::RenderingPlugin;
use super::sonar::{SonarNoise, SonarPlugin, SonarSettings};
use super::vision::{VisionNoise, VisionPlugin, VisionSettings};
use naoisis_core::ball::{Ball, BallPhysics};
use naoisis_core::cycle::{CyclePlugin, run_cycle};
use naoisis_core::geometry::{Pose, to_radians};
use naoisis_core::pitch::Post;
use naoisis_core::random::RandomStreams;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::motion::ExecutedStep;
use naoisis_core::team::{RobotId, Team};

/// A world with all sensors and nothing in it.
pub fn sensing_app() -> App {
    let mut app = App::new();
    app.add_plugins((CyclePlugin::default(), CameraPlugin, VisionPlugin, RenderingPlugin, SonarPlugin, OdometryPlugin));
    app
}

/// Sensors without any noise.
pub fn exact_sensors() -> (VisionSettings, SonarSettings, OdometrySettings) {
    (
        VisionSettings { noise: VisionNoise::none(), ..default() },
        SonarSettings { noise: SonarNoise::None, ..default() },
        OdometrySettings::exact(),
    )
}

/// A robot with exact sensors at `[x m, y m, heading deg]` and head at `[yaw deg, pitch deg]`.
pub fn spawn_robot(app: &mut App, team: Team, number: u8, pose: [f32; 3], head_deg: [f32; 2]) -> Entity {
    let id = RobotId::new(team, number);
    let [x, y, heading] = pose;
    let [yaw, pitch] = head_deg.map(to_radians);
    app.world_mut()
        .spawn((
            id,
            Pose::new(x, y, to_radians(heading)),
            Body::default(),
            HeadAngles { yaw, pitch },
            CameraSettings::default(),
            exact_sensors(),
            ExecutedStep::default(),
            RandomStreams::new(1, id),
        ))
        .id()
}

/// The ball at a place on the pitch, m.
pub fn spawn_ball(app: &mut App, x: f32, y: f32) -> Entity {
    app.world_mut().spawn((Ball, BallPhysics::default(), Pose::new(x, y, 0.0))).id()
}

/// A post, 10 cm thick and 80 cm high, at a place on the pitch, m.
pub fn spawn_post(app: &mut App, x: f32, y: f32, colour: Option<naoisis_core::pitch::GoalColour>) -> Entity {
    app.world_mut().spawn((Post { radius: 0.05, height: 0.8, colour }, Pose::new(x, y, 0.0))).id()
}

/// Runs one cycle, and returns a copy of the robot's component `C` after it.
pub fn sense<C: Component + Clone>(app: &mut App, robot: Entity) -> C {
    run_cycle(app.world_mut());
    app.world().get::<C>(robot).cloned().expect("the robot has this component")
}

/// Changes a component.
pub fn set<C: Component>(app: &mut App, entity: Entity, component: C) {
    app.world_mut().entity_mut(entity).insert(component);
}
