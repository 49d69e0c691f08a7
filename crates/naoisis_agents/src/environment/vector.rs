//! Many worlds that are stepped together, on several threads.

use bevy::prelude::*;
use core::sync::atomic::{AtomicBool, Ordering};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::thread;

use super::action::NotAnAction;
use super::counts::{EndedEpisode, EpisodeOrigin};
use super::entry::ObservationEntry;
use super::episode::{EnvironmentSettings, Episode, Start};
use super::mask::mask;
use super::observation::entries;
use super::same::{check_same, image_bytes};
use super::start_error::StartError;
use super::state::{state, state_entries};

/// When a world starts the next episode after the end of one.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum AutoReset {
    /// In its next step, which does nothing else.
    #[default]
    NextStep,
    /// In the step that ends the episode.
    SameStep,
    /// Only when it is reset.
    Disabled,
}

/// The arrays that a step fills: one row for each agent of each world, world by world.
#[derive(Debug)]
pub struct Arrays<'a> {
    /// The observations.
    pub observations: &'a mut [f32],
    /// The images, row by row of pixels; empty if no camera is observed.
    pub images: &'a mut [u8],
    /// The rewards.
    pub rewards: &'a mut [f32],
    /// Whether the task has ended.
    pub terminations: &'a mut [bool],
    /// Whether the time limit has ended the episode.
    pub truncations: &'a mut [bool],
    /// Whether the task was a success of the agent's team.
    pub successes: &'a mut [bool],
    /// The last observations of finished episodes if the next one starts in the same step; else empty.
    pub final_observations: &'a mut [f32],
    /// The last images of finished episodes, like `final_observations`.
    pub final_images: &'a mut [u8],
    /// The true state of each world, not of each agent, before a finished episode is followed by the next one; empty if it is not wanted.
    pub final_states: &'a mut [f32],
}

/// Why worlds cannot be stepped or reset.
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EnvironmentError {
    /// An episode cannot start.
    #[error(transparent)]
    Start(#[from] StartError),
    /// A row is not a valid action.
    #[error("row {row}: {error}")]
    Action {
        /// The row, from 0.
        row: usize,
        /// The fault of the action.
        error: NotAnAction,
    },
    /// The episode of a world is over.
    #[error("the episode of world {world} is over, or has not begun; expected a reset before the next step")]
    Over {
        /// The world, from 0.
        world: usize,
    },
    /// The step was broken off.
    #[error("the step was broken off; expected a reset before the next one")]
    Stopped,
    /// A world panicked; its next reset creates it again.
    #[error("world {world} panicked: {message}; the other worlds were stepped")]
    Panicked {
        /// The world, from 0.
        world: usize,
        /// The message of the panic.
        message: String,
    },
}

naoisis_core::debug_as_displayed!(EnvironmentError);

/// Worlds that are stepped together. Results do not depend on the number of threads.
pub struct Environments {
    pub(super) settings: EnvironmentSettings,
    simulator: fn() -> World,
    pub(super) episodes: Vec<Episode>,
    /// Whether each world may be stepped.
    pub(super) has_begun: Vec<bool>,
    stop: Arc<AtomicBool>,
    auto_reset: AutoReset,
    threads: usize,
    entries: Vec<ObservationEntry>,
    state_entries: Vec<ObservationEntry>,
    image_bytes: usize,
}

/// One world with its part of the arrays.
struct Part<'a> {
    index: usize,
    episode: &'a mut Episode,
    has_begun: &'a mut bool,
    actions: &'a [f32],
    arrays: Arrays<'a>,
}

impl Environments {
    /// Creates `worlds` worlds. Each has episodes with its own seeds; those of the first world start with `seed`.
    ///
    /// # Errors
    /// If the match cannot be started.
    pub fn new(
        settings: EnvironmentSettings,
        simulator: fn() -> World,
        worlds: usize,
        auto_reset: AutoReset,
        threads: usize,
    ) -> Result<Self, StartError> {
        let mut episodes: Vec<Episode> =
            (0..worlds.max(1)).map(|index| Episode::new(simulator(), index as u64)).collect();
        let stop = Arc::<AtomicBool>::default();
        episodes.iter_mut().for_each(|episode| episode.stop = Arc::clone(&stop));
        let first = &mut episodes[0];
        first.begin(&settings)?;
        let entries = settings.control.first().map(|id| entries(settings.observed, &first.world, *id));
        let state_entries = state_entries(&first.world);
        let image_bytes = if settings.camera.is_some() { image_bytes(&first.world) } else { 0 };
        let has_begun = vec![false; episodes.len()];
        let entries = entries.unwrap_or_default();
        Ok(Self {
            settings,
            simulator,
            episodes,
            has_begun,
            stop,
            auto_reset,
            threads,
            entries,
            state_entries,
            image_bytes,
        })
    }

    /// The settings that all worlds share.
    pub fn settings(&self) -> &EnvironmentSettings {
        &self.settings
    }

    /// The number of worlds.
    pub fn worlds(&self) -> usize {
        self.episodes.len()
    }

    /// The number of rows of the arrays: one for each agent of each world.
    pub fn rows(&self) -> usize {
        self.episodes.len() * self.settings.control.len()
    }

    /// The entries of an observation.
    pub fn entries(&self) -> &[ObservationEntry] {
        &self.entries
    }

    /// The entries of the state of a world.
    pub fn state_entries(&self) -> &[ObservationEntry] {
        &self.state_entries
    }

    /// Widens the ranges of the entries of an observation to those of `others`, for episodes whose robots have other ranges. Returns false, and
    /// changes nothing, if they have other names.
    pub fn widen(&mut self, others: &[ObservationEntry]) -> bool {
        let is_same = |(own, other): (&ObservationEntry, &ObservationEntry)| own.to_string() == other.to_string();
        if self.entries.len() != others.len() || !self.entries.iter().zip(others).all(is_same) {
            return false;
        }
        for (entry, other) in self.entries.iter_mut().zip(others) {
            entry.low = entry.low.min(other.low);
            entry.high = entry.high.max(other.high);
        }
        true
    }

    /// Returns what the episode of a world began from. Returns `None` if there is no such world.
    pub fn origin(&self, world: usize) -> Option<&EpisodeOrigin> {
        self.episodes.get(world).map(|episode| &episode.origin)
    }

    /// Returns the episode of a world that ended in the last step. Returns `None` if it goes on.
    pub fn ended(&self, world: usize) -> Option<&EndedEpisode> {
        self.episodes.get(world)?.ended.as_ref()
    }

    /// Returns for each choice of the next actions of all agents whether it has an effect, agent by agent, list by list. A continuous action has
    /// no choices.
    pub fn action_masks(&self) -> Vec<bool> {
        let space = self.settings.actions();
        let of_world = |episode: &Episode| {
            self.settings.control.iter().flat_map(|id| mask(space, &episode.world, *id)).collect::<Vec<_>>()
        };
        self.episodes.iter().flat_map(of_world).collect()
    }

    /// The number of bytes of an image.
    pub fn image_bytes(&self) -> usize {
        self.image_bytes
    }

    /// The world with this index.
    pub fn world_mut(&mut self, index: usize) -> Option<&mut World> {
        self.episodes.get_mut(index).map(|episode| &mut episode.world)
    }

    /// A flag that breaks off the step under way when it becomes true. The next step begins with it false.
    pub fn stop(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    /// Fills `array` with the true state of each world, world by world.
    pub fn state(&self, array: &mut [f32]) {
        for (episode, part) in self.episodes.iter().zip(array.chunks_mut(self.state_entries.len().max(1))) {
            state(part, &episode.world);
        }
    }

    /// Starts an episode in the worlds of the mask, or in all, and fills in their observations. With `seed`, the worlds get consecutive
    /// seeds from it; otherwise each continues its own sequence. The episodes start from `start` until the next reset; without it, from the
    /// start in the settings. The first of these episodes has the match of `match_seed`, if it is given.
    ///
    /// # Errors
    /// If a match cannot be started, or differs from the one that the environment was made for.
    pub fn reset(
        &mut self,
        seed: Option<u64>,
        mask: Option<&[bool]>,
        start: Option<&Arc<Start>>,
        match_seed: Option<u64>,
        arrays: Arrays,
    ) -> Result<(), EnvironmentError> {
        let (settings, simulator) = (&self.settings, self.simulator);
        let (entries, state_entries, image_bytes) = (&self.entries, &self.state_entries, self.image_bytes);
        let parts = parts(&mut self.episodes, &mut self.has_begun, &[], arrays);
        let parts = parts.into_iter().filter(|part| mask.is_none_or(|mask| mask.get(part.index) == Some(&true)));
        each(self.threads, parts.collect(), |part| {
            if let Some(seed) = seed {
                part.episode.seed(seed.wrapping_add(part.index as u64));
            }
            part.episode.start = start.cloned();
            part.episode.match_seed = match_seed;
            guarded(part, simulator, |part| {
                *part.has_begun = false;
                part.episode.ended = None;
                part.episode.begin(settings)?;
                if start.is_some() {
                    check_same(settings, &part.episode.world, entries, state_entries, image_bytes)?;
                }
                *part.has_begun = true;
                part.episode.observe(settings, part.arrays.observations, part.arrays.images);
                Ok(())
            })
        })
    }

    /// Plays a step of all worlds with the actions of all agents, row by row.
    ///
    /// # Errors
    /// When an action is invalid or an episode is over; then nothing has happened. When a world panics; then the others
    /// have been stepped. When the step is [broken off](Self::stop); then all worlds need a reset.
    pub fn step(&mut self, actions: &[f32], arrays: Arrays) -> Result<(), EnvironmentError> {
        let settings = &self.settings;
        let space = settings.actions();
        for (row, action) in actions.chunks(space.len()).enumerate() {
            space.check(action).map_err(|error| EnvironmentError::Action { row, error })?;
        }
        let auto_reset = self.auto_reset;
        let waits = |(begun, episode): (&bool, &Episode)| {
            !begun || (auto_reset == AutoReset::Disabled && episode.progress.is_over())
        };
        if let Some(world) = self.has_begun.iter().zip(&self.episodes).position(waits) {
            return Err(EnvironmentError::Over { world });
        }
        let simulator = self.simulator;
        self.stop.store(false, Ordering::Relaxed);
        let parts = parts(&mut self.episodes, &mut self.has_begun, actions, arrays);
        let stepped =
            each(self.threads, parts, |part| guarded(part, simulator, |part| step(settings, auto_reset, part)));
        if self.stop.load(Ordering::Relaxed) {
            self.has_begun.fill(false);
            return Err(EnvironmentError::Stopped);
        }
        stepped
    }
}

/// Plays a step of one world.
fn step(settings: &EnvironmentSettings, auto_reset: AutoReset, part: &mut Part) -> Result<(), EnvironmentError> {
    let Part { episode, actions, arrays, .. } = part;
    let begins = auto_reset == AutoReset::NextStep && episode.progress.is_over();
    if begins {
        episode.ended = None;
        episode.begin(settings)?;
        arrays.rewards.fill(0.0);
    } else {
        episode.step(settings, actions, arrays.rewards);
    }
    let progress = episode.progress;
    arrays.terminations.fill(progress.terminated);
    arrays.truncations.fill(progress.truncated);
    for (success, id) in arrays.successes.iter_mut().zip(&settings.control) {
        *success = progress.success_of[id.team];
    }
    if !arrays.final_states.is_empty() {
        state(arrays.final_states, &episode.world);
    }
    if auto_reset == AutoReset::SameStep && progress.is_over() {
        episode.observe(settings, arrays.final_observations, arrays.final_images);
        episode.begin(settings)?;
    }
    episode.observe(settings, arrays.observations, arrays.images);
    Ok(())
}

/// Calls a function with a world, and replaces the world if the function panics.
fn guarded(
    mut part: Part,
    simulator: fn() -> World,
    act: impl Fn(&mut Part) -> Result<(), EnvironmentError>,
) -> Result<(), EnvironmentError> {
    catch_unwind(AssertUnwindSafe(|| act(&mut part))).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let message = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        part.episode.world = simulator();
        *part.has_begun = false;
        Err(EnvironmentError::Panicked { world: part.index, message })
    })
}

/// Each world with its part of the arrays.
fn parts<'a>(
    episodes: &'a mut [Episode],
    has_begun: &'a mut [bool],
    mut actions: &'a [f32],
    mut arrays: Arrays<'a>,
) -> Vec<Part<'a>> {
    let worlds = episodes.len();
    let parts = episodes.iter_mut().zip(has_begun).enumerate().map(|(index, (episode, has_begun))| {
        let left = worlds - index;
        Part {
            index,
            episode,
            has_begun,
            actions: actions.split_off(..actions.len() / left).unwrap_or_default(),
            arrays: Arrays {
                observations: first(&mut arrays.observations, left),
                images: first(&mut arrays.images, left),
                rewards: first(&mut arrays.rewards, left),
                terminations: first(&mut arrays.terminations, left),
                truncations: first(&mut arrays.truncations, left),
                successes: first(&mut arrays.successes, left),
                final_observations: first(&mut arrays.final_observations, left),
                final_images: first(&mut arrays.final_images, left),
                final_states: first(&mut arrays.final_states, left),
            },
        }
    });
    parts.collect()
}

/// Splits off the first of `parts` equal parts of an array. An array that was not requested has empty parts.
fn first<'a, T>(array: &mut &'a mut [T], parts: usize) -> &'a mut [T] {
    array.split_off_mut(..array.len() / parts).unwrap_or_default()
}

/// Calls a function with each part, on several threads. Returns the error of the first part that has one.
fn each<'a>(
    threads: usize,
    mut parts: Vec<Part<'a>>,
    act: impl Fn(Part<'a>) -> Result<(), EnvironmentError> + Sync,
) -> Result<(), EnvironmentError> {
    let share = parts.len().div_ceil(threads.max(1)).max(1);
    if parts.len() <= share {
        return all(parts, &act);
    }
    thread::scope(|scope| {
        let mut others = Vec::new();
        while parts.len() > share {
            let rest = parts.split_off(share);
            let own = core::mem::replace(&mut parts, rest);
            let act = &act;
            others.push(scope.spawn(move || all(own, act)));
        }
        let last = all(parts, &act);
        let mut result = Ok(());
        for other in others {
            // A panic in a part is caught there.
            result = result.and(other.join().unwrap_or(Ok(())));
        }
        result.and(last)
    })
}

/// Calls a function with each part, and continues after errors.
fn all<'a>(
    parts: Vec<Part<'a>>,
    act: &impl Fn(Part<'a>) -> Result<(), EnvironmentError>,
) -> Result<(), EnvironmentError> {
    let mut result = Ok(());
    for part in parts {
        let done = act(part);
        result = result.and(done);
    }
    result
}
