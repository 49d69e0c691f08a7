//! How a program is lost: in a word, and in a sentence.

use naoisis_core::events::AgentLoss;

/// Why there will be nothing more from a program.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{message}")]
pub struct Loss {
    /// In a word.
    pub reason: AgentLoss,
    /// In a sentence.
    pub message: String,
}

impl Loss {
    pub(super) fn new(reason: AgentLoss, message: impl Into<String>) -> Self {
        Self { reason, message: message.into() }
    }
}
