//! Checks that the program knows the names of behaviours, teams, sensors and rules in a scenario.

use bevy::prelude::*;

use super::rules::RuleRegistry;
use super::sensors::SensorRegistry;
use crate::scenario::{BehaviourSpec, FieldPath, Scenario, ScenarioFault, TeamsSpec, unknown_name};
use naoisis_core::behaviour::{BehaviourRegistry, PolicyReader, REMOTE};
use naoisis_core::team::Team;

/// Returns a fault for each unregistered name, and for each invalid setting of a custom sensor or rule. Empty names are faults of the
/// scenario itself.
pub fn unknown(world: &World, scenario: &Scenario) -> Vec<ScenarioFault> {
    let registry = world.resource::<BehaviourRegistry>();
    let root = FieldPath::default();
    let robots = scenario.robots.iter().enumerate().filter_map(|(index, robot)| match &robot.behaviour {
        BehaviourSpec::Named(name) if !name.trim().is_empty() && registry.marker_of(name).is_none() => {
            let known: Vec<&str> = registry.behaviour_names().collect();
            let path = root.field("robots").index(index).field("behaviour");
            let mut fault = unknown_name(&path, "behaviour", name, known.iter().copied());
            fault.expected = format!("a script, or {}", fault.expected);
            Some(of_feature(name, fault))
        }
        BehaviourSpec::Policy(file) if !file.is_empty() => {
            no_policy(world, &root.field("robots").index(index).field("behaviour"), robot.team, file)
        }
        _ => None,
    });
    let named = scenario.teams.iter().flat_map(|teams| Team::BOTH.map(|team| (team, teams.name(team))));
    let teams = named.filter_map(|(team, name)| {
        let path = root.field("teams").field(team.name());
        match TeamsSpec::policy(name) {
            Some(file) => no_policy(world, &path, team, file),
            None => wrong_team(registry, &path, name),
        }
    });
    let sensors = world.resource::<SensorRegistry>().faults(scenario);
    robots.chain(teams).chain(sensors).chain(world.resource::<RuleRegistry>().faults(scenario)).collect()
}

/// Returns a fault if the learned policy in `file` cannot play.
fn no_policy(world: &World, path: &FieldPath, team: Team, file: &str) -> Option<ScenarioFault> {
    let problem = PolicyReader::read(world, team, file).err()?;
    Some(ScenarioFault::new(
        path.clone(),
        problem.to_string(),
        "a policy in ONNX, with its layout in a JSON file beside it",
    ))
}

/// Returns a fault if `name` is neither a registered team, the command line of a program (`exec:COMMAND`) nor the file of a learned policy
/// (`policy:FILE`), which is not read.
pub fn wrong_team(registry: &BehaviourRegistry, path: &FieldPath, name: &str) -> Option<ScenarioFault> {
    if TeamsSpec::policy(name).is_some_and(|file| !file.is_empty()) {
        return None;
    }
    match TeamsSpec::command_line(name) {
        Some(Some(words)) if words.first().is_some_and(|word| !word.is_empty()) => None,
        Some(words) => {
            let wrong = if words.is_some() { "names no program" } else { "has a quote that is not closed" };
            let expected = "the command line of a program, such as `exec:python3 my_team.py`";
            Some(ScenarioFault::new(path.clone(), format!("`{name}` {wrong}"), expected))
        }
        None if name == REMOTE => None,
        None => (!name.trim().is_empty() && registry.team(name).is_none()).then(|| no_team(registry, path, name)),
    }
}

/// Returns the fault of an unregistered team.
pub fn no_team(registry: &BehaviourRegistry, path: &FieldPath, name: &str) -> ScenarioFault {
    let known: Vec<&str> = registry.teams().map(|(name, _)| name).collect();
    of_feature(name, unknown_name(path, "team", name, known.iter().copied()))
}

/// Returns the fault of an unregistered name, with another expectation if it is registered by a program that was built with a feature.
fn of_feature(name: &str, mut fault: ScenarioFault) -> ScenarioFault {
    if name == "booster" {
        fault.expected = "a program that was built with `--features booster`".to_owned();
    }
    fault
}
