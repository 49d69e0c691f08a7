//! Matches as environments for reinforcement learning: agents with arrays of observations and actions, and rewards.
//!
//! [Observations](observation), [actions](action) and [rewards](reward) are defined by lists of named entries, which
//! also fill the arrays. Named tasks are [challenges](challenge), and [`attempts`] measures success rates.
//! [`Environments`] steps many worlds together. The Python package wraps these types.

pub mod action;
mod attempt_error;
pub mod attempts;
pub mod challenge;
pub mod demonstrations;
mod ending;
pub mod entry;
pub(crate) mod episode;
mod gaze;
pub mod observation;
mod player;
mod recorded_commands;
pub mod results;
pub mod reward;
mod same;
mod saved;
mod situation;
mod vector;

pub use action::ActionKind;
pub use challenge::Challenge;
pub use ending::EpisodeProgress;
pub use entry::ObservationEntry;
pub use episode::{EnvironmentSettings, Episode, Start, StartError};
pub use observation::ObservationKind;
pub use reward::RewardWeights;
pub use saved::SavedWorld;
pub use vector::{Arrays, AutoReset, EnvironmentError, Environments};
