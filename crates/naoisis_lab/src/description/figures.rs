//! Collects the figures of a model, each with its source.

use bevy::math::DVec3;
use core::fmt::Display;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

use super::ImportedFigure;
use super::tree::Joint;

/// Prefix of the source of a guess.
const GUESS: &str = "guess: ";

/// The figures of a model by their paths, with their sources.
#[derive(Default)]
pub(super) struct Figures {
    pub settings: Map<String, Value>,
    pub sources: BTreeMap<String, String>,
    /// The paths of the figures, in the order in which they were set.
    order: Vec<String>,
    /// What is missing from the description, in words.
    pub lacking: Vec<String>,
}

impl Figures {
    /// Sets the figure at `path` to a value of the description.
    pub fn found(&mut self, path: &str, value: Value, source: impl Display) {
        self.set(path, value);
        self.sources.insert(path.to_owned(), source.to_string());
    }

    /// Sets the figure at `path` to a guess, with its reason.
    pub fn guess(&mut self, path: &str, value: Value, reason: impl Display) {
        self.set(path, value);
        self.sources.insert(path.to_owned(), format!("{GUESS}{reason}"));
    }

    /// Removes a figure.
    pub fn remove(&mut self, path: &str) {
        self.order.retain(|other| other != path);
        self.sources.remove(path);
        let (group, name) = path.rsplit_once('.').unwrap_or(("", path));
        let group = group
            .split('.')
            .filter(|name| !name.is_empty())
            .try_fold(&mut self.settings, |fields, name| fields.get_mut(name).and_then(Value::as_object_mut));
        group.and_then(|fields| fields.remove(name));
    }

    /// Returns the figure at a path.
    pub fn get(&self, path: &str) -> Option<&Value> {
        let (first, rest) = path.split_once('.').unwrap_or((path, ""));
        let rest = rest.split('.').filter(|name| !name.is_empty());
        rest.fold(self.settings.get(first), |value, name| value?.get(name))
    }

    /// Returns the figures that were found, with their sources, and the guesses, with their reasons.
    pub fn with_reasons(&self) -> (Vec<ImportedFigure>, Vec<ImportedFigure>) {
        let figure = |path: &String| {
            let value = self.get(path).map(Value::to_string).unwrap_or_default();
            ImportedFigure { path: path.clone(), value, source: self.sources.get(path).cloned().unwrap_or_default() }
        };
        let (mut guessed, found): (Vec<_>, Vec<_>) =
            self.order.iter().map(figure).partition(|figure| figure.source.starts_with(GUESS));
        guessed.iter_mut().for_each(|figure| figure.source = figure.source.replacen(GUESS, "", 1));
        (found, guessed)
    }

    /// Sets the figure at `path`. `source` is its source, or as an error the reason of a guess.
    pub fn either(&mut self, path: &str, value: Value, source: &Result<String, String>) {
        match source {
            Ok(source) => self.found(path, value, source),
            Err(reason) => self.guess(path, value, reason),
        }
    }

    fn set(&mut self, path: &str, value: Value) {
        self.order.retain(|other| other != path);
        self.order.push(path.to_owned());
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

/// Returns a length in m, rounded to a tenth of a millimetre.
pub(super) fn metres(length_m: f64) -> Value {
    // Avoids a negative zero.
    json!((length_m * 1e4).round() / 1e4 + 0.0)
}

/// Returns a position in m, rounded to a tenth of a millimetre.
pub(super) fn place(place_m: DVec3) -> Value {
    Value::Array(place_m.to_array().map(metres).to_vec())
}

/// Returns the least and the greatest length, m.
pub(super) fn span([least, most]: [f64; 2]) -> Value {
    json!([metres(least), metres(most)])
}

/// Returns an angle in degrees, rounded to a tenth.
pub(super) fn degrees(angle: f64) -> Value {
    json!((angle.to_degrees() * 10.0).round() / 10.0 + 0.0)
}

/// Returns the source of a figure that is taken from a joint.
pub(super) fn joint_source(joint: &Joint) -> String {
    format!("{}, joint {}", joint.place, joint.name)
}
