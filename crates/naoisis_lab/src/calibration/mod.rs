//! Calibration: fits the figures of a robot model to logs of a real robot.
//!
//! A [`RobotLog`] has walks, kicks and sightings that were measured with a camera above the pitch or a tape measure.
//! [`calibrate`] fits the figures of a [model](naoisis_sim::scenario::RobotModel) to it, each with an interval, and
//! reports which data were missing. `naoisis calibrate` writes the result as a new model.
//!
//! [`calibrate_by_images`] fits the figures of vision to rendered images instead of a log.
//!
//! Intervals have 95 % confidence, by the jackknife: over robots if there are enough of them, else over stretches of
//! the log. Those of standard deviations, distances and times are symmetric in proportion and not in difference, so that
//! they are never negative.

use naoisis_core::statistics::{Estimate, jackknife};
use naoisis_sim::scenario::RobotModel;

mod images;
mod kicks;
mod log;
mod model_file;
mod odometry;
mod sightings;
mod walks;

pub use images::calibrate_by_images;
pub use log::{COLUMNS, Kick, LogError, LogErrorKind, LoggedSighting, Motion, RobotLog, Thing, Walk};
pub use model_file::model_file;
pub(crate) use model_file::ron_text;
pub use odometry::OdometryTrack;

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

/// Fits figures to `log`. `model` has the figures that a log does not determine, and can have all that are found.
pub fn calibrate(log: &RobotLog, model: &RobotModel) -> Calibration {
    let mut calibration = Calibration::default();
    walks::fit(&log.walks, &mut calibration);
    kicks::fit(&log.kicks, model, &mut calibration);
    sightings::fit(&log.sightings, model, &mut calibration);
    calibration.keep_possible(model);
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
    jackknife_positive(&robots, |robots| {
        let of_draw = |index: usize| {
            let values: Vec<f64> = robots.iter().map(|draws| draws[index][0]).collect();
            let of_chance = robots.iter().map(|draws| draws[index][1]).sum::<f64>() / robots.len() as f64;
            Some(variance(&values)? - of_chance)
        };
        let variances: Option<Vec<f64>> = (0..N).map(of_draw).collect();
        Some(mean(&variances?)?.max(0.0).sqrt())
    })
}

/// A statistic that cannot be negative, with the interval of the jackknife. Its upper end is as many times the value as the value is of
/// its lower end, so that it is never negative; of 0 it begins at 0.
fn jackknife_positive<T: Copy>(groups: &[Vec<T>], statistic: impl Fn(&[T]) -> Option<f64>) -> Option<Estimate> {
    let Estimate { value, high, .. } = jackknife(groups, statistic)?;
    Some(Estimate { value, low: if value > 0.0 { value * (value / high) } else { 0.0 }, high })
}

/// The estimate of a quantity from that of a function of it, of which `inverse` is the increasing inverse.
fn of_transformed(estimate: Estimate, inverse: impl Fn(f64) -> f64) -> Estimate {
    let Estimate { value, low, high } = estimate;
    Estimate { value: inverse(value), low: inverse(low), high: inverse(high) }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn deviation(values: &[f64]) -> Option<f64> {
        variance(values).map(f64::sqrt)
    }

    #[test]
    fn intervals_of_deviations_are_never_negative() {
        // One value far from the others: Student's interval would reach below 0.
        let few: Vec<Vec<f64>> = [0.1, 0.12, 0.09, 0.11, 3.0].map(|value| vec![value]).to_vec();
        let linear = jackknife(&few, deviation).unwrap();
        let found = jackknife_positive(&few, deviation).unwrap();
        assert!(linear.low < 0.0 && found.low > 0.0 && found.low < found.value, "{linear:?} {found:?}");
        assert_eq!((found.value, found.high), (linear.value, linear.high));
        let same: Vec<Vec<f64>> = vec![vec![0.5]; 4];
        assert_eq!(jackknife_positive(&same, deviation), Some(Estimate::exactly(0.0)));
        assert_eq!(jackknife_positive::<f64>(&[], deviation), None);
    }

    #[test]
    fn intervals_of_deviations_have_the_true_one_as_often_as_they_say() {
        let mut stream = naoisis_core::random::RandomStream::for_match(5, "calibration");
        let mut hits = 0;
        for _ in 0..400 {
            let groups: Vec<Vec<f64>> =
                (0..20).map(|_| (0..3).map(|_| f64::from(stream.gaussian(2.0))).collect()).collect();
            let found = jackknife_positive(&groups, deviation).unwrap();
            hits += u32::from((found.low..=found.high).contains(&2.0));
        }
        // 95 % of 400 are 380, with a deviation of 4.4.
        assert!((365..=395).contains(&hits), "{hits}");
    }
}
