//! The start of episodes: a scenario or a challenge, the controlled robots, their opponents, and the changes by a reset.

use naoisis::environment::challenge::{ChallengeError, Situation, SituationError};
use naoisis::environment::{
    Challenge, Draw, DrawnScenarios, DrawnValues, ObservationEntry, ObservationForm, Start, observation,
};
use naoisis::scenario::{Realism, Scenario, ScenarioFile, Setting};
use naoisis::simulation::Snapshot;
use naoisis::team::RobotId;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString};

use crate::errors::{scenario_error, snapshot_error};
use crate::simulator::{self, Made, controlled, setting};
use crate::values::from_python;

/// The start of an environment's episodes, without the changes by a reset.
pub struct Origin {
    /// The scenario at each level of realism and against each of the opponents, at least one.
    files: Vec<ScenarioFile>,
    /// The fields that are drawn for each episode.
    draws: Vec<Draw>,
    /// The form of observations.
    form: ObservationForm,
    /// The controlled robots, by name or team.
    words: Vec<String>,
    situation: Situation,
}

/// The options of a reset, which change the episodes from it on: a dictionary with these keys.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Changes<'py> {
    /// Fields of the scenario, and their values.
    set: Option<Bound<'py, PyDict>>,
    /// The start areas of ball and robots.
    situation: Option<Bound<'py, PyDict>>,
    /// The saved state of a match.
    snapshot: Option<Vec<u8>>,
    /// The fields to draw, instead of the environment's.
    draws: Option<Vec<DrawnField<'py>>>,
}

/// A field to draw for each episode: its path, whether its values are the two ends of a range, and its values.
pub type DrawnField<'py> = (String, bool, Bound<'py, PyList>);

/// The start of episodes, the controlled robots, and the observation entries of the first of them in each scenario.
pub struct Starts {
    pub start: Start,
    pub control: Vec<RobotId>,
    pub entries: Vec<Vec<ObservationEntry>>,
}

/// The fields to draw and their values.
pub fn draws_of(fields: &[DrawnField<'_>]) -> PyResult<Vec<Draw>> {
    let draw = |(field, is_range, values): &DrawnField<'_>| {
        let values = if *is_range {
            DrawnValues::Range(values.extract()?)
        } else {
            let value = |value: Bound<'_, PyAny>| from_python(&value, field);
            DrawnValues::OneOf(values.iter().map(value).collect::<PyResult<_>>()?)
        };
        Ok(Draw { field: field.clone(), values, fixed: None })
    };
    fields.iter().map(draw).collect()
}

/// The scenario at the level `realism`, and the challenge if it is one.
pub fn scenario_of(
    py: Python<'_>,
    made: &Made<'_>,
    realism: Option<&str>,
) -> PyResult<(ScenarioFile, Option<Challenge>)> {
    let name = made.scenario.cast::<PyString>().ok().and_then(|name| name.to_str().ok());
    match name.filter(|name| Challenge::exists(name)) {
        Some(name) => {
            let wrong = |error: ChallengeError| PyValueError::new_err(error.to_string());
            let mut challenge = Challenge::named(name).map_err(wrong)?;
            // An unknown word is refused with the other settings.
            let levels = [Realism::Paper, Realism::Ideal, Realism::Realistic];
            if let Some(level) = levels.into_iter().find(|level| realism == Some(level.name())) {
                challenge = challenge.with(level, None).map_err(wrong)?;
            }
            let file = challenge.scenario().map_err(|error| scenario_error(py, &error))?;
            let file = made.changed(py, &file, realism)?;
            let challenge = challenge.laid_out_for(&file.scenario);
            Ok((file, Some(challenge)))
        }
        None => Ok((made.file_at(py, realism)?, None)),
    }
}

impl Origin {
    /// Creates the start of episodes from `levels`, the scenario at each level of realism. `others` are the sides and names of further opponents.
    pub fn new(
        py: Python<'_>,
        levels: Vec<ScenarioFile>,
        others: &[(String, String)],
        draws: Vec<Draw>,
        words: Vec<String>,
        situation: Situation,
        form: ObservationForm,
    ) -> PyResult<Self> {
        let mut files = Vec::new();
        for file in levels {
            files.push(file);
            let first = files.len() - 1;
            for (side, team) in others {
                let lined_up = setting(&format!("teams.{side}"), &serde_json::Value::from(team.as_str()).to_string())?;
                let other = files[first].with(&[lined_up]).map_err(|error| scenario_error(py, &error))?;
                files.push(other);
            }
        }
        Ok(Self { files, draws, form, words, situation })
    }

    /// The scenario against the first of the opponents.
    pub fn scenario(&self) -> &Scenario {
        &self.files[0].scenario
    }

    /// The start of episodes before any reset.
    pub fn start(&self, py: Python<'_>) -> PyResult<Starts> {
        self.start_of(py, self.files.clone(), self.situation.clone(), self.draws.clone())
    }

    /// The first scenario.
    pub fn file(&self) -> &ScenarioFile {
        &self.files[0]
    }

    /// The observation entries of robot `id` in the scenario `file`.
    pub fn entries(&self, py: Python<'_>, file: &ScenarioFile, id: RobotId) -> PyResult<Vec<ObservationEntry>> {
        let mut world = simulator::world();
        simulator::start(py, &mut world, file)?;
        Ok(observation::entries(self.form, &world, id))
    }

    /// The start of episodes after a reset with `changes`.
    pub fn changed(&self, py: Python<'_>, changes: &Changes<'_>) -> PyResult<Start> {
        if let Some(bytes) = &changes.snapshot {
            let snapshot = Snapshot::from_bytes(bytes, &simulator::world());
            let wrong = |message| snapshot_error(py, &format!("{message}; expected the bytes of a snapshot"));
            return snapshot.map(Start::Moment).map_err(wrong);
        }
        let mut settings: Vec<Setting> = Vec::new();
        let mut draws = changes.draws.as_deref().map(draws_of).transpose()?.unwrap_or_else(|| self.draws.clone());
        for (path, value) in changes.set.iter().flatten() {
            let path: String = path.extract()?;
            let value = from_python(&value, &path)?;
            settings.push(setting(&path, &value.to_string())?);
            // What is set is not drawn.
            for draw in draws.iter_mut().filter(|draw| draw.field == path) {
                draw.fixed = Some(value.clone());
            }
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
        Ok(self.start_of(py, files, situation, draws)?.start)
    }

    fn start_of(
        &self,
        py: Python<'_>,
        files: Vec<ScenarioFile>,
        situation: Situation,
        draws: Vec<Draw>,
    ) -> PyResult<Starts> {
        let mut world = simulator::world();
        let mut scenarios = Vec::new();
        let mut entries = Vec::new();
        let mut control: Vec<RobotId> = Vec::new();
        let mut extreme_files = Vec::new();
        for (draw, file) in draws.iter().flat_map(|draw| files.iter().map(move |file| (draw, file))) {
            for value in draw.values.extremes() {
                let changed = file.with(&[setting(&draw.field, &value.to_string())?]);
                extreme_files.push(changed.map_err(|error| scenario_error(py, &error))?);
            }
        }
        for file in files.iter().chain(&extreme_files) {
            // What is wrong with it is said before who is controlled is looked for.
            simulator::start(py, &mut world, file)?;
            let (scenario, ids) = controlled(&world, &file.scenario, &self.words)?;
            let wrong = |error: SituationError| PyValueError::new_err(format!("situation: {error}"));
            situation.check(&scenario).map_err(wrong)?;
            entries.push(ids.first().map(|id| observation::entries(self.form, &world, *id)).unwrap_or_default());
            scenarios.push(scenario);
            control = ids;
        }
        let start = if draws.is_empty() {
            let first = Box::new(scenarios.remove(0));
            Start::Scenarios { first, others: scenarios, situation }
        } else {
            Start::Drawn(Box::new(DrawnScenarios { files, draws, control: control.clone(), situation }))
        };
        Ok(Starts { start, control, entries })
    }
}
