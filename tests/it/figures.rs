//! The paper's figures, drawn as their user draws them.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn draw(folder: &Path, arguments: &[&str]) -> Output {
    // As small as can be: the same figures, sooner.
    Command::new(env!("CARGO_BIN_EXE_naoisis"))
        .current_dir(folder)
        .args(["figures", "--scale", "0.1"])
        .args(arguments)
        .output()
        .unwrap()
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(Result::unwrap);
    entries.map(|entry| (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap())).collect()
}

#[test]
fn all_eight_are_drawn_the_same_on_every_run() {
    let folder = tempfile::tempdir().unwrap();
    let output = draw(folder.path(), &["--out", "once"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8_lossy(&output.stdout).lines().count(), 8);
    let once = files(&folder.path().join("once"));
    let names: Vec<&str> = once.keys().map(String::as_str).collect();
    assert_eq!(names.len(), 8);
    for (number, name) in (1..=8).zip(names) {
        assert!(name.starts_with(&format!("figure_{number}_")) && name.ends_with(".png"), "{name}");
    }
    assert!(draw(folder.path(), &["--out", "again", "--quiet"]).stdout.is_empty());
    assert!(files(&folder.path().join("again")) == once);
}

#[test]
fn nothing_is_written_over_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("figures");
    assert!(draw(folder.path(), &["--only", "4"]).status.success());
    let [path] = files(&out).keys().map(|name| out.join(name)).collect::<Vec<_>>().try_into().unwrap();
    fs::write(&path, "mine").unwrap();
    // Figure 1 is not there yet, and is not drawn either: it is all or nothing.
    let output = draw(folder.path(), &["--only", "1,4"]);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("figure_4_sonar.png") && said.contains("--force"), "{said}");
    assert_eq!(files(&out).len(), 1);
    assert_eq!(fs::read(&path).unwrap(), b"mine");
    assert!(draw(folder.path(), &["--only", "4", "--force"]).status.success());
    assert_ne!(fs::read(&path).unwrap(), b"mine");
}

#[test]
fn what_cannot_be_drawn_is_said_at_once() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    for (arguments, expected) in [
        (["--only", "9"], "9"),
        (["--scale", "0"], "0.1 to 6"),
        (["--scale", "x"], "0.1 to 6"),
        (["--out", "file"], "--out: file"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_naoisis"))
            .current_dir(folder.path())
            .arg("figures")
            .args(arguments)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(String::from_utf8_lossy(&output.stderr).contains(expected), "{arguments:?}");
    }
}
