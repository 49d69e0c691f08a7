//! Trials of walking and of what robots know of it.

use serde_json::{Value, json};

use super::{Laboratory, Quantity, TrialError, deviation_of, mean_of};
use crate::geometry::{to_degrees, wrap_angle};
use crate::scenario::RobotModel;
use crate::sensing::odometry::Odometry;
use crate::simulation::MatchApp;

/// A robot that is told to make such steps as long as a trial lasts.
fn walker(step: [f32; 3], seed: u32) -> Value {
    let script = json!({ "script": [{ "from_s": 0, "until_s": 1000, "walk": step }] });
    json!({ "seed": seed, "ball": null, "robots": [{ "team": "blue", "number": 1, "pose": [-4, 0, 0], "behaviour": script }] })
}

/// Speeds, and the errors of odometry.
///
/// # Errors
/// When the model makes no scenario.
pub fn measure(model: &RobotModel, repetitions: u32) -> Result<Vec<Quantity>, TrialError> {
    /// Farther and faster than any robot can within a cycle.
    const FASTEST: f32 = 1.0;
    const TIME_S: f64 = 5.0;

    let mut laboratory = Laboratory::new(model);
    let mut speeds = Vec::new();
    let [mut scales, mut headings] = [Vec::new(), Vec::new()];
    for seed in 1..=repetitions.max(2) {
        laboratory.begin(walker([FASTEST, 0.0, 0.0], seed))?;
        let start = laboratory.pose();
        let cycles = laboratory.cycles(TIME_S);
        laboratory.app.run_cycles(cycles);
        let way = f64::from(laboratory.pose().position.distance(start.position));
        let Odometry(counted) = laboratory.reading();
        speeds.push(way / (cycles as f64 * laboratory.period_s()));
        scales.push(f64::from(counted.position.x) / way);
        headings.push(f64::from(to_degrees(counted.heading)) / way.sqrt());
    }
    let mut turning_speeds = Vec::new();
    let mut turns = Vec::new();
    for seed in 1..=repetitions.max(2) {
        // Far more than any robot turns, in degrees.
        laboratory.begin(walker([0.0, 0.0, 100.0], seed))?;
        let (mut turned, mut counted) = (0.0, 0.0);
        let cycles = laboratory.cycles(1.0);
        for _ in 0..cycles {
            let before = (laboratory.pose().heading, laboratory.reading::<Odometry>().0.heading);
            laboratory.app.run_cycles(1);
            turned += f64::from(wrap_angle(laboratory.pose().heading - before.0));
            counted += f64::from(wrap_angle(laboratory.reading::<Odometry>().0.heading - before.1));
        }
        turning_speeds.push(turned.to_degrees() / (cycles as f64 * laboratory.period_s()));
        // The variance grows with the angle, so that what is divided by its root is that of a radian.
        turns.push((counted - turned).to_degrees() / turned.sqrt());
    }
    let real = laboratory.scenario(json!({}))?;
    let (motion, noise) = (real.motion, real.odometry.noise);
    // Of a straight way, the length is known to `translation_sd_m` times the root of it.
    let way = mean_of(&speeds) * TIME_S;
    let quantity = |name, unit, measured, real: f32, path| laboratory.quantity(name, unit, measured, real.into(), path);
    Ok(vec![
        quantity("speed forward", "m/s", mean_of(&speeds), motion.max_linear_mps, "motion.max_linear_mps"),
        quantity("turn", "°/s", mean_of(&turning_speeds), to_degrees(motion.max_angular), "motion.max_angular_degps"),
        quantity(
            "odometry: way counted for a way walked",
            "",
            mean_of(&scales),
            noise.translation_scale,
            "odometry.noise.translation_scale",
        ),
        quantity(
            "odometry: spread after a metre",
            "m",
            deviation_of(&scales) * way.sqrt(),
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
            deviation_of(&turns),
            to_degrees(noise.rotation_sd),
            "odometry.noise.rotation_sd_deg",
        ),
    ])
}
