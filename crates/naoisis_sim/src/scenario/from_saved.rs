//! Scenarios that continue a saved match: the field [`from`](super::Scenario::from).
//!
//! A file names the saved match, relative to its own folder: `{ "from": "lost_ball.naoisis", "expect": [...] }`. Values that the file does
//! not have are those of the match. After reading, the scenario contains the whole match in packed form, so that traces and other programs
//! need no other file.

use bevy::prelude::*;
use bevy::reflect::TypeRegistry;
use core::any::TypeId;
use core::marker::PhantomData;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::{Map, Value, json};
use std::io;
use std::path::Path;

use super::fault::ScenarioFault;
use super::field_path::FieldPath;
use super::format::Format;
use super::merge::lay_over;
use super::saved_match::{NamedValues, SavedMatch, SavedMatchError, read_parts};
use super::text::{ScenarioFile, ScenarioSource};
use super::types::Scenario;
use naoisis_core::cycle::CycleClock;
use naoisis_core::read_file::read_file;

/// Name of the scenario's field.
const FIELD: &str = "from";

impl SavedMatch {
    /// Reads a saved match from the bytes of its file.
    ///
    /// # Errors
    /// The fault of the bytes.
    pub fn of_bytes(bytes: &[u8]) -> Result<SavedMatch, SavedMatchError> {
        SavedMatch::pack(Head::read(bytes)?.clock.cycle, bytes)
    }

    /// Returns the scenario of the match, as read from a file without other fields.
    ///
    /// # Errors
    /// If the saved match is damaged.
    pub fn scenario(&self) -> Result<Scenario, SavedMatchError> {
        let scenario = Scenario { from: None, ..Head::read(&self.bytes()?)?.scenario };
        let text = scenario.resolved_json().map_err(|error| SavedMatchError::Content(error.to_string()))?;
        let file = ScenarioFile::from_text(&text, Format::Json, "the saved match");
        file.map(|file| file.scenario).map_err(|error| SavedMatchError::Content(error.to_string()))
    }
}

/// The parts of a saved match that are read before its robots.
struct Head {
    scenario: Scenario,
    clock: CycleClock,
}

impl Head {
    fn read(bytes: &[u8]) -> Result<Head, SavedMatchError> {
        let mut registry = TypeRegistry::default();
        registry.register::<Scenario>();
        registry.register::<CycleClock>();
        let find = |name: &str| {
            Ok(match name {
                "naoisis::Scenario" => registry.get(TypeId::of::<Scenario>()),
                "naoisis::CycleClock" => registry.get(TypeId::of::<CycleClock>()),
                _ => None,
            })
        };
        let resources = NamedValues { registry: &registry, find };
        let (values, IgnoredAny) = read_parts(bytes, resources, PhantomData::<IgnoredAny>)?;
        let missing = |what: &str| SavedMatchError::Content(format!("it has no {what}"));
        Ok(Head {
            scenario: value_of(&values).ok_or_else(|| missing("scenario"))?,
            clock: value_of(&values).ok_or_else(|| missing("clock"))?,
        })
    }
}

/// Returns the first value of this type.
fn value_of<T: Reflect + Clone>(values: &[Box<dyn Reflect>]) -> Option<T> {
    values.iter().find_map(|value| value.as_any().downcast_ref()).cloned()
}

/// Fills in the values of the saved match that a file names, if there is one. The path of the match is relative to the file.
///
/// # Errors
/// The fault of the saved match.
pub(super) fn fill_in(source: &ScenarioSource, root: &mut Value) -> Result<(), ScenarioFault> {
    let Some(from) = root.get(FIELD).filter(|from| !from.is_null()) else { return Ok(()) };
    let fault = |message: String, expected: &str| Err(ScenarioFault::new(FieldPath::from(FIELD), message, expected));
    let (saved, name) = match from {
        Value::String(name) => {
            let beside = Path::new(&source.name).parent().unwrap_or(Path::new("")).join(name);
            let expected = "a match that was saved (`naoisis run --save`), beside this file";
            let bytes = match read_file(&beside) {
                Ok(bytes) => bytes,
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    return fault(format!("there is no file `{}`", beside.display()), expected);
                }
                Err(error) => return fault(format!("`{}` cannot be read: {error}", beside.display()), expected),
            };
            match SavedMatch::of_bytes(&bytes) {
                Ok(saved) => (saved, format!("`{}`", beside.display())),
                Err(message) => {
                    return fault(format!("`{}` is no saved match: {message}", beside.display()), expected);
                }
            }
        }
        packed => match SavedMatch::deserialize(packed) {
            Ok(saved) => (saved, "it".to_owned()),
            Err(_) => {
                return fault("this is no saved match".to_owned(), "the path of one, such as `moment.naoisis`");
            }
        },
    };
    let base = saved.scenario().and_then(|scenario| {
        serde_json::to_value(scenario).map_err(|error| SavedMatchError::Content(error.to_string()))
    });
    let mut base = match base {
        Ok(Value::Object(base)) => base,
        Ok(_) => Map::new(),
        Err(message) => return fault(format!("{name} is no saved match: {message}"), "a match as it was saved"),
    };
    // The duration and the expectations are those of the file alone.
    for own in ["duration_s", "expect"] {
        base.remove(own);
    }
    let Value::Object(mut file) = core::mem::take(root) else { return Ok(()) };
    file.insert(FIELD.to_owned(), json!(saved));
    lay_over_teams(&mut base, &mut file);
    lay_over_robots(&mut base, &mut file);
    let mut filled = Value::Object(base);
    lay_over(&mut filled, Value::Object(file), "");
    *root = filled;
    Ok(())
}

/// Treats a word for a team as its name, so that its robots keep their own settings.
fn lay_over_teams(base: &mut Map<String, Value>, file: &mut Map<String, Value>) {
    let (Some(Value::Object(base)), Some(Value::Object(file))) = (base.get_mut("teams"), file.get_mut("teams")) else {
        return;
    };
    for (team, own) in file.iter_mut() {
        let name = |value: &Value| value.as_str().map(|name| json!({ "team": name }));
        match (base.get_mut(team), name(own)) {
            (Some(Value::Object(_)), Some(named)) => *own = named,
            (Some(base), None) => *base = name(base).unwrap_or_default(),
            _ => {}
        }
    }
}

/// Lays the robots of the file over those of the match with the same team and number.
fn lay_over_robots(base: &mut Map<String, Value>, file: &mut Map<String, Value>) {
    let Some(Value::Array(of_file)) = file.get("robots") else { return };
    let Some(Value::Array(of_match)) = base.get_mut("robots") else { return };
    let id = |robot: &Value| {
        let team = robot.get("team").and_then(Value::as_str).unwrap_or("blue").to_owned();
        robot.get("number").and_then(Value::as_u64).map(|number| (team, number))
    };
    let place = |robot: &Value| of_match.iter().position(|other| id(robot).is_some() && id(other) == id(robot));
    // Robots without a number, or that are not in the match, become faults when the match starts.
    let Some(places) = of_file.iter().map(place).collect::<Option<Vec<usize>>>() else { return };
    let Some(Value::Array(of_file)) = file.remove("robots") else { return };
    for (place, own) in places.into_iter().zip(of_file) {
        if let (Some(behaviour), Some(fields)) = (own.get("behaviour").cloned(), of_match[place].as_object_mut()) {
            // A new behaviour replaces the old one as a whole.
            fields.insert("behaviour".to_owned(), behaviour);
        }
        lay_over(&mut of_match[place], own, "");
    }
}
