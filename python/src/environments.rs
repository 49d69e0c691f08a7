//! Learning environments: many worlds that are stepped together.

use bevy::ecs::world::World;
use naoisis::cycle::CycleClock;
use naoisis::environment::challenge::CHALLENGES;
use naoisis::environment::counts::BeginCounter;
use naoisis::environment::reward::REWARDS;
use naoisis::environment::{
    self, ActionKind, ActionSpace, Arrays, Challenge, EnvironmentError, EnvironmentSettings, ObservationEntry,
    ObservationKind, SavedWorld, StartError, action, action_space,
};
use naoisis::interface::gather::{CurrentRecord, gather_start};
use naoisis::record::match_counts::begin_episode;
use naoisis::record::match_renderer::{MatchRenderer, view_of_field};
use naoisis::scenario::{ScenarioFile, ScenarioSource};
use naoisis::simulation::Snapshot;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArrayDyn, PyReadwriteArrayDyn};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::sync::{Arc, Mutex, TryLockError};

use crate::errors::{match_error, of_snapshot, scenario_error, snapshot_error};
use crate::shapes::{
    Shape, auto_reset_of, camera_of, first_of, observed, ranges_of_levels, reward_of, with_images, word,
};
use crate::simulator::{self, Made};
use crate::starts::{Changes, Origin, Starts, draws_of, scenario_of};
use crate::steps::{Filled, slice, step, written};
use crate::values::{Digits, to_python};

/// The names of the challenges and their versions.
#[pyfunction]
pub fn challenges() -> PyResult<Vec<(String, u32, String)>> {
    let read = |(name, _): &(&str, &str)| {
        let challenge = Challenge::named(name).map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok((challenge.name, challenge.version, challenge.description))
    };
    CHALLENGES.iter().map(read).collect()
}

/// Worlds that are stepped together. The Python classes that wrap them have the documentation.
#[pyclass(frozen, module = "naoisis._naoisis")]
pub struct Environments {
    worlds: Mutex<environment::Environments>,
    origin: Origin,
    source: ScenarioSource,
    renderer: Mutex<MatchRenderer>,
    settings: EnvironmentSettings,
    /// Height and width of the images, if there are any.
    image: Option<[u32; 2]>,
    rows: usize,
    count: usize,
    entries: usize,
    states: usize,
}

fn environment_error(py: Python<'_>, source: &ScenarioSource, error: &EnvironmentError) -> PyErr {
    match error {
        EnvironmentError::Action { .. } => PyValueError::new_err(error.to_string()),
        EnvironmentError::Start(error) => start_error(py, source, error),
        _ => match_error(py, &error.to_string()),
    }
}

fn start_error(py: Python<'_>, source: &ScenarioSource, error: &StartError) -> PyErr {
    match error {
        StartError::Scenario(fault) => scenario_error(py, &source.error(fault)),
        StartError::Moment(message) => snapshot_error(py, message),
        _ => PyValueError::new_err(error.to_string()),
    }
}

impl Environments {
    fn with<T>(&self, py: Python<'_>, act: impl FnOnce(&mut environment::Environments) -> PyResult<T>) -> PyResult<T> {
        match self.worlds.try_lock() {
            Ok(mut worlds) => act(&mut worlds),
            Err(TryLockError::WouldBlock) => {
                Err(match_error(py, "another thread is using this environment; expected one at a time"))
            }
            Err(TryLockError::Poisoned(_)) => Err(match_error(py, "the environment was broken off by an error")),
        }
    }

    /// Calls `act` with the arrays, after checking their sizes. Returns whether an episode has ended in any world.
    fn fill(
        &self,
        py: Python<'_>,
        arrays: &Filled<'_>,
        act: impl FnOnce(Python<'_>, &mut environment::Environments, Arrays) -> PyResult<Result<(), EnvironmentError>>,
    ) -> PyResult<bool> {
        let image_bytes = self.image.map_or(0, |[height, width]| 3 * (height * width) as usize);
        let has_final = arrays.final_observations.len()? > 0;
        let final_rows = if has_final { self.rows } else { 0 };
        let state_numbers = if arrays.final_states.len()? > 0 { self.count * self.states } else { 0 };
        let mut observations = written(&arrays.observations, "observations")?;
        let mut images = written(&arrays.images, "images")?;
        let mut rewards = written(&arrays.rewards, "rewards")?;
        let mut terminations = written(&arrays.terminations, "terminations")?;
        let mut truncations = written(&arrays.truncations, "truncations")?;
        let mut successes = written(&arrays.successes, "successes")?;
        let mut final_observations = written(&arrays.final_observations, "final_observations")?;
        let mut final_images = written(&arrays.final_images, "final_images")?;
        let mut final_states = written(&arrays.final_states, "final_states")?;
        let arrays = Arrays {
            observations: slice(&mut observations, "observations", self.rows * self.entries)?,
            images: slice(&mut images, "images", self.rows * image_bytes)?,
            rewards: slice(&mut rewards, "rewards", self.rows)?,
            terminations: slice(&mut terminations, "terminations", self.rows)?,
            truncations: slice(&mut truncations, "truncations", self.rows)?,
            successes: slice(&mut successes, "successes", self.rows)?,
            final_observations: slice(&mut final_observations, "final_observations", final_rows * self.entries)?,
            final_images: slice(&mut final_images, "final_images", final_rows * image_bytes)?,
            final_states: slice(&mut final_states, "final_states", state_numbers)?,
        };
        self.with(py, |worlds| act(py, worlds, arrays)?.map_err(|error| environment_error(py, &self.source, &error)))?;
        let has_any = |over: &PyReadwriteArrayDyn<'_, bool>| over.as_slice().is_ok_and(|rows| rows.contains(&true));
        Ok(has_any(&terminations) || has_any(&truncations))
    }
}

#[pymethods]
impl Environments {
    #[new]
    fn new(py: Python<'_>, made: Made<'_>, shape: Shape<'_>) -> PyResult<Self> {
        let (file, challenge) = scenario_of(py, &made, made.realism.as_deref())?;
        let sees_images = shape.observation == "image";
        let form = observed(&shape)?;
        let action: ActionKind =
            word(&shape.action, "action", "'continuous', 'multi_discrete', 'discrete' or 'velocities'")?;
        ActionSpace::new(action, shape.extras.words)
            .map_err(|error| PyValueError::new_err(format!("says: {error}")))?;
        let auto_reset = auto_reset_of(&shape.auto_reset)?;
        let camera = if sees_images || shape.camera.is_some() { Some(camera_of(&shape, &file)?) } else { None };
        let camera = camera.filter(|_| sees_images);
        let prepared = |file: ScenarioFile| match camera {
            Some(camera) => with_images(py, file, camera, shape.image_size),
            None => Ok(file),
        };
        let file = prepared(file)?;
        let words = match (&shape.control, &challenge) {
            (Some(words), _) => words.clone(),
            (None, Some(challenge)) if shape.solo => vec![challenge.solo.to_string()],
            (None, Some(challenge)) => challenge.control.iter().map(ToString::to_string).collect(),
            (None, None) => Vec::new(),
        };
        let situation = challenge.as_ref().map(|challenge| challenge.situation.clone()).unwrap_or_default();
        let source = file.source.clone();
        let mut levels = vec![file];
        for realism in &shape.realisms {
            levels.push(prepared(scenario_of(py, &made, Some(realism))?.0)?);
        }
        let draws = draws_of(&shape.draws)?;
        let origin = Origin::new(py, levels, &shape.others, draws, words, situation, form)?;
        let Starts { start, control, entries: ranges } = origin.start(py)?;
        let first = first_of(&control, &shape)?;
        let reward = reward_of(&shape, challenge.as_ref())?;
        let cycles = shape.cycles_per_step.or(challenge.as_ref().map(|challenge| challenge.cycles_per_step));
        let end = challenge.map(|challenge| challenge.end).unwrap_or_default();
        let reads_senses = end.ball_seen || end.believed_within_m.is_some() || shape.own_reward;
        let settings = EnvironmentSettings {
            start: Arc::new(start),
            control,
            end,
            observed: form,
            camera,
            blind: form.kind == ObservationKind::Truth && !reads_senses,
            action,
            cycles_per_step: cycles.unwrap_or(3),
            reward,
            counter: shape.statistics.then_some(begin_episode as BeginCounter),
        };
        let (count, threads) = (shape.worlds, shape.threads);
        let mut worlds = py
            .detach(|| environment::Environments::new(settings.clone(), simulator::world, count, auto_reset, threads))
            .map_err(|error| start_error(py, &source, &error))?;
        for entries in ranges_of_levels(py, &made, &origin, first) {
            // A level at which it observes other things is not one that a reset can choose.
            let _ = worlds.widen(&entries);
        }
        for entries in ranges {
            if !worlds.widen(&entries) {
                let count = worlds.entries().len();
                let message = format!(
                    "an episode has {} numbers to observe, or others than the {count} of the first; expected as many robots, with the same \
                     cameras, in all of them",
                    entries.len()
                );
                return Err(PyValueError::new_err(message));
            }
        }
        let (rows, entries, states) = (worlds.rows(), worlds.entries().len(), worlds.state_entries().len());
        let image = sees_images.then_some(shape.image_size);
        let worlds = Mutex::new(worlds);
        Ok(Self { worlds, origin, source, renderer: Mutex::default(), settings, image, rows, count, entries, states })
    }

    /// The controlled robots of each world.
    #[getter]
    fn control(&self) -> Vec<String> {
        self.settings.control.iter().map(ToString::to_string).collect()
    }

    #[getter]
    fn cycles_per_step(&self) -> u32 {
        self.settings.cycles_per_step
    }

    #[getter]
    fn cycle_s(&self) -> f64 {
        self.origin.scenario().cycle_s
    }

    #[getter]
    fn reward<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.settings.reward, Digits::All)
    }

    /// The entries of an agent's observation: name, least and greatest value, and meaning.
    fn entries(&self, py: Python<'_>) -> PyResult<Vec<(String, f32, f32, &'static str)>> {
        let entries = |entry: &ObservationEntry| (entry.to_string(), entry.low, entry.high, entry.says);
        self.with(py, |worlds| Ok(worlds.entries().iter().map(entries).collect()))
    }

    /// The entries of a world's true state: name, least and greatest value, and meaning.
    fn state_entries(&self, py: Python<'_>) -> PyResult<Vec<(String, f32, f32, &'static str)>> {
        let entries = |entry: &ObservationEntry| (entry.to_string(), entry.low, entry.high, entry.says);
        self.with(py, |worlds| Ok(worlds.state_entries().iter().map(entries).collect()))
    }

    /// The names of the numbers of a continuous action, or of the choices in each list of a discrete one.
    fn action_names(&self) -> Vec<Vec<&'static str>> {
        self.settings.actions().names()
    }

    fn reset(
        &self,
        py: Python<'_>,
        seed: Option<u64>,
        match_seed: Option<u64>,
        mask: Option<PyReadonlyArrayDyn<'_, bool>>,
        changes: Option<Changes<'_>>,
        arrays: Filled<'_>,
    ) -> PyResult<()> {
        let mask = mask.as_ref().map(|mask| mask.as_slice()).transpose();
        let mask = mask.map_err(|_| PyValueError::new_err("reset_mask: expected a contiguous array"))?;
        if let Some(mask) = mask
            && mask.len() != self.count
        {
            let message = format!("reset_mask: the array has {} entries; expected {}", mask.len(), self.count);
            return Err(PyValueError::new_err(message));
        }
        let start = changes.map(|changes| self.origin.changed(py, &changes)).transpose()?.map(Arc::new);
        self.fill(py, &arrays, |py, worlds, arrays| {
            Ok(py.detach(|| worlds.reset(seed, mask, start.as_ref(), match_seed, arrays)))
        })?;
        Ok(())
    }

    /// Plays a step and fills the arrays. Returns whether an episode has ended in any world.
    fn step(&self, py: Python<'_>, actions: PyReadonlyArrayDyn<'_, f32>, arrays: Filled<'_>) -> PyResult<bool> {
        let actions =
            actions.as_slice().map_err(|_| PyValueError::new_err("actions: expected a contiguous array of float32"))?;
        let expected = self.rows * self.settings.actions().len();
        if actions.len() != expected {
            let message = format!("actions: the array has {} numbers; expected {expected}", actions.len());
            return Err(PyValueError::new_err(message));
        }
        self.fill(py, &arrays, |py, worlds, arrays| step(py, worlds, actions, arrays))
    }

    /// The saved state of each world: its match, if there is one, and the rest of its episode.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Vec<(Option<Bound<'py, PyBytes>>, Bound<'py, PyBytes>)>> {
        self.with(py, |worlds| {
            let saved = worlds.save().map_err(|error| of_snapshot(py, &error))?;
            let bytes = |bytes: &Vec<u8>| PyBytes::new(py, bytes);
            Ok(saved.iter().map(|world| (world.snapshot.as_ref().map(bytes), bytes(&world.episode))).collect())
        })
    }

    /// Continues from saved states. `changed` are the options of earlier resets, each with the worlds whose later
    /// episodes they change.
    fn restore(
        &self,
        py: Python<'_>,
        saved: Vec<(Option<Vec<u8>>, Vec<u8>)>,
        changed: Vec<(Vec<usize>, Changes<'_>)>,
    ) -> PyResult<()> {
        let saved: Vec<SavedWorld> =
            saved.into_iter().map(|(snapshot, episode)| SavedWorld { snapshot, episode }).collect();
        self.with(py, |worlds| {
            worlds.restore(&saved).map_err(|error| of_snapshot(py, &error))?;
            for (indices, changes) in &changed {
                let start = Arc::new(self.origin.changed(py, changes)?);
                worlds.set_start(indices, &start);
            }
            Ok(())
        })
    }

    /// The start of a world's episode: seed, index of the scenario, and drawn values.
    fn origin<'py>(&self, py: Python<'py>, world: usize) -> PyResult<Bound<'py, PyAny>> {
        self.with(py, |worlds| match worlds.origin(world) {
            Some(origin) => to_python(py, origin, Digits::All),
            None => Err(PyIndexError::new_err(format!("there is no world {world}"))),
        })
    }

    /// The start of the episode that ended in a world in the last step, and the counts of both teams by name; `None` if no episode ended.
    fn ended<'py>(&self, py: Python<'py>, world: usize) -> PyResult<Option<Ended<'py>>> {
        self.with(py, |worlds| {
            let Some(ended) = worlds.ended(world) else { return Ok(None) };
            let counts = ended.counts.iter().map(|(name, counts)| (*name, counts.blue, counts.pink)).collect();
            Ok(Some((to_python(py, &ended.origin, Digits::All)?, counts)))
        })
    }

    /// Whether each choice has an effect in the next step, for all agents and all lists in order.
    fn action_masks<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        self.with(py, |worlds| Ok(PyArray1::from_vec(py, worlds.action_masks())))
    }

    /// The true state of each world, one after the other.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.with(py, |worlds| {
            let entries = worlds.state_entries().len();
            let mut array = vec![0.0_f32; worlds.worlds() * entries];
            worlds.state(&mut array);
            Ok(PyArray1::from_vec(py, array).reshape([worlds.worlds(), entries])?.into_any())
        })
    }

    /// The true state of a world as a line of a trace.
    fn truth<'py>(&self, py: Python<'py>, world: usize) -> PyResult<Bound<'py, PyAny>> {
        self.with(py, |worlds| {
            let world = world_of(worlds, world)?;
            gather_start(world);
            let mut record = world.remove_resource::<CurrentRecord>().unwrap_or_default().record;
            // In the cycle under way robots have perceived, and nothing else has happened.
            record.cycle = record.cycle.saturating_sub(1);
            record.time_s = record.cycle as f64 * world.resource::<CycleClock>().period_s;
            to_python(py, &record, Digits::Lean)
        })
    }

    /// A snapshot of a world's match, from which episodes can start.
    fn snapshot<'py>(&self, py: Python<'py>, world: usize) -> PyResult<Bound<'py, PyBytes>> {
        self.with(py, |worlds| {
            let world = world_of(worlds, world)?;
            let snapshot = Snapshot::take(world).map_err(|error| of_snapshot(py, &error))?;
            let bytes = snapshot.to_bytes(world).map_err(|error| of_snapshot(py, &error))?;
            Ok(PyBytes::new(py, &bytes))
        })
    }

    fn picture<'py>(&self, py: Python<'py>, world: usize, width: u32, height: u32) -> PyResult<Bound<'py, PyAny>> {
        let Ok(mut renderer) = self.renderer.try_lock() else {
            return Err(match_error(py, "another thread is drawing this environment; expected one at a time"));
        };
        let image = self.with(py, |worlds| {
            let world = world_of(worlds, world)?;
            renderer.look(world);
            let view = view_of_field(&renderer.scene().pitch, [width, height]);
            Ok(renderer.draw(world, &view))
        })?;
        Ok(PyArray1::from_vec(py, image.rgb).reshape([height as usize, width as usize, 3])?.into_any())
    }

    /// The terms of rewards and their meanings.
    #[staticmethod]
    fn rewards() -> Vec<(&'static str, &'static str)> {
        REWARDS.to_vec()
    }

    /// The numbers of a continuous action and their meanings.
    #[staticmethod]
    fn continuous() -> Vec<(&'static str, &'static str)> {
        action::CONTINUOUS.to_vec()
    }

    /// The numbers of a continuous action that choose a word to say, and their meanings.
    #[staticmethod]
    fn says() -> Vec<(&'static str, &'static str)> {
        action_space::SAYS.to_vec()
    }
}

/// The start of an episode, and for each count its name and the numbers of blue and pink.
type Ended<'py> = (Bound<'py, PyAny>, Vec<(&'static str, f64, f64)>);

fn world_of(worlds: &mut environment::Environments, index: usize) -> PyResult<&mut World> {
    let count = worlds.worlds();
    worlds.world_mut(index).ok_or_else(|| {
        PyIndexError::new_err(format!("there is no world {index}; expected 0 to {}", count.saturating_sub(1)))
    })
}
