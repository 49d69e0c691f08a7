//! `naoisis dataset` as its users meet it: wrong words and files, and a small data set.

use std::fs;

use crate::support::{naoisis, text};

#[test]
fn what_is_wrong_is_said_with_what_was_expected() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("typo.ron", "(\n  turf: (heu_deg: (80, 90)),\n)\n");
    write("range.json", r#"{ "lines": { "width_m": [0.2, 0.1] } }"#);
    write("a_file", "");
    fs::create_dir(folder.path().join("mine")).unwrap();
    write("mine/diary.txt", "");
    let cases: [(&[&str], &str); 12] = [
        (&["--images", "0"], "--images"),
        (&["--images", "2", "--format", "png"], "`coco`, `yolo` or `webdataset`"),
        (&["--images", "2", "--names", "spl"], "`hulks`"),
        (&["--images", "2", "--size", "640"], "such as 640x480"),
        (&["--images", "2", "--robot", "noa"], "did you mean `nao`"),
        (&["--images", "2", "--looks", "nowhere.ron"], "nowhere.ron"),
        (&["--images", "2", "--looks", "typo.ron"], "typo.ron:2:10"),
        (&["--images", "2", "--looks", "range.json"], "`lines.width_m`"),
        (&["--images", "2", "--set", "ball.radius=1"], "ball"),
        (&["--images", "2", "--out", "a/b"], "there is no folder a"),
        (&["--images", "2", "--out", "a_file"], "a_file"),
        (&["--images", "2", "--out", "mine", "--force"], "no data set is in it"),
    ];
    for (arguments, expected) in cases {
        let out: &[&str] = if arguments.contains(&"--out") { &[] } else { &["--out", "new"] };
        let output = naoisis(folder.path(), &[&["dataset", "match3v3", "--quiet"], out, arguments].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(expected), "{arguments:?}: {said}");
        assert!(!folder.path().join("new").exists() && folder.path().join("mine/diary.txt").exists());
    }
}

#[test]
fn a_league_is_enough_and_a_second_call_finds_all_there() {
    let folder = tempfile::tempdir().unwrap();
    let looks = r#"{ "scenes": { "first_s": [0.1, 0.2], "gap_s": [0.1, 0.2] } }"#;
    fs::write(folder.path().join("quick.json"), looks).unwrap();
    let command = [
        "dataset", "hsl2026_small_foundation", "--out", "set", "--images", "2", "--size", "64x48", "--looks",
        "quick.json",
    ];
    let first = naoisis(folder.path(), &command);
    assert!(first.status.success() && text(&first.stdout).starts_with("2 images in set, 2 of them in"), "{first:?}");
    let again = naoisis(folder.path(), &command);
    assert_eq!(text(&again.stdout), "set is complete: 2 images\n");
    let other = naoisis(folder.path(), &[&command[..], &["--seed", "5"]].concat());
    assert_eq!(other.status.code(), Some(2));
    assert!(text(&other.stderr).contains("other settings (seed)"), "{}", text(&other.stderr));
}
