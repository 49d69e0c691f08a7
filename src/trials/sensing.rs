//! Trials of sonars, vision and messages.

use bevy::math::ops;
use serde_json::json;

use super::{Laboratory, Quantity, TrialError, deviation_of, mean_of};
use crate::camera_model::CameraIntrinsics;
use crate::communication::MessageStatistics;
use crate::geometry::{to_degrees, unit};
use crate::scenario::RobotModel;
use crate::sensing::sonar::{SonarNoise, SonarReading};
use crate::sensing::vision::Percepts;
use crate::simulation::MatchApp;
use crate::team::Team;

/// Cycles of a trial, for each repetition.
const CYCLES: u32 = 10;

/// What the left sonar hears of a post along its axis, in each of so many cycles.
fn sonar(
    laboratory: &mut Laboratory,
    distance_m: f32,
    heading: f32,
    cycles: u32,
) -> Result<Vec<Option<f32>>, TrialError> {
    const RADIUS_M: f32 = 0.05;
    let place = unit(heading) * (distance_m + RADIUS_M);
    laboratory.begin(json!({
        "ball": null, "robots": [{ "team": "blue", "number": 1 }],
        "posts": [{ "position_m": [place.x, place.y], "radius_m": RADIUS_M }],
    }))?;
    Ok((0..cycles)
        .map(|_| {
            laboratory.app.run_cycles(1);
            laboratory.reading::<SonarReading>().left
        })
        .collect())
}

/// Where the ball seems to be that lies straight ahead, in each of so many cycles.
fn look(
    laboratory: &mut Laboratory,
    distance_m: f32,
    cycles: u32,
) -> Result<Vec<Option<bevy::math::Vec2>>, TrialError> {
    /// At one end of the pitch.
    const AT_M: f32 = -4.4;
    laboratory.begin(json!({
        "ball": { "position_m": [AT_M + distance_m, 0] },
        "robots": [{ "team": "blue", "number": 1, "pose": [AT_M, 0, 0] }],
    }))?;
    Ok((0..cycles)
        .map(|_| {
            laboratory.app.run_cycles(1);
            // One that is taken for the ball elsewhere is none of it.
            let seen = laboratory.reading::<Percepts>().ball.map(|ball| ball.position_m);
            seen.filter(|place| ops::atan2(place.y, place.x).abs() < 0.2)
        })
        .collect())
}

/// The last of the distances, in steps, at which something is there at all.
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

/// Ranges, errors and misses of the sensors, and the messages that are lost.
///
/// # Errors
/// When the model makes no scenario.
pub fn measure(model: &RobotModel, repetitions: u32) -> Result<Vec<Quantity>, TrialError> {
    /// Well within the range of every sonar.
    const SONAR_M: f32 = 0.5;
    /// In view of a camera that looks straight ahead.
    const BALL_M: f32 = 2.5;

    let mut laboratory = Laboratory::new(model);
    let real = laboratory.scenario(json!({}))?;
    let cycles = CYCLES * repetitions.max(2);
    let heading = real.sonar.heading;
    let echoes = sonar(&mut laboratory, SONAR_M, heading, cycles)?;
    let heard: Vec<f64> = echoes.iter().flatten().map(|&distance| f64::from(distance)).collect();
    let range_m = farthest(0.1, 3.0, 0.025, |distance| {
        Ok::<_, TrialError>(sonar(&mut laboratory, distance, heading, 4)?.iter().any(Option::is_some))
    })?;
    let balls = look(&mut laboratory, BALL_M, cycles)?;
    let angles: Vec<f64> =
        balls.iter().flatten().map(|place| f64::from(to_degrees(ops::atan2(place.y, place.x)))).collect();
    let sight_m = farthest(2.0, 9.0, 0.25, |distance| {
        Ok::<_, TrialError>(look(&mut laboratory, distance, 8)?.iter().any(Option::is_some))
    })?;
    let say = json!({ "script": [{ "from_s": 0, "until_s": 1000, "say": { "intention": "talk" } }] });
    laboratory.begin(json!({
        "ball": null, "messages": { "max_messages": null },
        "robots": [{ "team": "blue", "number": 1, "behaviour": say }, { "team": "blue", "number": 2, "pose": [1, 1, 0] }],
    }))?;
    laboratory.app.run_cycles(cycles as usize);
    let messages = laboratory.app.world().resource::<MessageStatistics>()[Team::Blue];

    let share = |part: usize, whole: usize| part as f64 / (whole as f64).max(1.0);
    let quantity = |name, unit, measured, real: f32, path| laboratory.quantity(name, unit, measured, real.into(), path);
    let noise = real.vision.noise;
    let sonar_sd_m = match real.sonar.noise {
        SonarNoise::Gaussian { sd_m } | SonarNoise::Outliers { sd_m, .. } => sd_m,
        SonarNoise::Uniform { half_width_m } => half_width_m / 3.0_f32.sqrt(),
        SonarNoise::None => 0.0,
    };
    // The head's error and that of the pixel add up.
    let focal_length_px = CameraIntrinsics::from(&real.cameras).focal_length;
    let pixel_angle = to_degrees(noise.ball.pixel_sd / focal_length_px);
    let angle_sd = ops::hypot(to_degrees(noise.head_angle_sd), pixel_angle);
    Ok(vec![
        quantity("sonar: farthest echo", "m", range_m, real.sonar.max_m, "sonar.max_m"),
        quantity("sonar: spread", "m", deviation_of(&heard), sonar_sd_m, "sonar.noise"),
        quantity("sonar: bias", "", mean_of(&heard) / f64::from(SONAR_M), 1.0, "sonar.noise"),
        quantity(
            "sonar: echoes missed",
            "",
            share(echoes.len() - heard.len(), echoes.len()),
            real.sonar.miss_probability,
            "sonar.miss_probability",
        ),
        quantity(
            "ball in view recognised at 2.5 m",
            "",
            share(angles.len(), balls.len()),
            1.0 - noise.ball.miss_probability,
            "vision.noise.ball",
        ),
        quantity(
            "ball recognised up to",
            "m",
            sight_m,
            noise.ball.max_distance_m.unwrap_or(f32::INFINITY),
            "vision.noise.ball",
        ),
        quantity(
            "spread of the angle to a ball",
            "°",
            deviation_of(&angles),
            angle_sd,
            "vision.noise.head_angle_sd_deg",
        ),
        quantity(
            "messages lost",
            "",
            share(messages.lost as usize, (messages.lost + messages.delivered) as usize),
            real.messages.loss,
            "messages.loss",
        ),
    ])
}
