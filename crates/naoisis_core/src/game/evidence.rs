//! The evidence that every decision of the referee carries.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use crate::team::RobotId;

/// The evidence for a decision.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct Evidence {
    /// The rule in one sentence.
    pub rule: Cow<'static, str>,
    /// Position of the offence, m, pitch frame.
    pub position_m: Vec2,
    /// Position of the ball, m, pitch frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ball_m: Option<Vec2>,
    /// The robots concerned.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub robots: Vec<RobotEvidence>,
    /// The measured quantity and its limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<Measurement>,
    /// What would have changed the decision.
    pub otherwise: Cow<'static, str>,
}

/// The state of a robot when the decision was made.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct RobotEvidence {
    /// The robot.
    pub robot: RobotId,
    /// Its position, m, pitch frame.
    pub position_m: Vec2,
    /// Speed of its intended walk, m/s.
    pub speed_mps: f32,
}

/// The quantity that the decision depends on.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct Measurement {
    /// The quantity with its unit.
    pub what: Cow<'static, str>,
    /// Its value, in that unit.
    pub value: f32,
    /// The limit of the rule, in the same unit.
    pub limit: f32,
}

impl Evidence {
    /// Adds a robot.
    #[must_use]
    pub fn with_robot(mut self, robot: RobotEvidence) -> Self {
        self.robots.push(robot);
        self
    }

    /// Adds the measured quantity.
    #[must_use]
    pub fn with_measurement(mut self, what: &'static str, value: f32, limit: f32) -> Self {
        self.measured = Some(Measurement { what: Cow::Borrowed(what), value, limit });
        self
    }

    /// Adds what would have changed the decision.
    #[must_use]
    pub fn otherwise(mut self, otherwise: impl Into<Cow<'static, str>>) -> Self {
        self.otherwise = otherwise.into();
        self
    }
}
