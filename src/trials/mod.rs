//! Trials: what a simulated robot does, measured by running it, beside what the real one does.
//!
//! Each quantity is measured as one would in a laboratory: robots walk, kick and look at things, in matches of their own with
//! everything `realistic`, and only poses, events and readings are looked at. The real figure is that of the robot's
//! [model](RobotModel), with its source. `naoisis realism` prints the table.
//!
//! ```
//! use naoisis::scenario::RobotModel;
//! use naoisis::trials;
//!
//! let model = RobotModel::named("nao").unwrap();
//! let speed = trials::walking::measure(&model, 3)?.remove(0);
//! assert_eq!((speed.name.as_str(), speed.unit), ("speed forward", "m/s"));
//! assert!(speed.difference().abs() < 0.15);
//! # Ok::<(), naoisis::trials::TrialError>(())
//! ```

use bevy::prelude::*;
use serde_json::{Map, Value, json};

use crate::geometry::Pose;
use crate::scenario::{RobotModel, Scenario, ScenarioError, ScenarioFault};
use crate::simulation::{MatchApp, NaoisisPlugins};
use crate::team::{RobotId, Team};

pub mod falling;
pub mod kicking;
pub mod seeing;
pub mod sensing;
pub mod walking;

/// A quantity of a robot, measured and real.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub struct MeasuredQuantity {
    /// What it is, in a few words.
    pub name: String,
    /// Its unit, as it is printed.
    pub unit: &'static str,
    /// What the simulated robot does.
    pub measured: f64,
    /// What the real one does.
    pub real: f64,
    /// Where the real figure is from; what no source gives begins with `guess:`.
    pub source: String,
}

impl MeasuredQuantity {
    /// How far the measured value is from the real one, as a share of the real one.
    pub fn difference(&self) -> f64 {
        if self.real == 0.0 { self.measured } else { self.measured / self.real - 1.0 }
    }

    /// Whether no source gives the real figure.
    pub fn is_guess(&self) -> bool {
        self.source.starts_with("guess:")
    }
}

/// Why a robot cannot be tried.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrialError {
    /// Its model makes no scenario.
    #[error("the model makes no scenario: {0}")]
    Scenario(#[from] ScenarioError),
    /// The match of a trial cannot start.
    #[error("a trial cannot start: {0}")]
    Start(#[from] ScenarioFault),
}

/// All quantities of a model, from so many repetitions of what is left to chance.
///
/// # Errors
/// When the model makes no scenario.
pub fn measure(model: &RobotModel, repetitions: u32) -> Result<Vec<MeasuredQuantity>, TrialError> {
    let mut quantities = walking::measure(model, repetitions)?;
    quantities.extend(kicking::measure(model, repetitions)?);
    quantities.extend(falling::measure(model, repetitions)?);
    quantities.extend(sensing::measure(model, repetitions)?);
    Ok(quantities)
}

/// The robot that is tried.
const TRIED: RobotId = RobotId::new(Team::Blue, 1);

/// A laboratory for a model: a pitch without a referee, on which one trial follows another.
struct Laboratory<'a> {
    model: &'a RobotModel,
    app: App,
}

impl<'a> Laboratory<'a> {
    fn new(model: &'a RobotModel) -> Self {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        Self { model, app }
    }

    /// The settings that the model's words stand for, as a scenario.
    fn scenario(&self, own: Value) -> Result<Scenario, TrialError> {
        let mut fields = Map::new();
        fields.insert("model".to_owned(), json!(self.model.reference()));
        fields.insert("realism".to_owned(), json!("realistic"));
        fields.insert("rules".to_owned(), json!("free"));
        fields.insert("field".to_owned(), json!("spl2025"));
        if let Value::Object(own) = own {
            fields.extend(own);
        }
        Ok(Scenario::from_json(&Value::Object(fields).to_string())?)
    }

    /// Begins a trial: a match with these fields of a scenario.
    fn begin(&mut self, own: Value) -> Result<(), TrialError> {
        let scenario = self.scenario(own)?;
        self.app.start_match(&scenario)?;
        Ok(())
    }

    /// The cycles in a time, s.
    fn cycles(&self, time_s: f64) -> usize {
        (time_s / self.period_s()).round() as usize
    }

    fn period_s(&self) -> f64 {
        self.app.world().resource::<crate::cycle::CycleClock>().period_s
    }

    /// Where the tried robot is.
    fn pose(&self) -> Pose {
        self.app.robot_pose(TRIED).unwrap_or_default()
    }

    /// A reading or state of the tried robot.
    fn reading<C: Component + Clone + Default>(&self) -> C {
        self.app.robot::<C>(TRIED).cloned().unwrap_or_default()
    }

    fn quantity(&self, name: &str, unit: &'static str, measured: f64, real: f64, path: &str) -> MeasuredQuantity {
        let source = self.model.source(path).unwrap_or("guess: the paper's").to_owned();
        MeasuredQuantity { name: name.to_owned(), unit, measured, real, source }
    }
}

/// The mean.
fn mean_of(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / (values.len() as f64).max(1.0)
}

/// The standard deviation about the mean.
fn deviation_of(values: &[f64]) -> f64 {
    let mean = mean_of(values);
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    (squares / (values.len() as f64 - 1.0).max(1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::MODELS;

    /// Of 200 repetitions, a standard deviation is known to 5 % (1 / sqrt(2 n)): three of them are within the 15 % that a
    /// realistic figure may be off, with 99.7 % confidence.
    #[test]
    fn every_measured_figure_is_within_15_percent_of_the_real_one() {
        for name in ["nao", "nao_v6", "booster_k1"] {
            let model = RobotModel::named(name).unwrap();
            let quantities = measure(&model, 200).unwrap();
            assert!(quantities.len() >= 15);
            for quantity in quantities {
                assert!(quantity.difference().abs() <= 0.15, "{}: {quantity:?}", model.name);
            }
        }
    }

    #[test]
    fn every_model_can_be_measured() {
        for preset in MODELS {
            let model = RobotModel::named(preset.name).unwrap();
            assert!(measure(&model, 2).unwrap().len() >= 15, "{}", model.name);
        }
    }
}
