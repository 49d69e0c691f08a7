//! What a robot can know: its cameras, sonars, joints, steps and its own state.
//!
//! A sensor is two components of a robot: its settings, and its reading, which the settings require. One system fills
//! it, once a cycle. All sensors of all robots read the same instant, the start of the cycle, which is gathered for them in
//! the [`Scene`](crate::appearance::scene::Scene). Each page below says what a sensor measures, in which units and how often, with which
//! noise, and what the real NAO does.
//!
//! | sensor | settings | reading |
//! |---|---|---|
//! | [cameras](camera) | [`camera::CameraSettings`] | [`camera::CameraImages`], where they are rendered |
//! | [vision] | [`vision::VisionSettings`] | [`vision::Percepts`] |
//! | [sonar] | [`sonar::SonarSettings`] | [`sonar::SonarReading`] |
//! | [odometry] | [`odometry::OdometrySettings`] | [`odometry::Odometry`] |
//! | joints | | [`HeadAngles`](naoisis_core::robot::head::HeadAngles), exact to a tenth of a degree on the NAO |
//! | [status] | | [`status::BodyStatus`], [`GameStatus`](naoisis_core::referee::GameStatus) |
//! | [team messages](naoisis_core::communication) | [`MessageSettings`](naoisis_core::communication::MessageSettings) | [`Inbox`](naoisis_core::communication::Inbox) |
//!
//! What they say can be [late](latency).
//!
//! How true a sensor is can be chosen for each robot and sensor, in a scenario or at run time: see [`fidelity`]. The
//! behaviours' code does not change.

use bevy::prelude::*;

pub mod camera;
pub mod fidelity;
pub mod jobs;
pub mod latency;
pub mod odometry;
pub mod rendering;
pub mod scene;
pub mod sonar;
pub mod status;
pub mod vision;

/// All sensors.
pub struct SensingPlugin;

impl Plugin for SensingPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            scene::ScenePlugin,
            camera::CameraPlugin,
            vision::VisionPlugin,
            rendering::RenderingPlugin,
            sonar::SonarPlugin,
            odometry::OdometryPlugin,
            status::BodyStatusPlugin,
            latency::LatencyPlugin,
        ));
    }
}

#[cfg(test)]
pub mod testing;
