//! Lays settings over others, field by field.

use serde_json::{Map, Value};

use super::field_path::{FieldPath, Segment};
use naoisis_core::kick_geometry::KickType;
use naoisis_core::robot::look::Look;
use naoisis_core::team::Team;

/// Fields whose value is a choice with contents, as object and field. Another choice replaces the whole value.
const CHOICES: [(&str, &str); 2] = [("sonar", "noise"), ("ball", "rolling")];

/// Settings that all kicks of a robot share. `extension_s` is not among them, because older traces do not have it.
const COMMON_TO_KICKS: [&str; 5] =
    ["wrong_side_speed_factor", "wind_up_s", "recovery_s", "direction_sd_deg", "speed_sd"];

/// Returns whether `kicks` is complete, as in the header of a trace. A complete value is not laid over a model's kicks, so that it does not
/// get the model's custom kicks.
fn says_all_of_kicks(kicks: &Value) -> bool {
    let says_region = |kick: KickType| kicks.get(kick.name()).is_some_and(|kick| kick.get("region").is_some());
    COMMON_TO_KICKS.iter().all(|field| kicks.get(field).is_some()) && KickType::ALL.into_iter().all(says_region)
}

/// Returns the field that a word stands for if it is in place of an object: `rules: "spl2010"` is `rules: (preset: "spl2010")`.
pub fn field_of_word(path: &FieldPath) -> &'static str {
    match path.segments() {
        [Segment::Field(realism)] if realism == "realism" => "all",
        [Segment::Field(teams), _] if teams == "teams" => "team",
        _ => "preset",
    }
}

/// Calls `act` with the settings of each team in the scenario `root`, and then of each robot, and with their paths.
pub(super) fn for_each_team_and_robot(
    root: &mut Map<String, Value>,
    mut act: impl FnMut(&mut Map<String, Value>, &FieldPath),
) {
    let path = FieldPath::default();
    if let Some(Value::Object(teams)) = root.get_mut("teams") {
        for team in Team::BOTH {
            if let Some(Value::Object(robots)) = teams.get_mut(team.name()) {
                act(robots, &path.field("teams").field(team.name()));
            }
        }
    }
    if let Some(Value::Array(robots)) = root.get_mut("robots") {
        for (index, robot) in robots.iter_mut().enumerate() {
            if let Value::Object(robot) = robot {
                act(robot, &path.field("robots").index(index));
            }
        }
    }
}

/// Lays `own` over `base`: objects field by field, other values as a whole. `field` is the name of both.
pub fn lay_over(base: &mut Value, own: Value, field: &str) {
    match (base, own) {
        (base, own) if field == "kicks" && says_all_of_kicks(&own) => *base = own,
        (base @ Value::String(_), own @ Value::Object(_)) if field == "look" => {
            // Replace the word by its fields.
            let look = base.as_str().and_then(Look::named).unwrap_or_default();
            *base = serde_json::to_value(look.fields()).unwrap_or_default();
            lay_over(base, own, field);
        }
        (Value::Object(base), Value::Object(own)) => {
            for (name, own) in own {
                match base.get_mut(&name) {
                    Some(base) if !CHOICES.contains(&(field, name.as_str())) => lay_over(base, own, &name),
                    _ => {
                        base.insert(name, own);
                    }
                }
            }
        }
        (base, own) => *base = own,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::robot::kick::KickSettings;
    use serde_json::json;

    #[test]
    fn kicks_that_say_all_are_no_changes_of_others_and_kicks_that_say_some_are() {
        let others = json!({ "kicks": { "wind_up_s": 0.5, "own": { "visual": { "max_distance_m": 6 } } } });
        let all = serde_json::to_value(KickSettings::default()).unwrap();
        let mut whole = others.clone();
        lay_over(&mut whole, json!({ "kicks": all }), "");
        assert_eq!(whole["kicks"], all);
        let mut changed = others.clone();
        lay_over(&mut changed, json!({ "kicks": { "wind_up_s": 0.7, "own": { "heel": {} } } }), "");
        assert_eq!(changed["kicks"]["wind_up_s"], 0.7);
        assert_eq!(changed["kicks"]["own"].as_object().map(|own| own.len()), Some(2));
    }
}
