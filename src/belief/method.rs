//! What scenarios name of the localisation: which filter does it.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// How a robot localises itself.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Localisation {
    /// By an extended Kalman filter, quick and exact; a robot that has lost its way searches with particles.
    #[default]
    Kalman,
    /// By an unscented Kalman filter, more exact where little is certain and some three times as costly; a robot that has
    /// lost its way searches with particles.
    Unscented,
    /// By a particle filter: several ideas at a time, and some ten times as costly.
    Particles,
}
