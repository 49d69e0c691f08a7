//! Batches of matches.

use bevy::prelude::*;
use naoisis::batch::{Batch, MatchOutcome, run_batch};
use naoisis::prelude::*;
use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use crate::support::{headless_app, naoisis, text};

#[test]
fn a_match_that_panics_or_cannot_start_is_a_row_and_the_others_go_on() {
    #[derive(Component, Default)]
    struct Careless;

    fn stumbles(clock: Res<CycleClock>, robots: Query<&WalkCommand, With<Careless>>) {
        assert!(clock.cycle < 10 || robots.is_empty(), "stumbled over its own feet");
    }
    let careless_simulator = || {
        let mut app = headless_app();
        app.add_behaviour::<Careless, _>("careless", stumbles);
        app
    };
    let scenario = |behaviour: &str| {
        let json = format!(r#"{{ "duration_s": 1, "robots": [{{ "behaviour": "{behaviour}" }}] }}"#);
        Scenario::from_json(&json).unwrap()
    };
    let variants = ["careless", "idle", "unknown"].map(scenario).to_vec();
    let batch = Batch { variants, matches: 1, first_seed: 1, threads: 2 };
    let mut rows = Vec::new();
    run_batch(&batch, 0, careless_simulator, &AtomicBool::new(false), |row| rows.push(row));
    let outcomes: Vec<MatchOutcome> = rows.iter().map(|row| row.outcome).collect();
    assert_eq!(outcomes, [MatchOutcome::Panicked, MatchOutcome::Duration, MatchOutcome::Refused]);
    assert!(rows[0].note.contains("stumbled over its own feet"), "{}", rows[0].note);
    assert!(rows[2].note.contains("there is no behaviour `unknown`"), "{}", rows[2].note);
}

#[test]
fn a_merged_table_is_never_written_over_a_part() {
    let folder = tempfile::tempdir().unwrap();
    let batch = |more: &[&str]| {
        let arguments = [&["batch", "match3v3", "--matches", "2", "--duration", "1", "--quiet"], more].concat();
        naoisis(folder.path(), &arguments)
    };
    for part in ["1/2", "2/2"] {
        assert!(batch(&["--shard", part, "--csv", &format!("part{}.csv", &part[..1])]).status.success());
    }
    let before = fs::read(folder.path().join("part1.csv")).unwrap();
    for output in ["part1.csv", "./part1.csv", "part2.csv"] {
        let merged = batch(&["--csv", output, "--merge", "part1.csv", "part2.csv"]);
        let said = text(&merged.stderr);
        assert_eq!(merged.status.code(), Some(2), "{said}");
        assert!(said.contains("which the command reads"), "{said}");
        assert_eq!(fs::read(folder.path().join("part1.csv")).unwrap(), before);
    }
    assert!(batch(&["--csv", "all.csv", "--merge", "part1.csv", "part2.csv"]).status.success());
}

const WITH_MISTAKES: [&str; 11] = [
    "batch", "match3v3", "--matches", "4", "--duration", "15", "--csv", "rows.csv", "--mistakes", "mistakes.csv",
    "--quiet",
];

fn tables(folder: &Path) -> [Vec<u8>; 2] {
    ["rows.csv", "mistakes.csv"].map(|name| fs::read(folder.join(name)).unwrap())
}

#[test]
fn a_batch_whose_table_of_mistakes_lost_its_end_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    assert!(naoisis(folder.path(), &WITH_MISTAKES).status.success());
    let whole = tables(folder.path());
    let last_row = whole[1].iter().rev().skip(1).position(|byte| *byte == b'\n').unwrap() + 1;
    for lost in [1, 30, last_row, whole[1].len() / 2, whole[1].len()] {
        let cut = whole[1].len() - lost;
        fs::write(folder.path().join("mistakes.csv"), &whole[1][..cut]).unwrap();
        let output = naoisis(folder.path(), &WITH_MISTAKES);
        let said = text(&output.stderr);
        assert!(output.status.success() && said.contains("mistakes.csv lost its end"), "{said}");
        assert!(tables(folder.path()) == whole, "{lost}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_batch_goes_on_after_a_full_disk() {
    let folder = tempfile::tempdir().unwrap();
    assert!(naoisis(folder.path(), &WITH_MISTAKES).status.success());
    let whole = tables(folder.path());
    let mut failed = 0;
    // No file may have more than so many blocks of 512 bytes.
    for blocks in 1..=3 {
        let folder = tempfile::tempdir().unwrap();
        let limited = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\"");
        let mut command = std::process::Command::new("sh");
        command.current_dir(folder.path()).args(["-c", &limited, "sh", env!("CARGO_BIN_EXE_naoisis")]);
        let output = command.args(WITH_MISTAKES).output().unwrap();
        failed += usize::from(!output.status.success());
        let output = naoisis(folder.path(), &WITH_MISTAKES);
        assert!(output.status.success(), "{blocks} blocks: {}", text(&output.stderr));
        assert!(tables(folder.path()) == whole, "{blocks} blocks");
    }
    assert!(failed >= 2, "{failed}");
}
