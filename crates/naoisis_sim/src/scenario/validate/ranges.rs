//! Checks the ranges of single numbers. They are attributes of the types, `#[schemars(range(min = 0.0, max = 5.0))]`, or
//! `extend("exclusiveMinimum" = 0.0)` if the minimum is excluded. The JSON Schema has the same ranges.

use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::LazyLock;

use super::{MOST_FAULTS, ScenarioFault};
use crate::scenario::field_path::FieldPath;
use crate::scenario::types::{Scenario, ScenarioForm};

/// Returns the faults of numbers that are out of range, in a scenario with finite numbers.
pub(super) fn faults(scenario: &Scenario) -> Vec<ScenarioFault> {
    static RANGES: LazyLock<Ranges> = LazyLock::new(|| {
        let schema = Value::from(schemars::schema_for!(ScenarioForm));
        Ranges::of(&schema, schema.get("$defs").unwrap_or(&Value::Null))
    });
    let mut faults = Vec::new();
    // Finite numbers and texts can always be serialised.
    if let Ok(value) = serde_json::to_value(scenario) {
        RANGES.check(&value, &mut Vec::new(), &mut faults);
    }
    faults
}

/// The ranges of a number, and of the numbers in a value.
#[derive(Default)]
struct Ranges {
    least: Option<f64>,
    /// The excluded minimum.
    above: Option<f64>,
    most: Option<f64>,
    /// The unit, if it is not part of the field's name.
    unit: Option<String>,
    fields: BTreeMap<String, Ranges>,
    /// The ranges of all other fields.
    others: Option<Box<Ranges>>,
    elements: Option<Box<Ranges>>,
}

/// A step into a value.
#[derive(Clone, Copy)]
enum Step<'a> {
    Field(&'a str),
    Index(usize),
}

impl Ranges {
    /// Returns the ranges in a schema.
    fn of(schema: &Value, definitions: &Value) -> Ranges {
        let mut ranges = Ranges::default();
        ranges.add(schema, definitions);
        ranges
    }

    fn add(&mut self, schema: &Value, definitions: &Value) {
        let number = |key: &str| schema.get(key).and_then(Value::as_f64);
        self.least = number("minimum").or(self.least);
        self.above = number("exclusiveMinimum").or(self.above);
        self.most = number("maximum").or(self.most);
        self.unit = schema.get("unit").and_then(Value::as_str).map(str::to_owned).or(self.unit.take());
        let referred = schema.get("$ref").and_then(Value::as_str).and_then(|path| path.strip_prefix("#/$defs/"));
        if let Some(definition) = referred.and_then(|name| definitions.get(name)) {
            self.add(definition, definitions);
        }
        // The fields of variants have different names or the same ranges.
        for key in ["allOf", "anyOf", "oneOf"] {
            for variant in schema.get(key).and_then(Value::as_array).into_iter().flatten() {
                self.add(variant, definitions);
            }
        }
        for (name, field) in schema.get("properties").and_then(Value::as_object).into_iter().flatten() {
            let ranges = Ranges::of(field, definitions);
            if !ranges.is_empty() {
                self.fields.insert(name.clone(), ranges);
            }
        }
        for (key, place) in [("additionalProperties", &mut self.others), ("items", &mut self.elements)] {
            let ranges = schema.get(key).map(|inner| {
                let mut ranges = Ranges::of(inner, definitions);
                ranges.unit = ranges.unit.or(self.unit.clone());
                ranges
            });
            *place = ranges.filter(|ranges| !ranges.is_empty()).map(Box::new).or(place.take());
        }
    }

    fn is_empty(&self) -> bool {
        let has_range = self.least.is_some() || self.above.is_some() || self.most.is_some();
        !has_range && self.fields.is_empty() && self.others.is_none() && self.elements.is_none()
    }

    /// Checks a value at the path `steps`.
    fn check<'a>(&self, value: &'a Value, steps: &mut Vec<Step<'a>>, faults: &mut Vec<ScenarioFault>) {
        if faults.len() >= MOST_FAULTS {
            return;
        }
        match value {
            Value::Number(number) => {
                // Settings have single precision.
                let given = number.as_f64().unwrap_or_default() as f32;
                let is_within = self.least.is_none_or(|least| given >= least as f32)
                    && self.above.is_none_or(|least| given > least as f32)
                    && self.most.is_none_or(|most| given <= most as f32);
                if !is_within {
                    let path = steps.iter().fold(FieldPath::default(), |path, step| match step {
                        Step::Field(name) => path.key(name),
                        Step::Index(index) => path.index(*index),
                    });
                    let shown = if number.is_f64() { given.to_string() } else { number.to_string() };
                    let message = format!("`{}` is {shown}", path.name());
                    let expected = self.expected(&path);
                    faults.push(ScenarioFault::new(path, message, expected));
                }
            }
            Value::Array(elements) => {
                let Some(ranges) = &self.elements else { return };
                for (index, element) in elements.iter().enumerate() {
                    steps.push(Step::Index(index));
                    ranges.check(element, steps, faults);
                    steps.pop();
                }
            }
            Value::Object(fields) => {
                for (name, field) in fields {
                    let Some(ranges) = self.fields.get(name).or(self.others.as_deref()) else { continue };
                    steps.push(Step::Field(name));
                    ranges.check(field, steps, faults);
                    steps.pop();
                }
            }
            Value::Null | Value::Bool(_) | Value::String(_) => {}
        }
    }

    /// Describes the range.
    fn expected(&self, path: &FieldPath) -> String {
        let own =
            self.unit.as_deref().map(|unit| if unit.starts_with(',') { unit.to_owned() } else { format!(" {unit}") });
        let unit = own.unwrap_or_else(|| unit_of(path).to_owned());
        match (self.least, self.above, self.most) {
            (_, Some(least), Some(most)) => format!("more than {least}, at most {most}{unit}"),
            (_, Some(least), None) => format!("more than {least}{unit}"),
            (Some(least), None, Some(most)) => format!("{least} to {most}{unit}"),
            (Some(least), None, None) => format!("{least}{unit} or more"),
            (None, None, Some(most)) => format!("at most {most}{unit}"),
            (None, None, None) => String::new(),
        }
    }
}

/// Returns the unit at the end of the field's name, as words after a number.
fn unit_of(path: &FieldPath) -> &'static str {
    const UNITS: [(&str, &str); 16] = [
        ("probability", ", a probability"),
        ("loss", ", a probability"),
        ("_mps2", " m/s²"),
        ("_degps2", " degrees/s²"),
        ("_degps", " degrees/s"),
        ("_degpm", " degrees/m"),
        ("_mps", " m/s"),
        ("_deg", " degrees"),
        ("_hz", " Hz"),
        ("_px", " pixels"),
        ("per_min", " a minute"),
        ("per_minute", " a minute"),
        ("_cycles", " cycles"),
        ("_bytes", " bytes"),
        ("_s", " s"),
        ("_m", " m"),
    ];
    let field = path.last_name().unwrap_or_default();
    UNITS.into_iter().find(|(ending, _)| field.ends_with(ending)).map_or("", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn wrong(value: Value) -> Vec<String> {
        let schema = json!({
            "properties": {
                "speed_mps": { "minimum": 0.1, "maximum": 5 },
                "kinds": { "additionalProperties": { "$ref": "#/$defs/Kind" } },
                "noise": { "oneOf": [{ "enum": ["none"] }, { "properties": { "uniform": { "$ref": "#/$defs/Kind" } } }] },
                "shift": { "items": { "minimum": -1, "maximum": 255 }, "unit": ", of 255" },
            },
            "$defs": { "Kind": { "properties": { "share": { "exclusiveMinimum": 0, "maximum": 1, "unit": ", a share" } } } },
        });
        let (ranges, mut faults) = (Ranges::of(&schema, &schema["$defs"]), Vec::new());
        ranges.check(&value, &mut Vec::new(), &mut faults);
        faults.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn numbers_are_within_the_ranges_of_their_schema_wherever_they_are() {
        let ends = json!({ "speed_mps": 0.1_f32, "kinds": { "a": { "share": 1 } }, "noise": "none", "shift": [-1, 7] });
        assert_eq!(wrong(ends), [""; 0]);
        let beyond = json!({
            "speed_mps": 5.5, "kinds": { "a": { "share": 0 } }, "noise": { "uniform": { "share": 2 } }, "shift": [0, -2], "other": 9,
        });
        assert_eq!(
            wrong(beyond),
            [
                "kinds.a.share: `share` is 0; expected more than 0, at most 1, a share",
                "noise.uniform.share: `share` is 2; expected more than 0, at most 1, a share",
                "shift[1]: `shift[1]` is -2; expected -1 to 255, of 255",
                "speed_mps: `speed_mps` is 5.5; expected 0.1 to 5 m/s",
            ]
        );
    }
}
