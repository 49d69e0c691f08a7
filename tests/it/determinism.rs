//! The same scenario and seed give the same trace, byte for byte.

use bevy::prelude::*;
use naoisis::prelude::*;

use crate::support::{begin_trace, headless_app};

/// The trace of so many cycles.
pub fn trace_of(scenario: &Scenario, cycles: usize) -> Vec<u8> {
    let mut app = headless_app();
    app.start_match(scenario).unwrap();
    let bytes = begin_trace(&mut app);
    app.run_cycles(cycles);
    drop(app);
    let written = bytes.written();
    assert_eq!(written.iter().filter(|byte| **byte == b'\n').count(), cycles + 2);
    written
}

#[test]
fn runs_of_the_same_seed_are_the_same_and_of_another_are_not() {
    let mut earlier = Vec::new();
    for seed in 1..=4 {
        let scenario = Scenario { seed, ..Scenario::named("match3v3").unwrap() };
        let trace = trace_of(&scenario, 900);
        assert!(trace == trace_of(&scenario, 900), "two runs of seed {seed} differ");
        assert!(!earlier.contains(&trace));
        earlier.push(trace);
    }
}

#[test]
fn the_order_in_which_robots_are_listed_does_not_matter() {
    let mut scenario = Scenario::from_json(
        r#"{ "rules": "free", "motion": { "error_sd": { "dx_m": 0.001, "dy_m": 0.001, "dtheta_deg": 0.5 } },
             "ball": { "position_m": [0.3, 0.0] }, "robots": [
             { "number": 1, "pose": [0, 0, 0], "behaviour": "chaser" },
             { "number": 2, "pose": [-0.5, 0.4, 0], "behaviour": "chaser" },
             { "team": "pink", "number": 1, "pose": [0.8, 0.1, 180], "behaviour": "chaser" },
             { "team": "pink", "number": 2, "pose": [0.9, -0.4, 180], "behaviour": "chaser" }] }"#,
    )
    .unwrap();
    let lines = |scenario: &Scenario| {
        let trace = String::from_utf8(trace_of(scenario, 600)).unwrap();
        // The header lists the robots in the scenario's order.
        trace.lines().skip(1).map(str::to_owned).collect::<Vec<_>>()
    };
    let listed = lines(&scenario);
    scenario.robots.reverse();
    assert!(listed == lines(&scenario));
}

#[test]
fn a_second_match_in_the_same_app_is_the_same_match() {
    let scenario = Scenario::named("match3v3").unwrap();
    let mut app = headless_app();
    let mut poses = Vec::new();
    for _ in 0..2 {
        app.start_match(&scenario).unwrap();
        app.run_cycles(300);
        let mut query = app.world_mut().query::<(&RobotId, &Pose)>();
        let mut places: Vec<_> = query.iter(app.world()).map(|(id, pose)| (*id, *pose)).collect();
        places.sort_by_key(|(id, _)| *id);
        poses.push((places, app.ball()));
    }
    assert_eq!(poses[0], poses[1]);
}
