//! Trials of heads and cameras: range and speed of the head, and the field of view.

use bevy::math::ops;
use serde_json::json;

use super::{Laboratory, MeasuredQuantity, TrialError};
use naoisis_core::geometry::{to_degrees, to_radians, unit};
use naoisis_core::robot::head::HeadAngles;
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::scenario::{RobotModel, Scenario};
use naoisis_sim::simulation::MatchApp;

/// Longer than a head takes from one end to the other, s.
const TURNS_S: f64 = 3.0;
/// The x coordinate of the robot, m: at one end of the pitch.
const LOOKS_FROM_M: f32 = -4.4;
/// The distance of the ball, m: so large that it is near the horizon, at half the height of the image.
const BALL_M: f32 = 7.0;

/// Measures range and speed of the head, and the field of view of the first camera.
///
/// # Errors
/// When the model makes no valid scenario.
pub fn measure(model: &RobotModel) -> Result<Vec<MeasuredQuantity>, TrialError> {
    let mut laboratory = Laboratory::new(model);
    let real = laboratory.scenario(json!({}))?;
    let mut quantities = Vec::new();
    if real.settings.head.moves() {
        let ([right, left], [up, down]) =
            (real.settings.head.yaw.map(to_degrees), real.settings.head.pitch.map(to_degrees));
        let turns = [
            ("head: to the left", [right, 0.0], [left, 0.0]),
            ("head: to the right", [left, 0.0], [right, 0.0]),
            ("head: down", [0.0, up], [0.0, down]),
            ("head: up", [0.0, down], [0.0, up]),
        ];
        let mut most_degps = 0.0_f64;
        for (name, from, to) in turns.into_iter().filter(|(_, from, to)| from != to) {
            let turn = turn(&mut laboratory, from, to)?;
            let is_yaw = from[0] != to[0];
            let (end, real, path) = match is_yaw {
                true => (turn.end.yaw, to[0], "head.yaw_deg"),
                false => (turn.end.pitch, to[1], "head.pitch_deg"),
            };
            quantities.push(laboratory.quantity(name, "°", to_degrees(end).into(), real.into(), path));
            most_degps = most_degps.max(turn.most_degps);
        }
        let speed = f64::from(to_degrees(real.settings.head.max_speed));
        quantities.push(laboratory.quantity("head: speed of a joint", "°/s", most_degps, speed, "head.max_degps"));
    }
    if shows_its_width(&real) {
        let (measured, diagonal) = field_of_view_deg(&mut laboratory, &real)?;
        quantities.push(laboratory.quantity(
            "camera: diagonal of what it sees",
            "°",
            measured,
            diagonal,
            "cameras.diagonal_fov_deg",
        ));
    }
    Ok(quantities)
}

/// Whether the cameras of a scenario's robots can see the ball by which the field of view is measured.
pub(super) fn shows_its_width(scenario: &Scenario) -> bool {
    super::sensing::sees_at(scenario, &[BALL_M])
}

/// A turn of the head from one end to the other.
struct TurnTrial {
    /// The angles at its end, radians.
    end: HeadAngles,
    /// The greatest speed of a joint in a cycle, degrees per second.
    most_degps: f64,
}

/// Turns the head from one pair of angles to another, yaw and pitch, degrees.
fn turn(laboratory: &mut Laboratory, from: [f32; 2], to: [f32; 2]) -> Result<TurnTrial, TrialError> {
    let script = json!({ "script": [
        { "from_s": 0, "until_s": TURNS_S, "head_deg": from },
        { "from_s": TURNS_S, "until_s": 3.0 * TURNS_S, "head_deg": to },
    ] });
    laboratory.begin(json!({ "ball": null, "robots": [{ "team": "blue", "number": 1, "behaviour": script }] }))?;
    let cycles = laboratory.cycles(TURNS_S);
    laboratory.app.run_cycles(cycles);
    let mut before = laboratory.reading::<HeadAngles>();
    let mut most_degps = 0.0_f64;
    for _ in 0..cycles {
        laboratory.app.run_cycles(1);
        let now = laboratory.reading::<HeadAngles>();
        let way = (now.yaw - before.yaw).abs().max((now.pitch - before.pitch).abs());
        most_degps = most_degps.max(f64::from(to_degrees(way)) / laboratory.period_s());
        before = now;
    }
    Ok(TurnTrial { end: before, most_degps })
}

/// The diagonal field of view of the first camera, degrees, measured and by the settings. The robot turns away from a
/// ball step by step; the last bearing at which it sees the ball gives the angle.
fn field_of_view_deg(laboratory: &mut Laboratory, real: &Scenario) -> Result<(f64, f64), TrialError> {
    const STEP_DEG: f32 = 0.25;
    /// The number of looks per bearing, because not every ball in view is detected.
    const LOOKS: usize = 3;

    let cameras = &real.settings.cameras;
    let Some(mount) = cameras.mounts.as_slice().first() else { return Ok((0.0, 0.0)) };
    let half = cameras.intrinsics(mount).half_slopes();
    let diagonal_deg = |half_width: f32| to_degrees(2.0 * ops::atan(half_width * half.length() / half.x));
    let exact = json!({ "noise": { "preset": "none" } });
    let mut widest_deg = 0.0;
    for step in 0..(90.0 / STEP_DEG) as u32 {
        let beside_deg = step as f32 * STEP_DEG;
        let place = unit(to_radians(beside_deg)) * BALL_M;
        laboratory.begin(json!({
            "ball": { "position_m": [LOOKS_FROM_M + BALL_M, 0] }, "vision": exact,
            "robots": [{ "team": "blue", "number": 1, "pose": [LOOKS_FROM_M, 0, -beside_deg] }],
        }))?;
        let is_seen = (0..LOOKS).any(|_| {
            laboratory.app.run_cycles(laboratory.cycles(0.1));
            laboratory.reading::<Percepts>().ball.is_some_and(|ball| ball.position_m.distance(place) < 0.5)
        });
        if is_seen {
            widest_deg = beside_deg;
        } else if widest_deg > 0.0 {
            break;
        }
    }
    Ok((diagonal_deg(ops::tan(to_radians(widest_deg))).into(), diagonal_deg(half.x).into()))
}
