//! Whole matches beside real ones: from the command line, through logs of the league's GameController, and the figures that must hold.

use bevy::prelude::*;
use naoisis::game::{GameState, Rules};
use naoisis::interface::gather::CurrentRecord;
use naoisis::internal::match_realism::{Comparison, Mark, MatchMeasures, MatchMeter, RealFigures, play_matches};
use naoisis::prelude::*;
use naoisis::record::RecordPlugin;
use naoisis::record::game_controller_log::{GameControllerLog, GameControllerLogRecorder};
use naoisis::record::recorder::{self, EndReason};
use serde_json::{Value, json};
use std::fs;
use std::sync::atomic::AtomicBool;

use crate::support::{headless_app, naoisis, text};

#[test]
fn matches_are_compared_with_the_figures_of_ones_own_first() {
    let folder = tempfile::tempdir().unwrap();
    let own = r#"(name: "my cup", year: "2026", figures: { "kicks": (value: 100, low: 90, high: 110, n: 3, of: "matches", source: "my own count") })"#;
    fs::write(folder.path().join("own.ron"), own).unwrap();
    let arguments = [
        "realism", "--match", "--matches", "2", "--set", "duration_s=60", "--set", "rules.standby_s=0", "--real",
        "own.ron", "--json", "rows.json",
    ];
    let output = naoisis(folder.path(), &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let words = text(&output.stdout);
    assert!(
        words.starts_with(
            "spl2025, passers (blue) against roles (pink), realistic, handicaps up to 0.865: 2 matches, seeds 1 to 2\n"
        ),
        "{words}"
    );
    assert!(words.contains("2026, 3 matches: my own count") && words.contains("RoboCup-SPL/Ratings"), "{words}");
    let rows: Value = serde_json::from_slice(&fs::read(folder.path().join("rows.json")).unwrap()).unwrap();
    let row = |key: &str| rows["rows"].as_array().unwrap().iter().find(|row| row["key"] == key).unwrap().clone();
    assert_eq!((row("kicks")["mark"].clone(), row("kicks")["real"]["name"].clone()), ("hard".into(), "my cup".into()));
    assert_eq!(
        (row("falls_per_km")["mark"].clone(), row("walked")["mark"].clone()),
        ("derived".into(), "unknown".into())
    );
    assert!(row("walked")["estimate"]["value"].as_f64().unwrap() > 0.3, "{}", row("walked"));
    // Nothing is written over unasked.
    assert_eq!(naoisis(folder.path(), &arguments).status.code(), Some(2));
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("wrong.ron"),
        r#"(name: "", year: "", figures: { "gaols": (value: 1, source: "s") })"#,
    )
    .unwrap();
    fs::write(folder.path().join("no_log.yaml"), "goals: 3\n").unwrap();
    for (arguments, words) in [
        (&["--match", "spl2052"][..], "spl2052"),
        (&["--matches", "3"], "--match"),
        (&["--match", "--real", "wrong.ron"], "there is no quantity `gaols`"),
        (&["--match", "--blue", "nobody"], "there is no team `nobody`"),
        (&["--match", "--pink", "exec:python3 team.py"], "programs take no part here"),
        (&["--match", "--robot", "nao"], "cannot be used with"),
        (&["--logs", "no_log.yaml"], "no_log.yaml:1: "),
        (&["--logs", "."], "no_log.yaml:1: "),
        (&["--write-real", "a.ron"], "--logs"),
        (&["--match", "--spread", "1"], "expected a number from 0 to 0.9"),
        (&["--blue", "roles"], "expected --match beside them"),
    ] {
        let output = naoisis(folder.path(), &[&["realism"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output.stderr));
        assert!(text(&output.stderr).contains(words), "{arguments:?}: {}", text(&output.stderr));
    }
    let explained = naoisis(folder.path(), &["realism", "--explain"]);
    assert!(explained.status.success() && text(&explained.stdout).lines().count() > 60);
}

#[test]
fn the_log_of_a_match_is_counted_as_the_match_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("match.yaml");
    let scenario = Scenario::named("spl2025").unwrap();
    let rules = Rules { half_s: 25.0, ready_s: 4.0, standby_s: 2.0, shoot_out: false, ..scenario.rules.clone() };
    let scenario = Scenario { rules, seed: 2, ..scenario };
    let mut app = headless_app();
    app.add_plugins(RecordPlugin).start_match(&scenario).unwrap();
    recorder::start(app.world_mut(), vec![Box::new(GameControllerLogRecorder::create(&path).unwrap())]);
    let mut meter = MatchMeter::new(&scenario);
    loop {
        let record = &app.world().resource::<CurrentRecord>().record;
        meter.look(record);
        if record.game.state == GameState::Finished {
            break;
        }
        app.run_cycles(1);
    }
    for said in recorder::finish(app.world_mut(), EndReason::FinalWhistle) {
        said.unwrap();
    }
    let counted = meter.finish();
    let log = GameControllerLog::read(&path).unwrap();
    let read = MatchMeasures::of_counts(&log.counts, Some(log.messages));
    assert!(log.is_complete && counted.play_s > 30.0, "{counted:?}");
    assert_eq!((read.goals, read.goals_in_first_half), (counted.goals, counted.goals_in_first_half));
    assert_eq!((&read.penalties, &read.set_plays), (&counted.penalties, &counted.set_plays));
    assert!((read.play_s - counted.play_s).abs() < 0.2 && (read.game_s - counted.game_s).abs() < 0.2);
    // A robot is there from its first status message on.
    assert!((read.robot_s - counted.robot_s).abs() < 3.0 && (read.active_s - counted.active_s).abs() < 30.0);
    let [of_log, sent] = [&read, &counted].map(|measures| measures.messages.unwrap());
    for team in Team::BOTH {
        // In the cycle in which a state begins, a message comes before it in the log.
        assert!(of_log[team].abs_diff(sent[team]) <= 4 && sent[team] > 20, "{of_log:?} {sent:?}");
    }
    // A person counts it, and compares with it.
    let output = naoisis(folder.path(), &["realism", "--logs", ".", "--write-real", "real.ron"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("spl2025: team 1 against team 2, "), "{}", text(&output.stdout));
    let figures = RealFigures::read(&folder.path().join("real.ron")).unwrap();
    assert_eq!(figures[0].figures["goals"].value, f64::from(counted.all_goals()));
    assert!(figures[0].scenarios.is_empty(), "they are compared with everything");
    assert_eq!(figures[0].year, "no date", "a simulated match has no date");
    let output = naoisis(
        folder.path(),
        &["realism", "--logs", "match.yaml", "--json", "rows.json", "--csv", "rows.csv", "--quiet"],
    );
    assert!(output.status.success() && output.stdout.is_empty(), "{}", text(&output.stderr));
    let rows: Value = serde_json::from_str(&fs::read_to_string(folder.path().join("rows.json")).unwrap()).unwrap();
    let goals = rows["rows"].as_array().unwrap().iter().find(|row| row["key"] == "goals").unwrap();
    assert_eq!(goals["estimate"]["value"], json!(f64::from(counted.all_goals())));
    assert!(fs::read_to_string(folder.path().join("rows.csv")).unwrap().contains("goals,"));
    // With a scenario, whose name is not that of its file, they are compared with it alone.
    fs::write(
        folder.path().join("cup.json"),
        r#"{ "name": "our cup", "league": "spl2010", "teams": { "blue": "passers", "pink": "roles" },
            "rules": { "half_s": 2, "shoot_out": false } }"#,
    )
    .unwrap();
    let arguments = ["--match", "cup.json", "--matches", "1", "--logs", "match.yaml", "--write-real", "cup.ron"];
    let output = naoisis(folder.path(), &[&["realism"], &arguments[..]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(RealFigures::read(&folder.path().join("cup.ron")).unwrap()[0].scenarios, ["our cup"]);
    // Logs of two competitions are told apart by a note.
    let log = fs::read_to_string(&path).unwrap();
    fs::write(folder.path().join("other.yaml"), log.replace("spl2025", "another")).unwrap();
    let output = naoisis(folder.path(), &["realism", "--logs", "."]);
    assert!(text(&output.stderr).contains("several competitions are counted together: another, spl2025"));
}

/// The rows that are off beside a figure that was counted in a primary source, and falls, in words.
fn off(scenario: &str, matches: usize) -> Vec<String> {
    let scenario = Scenario::named(scenario).unwrap();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut played = Vec::new();
    let keep = |_, measures: Result<MatchMeasures, _>| played.push(measures.unwrap());
    let real = RealFigures::built_in();
    let spread = RealFigures::spread(&real, &scenario.name);
    play_matches(&scenario, spread, matches, 1, threads, headless_app, &AtomicBool::new(false), keep);
    let rows = Comparison::of(&played, &real, &scenario.name).rows;
    let held: Vec<_> = rows.iter().filter(|row| row.mark() == Mark::Hard || row.key == "falls_per_km").collect();
    assert!(held.len() > 6, "{}", held.len());
    let off = held.iter().filter(|row| row.is_off() == Some(true));
    off.map(|row| format!("{}, {}: {:?}, real {:?}", scenario.name, row.key, row.estimate, row.real)).collect()
}

#[test]
#[cfg_attr(debug_assertions, ignore = "20 whole matches: .ci/statistics")]
fn figures_of_2010_are_those_of_real_matches() {
    let off = off("spl2010", 20);
    assert!(off.is_empty(), "these are off:\n{}", off.join("\n"));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "20 whole matches: .ci/statistics")]
fn figures_of_2025_are_those_of_real_matches() {
    let off = off("spl2025", 20);
    assert!(off.is_empty(), "these are off:\n{}", off.join("\n"));
}
