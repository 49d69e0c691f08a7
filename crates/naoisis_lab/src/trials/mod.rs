//! Trials: measurements of simulated robots, compared with the figures of real ones.
//!
//! Each quantity is measured as in a laboratory: robots walk, kick and look at objects in matches of their own with all
//! `realistic` settings, and only poses, events and readings are used. The real figure is that of the robot's
//! [model](RobotModel), with its source. `naoisis realism` prints the table.
//!
//! ```
//! use naoisis::scenario::RobotModel;
//! use naoisis::internal::trials;
//!
//! let model = RobotModel::named("nao").unwrap();
//! let speed = trials::walking::measure(&model, 3)?.remove(0);
//! assert_eq!((speed.name.as_str(), speed.unit), ("speed forward", "m/s"));
//! assert!(speed.difference().is_some_and(|share| share.abs() < 0.15));
//! # Ok::<(), naoisis::internal::trials::TrialError>(())
//! ```

use bevy::prelude::*;
use serde_json::{Map, Value, json};

use naoisis_core::geometry::Pose;
use naoisis_core::team::{RobotId, Team};
use naoisis_sim::scenario::{RobotModel, Scenario, ScenarioError, ScenarioFault};
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

pub mod falling;
pub mod kicking;
pub mod lateness;
pub mod looking;
pub mod recognising;
pub mod seeing;
pub mod sensing;
pub mod sonars;
pub mod walking;

/// A measured quantity of a robot and its real figure.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub struct MeasuredQuantity {
    /// Its name, in a few words.
    pub name: String,
    /// Its unit, as printed.
    pub unit: &'static str,
    /// The value of the simulated robot; 0 if it was [not seen](Self::not_seen).
    pub measured: f64,
    /// Why it could not be measured, such as "nobody fell"; `None` if it was measured.
    pub not_seen: Option<&'static str>,
    /// The figure of the real robot.
    pub real: f64,
    /// The source of the real figure, from the `sources` of the model; [`NOT_GIVEN`] if `sources` lacks it; for figures
    /// that the model leaves out, that they are the paper's. Figures without a known source begin with `guess:`.
    pub source: String,
}

/// The source of a figure of a model that its `sources` do not list.
pub const NOT_GIVEN: &str = "not given";

impl MeasuredQuantity {
    /// Returns the relative difference of the measured value from the real figure; `None` if it was not measured.
    pub fn difference(&self) -> Option<f64> {
        let share = if self.real == 0.0 { self.measured } else { self.measured / self.real - 1.0 };
        self.not_seen.is_none().then_some(share)
    }

    /// Marks the quantity as not measured, for the reason `otherwise`, if the event did not happen (`times` is 0). Rare
    /// events need not happen in short runs.
    fn if_seen(self, times: f64, otherwise: &'static str) -> Self {
        Self { not_seen: (times == 0.0 && self.real != 0.0).then_some(otherwise), ..self }
    }

    /// Returns whether the real figure has no known source.
    pub fn is_guess(&self) -> bool {
        self.source.starts_with("guess:") || self.source == NOT_GIVEN
    }
}

/// Why a robot cannot be measured.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum TrialError {
    /// Its model makes no valid scenario.
    #[error("the model makes no scenario: {0}")]
    Scenario(#[from] ScenarioError),
    /// The match of a trial cannot start.
    #[error("a trial cannot start: {0}")]
    Start(#[from] ScenarioFault),
}

naoisis_core::debug_as_displayed!(TrialError);

/// Measures all quantities of a model; random ones from `repetitions` repetitions. Quantities of parts that the robot
/// does not have are left out: [`not_measured`] lists them.
///
/// # Errors
/// When the model makes no valid scenario.
pub fn measure(model: &RobotModel, repetitions: u32) -> Result<Vec<MeasuredQuantity>, TrialError> {
    let mut quantities = walking::measure(model, repetitions)?;
    quantities.extend(kicking::measure(model, repetitions)?);
    quantities.extend(falling::measure(model, repetitions)?);
    quantities.extend(looking::measure(model)?);
    quantities.extend(sonars::measure(model, repetitions)?);
    quantities.extend(sensing::measure(model, repetitions)?);
    quantities.extend(recognising::measure(model, repetitions)?);
    quantities.extend(lateness::measure(model)?);
    Ok(quantities)
}

/// Returns the reasons why quantities of a model are left out, in words.
///
/// # Errors
/// When the model makes no valid scenario.
pub fn not_measured(model: &RobotModel) -> Result<Vec<&'static str>, TrialError> {
    let real = Laboratory::new(model).scenario(json!({}))?;
    let reasons = [
        (!walking::walks(&real), "it does not walk: nothing is measured of its steps"),
        (!walking::turns(&real), "it does not turn: nothing is measured of its turns"),
        (real.settings.kicks.strongest().is_none(), "it has no kicks: nothing is measured of them"),
        (!sensing::has_cameras(&real), "it has no cameras: nothing is measured of what it sees"),
        (
            sensing::has_cameras(&real) && !sensing::sees_ahead(&real),
            "its cameras do not show it a ball 2 m ahead while its head is level: the errors of what it sees are not measured",
        ),
        (
            sensing::has_cameras(&real) && !looking::shows_its_width(&real),
            "its cameras do not show it a ball 7 m ahead while its head is level: how wide they see is not measured",
        ),
        (!real.settings.sonar.fitted, "it has no sonars: nothing is measured of them"),
    ];
    Ok(reasons.into_iter().filter_map(|(lacks, words)| lacks.then_some(words)).collect())
}

/// The robot that is measured.
const TRIED: RobotId = RobotId::new(Team::Blue, 1);

/// A laboratory for a model: a pitch without a referee, on which trials are run one after the other.
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

    /// A scenario with the settings of the model, without break-downs: whether a robot is picked up or hot must not change what is measured of
    /// its walk and its falls.
    fn scenario(&self, own: Value) -> Result<Scenario, TrialError> {
        let mut fields = Map::new();
        fields.insert("model".to_owned(), json!(self.model.reference()));
        fields.insert("realism".to_owned(), json!("realistic"));
        fields.insert("rules".to_owned(), json!("free"));
        fields.insert("field".to_owned(), json!("spl2025"));
        let never = json!({ "pick_ups_per_hour": 0, "restarts_per_hour": 0, "hot_after_s": null });
        fields.insert("breakdowns".to_owned(), never);
        if let Value::Object(own) = own {
            fields.extend(own);
        }
        Ok(Scenario::from_json(&Value::Object(fields).to_string())?)
    }

    /// Starts a trial: a match with these fields of a scenario.
    fn begin(&mut self, own: Value) -> Result<(), TrialError> {
        let scenario = self.scenario(own)?;
        self.app.start_match(&scenario)?;
        Ok(())
    }

    /// The number of cycles in a time, s.
    fn cycles(&self, time_s: f64) -> usize {
        (time_s / self.period_s()).round() as usize
    }

    fn period_s(&self) -> f64 {
        self.app.world().resource::<naoisis_core::cycle::CycleClock>().period_s
    }

    /// The pose of the tried robot.
    fn pose(&self) -> Pose {
        self.app.robot_pose(TRIED).unwrap_or_default()
    }

    /// A reading or state of the tried robot.
    fn reading<C: Component + Clone + Default>(&self) -> C {
        self.app.robot::<C>(TRIED).cloned().unwrap_or_default()
    }

    fn quantity(&self, name: &str, unit: &'static str, measured: f64, real: f64, path: &str) -> MeasuredQuantity {
        let source = match self.model.source(path) {
            _ if !self.model.says(path) => "guess: the paper's",
            Some(source) => source,
            None => NOT_GIVEN,
        };
        let source = source.to_owned();
        MeasuredQuantity { name: name.to_owned(), unit, measured, not_seen: None, real, source }
    }
}

/// The number of cycles of a trial whose result is random.
fn cycles_of(repetitions: u32) -> u32 {
    10 * repetitions.max(2)
}

/// The share `part` of `whole`; 0 of nothing.
fn share(part: usize, whole: usize) -> f64 {
    part as f64 / (whole as f64).max(1.0)
}

/// The mean.
fn mean_of(values: &[f64]) -> f64 {
    // The sum of no values is -0.
    (0.0 + values.iter().sum::<f64>()) / (values.len() as f64).max(1.0)
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
    use naoisis_sim::scenario::MODELS;

    /// The measured quantities by name, and the reasons for those left out, of a model file with these settings and
    /// sources.
    fn measured(settings: &str, sources: &str, repetitions: u32) -> (Vec<MeasuredQuantity>, Vec<&'static str>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("own.ron");
        let body = "torso: (x_m: (-0.1, 0.1), half_width_m: 0.15, z_m: (0.0, 0.45)), \
                    waistband: (z_m: (0.2, 0.3), half_size_m: (0.11, 0.16))";
        let text = format!(
            r#"(name: "own", description: "", settings: (body: ({body}), {settings}),
                realistic: (falls: (falls_per_min: 0.5, kick_probability: 0.2)), sources: {{ {sources} }})"#
        );
        std::fs::write(&path, text).unwrap();
        let model = RobotModel::find(&path.to_string_lossy()).unwrap();
        (measure(&model, repetitions).unwrap(), not_measured(&model).unwrap())
    }

    #[test]
    fn what_a_robot_lacks_is_not_measured_and_said() {
        let (quantities, left_out) = measured("motion: (max_linear_mps: 0.5)", "", 10);
        let words = ["it has no kicks", "it has no cameras", "it has no sonars"];
        assert_eq!(left_out.len(), words.len());
        for (reason, words) in left_out.iter().zip(words) {
            assert!(reason.starts_with(words), "{left_out:?}");
        }
        assert!(quantities.iter().any(|quantity| quantity.name == "messages lost"));
        for quantity in &quantities {
            let is_of_what_it_lacks =
                ["kick", "ball", "sonar", "image"].iter().any(|word| quantity.name.contains(word));
            assert!(!is_of_what_it_lacks && quantity.difference().is_none_or(|share| share > -0.9), "{quantity:?}");
        }
        // A camera that looks at the ground, and a kick of another name than those of the paper.
        let flap = "(max_distance_m: 3, wind_up_s: 0.3, region: (x_m: (0.1, 0.3), y_m: (-0.1, 0.1), foot_m: (0.1, 0), best_m: (0.2, 0), direction: ahead))";
        let camera = r#"(name: "chin", position_m: (0.1, 0, 0.4), tilt_deg: 80)"#;
        let settings = format!(
            r#"motion: (max_linear_mps: 0, max_angular_degps: 0), cameras: (mounts: [{camera}]), kicks: (own: {{ "flap": {flap} }})"#
        );
        let (quantities, left_out) = measured(&settings, "", 10);
        assert!(left_out.iter().any(|reason| reason.starts_with("its cameras do not show it a ball 2 m ahead")));
        assert!(left_out.iter().any(|reason| reason.starts_with("it does not walk")), "{left_out:?}");
        for quantity in &quantities {
            let is_there = quantity.difference().is_none_or(|share| share > -0.9);
            assert!(is_there && !quantity.name.contains("speed forward"), "{quantity:?}");
        }
    }

    #[test]
    fn what_did_not_happen_in_few_trials_is_not_seen_and_differs_by_nothing() {
        let seldom = "motion: (max_linear_mps: 0.5), falls: (falls_per_min: 0.0001, get_up_s: Some(3.0))";
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("own.ron");
        let text = format!(r#"(name: "own", description: "", settings: ({seldom}), realistic: (), sources: {{}})"#);
        std::fs::write(&path, text).unwrap();
        let falls = falling::measure(&RobotModel::find(&path.to_string_lossy()).unwrap(), 2).unwrap();
        let fell = falls.iter().find(|quantity| quantity.name.starts_with("falls in a minute")).unwrap();
        assert_eq!((fell.measured, fell.difference()), (0.0, None));
        assert!(fell.not_seen.is_some_and(|why| why.contains("nobody fell")), "{fell:?}");
    }

    #[test]
    fn a_figures_source_is_that_of_the_file_or_none_and_never_another_robots() {
        let (quantities, _) = measured(
            "motion: (max_linear_mps: 0.5, max_angular_degps: 80)",
            r#""motion.max_angular_degps": "tape measure""#,
            2,
        );
        let source = |name: &str| {
            let of_name = quantities.iter().find(|quantity| quantity.name == name);
            of_name.map(|quantity| (quantity.source.as_str(), quantity.is_guess()))
        };
        assert_eq!(source("turn"), Some(("tape measure", false)));
        assert_eq!(source("speed forward"), Some((NOT_GIVEN, true)));
        assert_eq!(source("speed backward"), Some((NOT_GIVEN, true)));
        assert_eq!(source("falls in a minute at full speed"), Some((NOT_GIVEN, true)));
        assert_eq!(source("messages lost"), Some(("guess: the paper's", true)));
    }

    #[test]
    fn every_model_can_be_measured() {
        std::thread::scope(|scope| {
            for preset in MODELS {
                scope.spawn(|| {
                    let quantities = measure(&RobotModel::named(preset.name).unwrap(), 2).unwrap();
                    assert!(quantities.len() >= 15, "{}", preset.name);
                });
            }
        });
    }
}
