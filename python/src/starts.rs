//! What episodes start from: a scenario or a challenge, who is controlled in it, against whom, and what a reset changes of it.

use naoisis::environment::challenge::{ChallengeError, Situation, SituationError};
use naoisis::environment::{Challenge, Start};
use naoisis::scenario::{Realism, Scenario, ScenarioFile, Setting};
use naoisis::simulation::Snapshot;
use naoisis::team::RobotId;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::errors::{scenario_error, snapshot_error};
use crate::simulator::{self, Made, controlled, setting};
use crate::values::from_python;

/// What the episodes of an environment start from, as long as a reset says nothing else.
pub struct Origin {
    /// The same scenario against each of the opponents, at least one.
    files: Vec<ScenarioFile>,
    /// Who is controlled: robots and teams.
    words: Vec<String>,
    situation: Situation,
}

/// What a reset wants of the episodes that it begins: a dictionary with these keys.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Changes<'py> {
    /// Fields of the scenario, and their values.
    set: Option<Bound<'py, PyDict>>,
    /// Where things stand.
    situation: Option<Bound<'py, PyDict>>,
    /// A moment of a match.
    snapshot: Option<Vec<u8>>,
}

/// The scenario, and what a challenge adds to it.
pub fn scenario_of(py: Python<'_>, made: &Made<'_>) -> PyResult<(ScenarioFile, Option<Challenge>)> {
    let name = made.scenario.cast::<PyString>().ok().and_then(|name| name.to_str().ok());
    match name.filter(|name| Challenge::exists(name)) {
        Some(name) => {
            let wrong = |error: ChallengeError| PyValueError::new_err(error.to_string());
            let mut challenge = Challenge::named(name).map_err(wrong)?;
            // An unknown word is refused with the other settings.
            let levels = [Realism::Paper, Realism::Ideal, Realism::Realistic];
            if let Some(level) = levels.into_iter().find(|level| made.realism.as_deref() == Some(level.name())) {
                challenge = challenge.with(level, None).map_err(wrong)?;
            }
            let file = challenge.scenario().map_err(|error| scenario_error(py, &error))?;
            let file = made.changed(py, &file)?;
            let challenge = challenge.laid_out_for(&file.scenario);
            Ok((file, Some(challenge)))
        }
        None => Ok((made.file(py)?, None)),
    }
}

impl Origin {
    /// Episodes of a scenario, against its own opponents or one of those that `others` line up instead.
    pub fn new(
        py: Python<'_>,
        file: ScenarioFile,
        others: &[(String, String)],
        words: Vec<String>,
        situation: Situation,
    ) -> PyResult<Self> {
        let mut files = vec![file];
        for (side, team) in others {
            let lined_up = setting(&format!("teams.{side}"), &serde_json::Value::from(team.as_str()).to_string())?;
            let other = files[0].with(&[lined_up]).map_err(|error| scenario_error(py, &error))?;
            files.push(other);
        }
        Ok(Self { files, words, situation })
    }

    /// The scenario against the first of the opponents.
    pub fn scenario(&self) -> &Scenario {
        &self.files[0].scenario
    }

    /// What episodes start from, and who is controlled in them.
    pub fn start(&self, py: Python<'_>) -> PyResult<(Start, Vec<RobotId>)> {
        self.start_of(py, &self.files, self.situation.clone())
    }

    /// What episodes start from after a reset that wants something else.
    pub fn changed(&self, py: Python<'_>, changes: &Changes<'_>) -> PyResult<Start> {
        if let Some(bytes) = &changes.snapshot {
            let snapshot = Snapshot::from_bytes(bytes, &simulator::world());
            let wrong = |message| snapshot_error(py, &format!("{message}; expected the bytes of a snapshot"));
            return snapshot.map(Start::Moment).map_err(wrong);
        }
        let mut settings: Vec<Setting> = Vec::new();
        for (path, value) in changes.set.iter().flatten() {
            let path: String = path.extract()?;
            settings.push(setting(&path, &from_python(&value, &path)?.to_string())?);
        }
        let files: Result<Vec<ScenarioFile>, _> = self.files.iter().map(|file| file.with(&settings)).collect();
        let files = files.map_err(|error| scenario_error(py, &error))?;
        let situation = match &changes.situation {
            Some(situation) => {
                let value = from_python(situation, "situation")?;
                let wrong = |error| PyValueError::new_err(format!("situation: {error}"));
                serde_json::from_value(value).map_err(wrong)?
            }
            None => self.situation.clone(),
        };
        Ok(self.start_of(py, &files, situation)?.0)
    }

    fn start_of(
        &self,
        py: Python<'_>,
        files: &[ScenarioFile],
        situation: Situation,
    ) -> PyResult<(Start, Vec<RobotId>)> {
        let mut world = simulator::world();
        let mut scenarios = Vec::new();
        let mut control = Vec::new();
        for file in files {
            // What is wrong with it is said before who is controlled is looked for.
            simulator::start(py, &mut world, file)?;
            let (scenario, ids) = controlled(&world, &file.scenario, &self.words)?;
            let wrong = |error: SituationError| PyValueError::new_err(format!("situation: {error}"));
            situation.check(&scenario).map_err(wrong)?;
            scenarios.push(scenario);
            control = ids;
        }
        let first = Box::new(scenarios.remove(0));
        Ok((Start::Scenarios { first, others: scenarios, situation }, control))
    }
}
