//! The built-in scenarios show what their names say.

use crate::support;
use bevy::app::App;
use bevy::math::Vec2;
use naoisis::communication::Inbox;
use naoisis::events::{CollisionType, KickResult, MatchEvent};
use naoisis::scenario::{LIBRARY, Scenario};
use naoisis::simulation::MatchApp;

/// The events of a whole built-in scenario, with the time of each, s.
fn events_of(name: &str) -> (App, Vec<(f64, MatchEvent)>) {
    let scenario = Scenario::named(name).unwrap();
    let mut app = support::headless_app();
    app.start_match(&scenario).unwrap();
    let cycles = f64::from(scenario.duration_s.unwrap_or(10.0)) / scenario.cycle_s;
    let events = support::collect_events(&mut app, cycles as usize);
    (app, events.into_iter().map(|(cycle, event)| (cycle as f64 * scenario.cycle_s, event)).collect())
}

/// The times of the collisions of this type, s.
fn collisions(events: &[(f64, MatchEvent)], wanted: CollisionType) -> Vec<f64> {
    let is_wanted =
        |event: &MatchEvent| matches!(event, MatchEvent::Collision { collision_type, .. } if *collision_type == wanted);
    events.iter().filter(|(_, event)| is_wanted(event)).map(|(time, _)| *time).collect()
}

#[test]
fn nothing_goes_wrong_in_the_built_in_scenarios() {
    // Matches have their own tests.
    for entry in LIBRARY.iter().filter(|entry| !entry.name.starts_with("match")) {
        let (_, events) = events_of(entry.name);
        for (time, event) in events {
            let wrong = matches!(event, MatchEvent::InvariantBroken { .. } | MatchEvent::CommandRefused { .. });
            assert!(!wrong, "{}, {time} s: {event:?}", entry.name);
        }
    }
}

#[test]
fn the_kicks_send_the_ball_where_they_say() {
    // Name, where the ball comes to rest, the result of the kick. A side kick leaves along (0.05, -0.15), 2 m far:
    // 2 m * 0.05 / hypot(0.05, 0.15) = 0.632 m forward and three times as far to the side.
    for (name, expected, wanted) in [
        ("kick_left_straight", Vec2::new(-1.85 + 4.0, 0.05), KickResult::Kicked),
        ("kick_right_straight", Vec2::new(-1.85 + 4.0, -0.05), KickResult::Kicked),
        ("kick_left_side", Vec2::new(0.15 + 0.632, 0.9 - 1.897), KickResult::Kicked),
        ("kick_right_side", Vec2::new(0.15 + 0.632, -0.9 + 1.897), KickResult::Kicked),
        ("kick_wrong_side", Vec2::new(-1.85 + 2.0, 0.05), KickResult::Reduced),
    ] {
        let (app, events) = events_of(name);
        let results: Vec<KickResult> = events
            .iter()
            .filter_map(|(_, event)| if let MatchEvent::Kick { result, .. } = event { Some(*result) } else { None })
            .collect();
        assert_eq!(results, [wanted], "{name}");
        let ball = app.ball().unwrap().position;
        assert!(ball.distance(expected) < 0.01, "{name}: {ball}");
        assert_eq!(app.ball_velocity(), Some(Vec2::ZERO), "{name}");
    }
}

#[test]
fn the_collisions_are_of_the_type_that_they_say() {
    // Name, type, time of the first one as its file computes it, s.
    for (name, wanted, expected) in [
        ("collision_moving_robots", CollisionType::MovingRobots, 2.5),
        ("collision_static_robot", CollisionType::MovingAndStaticRobot, 3.33),
        ("collision_post", CollisionType::RobotAndPost, 3.75),
        ("collision_static_ball", CollisionType::MovingRobotAndStaticBall, 2.0),
    ] {
        let (_, events) = events_of(name);
        let times = collisions(&events, wanted);
        let first = times.first().copied().unwrap_or_else(|| panic!("{name}: {events:?}"));
        assert!((first - expected).abs() < 0.1, "{name}: {first} s");
    }
    for (name, wanted) in [
        ("collision_moving_ball", CollisionType::MovingRobotAndMovingBall),
        ("collision_ball_standing_robot", CollisionType::StandingRobotAndBall),
        ("collision_ball_post", CollisionType::BallAndPost),
    ] {
        let (app, events) = events_of(name);
        assert!(!collisions(&events, wanted).is_empty(), "{name}: {events:?}");
        // It came back from where it went.
        let furthest = if name == "collision_ball_post" { 2.9 } else { 0.4 };
        assert!(app.ball().unwrap().position.x < furthest, "{name}");
    }
}

#[test]
fn the_square_is_closed_and_the_pass_comes_back() {
    let (app, _) = events_of("walk_square");
    let pose = app.robot_pose(support::blue(1)).unwrap();
    assert!(pose.position.distance(Vec2::new(-0.45, -0.45)) < 1e-3 && pose.heading.abs() < 1e-3, "{pose:?}");

    let (app, events) = events_of("pass");
    let kicks = events.iter().filter(|(_, event)| matches!(event, MatchEvent::Kick { result: KickResult::Kicked, .. }));
    assert_eq!(kicks.count(), 2);
    let ball = app.ball().unwrap().position;
    assert!(ball.distance(Vec2::new(-1.35, -0.05)) < 0.01, "{ball}");
}

#[test]
fn team_mates_hear_each_other_and_opponents_nothing() {
    let mut app = support::headless_app();
    app.start_match(&Scenario::named("messages").unwrap()).unwrap();
    let mut heard = [0; 3];
    let robots = [support::blue(1), support::blue(2), support::pink(1)];
    for _ in 0..180 {
        app.run_cycles(1);
        for (count, id) in heard.iter_mut().zip(robots) {
            *count += app.robot::<Inbox>(id).unwrap().0.len();
        }
    }
    // Blue 1 speaks in 150 cycles and blue 2 in 90; two thirds arrive: 100 and 60, with standard deviations of
    // sqrt(n p (1 - p)) = 5.8 and 4.5.
    assert!((40..80).contains(&heard[0]) && (75..125).contains(&heard[1]) && heard[2] == 0, "{heard:?}");
}
