//! Settings laid over others: field by field.

use serde_json::Value;

use super::field_path::{FieldPath, Segment};

/// Fields whose value is a choice with contents, as object and field: another choice replaces it as a whole.
const CHOICES: [(&str, &str); 2] = [("sonar", "noise"), ("ball", "rolling")];

/// The field of an object for which a word stands that is there in its place: `rules: "spl2010"` is `rules: (preset: "spl2010")`.
pub fn field_of_word(path: &FieldPath) -> &'static str {
    match path.segments() {
        [Segment::Field(realism)] if realism == "realism" => "all",
        [Segment::Field(teams), _] if teams == "teams" => "team",
        _ => "preset",
    }
}

/// Lays `own` over `base`: objects field by field, everything else as a whole. `field` is the name of both.
pub fn lay_over(base: &mut Value, own: Value, field: &str) {
    match (base, own) {
        (Value::Object(base), Value::Object(own)) => {
            for (name, own) in own {
                match base.get_mut(&name) {
                    Some(base) if !CHOICES.contains(&(field, name.as_str())) => lay_over(base, own, &name),
                    _ => {
                        base.insert(name, own);
                    }
                }
            }
        }
        (base, own) => *base = own,
    }
}
