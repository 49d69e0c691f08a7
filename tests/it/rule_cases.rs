//! The rules, case by case: `tests/rule_cases/README.md` is the table, and each case a small scenario beside it.

use naoisis::prelude::*;
use serde_json::Value;
use std::path::PathBuf;

use crate::support::headless_app;

/// Numbers within this are equal.
const TOLERANCE: f64 = 0.1;

/// A test for each case of the table.
macro_rules! rule_cases {
    ($($name:ident)*) => {
        $(#[test]
        fn $name() {
            play(stringify!($name));
        })*

        const NAMES: &[&str] = &[$(stringify!($name)),*];
    };
}

rule_cases! {
    goal_whole_ball_over_the_line
    goal_ball_on_the_line
    goal_inside_the_post
    goal_outside_the_post
    goal_against_the_own_side
    goal_of_an_opponent
    goal_from_a_deflection
    goal_past_a_robot
    goal_mercy_reached
    goal_mercy_not_reached
    out_whole_ball_over_the_side_line
    out_ball_on_the_side_line
    out_whole_ball_over_the_goal_line
    out_ball_on_the_goal_line
    out_by_blue_is_pinks_kick_off
    out_by_pink_is_blues_kick_off
    out_after_a_deflection
    throw_in_a_metre_back
    throw_in_nobody_touched
    throw_in_over_the_own_goal_line
    throw_in_over_the_other_goal_line
    kick_in_after_a_ball_over_the_side_line
    goal_kick_after_a_shot_beside_the_goal
    corner_kick_after_a_clearance
    free_kick_defender_too_near
    free_kick_defender_far_enough
    free_kick_defender_leaves
    free_kick_defender_touches_the_ball
    free_kick_taken
    free_kick_not_taken_in_time
    free_kick_not_taken_yet
    kick_off_shot_directly
    kick_off_pass_then_shot
    indirect_goal_by_one_robot
    indirect_goal_by_two_robots
    indirect_own_goal
    kick_off_all_legal
    kick_off_in_the_other_half
    kick_off_just_in_the_own_half
    kick_off_defender_in_the_circle
    kick_off_defender_outside_the_circle
    kick_off_defender_before_its_penalty_mark
    kick_off_defender_behind_its_penalty_mark
    kick_off_second_attacker_in_the_circle
    kick_off_field_player_in_the_penalty_area
    kick_off_field_player_before_the_penalty_area
    kick_off_keeper_away
    kick_off_off_the_pitch
    kick_off_on_the_centre_mark
    kick_off_illegal_position_2025
    ready_ends_early_when_all_stand
    ready_goes_on_while_one_is_illegal
    ready_goes_on_while_one_walks
    kick_off_defender_comes_too_early
    kick_off_defender_waits
    push_a_standing_robot
    push_brush
    push_just_too_fast
    push_the_faster_one
    push_equally_fast
    push_with_the_ball_between
    push_with_the_ball_elsewhere
    push_a_team_mate
    push_by_the_keeper_at_home
    push_by_the_keeper_away
    push_with_the_side_on_the_way_to_the_ball_2010
    push_with_the_side_when_the_other_goes_elsewhere_2010
    push_with_the_side_when_the_other_goes_elsewhere_2025
    push_with_the_side_on_the_way_elsewhere_2025
    push_limit_reached
    push_limit_not_reached
    push_near_the_ball_2025
    push_far_from_the_ball_2025
    penalty_is_served
    penalty_is_not_over
    stall_near_the_ball
    stall_a_little_farther_away
    stall_not_yet
    stall_but_moves
    hold_the_ball
    hold_no_ball_at_the_toes
    hold_the_ball_shortly
    hold_by_the_keeper_at_home
    hold_by_the_keeper_for_too_long
    leave_the_carpet
    stay_on_the_carpet
    stay_in_the_goal
    come_out_of_the_goal
    defend_in_the_penalty_area
    defend_with_a_foot_outside
    defend_as_the_keeper
    defend_and_leave
    defend_with_one_too_many_2025
    defend_with_as_many_as_allowed_2025
    inactive_and_looks_away
    inactive_but_looks_at_the_ball
    inactive_but_moves_its_head
    inactive_not_yet
    stuck_with_a_robot_at_the_ball
    stuck_with_a_robot_at_the_ball_2025
    stuck_with_nobody_at_the_ball
    stuck_before_anybody_touched_it
    not_stuck_while_the_ball_moves
    fall_at_a_certain_speed
    no_fall_at_a_low_speed
    fallen_and_stays_down
    fallen_and_gets_up
    fallen_and_takes_too_long
    dive_saves
    dive_to_the_wrong_side
    dive_out_of_reach
    dive_where_there_are_none
    half_time
    final_whistle
    no_final_whistle_yet
    shoot_out_after_a_draw
    no_shoot_out_after_a_win
    shoot_out_is_won
    intervene_place_ball
    intervene_penalise
    intervene_penalise_who_is_not_there
    intervene_return
    intervene_whistle
    intervene_drop_ball
    intervene_score
    intervene_kick_off
    intervene_place_robot
}

#[test]
fn the_table_the_files_and_the_tests_agree() {
    let table = table();
    let in_table: Vec<&str> = table.iter().map(|case| case.name.as_str()).collect();
    assert_eq!(in_table, NAMES);
    let mut files: Vec<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "ron"))
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    files.sort();
    let mut names = in_table;
    names.sort_unstable();
    assert_eq!(files, names);
}

/// A row of the table.
struct Case {
    name: String,
    /// Events that must happen, and those that must not.
    expected: Vec<(bool, Pattern)>,
}

/// An event's kind, and values of some of its fields.
struct Pattern {
    text: String,
    kind: String,
    fields: Vec<(String, String)>,
}

impl Pattern {
    fn matches(&self, event: &Value) -> bool {
        event["kind"] == self.kind.as_str() && self.fields.iter().all(|(name, value)| is(&event[name], value))
    }
}

/// Whether a value of an event is what the table says.
fn is(found: &Value, expected: &str) -> bool {
    match (found, serde_json::from_str::<Value>(expected)) {
        (Value::String(text), _) => text == expected,
        (found, Ok(expected)) => equal(found, &expected),
        (_, Err(_)) => false,
    }
}

fn equal(one: &Value, other: &Value) -> bool {
    match (one, other) {
        (Value::Array(one), Value::Array(other)) => {
            one.len() == other.len() && one.iter().zip(other).all(|(one, other)| equal(one, other))
        }
        _ => match (one.as_f64(), other.as_f64()) {
            (Some(one), Some(other)) => (one - other).abs() < TOLERANCE,
            _ => one == other,
        },
    }
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/rule_cases")
}

fn table() -> Vec<Case> {
    let text = std::fs::read_to_string(folder().join("README.md")).unwrap();
    let rows = text.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| case "));
    rows.map(|line| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [name, _, expected] = cells[..] else { panic!("not a row of three cells: {line}") };
        let expected = expected.split("`, ").map(|event| {
            let must_not = event.starts_with("no ");
            let text = event.trim_start_matches("no ").trim_matches('`').to_owned();
            let mut words = text.split_whitespace();
            let kind = words.next().unwrap().to_owned();
            let fields = words.map(|word| {
                let (name, value) = word.split_once('=').unwrap();
                (name.to_owned(), value.to_owned())
            });
            (!must_not, Pattern { kind, fields: fields.collect(), text })
        });
        Case { name: name.to_owned(), expected: expected.collect() }
    })
    .collect()
}

fn play(name: &str) {
    let case = table().into_iter().find(|case| case.name == name).unwrap();
    let scenario = Scenario::load(folder().join(format!("{name}.ron"))).unwrap_or_else(|error| panic!("{error}"));
    let mut app = headless_app();
    app.start_match(&scenario).unwrap_or_else(|error| panic!("{error}"));
    let mut events: Vec<(u64, Value)> = Vec::new();
    while app.cycle() < scenario.last_cycle().unwrap() && !app.is_finished() {
        app.run_cycles(1);
        let cycle = app.cycle();
        events.extend(app.events().iter().map(|event| (cycle, serde_json::to_value(event).unwrap())));
    }
    let broken = events.iter().find(|(_, event)| event["kind"] == "invariant_broken");
    assert!(broken.is_none(), "{broken:?}");
    for (must, pattern) in &case.expected {
        let found = events.iter().find(|(_, event)| pattern.matches(event));
        assert!(
            found.is_some() == *must,
            "`{}` {}\n{}",
            pattern.text,
            if *must { "did not happen" } else { "happened" },
            events.iter().map(|(cycle, event)| format!("{cycle}: {event}\n")).collect::<String>()
        );
    }
}
