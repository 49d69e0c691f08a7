//! The head: two joints with limits and a speed.
//!
//! The paper's Table 1(b) prints the labels of yaw and pitch swapped: the NAO's head turns ±120° (yaw) and nods
//! from -35° (up) to +30° (down). Those are the defaults here.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::{file_units, to_radians};
use crate::knowledge::Knowledge;

/// Measured joint angles of the head.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
pub struct HeadAngles {
    /// Counter-clockwise (to the left), radians.
    pub yaw: f32,
    /// Downwards, radians.
    pub pitch: f32,
}

/// The angles that the head moves towards, as fast as it can. Stays until it is changed.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct HeadCommand {
    /// Counter-clockwise (to the left), radians; beyond the limit it is clamped.
    pub yaw: f32,
    /// Downwards, radians; beyond the limit it is clamped.
    pub pitch: f32,
}

/// Limits of the head's joints.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct HeadLimits {
    /// Least and greatest yaw, radians (degrees in files). Default ±120° (paper, Table 1b, labels corrected).
    #[serde(rename = "yaw_deg", with = "file_units::degree_pair")]
    pub yaw: [f32; 2],
    /// Least and greatest pitch, radians (degrees in files). Default -35°..+30° (same table).
    #[serde(rename = "pitch_deg", with = "file_units::degree_pair")]
    pub pitch: [f32; 2],
    /// Speed of each joint, rad/s (degrees per second in files). Default 300: the NAO V3.2's joints reach 474
    /// (yaw) and 412 (pitch) unloaded.
    #[serde(rename = "max_degps", with = "file_units::degrees")]
    pub max_speed: f32,
}

impl Default for HeadLimits {
    fn default() -> Self {
        Self {
            yaw: [-120.0, 120.0].map(to_radians),
            pitch: [-35.0, 30.0].map(to_radians),
            max_speed: to_radians(300.0),
        }
    }
}
