//! Scenario files that do not load: what errors say, and where they point.

use naoisis::ball::Rolling;
use naoisis::behaviour::script::ScriptEntry;
use naoisis::scenario::{BallSpec, BehaviourSpec, Format, RobotSpec, Scenario, ScenarioErrorKind, ScenarioFile};
use naoisis::team::Team;
use std::fs;
use std::path::Path;

/// Loads a text in which `«` marks where the error should point, and compares the error.
fn refuses(format: Format, marked: &str, message: &str, expected: &str) {
    let before = marked.split('«').next().unwrap();
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap().chars().count() + 1;
    let text = marked.replace('«', "");
    let name = if format == Format::Ron { "wrong.ron" } else { "wrong.json" };
    let Err(error) = Scenario::from_text(&text, format, name) else { panic!("this loads:\n{text}") };
    let whole = error.to_string();
    assert!(marked.contains('«'), "{whole}\n{text}");
    assert!(whole.starts_with(&format!("{name}:{line}:{column}: ")), "{line}:{column} expected, not {whole}\n{text}");
    assert!(!whole.contains('\n'), "{whole}");
    assert!(error.message().contains(message), "{whole}\nshould say {message}");
    assert!(error.expected().contains(expected), "{whole}\nshould expect {expected}");
    assert!(whole.ends_with(error.expected()) && !error.expected().is_empty(), "{whole}");
}

fn refuses_ron(marked: &str, message: &str, expected: &str) {
    refuses(Format::Ron, marked, message, expected);
}

fn refuses_json(marked: &str, message: &str, expected: &str) {
    refuses(Format::Json, marked, message, expected);
}

/// Refused as JSON, and as RON of the same shape.
fn refuses_both(marked: &str, message: &str, expected: &str) {
    refuses_json(marked, message, expected);
    refuses_ron(marked, message, expected);
}

#[test]
fn texts_that_are_no_ron_or_json() {
    refuses_both("«", "empty", "a scenario");
    refuses_both("«  \n\t\n", "empty", "a scenario");
    refuses_json("{ \"seed\": 1, «}", "nothing follows the comma", "another element");
    refuses_json("{ «seed: 1 }", "no field's name", "double quotes");
    refuses_json("{ \"seed\": 1 } «x", "after the scenario's end", "the end of the file");
    refuses_ron("(seed: 1) «x", "after the scenario's end", "the end of the file");
    refuses_json("{\n  \"seed\": 1\n  «\"name\": \"\" }", "not JSON", "`,` or `}`");
    refuses_ron("(\n  seed: 1\n  «name: \"\")", "there is no comma", "a comma");
    refuses_json("{ \"robots\": [ {«", "ends in the middle", "every bracket closed");
    refuses_ron("(robots: [(\n«", "ends in the middle", "every bracket closed");
    refuses_ron("(robots: [(team: blue, number: 1)«", "ends in the middle", "every bracket closed");
    refuses_ron("(seed: 1«", "ends in the middle", "every bracket closed");
    refuses_ron("(name: \"abc«", "ends in the middle", "every bracket closed");
    refuses_ron("(seed: 1) /* «", "ends in the middle", "every bracket closed");
    refuses_ron("(seed «1)", "no comma", "a colon after a field's name");
    refuses_ron("(1«: 2)", "no comma", "a comma");
    refuses_ron("{«1: 2}", "`1` is no field's name", "a field's name");
    refuses_ron("{\"name\": «b\"bytes\"}", "byte string", "a text in quotes");
    let deep = format!("{{ \"robots\": {}", "[".repeat(100_000));
    for format in [Format::Ron, Format::Json] {
        let error = Scenario::from_text(&deep, format, "deep").unwrap_err();
        assert_eq!((error.kind(), error.message()), (ScenarioErrorKind::Syntax, "the nesting is too deep"));
    }
}

#[test]
fn fields_that_there_are_not() {
    refuses_both("{ \"seed\": 1,\n \"name\": \"ä\", «\"sede\": 2 }", "no field `sede`: did you mean `seed`?", "`seed`");
    refuses_ron(
        "(\n  robots: [\n    (team: blue, number: 1, «positon: (0, 0)),\n  ],\n)",
        "no field `positon`",
        "`pose`",
    );
    refuses_ron("(ball: («radius: 0.03))", "did you mean `radius_m`?", "`radius_m`");
    refuses_ron("(robots: [(behaviour: script([(from_s: 0.0, «wlak: (0, 0, 0))]))])", "did you mean `walk`?", "`walk`");
    refuses_ron("(robots: [(behaviour: («scrip: []))])", "did you mean `script`?", "`script`");
    refuses_ron("(field: (preset: spl2025, goal: («widht_m: 1.0)))", "did you mean `width_m`?", "`width_m`");
    refuses_ron("(posts: [(«pos: (0, 0))])", "did you mean `position_m`?", "`radius_m`");
    refuses_both("{ \"seed\": 1, «\"seed\": 2 }", "`seed` is there twice", "once");
    refuses_ron("(sonar: (noise: gaussian(sd_m: 0.1, «sdm: 2)))", "did you mean `sd_m`?", "`sd_m`");
}

#[test]
fn values_of_the_wrong_type() {
    refuses_both("«[]", "a list", "an object");
    refuses_both("«3", "the number 3", "an object");
    refuses_both("{ \"seed\": «\"one\" }", "`seed` is the text `one`", "a whole number");
    refuses_both("{ \"seed\": «-1 }", "`seed` is the number -1", "a whole number, not negative");
    refuses_both("{ \"cycle_s\": «true }", "`cycle_s` is `true`", "a number");
    refuses_both("{ \"motion\": «[0.2] }", "`motion` is a list", "an object");
    refuses_both("{ \"motion\": «null }", "`motion` is nothing", "an object");
    refuses_both("{ \"robots\": «{} }", "`robots` is an object", "a list");
    refuses_both("{ \"robots\": [ {}, «1 ] }", "the number 1", "an object");
    refuses_both("{ \"robots\": [ { \"team\": «\"red\" } ] }", "`red`", "`blue` or `pink`");
    refuses_both("{ \"robots\": [ { \"number\": «256 } ] }", "the number 256", "a whole number from 0 to 255");
    refuses_both("{ \"robots\": [ { \"pose\": «[0, 0] } ] }", "a list of 2", "[x m, y m, heading deg]");
    refuses_both("{ \"robots\": [ { \"pose\": «[0, 0, 0, 0] } ] }", "a list of 4", "[x m, y m, heading deg]");
    refuses_both("{ \"robots\": [ { \"pose\": [0, «\"a\", 0] } ] }", "the text `a`", "a number");
    refuses_both("{ \"robots\": [ { \"behaviour\": «3 } ] }", "the number 3", "`idle`, the name of a behaviour");
    refuses_both(
        "{ \"robots\": [ { \"behaviour\": { \"script\": [ { \"walk\": «[1] } ] } } ] }",
        "a list of 1",
        "[dx m, dy m, dtheta deg]",
    );
    refuses_both(
        "{ \"robots\": [ { \"behaviour\": { \"script\": [ { \"kick\": «{} } ] } } ] }",
        "`type` is missing",
        "a field `type`",
    );
    refuses_both(
        "{ \"robots\": [ { \"behaviour\": { \"script\": [ { \"kick\": { \"type\": «\"left\" } } ] } } ] }",
        "did you mean `left_straight`?",
        "`right_side`",
    );
    refuses_both("{ \"ball\": { \"rolling\": «0.5 } }", "the number 0.5", "`exponential_per_s` or `constant_mps2`");
    refuses_both("{ \"cameras\": { \"width\": «320.5 } }", "320.5", "a whole number");
    refuses_both("{ \"cameras\": { \"render\": «\"sofware\" } }", "did you mean `software`?", "`gpu`");
    refuses_ron("(cycle_s: «NaN)", "`NaN` is not a finite number", "a finite number");
    refuses_ron("(robots: [(pose: (0.0, «-inf, 0.0))])", "not a finite number", "a finite number");
    refuses_json("{ \"cycle_s\": «NaN }", "`NaN` is not a finite number", "a finite number");
    refuses_json("{ \"robots\": [ { \"pose\": [0, «Infinity, 0] } ] }", "`Infinity`", "a finite number");
    refuses_both("{ \"duration_s\": «1e999 }", "", "finite number");
    refuses_both("{ \"duration_s\": «1e300 }", "1e+300", "a finite number");
}

#[test]
fn presets_that_there_are_not() {
    refuses_both(
        "{ \"field\": «\"spl2026\" }",
        "no preset `spl2026`: did you mean `spl2025`?",
        "`naoisis`, `hsl2026_small`, `hsl2026_middle`, `hsl2026_large`, `spl2010` or `spl2025`",
    );
    refuses_both("{ \"rules\": { \"preset\": «\"fre\" } }", "did you mean `free`?", "`spl2010`");
    refuses_both("{ \"rules\": { \"preset\": «3 } }", "`preset` is not the name", "`spl2010`");
    refuses_both("{ \"vision\": { \"noise\": «\"loud\" } }", "no preset `loud`", "`none`");
    refuses_ron("(robots: [(vision: (noise: «loud))])", "no preset `loud`", "`none`");
}

#[test]
fn values_out_of_range() {
    let cases = [
        ("cycle_s: «-0.1", "`cycle_s` is -0.1", "0.001 to 1 s"),
        ("cycle_s: «0", "`cycle_s` is 0", "0.001 to 1 s"),
        ("cycle_s: «30.0", "`cycle_s` is 30", "0.001 to 1 s"),
        ("duration_s: «0.0", "`duration_s` is 0", "more than 0"),
        ("duration_s: «-5.0", "`duration_s` is -5", "more than 0"),
        ("field: (length_m: «-6.0)", "length_m is -6", "1 to 120 m"),
        ("field: (preset: spl2025, goal: (width_m: «0.0))", "goal.width_m is 0", "0.2 to 6 m"),
        ("rules: (halves: «0)", "`halves` is 0", "1 to 10"),
        ("rules: (half_s: «0.0)", "`half_s` is 0", "more than 0, at most 100000 s"),
        ("rules: (penalty_s: «-30.0)", "`penalty_s` is -30", "0 to 100000 s"),
        ("rules: (preset: naoisis, stall_radius_m: «-0.5)", "`stall_radius_m` is -0.5", "100 m"),
        ("rules: (mercy_goals: «0)", "`mercy_goals` is 0", "1 to 1000 goals"),
        ("rules: (fall_from_mps: 0.5, fall_certain_mps: «0.4)", "`fall_certain_mps` is 0.4", "at least 0.5 m/s"),
        ("rules: (fall_certain_mps: «-1.0)", "`fall_certain_mps` is -1", "0 to 100 m/s"),
        ("rules: (dive_s: 1, dive_down_s: «2)", "`dive_down_s` is 2", "at most 1 s"),
        ("rules: (preset: spl2010, team_size: «12)", "`team_size` is 12", "1 to 11 robots"),
        ("ball: (radius_m: «0.0)", "`radius_m` is 0", "0.005 to 0.5 m"),
        ("ball: (radius_m: «-0.03)", "`radius_m` is -0.03", "0.005 to 0.5 m"),
        ("ball: (velocity_mps: «(90.0, 90.0))", "127", "at most 100 m/s"),
        ("ball: (rolling: exponential_per_s(«0.0))", "is 0", "more than 0"),
        ("ball: (rolling: (constant_mps2: «-0.3))", "is -0.3", "more than 0"),
        ("ball: (restitution: «1.5)", "`restitution` is 1.5", "0 to 1"),
        ("ball: (position_m: «(3.8, 0.0))", "the ball at (3.8, 0) is outside", "x within ±3.7 m and y within ±2.7 m"),
        ("ball: (position_m: «(2.975, 0.71))", "inside the post at (2.975, 0.7)", "clear of posts"),
        ("motion: (max_linear_mps: «-0.1)", "`max_linear_mps` is -0.1", "0 to 5 m/s"),
        ("motion: (max_linear_mps: «6.0)", "`max_linear_mps` is 6", "0 to 5 m/s"),
        ("motion: (max_angular_degps: «2000.0)", "`max_angular_degps` is 2000", "0 to 1080 degrees/s"),
        ("motion: (error_sd: (dx_m: «-0.1))", "`dx_m` is -0.1", "0 to 10 m"),
        ("motion: (error_sd: (dtheta_deg: «-1.0))", "`dtheta_deg` is -1", "0 to 360 degrees"),
        ("kicks: (left_side: (max_distance_m: «-0.5))", "`max_distance_m` is -0.5", "0 to 50 m"),
        ("kicks: (right_straight: (max_distance_m: «51.0))", "`max_distance_m` is 51", "0 to 50 m"),
        ("kicks: (wrong_side_speed_factor: «1.5)", "is 1.5", "0 to 1"),
        ("kicks: (wind_up_s: «-1.0)", "`wind_up_s` is -1", "0 to 60 s"),
        ("kicks: (extension_s: «-0.1)", "`extension_s` is -0.1", "0 to 60 s"),
        ("kicks: (recovery_s: «61.0)", "`recovery_s` is 61", "0 to 60 s"),
        ("kicks: (direction_sd_deg: «-1.0)", "`direction_sd_deg` is -1", "0 to 180 degrees"),
        ("kicks: (speed_sd: «-0.1)", "`speed_sd` is -0.1", "0 to 10"),
        ("head: (yaw_deg: «(120, -120))", "`yaw_deg` is [120, -120]", "the least and then the greatest"),
        ("head: (pitch_deg: («-100.0, 30.0))", "`pitch_deg[0]` is -100", "-90 to 90 degrees"),
        ("head: (max_degps: «-1.0)", "`max_degps` is -1", "0 to 3600 degrees/s"),
        ("sonar: (min_m: «-0.1)", "`min_m` is -0.1", "0 to 10 m"),
        ("sonar: (min_m: 0.8, max_m: «0.7)", "`max_m` is 0.7, and `min_m` 0.8", "more than `min_m`"),
        ("sonar: (half_angle_deg: «0.0)", "`half_angle_deg` is 0", "90 degrees"),
        ("sonar: (noise: gaussian(sd_m: «-0.01))", "`sd_m` is -0.01", "0 to 10 m"),
        ("sonar: (noise: outliers(sd_m: 0.1, probability: «2.0))", "`probability` is 2", "0 to 1, a probability"),
        ("sonar: (miss_probability: «-0.5)", "is -0.5", "a probability"),
        ("odometry: (noise: (preset: none, translation_sd_m: «-0.1))", "`translation_sd_m` is -0.1", "0 to 10 m"),
        ("vision: (noise: (ball: (miss_probability: «1.5)))", "`miss_probability` is 1.5", "a probability"),
        ("cameras: (width: «0)", "`width` is 0", "1 to 4096 pixels"),
        ("cameras: (height: «5000)", "`height` is 5000", "1 to 4096 pixels"),
        ("cameras: (diagonal_fov_deg: «175.0)", "is 175", "1 to 170 degrees"),
        ("cameras: (every_cycles: «0)", "`every_cycles` is 0", "1 to 100000 cycles"),
        ("cameras: (noise: (pixel_sd: «-1.0))", "`pixel_sd` is -1", "0 to 255"),
        ("cameras: (noise: (blur_px: «20.0))", "`blur_px` is 20", "0 to 8 pixels"),
        ("cameras: (noise: (colour_shift: (0, «300, 0)))", "is 300", "-255 to 255"),
        ("vision: (source: image), robots: [()], cameras: (render: «off)", "robots see by their images", "`software`"),
        ("messages: (loss: «1.1)", "`loss` is 1.1", "a probability"),
        ("messages: (delay_cycles: «0)", "`delay_cycles` is 0", "1 to 1000 cycles"),
        ("posts: [(radius_m: «0.0, position_m: (1, 1))]", "`radius_m` is 0", "more than 0"),
        ("posts: [(height_m: «-1.0, position_m: (1, 1))]", "`height_m` is -1", "more than 0"),
        ("posts: [(position_m: «(0.0, 3.0))]", "the post at (0, 3) is outside", "y within ±2.7 m"),
        ("teams: (blue: «\"\")", "`blue` has no name", "naoisis list teams"),
        ("robots: [()], teams: «(blue: roles)", "both", "one of the two"),
    ];
    for (marked, message, expected) in cases {
        refuses_ron(&format!("(\n    {marked},\n)"), message, expected);
    }
}

#[test]
fn interventions_that_cannot_be() {
    let cases = [
        ("penalise(robot: «blue7, reason: pushing)", "there is no robot blue7", "a robot of this scenario"),
        ("place_robot(robot: blue1, pose: «(9, 0, 0))", "(9, 0) is outside the carpet", "within"),
        ("place_ball(position_m: «(0, 9))", "(0, 9) is outside the carpet", "within"),
        ("«restart", "`restart`", "place_ball"),
    ];
    for (marked, message, expected) in cases {
        refuses_ron(&format!("(robots: [()], interventions: [(at_s: 1, do: {marked})])"), message, expected);
    }
    refuses_ron("(robots: [()], interventions: [(at_s: «-1, do: whistle)])", "`at_s` is -1", "0");
}

#[test]
fn robots_that_cannot_be() {
    let cases = [
        ("(number: «0)", "`number` is 0", "1 to 255"),
        (
            "(number: 2), (number: «2, pose: (1, 1, 0))",
            "there is a blue2 already: robots[0]",
            "no other robot of the team",
        ),
        ("(pose: «(3.71, 0, 0))", "blue1 at (3.71, 0) is outside the carpet", "x within ±3.7 m and y within ±2.7 m"),
        ("(pose: «(0, -2.8, 0))", "outside the carpet", "y within ±2.7 m"),
        ("(pose: (1, 1, 0)), (team: pink, pose: «(1.05, 1.1, 30))", "blue1 and pink1 stand in one place", "room"),
        ("(), «()", "blue1 and blue2 stand in one place", "room"),
        ("(pose: «(2.95, 0.7, 0))", "blue1 stands in the goal post at (2.975, 0.7)", "clear of posts"),
        ("(head_deg: (0, «45))", "the head's pitch is 45 degrees", "-35 to 30 degrees"),
        ("(head: (yaw_deg: (-10, 10)), head_deg: («20, 0))", "the head's yaw is 20 degrees", "-10 to 10 degrees"),
        ("(motion: (max_linear_mps: «-1))", "`max_linear_mps` is -1", "0 to 5 m/s"),
        ("(head: (max_degps: «5000))", "`max_degps` is 5000", "3600"),
        ("(sonar: (min_m: «-1))", "`min_m` is -1", "0 to 10 m"),
        ("(behaviour: «\"\")", "`behaviour` has no name", "`idle`"),
        ("(behaviour: script([(from_s: «-1, walk: (0, 0, 0))]))", "`from_s` is -1", "0 s or more"),
        (
            "(behaviour: script([(from_s: 2, until_s: «2, walk: (0, 0, 0))]))",
            "`until_s` is 2, and `from_s` 2",
            "after the start",
        ),
        (
            "(behaviour: script([(walk: (0, 0, 0)), «(from_s: 2)]))",
            "does nothing",
            "`walk`, `kick`, `head_deg`, `posture`, `request` or `say`",
        ),
    ];
    for (marked, message, expected) in cases {
        refuses_ron(&format!("(\n  robots: [\n    {marked},\n  ],\n)"), message, expected);
    }
    refuses_ron(
        "(robots: [(pose: «(1, 1, 0))], posts: [(position_m: (1.05, 1))])",
        "blue1 stands in the post",
        "clear of posts",
    );
    refuses_ron("(ball: (position_m: «(0.05, 0)), robots: [()])", "the ball at (0.05, 0) is inside blue1", "in front");
}

#[test]
fn what_a_robot_has_from_the_common_settings_is_found_there() {
    // The robot's own yaw limits contradict the common ones only after they were merged.
    refuses_ron(
        "(sonar: (min_m: 0.5, max_m: 0.7),\n robots: [(sonar: (max_m: «0.4))])",
        "`max_m` is 0.4, and `min_m` 0.5",
        "more than `min_m`",
    );
    refuses_ron("(vision: (source: «0), robots: [(vision: ())])", "the number 0", "`geometric`");
}

#[test]
fn errors_carry_their_parts() {
    let error = Scenario::from_text("(\n  seed: 1,\n  cycle_s: -1.0,\n)", Format::Ron, "some.ron").unwrap_err();
    assert_eq!(error.to_string(), "some.ron:3:12: `cycle_s` is -1; expected 0.001 to 1 s");
    assert_eq!((error.file(), error.line(), error.column()), ("some.ron", Some(3), Some(12)));
    assert_eq!(error.path().map(ToString::to_string).as_deref(), Some("cycle_s"));
    assert_eq!(error.place().map(|place| place.source_line()), Some("  cycle_s: -1.0,"));
    assert_eq!(error.kind(), ScenarioErrorKind::Value);
}

#[test]
fn files_that_cannot_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let written = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    let error = |path: &Path| {
        let error = Scenario::load(path).unwrap_err();
        assert!(error.to_string().starts_with(&format!("{}:", path.display())), "{error}");
        assert!(!error.to_string().contains('\n'), "{error}");
        error
    };
    let missing = error(&folder.path().join("mach3v3.ron"));
    assert_eq!(missing.kind(), ScenarioErrorKind::NotFound);
    assert!(missing.message().contains("no such file") && missing.message().contains("`match3v3`"), "{missing}");
    assert!(missing.expected().contains("naoisis list scenarios"), "{missing}");

    let directory = folder.path().join("folder.ron");
    fs::create_dir(&directory).unwrap();
    assert!(error(&directory).message().contains("directory"));

    let not_text = error(&written("latin1.ron", b"(\n  name: \"B\xe4r\",\n)"));
    assert_eq!((not_text.line(), not_text.column()), (Some(2), Some(11)));
    assert!(not_text.expected().contains("UTF-8"));

    let unknown = error(&written("scenario.toml", b"seed = 1"));
    assert!(unknown.expected().contains("`.ron` or `.json`"), "{unknown}");
    assert!(error(&written("scenario", b"()")).expected().contains("`.ron` or `.json`"));

    let empty = error(&written("empty.json", b""));
    assert_eq!((empty.line(), empty.column(), empty.message()), (Some(1), Some(1), "the file is empty"));

    let marked = "\u{feff}{ \"seed\": 7 }";
    assert_eq!(Scenario::load(written("byte_order_mark.json", marked.as_bytes())).unwrap().seed, 7);
}

#[test]
fn programs_get_the_faults_of_their_scenarios() {
    let entry = ScriptEntry { from_s: f64::NAN, walk: Some([0.0; 3]), ..ScriptEntry::default() };
    let behaviour = BehaviourSpec::Script(vec![entry]);
    let robot = RobotSpec { team: Team::Pink, number: 1, behaviour, ..RobotSpec::default() };
    let scenario = Scenario { robots: vec![robot], ball: None, ..Scenario::default() };
    let fault = scenario.validate().unwrap_err();
    assert_eq!(fault.path.to_string(), "robots[0].behaviour.script[0].from_s");
    assert_eq!(
        fault.to_string(),
        "robots[0].behaviour.script[0].from_s: NaN is not a finite number; expected a finite number, of single precision"
    );

    let scenario = Scenario {
        cycle_s: -1.0,
        ball: Some(BallSpec { rolling: Rolling::ConstantMps2(0.0), ..BallSpec::default() }),
        ..Scenario::default()
    };
    let paths: Vec<String> = scenario.faults().iter().map(|fault| fault.path.to_string()).collect();
    assert_eq!(paths, ["ball.rolling.constant_mps2", "cycle_s"]);
}

/// All that `ScenarioFile::check` says of a file.
fn all_errors(name: &str, text: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    let errors = ScenarioFile::check(path.to_str().unwrap(), |_| Vec::new()).err().unwrap_or_default();
    let start = format!("{}:", path.display());
    errors.iter().map(|error| error.to_string().strip_prefix(&start).unwrap().to_owned()).collect()
}

/// Checks that `ScenarioFile::check` finds these errors in a text, and no others.
fn finds(text: &str, expected: &[&str]) {
    let errors = all_errors(if text.starts_with('{') { "wrong.json" } else { "wrong.ron" }, text);
    for (error, start) in errors.iter().zip(expected) {
        assert!(error.starts_with(start), "{error}\nexpected {start}");
    }
    assert_eq!(errors.len(), expected.len(), "{errors:#?}");
}

#[test]
fn a_check_finds_all_wrong_fields_and_types_first() {
    let text = r#"(
  sede: 2,
  field: spl2026,
  ball: (radius_m: -1.0, position_m: "here"),
  sonar: (noise: (gaussian: [1])),
  robots: [
    (number: 1, pose: (0, 0), behaviour: script([(kick: (typ: left_side)), (from_s: -1.0, walk: (0, 0, 0))])),
    3,
    (number: 1, head_deg: (0, "down"), pose: (1, 1, 0)),
    (number: 4, vision: (noise: lout), pose: (-1, 1, 0)),
    (number: 5, fidelity: perfect, pose: (-1, 1, 0)),
  ],
)"#;
    let expected = [
        "2:3: there is no field `sede`: did you mean `seed`?",
        "3:10: there is no preset `spl2026`: did you mean `spl2025`?",
        "4:38: `position_m` is the text `here`; expected a list of two numbers",
        "5:29: `gaussian` is a list of 1; expected an object",
        "7:23: `pose` is a list of 2; expected a list of three numbers",
        "7:58: there is no field `typ`: did you mean `type`?",
        "8:5: `robots[1]` is the number 3; expected an object",
        "9:31: `head_deg[1]` is the text `down`; expected a number",
        "10:33: there is no preset `lout`",
        "11:27: `fidelity` is `perfect`; expected `truth`",
    ];
    finds(text, &expected);
}

#[test]
fn then_all_numbers_out_of_their_ranges() {
    let text = r#"(
  ball: (radius_m: -1.0, position_m: (9, 0)),
  cycle_s: 7,
  field: (length_m: -3, border_m: -1),
  messages: (loss: 3, delay_cycles: 0),
  motion: (max_linear_mps: 9.0),
  robots: [
    (number: 1, behaviour: script([(from_s: -1.0, walk: (0, 0, 0))])),
    (number: 1, motion: (max_linear_mps: 8.0)),
  ],
  posts: [(radius_m: 7.0)],
)"#;
    let expected = [
        "2:20: `radius_m` is -1; expected 0.005 to 0.5 m",
        "3:12: `cycle_s` is 7; expected 0.001 to 1 s",
        "4:21: length_m is -3; expected 1 to 120 m",
        "4:35: border_m is -1; expected 0.2 to 10 m",
        "5:20: `loss` is 3; expected 0 to 1, a probability",
        "5:37: `delay_cycles` is 0; expected 1 to 1000 cycles",
        "6:28: `max_linear_mps` is 9; expected 0 to 5 m/s",
        "8:45: `from_s` is -1; expected 0 s or more",
        "9:42: `max_linear_mps` is 8; expected 0 to 5 m/s",
        "11:22: `radius_m` is 7; expected more than 0, at most 1 m",
    ];
    finds(text, &expected);
}

#[test]
fn and_then_what_does_not_go_together() {
    let text = r#"{ "ball": { "position_m": [0, 0] }, "sonar": { "min_m": 0.5, "max_m": 0.4 },
        "robots": [{ "number": 1 }, { "number": 1 }, { "pose": [9, 0, 0] }] }"#;
    let expected = [
        "1:27: the ball at (0, 0) is inside blue1",
        "1:71: `max_m` is 0.4, and `min_m` 0.5; expected more than `min_m`",
        "2:37: blue1 and blue1 stand in one place",
        "2:49: there is a blue1 already: robots[0]",
        "2:64: blue2 at (9, 0) is outside the carpet",
    ];
    finds(text, &expected);
}

#[test]
fn files_and_lists_have_an_end() {
    let error = all_errors("large.json", &format!("{{ \"name\": \"{}\" }}", "x".repeat(3 << 20)));
    assert!(error[0].contains("too large for a scenario: it has more than 2 MiB; expected at most 2 MiB"), "{error:?}");
    let many = |field: &str, count: usize| format!("{{ \"{field}\": [{}] }}", vec!["{}"; count].join(","));
    for (field, most) in [("robots", 510), ("posts", 1000), ("interventions", 10_000)] {
        let errors = all_errors("many.json", &many(field, most + 1));
        let words = format!("`{field}` is a list of {}; expected at most {most}", most + 1);
        assert!(errors.iter().any(|error| error.contains(&words)), "{errors:?}");
    }
    // Of very many errors the first are told.
    let entries = vec![r#"{ "from_s": -1, "walk": [0, 0, 0] }"#; 5000].join(",");
    let errors =
        all_errors("many.json", &format!(r#"{{ "robots": [{{ "behaviour": {{ "script": [{entries}] }} }}] }}"#));
    assert_eq!(errors.len(), ScenarioFile::MOST_ERRORS);
}
