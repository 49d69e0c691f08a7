//! Fits slip, drift and the errors of odometry to walks.

use super::log::{Place, Walk};
use super::{
    Calibration, basis, between_robots, groups, jackknife_positive, mean, of_transformed, variance, wrap_degrees,
};
use naoisis_core::statistics::{Estimate, jackknife};

/// Least length of a straight walk, m.
const LEAST_WAY_M: f64 = 0.2;
/// Least angle of a turn, degrees.
const LEAST_TURN_DEG: f64 = 20.0;

/// A walk compared with the motion of the legs: as planned, or by odometry if the plan is not in the log.
#[derive(Clone, Copy)]
struct Compared {
    robot: usize,
    /// The displacement of the legs, m, and their turn, degrees.
    legs: [f64; 2],
    /// The displacement of the robot along that of the legs, m, and its turn, degrees.
    real: [f64; 2],
    /// The displacement and turn by odometry.
    counted: [f64; 2],
}

impl Compared {
    fn of(walk: &Walk) -> Self {
        let (legs, legs_turn) = walk.planned.unwrap_or(walk.odometry);
        let way = libm::hypot(legs[0], legs[1]);
        let along = |[x, y]: Place| if way > 0.0 { (x * legs[0] + y * legs[1]) / way } else { 0.0 };
        // Turns of more than half a turn are unwrapped to be near that of the legs.
        let turn = |turn: f64| legs_turn + wrap_degrees(turn - legs_turn);
        Self {
            robot: walk.robot,
            legs: [way, legs_turn],
            real: [along(walk.real.0), turn(walk.real.1)],
            counted: [along(walk.odometry.0), turn(walk.odometry.1)],
        }
    }
}

/// Returns the sum of `of` over all walks divided by the sum of `over`.
fn ratio(walks: &[Compared], of: impl Fn(&Compared) -> f64, over: impl Fn(&Compared) -> f64) -> Option<f64> {
    let sum: f64 = walks.iter().map(over).sum();
    (sum != 0.0).then(|| walks.iter().map(of).sum::<f64>() / sum)
}

/// Returns the estimate of a statistic over the groups of rows; `None` for fewer than three rows.
fn over_groups(rows: &[Compared], statistic: impl Fn(&[Compared]) -> Option<f64>) -> Option<Estimate> {
    if rows.len() < 3 { None } else { jackknife(&groups(rows, robot), statistic) }
}

fn robot(walk: &Compared) -> usize {
    walk.robot
}

fn way(walk: &Compared) -> f64 {
    walk.legs[0]
}

/// Displacement and turn of robots minus those of their legs, m and degrees.
const SLIPPED: [fn(&Compared) -> f64; 2] = [|walk| walk.real[0] - walk.legs[0], |walk| walk.real[1] - walk.legs[1]];
/// Displacement and turn by odometry minus those of the legs, m and degrees.
const MISCOUNTED: [fn(&Compared) -> f64; 2] =
    [|walk| walk.counted[0] - walk.legs[0], |walk| walk.counted[1] - walk.legs[1]];

const FEW_WALKS: &str = "fewer than three straight walks";
const FEW_TURNS: &str = "fewer than three turns on the spot";

/// Straight walks, and turns on the spot.
struct Samples {
    straight: Vec<Compared>,
    turning: Vec<Compared>,
}

impl Samples {
    fn of(walks: &[Walk]) -> Self {
        let all = || walks.iter().map(Compared::of);
        let turns = |walk: &Compared| walk.legs[1].abs() >= LEAST_TURN_DEG && way(walk) < LEAST_WAY_M;
        Self {
            straight: all().filter(|walk| way(walk) >= LEAST_WAY_M).collect(),
            turning: all().filter(turns).collect(),
        }
    }

    fn ways(&self) -> String {
        basis(&self.straight, "walks", robot)
    }

    fn turns(&self) -> String {
        basis(&self.turning, "turns", robot)
    }
}

/// Fits the figures of walks.
pub(super) fn fit(walks: &[Walk], into: &mut Calibration) {
    if walks.is_empty() {
        into.lacking.push("motion.gait.slip, odometry.noise: no walks".to_owned());
        return;
    }
    let samples = Samples::of(walks);
    fit_slip(&samples, into);
    let is_planned = walks.iter().all(|walk| walk.planned.is_some());
    if is_planned {
        fit_errors("motion.gait.slip.error", &samples, SLIPPED, into);
        let scale = over_groups(&samples.straight, |walks| ratio(walks, |walk| walk.counted[0], way));
        into.add("odometry.noise.translation_scale", scale, &samples.ways(), FEW_WALKS);
        let scale = over_groups(&samples.turning, |walks| ratio(walks, |walk| walk.counted[1], |walk| walk.legs[1]));
        into.add("odometry.noise.rotation_scale", scale, &samples.turns(), FEW_TURNS);
    } else {
        let words = "motion.gait.slip.error: without the columns `planned_…` what slips and what odometry miscounts cannot be told \
                     apart; all of it is taken for odometry's";
        into.lacking.push(words.to_owned());
    }
    fit_errors("odometry.noise", &samples, if is_planned { MISCOUNTED } else { SLIPPED }, into);
}

/// Fits the systematic slip: its scale, and the variation of scale and drift between robots.
fn fit_slip(samples: &Samples, into: &mut Calibration) {
    const FEW_ROBOTS: &str = "walks of fewer than three robots (column `robot`)";

    let (straight, ways) = (&samples.straight, samples.ways());
    let scale = |walks: &[Compared]| ratio(walks, |walk| walk.real[0], way);
    let drift = |walks: &[Compared]| ratio(walks, SLIPPED[1], way);
    into.add("motion.gait.slip.scale", over_groups(straight, scale), &ways, FEW_WALKS);
    // Variance by chance of a robot's own mean, from the differences between its walks.
    let chance = |walks: &[Compared], value: fn(&Compared) -> f64| {
        let mean_way = mean(&walks.iter().map(way).collect::<Vec<f64>>()).unwrap_or(1.0);
        let values: Vec<f64> = walks.iter().map(value).collect();
        variance(&values).unwrap_or_default() / (walks.len() as f64 * mean_way * mean_way)
    };
    let scales = between_robots(straight, robot, |walks| Some([[scale(walks)?, chance(walks, SLIPPED[0])]]));
    into.add("motion.gait.slip.scale_sd", scales, &ways, FEW_ROBOTS);
    let drifts = between_robots(straight, robot, |walks| Some([[drift(walks)?, chance(walks, SLIPPED[1])]]));
    into.add("motion.gait.slip.drift_sd_degpm", drifts, &ways, FEW_ROBOTS);
}

/// Fits the random errors of displacement and turn, which are figures within `path`.
fn fit_errors(path: &str, samples: &Samples, [off_way, off_turn]: [fn(&Compared) -> f64; 2], into: &mut Calibration) {
    // Converts a deviation that grows with the square root of an angle, from one degree to one radian.
    let of_radian = |estimate: Estimate| of_transformed(estimate, |value| 1.0_f64.to_degrees().sqrt() * value);
    let (ways, turns) = (samples.ways(), samples.turns());
    into.add(&format!("{path}.translation_sd_m"), spread(&samples.straight, off_way, way), &ways, FEW_WALKS);
    into.add(&format!("{path}.heading_per_metre_sd_deg"), spread(&samples.straight, off_turn, way), &ways, FEW_WALKS);
    let rotation = spread(&samples.turning, off_turn, |walk| walk.legs[1].abs()).map(of_radian);
    into.add(&format!("{path}.rotation_sd_deg"), rotation, &turns, FEW_TURNS);
}

/// Returns the standard deviation of `error` at one unit of `measure`. Its variance is proportional to `measure`.
fn spread(rows: &[Compared], error: fn(&Compared) -> f64, measure: fn(&Compared) -> f64) -> Option<Estimate> {
    if rows.len() < 3 {
        return None;
    }
    jackknife_positive(&groups(rows, robot), |walks| {
        let (mut sum, mut robots) = (0.0, 0);
        for of_robot in super::by_robot(walks, robot) {
            let rate = ratio(&of_robot, error, measure)?;
            robots += 1;
            let square = |walk: &Compared| {
                let off = error(walk) - rate * measure(walk);
                off * off / measure(walk)
            };
            sum += of_robot.iter().map(square).sum::<f64>();
        }
        (walks.len() > robots).then(|| (sum / (walks.len() - robots) as f64).sqrt())
    })
}
