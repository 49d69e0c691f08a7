//! The reason for the loss of a program: its kind and a message.

use naoisis_core::events::AgentLoss;

/// The reason why a program no longer plays.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Loss {
    /// The kind of the reason.
    pub reason: AgentLoss,
    /// The reason in a sentence.
    pub message: String,
}

naoisis_core::debug_as_displayed!(Loss);

impl Loss {
    pub(super) fn new(reason: AgentLoss, message: impl Into<String>) -> Self {
        Self { reason, message: message.into() }
    }
}
