//! Which filter localises a robot: what scenarios name.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// How a robot localises itself.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum LocalisationMethod {
    /// By an extended Kalman filter, quick and exact; a robot that has lost its way searches with particles.
    #[default]
    Kalman,
    /// By an unscented Kalman filter, more exact where little is certain and some three times as costly; a robot that has
    /// lost its way searches with particles.
    Unscented,
    /// By a particle filter: several hypotheses at a time, and some ten times as costly.
    Particles,
}

/// How a Kalman filter carries its estimate through steps and measurements.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum KalmanFilter {
    /// By slopes at its mean.
    #[default]
    Extended,
    /// By poses around its mean.
    Unscented,
}
