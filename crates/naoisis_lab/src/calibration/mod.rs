//! Calibration: the figures of a real robot, from tables of what it did.
//!
//! A [`RobotLog`] has walks, kicks and sightings, as somebody measured them with a camera over the pitch or a tape measure. From it
//! [`calibrate`] finds the figures of a [model](naoisis_sim::scenario::RobotModel) that belong to them, each with an interval, and
//! says what it lacked. `naoisis calibrate` writes them into a model of one's own.
//!
//! [`calibrate_by_images`] finds those of a robot's vision from images in place of a log.
//!
//! Intervals are of 95 % confidence, by the jackknife: over robots where there are enough of them, else over stretches of the log.

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

/// A figure of a model, as a log has it.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub struct FittedFigure {
    /// Its path in the model's `realistic` part, such as `motion.gait.slip.scale`.
    pub path: String,
    /// The figure, in the units of that path.
    pub estimate: Estimate,
    /// What it was found from, such as `40 walks of 8 robots`.
    pub basis: String,
}

/// What a log says of a robot.
#[derive(Clone, PartialEq, Debug, Default)]
#[non_exhaustive]
pub struct Calibration {
    /// The figures that were found.
    pub figures: Vec<FittedFigure>,
    /// What could not be found, and which column or how many rows it would have needed.
    pub lacking: Vec<String>,
}

impl Calibration {
    /// The figure of this path.
    pub fn figure(&self, path: &str) -> Option<&FittedFigure> {
        self.figures.iter().find(|figure| figure.path == path)
    }

    /// Takes note of a figure, or of what it lacked.
    fn add(&mut self, path: &str, estimate: Option<Estimate>, basis: &str, needs: &str) {
        match estimate.filter(|estimate| estimate.value.is_finite() && estimate.margin().is_finite()) {
            Some(estimate) => {
                self.figures.push(FittedFigure { path: path.to_owned(), estimate, basis: basis.to_owned() });
            }
            None => self.lacking.push(format!("{path}: {needs}")),
        }
    }
}

/// What a log says of a robot of which `model` has the rest.
pub fn calibrate(log: &RobotLog, model: &RobotModel) -> Calibration {
    let mut calibration = Calibration::default();
    walks::fit(&log.walks, &mut calibration);
    kicks::fit(&log.kicks, model, &mut calibration);
    sightings::fit(&log.sightings, model, &mut calibration);
    calibration
}

/// From so many robots on, they are the groups of a jackknife; with fewer, it is stretches of the log.
const ROBOTS_FOR_GROUPS: usize = 8;
/// Stretches into which a log of few robots is cut.
const STRETCHES: usize = 20;

/// Rows in groups that are independent of each other.
fn groups<T: Copy>(rows: &[T], robot: impl Fn(&T) -> usize) -> Vec<Vec<T>> {
    let robots = by_robot(rows, robot);
    if robots.len() >= ROBOTS_FOR_GROUPS {
        return robots;
    }
    let length = rows.len().div_ceil(STRETCHES).max(1);
    rows.chunks(length).map(<[T]>::to_vec).collect()
}

/// Rows by robot.
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

/// The standard deviation from robot to robot of what `draws` are of each: one value or more that are drawn alike, each with the
/// variance that chance alone gives it, which is taken away. None of fewer than three robots.
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

/// The mean. None of nothing.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The variance about the mean. None of fewer than two.
fn variance(values: &[f64]) -> Option<f64> {
    let mean = mean(values).filter(|_| values.len() > 1)?;
    Some(values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (values.len() as f64 - 1.0))
}

/// How many rows of how many robots.
fn basis<T: Copy>(rows: &[T], what: &str, robot: impl Fn(&T) -> usize) -> String {
    let robots = by_robot(rows, robot).len();
    format!("{} {what} of {robots} robot{}", rows.len(), if robots == 1 { "" } else { "s" })
}

/// An angle in (-180, 180], degrees.
fn wrap_degrees(angle: f64) -> f64 {
    180.0 - (180.0 - angle).rem_euclid(360.0)
}
