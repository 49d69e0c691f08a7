//! A first behaviour: a robot that looks for the ball, walks to it and kicks it. It knows only what its own cameras
//! see.
//!
//! Run with `cargo run --release --no-default-features --example first_behaviour`.

#![expect(clippy::print_stdout, reason = "an example says what it finds")]

mod common;

use bevy::prelude::*;
use naoisis::prelude::*;

/// Ties robots to the behaviour; scenarios name it `"kicker"`.
#[derive(Component, Default)]
struct Kicker;

/// A behaviour is a system. It reads sensors and writes commands of the robots with its marker, and registration fails
/// if it asks for more.
fn kick_the_ball(
    clock: Res<CycleClock>,
    mut robots: Query<(&Percepts, &HeadAngles, &mut HeadCommand, &mut WalkCommand, &mut KickCommand), With<Kicker>>,
) {
    for (percepts, angles, mut head, mut walk, mut kick) in &mut robots {
        *walk = WalkCommand::default();
        let Some(ball) = percepts.ball else {
            // Turns around, and nods: the upper camera sees far, the lower near.
            *walk = WalkCommand::at_velocity(0.0, 0.0, 1.2, &clock);
            head.pitch = if angles.pitch < 0.1 { 0.3 } else { 0.0 };
            continue;
        };
        // Positions are in the robot's frame: x ahead, y to the left, in metres.
        let place = ball.position_m;
        head.yaw = place.to_angle();
        head.pitch = if place.length() < 1.0 { 0.35 } else { 0.0 };
        if KickType::RightStraight.admits(place) {
            kick.0 = Some(KickRequest::new(KickType::RightStraight, 1.0));
        } else {
            // Walks to where the ball lies 16 cm ahead and 5 cm to the right: in front of the right foot. The step is cut to what a
            // robot can do in a cycle.
            *walk = WalkCommand::new(place.x - 0.16, place.y + 0.05, 0.3 * head.yaw);
        }
    }
}

const SCENARIO: &str = r#"{ "rules": "free", "ball": { "position_m": [0.8, 0.4] },
    "robots": [{ "number": 1, "pose": [-0.5, 0, 120], "behaviour": "kicker" }] }"#;

fn add_kicker(app: &mut App) {
    app.add_behaviour::<Kicker, _>("kicker", kick_the_ball);
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    if common::view(SCENARIO, add_kicker, |_| {})? {
        return Ok(());
    }
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    add_kicker(&mut app);
    app.start_match(&Scenario::from_json(SCENARIO)?)?;
    for second in 1..=20 {
        app.run_cycles(30);
        let (robot, ball) = (RobotId::new(Team::Blue, 1), app.ball().unwrap_or_default().position);
        let pose = app.robot_pose(robot).unwrap_or_default();
        println!(
            "{second:2} s  robot at ({:5.2}, {:5.2}) facing {:4.0}°   ball at ({:5.2}, {:5.2})",
            pose.position.x,
            pose.position.y,
            pose.heading.to_degrees(),
            ball.x,
            ball.y
        );
    }
    Ok(())
}
