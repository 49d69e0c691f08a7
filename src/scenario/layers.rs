//! Settings laid over others: field by field.

use serde_json::Value;

/// Fields whose value is a choice with contents, as object and field: another choice replaces it as a whole.
const CHOICES: [(&str, &str); 2] = [("sonar", "noise"), ("ball", "rolling")];

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
