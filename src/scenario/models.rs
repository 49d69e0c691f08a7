//! Models: the figures of real robots, each with its source, as files in RON that are embedded in the program.

use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

use super::preset::Preset;
use super::shape;

/// The models that come with the program: `assets/robots`.
pub const MODELS: &[Preset] = &[
    Preset { name: "nao", text: include_str!("../../assets/robots/nao.ron") },
    Preset { name: "nao_v6", text: include_str!("../../assets/robots/nao_v6.ron") },
];

/// A robot as it really is, in the surroundings of its league.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct RobotModel {
    /// Its name.
    pub name: String,
    /// What it is, in a sentence.
    pub description: String,
    /// A scenario's settings that are as real as is known.
    pub realistic: Map<String, Value>,
    /// Where each figure of them is from, by its path. What no source gives begins with `guess:`.
    pub sources: BTreeMap<String, String>,
}

impl RobotModel {
    /// The model of this name among the [`MODELS`].
    pub fn named(name: &str) -> Option<RobotModel> {
        let preset = MODELS.iter().find(|preset| preset.name == name)?;
        // A test reads every embedded file.
        shape::read(&preset.value()).ok()
    }

    /// Where the figure at a path, such as `kicks.wind_up_s`, is from: its own source, or that of the group it belongs to.
    pub fn source(&self, path: &str) -> Option<&str> {
        let own = self.sources.get(path).map(String::as_str);
        own.or_else(|| path.rsplit_once('.').and_then(|(group, _)| self.source(group)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paths of all figures.
    fn figures(path: &str, value: &Value, into: &mut Vec<String>) {
        match value {
            Value::Object(fields) => {
                for (name, value) in fields {
                    figures(&if path.is_empty() { name.clone() } else { format!("{path}.{name}") }, value, into);
                }
            }
            _ => into.push(path.to_owned()),
        }
    }

    #[test]
    fn every_figure_has_its_source_and_every_source_a_figure() {
        for preset in MODELS {
            let model = RobotModel::named(preset.name).unwrap_or_else(|| panic!("{} is not read", preset.name));
            assert_eq!(model.name, preset.name);
            let mut paths = Vec::new();
            figures("", &Value::Object(model.realistic.clone()), &mut paths);
            for path in &paths {
                assert!(model.source(path).is_some(), "{}: {path} has no source", model.name);
            }
            for source in model.sources.keys() {
                let is_of = |path: &String| path == source || path.starts_with(&format!("{source}."));
                assert!(paths.iter().any(is_of), "{}: {source} is no figure", model.name);
            }
        }
    }
}
