//! Matches as environments for learning: agents that observe arrays, act by arrays, and are rewarded.
//!
//! What agents [observe](observation), [do](action) and are [rewarded](reward) for is made of lists with names, which also fill the
//! arrays; named tasks are [challenges](challenge), and [`attempts`] measures how often they succeed; many worlds are stepped together by [`Environments`]. The Python package
//! wraps these.

pub mod action;
pub mod attempts;
pub mod challenge;
pub mod entry;
mod episode;
mod gaze;
pub mod observation;
pub mod reward;
mod vector;

pub use action::ActionKind;
pub use challenge::Challenge;
pub use entry::ObservationEntry;
pub use episode::{EnvironmentSettings, Episode, EpisodeProgress, Start, StartError};
pub use observation::ObservationKind;
pub use reward::RewardWeights;
pub use vector::{Arrays, AutoReset, EnvironmentError, Environments};
