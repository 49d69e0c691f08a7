//! The `messages` of a scenario file: how messages travel, and the limits on them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use naoisis_core::communication::{MessageLimits, MessageSettings};

/// The `messages` of a file.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "Messages")]
pub(super) struct MessagesForm {
    /// Probability that a recipient does not get a message, independently for each.
    #[schemars(range(min = 0.0, max = 1.0))]
    loss: f32,
    /// Cycles from sending to arrival; at least 1.
    #[schemars(range(min = 1, max = 1000))]
    delay_cycles: u32,
    /// Greatest additional delay, cycles; uniformly distributed.
    #[schemars(range(min = 0, max = 1000))]
    jitter_cycles: u32,
    /// Greatest distance between sender and recipient, m; none: unlimited.
    #[schemars(range(min = 0.0, max = 1000.0))]
    range_m: Option<f32>,
    /// Greatest length of the texts and the datagram in a message together, bytes.
    #[schemars(range(min = 0, max = 65_507))]
    max_text_bytes: u32,
    /// Messages that a team can send in a match, beyond which they are refused; none: unlimited.
    max_messages: Option<u32>,
    /// Bytes that a team can send in a match; none: unlimited.
    max_bytes: Option<u64>,
    /// The limits of robots without their own: those of their model.
    #[serde(skip_serializing_if = "MessageLimits::is_unset")]
    robots: MessageLimits,
}

impl Default for MessagesForm {
    fn default() -> Self {
        (MessageSettings::default(), MessageLimits::default()).into()
    }
}

impl From<(MessageSettings, MessageLimits)> for MessagesForm {
    fn from((settings, robots): (MessageSettings, MessageLimits)) -> Self {
        let MessageSettings { loss, delay_cycles, jitter_cycles, range_m, max_text_bytes, max_messages, max_bytes } =
            settings;
        Self { loss, delay_cycles, jitter_cycles, range_m, max_text_bytes, max_messages, max_bytes, robots }
    }
}

impl From<MessagesForm> for (MessageSettings, MessageLimits) {
    fn from(form: MessagesForm) -> Self {
        let MessagesForm {
            loss,
            delay_cycles,
            jitter_cycles,
            range_m,
            max_text_bytes,
            max_messages,
            max_bytes,
            robots,
        } = form;
        let settings =
            MessageSettings { loss, delay_cycles, jitter_cycles, range_m, max_text_bytes, max_messages, max_bytes };
        (settings, robots)
    }
}
