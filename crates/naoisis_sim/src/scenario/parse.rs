//! Builds a scenario from a tree of values in three passes: fields and types, ranges of single values, and values together. Building ends
//! with the first pass that finds errors.

use serde_json::{Map, Value};
use std::path::Path;

use super::deserialize;
use super::error::{ScenarioError, ScenarioErrorKind};
use super::fault::ScenarioFault;
use super::field_path::{FieldPath, Segment};
use super::from_saved;
use super::models::is_file;
use super::presets;
use super::text::{Finding, ScenarioFile, ScenarioSource};
use super::types::Scenario;
use super::validate::{LONGEST_LISTS, place_ball_beside_robots, too_long};

/// Builds a scenario from a tree of values, after applying the source's settings. `names` returns faults that only the program can find:
/// unregistered names.
///
/// # Errors
/// All errors of the first pass that finds any, in the order of the text.
pub fn build(
    source: ScenarioSource,
    mut value: Value,
    names: impl FnOnce(&Scenario) -> Vec<ScenarioFault>,
) -> Result<ScenarioFile, Vec<ScenarioError>> {
    if let Value::Object(root) = &mut value {
        root.remove(SCHEMA);
    }
    place_model_beside(&source, &mut value);
    // Without the saved match nothing else can be checked.
    if let Err(fault) = from_saved::fill_in(&source, &mut value) {
        return Err(vec![source.error(&fault)]);
    }
    let of_settings: Vec<ScenarioError> =
        source.settings.iter().filter_map(|setting| setting.lay_over(&mut value).err()).collect();
    if !of_settings.is_empty() {
        return Err(in_order(of_settings));
    }
    let scenario = scenario_of(value, names).map_err(|mut findings| {
        findings.truncate(ScenarioFile::MOST_ERRORS);
        findings.sort_by_key(|finding| source.setting_of(&finding.fault.path).map(|(index, _)| index));
        in_order(source.errors(&findings))
    })?;
    Ok(ScenarioFile { scenario, source })
}

/// The key under which files name their JSON Schema for editors.
pub(super) const SCHEMA: &str = "$schema";

/// Builds a scenario from a tree of values.
///
/// # Errors
/// All faults of the first pass that finds any.
pub(super) fn scenario_of(
    mut value: Value,
    names: impl FnOnce(&Scenario) -> Vec<ScenarioFault>,
) -> Result<Scenario, Vec<Finding>> {
    let gives_ball_place = value.pointer("/ball/position_m").or(value.pointer("/balls/0/position_m")).is_some();
    let mut findings: Vec<Finding> = Vec::new();
    if let Value::Object(root) = &mut value {
        let faults = cut_lists(root).into_iter().chain(two_starts(root)).chain(presets::resolve(root));
        findings.extend(faults.map(Finding::from));
    }
    let scenario = read_types(&mut value, &mut findings);
    let Some(mut scenario) = scenario.filter(|_| findings.is_empty()) else { return Err(findings) };
    let faults = scenario.faults_of_values();
    if !faults.is_empty() {
        return Err(faults.into_iter().map(Finding::from).collect());
    }
    if !gives_ball_place {
        place_ball_beside_robots(&mut scenario);
    }
    let faults: Vec<ScenarioFault> = scenario.faults_together().into_iter().chain(names(&scenario)).collect();
    if faults.is_empty() { Ok(scenario) } else { Err(faults.into_iter().map(Finding::from).collect()) }
}

/// Sorts errors in the order of the text, and removes repeated ones and those beyond the limit.
pub(super) fn in_order(mut errors: Vec<ScenarioError>) -> Vec<ScenarioError> {
    errors.sort_by_key(|error| (error.line(), error.column()));
    // A fault of a common setting is found once for every robot that shares it.
    errors.dedup_by(|one, other| one.place() == other.place() && one.message() == other.message());
    errors.truncate(ScenarioFile::MOST_ERRORS);
    errors
}

/// Makes relative paths of model files relative to the scenario's folder, instead of the program's.
fn place_model_beside(source: &ScenarioSource, value: &mut Value) {
    let Some(folder) = Path::new(&source.name).parent().filter(|folder| !folder.as_os_str().is_empty()) else { return };
    let place = |value: &mut Value| {
        let model = match value.get_mut("model") {
            Some(Value::Object(inline)) => inline.get_mut("preset"),
            model => model,
        };
        if let Some(Value::String(model)) = model
            && is_file(model)
            && Path::new(model.as_str()).is_relative()
        {
            *model = folder.join(model.as_str()).to_string_lossy().into_owned();
        }
    };
    place(value);
    if let Some(Value::Object(teams)) = value.get_mut("teams") {
        teams.values_mut().for_each(place);
    }
    if let Some(Value::Array(robots)) = value.get_mut("robots") {
        robots.iter_mut().for_each(place);
    }
}

/// Cuts lists that are too long, and returns their faults.
fn cut_lists(root: &mut Map<String, Value>) -> Vec<ScenarioFault> {
    let mut faults = Vec::new();
    for (field, most) in LONGEST_LISTS {
        if let Some(Value::Array(elements)) = root.get_mut(field)
            && elements.len() > most
        {
            faults.push(too_long(field, elements.len(), most));
            elements.truncate(most);
        }
    }
    faults
}

/// Returns the faults of a start in `ball` that is not that of the first of `balls`.
fn two_starts(root: &Map<String, Value>) -> Vec<ScenarioFault> {
    let (Some(ball), Some(first)) = (root.get("ball"), root.get("balls").and_then(|balls| balls.get(0))) else {
        return Vec::new();
    };
    // Numbers that are left out are 0.
    let numbers = |start: Option<&Value>| {
        [0, 1, 2].map(|axis| start.and_then(|start| start.get(axis)).and_then(Value::as_f64).unwrap_or_default())
    };
    let differs =
        |field: &&str| ball.get(*field).is_some_and(|start| numbers(Some(start)) != numbers(first.get(*field)));
    let fault = |field: &str| {
        let path = FieldPath::from("ball").field(field);
        let expected = format!("it in `balls`, which have the starts of all: `balls[0].{field}`");
        ScenarioFault::new(path, format!("`ball` has a `{field}` beside `balls`"), expected)
    };
    ["position_m", "velocity_mps"].into_iter().filter(differs).map(fault).collect()
}

/// Reads the types, removing values of the wrong shape until none is left. Returns `None` if reading does not succeed.
fn read_types(value: &mut Value, findings: &mut Vec<Finding>) -> Option<Scenario> {
    for _ in 0..ScenarioFile::MOST_ERRORS {
        let fault = match deserialize::read(value) {
            Ok(scenario) => return Some(scenario),
            Err(fault) => ScenarioFault::of_shape(&fault, &FieldPath::default()),
        };
        let path = fault.path.clone();
        // A missing value is not a fault of the file if an earlier fault removed it.
        if findings.iter().all(|finding| !finding.fault.path.starts_with(&path)) {
            findings.push(Finding { kind: ScenarioErrorKind::Shape, fault });
        }
        if !take_out(value, &path) {
            return None;
        }
    }
    None
}

/// Removes the value at `path`, or the nearest value around it. An element of a list becomes an empty object, so that the others keep their
/// indices. Returns whether there was something to remove.
fn take_out(root: &mut Value, path: &FieldPath) -> bool {
    let segments = path.segments();
    for length in (0..segments.len()).rev() {
        match (value_at_mut(root, &segments[..length]), &segments[length]) {
            (Some(Value::Object(fields)), Segment::Field(name)) if fields.contains_key(name) => {
                fields.remove(name);
                return true;
            }
            (Some(Value::Array(elements)), Segment::Index(index)) => {
                let empty = Value::Object(Map::new());
                if let Some(element) = elements.get_mut(*index)
                    && *element != empty
                {
                    *element = empty;
                    return true;
                }
            }
            _ => {}
        }
    }
    false
}

fn value_at_mut<'a>(root: &'a mut Value, segments: &[Segment]) -> Option<&'a mut Value> {
    segments.iter().try_fold(root, |value, segment| match segment {
        Segment::Field(name) => value.get_mut(name),
        Segment::Index(index) => value.get_mut(*index),
    })
}
