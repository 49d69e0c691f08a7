//! Odometry: where the robot's steps should have brought it.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::Pose;
use crate::knowledge::Knowledge;

/// The measured pose since the start of the match, in the frame of the robot's first pose (m, radians). It drifts,
/// and knows nothing of being carried.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
pub struct Odometry(pub Pose);
