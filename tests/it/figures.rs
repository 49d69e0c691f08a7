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
fn figures_of_another_robot_show_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let output = draw(folder.path(), &["--robot", "booster_k1", "--only", "2,4,5,7"]);
    assert!(output.status.success());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(said.lines().count(), 2, "{said}");
    assert!(said.contains("figure 4 shows what sonars hear, and the robot has none"), "{said}");
    let own = files(&folder.path().join("figures"));
    assert_eq!(own.keys().collect::<Vec<_>>(), ["figure_2_robots.png", "figure_5_kicks.png"]);
    let output = draw(folder.path(), &["--out", "nao", "--only", "2"]);
    assert!(output.status.success());
    assert_ne!(files(&folder.path().join("nao"))["figure_2_robots.png"], own["figure_2_robots.png"]);
    // Who sees nothing has the figures without cameras.
    let blind = r#"(name: "blind", description: "sees nothing", settings: (cameras: (mounts: [])), realistic: (), sources: {})"#;
    fs::write(folder.path().join("my_blind.ron"), blind).unwrap();
    let output = draw(folder.path(), &["--robot", "my_blind.ron", "--out", "blind", "--only", "2,3,7,8"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    for figure in [3, 7, 8] {
        assert!(said.contains(&format!("figure {figure} shows what a camera sees, and the robot has none")), "{said}");
    }
    assert_eq!(files(&folder.path().join("blind")).keys().collect::<Vec<_>>(), ["figure_2_robots.png"]);
    let output = draw(folder.path(), &["--robot", "boster_k1", "--out", "other"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("did you mean `booster_k1`?"));
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

#[test]
fn a_figure_without_room_for_a_robot_says_so_and_a_fixed_head_looks_once() {
    let folder = tempfile::tempdir().unwrap();
    let wide = r#"(name: "wide", description: "", settings: (body: (
        torso: (x_m: (-0.3, 0.3), half_width_m: 0.9, z_m: (0.3, 1.0)), base: (x_m: (-0.3, 0.3), half_width_m: 0.9, z_m: (0.0, 0.3)),
        waistband: (z_m: (0.5, 0.7), half_size_m: (0.31, 0.91)),
        height_m: 1.1, lying_height_m: 0.3, neck_m: (0.0, 0.0, 1.0)), sonar: (height_m: 0.5)), realistic: (), sources: {})"#;
    fs::write(folder.path().join("wide.ron"), wide).unwrap();
    let output = draw(folder.path(), &["--robot", "wide.ron", "--only", "1,4"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    assert!(said.contains("not drawn: figure 4 has no room for a robot of this size: "), "{said}");
    assert!(!said.contains("scenario:"), "{said}");
    let output = draw(folder.path(), &["--robot", "rover", "--only", "3", "--out", "rover"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
