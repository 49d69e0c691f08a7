//! Rules of a program's own: in force where a scenario says so, judged, reported, recorded and saved as the built-in ones.

use bevy::prelude::*;
use naoisis::game::{Evidence, PenaltyReason};
use naoisis::prelude::*;
use naoisis::record::read::TraceReader;
use naoisis::referee::custom_rules::MOST_CUSTOM_RULES;
use naoisis::referee::report::report;
use naoisis::referee::snapshot::{MatchSnapshot, RobotSnapshot};
use naoisis::scenario::{Format, ScenarioFile};
use naoisis::simulation::{Snapshot, change_settings};
use serde::Deserialize;
use std::path::Path;

use crate::support::{begin_trace, blue, collect_events, headless_app};

/// Nobody may stay on the halfway line.
#[derive(Deserialize, Default)]
#[serde(default, deny_unknown_fields)]
struct Loitering {
    limit_s: f32,
}

impl CustomRule for Loitering {
    fn advance(&self, cycles: u64, _seen: &MatchSnapshot, robot: &RobotSnapshot) -> u64 {
        if robot.pose.position.x.abs() < 0.2 { cycles + 1 } else { 0 }
    }

    fn judge(&self, cycles: u64, seen: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence> {
        (cycles >= seen.cycles(self.limit_s)).then(|| {
            seen.evidence_against("Nobody may stay on the halfway line.", robot)
                .with_measurement("s on the line", seen.seconds(cycles), self.limit_s)
                .otherwise("It had to leave the line in time.")
        })
    }
}

/// A rule that ignores misspelt settings.
#[derive(Deserialize, Default)]
#[serde(default)]
struct LaxLoitering {
    limit_s: f32,
}

impl CustomRule for LaxLoitering {
    fn advance(&self, cycles: u64, _: &MatchSnapshot, _: &RobotSnapshot) -> u64 {
        cycles
    }

    fn judge(&self, _: u64, _: &MatchSnapshot, _: &RobotSnapshot) -> Option<Evidence> {
        (self.limit_s < 0.0).then(Evidence::default)
    }
}

fn app() -> App {
    let mut app = headless_app();
    app.add_rule::<Loitering>("loitering");
    app
}

fn scenario(own: &str) -> Scenario {
    let json = format!(
        r#"{{ "rules": {{ "preset": "free", "own": {own} }}, "ball": null,
             "robots": [{{ "number": 1, "pose": [0.19, 1, 0] }}, {{ "number": 2, "pose": [0.21, -1, 0] }}] }}"#
    );
    Scenario::from_json(&json).unwrap()
}

/// The penalties of so many cycles: when, whom and what for.
fn penalties(app: &mut App, cycles: usize) -> Vec<(u64, RobotId, String)> {
    let penalty = |(cycle, event): (u64, MatchEvent)| match &event {
        MatchEvent::Penalty { robot, .. } => Some((cycle, *robot, event.kind())),
        _ => None,
    };
    collect_events(app, cycles).into_iter().filter_map(penalty).collect()
}

#[test]
fn a_rule_is_in_force_where_the_rules_name_it() {
    let mut app = app();
    app.start_match(&scenario(r#"{ "loitering": { "limit_s": 2 } }"#)).unwrap();
    // 2 s of 1/30 s; just inside the line's 0.2 m, and just outside.
    assert_eq!(penalties(&mut app, 90), [(60, blue(1), "penalty loitering".to_owned())]);
    for off in ["{}", r#"{ "loitering": null }"#] {
        app.start_match(&scenario(off)).unwrap();
        assert_eq!(penalties(&mut app, 90), []);
    }
    // It is switched on in the middle of a match, and counts from there.
    let mut on = scenario("{}");
    on.rules.own.set("loitering", Some(serde_json::json!({ "limit_s": 1 })));
    change_settings(app.world_mut(), &on).unwrap();
    assert_eq!(penalties(&mut app, 90), [(120, blue(1), "penalty loitering".to_owned())]);
}

#[test]
fn what_is_wrong_with_its_settings_is_located() {
    for (rules, expected) in [
        (r#"{ "own": { "loiterin": {} } }"#, "rules.json:1:23: there is no rule `loiterin`: did you mean `loitering`?"),
        (
            r#"{ "own": { "loitering": { "limt_s": 2 } } }"#,
            "rules.json:1:38: there is no field `limt_s`: did you mean `limit_s`?",
        ),
        (
            r#"{ "own": { "loitering": { "limit_s": "two" } } }"#,
            "rules.json:1:49: `limit_s` is the text `two`; expected a number",
        ),
    ] {
        let file = ScenarioFile::from_text(&format!(r#"{{ "rules": {rules} }}"#), Format::Json, "rules.json").unwrap();
        let fault = app().start_match(&file.scenario).err().unwrap();
        let error = file.source.error(&fault).to_string();
        assert!(error.starts_with(expected), "{error}");
    }
    let penalise = |reason: &str| {
        let json = format!(
            r#"{{ "robots": [{{}}], "interventions": [{{ "at_s": 1, "do": {{ "penalise": {{ "robot": "blue1", "reason": "{reason}" }} }} }}] }}"#
        );
        app().start_match(&Scenario::from_json(&json).unwrap()).map(|_| ()).map_err(|fault| fault.to_string())
    };
    assert_eq!(penalise("pushing"), Ok(()));
    assert_eq!(penalise("loitering"), Ok(()));
    let error = penalise("pushhing").unwrap_err();
    assert!(error.contains("there is no penalty `pushhing`: did you mean `pushing`?"), "{error}");
}

#[test]
fn a_verdict_is_reported_traced_and_saved() {
    let mut app = app();
    let scenario = scenario(r#"{ "loitering": { "limit_s": 2 } }"#);
    app.start_match(&scenario).unwrap();
    let bytes = begin_trace(&mut app);
    app.run_cycles(60);
    let penalty = app.events().iter().find(|event| matches!(event, MatchEvent::Penalty { .. })).unwrap().clone();
    let report = report(2.0, None, &penalty).unwrap();
    assert!(
        report.contains("blue1 is penalised for loitering until") && report.contains("Nobody may stay"),
        "{report}"
    );
    let mut reader = TraceReader::new(Path::new("rules"), std::io::Cursor::new(bytes.written())).unwrap();
    assert_eq!(reader.scenario(), &scenario);
    let last = core::iter::from_fn(|| reader.next_cycle().unwrap()).last().unwrap();
    assert!(last.events.contains(&penalty));
    let reason = PenaltyReason::Custom("loitering".parse().unwrap());
    assert_eq!(last.robots[0].penalised.as_ref().unwrap().reason, reason);

    // A match that was saved on the way judges at the same time.
    app.start_match(&scenario).unwrap().run_cycles(40);
    let saved = Snapshot::take(app.world_mut()).unwrap().to_bytes(app.world()).unwrap();
    let mut other = self::app();
    Snapshot::from_bytes(&saved, other.world()).unwrap().restore(other.world_mut()).unwrap();
    assert_eq!(penalties(&mut other, 40), [(60, blue(1), "penalty loitering".to_owned())]);
}

#[test]
fn a_rule_with_the_name_of_another_is_refused() {
    let mut app = app();
    let mut refused = |name: &str| app.try_add_rule::<Loitering>(name).err().unwrap().to_string();
    assert!(refused("loitering").contains("another rule has this name"));
    assert!(refused("pushing").contains("another rule has this name"));
    assert!(refused("Time wasting").contains("is no word"));
    let lax = app.try_add_rule::<LaxLoitering>("lax").err().unwrap().to_string();
    assert!(lax.contains("deny_unknown_fields"), "{lax}");
    // As many as there is room for beside those that are there.
    let error = (1..=MOST_CUSTOM_RULES)
        .find_map(|number| app.try_add_rule::<Loitering>(&format!("loitering_{number}")).err())
        .expect("there is room for no more");
    assert!(error.to_string().contains("8 rules"), "{error}");
}
