//! Trials of the detection rates of goal posts, robots and marks.

use bevy::math::Vec2;
use serde_json::{Value, json};

use super::sensing::{has_cameras, sees_ahead};
use super::{Laboratory, MeasuredQuantity, TrialError};
use naoisis_core::geometry::angle_of;
use naoisis_sensing::sensing::vision::{ClassNoise, LandmarkKind, Percepts};
use naoisis_sim::scenario::RobotModel;
use naoisis_sim::simulation::MatchApp;

/// The distance of the object, m.
const AHEAD_M: f32 = 2.0;
/// The greatest bearing difference between the object and its detection, radians.
const SAME_BEARING: f32 = 0.25;

/// The share of `cycles` in which a robot at `pose`, in metres and degrees, detects one of `places` straight ahead.
fn share_of_cycles(
    laboratory: &mut Laboratory,
    pose: [f32; 3],
    opponents: Value,
    cycles: u32,
    places: impl Fn(&Percepts) -> Vec<Vec2>,
) -> Result<f64, TrialError> {
    let mut robots = vec![json!({ "team": "blue", "number": 1, "pose": pose })];
    robots.extend(opponents.as_array().cloned().unwrap_or_default());
    laboratory.begin(json!({ "ball": null, "robots": robots }))?;
    let is_seen = |laboratory: &mut Laboratory| {
        laboratory.app.run_cycles(1);
        places(&laboratory.reading::<Percepts>()).iter().any(|place| angle_of(*place).abs() < SAME_BEARING)
    };
    let seen = (0..cycles).filter(|_| is_seen(laboratory)).count();
    Ok(seen as f64 / f64::from(cycles.max(1)))
}

/// Measures the detection rates of a goal post, a robot, a crossing of lines and a penalty cross 2 m ahead.
///
/// # Errors
/// When the model makes no valid scenario.
pub fn measure(model: &RobotModel, repetitions: u32) -> Result<Vec<MeasuredQuantity>, TrialError> {
    /// Cycles per repetition.
    const CYCLES: u32 = 10;

    let mut laboratory = Laboratory::new(model);
    let real = laboratory.scenario(json!({}))?;
    if !has_cameras(&real) || !sees_ahead(&real) {
        return Ok(Vec::new());
    }
    let cycles = CYCLES * repetitions.max(2);
    let (pitch, noise) = (&real.field, real.settings.vision.noise);
    let (end_m, touch_m) = (pitch.half_length(), pitch.half_width());
    let before_post = [end_m - AHEAD_M, pitch.goal.width_m / 2.0, 0.0];
    let posts = share_of_cycles(&mut laboratory, before_post, json!([]), cycles, |percepts| {
        percepts.goal_posts.iter().map(|post| post.position_m).collect()
    })?;
    let opponent = json!([{ "team": "pink", "number": 1, "pose": [AHEAD_M, 0, 180] }]);
    let robots = share_of_cycles(&mut laboratory, [0.0; 3], opponent, cycles, |percepts| {
        percepts.robots.iter().map(|robot| robot.position_m).collect()
    })?;
    let mut landmarks = |pose: [f32; 3], is_it: fn(&LandmarkKind) -> bool| {
        share_of_cycles(&mut laboratory, pose, json!([]), cycles, |percepts| {
            let of_kind = percepts.landmarks.iter().filter(|landmark| is_it(&landmark.kind));
            of_kind.map(|landmark| landmark.position_m).collect()
        })
    };
    // Where the middle line meets the touchline.
    let junctions = landmarks([0.0, touch_m - AHEAD_M, 90.0], |kind| matches!(kind, LandmarkKind::Junction { .. }))?;
    let before_cross = [end_m - pitch.penalty_mark_distance_m - AHEAD_M, 0.0, 0.0];
    let crosses = landmarks(before_cross, |kind| *kind == LandmarkKind::PenaltyCross)?;

    let of_class = |class: &ClassNoise| {
        let is_near = class.max_distance_m.is_none_or(|most_m| AHEAD_M <= most_m);
        let share = class.falloff.map_or(1.0, |falloff| falloff.share_at(AHEAD_M));
        if is_near { f64::from((1.0 - class.miss_probability) * share) } else { 0.0 }
    };
    let quantities = [
        ("goalpost", posts, &noise.goal_posts, "vision.noise.goal_posts"),
        ("robot", robots, &noise.robots, "vision.noise.robots"),
        ("crossing of lines", junctions, &noise.junctions, "vision.noise.junctions"),
        ("penalty cross", crosses, &noise.penalty_crosses, "vision.noise.penalty_crosses"),
    ];
    let quantity = |(name, measured, class, path): (&str, f64, &ClassNoise, &str)| {
        laboratory.quantity(&format!("{name} in view recognised at 2 m"), "", measured, of_class(class), path)
    };
    Ok(quantities.into_iter().map(quantity).collect())
}
