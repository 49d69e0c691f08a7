//! Trials of vision and messages.

use bevy::math::{Vec2, Vec3, ops};
use serde_json::{Value, json};

use super::{Laboratory, MeasuredQuantity, TrialError, cycles_of, deviation_of, mean_of, share};
use naoisis_core::camera_model::{CameraIntrinsics, CameraMount};
use naoisis_core::communication::MessageStatistics;
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::to_degrees;
use naoisis_core::robot::head::{HeadAngles, HeadLimits};
use naoisis_core::team::Team;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::ball_in_view::sees_ball;
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::scenario::{RobotModel, Scenario};
use naoisis_sim::simulation::MatchApp;

/// The x coordinate of a robot that looks along the pitch, m: at one end of it.
const LOOKS_FROM_M: f32 = -4.4;

/// The detected positions of a ball straight ahead, in each of `cycles` cycles.
fn look(laboratory: &mut Laboratory, distance_m: f32, cycles: u32) -> Result<Vec<Option<Vec2>>, TrialError> {
    laboratory.begin(json!({
        "ball": { "position_m": [LOOKS_FROM_M + distance_m, 0] },
        "robots": [{ "team": "blue", "number": 1, "pose": [LOOKS_FROM_M, 0, 0] }],
    }))?;
    Ok((0..cycles)
        .map(|_| {
            laboratory.app.run_cycles(1);
            // A false ball elsewhere does not count.
            let seen = laboratory.reading::<Percepts>().ball.map(|ball| ball.position_m);
            seen.filter(|place| ops::atan2(place.y, place.x).abs() < 0.2)
        })
        .collect())
}

/// The angles to a ball on the ground from a camera with this lens: to the left, and down; degrees.
fn angles_to(lens: Vec3, place: Vec2, radius_m: f32) -> [f64; 2] {
    let from_lens = place - lens.truncate();
    [ops::atan2(place.y, place.x), ops::atan2(lens.z - radius_m, from_lens.length())].map(to_degrees).map(f64::from)
}

/// The errors of the angles to a ball ahead at its next detection, degrees, in each of several matches: at the start,
/// when the robot stands, and after a time in which it executes a command.
fn angle_errors(
    laboratory: &mut Laboratory,
    radius_m: f32,
    behaviour: Value,
    later_s: f64,
    matches: u32,
) -> Result<Vec<[[f64; 2]; 2]>, TrialError> {
    /// The number of cycles within which a ball in view is detected at least once.
    const PATIENCE: usize = 100;

    let mut errors = Vec::new();
    for seed in 1..=matches {
        laboratory.begin(json!({
            "seed": seed, "ball": { "position_m": [LOOKS_FROM_M + FARTHER_BALL_M, 0] },
            "robots": [{ "team": "blue", "number": 1, "pose": [LOOKS_FROM_M, 0, 0], "behaviour": behaviour }],
        }))?;
        let ball = laboratory.app.ball().unwrap_or_default().position;
        let error_when_seen = |laboratory: &mut Laboratory| {
            (0..PATIENCE).find_map(|_| {
                let pose = laboratory.pose();
                laboratory.app.run_cycles(1);
                let seen = laboratory.reading::<Percepts>().ball?.position_m;
                let cameras = laboratory.reading::<CameraSettings>();
                let lens = cameras.mounts.as_slice().first()?.lens_m;
                let places = [seen, pose.inverse_transform_point(ball)];
                let [seen, real] = places.map(|place| angles_to(lens, place, radius_m));
                let error = [seen[0] - real[0], seen[1] - real[1]];
                error.iter().all(|error| error.abs() < 12.0).then_some(error)
            })
        };
        let first = error_when_seen(laboratory);
        let cycles = laboratory.cycles(later_s);
        laboratory.app.run_cycles(cycles);
        errors.extend(first.zip(error_when_seen(laboratory)).map(|(first, then)| [first, then]));
    }
    Ok(errors)
}

/// The mean lifetime of false balls, s: of those that a robot on an empty pitch without other errors sees in `cycles`
/// cycles.
fn false_balls(laboratory: &mut Laboratory, life_s: f32, cycles: u32) -> Result<Vec<f64>, TrialError> {
    const CYCLE_S: f64 = 0.1;
    /// A higher rate of false balls than usual, because their number is not measured here.
    const PER_MINUTE: f32 = 20.0;
    /// Detections that are farther apart are different places, m.
    const SAME_PLACE_M: f32 = 0.1;

    let often = json!({ "per_minute": PER_MINUTE, "life_s": life_s });
    laboratory.begin(json!({
        "ball": null, "cycle_s": CYCLE_S, "vision": { "noise": { "preset": "none", "false_balls": often } },
        "robots": [{ "team": "blue", "number": 1, "pose": [LOOKS_FROM_M, 0, 0] }],
    }))?;
    let mut lives = Vec::new();
    let mut current: Option<(Vec2, f64)> = None;
    for _ in 0..cycles {
        laboratory.app.run_cycles(1);
        let seen = laboratory.reading::<Percepts>().ball.map(|ball| ball.position_m);
        match (&mut current, seen) {
            (Some((place, life_s)), Some(seen)) if place.distance(seen) < SAME_PLACE_M => *life_s += CYCLE_S,
            (_, seen) => {
                lives.extend(current.map(|(_, life_s)| life_s));
                current = seen.map(|place| (place, CYCLE_S));
            }
        }
    }
    Ok(lives)
}

/// The relative error of the distance to a robot whose feet are in the gap between two images.
fn without_feet(laboratory: &mut Laboratory, cycles: u32) -> Result<f64, TrialError> {
    let still = json!({ "bias_sd_deg": 0, "standing_sd_deg": 0 });
    laboratory.begin(json!({
        "ball": null, "vision": { "noise": { "gaze": still } },
        "robots": [
            { "team": "blue", "number": 1, "pose": [LOOKS_FROM_M, 0, 0] },
            { "team": "pink", "number": 1, "pose": [LOOKS_FROM_M + FEET_HIDDEN_M, 0, 180] },
        ],
    }))?;
    let mut errors = Vec::new();
    for _ in 0..cycles {
        laboratory.app.run_cycles(1);
        let robots = laboratory.reading::<Percepts>().robots;
        let seen = robots.iter().map(|robot| robot.position_m).find(|place| place.y.abs() < 0.3 && place.x < 2.0);
        errors.extend(seen.map(|place| f64::from(place.x / FEET_HIDDEN_M) - 1.0));
    }
    Ok(mean_of(&errors))
}

/// Whether there is a gap between the images of two cameras, one below the other, in which feet can be hidden. The
/// images of a NAO V6 overlap.
fn has_gap(cameras: &CameraSettings) -> bool {
    let half_height = |mount: &CameraMount| ops::atan(cameras.intrinsics(mount).half_slopes().y);
    let is_gap = |pair: &[CameraMount]| {
        let [upper, lower] = pair else { return false };
        lower.tilt() - upper.tilt() > half_height(upper) + half_height(lower)
    };
    cameras.mounts.as_slice().windows(2).any(is_gap)
}

/// The distance at which a robot's feet are in the gap between the two images of a level head, m; the lowest visible
/// part of its legs is then at 15 of 30 cm.
const FEET_HIDDEN_M: f32 = 1.3;

/// A distance at which the ball is in view of a camera that looks straight ahead, m.
const BALL_M: f32 = 2.0;
/// A larger distance, so that a robot that walks towards the ball has it in view for a while, m.
const FARTHER_BALL_M: f32 = 2.2;
/// The greatest distance at which a ball is looked for, m; the pitch is no longer.
const FARTHEST_BALL_M: f32 = 9.0;

/// Whether the robots of a scenario have cameras.
pub(super) fn has_cameras(scenario: &Scenario) -> bool {
    !scenario.settings.cameras.mounts.as_slice().is_empty()
}

/// Whether the cameras can see the balls of these trials with the head straight ahead.
pub(super) fn sees_ahead(scenario: &Scenario) -> bool {
    sees_at(scenario, &[BALL_M, FARTHER_BALL_M])
}

/// Whether the cameras can see balls straight ahead at these distances, m, with the head straight ahead.
pub(super) fn sees_at(scenario: &Scenario, distances_m: &[f32]) -> bool {
    let limits = &scenario.settings.head;
    let at_rest = if limits.moves() { limits.nearest(HeadAngles::default()) } else { HeadAngles::default() };
    let head = HeadLimits { max_speed: 0.0, ..*limits }.reached_from(at_rest);
    let radius_m = scenario.ball.map_or(0.0, |ball| ball.radius_m);
    let sees = |place| sees_ball(&scenario.settings.cameras, &scenario.settings.body, &head, place, radius_m);
    distances_m.iter().all(|distance_m| sees(Vec2::X * *distance_m))
}

/// Measures ranges, errors and misses of vision, and the loss of messages.
///
/// # Errors
/// When the model makes no valid scenario.
pub fn measure(model: &RobotModel, repetitions: u32) -> Result<Vec<MeasuredQuantity>, TrialError> {
    let mut laboratory = Laboratory::new(model);
    let real = laboratory.scenario(json!({}))?;
    let mut quantities = Vec::new();
    if has_cameras(&real) {
        quantities.push(measure_age(&mut laboratory, &real)?);
    }
    if sees_ahead(&real) {
        quantities.extend(measure_recognition(&mut laboratory, &real, repetitions)?);
        quantities.extend(measure_angles(&mut laboratory, &real, repetitions)?);
        quantities.extend(measure_mistakes(&mut laboratory, &real, repetitions)?);
    }
    quantities.push(measure_messages(&mut laboratory, &real, repetitions)?);
    Ok(quantities)
}

/// Measures the time from an image to the percepts of it.
fn measure_age(laboratory: &mut Laboratory, real: &Scenario) -> Result<MeasuredQuantity, TrialError> {
    laboratory.begin(json!({ "ball": null, "robots": [{ "team": "blue", "number": 1 }] }))?;
    laboratory.app.run_cycles(laboratory.cycles(1.0));
    let now_s = laboratory.app.world().resource::<CycleClock>().start_time_s();
    let age_s = now_s - laboratory.reading::<Percepts>().time_s;
    let latency_s = real.settings.latency.vision_s.into();
    Ok(laboratory.quantity("from an image to what is seen in it", "s", age_s, latency_s, "latency.vision_s"))
}

/// Measures the share of images with a ball in view in which it is recognised.
fn measure_recognition(
    laboratory: &mut Laboratory,
    real: &Scenario,
    repetitions: u32,
) -> Result<[MeasuredQuantity; 2], TrialError> {
    let ball = real.settings.vision.noise.ball;
    let half_distance_m = ball.falloff.map_or(BALL_M, |falloff| falloff.half_distance_m).min(FARTHEST_BALL_M);
    let mut measure = |name, distance_m| {
        let looks = look(laboratory, distance_m, cycles_of(repetitions))?;
        let seen = share(looks.iter().flatten().count(), looks.len());
        let falloff = ball.falloff.map_or(1.0, |falloff| falloff.share_at(distance_m));
        let expected = ((1.0 - ball.miss_probability) * falloff).into();
        Ok::<_, TrialError>(laboratory.quantity(name, "", seen, expected, "vision.noise.ball"))
    };
    Ok([
        measure("ball in view recognised at 2 m", BALL_M)?,
        measure("ball recognised where it is half as often", half_distance_m)?,
    ])
}

/// Measures the errors of the angles to a ball.
fn measure_angles(
    laboratory: &mut Laboratory,
    real: &Scenario,
    repetitions: u32,
) -> Result<[MeasuredQuantity; 3], TrialError> {
    let noise = real.settings.vision.noise;
    let radius_m = real.ball.map_or(0.0, |ball| ball.radius_m);
    let standing = angle_errors(laboratory, radius_m, json!("idle"), 1.6, repetitions)?;
    let walk = json!({ "script": [{ "from_s": 0.2, "until_s": 100, "walk": [0.005, 0, 0] }] });
    let walking = angle_errors(laboratory, radius_m, walk, 1.8, repetitions)?;
    // The errors of the gaze and that of the pixel add up.
    let focal_length_px = CameraIntrinsics::from(&real.settings.cameras).focal.x;
    let pixel_angle = noise.ball.pixel_sd / focal_length_px;
    let angle_sd = |moving_sd: f32| {
        let constant = ops::hypot(noise.gaze.bias_sd, ops::hypot(noise.head_angle_sd, pixel_angle));
        to_degrees(ops::hypot(constant, moving_sd))
    };
    let spread = |errors: &[[[f64; 2]; 2]], when: usize| {
        let errors: Vec<f64> = errors.iter().flat_map(|match_errors| match_errors[when]).collect();
        deviation_of(&errors)
    };
    // The common part of two looks in a match, seconds apart, is the error that does not change in the match.
    let common: Vec<f64> = standing.iter().flat_map(|[first, then]| [first[0] * then[0], first[1] * then[1]]).collect();
    let bias = mean_of(&common).max(0.0).sqrt();
    let quantity = |name, measured, real: f32, path| laboratory.quantity(name, "°", measured, real.into(), path);
    Ok([
        quantity(
            "angles to a ball, standing: spread",
            spread(&standing, 0),
            angle_sd(noise.gaze.standing_sd),
            "vision.noise.gaze.standing_sd_deg",
        ),
        quantity(
            "angles to a ball, walking: spread",
            spread(&walking, 1),
            angle_sd(noise.gaze.walking_sd),
            "vision.noise.gaze.walking_sd_deg",
        ),
        quantity(
            "angles to a ball: bias of a match",
            bias,
            to_degrees(noise.gaze.bias_sd),
            "vision.noise.gaze.bias_sd_deg",
        ),
    ])
}

/// Measures the lifetime of false balls, and the error of the distance to a robot without visible feet.
fn measure_mistakes(
    laboratory: &mut Laboratory,
    real: &Scenario,
    repetitions: u32,
) -> Result<Vec<MeasuredQuantity>, TrialError> {
    /// Cycles per repetition in which about a hundred false balls appear.
    const FALSE_BALL_CYCLES: u32 = 80;

    let noise = real.settings.vision.noise;
    let life_s = noise.false_balls.life_s;
    let lives = false_balls(laboratory, life_s, FALSE_BALL_CYCLES * repetitions)?;
    let path = "vision.noise.false_balls";
    let false_ball = laboratory.quantity("a false ball stands for", "s", mean_of(&lives), life_s.into(), path);
    let mut quantities = vec![false_ball.if_seen(lives.len() as f64, "there was none in so few repetitions")];
    if has_gap(&real.settings.cameras) {
        let feet = without_feet(laboratory, cycles_of(repetitions))?;
        let bias = (noise.hidden_feet.bias / 2.0).into();
        let name = "robot without feet seems further away by";
        quantities.push(laboratory.quantity(name, "", feet, bias, "vision.noise.hidden_feet"));
    }
    Ok(quantities)
}

/// Measures the share of messages that are lost.
fn measure_messages(
    laboratory: &mut Laboratory,
    real: &Scenario,
    repetitions: u32,
) -> Result<MeasuredQuantity, TrialError> {
    let say = json!({ "script": [{ "from_s": 0, "until_s": 1000, "say": { "intention": "talk" } }] });
    laboratory.begin(json!({
        "ball": null, "messages": { "max_messages": null },
        "robots": [{ "team": "blue", "number": 1, "behaviour": say }, { "team": "blue", "number": 2, "pose": [1, 1, 0] }],
    }))?;
    laboratory.app.run_cycles(cycles_of(repetitions) as usize);
    let messages = laboratory.app.world().resource::<MessageStatistics>()[Team::Blue];
    let lost = share(messages.lost as usize, (messages.lost + messages.delivered) as usize);
    let quantity = laboratory.quantity("messages lost", "", lost, real.messages.loss.into(), "messages.loss");
    Ok(quantity.if_seen(messages.lost as f64, "none was lost in so few repetitions"))
}
