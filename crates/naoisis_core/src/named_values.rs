//! Values by name: settings and readings whose types are known only to the program that registers them.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// Values by name, as written in files.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(opaque)]
#[reflect(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct NamedValues(pub BTreeMap<String, Value>);

impl NamedValues {
    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the value of `name`, if there is one.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.get(name)
    }

    /// Sets the value of `name`, or removes it if `value` is `None`.
    pub fn set(&mut self, name: &str, value: Option<Value>) {
        match (value, self.0.get_mut(name)) {
            (Some(value), Some(old)) => *old = value,
            (Some(value), None) => {
                self.0.insert(name.to_owned(), value);
            }
            (None, _) => {
                self.0.remove(name);
            }
        }
    }
}
