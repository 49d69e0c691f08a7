//! The names of the teams of a match.

use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::team::{PerTeam, Team};
use naoisis_sim::scenario::{BehaviourSpec, Scenario};

/// Returns the names of both teams: those of the scenario, or those of the registered teams with the behaviours of its robots. A team
/// without a name is named by its colour.
pub fn team_names(scenario: &Scenario, registry: &BehaviourRegistry) -> PerTeam<String> {
    PerTeam::new(|team| match &scenario.teams {
        Some(teams) => teams.name(team).to_owned(),
        None => name_by_behaviours(team, scenario, registry).unwrap_or(team.name()).to_owned(),
    })
}

/// Returns the name of the registered team with the behaviours of the robots of `team`.
fn name_by_behaviours<'a>(team: Team, scenario: &Scenario, registry: &'a BehaviourRegistry) -> Option<&'a str> {
    let robots = scenario.robots.iter().filter(|robot| robot.team == team);
    let behaviours = robots.map(|robot| match &robot.behaviour {
        BehaviourSpec::Named(name) => Some((robot.number, name.as_str())),
        _ => None,
    });
    registry.team_of(&behaviours.collect::<Option<Vec<_>>>()?)
}
