//! What a message says, and how much that is on the air.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use super::datagram::Datagram;
use crate::geometry::{Pose, file_units};

/// Places farther than this from the origin are no places, m: a message with one is refused.
pub const FARTHEST_M: f32 = 1000.0;

/// More robots than these are in no match: a message that tells of more is refused.
pub const MOST_ROBOTS: usize = 64;

/// The structure that a robot shares with its team-mates. Every part is optional. Places are in the frame that the
/// team agrees on; the built-in teams use the team frame.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TeamMessage {
    /// Where the sender thinks that it is.
    #[serde(with = "file_units::optional_pose", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f32; 3]>")]
    pub pose: Option<Pose>,
    /// Where it thinks that the ball is, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f32; 2]>")]
    pub ball_m: Option<Vec2>,
    /// Where it thinks that other robots are, m.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(with = "Vec<[f32; 2]>")]
    pub robots_m: Vec<Vec2>,
    /// What it is about to do, in a word.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub intention: Option<Cow<'static, str>>,
    /// Anything else, short.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub payload: Option<Cow<'static, str>>,
    /// A message as a league's programs send it, which only the team understands: base64.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub datagram: Option<Datagram>,
}

impl TeamMessage {
    /// What the message would take on the air, bytes: 4 for every number, the texts and the datagram, and one byte for each
    /// part that is there beside a datagram.
    pub fn size_bytes(&self) -> usize {
        let TeamMessage { pose, ball_m, robots_m, intention, payload, datagram: _ } = self;
        let numbers = 3 * usize::from(pose.is_some()) + 2 * usize::from(ball_m.is_some()) + 2 * robots_m.len();
        let parts = [pose.is_some(), ball_m.is_some(), !robots_m.is_empty(), intention.is_some(), payload.is_some()];
        4 * numbers + self.text_bytes() + parts.into_iter().filter(|&is_there| is_there).count()
    }

    /// The length of its texts and its datagram, bytes.
    pub fn text_bytes(&self) -> usize {
        let texts = [&self.intention, &self.payload].into_iter().flatten().map(|text| text.len());
        texts.chain(self.datagram.iter().map(|datagram| datagram.0.len())).sum()
    }

    /// Whether every place in it is within range along both axes, as no pitch reaches so far, and there are no more than [`MOST_ROBOTS`].
    pub fn is_in_range(&self) -> bool {
        let places = self.pose.iter().map(|pose| pose.position).chain(self.ball_m).chain(self.robots_m.iter().copied());
        self.robots_m.len() <= MOST_ROBOTS && places.map(Vec2::abs).all(|place| place.max_element() <= FARTHEST_M)
    }

    /// Whether every number in it is finite.
    pub fn is_finite(&self) -> bool {
        self.pose.is_none_or(Pose::is_finite)
            && self.ball_m.is_none_or(Vec2::is_finite)
            && self.robots_m.iter().all(|place| place.is_finite())
    }
}
