//! Balls that leave the ground: thrown by a scenario, raised by a kick, seen by a robot, and judged by the referee.

use crate::support::{collect_events, match_of};
use approx::assert_abs_diff_eq;
use bevy::prelude::*;
use naoisis::ball::Ball;
use naoisis::ball::flight::BallFlight;
use naoisis::events::MatchEvent;
use naoisis::prelude::*;
use naoisis::simulation::Snapshot;

/// The place of the ball, m, and its height above the ground, after each cycle of a match without robots.
fn flight(ball: &str, cycles: usize) -> Vec<Vec3> {
    let mut app = match_of(&format!(r#"{{ "rules": "free", "ball": {ball}, "robots": [] }}"#));
    (0..cycles)
        .map(|_| {
            app.run_cycles(1);
            let mut balls = app.world_mut().query_filtered::<(&Pose, &BallFlight), With<Ball>>();
            let (pose, flight) = balls.single(app.world()).unwrap();
            pose.position.extend(flight.height_m)
        })
        .collect()
}

#[test]
fn a_thrown_ball_flies_bounces_and_rolls() {
    let way = flight(
        r#"{ "position_m": [0, 0], "velocity_mps": [2, 0, 3],
             "flight": { "drag_per_m": 0, "ground_restitution": 0.5, "ground_friction": 0 } }"#,
        120,
    );
    // It is highest after v / g = 0.306 s: v² / 2 g = 0.459 m.
    let highest = way.iter().map(|place| place.z).fold(0.0, f32::max);
    assert_abs_diff_eq!(highest, 0.459, epsilon = 0.01);
    // It comes down after 0.61 s, 1.22 m away, rises to a quarter, and lies on the ground after all its bounces: 1.2 s.
    let down = way.iter().skip(5).position(|place| place.z < 0.05).unwrap() + 5;
    assert_abs_diff_eq!(way[down].x, 1.22, epsilon = 0.1);
    let second = way[20..35].iter().map(|place| place.z).fold(0.0, f32::max);
    assert_abs_diff_eq!(second, 0.459 / 4.0, epsilon = 0.02);
    assert!(way[60..].iter().all(|place| place.z == 0.0));
}

#[test]
fn files_have_two_numbers_for_a_ball_on_the_ground_and_three_for_one_above() {
    let read = |ball: &str| Scenario::from_json(&format!(r#"{{ "ball": {ball}, "robots": [] }}"#));
    let ball = read(r#"{ "position_m": [1, 0.5, 0.4], "velocity_mps": [0, 0, -1] }"#).unwrap().ball.unwrap();
    let start = ball.start_flight();
    assert_abs_diff_eq!(start.height_m, 0.37, epsilon = 1e-6);
    assert_eq!(start.climb_mps, -1.0);
    for (text, numbers) in [("[1, 0.5]", "[1,0.5]"), ("[1, 0.5, 0.4]", "[1,0.5,0.4]")] {
        let text = format!(r#"{{ "position_m": {text} }}"#);
        let written = serde_json::to_string(&read(&text).unwrap().ball).unwrap().replace(".0,", ",");
        assert!(written.contains(&format!(r#""position_m":{numbers}"#)), "{written}");
    }
    for wrong in ["[1]", "[1, 2, 3, 4]", "1", r#"["a", 2]"#] {
        let problem = read(&format!(r#"{{ "position_m": {wrong} }}"#)).unwrap_err().to_string();
        assert!(problem.contains("position_m"), "{problem}");
    }
    // 80 m/s along the ground and 80 m/s up are more than 100 m/s.
    assert!(read(r#"{ "velocity_mps": [80, 0, 80] }"#).is_err());
}

#[test]
fn over_the_crossbar_it_is_out_and_under_it_a_goal() {
    let judged = |climb: f32| {
        let mut app = match_of(&format!(
            r#"{{ "rules": {{ "preset": "free", "goals": true, "ball_out": true, "ball_out_restart": "kick_off" }}, "robots": [],
                 "ball": {{ "position_m": [2, 0], "velocity_mps": [4, 0, {climb}] }} }}"#
        ));
        let events = collect_events(&mut app, 60);
        let goal = events.iter().any(|(_, event)| matches!(event, MatchEvent::Goal { .. }));
        let out = events.iter().any(|(_, event)| matches!(event, MatchEvent::BallOut { .. }));
        (goal, out)
    };
    // The goal line is reached after 0.26 s. With 2 m/s up the ball is 0.19 m high there, with 5 m/s 0.98 m; the bar is at 0.8 m.
    assert_eq!(judged(2.0), (true, false));
    assert_eq!(judged(5.0), (false, true));
}

#[test]
fn a_shot_at_the_goal_of_any_league_stays_in_its_net() {
    for league in ["spl2010", "spl2025", "hsl2026_small", "hsl2026_middle", "hsl2026_large"] {
        // Along the ground, aslant into the side of the net, and in the air.
        for velocity in ["5, 0", "5, 1.5", "5, 0, 2"] {
            let pitch = naoisis::scenario::pitch_preset(league).unwrap();
            let x = pitch.half_length() - 1.0;
            let mut app = match_of(&format!(
                r#"{{ "league": "{league}", "rules": "free", "robots": [],
                     "ball": {{ "position_m": [{x}, 0], "velocity_mps": [{velocity}] }} }}"#
            ));
            app.run_cycles(300);
            let mut balls = app.world_mut().query_filtered::<&Pose, With<Ball>>();
            let Vec2 { x, y } = balls.single(app.world()).unwrap().position;
            let goal = pitch.goal;
            assert!(
                x > pitch.half_length() && x < pitch.goal_post_x() + goal.depth_m && y.abs() < goal.width_m / 2.0,
                "{league}, {velocity}: {x}, {y}"
            );
        }
    }
}

#[test]
fn a_kick_with_an_elevation_lifts_the_ball_over_a_lying_obstacle() {
    let highest = |elevation: &str| {
        let mut app = match_of(&format!(
            r#"{{ "rules": "free", "ball": {{ "position_m": [0.15, -0.05] }},
                 "robots": [{{ "team": "blue", "number": 1, "pose": [0, 0, 0],
                    "kicks": {{ "right_straight": {{ "max_distance_m": 4 {elevation} }} }},
                    "behaviour": {{ "script": [{{ "until_s": 2, "kick": {{ "type": "right_straight" }} }}] }} }}] }}"#
        ));
        let mut highest = 0.0_f32;
        for _ in 0..60 {
            app.run_cycles(1);
            let mut balls = app.world_mut().query_filtered::<&BallFlight, With<Ball>>();
            highest = highest.max(balls.single(app.world()).unwrap().height_m);
        }
        highest
    };
    assert_eq!(highest(""), 0.0);
    // 2 m/s at 45 degrees rise by (2 sin 45°)² / 2 g = 0.10 m.
    assert_abs_diff_eq!(highest(r#", "elevation_deg": 45"#), 0.1, epsilon = 0.02);
}

#[test]
fn a_robot_takes_a_ball_in_the_air_for_one_that_is_further_away() {
    let mut app = match_of(
        r#"{ "rules": "free", "ball": { "position_m": [1.5, 0, 0.2], "velocity_mps": [0, 0, 0] },
             "robots": [{ "team": "blue", "number": 1, "pose": [0, 0, 0], "head_deg": [0, 10] }] }"#,
    );
    app.run_cycles(1);
    let mut balls = app.world_mut().query_filtered::<(&Pose, &BallFlight), With<Ball>>();
    let height_m = balls.single(app.world()).unwrap().1.height_m;
    let mut robots = app.world_mut().query::<(&Percepts, &naoisis::robot::body::Body)>();
    let (percepts, body) = robots.single(app.world()).unwrap();
    let seen = percepts.ball.as_ref().unwrap().position_m;
    // The line of sight goes through the ball's centre, and on to where a ball on the ground would be. The lens is some 0.5 m high.
    let expected = |lens_m: f32| 1.5 * (lens_m - 0.03) / (lens_m - 0.03 - height_m);
    assert!(
        height_m > 0.1 && seen.x > expected(body.height_m + 0.05) && seen.x < expected(body.neck_m.z),
        "{seen} {height_m}"
    );
}

#[test]
fn a_saved_match_goes_on_with_the_ball_in_the_air() {
    let mut app = match_of(r#"{ "rules": "free", "ball": { "velocity_mps": [2, 0.5, 5] }, "robots": [] }"#);
    app.run_cycles(10);
    let state = |app: &mut App| Snapshot::take(app.world_mut()).unwrap().to_bytes(app.world()).unwrap();
    let saved = state(&mut app);
    let ending = state(app.run_cycles(20));
    Snapshot::from_bytes(&saved, app.world()).unwrap().restore(app.world_mut()).unwrap();
    assert!(state(app.run_cycles(20)) == ending);
    let mut balls = app.world_mut().query_filtered::<&BallFlight, With<Ball>>();
    assert!(balls.single(app.world()).unwrap().height_m > 0.0);
}

#[test]
fn a_ball_high_above_a_post_is_not_in_it() {
    let mut app = match_of(
        r#"{ "rules": "free", "ball": { "position_m": [-2.5, 0.7, 2.5], "velocity_mps": [-4, 0, 0] }, "robots": [] }"#,
    );
    for cycle in 0..60 {
        app.run_cycles(1);
        assert!(app.events().iter().all(|event| !matches!(event, MatchEvent::InvariantBroken { .. })), "{cycle}");
    }
}
