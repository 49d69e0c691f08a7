//! Trials of walking and odometry.

use bevy::math::{Vec2, Vec3, ops};
use serde_json::{Value, json};

use super::{Laboratory, MeasuredQuantity, TrialError, deviation_of, mean_of};
use naoisis_core::geometry::{to_degrees, wrap_angle};
use naoisis_core::robot::gait::Gait;
use naoisis_core::robot::motion::ExecutedStep;
use naoisis_sensing::sensing::odometry::Odometry;
use naoisis_sim::scenario::{RobotModel, Scenario};
use naoisis_sim::simulation::MatchApp;

/// A longer step than any robot can make in a cycle, m.
const FASTEST: f32 = 1.0;
/// A larger turn than any robot can make in a cycle, degrees.
const MOST_TURN: f32 = 100.0;
/// The duration of walks, s.
const WALK_S: f64 = 5.0;
/// The duration of turns, s.
const TURN_S: f64 = 2.0;

/// A robot that repeats `step` for the whole trial.
fn walker(step: [f32; 3], seed: u32) -> Value {
    let script = json!({ "script": [{ "from_s": 0, "until_s": 1000, "walk": step }] });
    json!({ "seed": seed, "ball": null, "falls": { "falls_per_min": 0 }, "robots": [{ "team": "blue", "number": 1, "behaviour": script }] })
}

/// A walk: the true motion, that of the legs, and that by odometry.
struct Walk {
    /// The speed at the end, m/s.
    speed_mps: f64,
    /// The turning speed at the end, degrees/s.
    turn_degps: f64,
    /// The time until the legs reached their full speed or turning speed, s.
    started_s: f64,
    /// The displacement of the robot, of its legs and by odometry, m.
    ways: [f64; 3],
    /// The turn of the robot, of its legs and by odometry, degrees.
    turns: [f64; 3],
}

/// Runs a walk.
fn walk(laboratory: &mut Laboratory, step: [f32; 3], seed: u32) -> Result<Walk, TrialError> {
    laboratory.begin(walker(step, seed))?;
    let cycles = laboratory.cycles(if step[2] == 0.0 { WALK_S } else { TURN_S });
    let period_s = laboratory.period_s();
    let second = laboratory.cycles(1.0);
    let [mut ways, mut turns] = [[0.0; 3]; 2];
    let mut after = vec![(0.0, 0.0)];
    let mut legs_did = Vec::with_capacity(cycles);
    for _ in 0..cycles {
        let (pose, Odometry(counted)) = (laboratory.pose(), laboratory.reading());
        laboratory.app.run_cycles(1);
        // Odometry counts the steps of the cycle before.
        let (moved, Odometry(counted_now)) = (pose.relative(laboratory.pose()), laboratory.reading());
        let ExecutedStep(legs) = laboratory.reading();
        let counted = counted.relative(counted_now);
        legs_did.push(Vec3::new(legs.dx, legs.dy, legs.dtheta));
        let steps =
            [(moved.position, moved.heading), (legs.translation(), legs.dtheta), (counted.position, counted.heading)];
        // What is counted errs sideways, too: of that the way along the commanded direction is none.
        let along = Vec2::new(step[0], step[1]).normalize_or_zero();
        for (index, (translation, turn)) in steps.into_iter().enumerate() {
            ways[index] += f64::from(translation.dot(along));
            turns[index] += f64::from(to_degrees(wrap_angle(turn)));
        }
        after.push((ways[0], turns[0]));
    }
    let rate = |from: usize, to: usize| {
        let seconds = (to - from) as f64 * period_s;
        ((after[to].0 - after[from].0) / seconds, (after[to].1 - after[from].1) / seconds)
    };
    let (speed_mps, turn_degps) = rate(cycles - second, cycles);
    let last = legs_did.last().copied().unwrap_or_default();
    let is_full = |step: &Vec3| step.length() >= 0.999 * last.length();
    let started_s = legs_did.iter().position(is_full).unwrap_or_default() as f64 * period_s;
    Ok(Walk { speed_mps, turn_degps, started_s, ways, turns })
}

/// Whether the robots of a scenario can walk.
pub(super) fn walks(scenario: &Scenario) -> bool {
    scenario.motion.max_linear_mps > 0.0
}

/// Whether the robots of a scenario can turn.
pub(super) fn turns(scenario: &Scenario) -> bool {
    scenario.motion.max_angular > 0.0
}

/// The quantities that are measured of turns; all others are of walks.
const OF_TURNS: [&str; 4] = [
    "turn",
    "from standing to the full turn",
    "spread of a turn by a radian",
    "odometry: spread after a turn of a radian",
];

/// Measures speeds, accelerations, slip, and the errors of odometry.
///
/// # Errors
/// When the model makes no valid scenario.
pub fn measure(model: &RobotModel, repetitions: u32) -> Result<Vec<MeasuredQuantity>, TrialError> {
    let mut laboratory = Laboratory::new(model);
    let mut walked = |step: [f32; 3], repetitions: u32| -> Result<Vec<Walk>, TrialError> {
        (1..=repetitions.max(2)).map(|seed| walk(&mut laboratory, step, seed)).collect()
    };
    // A mean is known sooner than a spread.
    let some = repetitions / 8;
    let [forward, backward, sideways, turn] = [
        walked([FASTEST, 0.0, 0.0], repetitions)?,
        walked([-FASTEST, 0.0, 0.0], some)?,
        walked([0.0, FASTEST, 0.0], some)?,
        walked([0.0, 0.0, MOST_TURN], repetitions)?,
    ];
    let of = |walks: &[Walk], value: fn(&Walk) -> f64| walks.iter().map(value).collect::<Vec<f64>>();
    let real = laboratory.scenario(json!({}))?;
    let (motion, noise) = (real.motion, real.odometry.noise);
    let gait = motion.gait.unwrap_or(Gait {
        backward_mps: motion.max_linear_mps,
        sideways_mps: motion.max_linear_mps,
        ..Gait::default()
    });
    let slip = gait.slip;
    // Of a way L, the length spreads by a share and by the root of L, and so does the heading.
    let way = mean_of(&of(&forward, |walk| walk.ways[1])) as f32;
    let shares = of(&forward, |walk| walk.ways[0] / walk.ways[1]);
    let drifts = of(&forward, |walk| walk.turns[0] / walk.ways[1]);
    let counted = of(&forward, |walk| walk.ways[2] / walk.ways[1]);
    let headings = of(&forward, |walk| (walk.turns[2] - walk.turns[1]) / walk.ways[1].sqrt());
    // The variance grows with the angle, so that what is divided by its root is that of a radian.
    let of_radian = |walk: &Walk, error: f64| error / walk.turns[1].abs().to_radians().sqrt();
    let turned: Vec<f64> = turn.iter().map(|walk| of_radian(walk, walk.turns[0] - walk.turns[1])).collect();
    let counted_turns: Vec<f64> = turn.iter().map(|walk| of_radian(walk, walk.turns[2] - walk.turns[1])).collect();
    // The command's way, and how long the steps take that come before the first one at full speed.
    let start_s = |full: f32, acceleration: f32| {
        // Who has no gait is as fast as it can be at once.
        if motion.gait.is_none() {
            return real.latency.walk_s;
        }
        real.latency.walk_s + (ops::ceil(full / (acceleration * gait.step_s) - 1e-3).max(1.0) - 1.0) * gait.step_s
    };
    let mean = |walks: &[Walk], value: fn(&Walk) -> f64| mean_of(&of(walks, value));

    let quantity = |name, unit, measured, real: f32, path| laboratory.quantity(name, unit, measured, real.into(), path);
    let speed = |name, walks, real: f32, path| {
        quantity(name, "m/s", mean(walks, |walk| walk.speed_mps), slip.scale * real, path)
    };
    // Who has no gait of its own is as fast in all directions.
    let of_gait = |path| if motion.gait.is_some() { path } else { "motion.max_linear_mps" };
    let quantities = [
        speed("speed forward", &forward, motion.max_linear_mps, "motion.max_linear_mps"),
        speed("speed backward", &backward, gait.backward_mps, of_gait("motion.gait.backward_mps")),
        speed("speed sideways", &sideways, gait.sideways_mps, of_gait("motion.gait.sideways_mps")),
        quantity(
            "turn",
            "°/s",
            mean(&turn, |walk| walk.turn_degps),
            to_degrees(motion.max_angular),
            "motion.max_angular_degps",
        ),
        quantity(
            "from standing to full speed",
            "s",
            mean(&forward, |walk| walk.started_s),
            start_s(motion.max_linear_mps, gait.acceleration_mps2),
            "motion.gait.acceleration_mps2",
        ),
        quantity(
            "from standing to the full turn",
            "s",
            mean(&turn, |walk| walk.started_s),
            start_s(motion.max_angular, gait.angular_acceleration),
            "motion.gait.angular_acceleration_degps2",
        ),
        quantity("way walked for a way of the legs", "", mean_of(&shares), slip.scale, "motion.gait.slip.scale"),
        quantity(
            "spread of that over walks of a metre",
            "",
            deviation_of(&shares),
            ops::hypot(slip.scale_sd, slip.error.translation_sd_m / ops::sqrt(way)),
            "motion.gait.slip.scale_sd",
        ),
        quantity(
            "drift of the heading on a straight metre",
            "°",
            deviation_of(&drifts),
            to_degrees(ops::hypot(slip.drift_sd, slip.error.heading_per_metre_sd / ops::sqrt(way))),
            "motion.gait.slip.drift_sd_degpm",
        ),
        quantity(
            "spread of a turn by a radian",
            "°",
            deviation_of(&turned),
            to_degrees(slip.error.rotation_sd),
            "motion.gait.slip.error",
        ),
        quantity(
            "odometry: way counted for a way of the legs",
            "",
            mean_of(&counted),
            noise.translation_scale,
            "odometry.noise.translation_scale",
        ),
        quantity(
            "odometry: spread after a metre",
            "m",
            deviation_of(&counted) * f64::from(ops::sqrt(way)),
            noise.translation_sd_m,
            "odometry.noise.translation_sd_m",
        ),
        quantity(
            "odometry: spread of the heading after a metre",
            "°",
            deviation_of(&headings),
            to_degrees(noise.heading_per_metre_sd),
            "odometry.noise.heading_per_metre_sd_deg",
        ),
        quantity(
            "odometry: spread after a turn of a radian",
            "°",
            deviation_of(&counted_turns),
            to_degrees(noise.rotation_sd),
            "odometry.noise.rotation_sd_deg",
        ),
    ];
    let [has_walk, has_turn] = [walks(&real), turns(&real)];
    let has =
        |quantity: &MeasuredQuantity| if OF_TURNS.contains(&quantity.name.as_str()) { has_turn } else { has_walk };
    Ok(quantities.into_iter().filter(has).collect())
}
