//! The whole state of environments, to go on from later: the same episodes, number by number.

use naoisis_core::random::RandomStream;
use naoisis_sim::scenario::SavedMatchError;
use naoisis_sim::simulation::{Snapshot, SnapshotError};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

use super::counts::EpisodeOrigin;
use super::ending::{Course, EpisodeProgress};
use super::episode::Start;
use super::memory::Memory;
use super::reward::Standing;
use super::vector::Environments;

/// The state of one world.
#[derive(Clone, PartialEq, Debug)]
pub struct SavedWorld {
    /// Its match, as the bytes of a [`Snapshot`]; `None` before its first episode.
    pub snapshot: Option<Vec<u8>>,
    /// The rest of the episode, in MessagePack.
    pub episode: Vec<u8>,
}

#[derive(Serialize, Deserialize)]
struct SavedEpisode {
    seeds: RandomStream,
    memories: Vec<Memory>,
    standings: Vec<Standing>,
    progress: EpisodeProgress,
    course: Course,
    origin: EpisodeOrigin,
}

impl Environments {
    /// The state of each world. What a reset has changed of its [start](super::Episode::start) is not in it.
    ///
    /// # Errors
    /// When a match cannot be saved.
    pub fn save(&mut self) -> Result<Vec<SavedWorld>, SnapshotError> {
        let encode = |saved: &SavedEpisode| rmp_serde::to_vec(saved).map_err(|error| error.to_string());
        let worlds = self.episodes.iter_mut().zip(&self.has_begun);
        worlds
            .map(|(episode, has_begun)| {
                let world = &mut episode.world;
                let snapshot = if *has_begun { Some(Snapshot::take(world)?.to_bytes(world)?) } else { None };
                let saved = SavedEpisode {
                    seeds: episode.seeds.clone(),
                    memories: episode.memories.clone(),
                    standings: episode.standings.clone(),
                    progress: episode.progress,
                    course: episode.course,
                    origin: episode.origin.clone(),
                };
                Ok(SavedWorld { snapshot, episode: encode(&saved).map_err(SnapshotError::NotEncoded)? })
            })
            .collect()
    }

    /// Goes on from the state of each world of environments with the same settings.
    ///
    /// # Errors
    /// When it is the state of something else; then all worlds need a reset.
    pub fn restore(&mut self, saved: &[SavedWorld]) -> Result<(), SnapshotError> {
        self.has_begun.fill(false);
        if saved.len() != self.episodes.len() {
            let message = format!("there are {} worlds; expected {}", saved.len(), self.episodes.len());
            return Err(SavedMatchError::Content(message).into());
        }
        let settings = &self.settings;
        for (episode, world) in self.episodes.iter_mut().zip(saved) {
            let state: SavedEpisode = rmp_serde::from_slice(&world.episode)
                .map_err(|error| SavedMatchError::Content(format!("this is no episode: {error}")))?;
            if let Some(bytes) = &world.snapshot {
                Snapshot::from_bytes(bytes, &episode.world)?.restore(&mut episode.world)?;
                episode.set_senses(settings);
                // What was counted before is not saved, and a part of an episode is not counted.
                episode.counter = None;
            }
            episode.seeds = state.seeds;
            episode.memories = state.memories;
            episode.standings = state.standings;
            episode.progress = state.progress;
            episode.course = state.course;
            episode.origin = state.origin;
        }
        for (has_begun, world) in self.has_begun.iter_mut().zip(saved) {
            *has_begun = world.snapshot.is_some();
        }
        Ok(())
    }

    /// Lets the worlds with these indices begin their next episodes from `start`, until their next reset.
    pub fn set_start(&mut self, indices: &[usize], start: &Arc<Start>) {
        for index in indices {
            if let Some(episode) = self.episodes.get_mut(*index) {
                episode.start = Some(Arc::clone(start));
            }
        }
    }
}
