//! Files of robots' models: which are taken, which are refused, and where they are said to be wrong.

use naoisis::prelude::*;
use naoisis::scenario::{RobotModel, ScenarioError};
use proptest::prelude::*;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

use crate::support::{naoisis, text};

/// A model's file of a robot that somebody might build, from numbers between 0 and 1.
fn model_within_sense(random: [f64; 8]) -> Value {
    let [height, width, hip, neck, camera, speed, slowest, nod] = random;
    let between = |share: f64, least: f64, most: f64| least + share * (most - least);
    let height_m = between(height, 0.3, 1.8);
    let (hip_m, neck_m) = (between(hip, 0.3, 0.5) * height_m, between(neck, 0.72, 0.9) * height_m);
    let half_width_m = between(width, 0.15, 0.3) * height_m;
    let fastest_mps = between(speed, 0.1, 2.0);
    let pitch_deg = [between(nod, -40.0, 0.0), between(nod, 10.0, 60.0)];
    json!({
        "name": "random", "description": "a robot that somebody might build", "sources": {},
        "settings": {
            "body": {
                "torso": { "x_m": [-0.1, 0.1], "half_width_m": half_width_m, "z_m": [hip_m, neck_m] },
                "base": { "x_m": [-0.1, 0.15], "half_width_m": 0.6 * half_width_m, "z_m": [0.0, hip_m] },
                "height_m": height_m, "lying_height_m": 0.3 * height_m, "foot_y_m": 0.3 * half_width_m,
                "neck_m": [0.0, 0.0, neck_m],
                "waistband": { "z_m": [hip_m, hip_m + 0.1 * height_m], "half_size_m": [0.11, 0.5 * half_width_m] },
                "legs": { "hip_m": [0.0, 0.3 * half_width_m, hip_m], "thigh_m": 0.45 * hip_m, "shank_m": 0.45 * hip_m, "ankle_m": 0.1 * hip_m },
                "arms": { "shoulder_m": [0.0, half_width_m, neck_m], "length_m": 0.3 * height_m },
            },
            "head": { "yaw_deg": [-90, 90], "pitch_deg": pitch_deg, "pitch_at_yaw_deg": [[0, -90, pitch_deg[1]]] },
            "cameras": { "mounts": [{ "name": "head", "position_m": [0.05, 0.0, between(camera, 0.5, 1.2) * height_m], "tilt_deg": 40 }] },
            "sonar": { "height_m": 0.5 * height_m },
            "kicks": { "left_straight": { "max_distance_m": 4 } },
            "motion": { "max_linear_mps": fastest_mps },
        },
        "realistic": { "motion": { "gait": { "least_mps": slowest.min(0.99) * fastest_mps.min(1.0) } }, "ball": "spl2025" },
    })
}

/// What makes a model one of a robot that cannot be: where it is told, and the change.
const IMPOSSIBLE: &[(&str, fn(&mut Value))] = &[
    ("settings.body.torso.z_m[1]", |model| {
        // A trunk above the head.
        model["settings"]["body"]["torso"]["z_m"][1] = json!(2.2);
    }),
    ("settings.body.torso.x_m", |model| model["settings"]["body"]["torso"]["x_m"] = json!([0.1, -0.1])),
    ("settings.body.torso.z_m", |model| {
        // A trunk in the air above its legs.
        let torso = &mut model["settings"]["body"]["torso"]["z_m"];
        torso[0] = json!(torso[0].as_f64().unwrap() + 0.03);
    }),
    ("settings.body.torso.x_m", |model| model["settings"]["body"]["torso"]["x_m"] = json!([0.2, 0.3])),
    ("settings.body.neck_m", |model| {
        // A head on a stick.
        let torso = &mut model["settings"]["body"]["torso"]["z_m"];
        torso[1] = json!(torso[0].as_f64().unwrap() + 0.001);
    }),
    ("settings.body.waistband.half_size_m", |model| {
        model["settings"]["body"]["waistband"]["half_size_m"] = json!([0.05, 0.01]);
    }),
    ("settings.body.legs.hip_m", |model| {
        // Legs that would end above the ground.
        let shank = &mut model["settings"]["body"]["legs"]["shank_m"];
        *shank = json!(0.5 * shank.as_f64().unwrap());
    }),
    ("settings.cameras.mounts[0].pan_deg", |model| {
        model["settings"]["cameras"]["mounts"][0]["pan_deg"] = json!(190);
    }),
    ("settings.body.base.z_m[0]", |model| {
        // A robot that hovers.
        let base = &mut model["settings"]["body"]["base"]["z_m"];
        base[0] = json!(base[1].as_f64().unwrap() - 0.01);
    }),
    ("settings.body.neck_m", |model| model["settings"]["body"]["neck_m"][2] = json!(1.9)),
    ("settings.body.lying_height_m", |model| model["settings"]["body"]["lying_height_m"] = json!(1.9)),
    ("settings.body.foot_y_m", |model| model["settings"]["body"]["foot_y_m"] = json!(0.9)),
    ("settings.body.waistband.z_m[1]", |model| model["settings"]["body"]["waistband"]["z_m"][1] = json!(1.9)),
    ("settings.body.legs.hip_m", |model| {
        // Legs that would reach into the ground.
        let thigh = &mut model["settings"]["body"]["legs"]["thigh_m"];
        *thigh = json!(thigh.as_f64().unwrap() + 0.1);
    }),
    ("settings.body.arms.shoulder_m", |model| model["settings"]["body"]["arms"]["shoulder_m"][2] = json!(2.0)),
    ("settings.cameras.mounts[0].position_m", |model| {
        model["settings"]["cameras"]["mounts"][0]["position_m"] = json!([1.0, 0.95, 0.3]);
    }),
    ("settings.cameras.mounts[0].position_m", |model| {
        model["settings"]["cameras"]["mounts"][0]["position_m"][2] = json!(2.45);
    }),
    ("settings.head.yaw_deg", |model| model["settings"]["head"]["yaw_deg"] = json!([90, -90])),
    ("settings.head.pitch_deg", |model| model["settings"]["head"]["pitch_deg"] = json!([30, -30])),
    ("settings.head.pitch_at_yaw_deg[0]", |model| {
        model["settings"]["head"]["pitch_at_yaw_deg"][0] = json!([0, 70, 80]);
    }),
    ("realistic.motion.gait.least_mps", |model| {
        model["settings"]["motion"]["max_linear_mps"] = json!(0.001);
        model["realistic"]["motion"]["gait"]["least_mps"] = json!(0.05);
    }),
    ("realistic.motion.gait.step_s", |model| model["realistic"]["motion"]["gait"]["step_s"] = json!(0)),
    ("settings.league", |model| model["settings"]["league"] = json!("spl2025")),
    ("settings.ball", |model| model["settings"]["ball"] = json!("spl2025")),
    ("realistic.ball", |model| model["realistic"]["ball"] = json!("spl2052")),
    ("realistic.teams", |model| model["realistic"]["teams"] = json!({ "blue": "roles" })),
    ("realistic.realism", |model| model["realistic"]["realism"] = json!("ideal")),
    ("realistic.duration_s", |model| model["realistic"]["duration_s"] = json!(3)),
];

/// What is said of a model's file with these values, which are RON, too.
fn check(folder: &Path, model: &Value) -> Result<RobotModel, Vec<ScenarioError>> {
    let path = folder.join("random.ron");
    fs::write(&path, serde_json::to_string_pretty(model).unwrap()).unwrap();
    RobotModel::check(&path.to_string_lossy()).expect("it is a model's file")
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(24) })]

    /// Robots within sense are taken, and each mistake in one is told at its place.
    #[test]
    fn robots_that_can_be_are_taken_and_others_refused(random in proptest::array::uniform8(0.0..1.0)) {
        let folder = tempfile::tempdir().unwrap();
        let model = model_within_sense(random);
        prop_assert_eq!(check(folder.path(), &model).err(), None);
        for (place, spoil) in IMPOSSIBLE {
            let mut model = model.clone();
            spoil(&mut model);
            let errors = check(folder.path(), &model).expect_err(place);
            let places: Vec<String> = errors.iter().map(|error| error.path().unwrap().to_string()).collect();
            prop_assert!(places.iter().any(|told| told == place), "{place}: {errors:#?}");
            prop_assert!(errors.iter().all(|error| error.line() > Some(1) && !error.expected().is_empty()), "{errors:#?}");
        }
    }
}

/// A file with mistakes of all kinds.
const WRONG: &str = r#"(
    name: "wrong", descripton: "a robot that cannot be",
    settings: (
        body: (height_m: -1.0, lok: light),
        heat: (yaw_deg: (0, 0)),
    ),
    realistic: (league: "spl2025", kicks: (recovery_s: -1)),
    sources: { "body": 3 },
)"#;

#[test]
fn all_that_is_wrong_is_told_at_its_place_and_a_scenario_says_where_its_models_file_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wrong.ron");
    fs::write(&path, WRONG).unwrap();
    let path = path.to_string_lossy();
    let errors = RobotModel::check(&path).unwrap().unwrap_err();
    let told: Vec<String> = errors.iter().map(|error| error.to_string().replace(&*path, "FILE")).collect();
    for (place, words) in [
        ("1:1", "the field `description` is missing"),
        ("2:20", "a model has no field `descripton`: did you mean `description`?"),
        ("4:32", "there is no field `lok`: did you mean `look`?"),
        ("5:9", "a model has no `heat`: did you mean `head`?"),
        ("7:17", "a model has no `league`"),
        ("8:24", "`body` is the number 3; expected a text in quotes"),
    ] {
        let is_told = told.iter().any(|told| told.starts_with(&format!("FILE:{place}: {words}")));
        assert!(is_told, "{place}: {words}\n{}", told.join("\n"));
    }
    // Numbers are judged once all fields are those of a model.
    let other_fields =
        ["descripton", ", lok: light", "heat: (yaw_deg: (0, 0)),", "league: \"spl2025\", ", "\"body\": 3"];
    let mended = other_fields.iter().fold(WRONG.to_owned(), |text, wrong| {
        text.replace(wrong, if *wrong == "descripton" { "description" } else { "" })
    });
    fs::write(&*path, mended).unwrap();
    let errors: Vec<String> = RobotModel::check(&path).unwrap().unwrap_err().iter().map(ToString::to_string).collect();
    for words in [":4:26: `height_m` is -1; expected more than 0", "`recovery_s` is -1; expected 0 to 60 s"] {
        assert!(errors.iter().any(|error| error.contains(words)), "{words}\n{errors:#?}");
    }
    fs::write(&*path, WRONG).unwrap();
    let scenario = folder.path().join("scenario.ron");
    for text in [
        r#"(model: "wrong.ron")"#,
        r#"(robots: [(model: (preset: "wrong.ron", body: (height_m: 0.5)))])"#,
        r#"(teams: (blue: (team: "roles", model: "wrong.ron"), pink: "roles"))"#,
    ] {
        fs::write(&scenario, text).unwrap();
        let error = Scenario::load(&scenario).unwrap_err();
        assert!(error.message().contains(&format!("{path}:1:1: the field `description`")), "{error}");
    }
    // A text that is no RON has a place, too.
    fs::write(folder.path().join("wrong.ron"), "(\n  name: \"x\",,\n)").unwrap();
    let error = RobotModel::find(&path).unwrap_err().to_string();
    assert!(error.contains(&format!("{path}:2:")), "{error}");
}

#[test]
fn a_model_is_no_scenario_and_lies_beside_the_scenario_that_changes_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut model = model_within_sense([0.5; 8]);
    model["settings"]["motion"]["max_linear_mps"] = json!(0.77);
    check(folder.path(), &model).unwrap();
    let error = Scenario::load(folder.path().join("random.ron")).unwrap_err().to_string();
    assert!(error.contains("this is the model of a robot, no scenario"), "{error}");
    assert!(error.contains(r#"`(model: "random.ron", "#), "{error}");
    let scenario = folder.path().join("scenario.ron");
    // A field of models does not make a model of a scenario.
    fs::write(&scenario, r#"(like: "nao", teams: (blue: "roles", pink: "roles"))"#).unwrap();
    let error = Scenario::load(&scenario).unwrap_err().to_string();
    assert!(error.contains("there is no field `like`"), "{error}");
    let text = r#"(rules: "free", model: (preset: "random.ron", motion: (max_angular_degps: 33)),
        robots: [(), (pose: (1, 0, 0), model: (preset: "random.ron", motion: (max_linear_mps: 0.5)))])"#;
    fs::write(&scenario, text).unwrap();
    let scenario = Scenario::load(&scenario).unwrap();
    let own = scenario.robots[1].own.motion.unwrap();
    assert_eq!((scenario.settings.motion.max_linear_mps, own.max_linear_mps), (0.77, 0.5));
    assert_eq!(
        (scenario.settings.motion.max_angular.to_degrees().round(), own.max_angular.to_degrees().round()),
        (33.0, 90.0)
    );
}

#[test]
fn what_a_robot_with_a_trunk_of_its_own_does_not_name_it_lacks() {
    let folder = tempfile::tempdir().unwrap();
    let mut model = model_within_sense([0.5; 8]);
    let settings = model["settings"].as_object_mut().unwrap();
    for part in ["head", "cameras", "sonar"] {
        settings.remove(part);
    }
    let body = settings["body"].as_object_mut().unwrap();
    body.remove("legs");
    body.remove("arms");
    let bare = check(folder.path(), &model).unwrap();
    assert!(bare.source("sonar.fitted").is_some() && bare.source("body.legs").is_some());
    let path = folder.path().join("random.ron");
    let scenario = Scenario::from_json(&json!({ "model": path, "realism": "realistic" }).to_string()).unwrap();
    assert!(!scenario.settings.sonar.fitted && scenario.settings.cameras.mounts.as_slice().is_empty());
    assert_eq!((scenario.settings.head.yaw, scenario.settings.head.pitch), ([0.0; 2], [0.0; 2]));
    assert_eq!((scenario.settings.body.legs, scenario.settings.body.arms), (None, None));
    assert_eq!(scenario.settings.body.look, naoisis::robot::look::Look::LIGHT);
    // A NAO that is changed stays one.
    let tall = json!({ "name": "tall", "description": "", "settings": { "body": { "height_m": 0.6 } }, "realistic": {}, "sources": {} });
    check(folder.path(), &tall).unwrap();
    let tall = Scenario::from_json(&json!({ "model": path }).to_string()).unwrap();
    let nao = Scenario::default().settings;
    assert_eq!((tall.settings.sonar, tall.settings.head, tall.settings.cameras), (nao.sonar, nao.head, nao.cameras));
    assert!(tall.settings.body.legs.is_some());
}

#[cfg(unix)]
#[test]
fn nobody_waits_for_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.ron");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    for command in [&["robot", "show", "pipe.ron"][..], &["check", "pipe.ron"], &["run", "pipe.ron"]] {
        let output = naoisis(folder.path(), command);
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains("it is no ordinary file"), "{}", text(&output.stderr));
    }
}

#[test]
fn a_check_tells_models_from_scenarios_and_says_who_does_not_see_the_ball() {
    let folder = tempfile::tempdir().unwrap();
    let mut model = model_within_sense([0.5; 8]);
    check(folder.path(), &model).unwrap();
    let output = naoisis(folder.path(), &["check", "random.ron"]);
    let said = text(&output.stdout);
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines[0], "random.ron: ok, the model of a robot");
    assert_eq!(
        lines[1],
        "random.ron: note: the file leaves these out, so the NAO's figures are used: head.max_degps, cameras.diagonal_fov_deg, \
         cameras.height, cameras.width, motion.max_angular_degps"
    );
    assert_eq!(
        lines[2],
        "random.ron: note: the file leaves these out, so a `realistic` match uses the paper's figures instead of a real robot's: \
         cameras.lens, kicks.direction_sd_deg, vision.noise, sonar.noise, odometry.noise, falls, breakdowns, hearing and 2 more"
    );
    assert!(lines[3].starts_with("random.ron: note: `sources` has no source for: "), "{said}");
    assert!(lines[3].contains("body.arms, ") && lines[3].ends_with(" more") && lines.len() == 4, "{said}");
    let mut sourced = model.clone();
    let parts = [&model["settings"], &model["realistic"]].map(|part| part.as_object().unwrap().keys().cloned());
    sourced["sources"] = parts.into_iter().flatten().map(|part| (part, json!("invented"))).collect();
    check(folder.path(), &sourced).unwrap();
    // The ending may be in capitals.
    fs::rename(folder.path().join("random.ron"), folder.path().join("RANDOM.RON")).unwrap();
    let output = naoisis(folder.path(), &["check", "RANDOM.RON"]);
    let said = text(&output.stdout);
    assert!(said.starts_with("RANDOM.RON: ok, the model of a robot\n") && !said.contains("`sources`"), "{said}");
    check(folder.path(), &model).unwrap();
    fs::copy(folder.path().join("random.ron"), folder.path().join("random.json")).unwrap();
    let output = naoisis(folder.path(), &["check", "random.json"]);
    let words = "random.json:1:1: this is the model of a robot, which no scenario can name; expected a name that ends in `.ron`";
    assert!(output.status.code() == Some(2) && text(&output.stderr).contains(words), "{}", text(&output.stderr));
    model["settings"]["head"] = json!({ "yaw_deg": [0, 0], "pitch_deg": [0, 0] });
    model["settings"]["cameras"]["mounts"][0]["tilt_deg"] = json!(0);
    check(folder.path(), &model).unwrap();
    for command in [&["check", "random.ron"][..], &["robot", "show", "random.ron"]] {
        let output = naoisis(folder.path(), command);
        let words = "note: its cameras cannot see a ball that it could kick: the nearest ball that it can see straight ahead is ";
        assert!(output.status.success() && text(&output.stdout).contains(words), "{}", text(&output.stdout));
    }
}

#[test]
fn sources_of_nothing_are_refused_where_they_stand_with_what_was_meant() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.ron");
    let text = r#"(
    name: "own", description: "",
    settings: (motion: (max_linear_mps: 0.5), cameras: (mounts: [(name: "eye", position_m: (0.0, 0.0, 0.5))])),
    realistic: (),
    sources: {
        "motion": "tape measure", "cameras.mounts.0.position_m": "drawing", "motion.gait.step_s": "film", "falls": "film",
        "motin.max_linear_mps": "tape measure",
        "cameras.mounts[0].position_m": "drawing", "kicks.speed": "film", "colour": "red",
    },
)"#;
    fs::write(&path, text).unwrap();
    let errors = RobotModel::check(&path.to_string_lossy()).unwrap().unwrap_err();
    let told: Vec<(usize, &str)> = errors.iter().map(|error| (error.line().unwrap(), error.message())).collect();
    assert_eq!(
        told,
        [
            (7, "a model has nothing called `motin.max_linear_mps`: did you mean `motion.max_linear_mps`?"),
            (
                8,
                "a model has nothing called `cameras.mounts[0].position_m`: did you mean `cameras.mounts.0.position_m`?"
            ),
            (8, "a model has nothing called `kicks.speed`: did you mean `kicks.speed_sd`?"),
            (8, "a model has nothing called `colour`"),
        ]
    );
    assert_eq!(errors[0].column(), Some(9));
    assert!(errors[3].expected().contains("`motion.max_linear_mps`"), "{}", errors[3]);
}

#[test]
fn a_match_says_which_settings_do_not_reach_whom_and_what_its_models_leave_open() {
    let folder = tempfile::tempdir().unwrap();
    let model = model_within_sense([0.5; 8]);
    check(folder.path(), &model).unwrap();
    let scenario = r#"(
        league: "hsl2026_middle", duration_s: 0.1, kicks: (speed_sd: 0.3), rules: (team_size: 1),
        teams: (blue: (team: "roles", model: "random.ron"), pink: "roles"),
    )"#;
    fs::write(folder.path().join("match.ron"), scenario).unwrap();
    let unreached = "`kicks` of the scenario does not reach blue, whose model is `random.ron`: say it beside that `model`, or in it";
    let left_open = "random: the file leaves these out, so a `realistic` match uses the paper's figures instead of a real robot's: cameras.lens, kicks.direction_sd_deg, ";
    let checked = naoisis(folder.path(), &["check", "match.ron"]);
    let said = text(&checked.stdout);
    assert!(said.contains(unreached) && said.contains(left_open) && said.lines().count() == 3, "{said}");
    let played = naoisis(folder.path(), &["run", "match.ron"]);
    let said = text(&played.stderr);
    assert!(
        played.status.success() && said.matches(unreached).count() == 1 && said.matches(left_open).count() == 1,
        "{said}"
    );
    // Who wants it quiet has it quiet, and where nothing is realistic nothing real is promised.
    let quiet = naoisis(folder.path(), &["run", "match.ron", "--quiet"]);
    assert_eq!(text(&quiet.stderr), "");
    let paper = naoisis(folder.path(), &["run", "match.ron", "--realism", "paper"]);
    assert!(!text(&paper.stderr).contains("realistic"), "{}", text(&paper.stderr));
}

#[test]
fn a_script_commands_no_kick_that_its_robot_lacks() {
    let errors = |robot: &str, kick: &str| {
        let text = format!(
            r#"{{ "rules": "free", "kicks": {{ "left_side": {{ "max_distance_m": 0 }} }},
                  "robots": [{{ {robot} "behaviour": {{ "script": [{{ "kick": {{ "type": "{kick}" }} }}] }} }}] }}"#
        );
        Scenario::from_json(&text).map_err(|error| (error.path().unwrap().to_string(), error.to_string())).err()
    };
    assert_eq!(errors("", "left_straight"), None);
    let (place, words) = errors("", "left_side").unwrap();
    assert_eq!(place, "robots[0].behaviour.script[0].kick.type");
    assert!(words.contains("this robot has no kick `left_side`"), "{words}");
    assert!(words.ends_with("expected `left_straight`, `right_straight` or `right_side`"), "{words}");
    // Of another model it has what that has.
    let k1 = r#""model": "booster_k1","#;
    assert_eq!(errors(k1, "visual"), None);
    let (_, words) = errors(k1, "right_side").unwrap();
    assert!(words.ends_with("expected `left_straight`, `right_straight` or `visual`"), "{words}");
    let none = r#""model": { "preset": "rover", "kicks": { "left_straight": { "max_distance_m": 0 }, "right_straight": { "max_distance_m": 0 } } },"#;
    let (_, words) = errors(none, "left_straight").unwrap();
    assert!(words.ends_with("expected none: it has no kicks at all"), "{words}");
}

#[test]
fn a_measure_of_the_naos_that_does_not_fit_a_robot_is_told_as_such() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.ron");
    let text = r#"(name: "own", description: "", settings: (body: (
        torso: (x_m: (-0.1, 0.1), half_width_m: 0.15, z_m: (0.0, 0.45)))), realistic: (), sources: {})"#;
    fs::write(&path, text).unwrap();
    let errors = RobotModel::check(&path.to_string_lossy()).unwrap().unwrap_err();
    let words = "the waistband of (0.056, 0.074) m is inside the trunk, where no camera sees it (the NAO's, as the file does not say it)";
    assert!(errors.iter().all(|error| error.message() == words), "{errors:?}");
}

#[test]
fn a_model_may_start_from_another_and_say_what_differs() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path.to_string_lossy().into_owned()
    };
    let k1 = RobotModel::named("booster_k1").unwrap();
    let ours = file(
        "ours.ron",
        r#"(name: "our_k1", like: "booster_k1",
            settings: (motion: (max_linear_mps: 0.9), cameras: (mounts: [(name: "wide", position_m: (0.05, 0.0, 0.85), tilt_deg: 10.0)])),
            sources: { "motion.max_linear_mps": "our measurement" })"#,
    );
    let model = RobotModel::check(&ours).unwrap().unwrap_or_else(|errors| panic!("{errors:?}"));
    let (own, base) = (model.all_settings(), k1.all_settings());
    assert_eq!((&own["kicks"], &own["body"], &model.description), (&base["kicks"], &base["body"], &k1.description));
    assert_eq!(own["motion"]["max_linear_mps"], 0.9);
    assert_eq!(own["cameras"]["width"], base["cameras"]["width"]);
    // Changed figures have their own sources, or none.
    assert_eq!(model.source("motion.max_linear_mps"), Some("our measurement"));
    assert_eq!(model.source("kicks.wind_up_s"), k1.source("kicks.wind_up_s"));
    let of_camera = model.source("cameras.mounts.0.tilt_deg").unwrap();
    assert_eq!(of_camera, "guess: changed from booster_k1, without a source");
    // A file beside it, of which a scenario is played; what differs holds in every realism.
    let theirs = file("theirs.ron", r#"(name: "their_k1", like: "ours.ron", realistic: (kicks: (wind_up_s: 0.7)))"#);
    for realism in ["ideal", "realistic"] {
        let text = json!({ "model": theirs, "realism": realism }).to_string();
        let settings = Scenario::from_json(&text).unwrap().settings;
        assert_eq!((settings.motion.max_linear_mps, settings.cameras.mounts.as_slice().len()), (0.9, 1));
        assert_eq!(settings.kicks.wind_up_s == 0.7, realism == "realistic");
    }
    let output = naoisis(folder.path(), &["robot", "show", "theirs.ron"]);
    let shown = text(&output.stdout);
    assert!(
        shown.contains("our measurement") && shown.lines().any(|line| line.starts_with("body.height_m")),
        "{shown}"
    );
    for (name, like, said) in [
        ("unknown.ron", "booster_k2", "2:11: there is no model `booster_k2`: did you mean `booster_k1`?"),
        ("itself.ron", "itself.ron", "2:11: the model's file is wrong: "),
        ("missing.ron", "nowhere.ron", "cannot be read"),
    ] {
        let path = file(name, &format!("(name: \"x\",\n    like: \"{like}\")"));
        let errors = RobotModel::check(&path).unwrap().unwrap_err();
        assert!(errors.len() == 1 && errors[0].to_string().contains(said), "{errors:?}");
    }
}
