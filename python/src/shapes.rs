//! The options of environments, the camera of their images, and the ranges of their observations.

use naoisis::camera_model::{CameraName, NotACameraName};
use naoisis::environment::{
    AutoReset, Challenge, Extras, ObservationEntry, ObservationForm, ObservationKind, Others, RewardWeights,
};
use naoisis::scenario::{Realism, ScenarioFile, Setting};
use naoisis::sensing::camera::CameraRendering;
use naoisis::team::RobotId;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::de::DeserializeOwned;

use crate::errors::scenario_error;
use crate::simulator::{Made, setting};
use crate::starts::{DrawnField, Origin, scenario_of};
use crate::values::from_python;

/// The options of an environment: a dictionary with these keys.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Shape<'py> {
    pub control: Option<Vec<String>>,
    /// Opponents besides the first: the side of each and the name of its team.
    pub others: Vec<(String, String)>,
    pub solo: bool,
    pub observation: String,
    pub camera: Option<String>,
    pub image_size: [u32; 2],
    pub action: String,
    pub cycles_per_step: Option<u32>,
    pub reward: Option<Bound<'py, PyDict>>,
    /// Levels of realism besides the first; one of all is drawn for each episode.
    pub realisms: Vec<String>,
    /// The fields of the scenario that are drawn for each episode.
    pub draws: Vec<DrawnField<'py>>,
    pub extras: ShapeExtras,
    /// The numbers of team-mates and of opponents in an observation; `None` for those of the match.
    pub observed_robots: Option<[u8; 2]>,
    /// Whether the info of an episode has counts of goals, kicks and the like.
    pub statistics: bool,
    /// Whether the caller computes rewards, for which it needs perceptions besides the truth.
    pub own_reward: bool,
    pub worlds: usize,
    pub auto_reset: String,
    pub threads: usize,
}

/// Optional parts of observations and actions: a dictionary with these keys.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ShapeExtras {
    pub set_plays: bool,
    pub penalties: bool,
    pub messages: bool,
    pub tracked: bool,
    pub words: u8,
}

impl From<&ShapeExtras> for Extras {
    fn from(extras: &ShapeExtras) -> Self {
        let &ShapeExtras { set_plays, penalties, messages, tracked, words } = extras;
        Self { set_plays, penalties, messages, tracked, words }
    }
}

/// The value that `word` names. The error names the option `name` and the `expected` words.
pub fn word<T: DeserializeOwned>(word: &str, name: &str, expected: &str) -> PyResult<T> {
    serde_json::from_value(word.into())
        .map_err(|_| PyValueError::new_err(format!("{name}: there is no {word:?}; expected {expected}")))
}

/// The form of observations.
pub fn observed(shape: &Shape<'_>) -> PyResult<ObservationForm> {
    let kind = match shape.observation.as_str() {
        "image" => ObservationKind::Body,
        other => word(other, "observation", "'perception', 'belief', 'truth' or 'image'")?,
    };
    let others = shape.observed_robots.map(|[team_mates, opponents]| Others { team_mates, opponents });
    Ok(ObservationForm { kind, extras: Extras::from(&shape.extras), others })
}

pub fn auto_reset_of(word: &str) -> PyResult<AutoReset> {
    match word {
        "next_step" => Ok(AutoReset::NextStep),
        "same_step" => Ok(AutoReset::SameStep),
        "disabled" => Ok(AutoReset::Disabled),
        other => {
            let message = format!("autoreset_mode: there is no {other:?}; expected next_step, same_step or disabled");
            Err(PyValueError::new_err(message))
        }
    }
}

/// The first of the controlled robots. Fails if there is none, or more than one in an environment for one agent.
pub fn first_of(control: &[RobotId], shape: &Shape<'_>) -> PyResult<RobotId> {
    match control {
        [only] => Ok(*only),
        [first, ..] if !shape.solo => Ok(*first),
        _ => {
            let expected =
                if shape.solo { "one robot, such as 'blue2'" } else { "one robot at least, such as 'blue2'" };
            Err(PyValueError::new_err(format!("control: {} robots; expected {expected}", control.len())))
        }
    }
}

/// The weights of the reward: those that are given, or those of the task.
pub fn reward_of(shape: &Shape<'_>, challenge: Option<&Challenge>) -> PyResult<RewardWeights> {
    let Some(weights) = &shape.reward else {
        return Ok(challenge.map_or(RewardWeights::SCORE, |challenge| challenge.reward));
    };
    serde_json::from_value(from_python(weights, "reward")?)
        .map_err(|error| PyValueError::new_err(format!("reward: {error}")))
}

/// The camera of the observed images: the one that was asked for, or the first.
pub fn camera_of(shape: &Shape<'_>, file: &ScenarioFile) -> PyResult<CameraName> {
    let mounts = file.scenario.settings.cameras.mounts;
    let Some(word) = &shape.camera else {
        let none = || PyValueError::new_err("observation: a robot without a camera has no image");
        return mounts.names().next().ok_or_else(none);
    };
    let name: CameraName =
        word.parse().map_err(|error: NotACameraName| PyValueError::new_err(format!("camera: {error}")))?;
    if mounts.get(name).is_none() {
        let names: Vec<String> = mounts.names().map(|name| format!("'{name}'")).collect();
        let message = format!("camera: there is no '{name}'; expected {}", names.join(" or "));
        return Err(PyValueError::new_err(message));
    }
    Ok(name)
}

/// The scenario `file` with images of `camera`; `size` is height and width, pixels.
pub fn with_images(py: Python<'_>, file: ScenarioFile, camera: CameraName, size: [u32; 2]) -> PyResult<ScenarioFile> {
    let [height, width] = size;
    let which = serde_json::to_string(&camera).unwrap_or_default();
    let values = [("width", width.to_string()), ("height", height.to_string()), ("which", which)];
    let mut settings: Vec<Setting> =
        values.iter().map(|(field, value)| setting(&format!("cameras.{field}"), value)).collect::<PyResult<_>>()?;
    if !matches!(file.scenario.settings.cameras.render, CameraRendering::Gpu) {
        settings.push(setting("cameras.render", "\"software\"")?);
    }
    file.with(&settings).map_err(|error| scenario_error(py, &error))
}

/// The observation entries of robot `id` at each level of realism that the environment or a reset can set.
pub fn ranges_of_levels(py: Python<'_>, made: &Made<'_>, origin: &Origin, id: RobotId) -> Vec<Vec<ObservationEntry>> {
    let levels = [Realism::Paper, Realism::Ideal, Realism::Realistic];
    // A task has another robot at some levels, and a reset can set another level for each of them.
    let mut files: Vec<ScenarioFile> =
        levels.iter().filter_map(|level| Some(scenario_of(py, made, Some(level.name())).ok()?.0)).collect();
    files.push(origin.file().clone());
    let files = files.iter().flat_map(|file| levels.iter().filter_map(|level| at_level(file, *level)));
    files.filter_map(|file| origin.entries(py, &file, id).ok()).collect()
}

/// A scenario at another level of realism; `None` if it is not valid there.
fn at_level(file: &ScenarioFile, level: Realism) -> Option<ScenarioFile> {
    let realism = setting("realism", &format!("\"{}\"", level.name())).ok()?;
    file.with(&[realism]).ok()
}
