//! The message limits of a model. They apply to each robot, while those of a scenario apply to the match.

use serde_json::{Map, Value};

use naoisis_core::communication::MessageLimits;

/// Moves the message limits of a model to `messages.robots`, because elsewhere in `messages` they would be those of the match.
pub(super) fn make_of_robots(settings: &mut Map<String, Value>) {
    let limits = taken_out(settings);
    if limits.is_empty() {
        return;
    }
    if let Some(Value::Object(messages)) = settings.get_mut("messages")
        && let Value::Object(robots) = messages.entry("robots").or_insert_with(|| Value::Object(Map::new()))
    {
        robots.extend(limits);
    }
}

/// Keeps only the limits of a model's messages. The other settings of messages belong to the match.
pub(super) fn keep_only(settings: &mut Map<String, Value>) {
    let limits = taken_out(settings);
    settings.remove("messages");
    if !limits.is_empty() {
        settings.insert("messages".to_owned(), Value::Object(limits));
    }
}

/// Returns the limits of robots that have none of their own.
pub(super) fn common(root: &Map<String, Value>) -> Option<Value> {
    root.get("messages")?.get("robots").cloned()
}

fn taken_out(settings: &mut Map<String, Value>) -> Map<String, Value> {
    let Some(Value::Object(messages)) = settings.get_mut("messages") else { return Map::new() };
    let taken = MessageLimits::FIELDS.iter().filter_map(|field| messages.remove_entry(*field));
    taken.filter(|(_, value)| !value.is_null()).collect()
}

#[cfg(test)]
mod tests {
    use crate::scenario::Scenario;
    use naoisis_core::communication::MessageLimits;
    use naoisis_core::team::{RobotId, Team};

    /// Returns the limits of robot 1 of each team.
    fn limits(text: &str) -> [(Option<u32>, Option<u32>); 2] {
        let scenario = Scenario::from_json(text).unwrap();
        // The written scenario has the same limits.
        assert_eq!(Scenario::from_json(&scenario.resolved_json().unwrap()).unwrap(), scenario);
        Team::BOTH.map(|team| {
            let limits = scenario.message_limits_of(&scenario.robot(RobotId::new(team, 1)));
            let MessageLimits { max_text_bytes, max_messages, .. } = limits;
            (max_text_bytes, max_messages)
        })
    }

    #[test]
    fn a_team_has_its_own_limits_and_else_those_of_its_model() {
        let k1 = r#"{ "preset": "booster_k1", "messages": { "max_text_bytes": 100, "max_messages": 600 } }"#;
        // A team changes a limit of the common model.
        let teams =
            r#""teams": { "blue": "roles", "pink": { "team": "roles", "messages": { "max_text_bytes": 40 } } }"#;
        let all = limits(&format!(r#"{{ "league": "hsl2026_middle", "model": {k1}, {teams} }}"#));
        assert_eq!(all, [(Some(100), Some(600)), (Some(40), Some(600))]);
        // Only one team has the model. The other team has the league's limit.
        let teams = format!(r#""teams": {{ "blue": "roles", "pink": {{ "team": "roles", "model": {k1} }} }}"#);
        let one = limits(&format!(r#"{{ "league": "hsl2026_middle", {teams} }}"#));
        assert_eq!(one, [(Some(512), None), (Some(100), Some(600))]);
        // Another model does not have the limits of the scenario's model.
        let teams = r#""teams": { "blue": "roles", "pink": { "team": "roles", "model": "nao_v6" } }"#;
        let other = limits(&format!(r#"{{ "league": "hsl2026_middle", "model": {k1}, {teams} }}"#));
        assert_eq!(other, [(Some(100), Some(600)), (Some(512), None)]);
        // A robot's limit cannot exceed that of the match.
        let teams =
            r#""teams": { "blue": { "team": "roles", "messages": { "max_text_bytes": 2000 } }, "pink": "roles" }"#;
        assert_eq!(limits(&format!("{{ {teams} }}")), [(Some(128), None); 2]);
    }

    #[test]
    fn what_is_wrong_with_limits_is_told_where_it_stands() {
        for (text, message) in [
            (
                r#"{ "teams": { "blue": { "team": "roles", "messages": { "max_text_byte": 4 } } } }"#,
                "did you mean `max_text_bytes`?",
            ),
            (r#"{ "robots": [{ "messages": { "loss": 0.5 } }] }"#, "no field `loss`"),
            (r#"{ "robots": [{ "messages": { "max_text_bytes": 70000 } }] }"#, "expected 0 to 65507 bytes"),
            (
                r#"{ "robots": [{ "messages": { "max_text_bytes": 3 }, "behaviour": { "script": [{ "from_s": 0, "say": { "payload": "abcd" } }] } }] }"#,
                "at most 3 bytes",
            ),
        ] {
            let error = Scenario::from_json(text).unwrap_err().to_string();
            assert!(error.contains(message), "{text}\n{error}");
        }
    }
}
