//! The names of behaviours and teams in a scenario: whether the program has what they stand for.

use crate::behaviour::BehaviourRegistry;
use crate::robot::Team;
use crate::scenario::wording::{did_you_mean, one_of, quoted};
use crate::scenario::{BehaviourSpec, FieldPath, Scenario, ScenarioFault};

/// A fault for each name that nobody has registered. That a name is empty is a fault of the scenario itself.
pub fn unknown(registry: &BehaviourRegistry, scenario: &Scenario) -> Vec<ScenarioFault> {
    let robots = scenario.robots.iter().enumerate().filter_map(|(index, robot)| match &robot.behaviour {
        BehaviourSpec::Named(name) if !name.trim().is_empty() && registry.marker_of(name).is_none() => {
            let path = FieldPath::default().field("robots").index(index).field("behaviour");
            let meant = did_you_mean(name, registry.behaviour_names());
            let expected = format!("a script, or one of {}", one_of(registry.behaviour_names()));
            Some(ScenarioFault::new(path, format!("there is no behaviour {}{meant}", quoted(name)), expected))
        }
        _ => None,
    });
    let named = scenario.teams.iter().flat_map(|teams| [(Team::Blue, &teams.blue), (Team::Pink, &teams.pink)]);
    let teams = named
        .filter(|(_, name)| !name.trim().is_empty() && registry.team(name).is_none())
        .map(|(team, name)| no_team(registry, FieldPath::default().field("teams").field(team.name()), name));
    robots.chain(teams).collect()
}

/// The fault of a team's name that nobody has registered.
pub fn no_team(registry: &BehaviourRegistry, path: FieldPath, name: &str) -> ScenarioFault {
    let names = || registry.teams().map(|(name, _)| name);
    let message = format!("there is no team {}{}", quoted(name), did_you_mean(name, names()));
    ScenarioFault::new(path, message, format!("one of {}", one_of(names())))
}
