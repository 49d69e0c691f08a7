//! Matches as environments for reinforcement learning: agents with arrays of observations and actions, and rewards.
//!
//! [Observations](observation), [actions](action) and [rewards](reward) are defined by lists of named entries, which
//! also fill the arrays. Named tasks are [challenges](challenge), and [`attempts`] measures success rates.
//! [`Environments`] steps many worlds together. The Python package wraps these types.

pub mod action;
pub mod action_space;
pub mod attempt;
mod attempt_error;
pub mod attempts;
pub mod challenge;
pub mod counts;
pub mod demonstrations;
mod draws;
mod ending;
pub mod entry;
pub(crate) mod episode;
pub mod extras;
mod gaze;
pub(crate) mod heard;
pub mod kind;
mod mask;
pub(crate) mod memory;
pub mod observation;
mod player;
mod prepared;
mod recorded_commands;
pub mod results;
pub mod reward;
mod same;
mod saved;
mod situation;
mod start_error;
pub mod state;
mod tracks;
mod vector;

pub use action::ActionKind;
pub use action_space::ActionSpace;
pub use challenge::Challenge;
pub use draws::{Draw, DrawnScenarios, DrawnValues};
pub use ending::EpisodeProgress;
pub use entry::ObservationEntry;
pub use episode::{EnvironmentSettings, Episode, Start};
pub use extras::Extras;
pub use kind::{ObservationForm, ObservationKind, Others};
pub use reward::RewardWeights;
pub use saved::SavedWorld;
pub use start_error::StartError;
pub use vector::{Arrays, AutoReset, EnvironmentError, Environments};
