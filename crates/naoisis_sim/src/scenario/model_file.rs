//! Reads the files of models, and reports all of their errors.

use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::bytes::{LARGEST_FILE_BYTES, read_bytes};
use super::deserialize;
use super::error::{ScenarioError, ScenarioErrorKind};
use super::fault::ScenarioFault;
use super::field_path::FieldPath;
use super::format::Format;
use super::model_like::{LONGEST_CHAIN, reference};
use super::models::{ModelError, RobotModel, is_file, leave_out_what_it_lacks};
use super::parse::{SCHEMA, in_order, scenario_of};
use super::read::read;
use super::robot_settings::RobotSettings;
use super::text::{Finding, ScenarioSource};
use super::types::Scenario;
use super::wording::{all_of, did_you_mean, one_of, quoted};

/// The fields of a model file.
const FIELDS: [&str; 6] = ["name", "description", "like", "settings", "realistic", "sources"];
/// The fields that no scenario has.
const OF_MODELS_ONLY: [&str; 4] = ["settings", "realistic", "sources", "like"];
/// The field that names the model from which a file starts.
const LIKE: &str = "like";
/// The fields that no model has.
const OF_SCENARIOS_ONLY: [&str; 3] = ["teams", "robots", "duration"];
/// Settings that the realistic part can have besides those of a robot: the ball of its league.
const REALISTIC_BESIDES: [&str; 1] = ["ball"];

/// Returns whether the values of a file are those of a model, not of a scenario.
pub fn is_model(value: &Value) -> bool {
    let has_any = |fields: &[&str]| fields.iter().any(|field| value.get(field).is_some());
    has_any(&OF_MODELS_ONLY) && !has_any(&OF_SCENARIOS_ONLY)
}

/// Returns the error for a model in place of a scenario.
pub fn no_scenario(source: &ScenarioSource, value: &Value) -> ScenarioError {
    let first = OF_MODELS_ONLY.into_iter().find(|field| value.get(field).is_some()).unwrap_or_default();
    let file = source.name.rsplit(['/', '\\']).next().unwrap_or_default();
    let expected = format!(
        "a scenario, such as `(model: \"{file}\", teams: (blue: \"roles\", pink: \"roles\"))`; `naoisis check` and \
         `naoisis robot show` take models"
    );
    source.error(
        &ScenarioFault::new(FieldPath::from(first), "this is the model of a robot, no scenario", expected).at_key(),
    )
}

impl RobotModel {
    /// Finds a model: by the name of a built-in one, or by the path of a file that ends in `.ron`.
    ///
    /// # Errors
    /// If there is neither, or the file is no model.
    pub fn find(name_or_path: &str) -> Result<RobotModel, ModelError> {
        Self::find_within(name_or_path, 0)
    }

    /// Finds a model that is the `step`th of a chain of models, each like the next.
    fn find_within(name_or_path: &str, step: usize) -> Result<RobotModel, ModelError> {
        if is_file(name_or_path) {
            return Self::load(name_or_path, step);
        }
        Self::named(name_or_path).ok_or_else(|| ModelError::Unknown(name_or_path.to_owned()))
    }

    /// Returns the name of the model that scenarios refer to by this word. For a file, this is the name in the file, or the file name
    /// without folder and extension if it cannot be read any more.
    pub fn name_of(reference: &str) -> String {
        if !is_file(reference) {
            return reference.to_owned();
        }
        let text = text_of(reference).ok();
        let value = text.and_then(|text| read(&text, Format::Ron).ok());
        let name = value.as_ref().and_then(|value| value.get("name")).and_then(Value::as_str);
        let stem = || Path::new(reference).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        name.map_or_else(stem, str::to_owned)
    }

    /// Reads the model in a file, and reports all of its errors. Returns `None` if the file cannot be read or has other contents.
    pub fn check(path: &str) -> Option<Result<RobotModel, Vec<ScenarioError>>> {
        let text = text_of(path).ok()?;
        let format = Format::of_path(Path::new(path))?;
        let value = read(&text, format).ok()?;
        let source = ScenarioSource::of_file(path, format, &text);
        if !is_model(&value) {
            return None;
        }
        if !is_file(path) {
            let message = "this is the model of a robot, which no scenario can name";
            return Some(Err(vec![source.error(&ScenarioFault::new(
                FieldPath::default(),
                message,
                "a name that ends in `.ron`",
            ))]));
        }
        Some(read_model(&source, value, 0).map(|model| model.named_by(path)))
    }

    fn load(path: &str, step: usize) -> Result<RobotModel, ModelError> {
        let text = text_of(path).map_err(|reason| ModelError::Unreadable { path: path.to_owned(), reason })?;
        Self::read_ron(path, &text, step)
    }

    /// The model of the text of a file. `path` is the file's name, for errors and for scenarios that name it.
    ///
    /// # Errors
    /// All that is wrong with it.
    pub fn from_ron(path: &str, text: &str) -> Result<RobotModel, ModelError> {
        Self::read_ron(path, text, 0)
    }

    fn read_ron(path: &str, text: &str, step: usize) -> Result<RobotModel, ModelError> {
        let source = ScenarioSource::of_file(path, Format::Ron, text);
        let value =
            read(&source.text, Format::Ron).map_err(|fault| ModelError::Wrong(vec![source.syntax_error(fault)]))?;
        read_model(&source, value, step).map(|model| model.named_by(path)).map_err(ModelError::Wrong)
    }
}

/// Returns the text of a model file, or why it cannot be read.
fn text_of(path: &str) -> Result<String, String> {
    let bytes = read_bytes(Path::new(path)).map_err(|problem| problem.to_string())?;
    if bytes.len() as u64 > LARGEST_FILE_BYTES {
        return Err(format!("it has more than {} MiB", LARGEST_FILE_BYTES >> 20));
    }
    String::from_utf8(bytes).map_err(|_| "it is not UTF-8 text".to_owned())
}

/// Reads a model from the values of a file, the `step`th of a chain of models, each like the next.
///
/// # Errors
/// All errors, in the order of the text.
fn read_model(source: &ScenarioSource, value: Value, step: usize) -> Result<RobotModel, Vec<ScenarioError>> {
    let mut findings = Vec::new();
    let Value::Object(mut fields) = value else {
        let fault = ScenarioFault::new(FieldPath::default(), "this is no model", an_object_with(&FIELDS));
        return Err(vec![source.error(&fault)]);
    };
    fields.remove(SCHEMA);
    let base = match base_of(source, &mut fields, step) {
        Ok(base) => base,
        Err(finding) => return Err(in_order(source.errors(&[finding]))),
    };
    if let Some(base) = &base {
        fields.entry("description").or_insert_with(|| base.description.clone().into());
        fields.entry("realistic").or_insert_with(|| json!({}));
        fields.entry("sources").or_insert_with(|| json!({}));
    }
    let name: String = take(&mut fields, "name", &mut findings);
    let description: String = take(&mut fields, "description", &mut findings);
    fields.entry("settings").or_insert_with(|| json!({}));
    let settings = take_settings(&mut fields, "settings", &[], &mut findings);
    let realistic = take_settings(&mut fields, "realistic", &REALISTIC_BESIDES, &mut findings);
    let sources: BTreeMap<String, String> = take(&mut fields, "sources", &mut findings);
    for name in fields.keys() {
        let message = format!("a model has no field {}{}", quoted(name), did_you_mean(name, FIELDS));
        let fault = ScenarioFault::new(FieldPath::default().key(name), message, one_of(FIELDS)).at_key();
        findings.push(Finding { kind: ScenarioErrorKind::Shape, fault });
    }
    let model = RobotModel { name, description, settings, realistic, sources, reference: String::new() };
    let mut model = if let Some(base) = base { model.laid_over(base) } else { model };
    leave_out_what_it_lacks(&mut model);
    let mut real = None;
    // The model must be valid both without and with its realistic settings.
    for (mut settings, is_real) in [(model.settings.clone(), false), (model.all_settings(), true)] {
        settings.insert("realism".to_owned(), json!("paper"));
        let found = match scenario_of(Value::Object(settings), |_| Vec::new()) {
            Ok(scenario) => {
                real = Some(scenario);
                continue;
            }
            Err(found) => found,
        };
        findings.extend(found.into_iter().map(|mut finding| {
            if model.is_of_nao(&finding.fault.path) {
                finding.fault.message.push_str(" (the NAO's, as the file does not say it)");
            }
            finding.fault.path = place_of(source, &finding.fault.path, is_real);
            finding.fault.related = finding.fault.related.map(|path| place_of(source, &path, is_real));
            finding
        }));
    }
    findings.extend(sources_of_nothing(&model, real.as_ref()).into_iter().map(Finding::from));
    if findings.is_empty() { Ok(model) } else { Err(in_order(source.errors(&findings))) }
}

/// Removes `like` from the fields of a model. Returns the model that it names, if it does.
fn base_of(
    source: &ScenarioSource,
    fields: &mut Map<String, Value>,
    step: usize,
) -> Result<Option<RobotModel>, Finding> {
    if !fields.contains_key(LIKE) {
        return Ok(None);
    }
    let mut findings = Vec::new();
    let like: String = take(fields, LIKE, &mut findings);
    if let Some(finding) = findings.pop() {
        return Err(finding);
    }
    let fault = |message: String, expected: String| {
        let fault = ScenarioFault::new(FieldPath::from(LIKE), message, expected);
        Finding { kind: ScenarioErrorKind::Shape, fault }
    };
    if step >= LONGEST_CHAIN {
        let message = format!("there are more than {LONGEST_CHAIN} models, each like the next");
        return Err(fault(message, "a model that is not like itself".to_owned()));
    }
    match RobotModel::find_within(&reference(&source.name, &like), step + 1) {
        Ok(base) => Ok(Some(base)),
        Err(error) => Err(fault(error.to_string(), error.expected())),
    }
}

/// Returns the faults of sources for paths that are no figures or groups of figures of the model. `real` is the scenario with all of its
/// settings.
fn sources_of_nothing(model: &RobotModel, real: Option<&Scenario>) -> Vec<ScenarioFault> {
    let own = Value::Object(model.all_settings());
    let others: Vec<&String> = model.sources.keys().filter(|path| !has_figures(&own, path)).collect();
    if others.is_empty() {
        return Vec::new();
    }
    // Default values are figures, too, and any setting of the NAO could be given.
    let nao = RobotModel::named(&Scenario::default().model).map(|nao| Value::Object(nao.all_settings()));
    let real = real.and_then(|real| serde_json::to_value(real).ok());
    let mut known = BTreeSet::new();
    for values in [Some(own), nao, real].into_iter().flatten() {
        for part in RobotSettings::OF_MODEL.iter().chain(&REALISTIC_BESIDES) {
            if let Some(value) = values.get(part) {
                collect_paths(part, value, &mut known);
            }
        }
    }
    let unknown = others.into_iter().filter(|path| !known.contains(*path));
    let fault = |path: &String| {
        let meant = did_you_mean(path, known.iter().map(String::as_str));
        let message = format!("a model has nothing called {}{meant}", quoted(path));
        let expected = "the path of a figure, such as `motion.max_linear_mps`, or of a group of them, such as `motion`";
        ScenarioFault::new(FieldPath::from("sources").key(path), message, expected).at_key()
    };
    unknown.map(fault).collect()
}

/// Returns whether there is a value at a path such as `cameras.mounts.0.tilt_deg`.
fn has_figures(values: &Value, path: &str) -> bool {
    fn step<'a>(value: &'a Value, step: &str) -> Option<&'a Value> {
        match value {
            Value::Array(elements) => elements.get(step.parse::<usize>().ok()?).filter(|element| element.is_object()),
            value => value.get(step),
        }
    }
    path.split('.').try_fold(values, step).is_some()
}

/// Collects the paths of a value and of all values in it.
fn collect_paths(path: &str, value: &Value, paths: &mut BTreeSet<String>) {
    paths.insert(path.to_owned());
    match value {
        Value::Object(fields) => {
            fields.iter().for_each(|(name, value)| collect_paths(&format!("{path}.{name}"), value, paths));
        }
        Value::Array(elements) if elements.iter().any(Value::is_object) => {
            let elements = elements.iter().enumerate();
            elements.for_each(|(index, value)| collect_paths(&format!("{path}.{index}"), value, paths));
        }
        _ => {}
    }
}

/// Removes a field and reads it as its type. Returns the default if that fails.
fn take<T: DeserializeOwned + Default>(
    fields: &mut Map<String, Value>,
    name: &'static str,
    findings: &mut Vec<Finding>,
) -> T {
    let fault = match fields.remove(name) {
        None => {
            let message = format!("the field {} is missing", quoted(name));
            ScenarioFault::new(FieldPath::default(), message, format!("a model with {}", all_of(FIELDS)))
        }
        Some(value) => match deserialize::read(&value) {
            Ok(value) => return value,
            Err(fault) => ScenarioFault::of_shape(&fault, &FieldPath::from(name)),
        },
    };
    findings.push(Finding { kind: ScenarioErrorKind::Shape, fault });
    T::default()
}

/// Removes a group of settings. Only settings that a model may have, and those in `besides`, are kept.
fn take_settings(
    fields: &mut Map<String, Value>,
    part: &'static str,
    besides: &[&'static str],
    findings: &mut Vec<Finding>,
) -> Map<String, Value> {
    let mut settings: Map<String, Value> = take(fields, part, findings);
    let allowed: Vec<&str> = RobotSettings::OF_MODEL.iter().chain(besides).copied().collect();
    settings.retain(|name, _| {
        let is_allowed = allowed.contains(&name.as_str());
        if !is_allowed {
            let message = format!("a model has no {}{}", quoted(name), did_you_mean(name, allowed.iter().copied()));
            let expected = one_of(allowed.iter().copied());
            let fault = ScenarioFault::new(FieldPath::from(part).key(name), message, expected).at_key();
            findings.push(Finding { kind: ScenarioErrorKind::Shape, fault });
        }
        is_allowed
    });
    settings
}

/// Returns the place in a model's file of a scenario's setting: in the realistic part if `is_real` and the value is there, otherwise in
/// `settings`.
fn place_of(source: &ScenarioSource, path: &FieldPath, is_real: bool) -> FieldPath {
    let [always, realistic] = ["settings", "realistic"].map(|part| path.clone().within(&FieldPath::from(part)));
    let found = source.steps_found(&realistic);
    if is_real && found > 1 && found >= source.steps_found(&always) { realistic } else { always }
}

fn an_object_with(names: &[&str]) -> String {
    format!("an object with {}", all_of(names.iter().copied()))
}
