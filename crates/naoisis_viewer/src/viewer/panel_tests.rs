//! Courses of events with the panels: what a user clicks on, and what comes of it.

use bevy::prelude::*;
use bevy_egui::egui::Key;
use serde_json::{Value, json};

use super::test_window::TestWindow;
use naoisis_record::record::RecordPlugin;
use naoisis_record::record::match_summary::MatchSummary;
use naoisis_record::record::summary_rows::{robot_rows, team_rows};
use naoisis_sim::interface::gather::{CurrentRecord, gather_start};
use naoisis_sim::scenario::Scenario;
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

const SHIFT: &[KeyCode] = &[KeyCode::ShiftLeft];

/// Returns a window with a match of three robots a team, paused after at least this many cycles.
fn match_after(cycles: u64) -> TestWindow {
    let scenario = r#"{ "name": "test", "teams": { "blue": "roles", "pink": "chasers" } }"#;
    let mut window = TestWindow::new(&Scenario::from_json(scenario).unwrap());
    window.press(KeyCode::Space);
    window.wait("cycles", |state| number(&state["cycle"]) >= cycles as f64);
    window.press(KeyCode::Space);
    window.wait("a pause", |state| state["paused"] == true);
    window
}

/// Returns a number; NaN, which meets no condition, for anything else.
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn assert_state(window: &mut TestWindow, expected: &[(&str, Value)]) {
    let state = window.state();
    for (field, value) in expected {
        assert_eq!(state[field], *value, "{field}");
    }
}

#[test]
fn the_controls_play_pause_step_and_change_the_speed() {
    let mut window = match_after(3);
    let cycle = number(&window.state()["cycle"]);
    window.click("⏭");
    assert_state(&mut window, &[("cycle", json!(cycle as u64 + 1)), ("paused", json!(true))]);
    window.choose("Speed", "4×");
    assert_state(&mut window, &[("speed", json!("4×"))]);
    window.click("⏪");
    assert_state(&mut window, &[("speed", json!("2×"))]);
    window.click("▶");
    assert_state(&mut window, &[("paused", json!(false))]);
    window.click("⏸");
    assert_state(&mut window, &[("paused", json!(true))]);
}

#[test]
fn overlays_are_switched_for_all_for_one_and_for_none() {
    let mut window = match_after(3);
    window.press(KeyCode::KeyO);
    let count = number(&window.state()["overlays"]) as usize;
    window.click("Trails: all robots");
    assert_state(&mut window, &[("overlays", json!(count + 1))]);
    window.click("Fields of view: pink1");
    assert_state(&mut window, &[("overlays", json!(count + 2))]);
    window.click("None");
    assert_state(&mut window, &[("overlays", json!(0))]);
    window.click("Reset");
    assert_state(&mut window, &[("overlays", json!(count))]);
    window.press(KeyCode::KeyO);
    assert!(!window.has("Reset"));
}

#[test]
fn a_command_is_found_by_typing() {
    let mut window = match_after(3);
    window.press_with(&[KeyCode::ControlLeft], KeyCode::KeyK);
    assert_state(&mut window, &[("typing", json!(true))]);
    window.type_into("Find a command", "speed 0.5");
    window.press_in_field(Key::Enter);
    let state = window.wait("half the speed", |state| state["speed"] == "0.5×");
    assert_eq!(state["shown"]["commands"], false);
    window.press_with(&[KeyCode::ControlLeft], KeyCode::KeyK);
    assert_eq!(window.state()["shown"]["commands"], true);
    window.press_in_field(Key::Escape);
    window.wait("no list of commands", |state| state["shown"]["commands"] == false);
}

#[test]
fn teams_league_models_and_scenario_are_chosen_in_the_panel_of_the_match() {
    let mut window = match_after(20);
    window.press(KeyCode::KeyM);
    window.drag_along("Messages lost", &[0.1, 0.4]);
    let lost: f32 = window.value("Messages lost").parse().unwrap();
    assert!(lost > 0.2, "{lost}");
    window.choose("Sensors", "ideal");
    assert_eq!(window.value("Sensors"), "ideal");
    window.choose("Pink", "passers");
    let state = window.state();
    assert_eq!(state["teams"]["pink"], "passers");
    assert!(number(&state["cycle"]) < 10.0, "with another team the match begins again");
    window.choose("League", "spl2010");
    assert_state(&mut window, &[("scenario", json!("spl2010"))]);
    window.choose("Realism", "ideal");
    // The league's own ball stays.
    assert!(window.value("Realism").starts_with("ideal"));
    window.choose("Robots of blue", "booster_k1");
    assert_eq!(window.value("Robots of blue"), "booster_k1");
    window.choose("Scenario", "collision_static_robot");
    assert_state(&mut window, &[("scenario", json!("collision_static_robot"))]);
}

#[test]
fn a_scenario_file_is_opened_by_its_path() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.json");
    std::fs::write(&file, r#"{ "name": "mine", "teams": { "blue": "roles", "pink": "roles" } }"#).unwrap();
    let mut window = match_after(3);
    window.press(KeyCode::KeyM);
    window.type_into("File", file.to_str().unwrap());
    assert_eq!(window.value("File"), file.to_str().unwrap());
    window.click("Open");
    window.wait("the file", |state| state["scenario"] == "mine");
}

#[test]
fn an_event_of_the_list_is_a_moment_to_go_to_and_kinds_of_events_are_hidden() {
    let mut window = match_after(40);
    let event = "Half 1 begins";
    window.click(event);
    let state = window.state();
    assert!(state["event"] == event && !state["shown_cycle"].is_null(), "{state:#}");
    window.click(event);
    assert_state(&mut window, &[("event", Value::Null)]);
    window.press(KeyCode::End);
    let count = number(&window.state()["events"][0]);
    window.click("Filter");
    window.click("List referee");
    let state = window.wait("fewer events", |state| number(&state["events"][1]) > 0.0);
    assert_eq!(number(&state["events"][0]) + number(&state["events"][1]), count);
    window.press_in_field(Key::Escape);
    assert_state(&mut window, &[("shown_cycle", Value::Null)]);
    window.click("Hidden events");
    window.wait("all events", |state| state["events"] == json!([count as u64, 0]));
    window.press(KeyCode::Comma);
    window.wait("the event before", |state| !state["shown_cycle"].is_null());
}

#[test]
fn the_timeline_is_clicked_dragged_and_left() {
    let mut window = match_after(60);
    let present = number(&window.state()["cycle"]);
    let is_near = |state: &Value, share: f64| (number(&state["shown_cycle"]) - share * present).abs() <= 0.05 * present;
    window.click_along("Timeline", 1.0 / 3.0);
    window.wait("a third", |state| is_near(state, 1.0 / 3.0));
    window.drag_along("Timeline", &[1.0 / 3.0, 0.5, 2.0 / 3.0]);
    window.wait("two thirds", |state| is_near(state, 2.0 / 3.0));
    window.click("Present");
    assert_state(&mut window, &[("shown_cycle", Value::Null), ("cycle", json!(present as u64))]);
}

#[test]
fn a_branch_is_played_shown_with_ghosts_and_left() {
    let mut window = match_after(60);
    let present = window.state()["cycle"].clone();
    window.press(KeyCode::ArrowLeft);
    window.press(KeyCode::KeyF);
    window.wait("another branch", |state| state["branches"] == json!([2, 1]));
    let ghosts = "Ghosts of The match as it was";
    window.click(ghosts);
    window.wait("ghosts", |state| state["ghosts"][0] == 0 && state["ghosts"][2] == false);
    window.press(KeyCode::KeyZ);
    window.wait("both on a pitch of their own", |state| state["ghosts"] == json!([0, 7, true]));
    window.press(KeyCode::KeyZ);
    window.wait("one pitch", |state| state["ghosts"].is_null());
    window.click(ghosts);
    window.wait("ghosts again", |state| !state["ghosts"].is_null());
    window.click(ghosts);
    window.wait("no ghosts", |state| state["ghosts"].is_null());
    window.click("The match as it was");
    window.wait("the first branch", |state| state["branches"] == json!([2, 0]));
    window.press(KeyCode::End);
    window.wait("its present", |state| state["cycle"] == present && state["shown_cycle"].is_null());
    window.press(KeyCode::KeyR);
    window.wait("the match from its start", |state| state["branches"] == json!([1, 0]));
    window.press(KeyCode::Backspace);
    window.wait("the match before", |state| state["branches"] == json!([2, 0]) && state["cycle"] == present);
}

#[test]
fn a_moment_is_repeated_many_times_and_one_of_them_is_watched() {
    let mut window = match_after(20);
    window.press(KeyCode::Digit2);
    window.press(KeyCode::Home);
    window.press(KeyCode::ArrowRight);
    window.wait("what blue2 kept in mind then", |state| state["shown_cycle"] == 1.0 && !state["behaviour"].is_null());
    window.press(KeyCode::KeyT);
    window.click("Begin");
    // Once there is one of them.
    window.click("Watch: nobody scores");
    window.wait("it", |state| state["branches"] == json!([2, 1]));
    window.click("Stop");
    window.wait("no more repetitions", |state| state["many_times"][1] == false);
}

#[test]
fn a_field_is_plotted_for_one_robot_for_all_and_removed() {
    let mut window = match_after(40);
    window.press(KeyCode::Digit2);
    window.press(KeyCode::KeyQ);
    assert_state(&mut window, &[("plots", json!([0, 0]))]);
    window.click("Add a field…");
    window.type_into("Part of a field's name", "attacks");
    window.click("attacks");
    window.wait("a curve of the past", |state| state["plots"] == json!([1, 1]));
    window.press_in_field(Key::Escape);
    assert!(!window.has("Part of a field's name"));
    window.click("Robots of player memory: attacks");
    window.click("All of them");
    window.wait("a curve for each", |state| state["plots"] == json!([1, 6]));
    window.press_in_field(Key::Escape);
    window.click("Remove player memory: attacks");
    window.wait("no plot", |state| state["plots"] == json!([0, 0]));
}

#[test]
fn lanes_lead_to_events_and_select_robots() {
    let mut window = match_after(120);
    window.press(KeyCode::Home);
    window.press(KeyCode::KeyG);
    window.wait_until_gone("The match is being read…");
    window.choose("Kind of event", "new intention");
    assert_eq!(window.value("Kind of event"), "new intention");
    window.press(KeyCode::Period);
    let first = number(&window.wait("an event", |state| number(&state["shown_cycle"]) > 0.0)["shown_cycle"]);
    window.click("Next event");
    window.wait("one after it", |state| number(&state["shown_cycle"]) > first);
    window.click("Lane of pink3");
    assert_state(&mut window, &[("selected", json!("pink3"))]);
}

#[test]
fn in_the_workspace_for_teaching_there_are_a_pen_one_robots_world_and_bookmarks() {
    let mut window = match_after(20);
    window.click("Teach");
    assert_eq!(window.state()["shown"]["workspace"], "teach");
    window.press(KeyCode::KeyU);
    assert_state(&mut window, &[("pen", json!(0))]);
    window.press(KeyCode::KeyU);
    assert_state(&mut window, &[("pen", Value::Null)]);
    window.press(KeyCode::KeyY);
    let state = window.wait("a robot's world", |state| number(&state["believed"]) >= 1.0);
    assert!(state["truth"] == false && state["selected"] == "blue1", "{state:#}");
    window.press(KeyCode::KeyK);
    assert_state(&mut window, &[("bookmarks", json!([1, 0]))]);
    window.type_into("Caption", " here");
    assert!(window.value("Caption").contains(" here"));
    window.press_in_field(Key::Escape);
    window.press(KeyCode::KeyY);
    window.wait("the truth", |state| state["truth"] == true && state["believed"] == 0);
    let kept = number(&window.state()["cycle"]);
    window.press(KeyCode::Home);
    window.wait("the start", |state| state["shown_cycle"] == 0.0 && state["bookmarks"] == json!([1, null]));
    window.press(KeyCode::KeyJ);
    window.wait("the bookmark", |state| number(&state["cycle"]) == kept && state["truth"] == false);
}

/// A match of seven seconds: blue2 kicks after one second, and scores.
const GOAL: &str = r#"{ "name": "goal", "duration_s": 7, "ball": { "position_m": [1.65, -0.05] },
    "robots": [{ "number": 2, "pose": [1.5, 0, 0], "behaviour":
                 { "script": [{ "from_s": 1.0, "kick": { "type": "right_straight", "speed": 1.0 } }] } },
               { "team": "pink", "number": 1, "pose": [2.8, 0.6, 180], "behaviour": "idle" }] }"#;

#[test]
fn a_goal_is_shown_again_the_match_summed_up_and_its_score_opens_what_decided_it() {
    let scenario = Scenario::from_json(GOAL).unwrap();
    let mut window = TestWindow::new(&scenario);
    window.press_with(SHIFT, KeyCode::KeyV);
    assert_eq!(window.state()["shown"]["workspace"], "watch");
    window.press(KeyCode::Space);
    let state =
        window.wait("the goal again", |state| !state["goal_replay"].is_null() && !state["shown_cycle"].is_null());
    assert!(state["goal_replay"].as_str().unwrap().contains("blue2"), "{state:#}");
    window.wait("the match again", |state| state["goal_replay"].is_null() && state["speed"] == "1×");
    window.wait("the summary", |state| state["summary"] == true);
    // Every report of a match has the same numbers.
    let texts = window.texts().join("|");
    let summary = summary_of(&scenario);
    for row in team_rows(&summary).into_iter().chain(robot_rows(&summary)) {
        assert!(texts.contains(&row.join("|")), "{row:?} in {texts}");
    }
    window.click("Close");
    assert_state(&mut window, &[("summary", json!(false))]);
    for _ in 0..2 {
        window.press_with(SHIFT, KeyCode::KeyV);
    }
    assert_eq!(window.state()["shown"]["workspace"], "debug");
    window.click("1 : 0");
    window.wait("chances", |state| number(&state["decided"][0]) >= 1.0 && state["decided"][1] == false);
}

/// The summary of a match that is played without a window.
fn summary_of(scenario: &Scenario) -> MatchSummary {
    let mut app = App::new();
    app.add_plugins((NaoisisPlugins, RecordPlugin));
    app.start_match(scenario).unwrap();
    gather_start(app.world_mut());
    let mut summary = MatchSummary::new(scenario);
    loop {
        summary.look(&app.world().resource::<CurrentRecord>().record);
        if scenario.last_cycle().is_some_and(|last| app.cycle() >= last) {
            return summary;
        }
        app.run_cycles(1);
    }
}

#[test]
fn panels_beside_the_pitch_leave_ball_and_robots_free_in_windows_of_several_sizes() {
    let mut window = match_after(3);
    for key in [KeyCode::KeyG, KeyCode::Digit2, KeyCode::F1] {
        window.press(key);
    }
    for panel in ["robot", "events", "lanes"] {
        assert_eq!(window.state()["shown"][panel], true, "{panel}");
    }
    for size in [Vec2::new(800.0, 600.0), Vec2::new(1280.0, 720.0), Vec2::new(960.0, 540.0)] {
        window.resize(size);
        // The camera comes to rest.
        window.frames(120);
        let state = window.state();
        let corner = |index: usize, axis: usize| number(&state["free"][index][axis]);
        let is_free = |pixel: &Value| {
            (0..2).all(|axis| corner(0, axis) < number(&pixel[axis]) && number(&pixel[axis]) < corner(1, axis))
        };
        assert!(is_free(&state["ball"]["pixel"]), "{size}: {state:#}");
        for (id, robot) in state["robots"].as_object().unwrap() {
            assert!(is_free(&robot["pixel"]), "{size}, {id}: {state:#}");
        }
    }
}

#[test]
fn what_was_done_by_hand_is_undone_and_redone() {
    let mut window = match_after(3);
    window.press(KeyCode::KeyB);
    assert_state(&mut window, &[("undo", json!([1, 0]))]);
    window.press_with(&[KeyCode::ControlLeft], KeyCode::KeyZ);
    assert_state(&mut window, &[("undo", json!([0, 1]))]);
    window.press_with(&[KeyCode::ControlLeft, KeyCode::ShiftLeft], KeyCode::KeyZ);
    assert_state(&mut window, &[("undo", json!([1, 0]))]);
}

#[test]
fn the_edge_of_a_panel_is_dragged() {
    let mut window = match_after(3);
    window.press(KeyCode::Digit2);
    let edge = |window: &mut TestWindow| number(&window.state()["free"][0][0]) as f32;
    let before = edge(&mut window);
    let grip = Vec2::new(before - 1.0, 200.0);
    window.drag(&[grip, grip - 20.0 * Vec2::X, grip - 60.0 * Vec2::X]);
    let narrower = before - edge(&mut window);
    assert!((narrower - 60.0).abs() < 6.0, "{narrower}");
}

#[test]
fn every_panel_has_room_in_small_windows() {
    let mut window = match_after(3);
    for size in [Vec2::new(240.0, 180.0), Vec2::new(800.0, 600.0)] {
        window.resize(size);
        for (key, panel) in [
            (KeyCode::KeyO, "overlays"),
            (KeyCode::KeyC, "cameras"),
            (KeyCode::KeyM, "game"),
            (KeyCode::KeyT, "many_times"),
            (KeyCode::KeyH, "help"),
        ] {
            window.press(key);
            let state = window.state();
            assert_eq!(state["shown"][panel], true, "{size}, {panel}");
            let width = number(&state["free"][1][0]) - number(&state["free"][0][0]);
            assert!(size.x < 800.0 || f64::from(size.x) * 0.3 < width, "{size}, {panel}: {state:#}");
            window.press(key);
            assert_eq!(window.state()["shown"][panel], false, "{size}, {panel}");
        }
    }
}
