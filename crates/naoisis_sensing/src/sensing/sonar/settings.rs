//! The geometry and the noise of a robot's sonars.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{SonarPings, SonarReading};
use naoisis_core::geometry::{file_units, to_radians};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::random::RandomStream;

/// The source of a robot's sonar readings.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum SonarSource {
    /// The echoes in the sector.
    #[default]
    Echo,
    /// Exact and at any distance in the sector, for debugging.
    Truth,
}

/// The error of a measured distance. Files may also say `"default"`: [`SonarNoise::DEFAULT`].
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", from = "SonarNoiseForm")]
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
    /// Normally distributed, with some readings anywhere in the range.
    Outliers {
        /// Standard deviation of the good readings, m.
        sd_m: f32,
        /// Probability of a reading anywhere between minimum and maximum.
        probability: f32,
    },
}

/// The form of a [`SonarNoise`] in files.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum SonarNoiseForm {
    /// Exact distances.
    None,
    /// Normally distributed, 1 cm.
    Default,
    /// Normally distributed.
    Gaussian {
        /// Standard deviation, m.
        #[schemars(range(min = 0.0, max = 10.0))]
        sd_m: f32,
    },
    /// Uniformly distributed.
    Uniform {
        /// Greatest deviation to either side, m.
        #[schemars(range(min = 0.0, max = 10.0))]
        half_width_m: f32,
    },
    /// Normally distributed, with some readings anywhere in the range.
    Outliers {
        /// Standard deviation of the good readings, m.
        #[schemars(range(min = 0.0, max = 10.0))]
        sd_m: f32,
        /// Probability of a reading anywhere between minimum and maximum.
        #[schemars(range(min = 0.0, max = 1.0))]
        probability: f32,
    },
}

impl From<SonarNoiseForm> for SonarNoise {
    fn from(form: SonarNoiseForm) -> Self {
        match form {
            SonarNoiseForm::None => SonarNoise::None,
            SonarNoiseForm::Default => SonarNoise::DEFAULT,
            SonarNoiseForm::Gaussian { sd_m } => SonarNoise::Gaussian { sd_m },
            SonarNoiseForm::Uniform { half_width_m } => SonarNoise::Uniform { half_width_m },
            SonarNoiseForm::Outliers { sd_m, probability } => SonarNoise::Outliers { sd_m, probability },
        }
    }
}

impl SonarNoise {
    /// The noise of [`SonarSettings::default`]: 1 cm, normally distributed.
    pub const DEFAULT: SonarNoise = SonarNoise::Gaussian { sd_m: 0.01 };

    /// Adds the error to a true distance. The result is not clamped to the range from `min` to `max`, m.
    pub fn perturb(self, distance: f32, [min, max]: [f32; 2], stream: &mut RandomStream) -> f32 {
        match self {
            SonarNoise::None => distance,
            SonarNoise::Gaussian { sd_m } => distance + stream.gaussian(sd_m),
            SonarNoise::Uniform { half_width_m } => distance + half_width_m * (2.0 * stream.uniform() - 1.0),
            SonarNoise::Outliers { sd_m, probability } => {
                if stream.chance(probability) {
                    min + (max - min) * stream.uniform()
                } else {
                    distance + stream.gaussian(sd_m)
                }
            }
        }
    }
}

/// Geometry and noise of a robot's sonars.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[require(SonarReading, SonarPings)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct SonarSettings {
    /// Whether the robot has sonars.
    pub fitted: bool,
    /// The source of the readings.
    pub source: SonarSource,
    /// Least distance, m: 0.15 (paper, section 3.1).
    #[schemars(range(min = 0.0, max = 10.0))]
    pub min_m: f32,
    /// Greatest distance, m: 0.75 (paper, section 3.1).
    pub max_m: f32,
    /// Direction of the left sonar, radians (degrees in files); the right one is mirrored: 19.48° (paper, Fig. 4b).
    #[serde(rename = "heading_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = -180.0, max = 180.0))]
    pub heading: f32,
    /// Half the opening of the sector, radians (degrees in files): 18° (paper, Fig. 4b).
    #[serde(rename = "half_angle_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.1, max = 90.0))]
    pub half_angle: f32,
    /// Height above the ground, m: 0.40 (paper, Fig. 4b).
    #[schemars(range(min = 0.0, max = 2.0))]
    pub height_m: f32,
    /// Error of the distance.
    pub noise: SonarNoise,
    /// Probability that an echo is missed.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub miss_probability: f32,
    /// Rate of the pings, Hz; `None` for one in each cycle.
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub rate_hz: Option<f32>,
    /// Probability that a sonar mistakes a ping of another robot that faces it for an echo.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub crosstalk_probability: f32,
}

impl Default for SonarSettings {
    fn default() -> Self {
        Self {
            fitted: true,
            source: SonarSource::Echo,
            min_m: 0.15,
            max_m: 0.75,
            heading: to_radians(19.48),
            half_angle: to_radians(18.0),
            height_m: 0.40,
            noise: SonarNoise::DEFAULT,
            miss_probability: 0.0,
            rate_hz: None,
            crosstalk_probability: 0.0,
        }
    }
}
