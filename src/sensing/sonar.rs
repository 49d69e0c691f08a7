//! The two sonars (paper, section 3.1 and Fig. 4).

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::{file_units, to_radians};
use crate::knowledge::Knowledge;

/// What the two sonars measured in this cycle, m; nothing in range is no reading.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
pub struct SonarReading {
    /// The left sonar's distance, m.
    pub left: Option<f32>,
    /// The right sonar's distance, m.
    pub right: Option<f32>,
}

/// The error of a measured distance.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SonarNoise {
    /// Exact distances.
    #[default]
    None,
    /// Normally distributed.
    Gaussian {
        /// Standard deviation, m.
        sd_m: f32,
    },
    /// Uniformly distributed.
    Uniform {
        /// Greatest deviation to either side, m.
        half_width_m: f32,
    },
    /// Normally distributed, now and then anywhere in the range.
    Outliers {
        /// Standard deviation of the good readings, m.
        sd_m: f32,
        /// Probability of a reading anywhere between minimum and maximum.
        probability: f32,
    },
}

/// Geometry and noise of a robot's sonars.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct SonarSettings {
    /// Least distance, m: 0.15 (paper, section 3.1).
    pub min_m: f32,
    /// Greatest distance, m: 0.75 (paper, section 3.1).
    pub max_m: f32,
    /// Direction of the left sonar, radians (degrees in files); the right one is mirrored: 19.48° (paper, Fig. 4b).
    #[serde(rename = "heading_deg", with = "file_units::degrees")]
    pub heading: f32,
    /// Half the opening of the sector, radians (degrees in files): 18° (paper, Fig. 4b).
    #[serde(rename = "half_angle_deg", with = "file_units::degrees")]
    pub half_angle: f32,
    /// Height above the ground, m: 0.40 (paper, Fig. 4b).
    pub height_m: f32,
    /// Error of the distance.
    pub noise: SonarNoise,
    /// Probability that an echo is missed.
    pub miss_probability: f32,
}

impl Default for SonarSettings {
    fn default() -> Self {
        Self {
            min_m: 0.15,
            max_m: 0.75,
            heading: to_radians(19.48),
            half_angle: to_radians(18.0),
            height_m: 0.40,
            noise: SonarNoise::Gaussian { sd_m: 0.01 },
            miss_probability: 0.0,
        }
    }
}
