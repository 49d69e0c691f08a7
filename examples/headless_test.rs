//! A headless test of a behaviour, on Bevy's `MinimalPlugins`: no window, no renderer, a fraction of a second.
//!
//! Run with `cargo run --release --no-default-features --example headless_test`, or with `cargo test --example
//! headless_test`: the same test, as you would write it in your own crate.

#![expect(clippy::print_stdout, reason = "an example says what it finds")]

mod common;

use bevy::prelude::*;
use naoisis::prelude::*;

/// A robot that keeps its distance: it walks away from what its sonars detect.
#[derive(Component, Default)]
struct Shy;

fn keep_away(clock: Res<CycleClock>, mut robots: Query<(&SonarReading, &mut WalkCommand), With<Shy>>) {
    for (sonar, mut walk) in &mut robots {
        let nearest = [sonar.left, sonar.right].into_iter().flatten().fold(f32::MAX, f32::min);
        let speed_mps = if nearest < 0.5 { -0.15 } else { 0.0 };
        *walk = WalkCommand::at_velocity(speed_mps, 0.0, 0.0, &clock);
    }
}

fn add_shy(app: &mut App) {
    app.add_behaviour::<Shy, _>("shy", keep_away);
}

/// Another robot 40 cm ahead.
const VISITOR: &str = r#", { "team": "pink", "number": 1, "pose": [0.4, 0.15, 180] }"#;

fn scenario(other: &str) -> String {
    format!(
        r#"{{ "rules": "free", "sonar": {{ "noise": "none" }},
             "robots": [{{ "number": 1, "behaviour": "shy" }} {other}] }}"#
    )
}

/// The position of the robot of a scenario after two seconds.
fn place_after_two_seconds(other: &str) -> Vec2 {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, NaoisisPlugins));
    add_shy(&mut app);
    let scenario = Scenario::from_json(&scenario(other));
    app.start_match(&scenario.expect("the scenario is fine")).expect("it can be started");
    app.run_cycles(60);
    app.robot_pose(RobotId::new(Team::Blue, 1)).expect("the robot is there").position
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    if common::view(&scenario(VISITOR), add_shy, |_| {})? {
        return Ok(());
    }
    let alone = place_after_two_seconds("");
    let visited = place_after_two_seconds(VISITOR);
    println!("alone it stays at {alone}; with a robot 40 cm ahead, it goes to {visited}");
    assert_eq!(alone, Vec2::ZERO);
    // Until the other robot is 0.5 m away.
    assert!((-0.2..-0.05).contains(&visited.x));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alone_it_stays_where_it_is() {
        assert_eq!(place_after_two_seconds(""), Vec2::ZERO);
    }

    #[test]
    fn it_walks_back_from_robots_that_come_near() {
        let place = place_after_two_seconds(VISITOR);
        assert!((-0.2..-0.05).contains(&place.x), "{place}");
    }
}
