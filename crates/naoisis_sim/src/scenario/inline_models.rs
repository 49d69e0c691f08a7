//! Inline models: `model: (preset: "booster_k1", body: (height_m: 0.9))` is the same as the preset's name as model, with the other settings
//! beside it.

use serde_json::{Map, Value};

use super::fault::ScenarioFault;
use super::field_path::FieldPath;
use super::merge::{for_each_team_and_robot, lay_over};
use super::message_limits;
use super::models::expected_model;
use super::wording::{did_you_mean, one_of, quoted};

/// Splits inline models of the scenario, of teams, and of robots into a name and settings. `settings` are the names of the settings that a
/// model has.
pub(super) fn take_apart(root: &mut Map<String, Value>, settings: &[&str], faults: &mut Vec<ScenarioFault>) {
    if let Some(Value::Object(model)) = root.get_mut("model") {
        message_limits::make_of_robots(model);
    }
    take_apart_of(root, &FieldPath::default(), settings, faults);
    for_each_team_and_robot(root, |holder, path| take_apart_of(holder, path, settings, faults));
}

/// Splits the inline model of one object.
fn take_apart_of(
    holder: &mut Map<String, Value>,
    path: &FieldPath,
    settings: &[&str],
    faults: &mut Vec<ScenarioFault>,
) {
    let Some(Value::Object(fields)) = holder.get_mut("model") else { return };
    let mut fields = core::mem::take(fields);
    let path = path.field("model");
    match fields.remove("preset") {
        Some(name @ Value::String(_)) => holder.insert("model".to_owned(), name),
        preset => {
            let (path, message) = match preset {
                None => (path.clone(), "the model has no `preset`".to_owned()),
                Some(_) => (path.field("preset"), "`preset` is no name of a model".to_owned()),
            };
            faults.push(ScenarioFault::new(path, message, expected_model()));
            holder.remove("model")
        }
    };
    for (name, of_model) in fields {
        if !settings.contains(&name.as_str()) {
            let meant = did_you_mean(&name, settings.iter().copied());
            let message = format!("a model has no {}{meant}", quoted(&name));
            faults.push(ScenarioFault::new(path.key(&name), message, one_of(settings.iter().copied())).at_key());
            continue;
        }
        let mut value = of_model;
        if let Some(own) = holder.remove(&name) {
            lay_over(&mut value, own, &name);
        }
        holder.insert(name, value);
    }
}

#[cfg(test)]
mod tests {
    use crate::scenario::{RobotModel, Scenario};
    use naoisis_core::robot::body::Body;
    use naoisis_core::robot::jersey::Jersey;
    use naoisis_core::team::Team;

    #[test]
    fn a_model_written_where_it_is_used_is_its_preset_with_changes() {
        let scenario = Scenario::from_json(
            r#"{ "league": "hsl2026_middle", "model": { "body": { "height_m": 0.9 }, "kicks": { "speed_sd": 0.0 } },
                 "kicks": { "wind_up_s": 0.1 },
                 "teams": { "blue": "roles", "pink": { "team": "roles", "model": { "preset": "nao_v6", "sonar": { "max_m": 0.5 } } } } }"#,
        );
        let scenario = scenario.unwrap();
        let jersey = Some(Jersey::Team);
        let k1 = RobotModel::named("booster_k1").unwrap().scenario().unwrap();
        assert_eq!(
            (scenario.model.as_str(), scenario.settings.body),
            ("booster_k1", Body { height_m: 0.9, jersey, ..k1.settings.body })
        );
        assert_eq!((scenario.settings.kicks.speed_sd, scenario.settings.kicks.wind_up_s), (0.0, 0.1));
        let pink = scenario.teams.unwrap().robot(Team::Pink, 2);
        assert_eq!((pink.model.as_deref(), pink.own.sonar.unwrap().max_m), (Some("nao_v6"), 0.5));
        assert_eq!(pink.own.body, Some(Body { jersey, ..Body::default() }));
    }

    #[test]
    fn what_is_wrong_in_it_is_told_where_it_stands() {
        for (text, place, message) in [
            (r#"{ "model": { "body": {} } }"#, "1:12", "the model has no `preset`"),
            (
                r#"{ "model": { "preset": "nao", "bodyy": {} } }"#,
                "1:31",
                "a model has no `bodyy`: did you mean `body`?",
            ),
            (r#"{ "model": { "preset": "nao_6" } }"#, "1:12", "there is no model `nao_6`"),
            (r#"{ "model": { "preset": "nao", "body": { "height_m": -1 } } }"#, "1:53", "-1"),
            (r#"{ "robots": [{ "model": { "preset": 3 } }] }"#, "1:37", "`preset` is no name of a model"),
        ] {
            let error = Scenario::from_json(text).unwrap_err().to_string();
            assert!(error.contains(message) && error.contains(&format!(":{place}:")), "{text}\n{error}");
        }
    }
}
