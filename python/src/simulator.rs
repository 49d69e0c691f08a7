//! Simulators, and the scenarios that they play.

use bevy::app::App;
use bevy::ecs::world::World;
use naoisis::agents::{AgentsPlugin, with_remote_robots};
use naoisis::policy::PolicyPlugin;
use naoisis::record::RecordPlugin;
use naoisis::scenario::{Format, RobotSpec, Scenario, ScenarioFile, Setting};
use naoisis::sensing::jobs::SensingThreads;
use naoisis::simulation::{NaoisisPlugins, resolved, start_match};
use naoisis::team::{NotARobotId, RobotId, Team};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::path::PathBuf;

use crate::errors::scenario_error;
use crate::values::from_python;

/// A simulator with the built-in behaviours and teams, and programs as players, without a match.
pub fn simulator() -> App {
    let mut app = App::new();
    app.add_plugins((RecordPlugin, NaoisisPlugins, AgentsPlugin, PolicyPlugin));
    // One thread only: a process that Python forks would not have the others.
    app.insert_resource(SensingThreads(1));
    // Nothing runs this app, which would do so.
    app.finish();
    app.cleanup();
    app
}

/// The world of a simulator. Unlike an `App`, it can be sent to another thread.
pub fn world() -> World {
    core::mem::take(simulator().world_mut())
}

/// The options of a match: a dictionary with these keys.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Made<'py> {
    /// A built-in scenario's name, a file's path, or the scenario itself as a dictionary.
    pub scenario: Bound<'py, PyAny>,
    /// The seed, instead of the scenario's.
    pub seed: Option<u64>,
    /// Fields of the scenario, and their values.
    pub set: Option<Bound<'py, PyDict>>,
    /// The name of a team.
    pub blue: Option<String>,
    /// The name of a team.
    pub pink: Option<String>,
    /// The level of realism, such as `realistic`, instead of the scenario's.
    pub realism: Option<String>,
}

impl Made<'_> {
    /// The scenario with all options applied.
    pub fn file(&self, py: Python<'_>) -> PyResult<ScenarioFile> {
        self.file_at(py, self.realism.as_deref())
    }

    /// The scenario at the level `realism`, with all other options applied.
    pub fn file_at(&self, py: Python<'_>, realism: Option<&str>) -> PyResult<ScenarioFile> {
        self.changed(py, &self.unchanged(py)?, realism)
    }

    /// The scenario `file` at the level `realism`, with all other options applied.
    pub fn changed(&self, py: Python<'_>, file: &ScenarioFile, realism: Option<&str>) -> PyResult<ScenarioFile> {
        let mut settings = Vec::new();
        if let Some(word) = realism {
            settings.push(setting("realism", &format!("\"{word}\""))?);
        }
        for (path, value) in self.set.iter().flatten() {
            let Ok(path) = path.cast::<PyString>() else {
                return Err(PyTypeError::new_err("set: a key is no text; expected fields, such as 'messages.loss'"));
            };
            let path = path.to_str()?;
            settings.push(setting(path, &from_python(&value, path)?.to_string())?);
        }
        for (path, team) in [("teams.blue", &self.blue), ("teams.pink", &self.pink)] {
            if let Some(team) = team {
                settings.push(setting(path, &serde_json::Value::from(team.as_str()).to_string())?);
            }
        }
        if (self.blue.is_some() || self.pink.is_some()) && !file.scenario.robots.is_empty() {
            let name = &file.source.name;
            return Err(PyValueError::new_err(format!(
                "`{name}` places its robots itself; expected a scenario with `teams` for `blue` and `pink`"
            )));
        }
        let mut file = file.with(&settings).map_err(|error| scenario_error(py, &error))?;
        if let Some(seed) = self.seed {
            file.scenario.seed = seed;
        }
        Ok(file)
    }

    fn unchanged(&self, py: Python<'_>) -> PyResult<ScenarioFile> {
        let found = if self.scenario.cast::<PyDict>().is_ok() {
            let text = from_python(&self.scenario, "scenario")?;
            ScenarioFile::from_text(&format!("{text:#}"), Format::Json, "scenario")
        } else {
            let path: PathBuf = self.scenario.extract().map_err(|_| {
                PyTypeError::new_err("scenario: expected a built-in scenario's name, a file's path, or a dictionary")
            })?;
            ScenarioFile::find(&path.display().to_string())
        };
        found.map_err(|error| scenario_error(py, &error))
    }
}

/// A setting that replaces a field of a scenario. `value` is JSON.
pub fn setting(path: &str, value: &str) -> PyResult<Setting> {
    let fault = |_| {
        let message = format!("set: {path:?} is no field; expected one such as 'messages.loss' or 'robots[0].number'");
        PyValueError::new_err(message)
    };
    if path.contains('=') {
        return Err(fault(()));
    }
    format!("{path}={value}").parse().map_err(|_| fault(()))
}

/// Starts the match of a scenario.
pub fn start(py: Python<'_>, world: &mut World, file: &ScenarioFile) -> PyResult<()> {
    start_match(world, &file.scenario).map_err(|fault| scenario_error(py, &file.source.error(&fault)))
}

/// The robot that `word` names, such as `blue2`.
pub fn robot_id(word: &str) -> PyResult<RobotId> {
    word.parse().map_err(|error: NotARobotId| PyValueError::new_err(error.to_string()))
}

/// The scenario with the robots that `words` name commanded by Python, and their ids in order. The name of a team stands for all
/// of its robots.
pub fn controlled(world: &World, scenario: &Scenario, words: &[String]) -> PyResult<(Scenario, Vec<RobotId>)> {
    let everybody = resolved(world, scenario).robots;
    let mut control = Vec::new();
    for word in words {
        match Team::BOTH.into_iter().find(|team| team.name() == word) {
            Some(team) => control.extend(everybody.iter().map(RobotSpec::id).filter(|id| id.team == team)),
            None => control.push(robot_id(word)?),
        }
    }
    control.sort_unstable();
    control.dedup();
    let scenario = with_remote_robots(world, scenario, &control);
    let scenario = scenario.map_err(|fault| PyValueError::new_err(format!("control: {}", fault.in_words())))?;
    Ok((scenario, control))
}
