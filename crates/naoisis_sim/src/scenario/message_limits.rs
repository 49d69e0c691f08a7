//! The limits of messages that a model has: they are of its robots, where those of a scenario are of the match.

use serde_json::{Map, Value};

use naoisis_core::communication::MessageLimits;

/// Makes the limits among the settings of a model those of robots: in a scenario's `messages` they would be the match's.
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

/// Leaves of a model's messages what a single robot can have: its limits. How messages travel is the match's.
pub(super) fn keep_only(settings: &mut Map<String, Value>) {
    let limits = taken_out(settings);
    settings.remove("messages");
    if !limits.is_empty() {
        settings.insert("messages".to_owned(), Value::Object(limits));
    }
}

/// What a robot has that says nothing of its messages itself.
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

    /// The limits of robots 1 of both teams.
    fn limits(text: &str) -> [(Option<u32>, Option<u32>); 2] {
        let scenario = Scenario::from_json(text).unwrap();
        // What is written out says the same.
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
        // The model of all, in which a team changes something.
        let teams =
            r#""teams": { "blue": "roles", "pink": { "team": "roles", "messages": { "max_text_bytes": 40 } } }"#;
        let all = limits(&format!(r#"{{ "league": "hsl2026_middle", "model": {k1}, {teams} }}"#));
        assert_eq!(all, [(Some(100), Some(600)), (Some(40), Some(600))]);
        // The model of one team; the other has the league's limit alone.
        let teams = format!(r#""teams": {{ "blue": "roles", "pink": {{ "team": "roles", "model": {k1} }} }}"#);
        let one = limits(&format!(r#"{{ "league": "hsl2026_middle", {teams} }}"#));
        assert_eq!(one, [(Some(512), None), (Some(100), Some(600))]);
        // Another model has not those of the scenario's.
        let teams = r#""teams": { "blue": "roles", "pink": { "team": "roles", "model": "nao_v6" } }"#;
        let other = limits(&format!(r#"{{ "league": "hsl2026_middle", "model": {k1}, {teams} }}"#));
        assert_eq!(other, [(Some(100), Some(600)), (Some(512), None)]);
        // More than the match allows is no more than that.
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
