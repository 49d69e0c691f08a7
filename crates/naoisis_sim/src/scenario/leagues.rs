//! Leagues: field, ball, rules, robots and realism that belong together, in RON files that are embedded in the program.

use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

use super::deserialize;
use super::fault::ScenarioFault;
use super::field_path::FieldPath;
use super::merge::field_of_word;
use super::preset::{Preset, presets};
use super::wording::{did_you_mean, one_of, quoted};

/// The leagues that come with the program: `assets/leagues`.
pub const LEAGUES: &[Preset] = presets![
    "leagues":
    "hsl2026_large"
    "hsl2026_large_foundation"
    "hsl2026_middle"
    "hsl2026_middle_foundation"
    "hsl2026_small"
    "hsl2026_small_foundation"
    "paper"
    "spl2010"
    "spl2025"
];

/// A league of one year: its equipment and its rules.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct League {
    /// Name of the league.
    pub name: String,
    /// Description, one sentence.
    pub description: String,
    /// Settings of a scenario, which apply if a scenario of the league does not have its own. Presets are given by name.
    pub settings: Map<String, Value>,
    /// The source of each setting, by its path.
    pub sources: BTreeMap<String, String>,
}

impl League {
    /// Returns the league with this name among the [`LEAGUES`].
    pub fn named(name: &str) -> Option<League> {
        let preset = LEAGUES.iter().find(|preset| preset.name == name)?;
        // A test reads all embedded files.
        deserialize::read(&preset.value()).ok()
    }
}

/// Adds the settings of a scenario's league where the scenario has none. Of objects, only missing fields are added.
///
/// An unknown league is removed and becomes a fault.
pub(super) fn lay_under(root: &mut Map<String, Value>, faults: &mut Vec<ScenarioFault>) {
    let Some(name) = root.get("league").filter(|name| !name.is_null()) else { return };
    let Some(league) = name.as_str().and_then(League::named) else {
        faults.push(no_league(name));
        root.remove("league");
        return;
    };
    for (field, value) in league.settings {
        match root.get_mut(&field) {
            None => {
                root.insert(field, value);
            }
            Some(Value::Object(own)) => lay_under_object(own, value, &field),
            Some(_) => {}
        }
    }
}

/// Adds the missing fields to an object. If the league names a preset, the object's own fields are changes of that preset.
fn lay_under_object(own: &mut Map<String, Value>, league: Value, field: &str) {
    let key = field_of_word(&FieldPath::from(field));
    if own.contains_key(key) {
        return;
    }
    let fields = match league {
        Value::Object(fields) => fields,
        name => Map::from_iter([(key.to_owned(), json!(name))]),
    };
    for (name, value) in fields {
        own.entry(name).or_insert(value);
    }
}

/// Returns the fault of a value that is no league's name.
fn no_league(name: &Value) -> ScenarioFault {
    let names: Vec<&str> = LEAGUES.iter().map(|preset| preset.name).collect();
    let message = match name.as_str() {
        Some(name) => format!("there is no league {}{}", quoted(name), did_you_mean(name, names.iter().copied())),
        None => "`league` is no name of a league".to_owned(),
    };
    ScenarioFault::new(FieldPath::from("league"), message, one_of(names))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{BallSpec, Realism, RealismSettings, Scenario};

    fn read(value: Value) -> Scenario {
        Scenario::from_json(&value.to_string()).unwrap()
    }

    #[test]
    fn every_league_is_played_by_its_name() {
        for preset in LEAGUES {
            let file = crate::scenario::ScenarioFile::find(preset.name).unwrap();
            assert!(file.scenario.teams.is_some(), "{}", preset.name);
            if crate::scenario::LIBRARY.iter().all(|entry| entry.name != preset.name) {
                assert_eq!(file.scenario.league.as_deref(), Some(preset.name));
            }
        }
        let error = crate::scenario::ScenarioFile::find("hsl2026_middle_fondation").unwrap_err();
        assert!(error.to_string().contains("hsl2026_middle_foundation"), "{error}");
    }

    #[test]
    fn every_setting_of_a_league_has_a_source() {
        for preset in LEAGUES {
            let league = League::named(preset.name).unwrap_or_else(|| panic!("{} is not read", preset.name));
            assert_eq!(league.name, preset.name);
            for (field, value) in &league.settings {
                let paths: Vec<String> = match value {
                    Value::Object(fields) => fields.keys().map(|name| format!("{field}.{name}")).collect(),
                    _ => vec![field.clone()],
                };
                for path in paths {
                    assert!(league.sources.contains_key(&path), "{}: {path} has no source", league.name);
                }
            }
        }
    }

    #[test]
    fn the_papers_league_is_what_is_played_without_one() {
        let paper = read(json!({ "league": "paper" }));
        assert_eq!(Scenario { league: None, ..paper }, Scenario::default());
    }

    #[test]
    fn a_scenario_has_its_leagues_settings_but_for_its_own() {
        let league = read(json!({ "league": "spl2025" }));
        assert_eq!((league.field.length_m, league.rules.team_size, league.model.as_str()), (9.0, 7, "nao_v6"));
        assert_eq!(league.realism, RealismSettings::all(Realism::Realistic));
        assert_eq!((league.ball.map(|ball| ball.radius_m), league.settings.motion.max_linear_mps), (Some(0.05), 0.242));
        let own = read(json!({
            "league": "spl2025",
            "rules": { "team_size": 3 },
            "realism": { "vision": "ideal" },
            "ball": { "position_m": [1, 0] },
            "cameras": { "width": 640, "height": 480 },
        }));
        assert_eq!((own.rules.team_size, own.rules.half_s), (3, league.rules.half_s));
        assert_eq!(own.realism, RealismSettings { vision: Realism::Ideal, ..RealismSettings::all(Realism::Realistic) });
        let ball = own.ball.unwrap();
        assert_eq!((ball.radius_m, ball.position_m.x), (0.05, 1.0));
        assert_eq!(
            (own.settings.cameras.width, own.settings.cameras.diagonal_fov),
            (640, league.settings.cameras.diagonal_fov)
        );
        // A preset in the scenario replaces that of the league as a whole.
        let other = read(
            json!({ "league": "spl2025", "rules": { "preset": "naoisis" }, "ball": "naoisis", "realism": "paper" }),
        );
        assert_eq!((other.rules.team_size, other.ball), (3, Some(BallSpec::default())));
        assert_eq!(read(json!({ "league": "spl2025", "ball": null })).ball, None);
        // A scenario that is written out in full needs no league.
        let written = own.resolved_json().unwrap();
        assert_eq!(Scenario::from_json(&written).unwrap(), own);
    }

    #[test]
    fn a_league_that_there_is_not_is_refused_with_the_names() {
        let error = Scenario::from_json(r#"{ "league": "spl2026" }"#).unwrap_err().to_string();
        assert!(
            error.contains("there is no league `spl2026`: did you mean `spl2025`? expected `hsl2026_large`"),
            "{error}"
        );
        assert!(error.ends_with("`paper`, `spl2010` or `spl2025`"), "{error}");
    }
}
