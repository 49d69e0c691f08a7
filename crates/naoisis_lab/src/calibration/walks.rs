//! Fits slip, drift and the errors of odometry to walks.

use super::log::{Place, Walk};
use super::{Calibration, basis, between_robots, groups, mean, variance, wrap_degrees};
use naoisis_core::statistics::{Estimate, jackknife};

/// The least length of a straight walk, m.
const LEAST_WAY_M: f64 = 0.2;
/// The least angle of a turn, degrees.
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
        // A turn of more than half a turn is the one that is near to that of the legs.
        let turn = |turn: f64| legs_turn + wrap_degrees(turn - legs_turn);
        Self {
            robot: walk.robot,
            legs: [way, legs_turn],
            real: [along(walk.real.0), turn(walk.real.1)],
            counted: [along(walk.odometry.0), turn(walk.odometry.1)],
        }
    }
}

/// The sum of `of` over all walks divided by the sum of `over`.
fn ratio(walks: &[Compared], of: impl Fn(&Compared) -> f64, over: impl Fn(&Compared) -> f64) -> Option<f64> {
    let sum: f64 = walks.iter().map(over).sum();
    (sum != 0.0).then(|| walks.iter().map(of).sum::<f64>() / sum)
}

/// Fits the figures of walks.
pub(super) fn fit(walks: &[Walk], into: &mut Calibration) {
    if walks.is_empty() {
        into.lacking.push("motion.gait.slip, odometry.noise: no walks".to_owned());
        return;
    }
    let is_planned = walks.iter().all(|walk| walk.planned.is_some());
    let all: Vec<Compared> = walks.iter().map(Compared::of).collect();
    let straight: Vec<Compared> = all.iter().copied().filter(|walk| walk.legs[0] >= LEAST_WAY_M).collect();
    let turning: Vec<Compared> =
        all.iter().copied().filter(|walk| walk.legs[1].abs() >= LEAST_TURN_DEG && walk.legs[0] < LEAST_WAY_M).collect();
    let robot = |walk: &Compared| walk.robot;
    let ways = basis(&straight, "walks", robot);
    let turns = basis(&turning, "turns", robot);
    let over_groups = |rows: &[Compared], statistic: &dyn Fn(&[Compared]) -> Option<f64>| {
        if rows.len() < 3 { None } else { jackknife(&groups(rows, robot), statistic) }
    };

    let scale = |walks: &[Compared]| ratio(walks, |walk| walk.real[0], |walk| walk.legs[0]);
    let drift = |walks: &[Compared]| ratio(walks, |walk| walk.real[1] - walk.legs[1], |walk| walk.legs[0]);
    into.add("motion.gait.slip.scale", over_groups(&straight, &scale), &ways, "fewer than three straight walks");
    // What a robot's own mean errs by, from how its walks differ.
    let chance = |value: fn(&Compared) -> f64| {
        move |walks: &[Compared]| {
            let way = mean(&walks.iter().map(|walk| walk.legs[0]).collect::<Vec<f64>>()).unwrap_or(1.0);
            let values: Vec<f64> = walks.iter().map(value).collect();
            variance(&values).unwrap_or_default() / (walks.len() as f64 * way * way)
        }
    };
    let few = "walks of fewer than three robots (column `robot`)";
    let own_scale = |walk: &Compared| walk.real[0] - walk.legs[0];
    let own_drift = |walk: &Compared| walk.real[1] - walk.legs[1];
    into.add(
        "motion.gait.slip.scale_sd",
        between_robots(&straight, robot, |walks| Some([[scale(walks)?, chance(own_scale)(walks)]])),
        &ways,
        few,
    );
    into.add(
        "motion.gait.slip.drift_sd_degpm",
        between_robots(&straight, robot, |walks| Some([[drift(walks)?, chance(own_drift)(walks)]])),
        &ways,
        few,
    );

    // Of what is random, the variance grows with the way, or with the angle.
    let spread = |rows: &[Compared], error: fn(&Compared) -> f64, measure: fn(&Compared) -> f64| -> Option<Estimate> {
        let rate = move |walks: &[Compared]| ratio(walks, error, measure);
        let squares = move |walks: &[Compared]| -> Option<f64> {
            let mut sum = 0.0;
            let mut robots = 0;
            for of_robot in super::by_robot(walks, robot) {
                let rate = rate(&of_robot)?;
                robots += 1;
                sum += of_robot
                    .iter()
                    .map(|walk| {
                        let off = error(walk) - rate * measure(walk);
                        off * off / measure(walk)
                    })
                    .sum::<f64>();
            }
            (walks.len() > robots).then(|| (sum / (walks.len() - robots) as f64).sqrt())
        };
        over_groups(rows, &squares)
    };
    let way = |walk: &Compared| walk.legs[0];
    let angle = |walk: &Compared| walk.legs[1].abs();
    // A deviation that grows with the root of an angle in degrees, for a radian of it.
    let of_radian = |estimate: Estimate| {
        let scale = 1.0_f64.to_degrees().sqrt();
        Estimate { value: scale * estimate.value, low: scale * estimate.low, high: scale * estimate.high }
    };
    let few_walks = "fewer than three straight walks";
    let few_turns = "fewer than three turns on the spot";
    if is_planned {
        let slip = "motion.gait.slip.error";
        into.add(&format!("{slip}.translation_sd_m"), spread(&straight, own_scale, way), &ways, few_walks);
        into.add(&format!("{slip}.heading_per_metre_sd_deg"), spread(&straight, own_drift, way), &ways, few_walks);
        let rotation = spread(&turning, own_drift, angle).map(of_radian);
        into.add(&format!("{slip}.rotation_sd_deg"), rotation, &turns, few_turns);
        let counted_scale = |walks: &[Compared]| ratio(walks, |walk| walk.counted[0], |walk| walk.legs[0]);
        let counted_turn = |walks: &[Compared]| ratio(walks, |walk| walk.counted[1], |walk| walk.legs[1]);
        let noise = "odometry.noise";
        into.add(&format!("{noise}.translation_scale"), over_groups(&straight, &counted_scale), &ways, few_walks);
        into.add(&format!("{noise}.rotation_scale"), over_groups(&turning, &counted_turn), &turns, few_turns);
    } else {
        let words = "motion.gait.slip.error: without the columns `planned_…` what slips and what odometry miscounts cannot be told \
                     apart; all of it is taken for odometry's";
        into.lacking.push(words.to_owned());
    }
    let counted_way: fn(&Compared) -> f64 =
        if is_planned { |walk| walk.counted[0] - walk.legs[0] } else { |walk| walk.real[0] - walk.legs[0] };
    let counted_turn: fn(&Compared) -> f64 =
        if is_planned { |walk| walk.counted[1] - walk.legs[1] } else { |walk| walk.real[1] - walk.legs[1] };
    let noise = "odometry.noise";
    into.add(&format!("{noise}.translation_sd_m"), spread(&straight, counted_way, way), &ways, few_walks);
    into.add(&format!("{noise}.heading_per_metre_sd_deg"), spread(&straight, counted_turn, way), &ways, few_walks);
    let rotation = spread(&turning, counted_turn, angle).map(of_radian);
    into.add(&format!("{noise}.rotation_sd_deg"), rotation, &turns, few_turns);
}
