//! Limits of the messages of a robot and its team.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{MessageSettings, TeamMessage, TeamMessageStatistics};
use crate::events::Refusal;
use crate::knowledge::Knowledge;

/// The message limits of a robot, from its model, its team or itself. The smaller of these and the [limits](MessageSettings) of the match
/// apply.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct MessageLimits {
    /// Greatest total length of the texts and the datagram in a message, bytes; by default that of the match.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 65_507))]
    pub max_text_bytes: Option<u32>,
    /// Number of messages of the team in a match beyond which the robot sends none; by default that of the match.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_messages: Option<u32>,
    /// Number of bytes of the team in a match beyond which the robot sends none; by default that of the match.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_bytes: Option<u64>,
}

impl MessageLimits {
    /// The names of the fields in files.
    pub const FIELDS: [&'static str; 3] = ["max_text_bytes", "max_messages", "max_bytes"];

    /// Whether there is no limit.
    pub fn is_unset(&self) -> bool {
        *self == Self::default()
    }

    /// How many messages a team that has `sent` messages may still send; `None` if unlimited.
    pub fn messages_left(&self, sent: u32) -> Option<u32> {
        self.max_messages.map(|most| most.saturating_sub(sent))
    }

    /// Why a robot whose team has sent the messages `sent` may not send `message`; `None` if it may.
    pub fn refusal(&self, message: &TeamMessage, sent: &TeamMessageStatistics) -> Option<Refusal> {
        let is_too_long = self.max_text_bytes.is_some_and(|most| message.text_bytes() > most as usize);
        let size = message.size_bytes() as u64;
        if !message.is_finite() {
            Some(Refusal::NotFinite)
        } else if !message.is_in_range() || is_too_long {
            Some(Refusal::TooLarge)
        } else if self.max_messages.is_some_and(|most| sent.sent >= most)
            || self.max_bytes.is_some_and(|most| sent.sent_bytes + size > most)
        {
            Some(Refusal::BudgetSpent)
        } else {
            None
        }
    }
}

impl MessageSettings {
    /// The smaller of these limits and those of a robot.
    pub fn limits_with(&self, own: &MessageLimits) -> MessageLimits {
        MessageLimits {
            max_text_bytes: smaller(Some(self.max_text_bytes), own.max_text_bytes),
            max_messages: smaller(self.max_messages, own.max_messages),
            max_bytes: smaller(self.max_bytes, own.max_bytes),
        }
    }
}

fn smaller<T: Ord>(one: Option<T>, other: Option<T>) -> Option<T> {
    one.into_iter().chain(other).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smaller_of_a_match_and_a_robot_limit_counts() {
        let settings = MessageSettings { max_text_bytes: 128, max_messages: Some(10), ..default() };
        let limits = |own: MessageLimits| {
            let MessageLimits { max_text_bytes, max_messages, max_bytes } = settings.limits_with(&own);
            (max_text_bytes, max_messages, max_bytes)
        };
        assert_eq!(limits(MessageLimits::default()), (Some(128), Some(10), None));
        let more = MessageLimits { max_text_bytes: Some(512), max_messages: Some(100), max_bytes: Some(9) };
        assert_eq!(limits(more), (Some(128), Some(10), Some(9)));
        let less = MessageLimits { max_text_bytes: Some(64), max_messages: Some(0), max_bytes: None };
        assert_eq!(limits(less), (Some(64), Some(0), None));
    }
}
