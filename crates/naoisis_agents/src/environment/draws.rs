//! Fields of the scenario that are drawn for each episode.

use bevy::prelude::*;
use rand::RngExt;
use serde_json::Value;

use super::situation::Situation;
use super::start_error::StartError;
use crate::agents::with_remote_robots;
use naoisis_core::random::RandomStream;
use naoisis_core::team::RobotId;
use naoisis_sim::scenario::{Scenario, ScenarioFile, Setting};

/// A field of the scenario, and what its value is drawn from.
#[derive(Clone, PartialEq, Debug)]
pub struct Draw {
    /// The field, as for `--set`.
    pub field: String,
    /// Its values.
    pub values: DrawnValues,
    /// The value that it has instead of the drawn one, if any. Other fields are drawn as without it.
    pub fixed: Option<Value>,
}

/// The values of a field that is drawn.
#[derive(Clone, PartialEq, Debug)]
pub enum DrawnValues {
    /// Any number between two, evenly distributed.
    Range([f64; 2]),
    /// One of several values, at least one.
    OneOf(Vec<Value>),
}

impl DrawnValues {
    fn draw(&self, stream: &mut RandomStream) -> Value {
        match self {
            DrawnValues::Range([low, high]) => Value::from(low + (high - low) * stream.random::<f64>()),
            DrawnValues::OneOf(values) => {
                let index = stream.random_range(0..values.len().max(1));
                values.get(index).cloned().unwrap_or_default()
            }
        }
    }

    /// The ends of the range, or all values.
    pub fn extremes(&self) -> Vec<Value> {
        match self {
            DrawnValues::Range(ends) => ends.iter().map(|end| Value::from(*end)).collect(),
            DrawnValues::OneOf(values) => values.clone(),
        }
    }
}

/// Scenarios of which some fields are drawn for each episode.
pub struct DrawnScenarios {
    /// The files, one of which is drawn; at least one.
    pub files: Vec<ScenarioFile>,
    /// The fields that are drawn.
    pub draws: Vec<Draw>,
    /// The controlled robots.
    pub control: Vec<RobotId>,
    /// The areas of start positions.
    pub situation: Situation,
}

impl DrawnScenarios {
    /// Returns the scenario of the episode whose match has `seed`, and the values of its fields.
    ///
    /// # Errors
    /// If the scenario is not valid with the values.
    pub fn scenario(&self, world: &World, file: usize, seed: u64) -> Result<(Scenario, Vec<Value>), StartError> {
        let mut stream = RandomStream::for_match(seed, "draws");
        let mut value = |draw: &Draw| {
            let drawn = draw.values.draw(&mut stream);
            draw.fixed.clone().unwrap_or(drawn)
        };
        let values: Vec<Value> = self.draws.iter().map(&mut value).collect();
        let settings: Result<Vec<Setting>, _> =
            self.draws.iter().zip(&values).map(|(draw, value)| format!("{}={value}", draw.field).parse()).collect();
        let wrong = |error: &dyn core::fmt::Display| StartError::Drawn(error.to_string());
        let settings = settings.map_err(|error| wrong(&error))?;
        let Some(file) = self.files.get(file) else { return Err(wrong(&"there is no such scenario")) };
        let file = file.with(&settings).map_err(|error| wrong(&error))?;
        let scenario = with_remote_robots(world, &file.scenario, &self.control)?;
        Ok((self.situation.drawn(Scenario { seed, ..scenario }), values))
    }
}
