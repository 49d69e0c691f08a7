//! The sensors of a robot: cameras, sonars, joints, odometry and its own state.
//!
//! A sensor is two components of a robot: its settings, and its reading, which the settings require. One system updates the reading, once a
//! cycle. All sensors of all robots measure the same instant, the start of the cycle, whose state is gathered in the
//! [`Scene`](crate::appearance::scene::Scene). Each module below documents what a sensor measures, its units, rate and noise, and the real
//! NAO.
//!
//! | sensor | settings | reading |
//! |---|---|---|
//! | [cameras](camera) | [`camera::CameraSettings`] | [`camera::CameraImages`], where they are rendered |
//! | [vision] | [`vision::VisionSettings`] | [`vision::Percepts`] |
//! | [sonar] | [`sonar::SonarSettings`] | [`sonar::SonarReading`] |
//! | [odometry] | [`odometry::OdometrySettings`] | [`odometry::Odometry`] |
//! | joints | | [`HeadAngles`](naoisis_core::robot::head::HeadAngles), exact to a tenth of a degree on the NAO |
//! | [status] | | [`status::BodyStatus`], [`GameStatus`](naoisis_core::referee::GameStatus) |
//! | [imu], where a scenario has it | [`imu::Imu`] | [`imu::ImuReading`] |
//! | [buttons], where a scenario has them | [`buttons::Buttons`] | [`buttons::ButtonReadings`] |
//! | [team messages](naoisis_core::communication) | [`MessageSettings`] | [`Inbox`] |
//!
//! Readings can be [delayed](naoisis_core::robot::latency).
//!
//! [`MessageSettings`]: naoisis_core::communication::MessageSettings
//! [`Inbox`]: naoisis_core::communication::Inbox
//!
//! The fidelity of each sensor of each robot can be chosen in a scenario or at run time: see [`fidelity`]. The code of behaviours does not
//! change.

use bevy::prelude::*;

pub mod buttons;
pub mod camera;
pub mod fidelity;
pub mod imu;
pub mod jobs;
pub mod latency;
pub mod odometry;
pub mod rendering;
pub mod scene;
pub mod sonar;
pub mod status;
pub mod vision;

/// Registers all sensors.
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
            latency::ReadingLatencyPlugin,
        ));
    }
}

#[cfg(test)]
pub mod testing;
