//! The localisation methods that scenarios can choose.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The method by which a robot localises itself.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum LocalisationMethod {
    /// An extended Kalman filter, fast and exact; a lost robot searches with a particle filter.
    #[default]
    Kalman,
    /// An unscented Kalman filter, more exact under great uncertainty and about three times as costly; a lost robot searches with a particle
    /// filter.
    Unscented,
    /// A particle filter: several hypotheses at the same time, about ten times as costly.
    Particles,
}

/// The kind of a Kalman filter.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum KalmanFilter {
    /// Linearised at the mean.
    #[default]
    Extended,
    /// By sigma points around the mean.
    Unscented,
}
