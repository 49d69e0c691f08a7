//! Robots from their descriptions, and cameras from their calibrations, from the command line to a match.

use bevy::math::Vec2;
use naoisis::internal::description::{ImportOptions, import};
use naoisis::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::{blue, match_of, naoisis, text};

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/descriptions").join(name)
}

#[test]
fn a_description_plays_after_two_commands() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let output = naoisis(folder.path(), arguments);
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let description = sample("t1.urdf");
    let description = description.to_str().unwrap();
    let calibration =
        "width: 640\nheight: 480\nk: [605, 0, 331.5, 0, 611, 247.5, 0, 0, 1]\nd: [0.1, -0.2, 0.001, 0.002, 0]\n";
    fs::write(folder.path().join("head.yaml"), calibration).unwrap();
    let imported = run(&["robot", "import", description, "--camera-info", "head.yaml", "--name", "ours"]);
    assert_eq!(imported.0, Some(0), "{}", imported.2);
    for words in
        ["t1.urdf:11, joint aahead_pitch_joint", "to be measured:", "naoisis run match3v3 --set model=./ours.ron"]
    {
        assert!(imported.1.contains(words), "{words}: {}", imported.1);
    }
    assert!(folder.path().join("ours.png").is_file());
    let played =
        run(&["run", "match3v3", "--set", "model=./ours.ron", "--set", "realism=realistic", "--duration", "2"]);
    assert_eq!(played.0, Some(0), "{}", played.2);
    assert!(played.1.contains("2.0 s"), "{}", played.1);
    // A second time nothing is replaced without a word.
    let again = run(&["robot", "import", description, "--name", "ours"]);
    assert!(again.0 == Some(2) && again.2.contains("the file exists already"), "{}", again.2);
    assert_eq!(run(&["robot", "import", description, "--name", "ours", "--force"]).0, Some(0));
    let unknown = run(&["robot", "import", description, "--head-yaw", "neck"]);
    assert!(unknown.0 == Some(2) && unknown.2.contains("there is no joint `neck`"), "{}", unknown.2);
    let angle = run(&["robot", "import", description, "--stand", "left_knee_pitch_joint=bent"]);
    assert!(angle.0 == Some(2) && angle.2.contains("left_knee=0.5"), "{}", angle.2);
    let beyond = run(&["robot", "import", description, "--stand", "left_knee_pitch_joint=9"]);
    assert!(beyond.0 == Some(2) && beyond.2.contains("cannot stand at 9 rad; its limits are"), "{}", beyond.2);
}

#[test]
fn both_kinds_of_descriptions_make_models_that_play() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["t1.urdf", "k1.xml"] {
        let path = folder.path().join("robot.ron");
        fs::write(&path, import(&sample(name), &ImportOptions::default()).unwrap().text).unwrap();
        let mut app = match_of(&format!(
            r#"{{ "model": {path:?}, "realism": "realistic", "rules": "free", "ball": {{ "position_m": [0.3, 0.0] }},
                 "robots": [{{ "number": 1, "pose": [-1, 0.2, 0], "behaviour": "striker" }}] }}"#
        ));
        let kicked =
            app.run_until(1500, |app| app.events().iter().any(|event| matches!(event, MatchEvent::Kick { .. })));
        assert!(kicked, "{name} does not kick");
    }
}

#[test]
fn vision_and_images_have_the_calibrated_camera() {
    // A robot with its lens at (0.05, 0, 0.5), straight ahead, without noise: the ball's middle is 2 m ahead, 0.4 m to the left and
    // 0.45 m below the lens: x = -0.2, y = 0.225, r² = 0.090625, the factor 1.0074199. By the formula of OpenCV,
    // x' = -0.201484 - 0.00009 + 0.00034125 = -0.2012327, y' = 0.2266695 + 0.000191875 - 0.00018 = 0.2266814.
    let scene = r#"{ "rules": "free", "duration_s": 1, "ball": { "position_m": [2.05, 0.4], "radius_m": 0.05 }, "vision": { "noise": "none" },
        "head": { "yaw_deg": [0, 0], "pitch_deg": [0, 0], "max_degps": 0 },
        "robots": [{ "number": 1, "pose": [0, 0, 0], "behaviour": "idle" }],
        "cameras": { "width": 640, "height": 480, "mounts": [{ "name": "head", "position_m": [0.05, 0, 0.5] }],
            "intrinsics": { "fx": 605.0, "fy": 611.0, "cx": 331.5, "cy": 247.5, "distortion": [0.1, -0.2, 0.001, 0.002, 0.0] } } }"#;
    let mut app = match_of(scene);
    app.run_cycles(2);
    let ball = app.robot::<Percepts>(blue(1)).unwrap().ball.unwrap();
    // Pixels are counted from the outer corner of the image, those of calibrations from the middle of the first pixel.
    let expected = Vec2::new(605.0 * -0.201_232_7 + 332.0, 611.0 * 0.226_681_4 + 248.0);
    assert!(ball.pixel.distance(expected) < 0.01, "{} {expected}", ball.pixel);
    assert!(ball.position_m.distance(Vec2::new(2.05, 0.4)) < 1e-3, "{}", ball.position_m);
    // By images.
    let mut app = match_of(&scene.replace(r#""noise": "none""#, r#""source": "image""#));
    app.run_cycles(2);
    let ball = app.robot::<Percepts>(blue(1)).unwrap().ball.unwrap();
    assert!(ball.pixel.distance(expected) < 1.0, "{} {expected}", ball.pixel);
    assert!(ball.position_m.distance(Vec2::new(2.05, 0.4)) < 0.05, "{}", ball.position_m);
}

#[test]
fn lenses_that_cannot_be_are_refused() {
    let error = |cameras: &str| {
        let text = format!(r#"{{ "cameras": {cameras}, "robots": [{{}}] }}"#);
        Scenario::from_json(&text).unwrap_err().to_string()
    };
    let intrinsics = r#""intrinsics": { "fx": 605, "fy": 611, "cx": 319.5, "cy": 239.5, "distortion": DISTORTION }"#;
    let with = |distortion: &str| {
        format!(r#"{{ "width": 640, "height": 480, {} }}"#, intrinsics.replace("DISTORTION", distortion))
    };
    Scenario::from_json(&format!(r#"{{ "cameras": {}, "robots": [{{}}] }}"#, with("[0.1, -0.2]"))).unwrap();
    assert!(error(&with("[-0.9, 0.0]")).contains("the distortion cannot be inverted within the image"));
    assert!(error(&with("[0.1]")).contains("1 numbers of distortion; expected [k1, k2]"));
    let both = with("[0.1, 0.0]").replace(r#""width""#, r#""lens": { "distortion": [0.1, 0.0] }, "width""#);
    assert!(error(&both).contains("`intrinsics` has the distortion already"), "{}", error(&both));
    let wide = r#"{ "intrinsics": { "fx": 3, "fy": 3, "cx": 160, "cy": 120 } }"#;
    assert!(error(wide).contains("slopes of up to"), "{}", error(wide));
    let lacking = r#"{ "intrinsics": { "fx": 300, "fy": 300, "cx": 160 } }"#;
    assert!(error(lacking).contains("cy"), "{}", error(lacking));
}
