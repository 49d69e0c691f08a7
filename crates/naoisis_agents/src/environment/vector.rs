//! Many worlds in step, on several threads.

use bevy::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::thread;

use super::action::NotAnAction;
use super::entry::ObservationEntry;
use super::episode::{EnvironmentSettings, Episode, Start, StartError};
use super::observation::{entries, state, state_entries};
use crate::agents::remote_robots;
use naoisis_sensing::sensing::camera::CameraRendering;
use naoisis_sim::scenario::Scenario;

/// What becomes of a world whose episode is over.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum AutoReset {
    /// Its next step begins the next episode, and does nothing else.
    #[default]
    NextStep,
    /// The next episode begins in the step that ends this one.
    SameStep,
    /// It waits to be reset.
    Disabled,
}

/// What a step fills in: a row for each agent of each world, world by world.
#[derive(Debug)]
pub struct Arrays<'a> {
    /// What agents observe.
    pub observations: &'a mut [f32],
    /// Their images, row by row of pixels; empty where they observe none.
    pub images: &'a mut [u8],
    /// What they are rewarded with.
    pub rewards: &'a mut [f32],
    /// Whether the episode is over.
    pub terminations: &'a mut [bool],
    /// Whether its time is.
    pub truncations: &'a mut [bool],
    /// Whether it ended with success.
    pub successes: &'a mut [bool],
    /// The last observations of episodes that are over, where the next one begins in the same step; else empty.
    pub final_observations: &'a mut [f32],
    /// The images of the same.
    pub final_images: &'a mut [u8],
}

/// Why worlds cannot go on.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EnvironmentError {
    /// An episode cannot begin.
    #[error(transparent)]
    Start(#[from] StartError),
    /// A row is no action.
    #[error("row {row}: {error}")]
    Action {
        /// Which row, from 0.
        row: usize,
        /// What is wrong with it.
        error: NotAnAction,
    },
    /// An episode is over.
    #[error("the episode of world {world} is over, or has not begun; expected a reset before the next step")]
    Over {
        /// Which world, from 0.
        world: usize,
    },
    /// Something panicked; the world begins anew with its next reset.
    #[error("world {world} was broken off: {message}; the others went on")]
    Panicked {
        /// Which world, from 0.
        world: usize,
        /// What the panic said.
        message: String,
    },
}

/// Worlds that are stepped together. What comes out does not depend on the number of threads.
pub struct Environments {
    settings: EnvironmentSettings,
    simulator: fn() -> World,
    episodes: Vec<Episode>,
    /// Whether a world may be stepped.
    has_begun: Vec<bool>,
    auto_reset: AutoReset,
    threads: usize,
    entries: Vec<ObservationEntry>,
    state_entries: Vec<ObservationEntry>,
    image_bytes: usize,
}

/// A world's part of the arrays.
struct Part<'a> {
    index: usize,
    episode: &'a mut Episode,
    has_begun: &'a mut bool,
    actions: &'a [f32],
    arrays: Arrays<'a>,
}

impl Environments {
    /// So many worlds. The episodes of each have a seed of their own, that of the first being `seed`.
    ///
    /// # Errors
    /// When the match cannot be started.
    pub fn new(
        settings: EnvironmentSettings,
        simulator: fn() -> World,
        worlds: usize,
        auto_reset: AutoReset,
        threads: usize,
    ) -> Result<Self, StartError> {
        let mut episodes: Vec<Episode> =
            (0..worlds.max(1)).map(|index| Episode::new(simulator(), index as u64)).collect();
        let first = &mut episodes[0];
        first.begin(&settings)?;
        let entries = settings.control.first().map(|id| entries(settings.observation, &first.world, *id));
        let state_entries = state_entries(&first.world);
        let image_bytes = if settings.camera.is_some() { image_bytes(&first.world) } else { 0 };
        let has_begun = vec![false; episodes.len()];
        let entries = entries.unwrap_or_default();
        Ok(Self { settings, simulator, episodes, has_begun, auto_reset, threads, entries, state_entries, image_bytes })
    }

    /// What all worlds have in common.
    pub fn settings(&self) -> &EnvironmentSettings {
        &self.settings
    }

    /// The number of worlds.
    pub fn worlds(&self) -> usize {
        self.episodes.len()
    }

    /// Rows of the arrays: one for each agent of each world.
    pub fn rows(&self) -> usize {
        self.episodes.len() * self.settings.control.len()
    }

    /// The numbers that an agent observes.
    pub fn entries(&self) -> &[ObservationEntry] {
        &self.entries
    }

    /// The numbers of the state of a world.
    pub fn state_entries(&self) -> &[ObservationEntry] {
        &self.state_entries
    }

    /// Bytes of an image.
    pub fn image_bytes(&self) -> usize {
        self.image_bytes
    }

    /// A world.
    pub fn world_mut(&mut self, index: usize) -> Option<&mut World> {
        self.episodes.get_mut(index).map(|episode| &mut episode.world)
    }

    /// What is true in each world, world by world.
    pub fn state(&self, array: &mut [f32]) {
        for (episode, part) in self.episodes.iter().zip(array.chunks_mut(self.state_entries.len().max(1))) {
            state(part, &episode.world);
        }
    }

    /// Begins an episode in the worlds of the mask, or in all; with the seeds from `seed` on, one a world, or else the next
    /// of those that the worlds have. What their episodes start from is `start`, until their next reset, or else what the
    /// settings say. Fills in the observations of those worlds.
    ///
    /// # Errors
    /// When a match cannot be started, or is another one than the environment was made for.
    pub fn reset(
        &mut self,
        seed: Option<u64>,
        mask: Option<&[bool]>,
        start: Option<&Arc<Start>>,
        arrays: Arrays,
    ) -> Result<(), EnvironmentError> {
        let (settings, simulator) = (&self.settings, self.simulator);
        let (entries, state_entries, image_bytes) = (&self.entries, &self.state_entries, self.image_bytes);
        let agents = settings.control.len();
        let parts = parts(&mut self.episodes, &mut self.has_begun, &[], arrays, agents, 0);
        let parts = parts.into_iter().filter(|part| mask.is_none_or(|mask| mask.get(part.index) == Some(&true)));
        each(self.threads, parts.collect(), |part| {
            if let Some(seed) = seed {
                part.episode.seed(seed.wrapping_add(part.index as u64));
            }
            part.episode.start = start.cloned();
            guarded(part, simulator, |part| {
                *part.has_begun = false;
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
    /// When an action is none, or an episode is over: then nothing has happened. When a world panics: the others went on.
    pub fn step(&mut self, actions: &[f32], arrays: Arrays) -> Result<(), EnvironmentError> {
        let settings = &self.settings;
        let (length, agents) = (settings.action.len(), settings.control.len());
        for (row, action) in actions.chunks(length).enumerate() {
            settings.action.check(action).map_err(|error| EnvironmentError::Action { row, error })?;
        }
        let auto_reset = self.auto_reset;
        let waits = |(begun, episode): (&bool, &Episode)| {
            !begun || (auto_reset == AutoReset::Disabled && episode.progress.is_over())
        };
        if let Some(world) = self.has_begun.iter().zip(&self.episodes).position(waits) {
            return Err(EnvironmentError::Over { world });
        }
        let simulator = self.simulator;
        let parts = parts(&mut self.episodes, &mut self.has_begun, actions, arrays, agents, length);
        each(self.threads, parts, |part| guarded(part, simulator, |part| step(settings, auto_reset, part)))
    }
}

/// Bytes of an image that the robots of a match see.
fn image_bytes(world: &World) -> usize {
    let cameras = world.get_resource::<Scenario>().map(|scenario| scenario.cameras);
    let cameras = cameras.filter(|cameras| !matches!(cameras.render, CameraRendering::Auto | CameraRendering::Off));
    cameras.map_or(0, |cameras| 3 * (cameras.width * cameras.height) as usize)
}

/// That a match has the agents that the environment was made for, and that they observe the same numbers.
fn check_same(
    settings: &EnvironmentSettings,
    world: &World,
    expected: &[ObservationEntry],
    expected_state: &[ObservationEntry],
    expected_bytes: usize,
) -> Result<(), StartError> {
    let remote = remote_robots(world);
    if let Some(id) = settings.control.iter().find(|id| !remote.contains(id)) {
        return Err(StartError::Different(format!(
            "`{id}` is not decided for from outside in it; expected a match in which it is controlled"
        )));
    }
    let found = settings.control.first().map(|id| entries(settings.observation, world, *id)).unwrap_or_default();
    if found != expected || state_entries(world) != expected_state {
        let message =
            format!("its {} numbers to observe are not the {} of this environment", found.len(), expected.len());
        return Err(StartError::Different(format!("{message}; expected as many robots of the same models")));
    }
    let bytes = image_bytes(world);
    if settings.camera.is_some() && bytes != expected_bytes {
        return Err(StartError::Different(format!("its images have {bytes} bytes; expected {expected_bytes}")));
    }
    Ok(())
}

/// Plays a step of one world.
fn step(settings: &EnvironmentSettings, auto_reset: AutoReset, part: &mut Part) -> Result<(), EnvironmentError> {
    let Part { episode, actions, arrays, .. } = part;
    let begins = auto_reset == AutoReset::NextStep && episode.progress.is_over();
    if begins {
        episode.begin(settings)?;
        arrays.rewards.fill(0.0);
    } else {
        episode.step(settings, actions, arrays.rewards);
    }
    let progress = episode.progress;
    arrays.terminations.fill(progress.terminated);
    arrays.truncations.fill(progress.truncated);
    arrays.successes.fill(progress.is_success);
    if auto_reset == AutoReset::SameStep && progress.is_over() {
        episode.observe(settings, arrays.final_observations, arrays.final_images);
        episode.begin(settings)?;
    }
    episode.observe(settings, arrays.observations, arrays.images);
    Ok(())
}

/// Does something with a world, and gives it a new one where that panics.
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
    actions: &'a [f32],
    arrays: Arrays<'a>,
    agents: usize,
    length: usize,
) -> Vec<Part<'a>> {
    let worlds = episodes.len();
    let size = |all: usize| (all / worlds).max(1);
    let Arrays {
        observations,
        images,
        rewards,
        terminations,
        truncations,
        successes,
        final_observations,
        final_images,
    } = arrays;
    let sizes = [observations.len(), images.len(), final_observations.len(), final_images.len()].map(size);
    // What is not asked for is an empty part for everybody.
    let mut observations = observations.chunks_mut(sizes[0]);
    let mut images = images.chunks_mut(sizes[1]);
    let mut final_observations = final_observations.chunks_mut(sizes[2]);
    let mut final_images = final_images.chunks_mut(sizes[3]);
    let (mut rewards, mut terminations) = (rewards.chunks_mut(agents), terminations.chunks_mut(agents));
    let (mut truncations, mut successes) = (truncations.chunks_mut(agents), successes.chunks_mut(agents));
    let mut actions = actions.chunks((agents * length).max(1));
    let worlds = episodes.iter_mut().zip(has_begun).enumerate();
    worlds
        .map(|(index, (episode, has_begun))| Part {
            index,
            episode,
            has_begun,
            actions: actions.next().unwrap_or_default(),
            arrays: Arrays {
                observations: observations.next().unwrap_or_default(),
                images: images.next().unwrap_or_default(),
                rewards: rewards.next().unwrap_or_default(),
                terminations: terminations.next().unwrap_or_default(),
                truncations: truncations.next().unwrap_or_default(),
                successes: successes.next().unwrap_or_default(),
                final_observations: final_observations.next().unwrap_or_default(),
                final_images: final_images.next().unwrap_or_default(),
            },
        })
        .collect()
}

/// Does something with each part, on so many threads. The error of the first that has one.
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
            // What panics in a part is caught there.
            result = result.and(other.join().unwrap_or(Ok(())));
        }
        result.and(last)
    })
}

/// Does something with each part, and goes on where one fails.
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
