//! The settings that a scenario's realism stands for.

use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::fault::ScenarioFault;
use super::field_path::FieldPath;
use super::models::{MODELS, RobotModel};
use super::realism::{Realism, Realisms};
use super::types::Scenario;
use super::wording::{did_you_mean, one_of, quoted};

/// What a scenario has where it says nothing itself, by parts; of the paper's nothing, which are the defaults. Presets in it are
/// names still.
///
/// A model that there is not is taken out, and becomes a fault.
pub fn settings_of(root: &mut Map<String, Value>, faults: &mut Vec<ScenarioFault>) -> Map<String, Value> {
    let model = match root.get("model") {
        None => RobotModel::named(&Scenario::default().model),
        Some(name) => {
            let model = name.as_str().and_then(RobotModel::named);
            if model.is_none() {
                faults.push(no_model(name));
                root.remove("model");
            }
            model
        }
    };
    // What is wrong with the words is found when the types are read.
    let Some(realisms) = root.get("realism").and_then(|words| Realisms::deserialize(words).ok()) else {
        return Map::new();
    };
    let [ideal, realistic] = [ideal(), model.map(|model| model.realistic).unwrap_or_default()];
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

/// What is wrong with what is no model's name.
fn no_model(name: &Value) -> ScenarioFault {
    let names: Vec<&str> = MODELS.iter().map(|preset| preset.name).collect();
    let message = match name.as_str() {
        Some(name) => format!("there is no model {}{}", quoted(name), did_you_mean(name, names.iter().copied())),
        None => "`model` is no name of a model".to_owned(),
    };
    ScenarioFault::new(FieldPath::from("model"), message, one_of(names))
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
