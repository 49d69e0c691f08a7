//! Errors are sentences, also where they are printed by their `Debug` form: by `main` and tests that return them.

use naoisis::prelude::*;
use naoisis::record::read::TraceReader;
use naoisis::scenario::{RobotModel, Setting};
use naoisis::simulation::Snapshot;
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::{headless_app, naoisis};

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] }).collect()
}

#[test]
fn no_error_has_a_debug_form_of_its_own() {
    let crates = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("crates")).unwrap();
    let mut errors = 0;
    for path in crates.flat_map(|entry| sources(&entry.unwrap().path().join("src"))) {
        let text = fs::read_to_string(&path).unwrap_or_default();
        for line in text.lines().filter(|line| line.contains("derive(") && line.contains("thiserror::Error")) {
            errors += 1;
            assert!(!line.contains("Debug"), "{}: {line}: expected `debug_as_displayed!`", path.display());
        }
    }
    assert!(errors > 40, "{errors}");
}

#[test]
fn errors_that_main_returns_are_sentences() {
    fn is_sentence(error: &impl core::error::Error) {
        assert_eq!(format!("{error:?}"), error.to_string());
    }
    let mut app = headless_app();
    is_sentence(&Scenario::named("no_such_scenario").unwrap_err());
    is_sentence(&Scenario::from_json("{ \"sede\": 1 }").unwrap_err());
    is_sentence(&"blue".parse::<RobotId>().unwrap_err());
    is_sentence(&"rules=".parse::<Setting>().unwrap_err());
    is_sentence(&RobotModel::find("robby").unwrap_err());
    is_sentence(&Snapshot::from_bytes(b"no match", app.world()).err().unwrap());
    is_sentence(&Snapshot::load(Path::new("nowhere.naoisis"), app.world()).err().unwrap());
    is_sentence(&TraceReader::open(Path::new("nowhere.jsonl")).err().unwrap());
    let scenario = Scenario::from_json(r#"{ "robots": [{ "behaviour": "nobody" }] }"#).unwrap();
    is_sentence(&app.start_match(&scenario).err().unwrap());
}

#[test]
fn no_error_repeats_a_long_argument() {
    let long = "A".repeat(100_000);
    let with = |option: &str| vec!["run".to_owned(), "match3v3".to_owned(), option.to_owned(), long.clone()];
    let options =
        ["--set", "--seed", "--realism", "--trace-fields", "--log", "--views", "--draw", "--save", "--expect"];
    let word = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).chain([long.clone()]).collect();
    let commands: [Vec<String>; 7] = [
        word(&["run"]),
        word(&["list"]),
        word(&["serve", "match3v3", "--listen"]),
        word(&["figures"]),
        word(&["realism"]),
        word(&["challenge"]),
        word(&[]),
    ];
    let folder = tempfile::tempdir().unwrap();
    for command in options.map(with).into_iter().chain(commands) {
        let words: Vec<&str> = command.iter().map(String::as_str).collect();
        let output = naoisis(folder.path(), &words);
        let said = output.stderr.len() + output.stdout.len();
        assert!(!output.status.success() && said < 6_000, "{:?}: {said} bytes", &words[..words.len() - 1]);
    }
}
