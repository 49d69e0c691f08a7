//! The figures of a model, each with its source.

use bevy::math::DVec3;
use core::fmt::Display;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

use super::ImportedFigure;
use super::tree::Joint;

/// The figures of a model by their paths, and where they are from.
#[derive(Default)]
pub(super) struct Figures {
    pub settings: Map<String, Value>,
    pub sources: BTreeMap<String, String>,
    /// The figures that were found in the description, in the order in which they were found.
    pub found: Vec<ImportedFigure>,
    /// What was not found in the description, in words.
    pub lacking: Vec<String>,
}

impl Figures {
    /// Sets the figure at a path that the description has.
    pub fn found(&mut self, path: &str, value: Value, source: impl Display) {
        let source = source.to_string();
        self.found.push(ImportedFigure { path: path.to_owned(), value: value.to_string(), source: source.clone() });
        self.set(path, value);
        self.sources.insert(path.to_owned(), source);
    }

    /// Sets the figure at a path that is a guess for this reason.
    pub fn guess(&mut self, path: &str, value: Value, reason: impl Display) {
        self.set(path, value);
        self.sources.insert(path.to_owned(), format!("guess: {reason}"));
    }

    /// Sets the figure at a path, by a source or as a guess.
    pub fn either(&mut self, path: &str, value: Value, source: &Result<String, String>) {
        match source {
            Ok(source) => self.found(path, value, source),
            Err(reason) => self.guess(path, value, reason),
        }
    }

    fn set(&mut self, path: &str, value: Value) {
        let mut fields = &mut self.settings;
        let mut names = path.split('.').peekable();
        while let Some(name) = names.next() {
            if names.peek().is_none() {
                fields.insert(name.to_owned(), value);
                return;
            }
            let inner = fields.entry(name).or_insert_with(|| json!({}));
            let Value::Object(inner) = inner else { return };
            fields = inner;
        }
    }
}

/// A length in m to a tenth of a millimetre.
pub(super) fn metres(length_m: f64) -> Value {
    // Zero has no sign.
    json!((length_m * 1e4).round() / 1e4 + 0.0)
}

/// A place in m to a tenth of a millimetre.
pub(super) fn place(place_m: DVec3) -> Value {
    Value::Array(place_m.to_array().map(metres).to_vec())
}

/// The least and the greatest length, m.
pub(super) fn span([least, most]: [f64; 2]) -> Value {
    json!([metres(least), metres(most)])
}

/// An angle in degrees to a tenth.
pub(super) fn degrees(angle: f64) -> Value {
    json!((angle.to_degrees() * 10.0).round() / 10.0 + 0.0)
}

/// The source that is a joint.
pub(super) fn joint_source(joint: &Joint) -> String {
    format!("{}, joint {}", joint.place, joint.name)
}
