//! Trials of sonars, vision and messages.

use bevy::math::{Vec2, Vec3, ops};
use serde_json::{Value, json};

use super::{Laboratory, MeasuredQuantity, TrialError, deviation_of, mean_of};
use naoisis_core::camera_model::{CameraIntrinsics, CameraMount};
use naoisis_core::communication::MessageStatistics;
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::{to_degrees, to_radians, unit};
use naoisis_core::robot::head::{HeadAngles, HeadLimits};
use naoisis_core::team::Team;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::ball_in_view::sees_ball;
use naoisis_sensing::sensing::sonar::{SonarNoise, SonarReading};
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::scenario::{RobotModel, Scenario};
use naoisis_sim::simulation::MatchApp;

/// Cycles of a trial per repetition.
const CYCLES: u32 = 10;

/// The radius of the pole that the sonars detect, m.
const POLE_RADIUS_M: f32 = 0.02;

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

/// The duration of cycles that have one ping each, s.
const PING_S: f64 = 0.1;

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
            // One that is taken for the ball elsewhere is none of it.
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
    let half_height = |mount: &CameraMount| {
        let CameraIntrinsics { size, focal_length, .. } = cameras.intrinsics(mount);
        ops::atan(0.5 * size.y / focal_length)
    };
    let is_gap = |pair: &[CameraMount]| {
        let [upper, lower] = pair else { return false };
        lower.tilt() - upper.tilt() > half_height(upper) + half_height(lower)
    };
    cameras.mounts.as_slice().windows(2).any(is_gap)
}

/// The distance at which a robot's feet are in the gap between the two images of a level head, m; the lowest visible
/// part of its legs is then at 15 of 30 cm.
const FEET_HIDDEN_M: f32 = 1.3;

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

/// Measures ranges, errors and misses of the sonars.
fn measure_sonars(model: &RobotModel, real: &Scenario, cycles: u32) -> Result<Vec<MeasuredQuantity>, TrialError> {
    let (min_m, max_m) = (real.settings.sonar.min_m, real.settings.sonar.max_m);
    // Well within the range of most sonars.
    let sonar_m = if (min_m + 0.1..max_m).contains(&0.5) { 0.5 } else { (min_m + max_m) / 2.0 };
    let mut laboratory = Laboratory::new(model);
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
    // As soon as its edge is in the cone, a pole is heard.
    let edge_deg = to_degrees(ops::asin(POLE_RADIUS_M / (sonar_m + POLE_RADIUS_M)));
    let false_echoes = crosstalk(&mut laboratory, real.settings.sonar.max_m, cycles)?;
    let share = |part: usize, whole: usize| part as f64 / (whole as f64).max(1.0);
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

/// Measures ranges, errors and misses of the sensors, and the loss of messages.
///
/// # Errors
/// When the model makes no valid scenario.
pub fn measure(model: &RobotModel, repetitions: u32) -> Result<Vec<MeasuredQuantity>, TrialError> {
    /// Cycles per repetition in which about a hundred false balls appear.
    const FALSE_BALL_CYCLES: u32 = 80;

    let mut laboratory = Laboratory::new(model);
    let real = laboratory.scenario(json!({}))?;
    let cycles = CYCLES * repetitions.max(2);
    let noise = real.settings.vision.noise;
    let near = look(&mut laboratory, BALL_M, cycles)?;
    let half_distance_m = noise.ball.falloff.map_or(BALL_M, |falloff| falloff.half_distance_m).min(FARTHEST_BALL_M);
    let far = look(&mut laboratory, half_distance_m, cycles)?;
    let radius_m = real.ball.map_or(0.0, |ball| ball.radius_m);
    let standing = angle_errors(&mut laboratory, radius_m, json!("idle"), 1.6, repetitions)?;
    let walk = json!({ "script": [{ "from_s": 0.2, "until_s": 100, "walk": [0.005, 0, 0] }] });
    let walking = angle_errors(&mut laboratory, radius_m, walk, 1.8, repetitions)?;
    let lives = false_balls(&mut laboratory, noise.false_balls.life_s, FALSE_BALL_CYCLES * repetitions)?;
    let feet = without_feet(&mut laboratory, cycles)?;
    let say = json!({ "script": [{ "from_s": 0, "until_s": 1000, "say": { "intention": "talk" } }] });
    laboratory.begin(json!({
        "ball": null, "messages": { "max_messages": null },
        "robots": [{ "team": "blue", "number": 1, "behaviour": say }, { "team": "blue", "number": 2, "pose": [1, 1, 0] }],
    }))?;
    laboratory.app.run_cycles(cycles as usize);
    let age_s =
        laboratory.app.world().resource::<CycleClock>().start_time_s() - laboratory.reading::<Percepts>().time_s;
    let messages = laboratory.app.world().resource::<MessageStatistics>()[Team::Blue];

    let share = |part: usize, whole: usize| part as f64 / (whole as f64).max(1.0);
    let quantity = |name, unit, measured, real: f32, path| laboratory.quantity(name, unit, measured, real.into(), path);
    // The errors of the gaze and that of the pixel add up.
    let focal_length_px = CameraIntrinsics::from(&real.settings.cameras).focal_length;
    let pixel_angle = noise.ball.pixel_sd / focal_length_px;
    let angle_sd = |moving_sd: f32| {
        let constant = ops::hypot(noise.gaze.bias_sd, ops::hypot(noise.head_angle_sd, pixel_angle));
        to_degrees(ops::hypot(constant, moving_sd))
    };
    let spread = |errors: &[[[f64; 2]; 2]], when: usize| {
        let errors: Vec<f64> = errors.iter().flat_map(|match_errors| match_errors[when]).collect();
        deviation_of(&errors)
    };
    // What two looks in a match have in common, seconds apart, is what never changes in it.
    let common: Vec<f64> = standing.iter().flat_map(|[first, then]| [first[0] * then[0], first[1] * then[1]]).collect();
    let recognised_at = |distance_m: f32| {
        let falloff = noise.ball.falloff;
        let share = falloff.map_or(1.0, |falloff| falloff.share_at(distance_m));
        (1.0 - noise.ball.miss_probability) * share
    };
    let seen = |looks: &[Option<Vec2>]| share(looks.iter().flatten().count(), looks.len());
    let quantities = vec![
        quantity("from an image to what is seen in it", "s", age_s, real.settings.latency.vision_s, "latency.vision_s"),
        quantity("ball in view recognised at 2 m", "", seen(&near), recognised_at(BALL_M), "vision.noise.ball"),
        quantity(
            "ball recognised where it is half as often",
            "",
            seen(&far),
            recognised_at(half_distance_m),
            "vision.noise.ball",
        ),
        quantity(
            "angles to a ball, standing: spread",
            "°",
            spread(&standing, 0),
            angle_sd(noise.gaze.standing_sd),
            "vision.noise.gaze.standing_sd_deg",
        ),
        quantity(
            "angles to a ball, walking: spread",
            "°",
            spread(&walking, 1),
            angle_sd(noise.gaze.walking_sd),
            "vision.noise.gaze.walking_sd_deg",
        ),
        quantity(
            "angles to a ball: bias of a match",
            "°",
            mean_of(&common).max(0.0).sqrt(),
            to_degrees(noise.gaze.bias_sd),
            "vision.noise.gaze.bias_sd_deg",
        ),
        quantity("a false ball stands for", "s", mean_of(&lives), noise.false_balls.life_s, "vision.noise.false_balls")
            .if_seen(lives.len() as f64, "there was none in so few repetitions"),
        quantity(
            "robot without feet seems further away by",
            "",
            feet,
            noise.hidden_feet.bias / 2.0,
            "vision.noise.hidden_feet",
        ),
        quantity(
            "messages lost",
            "",
            share(messages.lost as usize, (messages.lost + messages.delivered) as usize),
            real.messages.loss,
            "messages.loss",
        )
        .if_seen(messages.lost as f64, "none was lost in so few repetitions"),
    ];
    let [has_gap, has_cameras, sees_ahead] = [has_gap(&real.settings.cameras), has_cameras(&real), sees_ahead(&real)];
    let has = |quantity: &MeasuredQuantity| match quantity.name.as_str() {
        "messages lost" => true,
        "from an image to what is seen in it" => has_cameras,
        name => sees_ahead && (has_gap || !name.starts_with("robot without feet")),
    };
    let sonars = if real.settings.sonar.fitted { measure_sonars(model, &real, cycles)? } else { Vec::new() };
    Ok(sonars.into_iter().chain(quantities.into_iter().filter(has)).collect())
}
