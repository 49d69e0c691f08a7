//! Remarks of behaviours for people: an intention in a word or two, and values to plot. They do not influence the match.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::knowledge::Knowledge;

/// The remarks of a robot's behaviour. They are in traces until they are changed.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct Remarks {
    /// The intention in a word or two; `None` leaves it to the messages of the robot.
    pub intention: Option<String>,
    /// Values to plot, by their names.
    pub values: BTreeMap<String, f32>,
}

impl Remarks {
    /// Whether there are no remarks.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
