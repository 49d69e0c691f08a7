//! The names of behaviours, teams, sensors and rules in a scenario: whether the program has what they stand for.

use bevy::prelude::*;

use super::rules::RuleRegistry;
use super::sensors::SensorRegistry;
use crate::behaviour::BehaviourRegistry;
use crate::scenario::{BehaviourSpec, FieldPath, Scenario, ScenarioFault, unknown_name};
use crate::team::Team;

/// A fault for each name that nobody has registered, and for each setting of a sensor or rule of the program's own. That a name is
/// empty is a fault of the scenario itself.
pub fn unknown(world: &World, scenario: &Scenario) -> Vec<ScenarioFault> {
    let registry = world.resource::<BehaviourRegistry>();
    let root = FieldPath::default();
    let robots = scenario.robots.iter().enumerate().filter_map(|(index, robot)| match &robot.behaviour {
        BehaviourSpec::Named(name) if !name.trim().is_empty() && registry.marker_of(name).is_none() => {
            let known: Vec<&str> = registry.behaviour_names().collect();
            let path = root.field("robots").index(index).field("behaviour");
            let mut fault = unknown_name(&path, "behaviour", name, known.iter().copied());
            fault.expected = format!("a script, or {}", fault.expected);
            Some(fault)
        }
        _ => None,
    });
    let named = scenario.teams.iter().flat_map(|teams| [(Team::Blue, &teams.blue), (Team::Pink, &teams.pink)]);
    let teams = named
        .filter(|(_, name)| !name.trim().is_empty() && registry.team(name).is_none())
        .map(|(team, name)| no_team(registry, &root.field("teams").field(team.name()), name));
    let sensors = world.resource::<SensorRegistry>().faults(scenario);
    robots.chain(teams).chain(sensors).chain(world.resource::<RuleRegistry>().faults(scenario)).collect()
}

/// The fault of a team's name that nobody has registered.
pub fn no_team(registry: &BehaviourRegistry, path: &FieldPath, name: &str) -> ScenarioFault {
    let known: Vec<&str> = registry.teams().map(|(name, _)| name).collect();
    unknown_name(path, "team", name, known.iter().copied())
}
