//! Why an episode cannot start.

use crate::agents::ProgramStartError;
use naoisis_sim::scenario::ScenarioFault;

/// Why an episode cannot start.
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// Its match cannot be started.
    #[error(transparent)]
    Scenario(#[from] ScenarioFault),
    /// The scenario is not valid with the values that were drawn for it.
    #[error("the values that were drawn make no scenario: {0}")]
    Drawn(String),
    /// The simulator cannot continue from its moment.
    #[error("{0}")]
    Moment(String),
    /// A program that plays cannot be started.
    #[error(transparent)]
    Program(#[from] ProgramStartError),
    /// The match of the episode differs from the one that the environment was made for.
    #[error("an episode cannot start: {0}")]
    Different(String),
}

naoisis_core::debug_as_displayed!(StartError);
