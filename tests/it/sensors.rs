//! Sensors of a program's own: settings in scenario files, readings in traces, and both in saved matches.

use bevy::prelude::*;
use naoisis::prelude::*;
use naoisis::random::RandomStreams;
use naoisis::record::read::TraceReader;
use naoisis::scenario::{Format, ScenarioFile, Setting};
use naoisis::sensing::scene::Scene;
use naoisis::simulation::{Snapshot, change_settings};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::Path;

use crate::support::{begin_trace, blue, headless_app};

/// How far a robot hears the ball.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
struct Ear {
    range_m: f32,
    sd_m: f32,
}

impl Default for Ear {
    fn default() -> Self {
        Self { range_m: 1.0, sd_m: 0.0 }
    }
}

/// How far away the ball sounds, m.
#[derive(Component, Default, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
struct BallNoise {
    distance_m: Option<f32>,
}

fn listen(scene: Res<Scene>, mut robots: Query<(&Pose, &Ear, &mut BallNoise, &mut RandomStreams)>) {
    for (pose, ear, mut noise, mut streams) in &mut robots {
        let distance = scene.ball.map(|ball| ball.position.distance(pose.position));
        let heard = distance.filter(|distance| *distance < ear.range_m);
        noise.distance_m = heard.map(|distance| distance + streams.own("ear").gaussian(ear.sd_m));
    }
}

/// Walks away from what it hears.
#[derive(Component, Default)]
struct Timid;

fn flee(mut robots: Query<(&BallNoise, &mut WalkCommand), With<Timid>>) {
    for (noise, mut walk) in &mut robots {
        walk.dx = if noise.distance_m.is_some() { -0.005 } else { 0.0 };
    }
}

fn app() -> App {
    let mut app = headless_app();
    app.add_sensor::<Ear, BallNoise, _>("ball_ear", listen);
    app.add_behaviour::<Timid, _>("timid", flee);
    app
}

/// Three robots 0.5 m, 1.5 m and 2.5 m away from the ball: the second hears farther than the default, the third not at all.
const SCENARIO: &str = r#"{ "rules": "free", "sensors": { "ball_ear": { "sd_m": 0.01 } }, "robots": [
    { "number": 1, "pose": [0.5, 0, 0], "behaviour": "timid" },
    { "number": 2, "pose": [1.5, 0, 0], "sensors": { "ball_ear": { "range_m": 2 } } },
    { "number": 3, "pose": [2.5, 0, 0], "sensors": { "ball_ear": null } }] }"#;

#[test]
fn settings_are_the_scenarios_common_ones_and_each_robots_own() {
    let mut app = app();
    app.start_match(&Scenario::from_json(SCENARIO).unwrap()).unwrap().run_cycles(1);
    assert_eq!(app.robot::<Ear>(blue(1)), Some(&Ear { range_m: 1.0, sd_m: 0.01 }));
    assert_eq!(app.robot::<Ear>(blue(2)), Some(&Ear { range_m: 2.0, sd_m: 0.01 }));
    assert_eq!((app.robot::<Ear>(blue(3)), app.robot::<BallNoise>(blue(3))), (None, None));
    let heard = |app: &App, number| app.robot::<BallNoise>(blue(number)).unwrap().distance_m;
    assert!((heard(&app, 1).unwrap() - 0.5).abs() < 0.05 && (heard(&app, 2).unwrap() - 1.5).abs() < 0.05);
    // Without a word, every robot has it as it is by default: those of teams, too.
    app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
    assert_eq!(app.robot::<Ear>(blue(3)), Some(&Ear::default()));
}

#[test]
fn what_is_wrong_is_found_before_the_match_and_located() {
    let check = |text: &str, settings: &[&str]| {
        let settings: Vec<Setting> = settings.iter().map(|setting| setting.parse().unwrap()).collect();
        let file = match ScenarioFile::from_text(text, Format::Json, "ears.json") {
            Ok(file) => file.with(&settings).unwrap(),
            Err(error) => return error.to_string(),
        };
        let fault = app().start_match(&file.scenario).err().unwrap();
        file.source.error(&fault).to_string()
    };
    let own = |sensors: &str| format!("{{ \"robots\": [\n  {{ \"sensors\": {sensors} }}] }}");
    for (text, expected) in [
        (
            own(r#"{ "bal_ear": {} }"#),
            "ears.json:2:18: there is no sensor `bal_ear`: did you mean `ball_ear`? expected `ball_ear`",
        ),
        (
            own(r#"{ "ball_ear": { "rang_m": 1 } }"#),
            "ears.json:2:32: there is no field `rang_m`: did you mean `range_m`?",
        ),
        (
            own(r#"{ "ball_ear": { "range_m": "far" } }"#),
            "ears.json:2:43: `range_m` is the text `far`; expected a number",
        ),
        (own(r#"{ "ball_ear": { "range_m": 1e99 } }"#), "ears.json:2:43: 1000"),
        (own(r#"{ "ball_ear": 3 }"#), "ears.json:2:30: `ball_ear` is the number 3; expected an object"),
    ] {
        let error = check(&text, &[]);
        assert!(error.starts_with(expected), "{error}");
    }
    let error = check("{}", &["sensors.ball_ear.range_m=far"]);
    assert!(error.starts_with("--set sensors.ball_ear.range_m=far: `range_m` is the text `far`"), "{error}");
    // A program without it says that it has none.
    let scenario = Scenario::from_json(r#"{ "sensors": { "ball_ear": {} } }"#).unwrap();
    let fault = headless_app().start_match(&scenario).err().unwrap();
    let fault = fault.to_string();
    assert!(fault.starts_with("sensors.ball_ear: there is no sensor `ball_ear`; expected "), "{fault}");
}

#[test]
fn readings_are_in_the_trace_and_come_back_from_it() {
    let mut app = app();
    let scenario = Scenario::from_json(SCENARIO).unwrap();
    app.start_match(&scenario).unwrap();
    let bytes = begin_trace(&mut app);
    app.run_cycles(3);
    let written = bytes.written();
    let heard = app.robot::<BallNoise>(blue(2)).unwrap().distance_m.unwrap();
    let last = written.split(|byte| *byte == b'\n').rfind(|line| !line.is_empty()).unwrap();
    let last: serde_json::Value = serde_json::from_slice(last).unwrap();
    // With as many digits as mean something.
    let traced = last["robots"][1]["sensors"]["ball_ear"]["distance_m"].as_f64().unwrap();
    assert!((traced - f64::from(heard)).abs() <= 1e-5, "{traced} {heard}");
    let mut reader = TraceReader::new(Path::new("ears"), std::io::Cursor::new(written)).unwrap();
    // The header is the match: its robots hear as these did.
    assert_eq!(reader.scenario(), &scenario);
    let records: Vec<_> = core::iter::from_fn(|| reader.next_cycle().unwrap()).collect();
    assert_eq!(records.len(), 4);
    assert!(records[0].robots[0].sensors["ball_ear"]["distance_m"].is_null());
    assert_eq!(records[3].robots[1].sensors["ball_ear"]["distance_m"].as_f64(), Some(traced));
    assert!(!records[3].robots[2].sensors.contains_key("ball_ear"));
}

#[test]
fn a_match_with_own_sensors_is_saved_and_its_settings_change_while_it_runs() {
    let mut app = app();
    app.start_match(&Scenario::from_json(SCENARIO).unwrap()).unwrap().run_cycles(20);
    let saved = Snapshot::take(app.world_mut()).unwrap().to_bytes(app.world()).unwrap();
    let place = app.run_cycles(30).robot_pose(blue(1)).unwrap();
    let reading = *app.robot::<BallNoise>(blue(2)).unwrap();
    Snapshot::from_bytes(&saved, app.world()).unwrap().restore(app.world_mut()).unwrap();
    app.run_cycles(30);
    assert_eq!((app.robot_pose(blue(1)), app.robot::<BallNoise>(blue(2))), (Some(place), Some(&reading)));

    let mut scenario = app.world().resource::<Scenario>().clone();
    scenario.robots[0]
        .own
        .sensors
        .get_or_insert_default()
        .0
        .insert("ball_ear".to_owned(), serde_json::json!({ "range_m": 0.1 }));
    scenario.robots[2].own.sensors = None;
    change_settings(app.world_mut(), &scenario).unwrap();
    app.run_cycles(1);
    assert_eq!(app.robot::<BallNoise>(blue(1)), Some(&BallNoise::default()));
    assert_eq!(app.robot::<Ear>(blue(3)), Some(&Ear { range_m: 1.0, sd_m: 0.01 }));
    scenario.robots[0]
        .own
        .sensors
        .get_or_insert_default()
        .0
        .insert("ball_ear".to_owned(), serde_json::json!({ "range": 0.1 }));
    assert!(change_settings(app.world_mut(), &scenario).is_err());
}

#[derive(Component, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component)]
struct Unmarked;

#[derive(Component, Default, Reflect, Serialize, Deserialize)]
#[reflect(@Knowledge::Sensor)]
struct Unsaved;

#[derive(Component, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
struct Smell;

#[derive(Component, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
struct Nose;

/// Settings that ignore misspelt fields.
#[derive(Component, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default)]
struct LaxNose {
    range_m: f32,
}

#[test]
fn a_sensor_is_told_what_it_lacks() {
    fn refused<Settings, Reading>(app: &mut App, name: &str) -> String
    where
        Settings: naoisis::simulation::sensors::SensorSettings,
        Reading: naoisis::simulation::sensors::SensorReading,
    {
        app.try_add_sensor::<Settings, Reading, _>(name, || {}).err().unwrap().to_string()
    }
    let mut app = app();
    assert!(refused::<Nose, Smell>(&mut app, "ball_ear").contains("another sensor has this name"));
    assert!(refused::<Nose, BallNoise>(&mut app, "nose").contains("BallNoise` is another sensor's"));
    assert!(refused::<Unmarked, Smell>(&mut app, "nose").contains("Unmarked` lacks a part of its mark"));
    let unmarked = refused::<Nose, Unmarked>(&mut app, "nose");
    assert!(unmarked.contains("`#[reflect(Component, @Knowledge::Sensor)]`"), "{unmarked}");
    assert!(refused::<Nose, Unsaved>(&mut app, "nose").contains("Unsaved` lacks a part of its mark"));
    assert!(refused::<LaxNose, Smell>(&mut app, "nose").contains("deny_unknown_fields"));
    assert!(refused::<Nose, Smell>(&mut app, "my nose").contains("lower-case letters"));
    app.start_match(&Scenario::from_json(SCENARIO).unwrap()).unwrap();
    assert!(refused::<Nose, Smell>(&mut app, "nose").contains("while a match is on"));
}

#[test]
fn a_behaviour_reads_a_reading_and_cannot_write_it() {
    fn imagine(mut robots: Query<&mut BallNoise, With<Timid>>) {
        for mut noise in &mut robots {
            noise.distance_m = Some(1.0);
        }
    }
    let mut app = headless_app();
    app.add_sensor::<Ear, BallNoise, _>("ball_ear", listen);
    let error = app.try_add_behaviour::<Timid, _>("timid", imagine).err().unwrap().to_string();
    assert!(error.contains("BallNoise`, which is a sensor"), "{error}");
}

#[test]
fn robots_have_an_imu_where_a_scenario_or_a_program_needs_it_in_traces_and_for_programs_alike() {
    let scenario = |sensors: &str| {
        let text = format!(
            r#"{{ "realism": "realistic", "rules": "free", {sensors} "robots": [
                {{ "number": 1, "behaviour": {{ "script": [{{ "from_s": 0, "until_s": 60, "walk": [0.005, 0, 2] }}] }} }},
                {{ "number": 2, "pose": [1, 1, 0], "lies_on": "back", "behaviour": "idle" }} ] }}"#
        );
        Scenario::from_json(&text).unwrap()
    };
    let mut app = headless_app();
    app.start_match(&scenario(r#""sensors": { "imu": {} },"#)).unwrap();
    let bytes = begin_trace(&mut app);
    app.run_cycles(60);
    let written = bytes.written();
    let last = written.split(|byte| *byte == b'\n').rfind(|line| !line.is_empty()).unwrap();
    let last: serde_json::Value = serde_json::from_slice(last).unwrap();
    let measured = |robot: usize| &last["robots"][robot]["sensors"]["imu"];
    // It turns by 2° a cycle and rocks; the other one looks at the sky.
    let turn = measured(0)["turn_degps"][2].as_f64().unwrap();
    assert!((40.0..75.0).contains(&turn) && measured(0)["ground_contact"] == true, "{}", measured(0));
    assert!(measured(0)["tilt_deg"][1].as_f64().unwrap() != 0.0);
    let up = measured(1)["acceleration_mps2"][0].as_f64().unwrap();
    assert!((up - 9.81).abs() < 0.5 && measured(1)["lies_on"] == "back", "{}", measured(1));
    let perceived = naoisis::agents::perception(app.world_mut(), blue(2)).unwrap();
    assert_eq!(perceived.sensors["imu"]["lies_on"], "back");
    // It is part of a saved match.
    let saved = Snapshot::take(app.world_mut()).unwrap();
    let reading = |app: &mut App| naoisis::agents::perception(app.run_cycles(5).world_mut(), blue(1)).unwrap().sensors;
    let expected = reading(&mut app);
    saved.restore(app.world_mut()).unwrap();
    assert_eq!(reading(&mut app), expected);
    // Nobody else has it but robots that programs play in realistic matches.
    app.start_match(&scenario("")).unwrap().run_cycles(1);
    assert!(naoisis::agents::perception(app.world_mut(), blue(1)).unwrap().sensors.is_empty());
    for (fields, has_it) in [
        (r#""realism": "realistic""#, true),
        (r#""realism": "realistic", "sensors": { "imu": null }"#, false),
        (r#""realism": "paper""#, false),
    ] {
        let text = format!(r#"{{ {fields}, "rules": "free", "robots": [{{ "number": 1, "behaviour": "remote" }}] }}"#);
        app.start_match(&Scenario::from_json(&text).unwrap()).unwrap().run_cycles(1);
        let perceived = naoisis::agents::perception(app.world_mut(), blue(1)).unwrap();
        assert_eq!(perceived.sensors.contains_key("imu"), has_it, "{fields}");
    }
}

#[test]
fn somebody_presses_a_robots_buttons_at_the_times_of_the_scenario() {
    let text = r#"{ "rules": "free", "robots": [
        { "number": 1, "sensors": { "buttons": { "presses": [{ "at_s": 0.5, "button": "chest" }] } } }, { "number": 2, "pose": [1, 1, 0] }] }"#;
    let mut app = headless_app();
    app.start_match(&Scenario::from_json(text).unwrap()).unwrap();
    begin_trace(&mut app);
    let told = |app: &mut App, cycles: usize, number: u8| {
        naoisis::agents::perception(app.run_cycles(cycles).world_mut(), blue(number)).unwrap().sensors
    };
    assert_eq!(told(&mut app, 10, 1)["buttons"], json!({}));
    assert_eq!(told(&mut app, 7, 1)["buttons"], json!({ "chest": { "presses": 1, "pressed": true } }));
    assert_eq!(told(&mut app, 10, 1)["buttons"], json!({ "chest": { "presses": 1, "pressed": false } }));
    assert!(told(&mut app, 0, 2).is_empty());
    let saved = Snapshot::take(app.world_mut()).unwrap().to_bytes(app.world()).unwrap();
    Snapshot::from_bytes(&saved, app.world()).unwrap().restore(app.world_mut()).unwrap();
    assert_eq!(told(&mut app, 1, 1)["buttons"]["chest"]["presses"], 1);
    let wrong = text.replace("chest", "Chest").replace("0.5", "-1");
    let error = headless_app().start_match(&Scenario::from_json(&wrong).unwrap()).err().unwrap().to_string();
    assert!(error.contains("a button `Chest`"), "{error}");
}

#[test]
fn robots_that_hear_badly_miss_whistles_and_hear_others() {
    let whistles = |hearing: &str| {
        let text = format!(
            r#"{{ "league": "spl2025", "rules": {{ "preset": "spl2025", "standby_s": 1, "ready_s": 2, "set_s": 1 }},
                 "teams": {{ "blue": {{ "team": "roles", {hearing} }}, "pink": "roles" }} }}"#
        );
        let mut app = headless_app();
        app.start_match(&Scenario::from_json(&text).unwrap()).unwrap().run_cycles(300);
        let count = |team: Team| app.robot::<GameStatus>(RobotId::new(team, 2)).unwrap().whistles;
        (count(Team::Blue), count(Team::Pink))
    };
    let (all, also_all) = whistles(r#""hearing": {}"#);
    assert!(all > 0 && all == also_all, "{all} {also_all}");
    assert_eq!(whistles(r#""hearing": { "miss_probability": 1, "false_per_hour": 0 }"#).0, 0);
    // One in each cycle, nearly.
    assert!(whistles(r#""hearing": { "false_per_hour": 3600 }"#).0 > all);
}
