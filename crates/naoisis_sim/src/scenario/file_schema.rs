//! Derives the JSON Schema of the files from their types, so that editors can complete and check them.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

use super::fidelity;
use super::leagues::LEAGUES;
use super::models::MODELS;
use super::parse::SCHEMA;
use super::preset::Preset;
use super::presets::{BALL_PRESETS, FIELD_PRESETS, RULES_PRESETS};
use super::robot_settings::RobotSettings;
use super::types::ScenarioForm;
use naoisis_core::game::Rules;

/// A kind of file.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum FileKind {
    /// A scenario.
    Scenario,
    /// The model of a robot.
    Robot,
    /// A league.
    League,
    /// Rules.
    Rules,
}

impl FileKind {
    /// All kinds of files.
    pub const ALL: [FileKind; 4] = [FileKind::Scenario, FileKind::Robot, FileKind::League, FileKind::Rules];

    /// Returns the name of the kind.
    pub fn name(self) -> &'static str {
        match self {
            FileKind::Scenario => "scenario",
            FileKind::Robot => "robot",
            FileKind::League => "league",
            FileKind::Rules => "rules",
        }
    }

    /// Returns the JSON Schema (draft 7, which most editors support) of files of this kind, with the ranges that are checked when a file is
    /// read.
    pub fn schema(self) -> Value {
        let mut schema = match self {
            FileKind::Rules => schema_of::<Rules>(),
            _ => scenario_schema(),
        };
        if let Some(own) = self.fields(&schema) {
            schema["properties"] = own;
        }
        schema["title"] = self.name().into();
        schema["properties"][SCHEMA] = json!({ "type": "string" });
        tidy(&mut schema);
        leave_out_unused(&mut schema);
        schema
    }

    /// Returns the fields of a robot or league file, which contains settings of a scenario. Returns `None` for other files.
    fn fields(self, scenario: &Value) -> Option<Value> {
        let fields = scenario.get("properties")?;
        let of_model = || model_fields(fields);
        let object = |fields: Map<String, Value>| json!({ "type": "object", "properties": fields, "additionalProperties": false });
        let settings = match self {
            FileKind::Scenario | FileKind::Rules => return None,
            FileKind::Robot => {
                let like = "The model from which this one starts: its name, or the path of its file. All other figures are changes.";
                let names: Vec<&str> = MODELS.iter().map(|preset| preset.name).collect();
                json!({
                    "like": { "type": "string", "examples": names, "description": like },
                    "settings": object(of_model()),
                    "realistic": object(with_ball(of_model(), fields)),
                })
            }
            FileKind::League => json!({ "settings": object(fields.as_object()?.clone()) }),
        };
        let mut all = json!({
            "name": { "type": "string" },
            "description": { "type": "string", "description": "What it is, in a sentence." },
            "sources": {
                "type": "object",
                "description": "Where each figure is from, by its path. A guess begins with `guess:`.",
                "additionalProperties": { "type": "string" },
            },
        });
        for (name, value) in settings.as_object()? {
            all[name] = value.clone();
        }
        Some(all)
    }
}

fn schema_of<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft07().with(|settings| settings.meta_schema = Some(DRAFT.into()));
    settings.into_generator().into_root_schema_for::<T>().into()
}

const DRAFT: &str = "http://json-schema.org/draft-07/schema#";

/// Returns the schema of scenario files: presets can be names, and all fields are optional.
fn scenario_schema() -> Value {
    let mut schema = schema_of::<ScenarioForm>();
    let names = |presets: &[Preset]| presets.iter().map(|preset| preset.name).collect::<Vec<_>>();
    let noises = ["none", "default"];
    let presets = [
        ("Pitch", names(FIELD_PRESETS)),
        ("Rules", names(RULES_PRESETS)),
        ("BallSpec", names(BALL_PRESETS)),
        ("VisionNoise", noises.to_vec()),
        ("OdometryNoise", noises.to_vec()),
    ];
    for (definition, names) in presets {
        let object = &mut schema["definitions"][definition];
        object["properties"]["preset"] =
            json!({ "enum": names, "description": "What the other fields are changes of." });
        *object = json!({ "anyOf": [{ "enum": names }, object.take()] });
    }
    let mut model = model_fields(&schema["properties"]);
    let name = json!({ "type": "string", "examples": names(MODELS), "description": "The name of a model, or the path of its file." });
    model.insert("preset".to_owned(), name.clone());
    schema["definitions"]["Model"] =
        json!({ "anyOf": [name, { "type": "object", "properties": model, "additionalProperties": false }] });
    schema["properties"]["league"] =
        json!({ "enum": names(LEAGUES), "description": "The league whose settings hold where none are given here." });
    schema["properties"]["from"] =
        json!({ "type": "string", "description": "The path of the saved match that it goes on from." });
    for holder in ["", "/definitions/RobotSpec", "/definitions/EntryForm"] {
        if let Some(fields) = schema.pointer_mut(&format!("{holder}/properties")) {
            fields["model"] = json!({ "$ref": "#/definitions/Model" });
            fields[fidelity::FIELD] = json!({ "deprecated": true, "description": "Old; say the sensors' `source` and `noise`, or `realism`." });
        }
    }
    schema
}

/// Returns the fields of a scenario that a model's settings can have.
fn model_fields(scenario: &Value) -> Map<String, Value> {
    let field = |name: &&str| Some(((*name).to_owned(), scenario.get(*name)?.clone()));
    RobotSettings::OF_MODEL.iter().filter_map(field).collect()
}

fn with_ball(mut fields: Map<String, Value>, scenario: &Value) -> Map<String, Value> {
    fields.extend(scenario.get("ball").map(|ball| ("ball".to_owned(), ball.clone())));
    fields
}

/// Removes the lists of required fields, as files have only what differs from the defaults, and shortens numbers to the digits of single
/// precision.
fn tidy(schema: &mut Value) {
    match schema {
        Value::Object(fields) => {
            // A variant is an object with one field, which stays required.
            if fields.get("properties").and_then(Value::as_object).is_some_and(|fields| fields.len() > 1) {
                fields.remove("required");
            }
            fields.remove("format");
            // The defaults of an object are given with its fields.
            if fields.get("default").is_some_and(Value::is_object) {
                fields.remove("default");
            }
            fields.values_mut().for_each(tidy);
        }
        Value::Array(elements) => elements.iter_mut().for_each(tidy),
        Value::Number(number) if number.is_f64() => {
            let short = number.as_f64().map(|number| (number as f32).to_string());
            if let Some(short) = short.and_then(|short| short.parse::<f64>().ok()) {
                *schema = json!(short);
            }
        }
        _ => {}
    }
}

/// Removes unused definitions.
fn leave_out_unused(schema: &mut Value) {
    let Some(Value::Object(mut definitions)) = schema.get_mut("definitions").map(Value::take) else { return };
    let mut used = Map::new();
    let mut wanted = Vec::new();
    references(schema, &mut wanted);
    while let Some(reference) = wanted.pop() {
        if let Some((name, definition)) = definitions.remove_entry(reference.trim_start_matches("#/definitions/")) {
            references(&definition, &mut wanted);
            used.insert(name, definition);
        }
    }
    schema["definitions"] = used.into();
}

/// Collects the definitions that a schema refers to.
fn references(schema: &Value, found: &mut Vec<String>) {
    match schema {
        Value::Object(fields) => {
            found.extend(fields.get("$ref").and_then(Value::as_str).map(str::to_owned));
            fields.values().for_each(|value| references(value, found));
        }
        Value::Array(elements) => elements.iter().for_each(|value| references(value, found)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    #[test]
    fn ranges_in_the_schema_are_those_of_validation() {
        let schema = FileKind::Scenario.schema();
        let speed = &schema["definitions"]["MotionSettings"]["properties"]["max_linear_mps"];
        let most = speed["maximum"].as_f64().unwrap();
        let read = |speed: f64| Scenario::from_json(&json!({ "motion": { "max_linear_mps": speed } }).to_string());
        assert!(read(most).is_ok() && read(most + 0.01).is_err());
        assert!(speed["description"].as_str().unwrap().starts_with("Greatest speed"), "{speed}");
    }

    #[test]
    fn every_definition_that_is_named_is_there() {
        for kind in FileKind::ALL {
            let (schema, mut found) = (kind.schema(), Vec::new());
            references(&schema, &mut found);
            for reference in &found {
                assert!(schema.pointer(reference.trim_start_matches('#')).is_some(), "{}: {reference}", kind.name());
            }
            assert!(!found.is_empty(), "{}", kind.name());
        }
    }

    #[test]
    fn a_file_may_name_its_schema() {
        let text = r#"{ "$schema": "scenario.json", "seed": 3 }"#;
        assert_eq!(Scenario::from_json(text).unwrap().seed, 3);
        assert!(Scenario::from_json(r#"{ "robots": [{ "$schema": "x" }] }"#).is_err());
    }
}
