//! Kicks from the command to where the ball comes to rest.

use approx::assert_abs_diff_eq;
use naoisis::events::{KickMiss, KickResult};
use naoisis::internal::appearance::stride::Stride;
use naoisis::prelude::*;
use naoisis::robot::Roster;
use naoisis::robot::body::Body;

use crate::support::{blue, collect_events, match_of};

fn kick(kick_type: &str, speed: f32, ball: [f32; 2]) -> bevy::prelude::App {
    match_of(&format!(
        r#"{{ "rules": "free", "ball": {{ "position_m": [{}, {}] }},
             "robots": [{{ "number": 1, "behaviour": {{ "script": [
                 {{ "kick": {{ "type": "{kick_type}", "speed": {speed} }} }}] }} }}] }}"#,
        ball[0], ball[1],
    ))
}

fn the_kick(events: &[(u64, MatchEvent)]) -> (KickResult, Option<KickMiss>, Option<f32>) {
    let kicks: Vec<_> = events
        .iter()
        .filter_map(|(_, event)| match event {
            MatchEvent::Kick { result, reason, direction, .. } => Some((*result, *reason, *direction)),
            _ => None,
        })
        .collect();
    assert_eq!(kicks.len(), 1, "{kicks:?}");
    kicks[0]
}

#[test]
fn a_straight_kick_rolls_its_greatest_distance_straight_ahead() {
    let mut app = kick("right_straight", 1.0, [0.15, -0.05]);
    let events = collect_events(&mut app, 30 * 20);
    assert_eq!(the_kick(&events), (KickResult::Kicked, None, Some(0.0)));
    let ball = app.ball().unwrap().position;
    // 4 m from where it lay, at 0.5 /s.
    assert_abs_diff_eq!(ball.x, 4.15, epsilon = 2e-3);
    assert_abs_diff_eq!(ball.y, -0.05, epsilon = 1e-4);
    assert_eq!(app.ball_velocity().unwrap().length(), 0.0);
}

#[test]
fn the_distance_is_in_proportion_to_the_speed() {
    for (speed, distance) in [(0.25, 1.0), (0.5, 2.0), (0.75, 3.0)] {
        let mut app = kick("left_straight", speed, [0.15, 0.05]);
        app.run_cycles(30 * 20);
        assert_abs_diff_eq!(app.ball().unwrap().position.x - 0.15, distance, epsilon = 5e-3);
    }
}

#[test]
fn side_kicks_go_to_their_side_and_2_m_far() {
    for (kick_type, y) in [("left_side", -0.10), ("right_side", 0.10)] {
        let mut app = kick(kick_type, 1.0, [0.10, y]);
        app.run_cycles(30 * 20);
        let ball = app.ball().unwrap().position;
        // Straight from the foot's tip at x = 10 cm to the side.
        assert_abs_diff_eq!(ball.x, 0.10, epsilon = 1e-3);
        assert_abs_diff_eq!(ball.y, y + 2.0 * y.signum(), epsilon = 3e-3);
    }
}

/// The cycles, of 1/30 s, in which a robot that begins a kick in the first one strikes or misses, with the results.
fn strikes(kick_type: &str, wind_up_s: f32, ball: [f32; 2]) -> Vec<(u64, KickResult)> {
    let mut app = match_of(&format!(
        r#"{{ "rules": "free", "ball": {{ "position_m": [{}, {}] }},
             "kicks": {{ "wind_up_s": {wind_up_s}, "extension_s": 0.3, "recovery_s": 0.5 }},
             "robots": [{{ "number": 1, "behaviour": {{ "script": [
                 {{ "kick": {{ "type": "{kick_type}" }} }}, {{ "until_s": 10.0, "walk": [0.003, 0.0, 0.0] }}] }} }}] }}"#,
        ball[0], ball[1],
    ));
    let kicks = collect_events(&mut app, 60).into_iter().filter_map(|(cycle, event)| match event {
        MatchEvent::Kick { result, .. } => Some((cycle, result)),
        _ => None,
    });
    kicks.collect()
}

#[test]
fn the_foot_of_a_side_kick_extends_to_the_front_first_and_strikes_there_what_is_on_the_wrong_side() {
    // A straight kick meets the ball when its wind-up is over, a side kick not before its foot was at the front, 0.3 s or 9 cycles later.
    assert_eq!(strikes("left_straight", 0.0, [0.15, 0.05]), [(1, KickResult::Kicked)]);
    assert_eq!(strikes("left_side", 0.0, [0.15, -0.05]), [(10, KickResult::Kicked)]);
    assert_eq!(strikes("left_side", 0.0, [0.15, 0.05]), [(10, KickResult::Reduced)]);
    assert_eq!(strikes("left_side", 0.0, [0.5, 0.05]), [(10, KickResult::Missed)]);
    // Of a wind-up of 0.7 s, or 21 cycles, the side motion is the rest; the wrong side is struck before it.
    assert_eq!(strikes("left_straight", 0.7, [0.15, 0.05]), [(22, KickResult::Kicked)]);
    assert_eq!(strikes("left_side", 0.7, [0.15, -0.05]), [(22, KickResult::Kicked)]);
    assert_eq!(strikes("left_side", 0.7, [0.15, 0.05]), [(10, KickResult::Reduced)]);
    assert_eq!(strikes("left_side", 0.7, [0.5, 0.05]), [(22, KickResult::Missed)]);
}

#[test]
fn a_ball_that_comes_to_the_wrong_side_after_the_foot_was_extended_is_missed() {
    // It rolls to where the straight kick reaches: there after 0.7 s, and not after 0.3 s.
    let kick = |kick_type: &str| {
        let mut app = match_of(&format!(
            r#"{{ "rules": "free", "ball": {{ "position_m": [0.87, 0.05], "velocity_mps": [-1.2, 0] }},
                 "kicks": {{ "wind_up_s": 0.7, "extension_s": 0.3 }},
                 "robots": [{{ "number": 1, "behaviour": {{ "script": [{{ "kick": {{ "type": "{kick_type}" }} }}] }} }}] }}"#
        ));
        the_kick(&collect_events(&mut app, 30))
    };
    assert_eq!(kick("left_straight").0, KickResult::Kicked);
    assert_eq!(kick("left_side"), (KickResult::Missed, Some(KickMiss::OutOfReach), None));
}

#[test]
fn a_side_kick_from_the_wrong_side_takes_as_long_as_any_other() {
    for ball in [[0.15, 0.05], [0.15, -0.05]] {
        let mut app = match_of(&format!(
            r#"{{ "rules": "free", "ball": {{ "position_m": [{}, {}] }},
                 "kicks": {{ "wind_up_s": 0.7, "extension_s": 0.3, "recovery_s": 0.5 }},
                 "robots": [{{ "number": 1, "behaviour": {{ "script": [
                     {{ "kick": {{ "type": "left_side" }} }}, {{ "until_s": 10.0, "walk": [-0.003, 0.0, 0.0] }}] }} }}] }}"#,
            ball[0], ball[1],
        ));
        // 21 cycles of wind-up and 15 of recovery, of which the first is that of the strike.
        app.run_cycles(36);
        assert_eq!(app.robot_pose(blue(1)).unwrap().position.x, 0.0);
        app.run_cycles(1);
        assert!(app.robot_pose(blue(1)).unwrap().position.x < 0.0);
    }
}

#[test]
fn a_ball_out_of_reach_stays_and_the_event_says_why() {
    let mut app = kick("right_straight", 1.0, [0.25, -0.05]);
    let events = collect_events(&mut app, 60);
    assert_eq!(the_kick(&events), (KickResult::Missed, Some(KickMiss::OutOfReach), None));
    assert_eq!(app.ball().unwrap().position.x, 0.25);
}

#[test]
fn from_the_wrong_side_it_is_a_straight_kick_at_half_the_speed() {
    let mut app = kick("left_side", 1.0, [0.15, 0.05]);
    let events = collect_events(&mut app, 30 * 20);
    assert_eq!(the_kick(&events), (KickResult::Reduced, None, Some(0.0)));
    assert_abs_diff_eq!(app.ball().unwrap().position.x, 2.15, epsilon = 5e-3);
}

#[test]
fn wind_up_delays_the_strike_and_recovery_forbids_the_next_kick_and_walking() {
    let mut app = match_of(
        r#"{ "rules": "free", "ball": { "position_m": [0.15, 0.05] }, "kicks": { "wind_up_s": 0.2, "recovery_s": 0.5 },
             "robots": [{ "number": 1, "behaviour": { "script": [
                 { "from_s": 0.0, "kick": { "type": "left_straight", "speed": 0.1 } },
                 { "from_s": 0.4, "kick": { "type": "left_straight" } },
                 { "from_s": 0.0, "until_s": 10.0, "walk": [0.003, 0.0, 0.0] }] } }] }"#,
    );
    let events = collect_events(&mut app, 21);
    let kicks: Vec<_> = events
        .iter()
        .filter_map(|(cycle, event)| match event {
            MatchEvent::Kick { result, reason, .. } => Some((*cycle, *result, *reason)),
            _ => None,
        })
        .collect();
    // Commanded in cycle 1, 6 cycles of wind-up; at 0.4 s (cycle 13) the robot is still recovering.
    assert_eq!(kicks, [(7, KickResult::Kicked, None), (13, KickResult::Missed, Some(KickMiss::Busy))]);
    assert_eq!(app.robot_pose(blue(1)).unwrap().position.x, 0.0);
    // Recovered after 15 cycles from the strike, in cycle 21: it walks from cycle 22 on.
    app.run_cycles(1);
    assert!(app.robot_pose(blue(1)).unwrap().position.x > 0.0);
}

#[test]
fn speeds_outside_their_range_are_clamped() {
    let mut app = kick("left_straight", 7.5, [0.15, 0.05]);
    app.run_cycles(30 * 20);
    assert_abs_diff_eq!(app.ball().unwrap().position.x, 4.15, epsilon = 2e-3);
}

#[test]
fn a_kick_of_no_number_is_refused_and_nothing_moves() {
    #[derive(bevy::prelude::Component, Default)]
    struct Confused;
    fn confuse(mut robots: bevy::prelude::Query<(&mut KickCommand, &mut WalkCommand), bevy::prelude::With<Confused>>) {
        for (mut kick, mut walk) in &mut robots {
            kick.0 = Some(KickRequest::new(KickType::LeftStraight, f32::NAN));
            *walk = WalkCommand::new(f32::INFINITY, 0.0, 1e30);
        }
    }
    let mut app = crate::support::headless_app();
    app.add_behaviour::<Confused, _>("confused", confuse);
    let scenario = Scenario::from_json(
        r#"{ "rules": "free", "ball": { "position_m": [0.15, 0.05] },
             "robots": [{ "number": 1, "behaviour": "confused" }] }"#,
    )
    .unwrap();
    app.start_match(&scenario).unwrap();
    let events = collect_events(&mut app, 3);
    let refused = events.iter().filter(|(_, event)| matches!(event, MatchEvent::CommandRefused { .. })).count();
    assert_eq!(refused, 6, "{events:?}");
    assert_eq!(app.robot_pose(blue(1)).unwrap(), Pose::default());
    assert_eq!(app.ball().unwrap().position.x, 0.15);
}

/// The greatest angle of the left hip and of its swing aside, by cycles of 1/30 s, of a robot that makes a left side kick in the
/// first one, of 0.7 s with 0.3 s of extension.
fn side_kick(ball_y_m: f32) -> Vec<[f32; 2]> {
    let mut app = match_of(&format!(
        r#"{{ "rules": "free", "ball": {{ "position_m": [0.15, {ball_y_m}] }},
             "kicks": {{ "wind_up_s": 0.7, "extension_s": 0.3 }},
             "robots": [{{ "number": 1, "behaviour": {{ "script": [{{ "kick": {{ "type": "left_side" }} }}] }} }}] }}"#
    ));
    let id = blue(1);
    let robot = app.world().resource::<Roster>().get(id).unwrap();
    app.world_mut().entity_mut(robot).insert(Stride::default());
    let poses = (0..40).map(|_| {
        app.run_cycles(1);
        let leg = app.robot::<Stride>(id).unwrap().joints(id, HeadAngles::default(), &Body::default()).legs[0];
        [leg.hip, leg.aside]
    });
    poses.collect()
}

#[test]
fn a_leg_extends_for_as_long_as_the_kick_takes_and_strikes_the_wrong_side_by_that() {
    let right = side_kick(-0.05);
    // At the front after 0.2 s, and not aside before the last tenth of a second.
    assert!(right[8][0] > 0.3 && right[16] == [right[8][0], 0.0] && right[21][1] < -0.25, "{right:?}");
    let wrong = side_kick(0.05);
    assert_eq!(wrong[..9], right[..9]);
    assert!(wrong[10][0] > 0.3 && wrong.iter().all(|[_, aside]| *aside == 0.0), "{wrong:?}");
    assert!(wrong[30][0].abs() < 0.1, "the foot is back: {wrong:?}");
}
