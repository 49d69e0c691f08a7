//! Messages between team-mates (paper, section 3.3).

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use crate::geometry::{Pose, file_units};
use crate::knowledge::Knowledge;
use crate::robot::RobotId;

/// The structure that a robot shares with its team-mates. Every part is optional. Places are in the frame that the
/// team agrees on; the built-in teams use the team frame.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TeamMessage {
    /// Where the sender thinks that it is.
    #[serde(with = "file_units::optional_pose", skip_serializing_if = "Option::is_none")]
    pub pose: Option<Pose>,
    /// Where it thinks that the ball is, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ball_m: Option<Vec2>,
    /// Where it thinks that other robots are, m.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub robots_m: Vec<Vec2>,
    /// What it is about to do, in a word.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub intention: Option<Cow<'static, str>>,
    /// Anything else, short.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub payload: Option<Cow<'static, str>>,
}

/// What the robot says in this cycle, if anything. None again after every cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct Outbox(pub Option<TeamMessage>);

/// A message that arrived.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct ReceivedMessage {
    /// Who sent it.
    pub from: RobotId,
    /// In which cycle.
    pub sent_cycle: u64,
    /// What it says.
    pub say: TeamMessage,
}

/// The messages that arrived in this cycle, ordered by sender.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
pub struct Inbox(pub Vec<ReceivedMessage>);

/// How messages travel.
#[derive(Resource, Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct MessageSettings {
    /// Probability that a recipient does not get a message, independently for each.
    pub loss: f32,
    /// Cycles from sending to arrival, at least 1.
    pub delay_cycles: u32,
}

impl Default for MessageSettings {
    fn default() -> Self {
        Self { loss: 0.0, delay_cycles: 1 }
    }
}
