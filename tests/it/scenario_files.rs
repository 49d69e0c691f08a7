//! Scenario files: what loads, and how.

use bevy::math::Vec2;
use naoisis::game::{BallOutRestart, Rules};
use naoisis::geometry::{Pose, to_radians};
use naoisis::kick_geometry::KickType;
use naoisis::robot::kick::KickRequest;
use naoisis::scenario::{
    BallSpec, BehaviourSpec, Format, LIBRARY, PostSpec, Scenario, ScenarioErrorKind, TeamsSpec, pitch_preset,
    rules_preset,
};
use naoisis::sensing::sonar::SonarNoise;
use proptest::prelude::*;
use std::path::Path;

#[test]
fn scenarios_are_found_by_name_and_by_path() {
    assert_eq!(Scenario::find("match3v3").unwrap().teams, Some(TeamsSpec::default()));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenarios/match7v7.ron");
    let match7v7 = Scenario::find(path.to_str().unwrap()).unwrap();
    assert_eq!((match7v7.rules.team_size, match7v7.field.length_m), (7, 9.0));
    for name in ["match4v4", "", "match3v3.json", "no/such/file.ron", "x"] {
        let error = Scenario::find(name).unwrap_err();
        assert_eq!(error.kind(), ScenarioErrorKind::NotFound, "{error}");
        assert!(error.expected().contains("naoisis list scenarios"), "{error}");
    }
    assert!(Scenario::find("match3v4").unwrap_err().message().contains("did you mean `match3v3`?"));
}

#[test]
fn an_empty_scenario_is_the_default_one() {
    for (text, format) in [("{}", Format::Json), ("()", Format::Ron), ("{}", Format::Ron), ("Scenario()", Format::Ron)]
    {
        assert_eq!(Scenario::from_text(text, format, "empty").unwrap(), Scenario::default());
    }
}

const CONTRACT: &str = r#"{
  "name": "right foot", "seed": 1,
  "cycle_s": 0.0333333333, "duration_s": 20.0,
  "field": "naoisis",
  "rules": "naoisis",
  "ball": { "position_m": [0.15, -0.05], "velocity_mps": [0.0, 0.0], "radius_m": 0.03,
            "rolling": { "exponential_per_s": 0.5 } },
  "motion": { "max_linear_mps": 0.2, "max_angular_degps": 90.0,
              "error_sd": { "dx_m": 0.0, "dy_m": 0.0, "dtheta_deg": 0.0 } },
  "kicks": { "left_straight": { "max_distance_m": 4.0 }, "right_straight": { "max_distance_m": 4.0 },
             "left_side": { "max_distance_m": 2.0 }, "right_side": { "max_distance_m": 2.0 },
             "wrong_side_speed_factor": 0.5, "wind_up_s": 0.0, "recovery_s": 1.0,
             "direction_sd_deg": 0.0, "speed_sd": 0.0 },
  "head": { "yaw_deg": [-120, 120], "pitch_deg": [-35, 30], "max_degps": 300.0 },
  "sonar": { "min_m": 0.15, "max_m": 0.75, "heading_deg": 19.48, "half_angle_deg": 18.0, "height_m": 0.40,
             "noise": { "gaussian": { "sd_m": 0.01 } }, "miss_probability": 0.0 },
  "cameras": { "render": "off", "width": 320, "height": 240, "diagonal_fov_deg": 58.0 },
  "vision": { "source": "geometric", "noise": "default" },
  "messages": { "loss": 0.0, "delay_cycles": 1 },
  "robots": [
    { "team": "blue", "number": 1, "pose": [0.0, 0.0, 0.0], "head_deg": [0.0, 0.0],
      "behaviour": { "script": [
        { "from_s": 0.0, "kick": { "type": "right_straight", "speed": 1.0 } },
        { "from_s": 2.0, "until_s": 3.0, "walk": [0.01, 0.0, 0.0] },
        { "from_s": 2.0, "head_deg": [20.0, 10.0] },
        { "from_s": 0.0, "until_s": 60.0, "say": { "ball_m": [0.1, 0.2] } } ] } },
    { "team": "pink", "number": 1, "pose": [1.0, 0.5, 180.0], "behaviour": "striker", "motion": { "max_linear_mps": 0.1 } }
  ],
  "posts": [ { "position_m": [0.4242, 0.1501], "radius_m": 0.05, "height_m": 0.8 } ]
}"#;

const NATURAL: &str = r#"
// The same, as RON is written by hand.
Scenario(
    name: "right foot", cycle_s: 0.0333333333, duration_s: Some(20.0),
    ball: (position_m: (0.15, -0.05), rolling: exponential_per_s(0.5)),
    cameras: (render: off), vision: (source: geometric, noise: default),
    robots: [
        (
            team: blue, number: 1,
            behaviour: script([
                (kick: (type: right_straight)),
                (from_s: 2.0, until_s: 3.0, walk: (0.01, 0, 0)),
                (from_s: 2.0, head_deg: (20, 10)), /* a look */
                (until_s: 60.0, say: (ball_m: (0.1, 0.2))),
            ]),
        ),
        (team: pink, pose: (1.0, 0.5, 180), behaviour: striker, motion: (max_linear_mps: 0.1)),
    ],
    posts: [(position_m: (0.4242, 0.1501))],
)"#;

#[test]
fn the_contracts_example_loads_and_natural_ron_is_the_same() {
    let contract = Scenario::from_text(CONTRACT, Format::Json, "contract.json").unwrap();
    let BehaviourSpec::Script(entries) = &contract.robots[0].behaviour else { panic!("no script") };
    assert_eq!(entries[0].kick, Some(KickRequest::new(KickType::RightStraight, 1.0)));
    assert_eq!(entries[2].head, Some([to_radians(20.0), to_radians(10.0)]));
    assert_eq!(contract.robots[1].pose, Pose::new(1.0, 0.5, to_radians(180.0)));
    assert_eq!(contract.robots[1].own.motion.map(|motion| motion.max_linear_mps), Some(0.1));
    assert_eq!(contract.posts, [PostSpec { position_m: Vec2::new(0.4242, 0.1501), ..PostSpec::default() }]);
    assert_eq!(Scenario::from_text(CONTRACT, Format::Ron, "contract.ron").unwrap(), contract);
    assert_eq!(Scenario::from_text(NATURAL, Format::Ron, "natural.ron").unwrap(), contract);
}

#[test]
fn presets_are_changed_by_an_objects_own_fields() {
    let text = "(
        field: (preset: spl2025, border_m: 1.0, goal: (width_m: 2.0)),
        rules: (preset: spl2010, half_s: 60.0),
        motion: (max_linear_mps: 0.3, error_sd: (dx_m: 0.01)),
        sonar: (max_m: 0.6, noise: gaussian(sd_m: 0.02)),
        robots: [(number: 3, motion: (error_sd: (dy_m: 0.02)), sonar: (noise: none)), (pose: (0, 1, 0))],
    )";
    let scenario = Scenario::from_text(text, Format::Ron, "presets.ron").unwrap();
    let mut field = pitch_preset("spl2025").unwrap();
    (field.border_m, field.goal.width_m) = (1.0, 2.0);
    assert_eq!(scenario.field, field);
    assert_eq!(scenario.rules, Rules { half_s: 60.0, ..rules_preset("spl2010").unwrap() });
    assert_eq!(scenario.rules.ball_out_restart, BallOutRestart::ThrowIn);
    let own = scenario.robots[0].own.motion.unwrap();
    assert_eq!((own.max_linear_mps, own.error_sd.dx_m, own.error_sd.dy_m), (0.3, 0.01, 0.02));
    let sonar = scenario.robots[0].own.sonar.unwrap();
    assert_eq!((sonar.max_m, sonar.noise), (0.6, SonarNoise::None));
    assert_eq!(scenario.robots[1].number, 1);
    assert_eq!(scenario.robots[1].own.motion, None);
}

#[test]
fn a_robot_may_stand_on_the_mark_when_the_ball_is_left_to_its_default() {
    let scenario = Scenario::from_text("(robots: [(pose: (0, 0, 0))])", Format::Ron, "mark.ron").unwrap();
    assert_eq!(scenario.validate(), Ok(()));
    // Without a robot there it lies on the mark.
    let scenario = Scenario::from_text("(robots: [(pose: (1, 0, 0))])", Format::Ron, "mark.ron").unwrap();
    assert_eq!(scenario.ball, Some(BallSpec::default()));
}

#[test]
fn huge_walk_commands_load_and_stay_finite() {
    let text = "{ \"robots\": [ { \"behaviour\": { \"script\": [ { \"walk\": [1e308, -1e40, 1e39] } ] } } ] }";
    let scenario = Scenario::from_text(text, Format::Json, "huge.json").unwrap();
    let BehaviourSpec::Script(entries) = &scenario.robots[0].behaviour else { panic!("no script") };
    assert!(entries[0].walk.unwrap().iter().all(|number| number.is_finite() && number.abs() > 1e20));
}

#[test]
fn what_was_resolved_loads_again_as_it_is() {
    let again = |scenario: &Scenario| {
        let json = scenario.resolved_json().unwrap();
        let loaded = Scenario::from_text(&json, Format::Json, "resolved.json").unwrap();
        assert_eq!(&loaded, scenario);
        assert_eq!(Scenario::from_text(&json, Format::Ron, "resolved.ron").unwrap(), loaded);
        assert_eq!(loaded.resolved_json().unwrap(), json);
    };
    for entry in LIBRARY {
        again(&Scenario::named(entry.name).unwrap());
    }
    again(&Scenario::from_text(CONTRACT, Format::Json, "contract.json").unwrap());
    again(
        &Scenario::from_text("(robots: [(pose: (0, 1, 270)), (pose: (0, -1, -180))])", Format::Ron, "turned.ron")
            .unwrap(),
    );
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever becomes of a valid file, it loads or is refused in one paragraph, and what loads loads again.
    #[test]
    fn broken_files_never_panic(
        which in 0..LIBRARY.len() + 2,
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..6_u8, any::<u8>(), 1..30_usize), 1..6),
    ) {
        let (text, format) = match which.checked_sub(LIBRARY.len()) {
            None => (LIBRARY[which].text, LIBRARY[which].format),
            Some(0) => (CONTRACT, Format::Json),
            Some(_) => (NATURAL, Format::Ron),
        };
        const PIECES: [&str; 16] = [
            "(", ")", "[", "]", "{", "}", ",", ":", "\"", "NaN", "-1e999", "null", "Some(", "/*", "r#\"", "ä",
        ];
        let mut bytes = text.as_bytes().to_vec();
        for (index, kind, byte, length) in edits {
            if bytes.is_empty() {
                break;
            }
            let at = index.index(bytes.len());
            let end = (at + length).min(bytes.len());
            match kind {
                0 => bytes[at] = byte,
                1 => drop(bytes.drain(at..end)),
                2 => {
                    let copy = bytes[at..end].to_vec();
                    bytes.splice(at..at, copy);
                }
                3 => bytes.truncate(at),
                4 => drop(bytes.splice(at..at, PIECES[usize::from(byte) % PIECES.len()].bytes())),
                _ => bytes[at] = b'0' + byte % 10,
            }
        }
        let text = String::from_utf8_lossy(&bytes);
        for format in [format, Format::Json, Format::Ron] {
            match Scenario::from_text(&text, format, "broken") {
                Ok(scenario) => {
                    let json = scenario.resolved_json().unwrap();
                    prop_assert_eq!(Scenario::from_text(&json, Format::Json, "again").unwrap(), scenario);
                }
                Err(error) => {
                    let (line, column) = (error.line().unwrap(), error.column().unwrap());
                    prop_assert!(line >= 1 && line <= text.lines().count().max(1) + 1);
                    let place = format!("broken:{line}:{column}: ");
                    prop_assert!(column >= 1 && error.to_string().starts_with(&place), "{}", error);
                    prop_assert!(!error.to_string().contains('\n'), "{}", error);
                }
            }
        }
    }
}
