//! The settings that a scenario's realism stands for.

use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::sync::LazyLock;

use super::fault::ScenarioFault;
use super::field_path::FieldPath;
use super::layers::lay_over;
use super::message_limits;
use super::models::{ModelError, RobotModel, expected_model, is_file};
use super::realism::{Realism, Realisms};
use super::types::Scenario;

/// What a scenario has where it says nothing itself, by parts; of the paper's nothing, which are the defaults. Presets in it are
/// names still.
///
/// A model that there is not is taken out, and becomes a fault.
pub fn settings_of(root: &mut Map<String, Value>, faults: &mut Vec<ScenarioFault>) -> Map<String, Value> {
    let realisms = realisms_of(root);
    let model = match root.get("model") {
        None => RobotModel::named(&Scenario::default().model),
        Some(reference) => match find(reference) {
            Ok(model) => Some(model),
            // What says all itself, as the header of a trace does, needs no file of a model.
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

/// The words of a scenario for its realism. What is wrong with them is found when the types are read.
pub fn realisms_of(root: &Map<String, Value>) -> Option<Realisms> {
    match root.get("realism") {
        None => Some(Realisms::default()),
        Some(words) => Realisms::deserialize(words).ok(),
    }
}

/// What robots of a model have in this realism: what they always have, and over it what the realism of each part says. What the
/// model does not say of itself is as the NAO's.
pub fn settings_of_model(model: &RobotModel, realisms: Realisms) -> Map<String, Value> {
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

/// What the realism of each part says.
fn by_parts(realisms: Realisms, realistic: &Map<String, Value>) -> Map<String, Value> {
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

/// The model of its own that a robot, or a team, names. One that there is not becomes a fault, unless all `settings` are there.
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

/// What is wrong with a `model`.
enum NoModel {
    /// It names one that cannot be had.
    Error(ModelError),
    /// It is no name.
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

/// The model that a scenario names, or what is wrong with that.
fn find(reference: &Value) -> Result<RobotModel, NoModel> {
    let name = reference.as_str().ok_or(NoModel::NoName)?;
    RobotModel::find(name).map_err(NoModel::Error)
}

/// Whether there are settings for every part that a realism has.
fn says_all(root: &Map<String, Value>, realisms: Option<Realisms>) -> bool {
    realisms.unwrap_or_default().parts().all(|(part, _)| root.contains_key(part))
}

/// What is different from the paper without noise.
fn ideal() -> Map<String, Value> {
    let settings = [
        ("vision", json!({ "noise": "none" })),
        ("odometry", json!({ "noise": "none" })),
        ("sonar", json!({ "noise": "none", "miss_probability": 0.0, "crosstalk_probability": 0.0 })),
    ];
    settings.into_iter().map(|(part, value)| (part.to_owned(), value)).collect()
}
