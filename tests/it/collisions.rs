//! Each type of collision, as it plays out in a match.

use approx::assert_abs_diff_eq;
use bevy::prelude::App;
use naoisis::events::{CollisionPartner, CollisionType};
use naoisis::prelude::*;

use crate::support::{blue, collect_events, match_of, pink};

fn collisions(events: &[(u64, MatchEvent)]) -> Vec<(Option<RobotId>, CollisionPartner, CollisionType)> {
    let mut found = Vec::new();
    for (_, event) in events {
        match event {
            MatchEvent::Collision { robot, with, collision_type, .. } => found.push((*robot, *with, *collision_type)),
            MatchEvent::InvariantBroken { message } => panic!("{message}"),
            _ => {}
        }
    }
    found
}

/// Two robots, 60 cm apart, that walk at each other, and a ball, m.
fn robots_walking_at_each_other(ball: [f32; 2]) -> App {
    let walking = r#""behaviour": { "script": [{ "until_s": 9.0, "walk": [0.005, 0.0, 0.0] }] }"#;
    match_of(&format!(
        r#"{{ "rules": "free", "ball": {{ "position_m": {ball:?} }}, "robots": [
             {{ "number": 1, "pose": [-0.3, 0.0, 0.0], {walking} }},
             {{ "team": "pink", "number": 1, "pose": [0.3, 0.0, 180.0], {walking} }}] }}"#
    ))
}

#[test]
fn two_moving_robots_stop_face_to_face() {
    let mut app = robots_walking_at_each_other([0.0, 1.0]);
    let events = collect_events(&mut app, 150);
    assert_eq!(collisions(&events), [(Some(blue(1)), CollisionPartner::Robot(pink(1)), CollisionType::MovingRobots)]);
    // Torsos reach 5 cm ahead: they meet at the middle, each 5 cm from it.
    assert_abs_diff_eq!(app.robot_pose(blue(1)).unwrap().position.x, -0.05, epsilon = 1e-3);
    assert_abs_diff_eq!(app.robot_pose(pink(1)).unwrap().position.x, 0.05, epsilon = 1e-3);
}

#[test]
fn a_moving_robot_stops_at_a_static_one() {
    let mut app = match_of(
        r#"{ "rules": "free", "ball": { "position_m": [0.0, 1.0] }, "robots": [
             { "number": 1, "pose": [-0.5, 0.0, 0.0],
               "behaviour": { "script": [{ "until_s": 9.0, "walk": [0.005, 0.0, 0.0] }] } },
             { "team": "pink", "number": 1, "pose": [0.0, 0.0, 180.0] }] }"#,
    );
    let events = collect_events(&mut app, 150);
    assert_eq!(
        collisions(&events),
        [(Some(blue(1)), CollisionPartner::Robot(pink(1)), CollisionType::MovingAndStaticRobot)]
    );
    assert_abs_diff_eq!(app.robot_pose(blue(1)).unwrap().position.x, -0.10, epsilon = 1e-3);
    assert_eq!(app.robot_pose(pink(1)).unwrap().position.x, 0.0);
}

#[test]
fn a_moving_robot_stops_at_a_post() {
    let mut app = match_of(
        r#"{ "rules": "free", "ball": { "position_m": [0.0, 1.0] }, "posts": [{ "position_m": [0.5, 0.0] }],
             "robots": [{ "number": 1, "behaviour": { "script": [{ "until_s": 9.0, "walk": [0.005, 0.0, 0.0] }] } }] }"#,
    );
    let events = collect_events(&mut app, 150);
    assert_eq!(collisions(&events), [(Some(blue(1)), CollisionPartner::Post, CollisionType::RobotAndPost)]);
    // 5 cm of torso and 5 cm of post in front of the post's centre.
    assert_abs_diff_eq!(app.robot_pose(blue(1)).unwrap().position.x, 0.40, epsilon = 1e-3);
}

#[test]
fn a_walking_robot_pushes_a_static_ball_ahead_of_itself() {
    let mut app = match_of(
        r#"{ "rules": "free", "ball": { "position_m": [0.3, 0.02] },
             "robots": [{ "number": 1, "behaviour": { "script": [{ "until_s": 2.0, "walk": [0.005, 0.0, 0.0] }] } }] }"#,
    );
    let events = collect_events(&mut app, 60);
    assert_eq!(
        collisions(&events)[0],
        (Some(blue(1)), CollisionPartner::Ball, CollisionType::MovingRobotAndStaticBall)
    );
    // The robot walks at 0.15 m/s, so the ball left with 0.15 (1 + 0.4) = 0.21 m/s at 0.3 m, straight ahead.
    let ball = app.ball().unwrap().position;
    let robot = app.robot_pose(blue(1)).unwrap().position;
    assert_abs_diff_eq!(robot.x, 0.3, epsilon = 1e-3);
    assert!(ball.x > robot.x + 0.14 - 1e-3);
    assert_abs_diff_eq!(ball.y, 0.02, epsilon = 1e-4);
}

#[test]
fn a_kicked_ball_bounces_off_a_standing_and_off_a_walking_robot() {
    for (walk, expected) in
        [(0.0, CollisionType::StandingRobotAndBall), (0.005, CollisionType::MovingRobotAndMovingBall)]
    {
        let mut app = match_of(&format!(
            r#"{{ "rules": "free", "ball": {{ "position_m": [0.3, 0.0], "velocity_mps": [1.0, 0.0] }},
                 "robots": [{{ "number": 1, "pose": [1.0, 0.0, 180.0],
                    "behaviour": {{ "script": [{{ "until_s": 9.0, "walk": [{walk}, 0.0, 0.0] }}] }} }}] }}"#
        ));
        let events = collect_events(&mut app, 45);
        assert_eq!(collisions(&events)[0], (Some(blue(1)), CollisionPartner::Ball, expected));
        let velocity = app.ball_velocity().unwrap();
        assert!(velocity.x < -0.1, "{velocity}");
        assert_abs_diff_eq!(velocity.y, 0.0, epsilon = 1e-4);
    }
}

#[test]
fn a_ball_bounces_off_a_goal_post_and_off_an_extra_post() {
    // The goal post at (2.975, 0.7), and an extra one.
    for (x, y) in [(2.975, 0.7), (0.5, 1.5)] {
        let mut app = match_of(&format!(
            r#"{{ "rules": "free", "ball": {{ "position_m": [{}, {y}], "velocity_mps": [2.0, 0.0] }},
                 "posts": [{{ "position_m": [0.5, 1.5] }}] }}"#,
            x - 0.5,
        ));
        let events = collect_events(&mut app, 30);
        assert_eq!(collisions(&events), [(None, CollisionPartner::Post, CollisionType::BallAndPost)]);
        assert!(app.ball_velocity().unwrap().x < 0.0);
    }
}

#[test]
fn a_ball_between_two_robots_holds_them_apart() {
    let mut app = robots_walking_at_each_other([0.0, 0.0]);
    let events = collect_events(&mut app, 200);
    assert!(!collisions(&events).is_empty());
    let gap = app.robot_pose(pink(1)).unwrap().position.x - app.robot_pose(blue(1)).unwrap().position.x;
    // Toes 11 cm ahead of each, a ball of 6 cm between.
    assert!(gap > 0.28 - 2e-3, "{gap}");
}
