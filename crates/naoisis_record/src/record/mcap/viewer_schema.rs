//! Simplifies JSON schemas for viewers: without references, alternatives and `null`.

use foxglove::Schema;
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value, json};

/// Depth down to which schemas are followed. It ends recursive schemas.
const DEEPEST: usize = 16;

/// Returns the schema of `T`, with the fields whose type viewers understand. They display other fields, too, but do not suggest them.
pub(in crate::record) fn viewer_schema<T: JsonSchema>() -> Schema {
    let whole = Value::from(SchemaGenerator::default().into_root_schema_for::<T>());
    let schema =
        simplified(&whole, &whole["$defs"], 0).unwrap_or_else(|| json!({ "type": "object", "properties": {} }));
    // The name of the type, which files may call differently.
    let name = core::any::type_name::<T>().rsplit("::").next().unwrap_or_default();
    Schema::new(format!("naoisis.{name}"), "jsonschema", schema.to_string().into_bytes())
}

fn simplified(schema: &Value, definitions: &Value, depth: usize) -> Option<Value> {
    let within = |inner: &Value| if depth < DEEPEST { simplified(inner, definitions, depth + 1) } else { None };
    let alternatives = schema["anyOf"].as_array().or_else(|| schema["oneOf"].as_array());
    let mut simple = if let Some(reference) = schema["$ref"].as_str() {
        within(&definitions[reference.strip_prefix("#/$defs/")?])?
    } else if let Some(alternatives) = alternatives {
        let mut kinds = alternatives.iter().filter(|kind| kind["type"] != "null").map(within);
        let first = kinds.next()??;
        // Viewers treat all texts alike.
        if kinds.any(|kind| kind.is_none_or(|kind| kind["type"] != "string" || first["type"] != "string")) {
            return None;
        }
        first
    } else {
        let name = match &schema["type"] {
            Value::Array(names) => names.iter().find(|name| *name != "null")?.as_str()?,
            name => name.as_str().or_else(|| schema.get("enum").map(|_| "string"))?,
        };
        match name {
            "object" => {
                let properties = schema["properties"].as_object().into_iter().flatten();
                let properties: Map<String, Value> =
                    properties.filter_map(|(name, inner)| Some((name.clone(), within(inner)?))).collect();
                json!({ "type": name, "properties": properties })
            }
            "array" => {
                // Viewers cannot read arrays of arrays.
                let items = within(schema.get("items")?).filter(|items| items["type"] != "array")?;
                json!({ "type": name, "items": items })
            }
            _ => json!({ "type": name }),
        }
    };
    if let Some(description) = schema.get("description") {
        simple["description"] = description.clone();
    }
    Some(simple)
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::interface::cycle_record::CycleRecord;

    /// Returns whether Lichtblick reads the schema: objects with properties, arrays of items, and plain values.
    fn is_understood(schema: &Value) -> bool {
        match schema["type"].as_str() {
            Some("object") => schema["properties"].as_object().is_some_and(|inner| inner.values().all(is_understood)),
            Some("array") => is_understood(&schema["items"]) && schema["items"]["type"] != "array",
            other => other.is_some_and(|name| ["string", "number", "integer", "boolean"].contains(&name)),
        }
    }

    #[test]
    fn the_schema_of_a_record_has_what_can_be_plotted() {
        let schema = viewer_schema::<CycleRecord>();
        let value: Value = serde_json::from_slice(&schema.data).unwrap();
        assert!(is_understood(&value), "{value:#}");
        assert_eq!(schema.name, "naoisis.CycleRecord");
        let robot = &value["properties"]["robots"]["items"]["properties"];
        assert_eq!(robot["pose"]["items"]["type"], "number");
        assert_eq!(robot["belief"]["properties"]["ball"]["properties"]["age_s"]["type"], "number");
        assert_eq!(robot["command"]["properties"]["kick"]["properties"]["speed"]["type"], "number");
        assert_eq!(value["properties"]["game"]["properties"]["state"]["type"], "string");
        assert!(robot["pose"]["description"].as_str().unwrap().contains("pitch frame"));
    }
}
