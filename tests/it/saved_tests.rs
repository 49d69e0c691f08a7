//! Tests that go on from a saved match: what is played is that very moment, wherever the two files lie.

use serde_json::{Value, json};
use std::fs;
use std::path::Path;

use crate::support::{naoisis, text};

/// Blue shoots at a goal that pink keeps, and may score; everything in it is left to chance.
const SHOT: &str = r#"{ "name": "shot", "realism": "realistic", "seed": 5, "duration_s": 60,
    "ball": { "position_m": [1.9, 0.1] }, "robots": [
    { "number": 1, "pose": [1.2, 0.0, 0.0], "behaviour": "striker" },
    { "team": "pink", "number": 1, "pose": [2.8, 0.6, 180.0], "behaviour": "keeper" } ] }"#;
/// So often the moment is played on.
const TIMES: u32 = 8;

/// The match is saved in a folder, in its midst, with a test beside it.
fn saved(folder: &Path) {
    fs::write(folder.join("shot.json"), SHOT).unwrap();
    said(folder, &["run", "shot.json", "--save", "m.naoisis", "--save-at", "3", "--duration", "5", "--quiet"], 0);
    write_test(folder, "test.json", json!({}));
}

/// A test that goes on from the saved match, with these fields besides.
fn write_test(folder: &Path, name: &str, fields: Value) {
    let expectation = format!("blue.goals >= 1 within 8 s in 1 % of {TIMES}");
    let mut test = json!({ "from": "m.naoisis", "seed": 1, "duration_s": 8, "expect": [expectation] });
    test.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
    fs::write(folder.join(name), test.to_string()).unwrap();
}

/// What a command says, which ends with this status.
fn said(folder: &Path, arguments: &[&str], status: i32) -> String {
    let output = naoisis(folder, arguments);
    let said = text(&output.stdout) + &text(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said}");
    said
}

/// What came of each time, with the seeds from 1 on.
fn futures(folder: &Path, moment: &str) -> Value {
    futures_with(folder, moment, &[])
}

/// The same, with these options.
fn futures_with(folder: &Path, moment: &str, more: &[&str]) -> Value {
    let times = TIMES.to_string();
    let options = ["--times", &times, "--until", "8", "--json", "out.json", "--force", "--quiet"];
    said(folder, &[&["whatif", moment], &options[..], more].concat(), 0);
    let value: Value = serde_json::from_slice(&fs::read(folder.join("out.json")).unwrap()).unwrap();
    value["branches"].clone()
}

fn goals_of_blue(futures: &Value) -> Vec<u64> {
    futures.as_array().unwrap().iter().map(|one| one["goals"]["blue"].as_u64().unwrap()).collect()
}

#[test]
fn another_team_plays_on_from_any_moment() {
    let folder = tempfile::tempdir().unwrap();
    saved(folder.path());
    let mut test: Value = serde_json::from_slice(&fs::read(folder.path().join("test.json")).unwrap()).unwrap();
    test.as_object_mut().unwrap().remove("seed");
    fs::write(folder.path().join("test.json"), test.to_string()).unwrap();
    said(folder.path(), &["run", "shot.json", "--duration", "3", "--trace", "shot.jsonl", "--quiet"], 0);
    let others = |moment: &str| futures_with(folder.path(), moment, &["--pink", "chasers"]);
    let of_moment = others("m.naoisis");
    assert_ne!(of_moment, futures(folder.path(), "m.naoisis"));
    assert_eq!(of_moment, others("test.json"));
    assert_eq!(of_moment, others("shot.jsonl@3"));
    assert!(said(folder.path(), &["whatif", "m.naoisis", "--pink", "nobody"], 2).contains("there is no team `nobody`"));
}

#[test]
fn a_test_of_a_moment_comes_out_as_the_moment_does_many_times() {
    let folder = tempfile::tempdir().unwrap();
    saved(folder.path());
    let futures_of_moment = futures(folder.path(), "m.naoisis");
    let goals = goals_of_blue(&futures_of_moment);
    let scored = goals.iter().filter(|goals| **goals > 0).count();
    assert!(scored > 0 && scored < TIMES as usize, "chance decides nothing: {goals:?}");
    // The pair of files may lie anywhere.
    let other = folder.path().join("elsewhere");
    fs::create_dir(&other).unwrap();
    for file in ["m.naoisis", "test.json"] {
        fs::rename(folder.path().join(file), other.join(file)).unwrap();
    }
    assert_eq!(futures(folder.path(), "elsewhere/test.json"), futures_of_moment);
    let share = format!("({scored} of {TIMES})");
    let checked = said(folder.path(), &["check", "--play", "elsewhere/test.json"], 0);
    assert!(checked.contains(&share), "{checked}: {share}");
    let expectation = format!("blue.goals >= 1 within 8 s in 1 % of {TIMES}");
    let run = said(folder.path(), &["run", "elsewhere/test.json", "--expect", &expectation], 0);
    assert!(run.contains(&share), "{run}: {share}");
    said(folder.path(), &["batch", "elsewhere/test.json", "--matches", "8", "--csv", "batch.csv", "--quiet"], 0);
    let table = fs::read_to_string(folder.path().join("batch.csv")).unwrap();
    let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = rows.next().unwrap();
    let column = header.iter().position(|name| *name == "goals_blue" || *name == "blue_goals").unwrap();
    assert_eq!(rows.map(|row| row[column].parse().unwrap()).collect::<Vec<u64>>(), goals);
}

#[test]
fn another_behaviour_begins_afresh_in_the_moment_and_other_settings_hold_from_there() {
    let folder = tempfile::tempdir().unwrap();
    saved(folder.path());
    let as_it_was = futures(folder.path(), "test.json");
    write_test(folder.path(), "idle.json", json!({ "robots": [{ "team": "blue", "number": 1, "behaviour": "idle" }] }));
    assert_eq!(goals_of_blue(&futures(folder.path(), "idle.json")), [0; TIMES as usize]);
    write_test(folder.path(), "slow.json", json!({ "motion": { "max_linear_mps": 0.02 } }));
    assert_ne!(futures(folder.path(), "slow.json"), as_it_was);
    // The command line does the same, though the match lists its robots.
    let idle = said(folder.path(), &["check", "--play", "test.json", "--set", "robots[0].behaviour=idle"], 1);
    assert!(idle.contains("(0 of 8)"), "{idle}");
    let chaser = said(folder.path(), &["run", "test.json", "--blue", "chasers", "--seed", "3"], 0);
    assert!(chaser.contains("end: blue"), "{chaser}");
    let wrong = said(folder.path(), &["run", "test.json", "--blue", "nobody"], 2);
    assert!(wrong.contains("there is no team `nobody`"), "{wrong}");
}

#[test]
fn a_team_of_a_saved_match_is_exchanged_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let save = ["--save", "m.naoisis", "--save-at", "3", "--duration", "4", "--quiet"];
    said(folder.path(), &[&["run", "match3v3", "--realism", "realistic"], &save[..]].concat(), 0);
    write_test(folder.path(), "test.json", json!({ "expect": [] }));
    let trace = |name: &str, options: &[&str]| {
        said(folder.path(), &[&["run", "test.json", "--trace", name, "--quiet"], options].concat(), 0);
        fs::read_to_string(folder.path().join(name)).unwrap()
    };
    let by_option = trace("option.jsonl", &["--blue", "passers"]);
    let by_setting = trace("setting.jsonl", &["--set", "teams.blue=passers"]);
    let as_it_was = trace("was.jsonl", &[]);
    let cycles = |trace: &str| trace.lines().skip(1).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(cycles(&by_option), cycles(&by_setting));
    assert_ne!(cycles(&by_option), cycles(&as_it_was));
    // Everybody is where they were: the first line is that of the moment.
    let poses = |trace: &str| -> Vec<Value> {
        let line: Value = serde_json::from_str(trace.lines().nth(1).unwrap()).unwrap();
        assert_eq!(line["cycle"], 90);
        line["robots"].as_array().unwrap().iter().map(|robot| robot["pose"].clone()).collect()
    };
    assert_eq!(poses(&by_option), poses(&as_it_was));
    // A trace needs no other file: its match can be played again.
    fs::remove_file(folder.path().join("m.naoisis")).unwrap();
    said(folder.path(), &["whatif", "option.jsonl@5", "--times", "1", "--until", "1"], 0);
}

#[test]
fn what_cannot_be_gone_on_from_is_said_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    saved(folder.path());
    for (fields, words) in [
        (json!({ "from": "n.naoisis" }), "there is no file `n.naoisis`; expected a match that was saved"),
        (json!({ "from": "shot.json" }), "`shot.json` is no saved match"),
        (json!({ "field": "spl2025" }), "`field` cannot change in the middle of a match"),
        (json!({ "ball": { "position_m": [0, 0] } }), "`ball` is that of the saved match, which goes on as it stands"),
        (json!({ "realism": "ideal" }), "`realism` is that of the saved match"),
        (json!({ "robots": [{ "number": 1, "pose": [0, 0, 0] }] }), "`robots` is that of the saved match"),
        (json!({ "robots": [{ "number": 4 }] }), "`robots`"),
        (json!({ "messages": { "loss": 7 } }), "`loss` is 7"),
    ] {
        write_test(folder.path(), "wrong.json", fields.clone());
        let said = said(folder.path(), &["check", "wrong.json"], 2);
        assert!(said.contains(words) && said.contains("wrong.json:1:"), "{fields}: {said}");
    }
}

#[test]
fn mistakes_are_expected_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    // The ball lies out of reach of the kick.
    let kick = r#"{ "duration_s": 3, "ball": { "position_m": [1.0, 0.5] }, "robots": [{ "number": 1, "behaviour":
        { "script": [{ "from_s": 1.0, "kick": { "type": "right_straight" } }] } }], "expect": [
        "blue.mistakes >= 1 within 2 s", "blue1.kick_missed == 1", "blue.same_ball == 0", "pink.mistakes == 0",
        "blue.kick_missed == 0 within 0.5 s", "blue1.kick_missed >= 1 in 100 % of 2" ] }"#;
    fs::write(folder.path().join("kick.json"), kick).unwrap();
    let checked = said(folder.path(), &["check", "--play", "kick.json"], 0);
    assert_eq!(checked.matches("  ok   ").count(), 6, "{checked}");
    let run = said(folder.path(), &["run", "kick.json", "--expect", "blue.kick_missed == 0"], 1);
    assert!(run.contains("wrong  blue.kick_missed == 0: it was 1"), "{run}");
    // A robot that believes nothing is not right about where it is.
    let run = said(folder.path(), &["run", "kick.json", "--expect", "blue.own_pose_lost == 0"], 1);
    assert!(run.contains("wrong  blue.own_pose_lost == 0: there was nothing to measure"), "{run}");
}
