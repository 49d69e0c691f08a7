//! Falls and kicks of robots that walk: in contact, over robots that lie, from either side, and on the move.

use crate::support::{blue, collect_events, match_of};
use bevy::prelude::*;
use naoisis::events::{FallCause, MatchEvent};
use naoisis::prelude::*;
use naoisis::robot::posture::{LyingOn, Posture};
use naoisis::team::Team;

/// What happens in a minute in which blue's robot walks ahead into pink's. `falls` are the settings of both, `pink` are the
/// behaviour and other fields of pink's; without a pose, it faces blue's 0.6 m ahead.
fn meeting(seed: u32, falls: &str, pink: &str) -> Vec<(u64, MatchEvent)> {
    let place = if pink.contains("pose") { "" } else { r#""pose": [0.6, 0, 180],"# };
    let mut app = match_of(&format!(
        r#"{{ "seed": {seed}, "rules": "free", "ball": null, "falls": {falls},
             "robots": [
                {{ "team": "blue", "number": 1, "pose": [0, 0, 0],
                   "behaviour": {{ "script": [{{ "until_s": 60, "walk": [1, 0, 0] }}] }} }},
                {{ "team": "pink", "number": 1, {place} {pink} }}] }}"#
    ));
    collect_events(&mut app, 30 * 60)
}

/// The causes of the falls of blue's robot.
fn causes(events: &[(u64, MatchEvent)]) -> Vec<FallCause> {
    let fall = |event: &MatchEvent| match event {
        MatchEvent::Fall { robot, cause, .. } if *robot == blue(1) => Some(*cause),
        _ => None,
    };
    events.iter().filter_map(|(_, event)| fall(event)).collect()
}

#[test]
fn a_robot_falls_in_contact_that_lasts_and_not_at_once() {
    let still = r#""behaviour": "idle""#;
    let events = meeting(1, r#"{ "contact_falls_per_min": 6 }"#, still);
    assert_eq!(causes(&events), [FallCause::Contact]);
    assert_eq!(causes(&meeting(1, "{}", still)), []);
    // With six falls a minute it takes 10 s on average: of 30 robots, 1 - exp(-3) fall within 30 s, and few at once.
    let first_s = |seed| {
        let events = meeting(seed, r#"{ "contact_falls_per_min": 6 }"#, still);
        let cycle = |wanted: fn(&MatchEvent) -> bool| events.iter().find(|(_, event)| wanted(event)).map(|(at, _)| *at);
        let began = cycle(|event| matches!(event, MatchEvent::Collision { .. })).unwrap();
        let fell = cycle(|event| matches!(event, MatchEvent::Fall { cause: FallCause::Contact, .. }));
        fell.map_or(60.0, |fell| (fell - began) as f32 / 30.0)
    };
    let times: Vec<f32> = (1..=30).map(first_s).collect();
    let mean = times.iter().sum::<f32>() / 30.0;
    // Either of the two may fall first: 5 s on average, with a standard error of 0.9 s.
    assert!((2.5..8.0).contains(&mean), "{mean}");
}

#[test]
fn a_robot_trips_over_one_that_lies() {
    let falls = r#"{ "trip_probability": 1 }"#;
    // Pink's falls as soon as it walks, and stays down.
    let lies =
        r#""falls": { "falls_per_min": 1000 }, "behaviour": { "script": [{ "until_s": 1, "walk": [0, 1, 0] }] }"#;
    assert_eq!(causes(&meeting(1, falls, lies)), [FallCause::Tripping]);
    // One that stands is no obstacle to trip over.
    assert_eq!(causes(&meeting(1, falls, r#""behaviour": "idle""#)), []);
    // Its whole length lies in the way: from 1 m ahead, facing to the left, half of its 57 cm reach into the way of a robot 0.37 m beside it.
    let aside = |y: f32| format!(r#""pose": [1, {y}, 90], {lies}"#);
    assert_eq!(causes(&meeting(1, falls, &aside(0.37))), [FallCause::Tripping]);
    assert_eq!(causes(&meeting(1, falls, &aside(0.41))), []);
    // Once for each time: of 60 that walk into one that lies, half fall, with a standard error of 6 %.
    let fell =
        (1..=60).filter(|seed| !causes(&meeting(*seed, r#"{ "trip_probability": 0.5 }"#, lies)).is_empty()).count();
    assert!((18..=42).contains(&fell), "{fell}");
}

#[test]
fn a_robot_that_lies_stops_the_ball_with_its_whole_length_and_lets_out_the_one_under_it() {
    let end_of = |falls: &str, ball: &str| {
        let mut app = match_of(&format!(
            r#"{{ "rules": "free", "ball": {{ {ball} }}, "robots": [
                {{ "number": 1, "pose": [0, 0, 0], "falls": {falls},
                   "behaviour": {{ "script": [{{ "from_s": 0.5, "until_s": 0.9, "walk": [1, 0, 0] }}] }} }}] }}"#
        ));
        app.run_cycles(5 * 30);
        app.ball().unwrap().position
    };
    let (falls, stands) = (r#"{ "falls_per_min": 1000 }"#, "{}");
    let passing = r#""position_m": [0.24, 1.5], "velocity_mps": [0, -1]"#;
    assert!(end_of(stands, passing).y < -0.2, "it rolls by before the toes");
    let stopped = end_of(falls, passing).y;
    assert!(stopped > 0.15, "{stopped}");
    // The robot falls on this one, which rolls on.
    let under = r#""position_m": [0.24, 0.3], "velocity_mps": [0, -0.5]"#;
    assert!(end_of(falls, under).y < -0.2);
}

#[test]
fn a_robot_lies_on_the_side_that_it_fell_on_and_gets_up_from_the_back_in_its_own_time() {
    let times = |share: f32| {
        let mut app = match_of(&format!(
            r#"{{ "rules": "free", "ball": null,
                 "falls": {{ "falls_per_min": 60, "on_back_share": {share}, "get_up_s": 1, "get_up_from_back_s": 3 }},
                 "robots": [{{ "number": 1, "behaviour":
                    {{ "script": [{{ "until_s": 100, "walk": [1, 0, 0], "posture": "get_up" }}] }} }}] }}"#
        ));
        let (mut down, mut sides) = (Vec::new(), Vec::new());
        let mut fell = None;
        for cycle in 0..1800_u32 {
            app.run_cycles(1);
            sides.extend(app.robot::<Posture>(blue(1)).unwrap().lying_on());
            for event in app.events() {
                match event {
                    MatchEvent::Fall { .. } => fell = Some(cycle),
                    MatchEvent::GotUp { .. } => down.extend(fell.take().map(|fell| cycle - fell)),
                    _ => {}
                }
            }
        }
        (down, sides)
    };
    for (share, side, seconds) in [(0.0, LyingOn::Front, 1), (1.0, LyingOn::Back, 3)] {
        let (down, sides) = times(share);
        assert!(down.len() > 5 && sides.iter().all(|on| *on == side), "{side:?}");
        // A cycle to begin, and one to stand.
        assert!(down.iter().all(|cycles| (30 * seconds..=30 * seconds + 3).contains(cycles)), "{side:?} {down:?}");
    }
}

#[test]
fn getting_up_fails_where_another_robot_touches_it() {
    let touched = r#""falls": { "contact_falls_per_min": 1000, "get_up_s": 1, "get_up_failure_in_contact": 1 },
        "behaviour": { "script": [{ "until_s": 60, "posture": "get_up" }] }"#;
    let events = meeting(1, "{}", touched);
    let of_pink = |wanted: fn(&MatchEvent) -> bool| events.iter().filter(|(_, event)| wanted(event)).count();
    let failed = of_pink(
        |event| matches!(event, MatchEvent::Fall { cause: FallCause::GettingUp, robot, .. } if robot.team == Team::Pink),
    );
    let stood = of_pink(|event| matches!(event, MatchEvent::GotUp { robot } if robot.team == Team::Pink));
    // Blue's robot walks against it all the time.
    assert!(failed > 5 && stood == 0, "{failed} {stood}");
}

#[test]
fn a_kick_in_walking_does_not_stop_the_robot_and_a_standing_one_does() {
    let way = |kick: &str| {
        let mut app = match_of(&format!(
            r#"{{ "rules": "free", "model": "nao_v6", "realism": {{ "motion": "realistic", "kicks": "realistic" }},
                 "ball": {{ "position_m": [0.2, 0] }},
                 "robots": [{{ "number": 1, "pose": [0, 0, 0], "behaviour": {{ "script": [
                    {{ "until_s": 2, "walk": [1, 0, 0] }},
                    {{ "from_s": 0, "until_s": 0.03, "kick": {{ "type": "{kick}" }} }}] }} }}] }}"#
        ));
        let events = collect_events(&mut app, 45);
        let struck =
            events.iter().any(|(_, event)| matches!(event, MatchEvent::Kick { launch_speed_mps: Some(_), .. }));
        (app.robot_pose(blue(1)).unwrap().position.x, struck)
    };
    let (walked_m, struck) = way("walk_forward");
    assert!(walked_m > 0.15 && struck, "{walked_m} {struck}");
    let (stood_m, _) = way("left_straight");
    assert!(stood_m < 0.05, "{stood_m}");
}

#[test]
fn a_dive_stops_the_balls_that_come_after_the_body_is_down() {
    /// How far the ball gets that passes 0.35 m to the left of a robot that dives to the left at once, and reaches it after 0.5 s.
    fn ball_x_m(dive_down_s: f32) -> f32 {
        let mut app = match_of(&format!(
            r#"{{ "rules": {{ "preset": "free", "dives": true, "dive_s": 2, "dive_down_s": {dive_down_s} }},
                 "ball": {{ "position_m": [1, 0.35], "velocity_mps": [-2, 0] }},
                 "robots": [{{ "number": 1, "pose": [0, 0, 0],
                               "behaviour": {{ "script": [{{ "until_s": 0.1, "posture": {{ "dive": "left" }} }}] }} }}] }}"#
        ));
        collect_events(&mut app, 30 * 2);
        app.ball().unwrap().position.x
    }
    assert!(ball_x_m(0.0) > 0.0 && ball_x_m(0.2) > 0.0, "{} {}", ball_x_m(0.0), ball_x_m(0.2));
    assert!(ball_x_m(1.2) < -0.3, "it has passed: {}", ball_x_m(1.2));
}
