//! The content of a message, and its size.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use super::datagram::Datagram;
use crate::geometry::{Pose, file_units};

/// Greatest distance from the origin of a position in a message, m. Messages with others are refused.
pub const FARTHEST_M: f32 = 1000.0;

/// Greatest number of robots in a message. Messages with more are refused.
pub const MOST_ROBOTS: usize = 64;

/// The structure that a robot shares with its team-mates. Every part is optional. Positions are in a frame that the team agrees
/// on; the built-in teams use the team frame.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TeamMessage {
    /// The sender's belief of its own pose.
    #[serde(with = "file_units::optional_pose", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f32; 3]>")]
    pub pose: Option<Pose>,
    /// The sender's belief of the ball's position, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f32; 2]>")]
    pub ball_m: Option<Vec2>,
    /// The sender's belief of the positions of other robots, m.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(with = "Vec<[f32; 2]>")]
    pub robots_m: Vec<Vec2>,
    /// The sender's intention in a word.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub intention: Option<Cow<'static, str>>,
    /// Any other short text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub payload: Option<Cow<'static, str>>,
    /// A message in the format of the team's program: base64.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub datagram: Option<Datagram>,
}

impl TeamMessage {
    /// The size of the message on the air, bytes: 4 for every number, the texts and the datagram, and one byte for each part that is
    /// present except the datagram.
    pub fn size_bytes(&self) -> usize {
        let TeamMessage { pose, ball_m, robots_m, intention, payload, datagram: _ } = self;
        let numbers = 3 * usize::from(pose.is_some()) + 2 * usize::from(ball_m.is_some()) + 2 * robots_m.len();
        let parts = [pose.is_some(), ball_m.is_some(), !robots_m.is_empty(), intention.is_some(), payload.is_some()];
        4 * numbers + self.text_bytes() + parts.into_iter().filter(|&is_there| is_there).count()
    }

    /// The total length of its texts and its datagram, bytes.
    pub fn text_bytes(&self) -> usize {
        let texts = [&self.intention, &self.payload].into_iter().flatten().map(|text| text.len());
        texts.chain(self.datagram.iter().map(|datagram| datagram.0.len())).sum()
    }

    /// Whether every position is within [`FARTHEST_M`] along both axes, and there are at most [`MOST_ROBOTS`].
    pub(crate) fn is_in_range(&self) -> bool {
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
