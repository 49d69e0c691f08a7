//! Logs of simulated robots whose figures are known: they come back, within their intervals, and a match plays with them.

use crate::support::{blue, match_of, naoisis, text};
use bevy::prelude::*;
use core::fmt::Write;
use mcap::records::MessageHeader;
use naoisis::cycle::CycleClock;
use naoisis::geometry::Pose;
use naoisis::internal::calibration::{RobotLog, calibrate};
use naoisis::prelude::*;
use naoisis::robot::motion::ExecutedStep;
use naoisis::scenario::RobotModel;
use naoisis::sensing::odometry::Odometry;
use naoisis::sensing::vision::Percepts;
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;

/// What the robots of the log are like, in a scenario's words, and by path.
const MOTION: &str = r#""motion": { "max_linear_mps": 0.25, "gait": { "slip": { "scale": 0.9, "scale_sd": 0.05, "drift_sd_degpm": 4.0,
    "error": { "translation_sd_m": 0.03, "heading_per_metre_sd_deg": 2.0, "rotation_sd_deg": 5.0 } } } },
    "odometry": { "noise": { "translation_sd_m": 0.05, "heading_per_metre_sd_deg": 3.0, "rotation_sd_deg": 6.0, "translation_scale": 1.05 } }"#;
const WALKED: [(&str, f64); 10] = [
    ("motion.gait.slip.scale", 0.9),
    ("motion.gait.slip.scale_sd", 0.05),
    ("motion.gait.slip.drift_sd_degpm", 4.0),
    ("motion.gait.slip.error.translation_sd_m", 0.03),
    ("motion.gait.slip.error.heading_per_metre_sd_deg", 2.0),
    ("motion.gait.slip.error.rotation_sd_deg", 5.0),
    ("odometry.noise.translation_sd_m", 0.05),
    ("odometry.noise.heading_per_metre_sd_deg", 3.0),
    ("odometry.noise.rotation_sd_deg", 6.0),
    ("odometry.noise.translation_scale", 1.05),
];
const VISION: &str = r#""vision": { "noise": { "preset": "none", "ball": { "pixel_sd": 1.0, "miss_probability": 0.15,
    "false_positive_probability": 0.0, "max_distance_m": null, "falloff": { "half_distance_m": 4.0, "exponent": 5.0 } },
    "gaze": { "bias_sd_deg": 1.2, "standing_sd_deg": 0.6, "walking_sd_deg": 1.8, "correlation_s": 0.3 } } }"#;
const SEEN: [(&str, f64); 7] = [
    ("vision.noise.gaze.bias_sd_deg", 1.2),
    ("vision.noise.gaze.standing_sd_deg", 0.6),
    ("vision.noise.gaze.walking_sd_deg", 1.8),
    ("vision.noise.gaze.correlation_s", 0.3),
    ("vision.noise.ball.miss_probability", 0.15),
    ("vision.noise.ball.falloff.half_distance_m", 4.0),
    ("vision.noise.ball.falloff.exponent", 5.0),
];
const KICKED: [(&str, f64); 3] =
    [("kicks.right_straight.max_distance_m", 5.0), ("kicks.direction_sd_deg", 6.0), ("kicks.speed_sd", 0.05)];

/// Walks of twelve robots: each goes straight for four seconds, stands for one, turns on the spot for two and stands for one, ten times.
fn walks() -> String {
    let mut table = "robot,true_forward_m,true_left_m,true_turn_deg,odometry_forward_m,odometry_left_m,odometry_turn_deg,planned_forward_m,planned_left_m,planned_turn_deg\n".to_owned();
    for seed in 1..=12 {
        let entries: Vec<String> = (0..10)
            .flat_map(|lap| {
                let start = 8 * lap;
                let [until, turn, end] = [start + 4, start + 5, start + 7];
                [
                    format!(r#"{{ "from_s": {start}, "until_s": {until}, "walk": [1, 0, 0] }}"#),
                    format!(r#"{{ "from_s": {turn}, "until_s": {end}, "walk": [0, 0, 100] }}"#),
                ]
            })
            .collect();
        let mut app = match_of(&format!(
            r#"{{ "seed": {seed}, "rules": "free", "ball": null, {MOTION},
                 "robots": [{{ "number": 1, "behaviour": {{ "script": [{}] }} }}] }}"#,
            entries.join(",")
        ));
        for cycles in [150, 90].repeat(10) {
            let at = |app: &App| (app.robot_pose(blue(1)).unwrap(), app.robot::<Odometry>(blue(1)).unwrap().0);
            let (pose, counted) = at(&app);
            let mut legs = Pose::default();
            let mut counted_to = counted;
            for _ in 0..cycles {
                app.run_cycles(1);
                let step = app.robot::<ExecutedStep>(blue(1)).unwrap().0;
                legs = legs.compose(Pose::new(step.dx, step.dy, step.dtheta));
                counted_to = at(&app).1;
            }
            // Odometry counts a step a cycle late: robots stand at neither end of a walk, so that one step is as good as the other.
            for (index, moved) in
                [pose.relative(at(&app).0), counted.relative(counted_to), legs].into_iter().enumerate()
            {
                let end = if index == 2 { '\n' } else { ',' };
                let start = if index == 0 { format!("{seed},") } else { String::new() };
                let (place, turn) = (moved.position, moved.heading.to_degrees());
                write!(table, "{start}{},{},{turn}{end}", place.x, place.y).unwrap();
            }
        }
    }
    table
}

/// A hundred kicks of a robot.
fn kicks() -> String {
    let mut table = "kick,start_forward_m,start_left_m,rest_forward_m,rest_left_m\n".to_owned();
    for seed in 1..=100 {
        let mut app = match_of(&format!(
            r#"{{ "seed": {seed}, "rules": "free", "field": {{ "preset": "spl2025", "length_m": 18, "width_m": 12 }},
                 "ball": {{ "preset": "spl2025", "position_m": [0.16, -0.05] }},
                 "kicks": {{ "right_straight": {{ "max_distance_m": 5.0 }}, "direction_sd_deg": 6.0, "speed_sd": 0.05 }},
                 "robots": [{{ "number": 1, "behaviour": {{ "script": [{{ "kick": {{ "type": "right_straight" }} }}] }} }}] }}"#
        ));
        app.run_cycles(30 * 10);
        let rest = app.ball().unwrap().position;
        writeln!(table, "right_straight,0.16,-0.05,{},{}", rest.x, rest.y).unwrap();
    }
    table
}

/// What twenty robots see of a ball ahead, standing and walking towards it.
fn sightings() -> String {
    let mut table = "robot,time_s,thing,true_forward_m,true_left_m,seen_forward_m,seen_left_m,motion\n".to_owned();
    for seed in 1..=20_u16 {
        for (motion, walk) in [("standing", "[0, 0, 0]"), ("walking", "[0.002, 0, 0]")] {
            // Nearer, a ball would be out of the image now and then, as the camera rocks.
            for distance in [2.5, 3.5, 4.5, 5.5, 6.5] {
                let mut app = match_of(&format!(
                    r#"{{ "seed": {seed}, "rules": "free", "field": "spl2025", "ball": {{ "position_m": [{}, 0] }}, {VISION},
                         "robots": [{{ "number": 1, "pose": [-5, 0, 0], "behaviour": {{ "script": [{{ "until_s": 100, "walk": {walk} }}] }} }}] }}"#,
                    distance - 5.0
                ));
                // Walking begins in the first cycle, which rocks the camera from the second on.
                app.run_cycles(2);
                for _ in 0..120 {
                    let ball = app.robot_pose(blue(1)).unwrap().inverse_transform_point(app.ball().unwrap().position);
                    app.run_cycles(1);
                    let seen = app.robot::<Percepts>(blue(1)).unwrap().ball.as_ref().map(|ball| ball.position_m);
                    let seen = seen.map_or(",".to_owned(), |place| format!("{},{}", place.x, place.y));
                    // Each of a robot's matches begins long after the last.
                    let time_s = app.world().resource::<CycleClock>().start_time_s() + 1000.0 * distance;
                    writeln!(table, "{seed},{time_s},ball,{},{},{seen},{motion}", ball.x, ball.y).unwrap();
                }
            }
        }
    }
    table
}

#[test]
fn the_figures_of_simulated_robots_come_back_within_their_intervals() {
    let model = RobotModel::named("nao_v6").unwrap();
    let mut log = RobotLog::default();
    for table in [walks(), kicks(), sightings()] {
        log.read(table.as_bytes()).unwrap();
    }
    let calibration = calibrate(&log, &model);
    let known: Vec<(&str, f64)> = WALKED.into_iter().chain(KICKED).chain(SEEN).collect();
    let mut outside = Vec::new();
    for &(path, real) in &known {
        let figure = calibration.figure(path).unwrap_or_else(|| panic!("{path}: {:?}", calibration.lacking));
        let estimate = figure.estimate;
        // An interval that says something.
        assert!(estimate.margin() < 0.6 * real, "{path} {estimate:?}");
        let off = (real - estimate.value).abs();
        // Of twenty intervals of 95 % one is missed on average; none by three times its half, which are six standard errors.
        assert!(off < 3.0 * estimate.margin(), "{path} {real} {estimate:?}");
        if off > estimate.margin() {
            outside.push((path, real, estimate));
        }
    }
    // More than three of twenty happen once in 60 logs; the seeds are fixed.
    assert!(outside.len() <= 3, "{outside:#?}");
}

#[test]
fn a_calibrated_model_is_a_file_that_matches_are_played_with() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("walks.csv"), walks()).unwrap();
    let output = naoisis(folder.path(), &["calibrate", "walks.csv", "--robot", "nao_v6", "--name", "mine"]);
    let (model, found) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "{found}");
    assert!(found.contains("motion.gait.slip.scale") && found.contains("not found: kicks: no kicks"), "{found}");
    fs::create_dir(folder.path().join("lab")).unwrap();
    fs::write(folder.path().join("lab/mine.ron"), &model).unwrap();
    let scenario =
        r#"(model: "mine.ron", realism: "realistic", duration_s: 2.0, rules: "free", robots: [(number: 1)])"#;
    fs::write(folder.path().join("lab/walk.ron"), scenario).unwrap();
    // The model lies beside the scenario, wherever the program runs.
    let output = naoisis(folder.path(), &["run", "lab/walk.ron", "--trace", "t.jsonl", "--quiet"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let played = Scenario::load(folder.path().join("lab/walk.ron")).unwrap();
    let slip = played.settings.motion.gait.unwrap().slip;
    assert!((slip.scale - 0.9).abs() < 0.05 && played.settings.motion.max_linear_mps == 0.242, "{slip:?}");
    // A trace needs no file besides.
    fs::remove_file(folder.path().join("lab/mine.ron")).unwrap();
    let output = naoisis(folder.path(), &["replay", "t.jsonl"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let output = naoisis(folder.path(), &["check", "lab/walk.ron"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("mine.ron` cannot be read"), "{}", text(&output.stderr));
    let output = naoisis(folder.path(), &["calibrate", "t.jsonl", "--robot", "nao_v6"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn kicks_of_which_there_are_too_few_say_nothing() {
    let mut log = RobotLog::default();
    log.read("kick,start_forward_m,start_left_m,rest_forward_m,rest_left_m\nleft_side,0.16,0.05,0.2,1.4\n".as_bytes())
        .unwrap();
    let calibration = calibrate(&log, &RobotModel::named("nao").unwrap());
    assert_eq!(calibration.figures, []);
    assert!(calibration.lacking.iter().any(|line| line.starts_with("kicks.left_side.max_distance_m: 1 full kicks")));
    assert!(!calibration.lacking.iter().any(|line| line.contains("NaN")));
}

/// Kicks of each of `names`, and walks that slip to `scale` of their steps.
fn odd_log(names: &[&str], scale: f64) -> String {
    let header = "kind,kick,start_forward_m,start_left_m,rest_forward_m,rest_left_m,true_forward_m,true_left_m,true_turn_deg,\
                  odometry_forward_m,odometry_left_m,odometry_turn_deg,planned_forward_m,planned_left_m,planned_turn_deg\n";
    let mut log = header.to_owned();
    for index in 0..12 {
        let more = 0.01 * f64::from(index % 4);
        for name in names {
            writeln!(log, "kick,{name},0.16,-0.05,{},{more},,,,,,,,,", 3.0 + more).unwrap();
        }
        writeln!(log, "walk,,,,,,{},0,{more},{},0,{more},1,0,0", scale * (1.0 + more), 1.0 + more).unwrap();
    }
    log
}

#[test]
fn what_calibrate_writes_is_accepted_whatever_the_log_and_the_name_are() {
    let folder = tempfile::tempdir().unwrap();
    let logs = [
        ("kick.csv", odd_log(&["left_straight", "power_kick", "right_strait", "2nd"], 0.9), "power_kick"),
        ("tiny.csv", odd_log(&["left_straight"], 0.01), "motion.gait.slip.scale: 0.01"),
        ("none.csv", odd_log(&["left_straight"], 1e-40), "motion.gait.slip.scale"),
        ("huge.csv", odd_log(&["left_straight"], 1000.0), "motion.gait.slip.scale"),
    ];
    for (file, log, not_found) in logs {
        fs::write(folder.path().join(file), log).unwrap();
        for name in ["mine", "\u{1b}[31mred\n", "2nd \"best\"", "é"] {
            let output = naoisis(folder.path(), &["calibrate", file, "--robot", "nao_v6", "--name", name]);
            let found = text(&output.stderr);
            assert!(output.status.success(), "{file} {name:?}: {found}");
            assert!(found.lines().any(|line| line.starts_with("not found: ") && line.contains(not_found)), "{found}");
            fs::write(folder.path().join("made.ron"), &output.stdout).unwrap();
            let made = RobotModel::find(&folder.path().join("made.ron").to_string_lossy());
            assert_eq!(made.unwrap_or_else(|error| panic!("{file} {name:?}: {error}")).name, name);
        }
    }
}

#[test]
fn a_log_without_end_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = naoisis(folder.path(), &["calibrate", "/dev/zero", "--robot", "nao"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("more than 32 MiB"), "{}", text(&output.stderr));
}

/// An MCAP file of a Booster, as `ros2 bag record` writes it: its odometry says for 20 s that it walks 1 m in each second.
fn recording() -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut file).unwrap();
    let definition = b"float32 x\nfloat32 y\nfloat32 theta";
    let schema = writer.add_schema("booster_interface/msg/Odometer", "ros2msg", definition).unwrap();
    let channel = writer.add_channel(schema, "/odometer_state", "cdr", &BTreeMap::new()).unwrap();
    for sequence in 0..1000_u32 {
        let log_time = 1_780_000_000_000_000_000 + u64::from(sequence) * 20_000_000;
        let mut data = vec![0, 1, 0, 0];
        data.extend([0.02 * sequence as f32, 0.0, 0.0].into_iter().flat_map(f32::to_le_bytes));
        let header = MessageHeader { channel_id: channel, sequence, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

#[test]
fn walks_may_name_their_times_in_a_recording_of_the_odometry() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("anna.mcap"), recording()).unwrap();
    // In 2 s the odometry counts 2 m; in truth it was 1.8 m.
    let rows: String = (0..6).map(|walk| format!("anna,{},{},1.8,0,0\n", 3 * walk, 3 * walk + 2)).collect();
    let header = "robot,start_s,end_s,true_forward_m,true_left_m,true_turn_deg\n";
    fs::write(folder.path().join("walks.csv"), format!("{header}{rows}")).unwrap();
    let calibrated = |files: &[&str]| {
        let arguments = [&["calibrate"], files, &["--robot", "booster_k1"]].concat();
        let output = naoisis(folder.path(), &arguments);
        (output.status.code(), text(&output.stderr))
    };
    for files in [["walks.csv", "anna.mcap"], ["anna.mcap", "walks.csv"]] {
        let (status, said) = calibrated(&files);
        let scale = said.lines().find(|line| line.contains("motion.gait.slip.scale ")).unwrap_or_default();
        assert!(status == Some(0) && scale.contains("0.9000"), "{said}");
    }
    let (status, said) = calibrated(&["walks.csv"]);
    assert!(status == Some(2) && said.contains("an MCAP file with the odometry"), "{said}");
    fs::write(folder.path().join("walks.csv"), format!("{header}anna,19,25,1.8,0,0\n")).unwrap();
    let (status, said) = calibrated(&["walks.csv", "anna.mcap"]);
    assert!(status == Some(2) && said.contains("line 2, column `end_s`") && said.contains("0 to 20.0 s"), "{said}");
}
