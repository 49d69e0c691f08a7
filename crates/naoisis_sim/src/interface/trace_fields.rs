//! The fields of a trace's lines, derived from the types of the record, for selecting fields and for the table in the guide.

use schemars::generate::SchemaSettings;
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::LazyLock;

use super::cycle_record::CycleRecord;
use crate::scenario::wording::one_of;

/// The names of all fields with the names of their parents (such as `robots.pose`), and their descriptions.
pub static TRACE_FIELDS: LazyLock<BTreeMap<String, String>> = LazyLock::new(|| {
    let mut settings = SchemaSettings::draft2020_12().for_serialize();
    settings.inline_subschemas = true;
    let schema = settings.into_generator().into_root_schema_for::<CycleRecord>();
    let mut fields = BTreeMap::from([("type".to_owned(), "`cycle`".to_owned())]);
    add_fields(schema.as_value(), "", &mut fields);
    fields
});

/// Fields whose parts are not listed, because programs and messages have them as a whole.
const WHOLE: [&str; 3] = ["posture", "request", "say"];

/// The parts of a value with one entry for each team. They are not listed.
const OF_TEAMS: [&str; 2] = ["blue", "pink"];

/// A field that no line has, because the numbers of opponents are not known.
const UNKNOWN: &str = "robots.belief.opponents.id";

/// Adds the fields of the values that `schema` describes, below the field `path`.
fn add_fields(schema: &Value, path: &str, fields: &mut BTreeMap<String, String>) {
    for (name, part) in schema["properties"].as_object().into_iter().flatten() {
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        if OF_TEAMS.contains(&name.as_str()) || path == UNKNOWN {
            continue;
        }
        let is_whole = WHOLE.contains(&name.as_str());
        let words = if is_whole { Vec::new() } else { words(part) };
        let words = if words.is_empty() { String::new() } else { one_of(words) };
        let says = match fields.remove(&path) {
            Some(before) => format!("{before}, {words}"),
            None => format!("{} {words}", first_sentence(part)).trim().to_owned(),
        };
        fields.insert(path.clone(), says);
        if !is_whole {
            add_fields(part, &path, fields);
        }
    }
    alternatives(schema).chain(schema.get("items")).for_each(|part| add_fields(part, path, fields));
}

fn first_sentence(schema: &Value) -> String {
    let description = schema["description"].as_str().unwrap_or_default().replace('\n', " ");
    description.split_inclusive(". ").next().unwrap_or_default().trim_end().to_owned()
}

/// Returns the words that a value can have.
fn words(schema: &Value) -> Vec<&str> {
    let listed = schema["enum"].as_array().into_iter().flatten().chain(schema.get("const"));
    listed.filter_map(Value::as_str).chain(alternatives(schema).flat_map(words)).collect()
}

fn alternatives(schema: &Value) -> impl Iterator<Item = &Value> {
    ["oneOf", "anyOf"].into_iter().filter_map(|key| schema[key].as_array()).flatten()
}
