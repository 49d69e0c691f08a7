//! The rules, case by case: `tests/rule_cases/README.md` is the table, and each case a small scenario beside it.

use bevy::reflect::{TypeInfo, Typed};
use naoisis::game::PenaltyReason;
use naoisis::prelude::*;
use naoisis::simulation::RuleRegistry;
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

/// What the referee may find, by the kind of its event and one of its fields: of a penalty, what it is for.
fn verdicts() -> Vec<(String, Option<String>)> {
    let TypeInfo::Enum(events) = MatchEvent::type_info() else { panic!("events are an enum") };
    let with_evidence = events
        .iter()
        .filter(|variant| variant.as_struct_variant().is_ok_and(|variant| variant.field_names().contains(&"evidence")));
    let mut kinds: Vec<String> = with_evidence.map(|variant| snake_case(variant.name())).collect();
    kinds.retain(|kind| kind != "penalty");
    let app = headless_app();
    let own = app.world().resource::<RuleRegistry>().names().map(str::to_owned);
    // Of what is not for something that the robot did there are no cases.
    let is_of_a_rule = |reason: &PenaltyReason| !matches!(reason, PenaltyReason::ShootOut | PenaltyReason::Manual);
    let built_in = PenaltyReason::BUILT_IN.into_iter().filter(is_of_a_rule).map(|reason| reason.name().to_owned());
    let penalties = built_in.chain(own).map(|reason| ("penalty".to_owned(), Some(reason)));
    kinds.into_iter().map(|kind| (kind, None)).chain(penalties).collect()
}

fn snake_case(name: &str) -> String {
    let separated = name.char_indices().flat_map(|(index, letter)| {
        let separator = (index > 0 && letter.is_uppercase()).then_some('_');
        separator.into_iter().chain(letter.to_lowercase())
    });
    separated.collect()
}

#[test]
fn every_verdict_has_a_case_just_inside_and_one_just_outside() {
    let table = table();
    let finds = |case: &Case, must: bool, kind: &str, reason: Option<&str>| {
        case.expected.iter().any(|(happens, pattern)| {
            let is_for = |reason| pattern.fields.iter().any(|(name, value)| name == "reason" && value == reason);
            *happens == must && pattern.kind == kind && reason.is_none_or(is_for)
        })
    };
    for (kind, reason) in verdicts() {
        let inside = table.iter().find(|case| finds(case, true, &kind, reason.as_deref()));
        let outside = |inside: &Case| {
            let same_section = table.iter().filter(|case| case.section == inside.section);
            same_section.into_iter().any(|case| finds(case, false, &kind, None))
        };
        let what = reason.map_or(kind.clone(), |reason| format!("{kind} reason={reason}"));
        assert!(
            inside.is_some_and(outside),
            "a rule needs two cases in tests/rule_cases: one in which `{what}` happens, and in the same section of its README \
             one in which no `{kind}` does"
        );
    }
}

#[test]
fn all_built_in_penalties_are_listed() {
    let TypeInfo::Enum(reasons) = PenaltyReason::type_info() else { panic!("reasons are an enum") };
    let listed = PenaltyReason::BUILT_IN.map(|reason| reason.name().to_owned());
    let names: Vec<String> = reasons.variant_names().iter().map(|name| snake_case(name)).collect();
    assert_eq!(names, [&listed[..], &["own".to_owned()]].concat());
}

/// A row of the table.
struct Case {
    name: String,
    /// The heading that it stands under.
    section: String,
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
    let mut section = "";
    let mut cases = Vec::new();
    for line in text.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            section = heading;
        }
        if !line.starts_with("| ") || line.starts_with("| case ") {
            continue;
        }
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [name, _, expected] = cells[..] else { panic!("not a row of three cells: {line}") };
        let expected = expected.split("`, ").map(pattern).collect();
        cases.push(Case { name: name.to_owned(), section: section.to_owned(), expected });
    }
    cases
}

/// An event as the table has it, and whether it must happen.
fn pattern(text: &str) -> (bool, Pattern) {
    let must_not = text.starts_with("no ");
    let text = text.trim_start_matches("no ").trim_matches('`').to_owned();
    let mut words = text.split_whitespace();
    let kind = words.next().unwrap().to_owned();
    let fields = words.map(|word| {
        let (name, value) = word.split_once('=').unwrap();
        (name.to_owned(), value.to_owned())
    });
    (!must_not, Pattern { kind, fields: fields.collect(), text })
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
