//! Custom rules: judged by the referee, with settings in scenario files.
//!
//! A rule is a type with the rule's settings. [`CustomRule`] says when a robot breaks the rule, and with what evidence.
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::game::Evidence;
//! use naoisis::prelude::*;
//! use naoisis::referee::snapshot::{MatchSnapshot, RobotSnapshot};
//! use serde::Deserialize;
//!
//! /// Nobody may stay on the halfway line.
//! #[derive(Deserialize)]
//! #[serde(default, deny_unknown_fields)]
//! struct Loitering {
//!     limit_s: f32,
//! }
//!
//! impl Default for Loitering {
//!     fn default() -> Self {
//!         Self { limit_s: 5.0 }
//!     }
//! }
//!
//! impl CustomRule for Loitering {
//!     fn advance(&self, cycles: u64, _seen: &MatchSnapshot, robot: &RobotSnapshot) -> u64 {
//!         if robot.pose.position.x.abs() < 0.2 { cycles + 1 } else { 0 }
//!     }
//!
//!     fn judge(&self, cycles: u64, seen: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence> {
//!         (cycles >= seen.cycles(self.limit_s)).then(|| {
//!             seen.evidence_against("Nobody may stay on the halfway line.", robot)
//!                 .with_measurement("s on the line", seen.seconds(cycles), self.limit_s)
//!                 .otherwise("It had to leave the line in time.")
//!         })
//!     }
//! }
//!
//! let mut app = App::new();
//! app.add_plugins(NaoisisPlugins).add_rule::<Loitering>("loitering");
//! app.start_match(&Scenario::from_json(
//!     r#"{ "rules": { "preset": "free", "own": { "loitering": { "limit_s": 2 } } }, "robots": [{ "pose": [0, 1, 0] }] }"#,
//! )?)?;
//! let penalised = app.run_until(61, |app| {
//!     app.events().iter().any(|event| event.kind() == "penalty loitering")
//! });
//! assert!(penalised && app.cycle() == 60);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! A registered rule is in force if a scenario's rules have its name under `"own"`, even with just `{}`. Like built-in rules, it is
//! switched on by each scenario. Its verdicts are events, are explained by `--explain`, counted in tables, and replayed.

use bevy::prelude::*;
use core::marker::PhantomData;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::BTreeMap;

use super::sensors::accepts_unknown_fields;
use crate::scenario::{FieldPath, Scenario, ScenarioFault, read_settings, unknown_name};
use naoisis_core::cycle::{BeginCycle, Cycle, CycleSystems};
use naoisis_core::game::{Intervention, PenaltyReason, RuleName, Rules};
use naoisis_core::referee::custom_rules::{CustomRule, CustomRules, MOST_CUSTOM_RULES};

/// Puts custom rules into force, as set in the rules of the match.
pub struct CustomRulesPlugin;

impl Plugin for CustomRulesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<RuleRegistry>().add_systems(
            Cycle,
            put_in_force.run_if(resource_changed::<Rules>).in_set(CycleSystems::First).after(BeginCycle),
        );
    }
}

/// Why a rule was refused.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RuleError {
    /// The name is not valid.
    #[error("the rule `{0}` is refused: its name is no word of at most 32 lower-case letters, digits and underscores")]
    NotAName(String),
    /// The name belongs to another rule.
    #[error("the rule `{0}` is refused: another rule has this name; give it a name of its own")]
    NameTaken(RuleName),
    /// The rule accepts settings that do not exist, so that misspelt ones would be ignored.
    #[error(
        "the rule `{0}` is refused: it accepts settings that it does not have; add `#[serde(deny_unknown_fields)]` to its type"
    )]
    AcceptsUnknownFields(RuleName),
    /// There are too many custom rules.
    #[error("the rule `{0}` is refused: a program can have {MOST_CUSTOM_RULES} rules of its own")]
    TooMany(RuleName),
}

naoisis_core::debug_as_displayed!(RuleError);

/// Methods of [`App`] that register rules.
pub trait RuleApp {
    /// Registers a rule about single robots. Scenarios switch it on by its name, which its verdicts have, too.
    ///
    /// # Errors
    /// [`RuleError`] if the name is not valid or belongs to another rule, or if there are too many rules.
    fn try_add_rule<Rule: CustomRule + Default + DeserializeOwned>(
        &mut self,
        name: &str,
    ) -> Result<&mut Self, RuleError>;

    /// Does the same as [`RuleApp::try_add_rule`], for a rule that cannot be refused.
    ///
    /// # Panics
    /// If the rule is refused.
    #[track_caller]
    fn add_rule<Rule: CustomRule + Default + DeserializeOwned>(&mut self, name: &str) -> &mut Self {
        match self.try_add_rule::<Rule>(name) {
            Ok(app) => app,
            Err(error) => panic!("{error}"),
        }
    }
}

impl RuleApp for App {
    fn try_add_rule<Rule: CustomRule + Default + DeserializeOwned>(
        &mut self,
        name: &str,
    ) -> Result<&mut Self, RuleError> {
        let name = name.parse::<RuleName>().map_err(|_| RuleError::NotAName(name.to_owned()))?;
        let mut registry = self.world_mut().get_resource_or_init::<RuleRegistry>();
        let is_built_in = PenaltyReason::built_in_names().any(|built_in| built_in == name.as_str());
        if is_built_in || registry.rules.contains_key(&name) {
            return Err(RuleError::NameTaken(name));
        }
        if accepts_unknown_fields::<Rule>() {
            return Err(RuleError::AcceptsUnknownFields(name));
        }
        let place = registry.rules.len();
        if place >= MOST_CUSTOM_RULES {
            return Err(RuleError::TooMany(name));
        }
        let settings = Box::new(SettingsOf::<Rule>(PhantomData));
        registry.rules.insert(name, RegisteredRule { place, settings });
        Ok(self)
    }
}

/// The registered rules, by name.
#[derive(Resource, Default)]
pub struct RuleRegistry {
    rules: BTreeMap<RuleName, RegisteredRule>,
}

/// A registered rule without its type.
struct RegisteredRule {
    place: usize,
    settings: Box<dyn ReadRule>,
}

/// Makes a rule from its settings.
trait ReadRule: Send + Sync {
    fn read(&self, settings: &Value, path: &FieldPath) -> Result<Box<dyn CustomRule>, ScenarioFault>;
}

struct SettingsOf<Rule>(PhantomData<fn() -> Rule>);

impl<Rule: CustomRule + DeserializeOwned> ReadRule for SettingsOf<Rule> {
    fn read(&self, settings: &Value, path: &FieldPath) -> Result<Box<dyn CustomRule>, ScenarioFault> {
        Ok(Box::new(read_settings::<Rule>(settings, path)?))
    }
}

impl RuleRegistry {
    /// Returns the names of all rules, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.rules.keys().map(RuleName::as_str)
    }

    fn get(&self, name: &str) -> Option<(RuleName, &RegisteredRule)> {
        let name: RuleName = name.parse().ok()?;
        Some((name, self.rules.get(&name)?))
    }

    /// Returns the faults of a scenario's custom rules: unregistered names and invalid settings.
    pub(super) fn faults(&self, scenario: &Scenario) -> Vec<ScenarioFault> {
        let path = FieldPath::from("rules.own");
        let of_settings = scenario.rules.own.0.iter().filter_map(|(name, settings)| {
            let path = path.key(name);
            match self.get(name) {
                None => Some(unknown_name(&path, "rule", name, self.names()).at_key()),
                Some(_) if settings.is_null() => None,
                Some((_, rule)) => rule.settings.read(settings, &path).err(),
            }
        });
        let mut faults: Vec<ScenarioFault> = of_settings.collect();
        for (index, timed) in scenario.interventions.iter().enumerate() {
            if let Intervention::Penalise { reason: PenaltyReason::Custom(name), .. } = timed.intervention
                && !self.rules.contains_key(&name)
            {
                let path = FieldPath::from("interventions").index(index).field("do.penalise.reason");
                let known = PenaltyReason::built_in_names().chain(self.names());
                faults.push(unknown_name(&path, "penalty", name.as_str(), known));
            }
        }
        faults
    }
}

fn put_in_force(rules: Res<Rules>, registry: Res<RuleRegistry>, mut own: ResMut<CustomRules>) {
    *own = CustomRules::default();
    for (name, settings) in rules.own.0.iter().filter(|(_, settings)| !settings.is_null()) {
        let Some((name, rule)) = registry.get(name) else { continue };
        // Invalid settings were found before the match started.
        if let Ok(in_force) = rule.settings.read(settings, &FieldPath::default()) {
            own.add(name, rule.place, in_force);
        }
    }
}
