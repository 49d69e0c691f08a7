//! Trials of sonars.

use bevy::math::ops;
use serde_json::json;

use super::{Laboratory, MeasuredQuantity, TrialError, deviation_of, mean_of, share};
use naoisis_core::geometry::{to_degrees, to_radians, unit};
use naoisis_sensing::sensing::sonar::{SonarNoise, SonarReading};
use naoisis_sim::scenario::RobotModel;
use naoisis_sim::simulation::MatchApp;

/// The radius of the pole that the sonars detect, m.
const POLE_RADIUS_M: f32 = 0.02;

/// The duration of cycles that have one ping each, s.
const PING_S: f64 = 0.1;

/// The readings of the left sonar of a pole at this distance and bearing, one per cycle.
fn sonar(
    laboratory: &mut Laboratory,
    [distance_m, bearing]: [f32; 2],
    cycle_s: f64,
    cycles: u32,
) -> Result<Vec<Option<f32>>, TrialError> {
    let place = unit(bearing) * (distance_m + POLE_RADIUS_M);
    laboratory.begin(json!({
        "ball": null, "cycle_s": cycle_s, "robots": [{ "team": "blue", "number": 1 }],
        "posts": [{ "position_m": [place.x, place.y], "radius_m": POLE_RADIUS_M }],
    }))?;
    Ok((0..cycles)
        .map(|_| {
            laboratory.app.run_cycles(1);
            laboratory.reading::<SonarReading>().left
        })
        .collect())
}

/// The number of sonar readings, and the share of them with an echo that is only the ping of another robot, which faces
/// this one from out of range.
fn crosstalk(laboratory: &mut Laboratory, range_m: f32, cycles: u32) -> Result<f64, TrialError> {
    laboratory.begin(json!({
        "ball": null, "cycle_s": PING_S,
        "robots": [
            { "team": "blue", "number": 1 },
            { "team": "pink", "number": 1, "pose": [1.5 * range_m, 0, 180] },
        ],
    }))?;
    let heard = (0..cycles).map(|_| {
        laboratory.app.run_cycles(1);
        let reading = laboratory.reading::<SonarReading>();
        u32::from(reading.left.is_some()) + u32::from(reading.right.is_some())
    });
    Ok(f64::from(heard.sum::<u32>()) / f64::from(2 * cycles))
}

/// The last distance, in steps, at which anything is detected.
fn farthest<E>(
    from_m: f32,
    to_m: f32,
    step_m: f32,
    mut is_there: impl FnMut(f32) -> Result<bool, E>,
) -> Result<f64, E> {
    let mut farthest_m = 0.0;
    for step in 0..=((to_m - from_m) / step_m) as u32 {
        let distance_m = from_m + step as f32 * step_m;
        if is_there(distance_m)? {
            farthest_m = distance_m;
        }
    }
    Ok(f64::from(farthest_m))
}

/// Measures ranges, errors and misses of the sonars; nothing if the robot has none.
///
/// # Errors
/// When the model makes no valid scenario.
pub fn measure(model: &RobotModel, repetitions: u32) -> Result<Vec<MeasuredQuantity>, TrialError> {
    let mut laboratory = Laboratory::new(model);
    let real = laboratory.scenario(json!({}))?;
    if !real.settings.sonar.fitted {
        return Ok(Vec::new());
    }
    let cycles = super::cycles_of(repetitions);
    let (min_m, max_m) = (real.settings.sonar.min_m, real.settings.sonar.max_m);
    // Well within the range of most sonars.
    let sonar_m = if (min_m + 0.1..max_m).contains(&0.5) { 0.5 } else { (min_m + max_m) / 2.0 };
    // A pole stands clear of the body.
    let nearest_m = (real.settings.body.torso.x_m[1] + 0.05).max(0.1);
    let heading = real.settings.sonar.heading;
    let echoes = sonar(&mut laboratory, [sonar_m, heading], PING_S, cycles)?;
    let often = sonar(&mut laboratory, [sonar_m, heading], real.cycle_s, cycles)?;
    // A reading that differs is a new one.
    let pings = often.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let pings_hz = pings as f64 / (f64::from(cycles) * real.cycle_s);
    let heard: Vec<f64> = echoes.iter().flatten().map(|&distance| f64::from(distance)).collect();
    let range_m = farthest(nearest_m, (max_m + 0.5).max(3.0), 0.025, |distance| {
        Ok::<_, TrialError>(sonar(&mut laboratory, [distance, heading], PING_S, 4)?.iter().any(Option::is_some))
    })?;
    let widest_deg = farthest(0.0, 90.0, 1.0, |beside_deg| {
        let bearing = heading + to_radians(beside_deg);
        Ok::<_, TrialError>(sonar(&mut laboratory, [sonar_m, bearing], PING_S, 4)?.iter().any(Option::is_some))
    })?;
    // A pole is detected as soon as its edge is in the cone.
    let edge_deg = to_degrees(ops::asin(POLE_RADIUS_M / (sonar_m + POLE_RADIUS_M)));
    let false_echoes = crosstalk(&mut laboratory, real.settings.sonar.max_m, cycles)?;
    let quantity = |name, unit, measured, real: f32, path| laboratory.quantity(name, unit, measured, real.into(), path);
    let sonar_sd_m = match real.settings.sonar.noise {
        SonarNoise::Gaussian { sd_m } | SonarNoise::Outliers { sd_m, .. } => sd_m,
        SonarNoise::Uniform { half_width_m } => half_width_m / 3.0_f32.sqrt(),
        SonarNoise::None => 0.0,
    };
    Ok(vec![
        quantity("sonar: farthest echo", "m", range_m, real.settings.sonar.max_m, "sonar.max_m"),
        quantity("sonar: spread", "m", deviation_of(&heard), sonar_sd_m, "sonar.noise"),
        quantity("sonar: distance heard of the true one", "", mean_of(&heard) / f64::from(sonar_m), 1.0, "sonar.noise"),
        quantity(
            "sonar: echoes missed",
            "",
            share(echoes.len() - heard.len(), echoes.len()),
            real.settings.sonar.miss_probability,
            "sonar.miss_probability",
        )
        .if_seen((echoes.len() - heard.len()) as f64, "none was missed in so few repetitions"),
        quantity(
            "sonar: half of its cone",
            "°",
            widest_deg - f64::from(edge_deg),
            to_degrees(real.settings.sonar.half_angle),
            "sonar.half_angle_deg",
        ),
        quantity(
            "sonar: readings",
            "Hz",
            pings_hz,
            real.settings.sonar.rate_hz.unwrap_or(real.cycle_s.recip() as f32),
            "sonar.rate_hz",
        ),
        quantity(
            "sonar: false echoes of a robot that faces it",
            "",
            false_echoes,
            real.settings.sonar.crosstalk_probability,
            "sonar.crosstalk_probability",
        )
        .if_seen(false_echoes, "there was none in so few repetitions"),
    ])
}
