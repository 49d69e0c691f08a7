//! What commands write: nothing over what is there unless they are told to, and never over what they read.

use std::fs;
use std::path::Path;
#[cfg(unix)]
use std::{path::PathBuf, process::Command};

use crate::support::{naoisis, text};

fn folder_with_a_scenario() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("short.json"), r#"{ "duration_s": 0.1, "robots": [{}] }"#).unwrap();
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = naoisis(folder, &[&["run", "short.json", "--quiet"], arguments].concat());
    (output.status.code(), text(&output.stderr))
}

#[test]
fn every_output_that_is_there_asks_for_force() {
    let folder = folder_with_a_scenario();
    let path = |name: &str| folder.path().join(name);
    for [option, name] in [
        ["--trace", "t.jsonl"],
        ["--trace", "t.jsonl.zst"],
        ["--beliefs", "b.csv"],
        ["--mistakes", "m.json"],
        ["--summary", "s.html"],
        ["--html", "p.html"],
        ["--save", "s.naoisis"],
        ["--video", "v.mp4"],
        ["--sheet", "s.png"],
    ] {
        fs::write(path(name), "precious").unwrap();
        let (status, said) = run(folder.path(), &[option, name]);
        assert_eq!(status, Some(2), "{option}: {said}");
        let start = format!("error: {option}: {name}: the file exists already; expected another name, or --force");
        assert!(said.starts_with(&start), "{said}");
        assert_eq!(fs::read(path(name)).unwrap(), b"precious");
        let (status, said) = run(folder.path(), &[option, name, "--force"]);
        assert_eq!(status, Some(0), "{option}: {said}");
        assert_ne!(fs::read(path(name)).unwrap(), b"precious", "{option}");
    }
    // What is wrong with another option is found out before anything goes.
    fs::write(path("t.jsonl"), "precious").unwrap();
    assert_eq!(run(folder.path(), &["--trace", "t.jsonl", "--force", "--save", "s.json"]).0, Some(2));
    assert_eq!(fs::read(path("t.jsonl")).unwrap(), b"precious");
}

/// The program where no file may have more than nothing in it, which is as a full disk is.
#[cfg(unix)]
fn on_a_full_disk(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let limited = "trap '' XFSZ; ulimit -f 0; exec \"$@\"";
    let mut command = Command::new("sh");
    command.current_dir(folder).env_remove("DISPLAY").args(["-c", limited, "sh", env!("CARGO_BIN_EXE_naoisis")]);
    let output = command.args(arguments).output().unwrap();
    (output.status.code(), text(&output.stderr))
}

/// The files of the folder that have another name until they are whole.
#[cfg(unix)]
fn unfinished(folder: &Path) -> Vec<PathBuf> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files.filter(|path| path.extension().is_some_and(|extension| extension == "part")).collect()
}

#[cfg(unix)]
#[test]
fn on_a_full_disk_what_was_there_stays() {
    let folder = folder_with_a_scenario();
    for [option, name] in [
        ["--trace", "t.jsonl"],
        ["--trace", "t.jsonl.zst"],
        ["--beliefs", "b.csv"],
        ["--mistakes", "m.json"],
        ["--summary", "s.html"],
        ["--log", "trace=l.jsonl"],
        ["--html", "p.html"],
        ["--video", "v.mp4"],
        ["--save", "s.naoisis"],
        ["--sheet", "s.png"],
    ] {
        let path = folder.path().join(name.trim_start_matches("trace="));
        fs::write(&path, "precious").unwrap();
        let (status, said) = on_a_full_disk(folder.path(), &["run", "short.json", option, name, "--force", "--quiet"]);
        assert_eq!(status, Some(1), "{option}: {said}");
        assert!(said.starts_with("error: cannot "), "{option}: {said}");
        assert_eq!(fs::read(&path).unwrap(), b"precious", "{option}");
        // What grows with the match is of use even so; half a picture is not.
        let left = unfinished(folder.path());
        let grows = !["--save", "--sheet"].contains(&option);
        assert_eq!(left.len(), usize::from(grows), "{option}: {left:?}");
        for path in left {
            let name = path.file_name().unwrap().to_str().unwrap();
            assert!(said.contains("the earlier file is as it was") && said.contains(name), "{option}: {said}");
            fs::remove_file(path).unwrap();
        }
    }
    let batch = ["batch", "short.json", "--matches", "1", "--csv", "new.csv"];
    let (status, said) = on_a_full_disk(folder.path(), &batch);
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("new.csv: the table cannot be written"), "{said}");
    assert!(!folder.path().join("new.csv").exists());
}

#[cfg(unix)]
#[test]
fn a_killed_command_leaves_the_earlier_file_and_the_part_of_the_new_one() {
    let folder = folder_with_a_scenario();
    let trace = folder.path().join("t.jsonl");
    fs::write(&trace, "precious").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_naoisis"));
    command.current_dir(folder.path()).args(["run", "match3v3", "--trace", "t.jsonl", "--force", "--quiet"]);
    let mut child = command.spawn().unwrap();
    let lines = |path: &Path| fs::read_to_string(path).unwrap().lines().count();
    while unfinished(folder.path()).first().is_none_or(|path| lines(path) <= 2) {
        assert!(child.try_wait().unwrap().is_none(), "it ended early");
        std::thread::yield_now();
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(fs::read(&trace).unwrap(), b"precious");
    let left = unfinished(folder.path());
    assert_eq!(left, [folder.path().canonicalize().unwrap().join(format!("t.jsonl.{}.part", child.id()))]);
}

#[test]
fn earlier_frames_make_way_by_force_and_nothing_else_does() {
    let folder = folder_with_a_scenario();
    let (status, said) = run(folder.path(), &["--frames", "missing/frames"]);
    assert_eq!(status, Some(2));
    assert!(said.contains("--frames: missing/frames") && !folder.path().join("missing").exists(), "{said}");
    assert_eq!(run(folder.path(), &["--frames", "frames"]).0, Some(0));
    let (status, said) = run(folder.path(), &["--frames", "frames"]);
    assert_eq!(status, Some(2));
    assert!(said.contains("--frames: frames: the folder is not empty") && said.contains("--force"), "{said}");
    assert_eq!(run(folder.path(), &["--frames", "frames", "--every", "3", "--force"]).0, Some(0));
    let frames = fs::read_dir(folder.path().join("frames/field")).unwrap().count();
    assert_eq!(frames, 2, "cycles 0 and 3, and none of the earlier ones");
    fs::write(folder.path().join("frames/diary.txt"), "dear diary").unwrap();
    assert_eq!(run(folder.path(), &["--frames", "frames", "--force"]).0, Some(2));
    assert!(folder.path().join("frames/diary.txt").exists());
}

#[test]
fn a_link_to_the_scenario_is_the_scenario() {
    let folder = folder_with_a_scenario();
    let scenario = folder.path().join("short.json");
    let before = fs::read(&scenario).unwrap();
    fs::hard_link(&scenario, folder.path().join("hard.jsonl")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(&scenario, folder.path().join("soft.jsonl")).unwrap();
    for name in [
        "short.json",
        "./short.json",
        "hard.jsonl",
        #[cfg(unix)]
        "soft.jsonl",
    ] {
        for force in [&[][..], &["--force"]] {
            let (status, said) = run(folder.path(), &[&["--trace", name], force].concat());
            assert_eq!(status, Some(2), "{name}: {said}");
            assert!(said.contains("would replace short.json"), "{said}");
        }
        assert_eq!(fs::read(&scenario).unwrap(), before);
    }
    let (status, said) = run(folder.path(), &["--trace", "one.csv", "--beliefs", "./one.csv"]);
    assert_eq!(status, Some(2));
    assert!(said.contains("--beliefs: ./one.csv: --trace writes this file already"), "{said}");
}

#[test]
fn nothing_of_a_file_is_told_to_the_terminal() {
    let folder = folder_with_a_scenario();
    let scenario = r#"{ "name": "\u001b[31mred\u0007", "description": "\u009b2J", "duration_s": 0.1, "robots": [{}] }"#;
    fs::write(folder.path().join("odd.json"), scenario).unwrap();
    fs::write(folder.path().join("wrong.ron"), "(name: \"\u{1b}[2J\", ball: \"\u{1b}[31m\")").unwrap();
    for arguments in [
        &["run", "odd.json", "--explain", "--trace", "odd.jsonl"][..],
        &["replay", "odd.jsonl"],
        &["check", "odd.json", "wrong.ron", "\u{1b}[31m.json"],
        &["run", "odd.json", "--set", "teams.blue=\u{1b}[1m"],
    ] {
        let output = naoisis(folder.path(), arguments);
        let said = text(&output.stdout) + &text(&output.stderr);
        assert!(!said.is_empty() && !said.contains(['\u{1b}', '\u{7}', '\u{9b}']), "{arguments:?}: {said:?}");
    }
    let output = naoisis(folder.path(), &["run", "odd.json", "--explain"]);
    assert!(text(&output.stdout).starts_with("\\u{1b}[31mred\\u{7}. Rules naoisis"), "{}", text(&output.stdout));
}
