use super::*;
use crate::scenario::{RobotModel, Scenario};
use naoisis_core::robot::body::Body;
use naoisis_core::robot::jersey::Jersey;
use serde_json::json;

fn resolved(value: Value) -> Result<Value, Vec<ScenarioFault>> {
    let Value::Object(mut root) = value else { panic!("not an object") };
    let faults = resolve(&mut root);
    if faults.is_empty() { Ok(Value::Object(root)) } else { Err(faults) }
}

#[test]
fn presets_read_as_their_types() {
    assert_eq!(pitch_preset("naoisis"), Some(Pitch::default()));
    assert_eq!(rules_preset("naoisis"), Some(Rules::default()));
    for preset in FIELD_PRESETS {
        let pitch = pitch_preset(preset.name).unwrap();
        assert_eq!((pitch.name.as_str(), pitch.validate()), (preset.name, Ok(())));
    }
    for preset in RULES_PRESETS {
        assert_eq!(rules_preset(preset.name).unwrap().name, preset.name);
    }
    assert_eq!(pitch_preset("none"), None);
}

#[test]
fn an_object_changes_fields_of_its_preset_at_any_depth() {
    let value = resolved(json!({ "field": { "preset": "spl2025", "goal": { "width_m": 2.0 } } })).unwrap();
    let pitch: Pitch = serde_json::from_value(value["field"].clone()).unwrap();
    let mut expected = pitch_preset("spl2025").unwrap();
    expected.goal.width_m = 2.0;
    assert_eq!(pitch, expected);
}

#[test]
fn robots_change_fields_of_the_common_settings() {
    let value = resolved(json!({
        "motion": { "max_linear_mps": 0.1, "error_sd": { "dx_m": 0.01 } },
        "sonar": { "noise": { "gaussian": { "sd_m": 0.1 } }, "max_m": 0.6 },
        "vision": { "noise": { "preset": "none", "ball": { "miss_probability": 0.5 } } },
        "robots": [
            { "motion": { "error_sd": { "dy_m": 0.02 } } },
            { "sonar": { "noise": { "uniform": { "half_width_m": 0.2 } } }, "vision": { "noise": "none" } },
            { "vision": { "noise": { "ball": { "pixel_sd": 2.0 } } }, "odometry": { "noise": "default" } },
        ]
    }))
    .unwrap();
    let motion = &value["robots"][0]["motion"];
    assert_eq!(motion["error_sd"], json!({ "dx_m": 0.01, "dy_m": 0.02 }));
    assert_eq!(motion["max_linear_mps"], json!(0.1));
    let sonar = &value["robots"][1]["sonar"];
    assert_eq!((&sonar["noise"], &sonar["max_m"]), (&json!({ "uniform": { "half_width_m": 0.2 } }), &json!(0.6)));
    let noise = |robot: usize, sensor: &str| value["robots"][robot][sensor]["noise"].clone();
    assert_eq!(noise(1, "vision"), serde_json::to_value(VisionNoise::none()).unwrap());
    let common = serde_json::from_value::<VisionNoise>(value["vision"]["noise"].clone()).unwrap();
    let mut expected = common;
    expected.ball.pixel_sd = 2.0;
    assert_eq!(common.ball.miss_probability, 0.5);
    assert_eq!(serde_json::from_value::<VisionNoise>(noise(2, "vision")).unwrap(), expected);
    assert_eq!(noise(2, "odometry"), serde_json::to_value(OdometryNoise::default()).unwrap());
}

#[test]
fn noise_without_a_preset_changes_the_common_one_or_else_the_default() {
    let value = resolved(json!({
        "vision": { "noise": { "head_angle_sd_deg": 1.0 } },
        "robots": [{ "vision": { "noise": {} } }, { "odometry": { "noise": { "translation_scale": 1.5 } } }],
    }));
    let value = value.unwrap();
    let mut expected = serde_json::to_value(VisionNoise::default()).unwrap();
    expected["head_angle_sd_deg"] = json!(1.0);
    assert_eq!(value["vision"]["noise"], expected);
    assert_eq!(value["robots"][0]["vision"]["noise"], expected);
    let own: OdometryNoise = serde_json::from_value(value["robots"][1]["odometry"]["noise"].clone()).unwrap();
    assert_eq!(own, OdometryNoise { translation_scale: 1.5, ..OdometryNoise::default() });
}

#[test]
fn a_body_is_changed_field_by_field_in_any_layer() {
    let scenario = Scenario::from_json(
        r#"{ "body": { "torso": { "half_width_m": 0.2 } }, "teams": { "blue": "roles",
             "pink": { "team": "chasers", "model": "booster_k1", "body": { "height_m": 0.9 } } },
             "robots": [] }"#,
    );
    let scenario = scenario.unwrap();
    let mut expected = Body::default();
    expected.torso.half_width_m = 0.2;
    assert_eq!(scenario.settings.body, expected);
    let k1 = RobotModel::named("booster_k1").unwrap().scenario().unwrap().settings.body;
    let own = scenario.body_of(&scenario.teams.as_ref().unwrap().robot(Team::Pink, 1));
    assert_eq!(own, Body { height_m: 0.9, ..k1 });
    let robots = r#"{ "robots": [{ "body": { "base": { "half_width_m": 0.12 } } }] }"#;
    assert_eq!(Scenario::from_json(robots).unwrap().robots[0].own.body.unwrap().torso, Body::default().torso);
}

/// The NAO's values are the defaults of the types, but not of another model, so they must be written.
#[test]
fn a_scenario_that_gives_another_robot_what_a_nao_has_comes_back_from_its_own_text() {
    let nao = Scenario::from_json("{}").unwrap();
    assert_eq!(nao, Scenario::default());
    let k1 = Scenario::from_json(r#"{ "model": "booster_k1", "league": "hsl2026_middle" }"#).unwrap();
    let field = Pitch { corner_arc_radius_m: 0.0, ..k1.field.clone() };
    let RobotSettings { body, cameras, sonar, kicks, .. } = nao.settings;
    let settings = RobotSettings { body, cameras, sonar, kicks, ..k1.settings.clone() };
    let mixed = Scenario { field, settings, ..k1 };
    let again = Scenario::from_json(&serde_json::to_string(&mixed).unwrap()).unwrap();
    assert_eq!(again, mixed);
}

#[test]
fn robots_without_a_number_get_the_least_free_one() {
    let value = resolved(json!({ "robots": [{}, { "number": 1 }, { "team": "pink" }, {}] })).unwrap();
    let numbers: Vec<u64> = (0..4).map(|index| value["robots"][index]["number"].as_u64().unwrap()).collect();
    assert_eq!(numbers, [2, 1, 1, 3]);
}

#[test]
fn a_misspelled_preset_is_refused_with_the_names() {
    let fault = &resolved(json!({ "field": { "preset": "spl2052" } })).unwrap_err()[0];
    assert_eq!(fault.path.to_string(), "field.preset");
    assert_eq!(fault.message, "there is no preset `spl2052`: did you mean `spl2025`?");
    assert!(fault.expected.starts_with("`naoisis`") && fault.expected.ends_with(" or `spl2025`"), "{}", fault.expected);
    assert!(resolved(json!({ "rules": 3 })).is_err());
    let robots = json!([{ "vision": { "noise": "nothing" } }, { "odometry": { "noise": { "preset": 1 } } }]);
    let faults = resolved(json!({ "robots": robots, "rules": "spl2011" })).unwrap_err();
    let paths: Vec<String> = faults.iter().map(|fault| fault.path.to_string()).collect();
    assert_eq!(paths, ["rules", "robots[0].vision.noise", "robots[1].odometry.noise.preset"]);
}

#[test]
fn a_match_of_a_league_without_its_looks_comes_back_from_its_own_text() {
    let text = r#"{ "league": "spl2025", "ball": "spl2010", "field": { "unevenness": 0.0 }, "body": { "jersey": null },
                    "teams": { "blue": { "team": "roles", "body": { "jersey": "purple" } }, "pink": "roles" } }"#;
    let plain = Scenario::from_json(text).unwrap();
    assert_eq!((plain.ball.unwrap().look, plain.field.unevenness), (BallLook::Orange, 0.0));
    let jersey = |scenario: &Scenario, team| scenario.body_of(&scenario.teams.as_ref().unwrap().robot(team, 1)).jersey;
    assert_eq!(Team::BOTH.map(|team| jersey(&plain, team)), [Some(Jersey::Purple), None]);
    assert_eq!(Scenario::from_json(&serde_json::to_string(&plain).unwrap()).unwrap(), plain);
    let of_league =
        Scenario::from_json(r#"{ "league": "spl2025", "teams": { "blue": "roles", "pink": "roles" } }"#).unwrap();
    assert_eq!(
        (of_league.ball.unwrap().look, jersey(&of_league, Team::Pink)),
        (BallLook::Pentagons, Some(Jersey::Team))
    );
}
