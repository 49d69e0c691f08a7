//! A headless test of a behaviour, on `MinimalPlugins`: no window, no renderer, a fraction of a second.
//!
//! Run with `cargo run --release --no-default-features --example headless_test`, or with `cargo test --example
//! headless_test`: the same test, as you would write it in your own crate.

#![expect(clippy::print_stdout, reason = "an example says what it finds")]

use bevy::prelude::*;
use naoisis::prelude::*;

/// A robot that keeps its distance: it walks back from whatever its sonars hear.
#[derive(Component, Default)]
struct Shy;

fn keep_away(mut robots: Query<(&SonarReading, &mut WalkCommand), With<Shy>>) {
    for (sonar, mut walk) in &mut robots {
        let nearest = [sonar.left, sonar.right].into_iter().flatten().fold(f32::MAX, f32::min);
        walk.dx = if nearest < 0.5 { -0.005 } else { 0.0 };
    }
}

/// What the robot of a scenario has before it, and where it is two seconds later.
fn place_after_two_seconds(other: &str) -> Vec2 {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, NaoisisPlugins));
    app.add_behaviour::<Shy, _>("shy", keep_away);
    let scenario = Scenario::from_json(&format!(
        r#"{{ "rules": "free", "sonar": {{ "noise": "none" }},
             "robots": [{{ "number": 1, "behaviour": "shy" }} {other}] }}"#
    ));
    app.start_match(&scenario.expect("the scenario is fine")).expect("it can be started");
    app.run_cycles(60);
    app.robot_pose(RobotId::new(Team::Blue, 1)).expect("the robot is there").position
}

fn main() {
    let alone = place_after_two_seconds("");
    let visited = place_after_two_seconds(r#", { "team": "pink", "number": 1, "pose": [0.4, 0.15, 180] }"#);
    println!("alone it stays at {alone}; with somebody 40 cm before it, it goes to {visited}");
    assert_eq!(alone, Vec2::ZERO);
    // Until the other is 0.5 m away.
    assert!((-0.2..-0.05).contains(&visited.x));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alone_it_stays_where_it_is() {
        assert_eq!(place_after_two_seconds(""), Vec2::ZERO);
    }

    #[test]
    fn it_walks_back_from_whoever_comes_near() {
        let place = place_after_two_seconds(r#", { "team": "pink", "number": 1, "pose": [0.4, 0.15, 180] }"#);
        assert!((-0.2..-0.05).contains(&place.x), "{place}");
    }
}
