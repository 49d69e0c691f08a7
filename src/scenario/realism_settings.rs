//! The settings that a scenario's realism stands for.

use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::fault::ScenarioFault;
use super::field_path::FieldPath;
use super::models::{MODELS, RobotModel, is_file};
use super::realism::{Realism, Realisms};
use super::types::Scenario;
use super::wording::one_of;

/// What a scenario has where it says nothing itself, by parts; of the paper's nothing, which are the defaults. Presets in it are
/// names still.
///
/// A model that there is not is taken out, and becomes a fault.
pub fn settings_of(root: &mut Map<String, Value>, faults: &mut Vec<ScenarioFault>) -> Map<String, Value> {
    // What is wrong with the words is found when the types are read.
    let realisms = root.get("realism").and_then(|words| Realisms::deserialize(words).ok());
    let model = match root.get("model") {
        None => RobotModel::named(&Scenario::default().model),
        Some(reference) => match find(reference) {
            Ok(model) => Some(model),
            // What says all itself, as the header of a trace does, needs no file of a model.
            Err(_) if reference.as_str().is_some_and(is_file) && says_all(root, realisms) => None,
            Err(message) => {
                let names = MODELS.iter().map(|preset| preset.name);
                let expected = format!("{}, or the path of a `.ron` file", one_of(names));
                faults.push(ScenarioFault::new(FieldPath::from("model"), message, expected));
                root.remove("model");
                None
            }
        },
    };
    let Some(realisms) = realisms else { return Map::new() };
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

/// The model that a scenario names, or what is wrong with that.
fn find(reference: &Value) -> Result<RobotModel, String> {
    let name = reference.as_str().ok_or_else(|| "`model` is no name of a model".to_owned())?;
    RobotModel::find(name).map_err(|error| error.to_string())
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
