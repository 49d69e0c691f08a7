//! Robots that are picked up, whose programs start again, and whose motors get hot.

use crate::support::{blue, collect_events, headless_app, match_of};
use naoisis::agents::RobotCommand;
use naoisis::communication::MessageStatistics;
use naoisis::events::MatchEvent;
use naoisis::game::PenaltyReason;
use naoisis::interface::gather::{CurrentRecord, gather_start};
use naoisis::prelude::*;
use naoisis::record::RecordPlugin;

/// What happens in `seconds` of a match in which a robot walks ahead with these breakdowns, and how far it gets, m.
fn walk(breakdowns: &str, rules: &str, seconds: usize) -> (Vec<(u64, MatchEvent)>, f32) {
    let mut app = match_of(&format!(
        r#"{{ "rules": {rules}, "ball": null, "breakdowns": {breakdowns}, "motion": {{ "max_linear_mps": 0.1 }},
             "robots": [{{ "team": "blue", "number": 1, "pose": [-2, 0, 0],
                "behaviour": {{ "script": [{{ "until_s": 100, "walk": [1, 0, 0] }}] }} }}] }}"#
    ));
    let events = collect_events(&mut app, 30 * seconds);
    let mut poses = app.world_mut().query::<(&RobotId, &Pose)>();
    let (_, pose) = poses.iter(app.world()).next().unwrap();
    (events, pose.position.x + 2.0)
}

#[test]
fn a_robot_never_breaks_down_by_default() {
    let (events, way_m) = walk("{}", r#""free""#, 20);
    assert!(events.is_empty(), "{events:?}");
    assert!((way_m - 2.0).abs() < 0.01, "{way_m}");
}

#[test]
fn a_team_asks_for_its_robot_to_be_picked_up_and_the_referee_removes_it() {
    // On average once a second.
    let (events, way_m) = walk(r#"{ "pick_ups_per_hour": 1000 }"#, r#"{ "preset": "free", "penalty_s": 15 }"#, 30);
    let removed: Vec<_> = events
        .iter()
        .filter(|(_, event)| {
            matches!(event, MatchEvent::Penalty { robot, reason: PenaltyReason::PickUp, .. } if *robot == blue(1))
        })
        .collect();
    assert!(!removed.is_empty() && way_m < 2.0, "{removed:?} {way_m}");
}

#[test]
fn a_robot_whose_program_starts_again_stands_until_it_has() {
    let (events, way_m) = walk(r#"{ "restarts_per_hour": 1000, "restart_s": 4 }"#, r#""free""#, 60);
    let restarts = events.iter().filter(|(_, event)| matches!(event, MatchEvent::ProgramRestarts { .. })).count();
    // 3.6 s of walking, then 4 s of a start: about eight in a minute, and half of the way. The same seed plays the same.
    assert!((4..=12).contains(&restarts), "{restarts}");
    let stood_s = 4.0 * restarts as f32;
    assert!((way_m - 0.1 * (60.0 - stood_s)).abs() < 0.5, "{way_m} m with {restarts} starts");
    assert_eq!(walk(r#"{ "restarts_per_hour": 1000, "restart_s": 4 }"#, r#""free""#, 60), (events, way_m));
}

#[test]
fn a_robot_whose_program_starts_again_commands_nothing_and_says_nothing() {
    let restarts = r#""breakdowns": { "restarts_per_hour": 400, "restart_s": 4 }"#;
    let scenario = format!(r#"{{ "teams": {{ "blue": "roles", "pink": "roles" }}, {restarts} }}"#);
    let mut app = headless_app();
    app.add_plugins(RecordPlugin).start_match(&Scenario::from_json(&scenario).unwrap()).unwrap();
    gather_start(app.world_mut());
    let (mut said, mut held) = (0, 0);
    for _ in 0..30 * 60 {
        app.run_cycles(1);
        for robot in &app.world().resource::<CurrentRecord>().record.robots {
            let command = robot.command.clone().unwrap_or_default();
            said += u32::from(command.say.is_some());
            held += u32::from(command == RobotCommand::default());
        }
    }
    let statistics = app.world().resource::<MessageStatistics>();
    assert_eq!(said, statistics.blue.sent + statistics.pink.sent);
    assert!(said > 1000 && held > 1000, "{said} {held}");
}

#[test]
fn a_robot_with_hot_motors_walks_more_slowly() {
    let (_, way_m) = walk(r#"{ "hot_after_s": 10, "hot_speed_share": 0.5 }"#, r#""free""#, 20);
    // Ten seconds at 0.1 m/s, then ten at half of it: at half the speed it gets warmer still.
    assert!((way_m - 1.5).abs() < 0.05, "{way_m}");
}
