//! A program of a user's own, that has all commands: the example `own_program`, run as its user runs it.

use std::path::Path;
use std::process::{Command, Output};

use crate::support::text;

/// What comes of `own_program` with these arguments.
fn own_program(folder: &Path, arguments: &[&str]) -> Output {
    example("own_program", folder, arguments)
}

/// What comes of an example with these arguments.
fn example(name: &str, folder: &Path, arguments: &[&str]) -> Output {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(folder).args(["run", "--quiet", "--locked", "--example", name]);
    cargo.args(["--manifest-path", concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")]);
    // As the tests are built, so that there is nothing to build.
    cargo.args((!cfg!(feature = "viewer")).then_some("--no-default-features"));
    cargo.args((!cfg!(debug_assertions)).then_some("--release"));
    cargo.arg("--").args(arguments).env_remove("DISPLAY").output().unwrap()
}

#[test]
fn an_own_program_has_all_commands_with_its_team_in_them() {
    let folder = tempfile::tempdir().unwrap();
    let own = |arguments: &[&str]| {
        let output = own_program(folder.path(), arguments);
        assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
        text(&output.stdout)
    };
    let teams = own(&["list", "teams"]);
    let is_own =
        |line: &str| line.strip_prefix("rushers ").is_some_and(|words| words.trim().starts_with("Everybody rushes"));
    assert!(teams.lines().any(is_own), "{teams}");
    std::fs::write(folder.path().join("own.json"), r#"{ "duration_s": 5, "teams": { "blue": "rushers" } }"#).unwrap();
    assert_eq!(own(&["check", "own.json"]), "own.json: ok\n");
    assert!(own(&["run", "own.json", "--duration", "0.5", "--trace", "own.jsonl"]).contains("15 cycles"));
    assert!(own(&["replay", "own.jsonl"]).contains("15 cycles, 0.5 s"));
    assert!(own(&["play", "own.json", "--pink", "rushers"]).contains("150 cycles"));
    // On several threads: each match has an app of its own.
    let batch = ["batch", "own.json", "--matches", "4", "--threads", "2", "--pairs", "rushers,chasers"];
    let table = own(&batch);
    assert!(table.contains("rushers") && table.contains("4 of 4 matches"), "{table}");
    // A saved match goes on, as its behaviours are there.
    own(&["run", "own.json", "--duration", "2", "--save", "own.naoisis", "--quiet"]);
    assert!(own(&["run", "own.naoisis", "--duration", "3"]).contains("30 cycles"));
}

#[test]
fn what_is_wrong_names_what_the_own_program_has() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = "{ \"robots\": [\n{ \"behaviour\": \"rushr\" }] }";
    std::fs::write(folder.path().join("typo.json"), scenario).unwrap();
    let output = own_program(folder.path(), &["check", "typo.json"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("typo.json:2:16") && said.contains("`rusher`"), "{said}");
    let help = text(&own_program(folder.path(), &["--help"]).stdout);
    assert!(help.contains("Usage: own_program [COMMAND]"), "{help}");
}

#[test]
fn the_examples_of_an_own_rule_an_own_sensor_and_an_own_app_play_what_they_say() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["time_wasting", "robot_that_hears", "bevy_game"] {
        let output = example(name, folder.path(), &[]);
        assert!(output.status.success() && !output.stdout.is_empty(), "{name}: {}", text(&output.stderr));
    }
}

#[test]
fn an_own_log_format_is_an_option_of_run() {
    let folder = tempfile::tempdir().unwrap();
    let own = |arguments: &[&str]| example("log_format", folder.path(), arguments);
    let formats = text(&own(&["list", "logs"]).stdout);
    let line = |name: &str| formats.lines().find(|line| line.split_whitespace().next() == Some(name));
    assert!(line("ball_csv").is_some_and(|line| line.ends_with("the positions of the ball, as a table")), "{formats}");
    assert!(line("trace").is_some(), "{formats}");
    let run =
        ["run", "kick_right_straight", "--duration", "1", "--log", "ball_csv=ball.csv", "--log", "trace=all.jsonl"];
    let output = own(&run);
    assert!(text(&output.stdout).contains("the positions of the ball are in ball.csv"), "{}", text(&output.stderr));
    let table = std::fs::read_to_string(folder.path().join("ball.csv")).unwrap();
    assert_eq!((table.lines().count(), table.lines().next()), (1 + 1 + 30, Some("time_s,x_m,y_m")));
    assert_eq!(std::fs::read_to_string(folder.path().join("all.jsonl")).unwrap().lines().count(), 1 + 31 + 1);
    // It is written over no more than other outputs, nor into each other, and an unknown one is said.
    for (arguments, expected) in [
        (&run[..], "--log: ball.csv: the file exists already"),
        (
            &["run", "match3v3", "--log", "ball_csv=new", "--log", "trace=new"],
            "--log: new: --log writes this file already",
        ),
        (
            &["run", "match3v3", "--log", "ball_cvs=new"],
            "there is no log format `ball_cvs`; expected one of `ball_csv`, ",
        ),
        (&["run", "match3v3", "--log", "new.csv"], "expected the name of a format and a file"),
        (&["run", "match3v3", "--log", "ball_csv=no/such/folder"], "--log: no/such/folder: "),
    ] {
        let output = own(arguments);
        let said = text(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(expected), "{arguments:?}: {said}");
    }
    assert!(!folder.path().join("new").exists());
}
