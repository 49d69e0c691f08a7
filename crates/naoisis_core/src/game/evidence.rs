//! Why the referee decided as it did: every verdict carries its evidence.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use crate::team::RobotId;

/// The evidence for a verdict.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct Evidence {
    /// The rule in one sentence.
    pub rule: Cow<'static, str>,
    /// Where it happened, m, pitch frame.
    pub position_m: Vec2,
    /// Where the ball was, m, pitch frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ball_m: Option<Vec2>,
    /// The robots concerned.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub robots: Vec<RobotEvidence>,
    /// What was measured, and the limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<Measurement>,
    /// What would have changed the verdict.
    pub otherwise: Cow<'static, str>,
}

/// A robot as it was when the verdict was given.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct RobotEvidence {
    /// The robot.
    pub robot: RobotId,
    /// Where it was, m, pitch frame.
    pub position_m: Vec2,
    /// How fast it wanted to walk, m/s.
    pub speed_mps: f32,
}

/// A quantity that decided.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct Measurement {
    /// What, with its unit.
    pub what: Cow<'static, str>,
    /// Its value, in that unit.
    pub value: f32,
    /// Where the rule draws the line, in the same unit.
    pub limit: f32,
}

impl Evidence {
    /// Adds a robot.
    #[must_use]
    pub fn with_robot(mut self, robot: RobotEvidence) -> Self {
        self.robots.push(robot);
        self
    }

    /// Adds what was measured.
    #[must_use]
    pub fn with_measurement(mut self, what: &'static str, value: f32, limit: f32) -> Self {
        self.measured = Some(Measurement { what: Cow::Borrowed(what), value, limit });
        self
    }

    /// Adds what would have changed the verdict.
    #[must_use]
    pub fn otherwise(mut self, otherwise: impl Into<Cow<'static, str>>) -> Self {
        self.otherwise = otherwise.into();
        self
    }
}
