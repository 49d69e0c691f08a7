//! A program of a user's own, that has all commands: the example `own_program`, run as its user runs it.

use std::path::Path;
use std::process::{Command, Output};

use crate::support::text;

/// What comes of `own_program` with these arguments.
fn own_program(folder: &Path, arguments: &[&str]) -> Output {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(folder).args(["run", "--quiet", "--locked", "--example", "own_program"]);
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
    assert!(own(&["list", "teams"]).contains("rushers  Everybody rushes"));
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
