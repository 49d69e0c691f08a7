//! Models: the figures of real robots, each with its source, in RON files. Some are embedded in the program; users can add their own.

use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::Path;

use super::deserialize;
use super::error::ScenarioError;
use super::fault::ScenarioFault;
use super::field_path::FieldPath;
use super::merge::lay_over;
use super::preset::{Preset, presets};
use super::types::Scenario;
use super::wording::{did_you_mean, one_of, quoted};
use naoisis_core::kick_geometry::KickType;

/// The models that come with the program: `assets/robots`.
pub const MODELS: &[Preset] = presets!["robots": "booster_k1" "booster_t1" "nao" "nao_v6" "rover"];

/// Returns whether the name of a scenario's model is the path of a file.
pub(super) fn is_file(reference: &str) -> bool {
    Path::new(reference).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ron"))
}

/// The model of a real robot, with the settings of its league.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct RobotModel {
    /// Name of the model.
    pub name: String,
    /// Description, one sentence.
    pub description: String,
    /// Settings that apply with any realism: the robot's body, head, cameras and kicks, and how fast it walks.
    #[serde(default)]
    pub settings: Map<String, Value>,
    /// Settings that apply if they are to be realistic.
    pub realistic: Map<String, Value>,
    /// The source of each figure, by its path. A guess without a source begins with `guess:`.
    pub sources: BTreeMap<String, String>,
    /// Name in scenarios: that of a built-in model, or the path of its file.
    #[serde(skip)]
    pub(super) reference: String,
}

/// Why a model is not available.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// There is no built-in model with this name.
    #[error("there is no model {}{}", quoted(.0), did_you_mean(.0, MODELS.iter().map(|preset| preset.name)))]
    Unknown(String),
    /// The file cannot be read.
    #[error("the model's file {} cannot be read: {reason}", quoted(.path))]
    Unreadable {
        /// The file.
        path: String,
        /// The operating system's error.
        reason: String,
    },
    /// The file is no model, or its robot is not possible: all errors, in the order of the text.
    #[error("the model's file is wrong: {}", .0.first().map(ScenarioError::headline).unwrap_or_default())]
    Wrong(Vec<ScenarioError>),
}

naoisis_core::debug_as_displayed!(ModelError);

impl ModelError {
    /// Returns what was expected instead of the first fault.
    pub fn expected(&self) -> String {
        match self {
            ModelError::Wrong(errors) => errors.first().map(|error| error.expected().to_owned()).unwrap_or_default(),
            _ => expected_model(),
        }
    }

    /// Returns the faults of a scenario that names the model at `path`.
    pub(super) fn faults(&self, path: &FieldPath) -> Vec<ScenarioFault> {
        let fault = |message: String, expected: String| ScenarioFault::new(path.clone(), message, expected);
        match self {
            ModelError::Wrong(errors) => errors
                .iter()
                .map(|error| {
                    let message = format!("the model's file is wrong: {}", error.headline());
                    fault(message, error.expected().to_owned())
                })
                .collect(),
            _ => vec![fault(self.to_string(), self.expected())],
        }
    }
}

/// Describes what is expected in place of a model's name.
pub(super) fn expected_model() -> String {
    format!("{}, or the path of a `.ron` file", one_of(MODELS.iter().map(|preset| preset.name)))
}

impl RobotModel {
    /// Returns the model with this name among the [`MODELS`].
    pub fn named(name: &str) -> Option<RobotModel> {
        let preset = MODELS.iter().find(|preset| preset.name == name)?;
        // A test reads all embedded files.
        let mut model: RobotModel = deserialize::read(&preset.value()).ok()?;
        leave_out_what_it_lacks(&mut model);
        Some(model.named_by(name))
    }

    pub(super) fn named_by(self, reference: &str) -> RobotModel {
        RobotModel { reference: reference.to_owned(), ..self }
    }

    /// Returns all settings of the robot, including the realistic ones.
    pub fn all_settings(&self) -> Map<String, Value> {
        let mut settings = Value::Object(self.settings.clone());
        lay_over(&mut settings, Value::Object(self.realistic.clone()), "");
        match settings {
            Value::Object(settings) => settings,
            _ => Map::new(),
        }
    }

    /// Returns the name in scenarios: that of a built-in model, or the path of its file.
    pub fn reference(&self) -> &str {
        &self.reference
    }

    /// Returns a scenario with this model and `realistic` settings.
    ///
    /// # Errors
    /// If its settings make no valid scenario.
    pub fn scenario(&self) -> Result<Scenario, ScenarioError> {
        Scenario::from_json(&json!({ "model": self.reference, "realism": "realistic" }).to_string())
    }

    /// Returns the paths of figures without a source. A group in which no figure has a source is listed as a whole.
    pub fn without_source(&self) -> Vec<String> {
        let mut paths = Vec::new();
        self.collect_without_source("", &Value::Object(self.all_settings()), &mut paths);
        paths
    }

    /// Collects the paths below `path`. Returns whether no figure there has a source.
    fn collect_without_source(&self, path: &str, value: &Value, paths: &mut Vec<String>) -> bool {
        let Value::Object(fields) = value else {
            let lacks = self.source(path).is_none();
            if lacks {
                paths.push(path.to_owned());
            }
            return lacks;
        };
        let before = paths.len();
        let mut lacks = !fields.is_empty();
        for (name, value) in fields {
            let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            lacks &= self.collect_without_source(&path, value, paths);
        }
        if lacks && !path.is_empty() {
            paths.truncate(before);
            paths.push(path.to_owned());
        }
        lacks
    }

    /// Returns whether the model itself has a value at a path such as `kicks.wind_up_s`: a figure, a group of figures, or a word for a
    /// group.
    pub fn says(&self, path: &str) -> bool {
        let mut value = &Value::Object(self.all_settings());
        for name in path.split('.') {
            match value {
                Value::Object(fields) => match fields.get(name) {
                    Some(field) => value = field,
                    None => return false,
                },
                _ => break,
            }
        }
        true
    }

    /// Returns the source of the figure at a path such as `kicks.wind_up_s`, or that of its group.
    pub fn source(&self, path: &str) -> Option<&str> {
        let own = self.sources.get(path).map(String::as_str);
        own.or_else(|| path.rsplit_once('.').and_then(|(group, _)| self.source(group)))
    }
}

/// Returns whether settings have a trunk: they describe another robot, not a NAO with changes.
pub(super) fn has_a_trunk_of_its_own(settings: &Map<String, Value>) -> bool {
    settings.get("body").and_then(|body| body.get("torso")).is_some()
}

/// Removes from a robot with its own trunk the parts that its file does not have, which would otherwise be the NAO's: head joints, cameras,
/// sonars, kicks, legs, arms and looks.
pub(super) fn leave_out_what_it_lacks(model: &mut RobotModel) {
    let RobotModel { settings, realistic, sources, .. } = model;
    if !has_a_trunk_of_its_own(settings) {
        return;
    }
    let mut lacks = |path: &str, source: &str| {
        sources.entry(path.to_owned()).or_insert_with(|| source.to_owned());
    };
    let absent = [
        ("head", json!({ "yaw_deg": [0.0, 0.0], "pitch_deg": [0.0, 0.0], "pitch_at_yaw_deg": [], "max_degps": 0.0 })),
        ("cameras", json!({ "mounts": [] })),
        ("sonar", json!({ "fitted": false })),
    ];
    for (part, nothing) in absent {
        if !realistic.contains_key(part) && !settings.contains_key(part) {
            settings.insert(part.to_owned(), nothing);
            lacks(part, "the file says nothing of it: it has none");
        }
    }
    let kicks = |settings: &Map<String, Value>| settings.get("kicks").cloned().unwrap_or_else(|| json!({}));
    let [mut own, real] = [&*settings, &*realistic].map(kicks);
    if let (Some(own), Some(real)) = (own.as_object_mut(), real.as_object()) {
        for kick in KickType::ALL.iter().map(KickType::name) {
            if !own.contains_key(kick) && !real.contains_key(kick) {
                own.insert(kick.to_owned(), json!({ "max_distance_m": 0.0 }));
                lacks(&format!("kicks.{kick}"), "the file says nothing of it: it has none");
            }
        }
    }
    // A value that is no object is reported elsewhere.
    settings.insert("kicks".to_owned(), own);
    let of_body = [("legs", Value::Null), ("arms", Value::Null), ("look", json!("light"))];
    if let Some(Value::Object(body)) = settings.get_mut("body") {
        for (part, nothing) in of_body {
            if !body.contains_key(part) {
                body.insert(part.to_owned(), nothing);
                lacks(&format!("body.{part}"), "the file says nothing of it");
            }
        }
        if let Some(Value::Object(look)) = body.get_mut("look") {
            look.entry("shape").or_insert_with(|| json!("measures"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Collects the paths of all figures.
    fn figures(path: &str, value: &Value, into: &mut Vec<String>) {
        match value {
            Value::Object(fields) => {
                for (name, value) in fields {
                    figures(&if path.is_empty() { name.clone() } else { format!("{path}.{name}") }, value, into);
                }
            }
            _ => into.push(path.to_owned()),
        }
    }

    #[test]
    fn figures_without_a_source_are_named_by_groups() {
        let mut model = RobotModel::named("rover").unwrap();
        assert_eq!(model.without_source(), [""; 0]);
        for source in ["sonar", "falls", "head"] {
            model.sources.remove(source);
        }
        model.sources.insert("head.max_degps".to_owned(), "guess".to_owned());
        assert_eq!(model.without_source(), ["falls", "head.pitch_deg", "head.yaw_deg", "sonar"]);
    }

    #[test]
    fn every_figure_has_its_source_and_every_source_a_figure() {
        for preset in MODELS {
            let model = RobotModel::named(preset.name).unwrap_or_else(|| panic!("{} is not read", preset.name));
            assert_eq!(model.name, preset.name);
            let mut paths = Vec::new();
            figures("", &Value::Object(model.all_settings()), &mut paths);
            for path in &paths {
                assert!(model.source(path).is_some(), "{}: {path} has no source", model.name);
            }
            for source in model.sources.keys() {
                let is_of = |path: &String| path == source || path.starts_with(&format!("{source}."));
                assert!(paths.iter().any(is_of), "{}: {source} is no figure", model.name);
            }
        }
    }
}
