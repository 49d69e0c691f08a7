//! Calibration: fits the figures of a robot model to logs of a real robot.
//!
//! A [`RobotLog`] has walks, kicks and sightings that were measured with a camera above the pitch or a tape measure.
//! [`calibrate`] fits the figures of a [model](naoisis_sim::scenario::RobotModel) to it, each with an interval, and
//! reports which data were missing. `naoisis calibrate` writes the result as a new model.
//!
//! [`calibrate_by_images`] fits the figures of vision to rendered images instead of a log.
//!
//! Intervals have 95 % confidence, by the jackknife: over robots if there are enough of them, else over stretches of
//! the log.

use naoisis_core::statistics::{Estimate, jackknife};
use naoisis_sim::scenario::RobotModel;

mod images;
mod kicks;
mod log;
mod model_file;
mod sightings;
mod walks;

pub use images::calibrate_by_images;
pub use log::{COLUMNS, Kick, LogError, LogErrorKind, LoggedSighting, Motion, RobotLog, Thing, Walk};
pub use model_file::model_file;
pub(crate) use model_file::ron_text;

/// A fitted figure of a model.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub struct FittedFigure {
    /// Its path in the model's `realistic` part, such as `motion.gait.slip.scale`.
    pub path: String,
    /// The value, in the unit of `path`.
    pub estimate: Estimate,
    /// The data of the fit, such as `40 walks of 8 robots`.
    pub basis: String,
}

/// The result of a calibration.
#[derive(Clone, PartialEq, Debug, Default)]
#[non_exhaustive]
pub struct Calibration {
    /// The figures that were found.
    pub figures: Vec<FittedFigure>,
    /// The figures that could not be fitted, with the columns or number of rows that they need.
    pub lacking: Vec<String>,
}

impl Calibration {
    /// The figure with this path.
    pub fn figure(&self, path: &str) -> Option<&FittedFigure> {
        self.figures.iter().find(|figure| figure.path == path)
    }

    /// Adds a figure, or if `estimate` is `None` what it needs.
    fn add(&mut self, path: &str, estimate: Option<Estimate>, basis: &str, needs: &str) {
        match estimate.filter(|estimate| estimate.value.is_finite() && estimate.margin().is_finite()) {
            Some(estimate) => {
                self.figures.push(FittedFigure { path: path.to_owned(), estimate, basis: basis.to_owned() });
            }
            None => self.lacking.push(format!("{path}: {needs}")),
        }
    }
}

/// Fits figures to `log`. `model` has the figures that a log does not determine.
pub fn calibrate(log: &RobotLog, model: &RobotModel) -> Calibration {
    let mut calibration = Calibration::default();
    walks::fit(&log.walks, &mut calibration);
    kicks::fit(&log.kicks, model, &mut calibration);
    sightings::fit(&log.sightings, model, &mut calibration);
    calibration
}

/// From this number of robots on, the jackknife groups rows by robot; with fewer, by stretches of the log.
const ROBOTS_FOR_GROUPS: usize = 8;
/// The number of stretches of a log with few robots.
const STRETCHES: usize = 20;

/// Groups rows so that groups are independent of each other.
fn groups<T: Copy>(rows: &[T], robot: impl Fn(&T) -> usize) -> Vec<Vec<T>> {
    let robots = by_robot(rows, robot);
    if robots.len() >= ROBOTS_FOR_GROUPS {
        return robots;
    }
    let length = rows.len().div_ceil(STRETCHES).max(1);
    rows.chunks(length).map(<[T]>::to_vec).collect()
}

/// Groups rows by robot.
fn by_robot<T: Copy>(rows: &[T], robot: impl Fn(&T) -> usize) -> Vec<Vec<T>> {
    let mut robots: Vec<Vec<T>> = Vec::new();
    for row in rows {
        let index = robot(row);
        if robots.len() <= index {
            robots.resize_with(index + 1, Vec::new);
        }
        robots[index].push(*row);
    }
    robots.retain(|rows| !rows.is_empty());
    robots
}

/// The standard deviation between robots of each value in `draws`, without the variance that the values of one robot
/// have by chance. `None` for fewer than three robots.
fn between_robots<T: Copy, const N: usize>(
    rows: &[T],
    robot: impl Fn(&T) -> usize,
    draws: impl Fn(&[T]) -> Option<[[f64; 2]; N]>,
) -> Option<Estimate> {
    let robots: Vec<Vec<[[f64; 2]; N]>> =
        by_robot(rows, robot).iter().filter_map(|rows| Some(vec![draws(rows)?])).collect();
    if robots.len() < 3 {
        return None;
    }
    let estimate = jackknife(&robots, |robots| {
        let of_draw = |index: usize| {
            let values: Vec<f64> = robots.iter().map(|draws| draws[index][0]).collect();
            let of_chance = robots.iter().map(|draws| draws[index][1]).sum::<f64>() / robots.len() as f64;
            Some(variance(&values)? - of_chance)
        };
        let variances: Option<Vec<f64>> = (0..N).map(of_draw).collect();
        Some(mean(&variances?)?.max(0.0).sqrt())
    })?;
    Some(Estimate { low: estimate.low.max(0.0), ..estimate })
}

/// The mean; `None` for no values.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The sample variance; `None` for fewer than two values.
fn variance(values: &[f64]) -> Option<f64> {
    let mean = mean(values).filter(|_| values.len() > 1)?;
    Some(values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (values.len() as f64 - 1.0))
}

/// The number of rows and of robots, in words.
fn basis<T: Copy>(rows: &[T], what: &str, robot: impl Fn(&T) -> usize) -> String {
    let robots = by_robot(rows, robot).len();
    format!("{} {what} of {robots} robot{}", rows.len(), if robots == 1 { "" } else { "s" })
}

/// Wraps an angle to (-180, 180], degrees.
fn wrap_degrees(angle: f64) -> f64 {
    180.0 - (180.0 - angle).rem_euclid(360.0)
}
