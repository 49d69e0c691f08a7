//! The settings for the realism of a scenario.

use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::sync::LazyLock;

use super::fault::ScenarioFault;
use super::field_path::FieldPath;
use super::merge::lay_over;
use super::message_limits;
use super::models::{ModelError, RobotModel, expected_model, is_file};
use super::realism::{Realism, RealismSettings};
use super::types::Scenario;

/// Returns the settings that apply where the scenario does not have its own, for each part. Nothing is returned for the paper, whose
/// settings are the defaults. Presets are still names.
///
/// An unknown model is removed and becomes a fault.
pub fn settings_of(root: &mut Map<String, Value>, faults: &mut Vec<ScenarioFault>) -> Map<String, Value> {
    let realisms = realisms_of(root);
    let model = match root.get("model") {
        None => RobotModel::named(&Scenario::default().model),
        Some(reference) => match find(reference) {
            Ok(model) => Some(model),
            // A scenario with all settings, such as the header of a trace, does not need the file of its model.
            Err(_) if reference.as_str().is_some_and(is_file) && says_all(root, realisms) => None,
            Err(wrong) => {
                faults.extend(wrong.at(&FieldPath::from("model")));
                root.remove("model");
                None
            }
        },
    };
    let Some(realisms) = realisms else { return Map::new() };
    let mut settings = match model {
        Some(model) => settings_of_model(&model, realisms),
        None => by_parts(realisms, &Map::new()),
    };
    message_limits::make_of_robots(&mut settings);
    settings
}

/// Returns the scenario's words for its realism. Errors in them are found when the types are read.
pub fn realisms_of(root: &Map<String, Value>) -> Option<RealismSettings> {
    match root.get("realism") {
        None => Some(RealismSettings::default()),
        Some(words) => RealismSettings::deserialize(words).ok(),
    }
}

/// Returns the settings of a model's robots with this realism: those that always apply, and over them those of each part's realism.
/// Settings that the model does not have are those of the NAO.
pub fn settings_of_model(model: &RobotModel, realisms: RealismSettings) -> Map<String, Value> {
    static NAO: LazyLock<Map<String, Value>> =
        LazyLock::new(|| RobotModel::named(&Scenario::default().model).map_or_else(Map::new, |model| model.settings));
    let mut settings = Value::Object(NAO.clone());
    lay_over(&mut settings, Value::Object(model.settings.clone()), "");
    lay_over(&mut settings, Value::Object(by_parts(realisms, &model.realistic)), "");
    match settings {
        Value::Object(settings) => settings,
        _ => Map::new(),
    }
}

/// Returns the settings for the realism of each part.
fn by_parts(realisms: RealismSettings, realistic: &Map<String, Value>) -> Map<String, Value> {
    let ideal = ideal();
    let of_part = |(part, realism): (&str, Realism)| {
        let settings = match realism {
            Realism::Paper => None,
            Realism::Ideal => ideal.get(part),
            Realism::Realistic => realistic.get(part),
        };
        Some((part.to_owned(), settings?.clone()))
    };
    realisms.parts().filter_map(of_part).collect()
}

/// Returns the own model of a robot or a team. An unknown model becomes a fault, unless the robot has all `settings`.
pub fn model_of(
    robot: &mut Map<String, Value>,
    path: &FieldPath,
    settings: &[&str],
    faults: &mut Vec<ScenarioFault>,
) -> Option<RobotModel> {
    let reference = robot.get("model").filter(|model| !model.is_null())?;
    match find(reference) {
        Ok(model) => Some(model),
        Err(_)
            if reference.as_str().is_some_and(is_file)
                && settings.iter().all(|field| *field == "messages" || robot.contains_key(*field)) =>
        {
            None
        }
        Err(wrong) => {
            faults.extend(wrong.at(&path.field("model")));
            robot.remove("model");
            None
        }
    }
}

/// A fault of a `model`.
enum NoModel {
    /// The named model is not available.
    Error(ModelError),
    /// The value is no name.
    NoName,
}

impl NoModel {
    fn at(self, path: &FieldPath) -> Vec<ScenarioFault> {
        match self {
            NoModel::Error(error) => error.faults(path),
            NoModel::NoName => {
                vec![ScenarioFault::new(path.clone(), "`model` is no name of a model", expected_model())]
            }
        }
    }
}

/// Finds the model that a scenario names.
fn find(reference: &Value) -> Result<RobotModel, NoModel> {
    let name = reference.as_str().ok_or(NoModel::NoName)?;
    RobotModel::find(name).map_err(NoModel::Error)
}

/// Returns whether the scenario has settings for every part with a realism.
fn says_all(root: &Map<String, Value>, realisms: Option<RealismSettings>) -> bool {
    realisms.unwrap_or_default().parts().all(|(part, _)| root.contains_key(part))
}

/// Returns the settings of `ideal` that differ from the paper: no noise.
fn ideal() -> Map<String, Value> {
    let settings = [
        ("vision", json!({ "noise": "none" })),
        ("odometry", json!({ "noise": "none" })),
        ("sonar", json!({ "noise": "none", "miss_probability": 0.0, "crosstalk_probability": 0.0 })),
    ];
    settings.into_iter().map(|(part, value)| (part.to_owned(), value)).collect()
}
