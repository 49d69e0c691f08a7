//! Trials of walking and odometry.

use bevy::math::{Vec2, Vec3, ops};
use serde_json::{Value, json};

use super::{Laboratory, MeasuredQuantity, TrialError, deviation_of, mean_of};
use naoisis_core::geometry::{to_degrees, wrap_angle};
use naoisis_core::robot::gait::Gait;
use naoisis_core::robot::motion::{ExecutedStep, MotionSettings};
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
        // Odometry counts the steps of the previous cycle.
        let (moved, Odometry(counted_now)) = (pose.relative(laboratory.pose()), laboratory.reading());
        let ExecutedStep(legs) = laboratory.reading();
        let counted = counted.relative(counted_now);
        legs_did.push(Vec3::new(legs.dx, legs.dy, legs.dtheta));
        let steps =
            [(moved.position, moved.heading), (legs.translation(), legs.dtheta), (counted.position, counted.heading)];
        // Odometry also errs sideways. Only the displacement along the commanded direction counts.
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
    scenario.settings.motion.max_linear_mps > 0.0
}

/// Whether the robots of a scenario can turn.
pub(super) fn turns(scenario: &Scenario) -> bool {
    scenario.settings.motion.max_angular > 0.0
}

/// A measured quantity, and the setting of the model that it belongs to.
struct Row {
    name: &'static str,
    unit: &'static str,
    measured: f64,
    real: f32,
    path: &'static str,
}

fn row([name, unit, path]: [&'static str; 3], measured: f64, real: f32) -> Row {
    Row { name, unit, measured, real, path }
}

/// Walks at full speed in each direction, and turns on the spot.
struct Walks {
    forward: Vec<Walk>,
    backward: Vec<Walk>,
    sideways: Vec<Walk>,
    aslant: Vec<Walk>,
    turn: Vec<Walk>,
}

impl Walks {
    fn run(laboratory: &mut Laboratory, repetitions: u32) -> Result<Self, TrialError> {
        let mut walked = |step: [f32; 3], repetitions: u32| -> Result<Vec<Walk>, TrialError> {
            (1..=repetitions.max(2)).map(|seed| walk(laboratory, step, seed)).collect()
        };
        // A mean needs fewer repetitions than a spread.
        let some = repetitions / 8;
        Ok(Self {
            forward: walked([FASTEST, 0.0, 0.0], repetitions)?,
            backward: walked([-FASTEST, 0.0, 0.0], some)?,
            sideways: walked([0.0, FASTEST, 0.0], some)?,
            aslant: walked([FASTEST, FASTEST, 0.0], some)?,
            turn: walked([0.0, 0.0, MOST_TURN], repetitions)?,
        })
    }
}

fn values(walks: &[Walk], value: impl Fn(&Walk) -> f64) -> Vec<f64> {
    walks.iter().map(value).collect()
}

fn mean(walks: &[Walk], value: impl Fn(&Walk) -> f64) -> f64 {
    mean_of(&values(walks, value))
}

/// The gait of a scenario's robots. Robots without one walk equally fast in all directions.
fn gait_of(motion: &MotionSettings) -> Gait {
    motion.gait.unwrap_or(Gait {
        backward_mps: motion.max_linear_mps,
        sideways_mps: motion.max_linear_mps,
        ..Gait::default()
    })
}

/// The time from a command to a step at the speed `full`, s: the latency, and the duration of slower steps before it.
fn start_s(real: &Scenario, full: f32, acceleration: f32) -> f32 {
    // A robot without a gait reaches its speed at once.
    let Some(gait) = real.settings.motion.gait else { return real.settings.latency.walk_s };
    real.settings.latency.walk_s + (ops::ceil(full / (acceleration * gait.step_s) - 1e-3).max(1.0) - 1.0) * gait.step_s
}

/// The quantities of walks.
fn walk_rows(walks: &Walks, real: &Scenario) -> Vec<Row> {
    let (motion, noise, gait) = (real.settings.motion, real.settings.odometry.noise, gait_of(&real.settings.motion));
    let slip = gait.slip;
    let forward = &walks.forward;
    // For a displacement L, one part of the variances grows with L, another with the square of L.
    let way = mean(forward, |walk| walk.ways[1]) as f32;
    let shares = values(forward, |walk| walk.ways[0] / walk.ways[1]);
    let drifts = values(forward, |walk| walk.turns[0] / walk.ways[1]);
    let counted = values(forward, |walk| walk.ways[2] / walk.ways[1]);
    let headings = values(forward, |walk| (walk.turns[2] - walk.turns[1]) / walk.ways[1].sqrt());
    let fast = Vec3::new(FASTEST, FASTEST, 0.0);
    let aslant_mps = motion.gait.map_or(motion.max_linear_mps, |gait| gait.reachable(fast, &motion).length());
    let of_gait = |path| if motion.gait.is_some() { path } else { "motion.max_linear_mps" };
    let speed = |name, walks: &[Walk], real: f32, path| {
        let measured = mean(walks, |walk| walk.speed_mps);
        row([name, "m/s", path], measured, slip.scale * real)
    };
    vec![
        speed("speed forward", forward, motion.max_linear_mps, "motion.max_linear_mps"),
        speed("speed backward", &walks.backward, gait.backward_mps, of_gait("motion.gait.backward_mps")),
        speed("speed sideways", &walks.sideways, gait.sideways_mps, of_gait("motion.gait.sideways_mps")),
        speed("speed at 45°", &walks.aslant, aslant_mps, of_gait("motion.gait.volume")),
        row(
            ["from standing to full speed", "s", "motion.gait.acceleration_mps2"],
            mean(forward, |walk| walk.started_s),
            start_s(real, motion.max_linear_mps, gait.acceleration_mps2),
        ),
        row(["way walked for a way of the legs", "", "motion.gait.slip.scale"], mean_of(&shares), slip.scale),
        row(
            ["spread of that over walks of a metre", "", "motion.gait.slip.scale_sd"],
            deviation_of(&shares),
            ops::hypot(slip.scale_sd, slip.error.translation_sd_m / ops::sqrt(way)),
        ),
        row(
            ["drift of the heading on a straight metre", "°", "motion.gait.slip.drift_sd_degpm"],
            deviation_of(&drifts),
            to_degrees(ops::hypot(slip.drift_sd, slip.error.heading_per_metre_sd / ops::sqrt(way))),
        ),
        row(
            ["odometry: way counted for a way of the legs", "", "odometry.noise.translation_scale"],
            mean_of(&counted),
            noise.translation_scale,
        ),
        row(
            ["odometry: spread after a metre", "m", "odometry.noise.translation_sd_m"],
            deviation_of(&counted) * f64::from(ops::sqrt(way)),
            noise.translation_sd_m,
        ),
        row(
            ["odometry: spread of the heading after a metre", "°", "odometry.noise.heading_per_metre_sd_deg"],
            deviation_of(&headings),
            to_degrees(noise.heading_per_metre_sd),
        ),
    ]
}

/// The quantities of turns on the spot.
fn turn_rows(turns: &[Walk], real: &Scenario) -> Vec<Row> {
    let (motion, noise, gait) = (real.settings.motion, real.settings.odometry.noise, gait_of(&real.settings.motion));
    // The variance grows with the angle, so an error divided by the root of the angle is that of a radian.
    let of_radian = |walk: &Walk, error: f64| error / walk.turns[1].abs().to_radians().sqrt();
    let turned = values(turns, |walk| of_radian(walk, walk.turns[0] - walk.turns[1]));
    let counted = values(turns, |walk| of_radian(walk, walk.turns[2] - walk.turns[1]));
    vec![
        row(
            ["turn", "°/s", "motion.max_angular_degps"],
            mean(turns, |walk| walk.turn_degps),
            to_degrees(motion.max_angular),
        ),
        row(
            ["from standing to the full turn", "s", "motion.gait.angular_acceleration_degps2"],
            mean(turns, |walk| walk.started_s),
            start_s(real, motion.max_angular, gait.angular_acceleration),
        ),
        row(
            ["spread of a turn by a radian", "°", "motion.gait.slip.error"],
            deviation_of(&turned),
            to_degrees(gait.slip.error.rotation_sd),
        ),
        row(
            ["odometry: spread after a turn of a radian", "°", "odometry.noise.rotation_sd_deg"],
            deviation_of(&counted),
            to_degrees(noise.rotation_sd),
        ),
    ]
}

/// Measures speeds, accelerations, slip, and the errors of odometry.
///
/// # Errors
/// When the model makes no valid scenario.
pub fn measure(model: &RobotModel, repetitions: u32) -> Result<Vec<MeasuredQuantity>, TrialError> {
    let mut laboratory = Laboratory::new(model);
    let run = Walks::run(&mut laboratory, repetitions)?;
    let real = laboratory.scenario(json!({}))?;
    let mut rows = Vec::new();
    if walks(&real) {
        rows.extend(walk_rows(&run, &real));
    }
    if turns(&real) {
        rows.extend(turn_rows(&run.turn, &real));
    }
    let quantity =
        |Row { name, unit, measured, real, path }| laboratory.quantity(name, unit, measured, real.into(), path);
    Ok(rows.into_iter().map(quantity).collect())
}
