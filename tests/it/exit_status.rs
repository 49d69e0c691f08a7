//! The exit status of every command: 0 done, 1 failed while running, 2 a wrong command line or file, and 128 and the
//! signal's number after an interrupt.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::support::{naoisis, text};

/// A folder with scenarios, right and wrong, and with what commands would not write over.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("short.json", r#"{ "duration_s": 0.1, "robots": [{}] }"#),
        ("many.json", r#"{ "robots": [{}], "duration_s": 5, "expect": ["blue.goals >= 1 in 1 % of 10000"] }"#),
        ("typo.json", r#"{ "sede": 3 }"#),
        ("team.json", r#"{ "teams": { "blue": "dragons" } }"#),
        ("there.jsonl", "there"),
    ] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

#[test]
fn the_program_says_its_name_and_version() {
    let said = |option: &str| text(&naoisis(folder().path(), &[option]).stdout);
    assert_eq!(said("--version"), format!("naoisis {}\n", env!("CARGO_PKG_VERSION")));
    assert!(said("--help").starts_with("A simulator of humanoid robot soccer"), "{}", said("--help"));
}

#[test]
fn every_command_says_by_its_status_how_it_went() {
    let folder = folder();
    let table: &[(&str, i32)] = &[
        ("--help", 0),
        ("--version", 0),
        ("fly", 2),
        ("play short.json", 0),
        ("play typo.json", 2),
        ("play match3v3 --blue dragons", 2),
        ("play short.json --record typo.json", 2),
        ("run short.json", 0),
        ("run short.json --trace t.jsonl --beliefs b.csv --mistakes m.json --save s.naoisis", 0),
        ("run s.naoisis --duration 0.2", 0),
        ("run nowhere.json", 2),
        ("run typo.json", 2),
        ("run team.json", 2),
        ("run short.json --set sede=3", 2),
        ("run short.json --duration no", 2),
        ("run short.json --trace there.jsonl", 2),
        ("run short.json --trace there.jsonl --force", 0),
        ("run short.json --trace no/folder/t.jsonl", 2),
        ("run short.json --trace short.json --force", 2),
        ("batch short.json --matches 2", 0),
        ("batch short.json --matches 0", 2),
        ("batch typo.json --matches 1", 2),
        ("batch short.json --matches 1 --set messages.loss=0,7", 2),
        ("batch short.json --matches 1 --csv typo.json", 2),
        ("replay t.jsonl", 0),
        ("replay typo.json", 2),
        ("replay nowhere.jsonl", 2),
        ("convert t.jsonl t.html", 0),
        ("convert t.jsonl t.html", 2),
        ("convert t.jsonl t.html --force", 0),
        ("convert t.jsonl t.gif", 2),
        ("convert t.jsonl no/such/u.html", 2),
        ("convert t.jsonl u.mcap --parquet no/such/folder", 2),
        ("convert typo.json u.html", 2),
        ("run short.json --html page", 2),
        ("check short.json match3v3", 0),
        ("check short.json typo.json", 2),
        ("check team.json", 2),
        ("check", 2),
        ("list teams", 0),
        ("list dragons", 2),
        ("figures --only 1 --scale 0.1", 0),
        ("figures --only 1 --scale 0.1 --out figures", 2),
        ("figures --only 9", 2),
        ("vision --scenes 1 --design simple", 0),
        ("vision --scenes 0", 2),
    ];
    for (line, status) in table {
        let output = naoisis(folder.path(), &line.split(' ').collect::<Vec<_>>());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(*status), "{line}: {said}");
        assert!(!said.contains("panicked"), "{line}: {said}");
        // What is wrong is said, and where nothing is, nothing.
        assert_eq!(said.contains("error: "), *status != 0, "{line}: {said}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_printed_or_written_fails_by_name() {
    let folder = folder();
    let full = || Stdio::from(fs::File::options().write(true).open("/dev/full").unwrap());
    for line in [
        "--help",
        "run short.json",
        "run short.json --explain --quiet",
        "run short.json --trace -",
        "batch short.json --matches 1",
        "check short.json",
        "list teams",
        "vision --scenes 1 --design simple",
        "figures --only 1 --scale 0.1 --force",
    ] {
        let output = command(folder.path(), line).stdout(full()).output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{line}: {said}");
        assert!(said.contains("standard output: No space left on device"), "{line}: {said}");
    }
    for option in ["--trace", "--beliefs", "--mistakes", "--summary"] {
        let output =
            command(folder.path(), &format!("run match3v3 --duration 20 {option} /dev/full")).output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{option}: {said}");
        assert!(said.contains("/dev/full: No space left on device"), "{option}: {said}");
    }
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_ends_a_command_without_an_error() {
    let folder = folder();
    for line in [
        "--help", "run short.json", "run match3v3 --trace -", "batch short.json --matches 1", "check short.json",
        "list teams",
    ] {
        let mut child = command(folder.path(), line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{line}: {said}");
        assert!(!said.contains("rror"), "{line}: {said}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_closes_files_and_is_told_by_the_status() {
    for (signal, status) in [("INT", 130), ("TERM", 143)] {
        let folder = folder();
        for line in [
            "run match3v3 --trace there.jsonl --force --quiet",
            "play match3v3",
            "batch match3v3 --duration 2 --matches 100000 --csv t.csv --quiet",
            "figures --scale 0.1",
            "vision --scenes 1000000",
            "check --play many.json --junit tests.xml",
        ] {
            let mut child = command(folder.path(), line).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            while !catches_interrupts(child.id()) {
                assert!(child.try_wait().unwrap().is_none(), "{line}: it ended early");
                std::thread::yield_now();
            }
            let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
            assert!(sent.success());
            assert_eq!(child.wait().unwrap().code(), Some(status), "{line}");
        }
        let trace = fs::read_to_string(folder.path().join("there.jsonl")).unwrap();
        let end: serde_json::Value = serde_json::from_str(trace.lines().last().unwrap()).unwrap();
        assert_eq!((end["type"].as_str(), end["reason"].as_str()), (Some("end"), Some("interrupted")));
        assert!(fs::read_to_string(folder.path().join("t.csv")).unwrap().ends_with('\n'));
        let names = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
        assert!(names.into_iter().all(|name| !name.to_string_lossy().ends_with(".part")));
    }
}

/// Whether a process has a handler for SIGINT: the second bit of the mask.
#[cfg(target_os = "linux")]
fn catches_interrupts(process: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 0b10 != 0)
}

#[cfg(unix)]
fn command(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_naoisis"));
    command.current_dir(folder).env_remove("DISPLAY").args(line.split(' '));
    command
}

#[cfg(unix)]
#[test]
fn a_million_variants_are_made_as_they_are_played_and_gone_on_with() {
    let folder = folder();
    let hundred: Vec<String> = (1..=100).map(|value| value.to_string()).collect();
    let sweeps = ["rules.half_s", "rules.penalty_s", "messages.delay_cycles"]
        .map(|path| format!("{path}={}", hundred.join(",")));
    let mut line = "batch match3v3 --duration 0.1 --matches 1 --csv t.csv".to_owned();
    for sweep in sweeps {
        line += &format!(" --set {sweep}");
    }
    let table = folder.path().join("t.csv");
    let rows = || fs::read_to_string(&table).unwrap_or_default().lines().count();
    let mut before = String::new();
    for more in [5, 7] {
        // More than the last one left: who finds enough at once interrupts a command that
        // does not listen yet.
        let wanted = rows() + more;
        let mut child = command(folder.path(), &line).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        while rows() < wanted {
            assert!(child.try_wait().unwrap().is_none(), "it ended early");
            std::thread::yield_now();
        }
        let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130));
        let said = text(&output.stdout);
        assert!(
            said.contains(" of 1000000 matches")
                && said.contains("messages.delay_cycles = 2; realism paper but for messages\n"),
            "{said}"
        );
        let after = fs::read_to_string(&table).unwrap();
        assert!(after.starts_with(&before) && after.lines().count() >= wanted);
        before = after;
    }
    assert!(before.lines().nth(2).unwrap().starts_with("2,1,1,1,2,duration,"), "{before}");
}
