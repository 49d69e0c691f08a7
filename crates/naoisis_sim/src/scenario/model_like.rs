//! Models that start from another one: a file with `like: "booster_k1"` has the figures of that model where it names no others.

use serde_json::{Map, Value};
use std::path::Path;

use super::merge::lay_over;
use super::models::{RobotModel, is_file};

/// The longest chain of models, each like the next. It also ends chains that have no end.
pub(super) const LONGEST_CHAIN: usize = 8;

/// Returns the name by which a file at `path` finds the model that it is `like`: a file lies relative to it.
pub(super) fn reference(path: &str, like: &str) -> String {
    match Path::new(path).parent() {
        Some(folder) if is_file(like) => folder.join(like).to_string_lossy().into_owned(),
        _ => like.to_owned(),
    }
}

impl RobotModel {
    /// Returns the model with the figures of `base` where it has none. A changed figure does not keep the source of the other one: without
    /// a source of its own it is a guess.
    pub(super) fn laid_over(self, base: RobotModel) -> RobotModel {
        let mut changed = Vec::new();
        collect_figures("", &Value::Object(self.all_settings()), &mut changed);
        let mut sources = base.sources.clone();
        for path in &changed {
            let below = format!("{path}.");
            sources.retain(|other, _| other != path && !other.starts_with(&below));
        }
        for path in &changed {
            let guess = || format!("guess: changed from {}, without a source", base.name);
            sources.insert(path.clone(), self.source(path).map_or_else(guess, str::to_owned));
        }
        let is_above = |group: &str| changed.iter().any(|path| path.starts_with(&format!("{group}.")));
        sources.extend(
            self.sources.iter().filter(|(path, _)| !is_above(path)).map(|(path, told)| (path.clone(), told.clone())),
        );
        let laid = |base: &Map<String, Value>, own: &Map<String, Value>| {
            let mut value = Value::Object(base.clone());
            lay_over(&mut value, Value::Object(own.clone()), "");
            if let Value::Object(value) = value { value } else { Map::new() }
        };
        // A change of a figure that the other model has only if it is realistic holds there, too.
        let realistic = laid(&base.realistic, &common(&self.settings, &base.realistic));
        RobotModel {
            settings: laid(&base.settings, &self.settings),
            realistic: laid(&realistic, &self.realistic),
            sources,
            ..self
        }
    }
}

/// The paths of all figures below `path`. A list is one figure.
fn collect_figures(path: &str, value: &Value, figures: &mut Vec<String>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                collect_figures(&if path.is_empty() { name.clone() } else { format!("{path}.{name}") }, value, figures);
            }
        }
        _ => figures.push(path.to_owned()),
    }
}

/// The part of `own` that `other` has, too.
fn common(own: &Map<String, Value>, other: &Map<String, Value>) -> Map<String, Value> {
    let part = |(name, value): (&String, &Value)| {
        let part = match (value, other.get(name)?) {
            (Value::Object(own), Value::Object(other)) => Value::Object(common(own, other)),
            (own, _) => own.clone(),
        };
        Some((name.clone(), part))
    };
    own.iter().filter_map(part).collect()
}
