//! What is told of episodes: what they began from, and what was counted in them.

use bevy::prelude::*;
use naoisis_core::team::PerTeam;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What an episode began from.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct EpisodeOrigin {
    /// The seed of its match.
    pub seed: u64,
    /// The index of its scenario among those that one is drawn from.
    pub scenario: usize,
    /// The values of the fields that are drawn, in their order.
    pub drawn: Vec<Value>,
}

/// An episode that has ended.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct EndedEpisode {
    /// What it began from.
    pub origin: EpisodeOrigin,
    /// What was counted, by name, if something was.
    pub counts: Vec<(&'static str, PerTeam<f64>)>,
}

/// Counts what happens in an episode.
pub trait EpisodeCounter: Send + Sync {
    /// Counts the last completed cycle.
    fn observe(&mut self, world: &World);
    /// Returns the counts up to now, by name.
    fn counts(&self) -> Vec<(&'static str, PerTeam<f64>)>;
}

/// Begins to count a match in its present state.
pub type BeginCounter = fn(&mut World) -> Box<dyn EpisodeCounter>;
