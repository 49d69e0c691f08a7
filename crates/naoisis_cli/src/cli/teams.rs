//! Arguments for the teams, which replace those of a scenario.

use bevy::prelude::*;
use clap::Args;
use std::path::Path;

use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::team::Team;
use naoisis_sim::scenario::{BehaviourSpec, FieldPath, RobotSpec, Scenario, ScenarioFile, TeamsSpec};
use naoisis_sim::simulation::names;

/// Arguments that choose teams.
#[derive(Args, Debug, Clone, Default)]
pub struct TeamArguments {
    /// The blue team, instead of the scenario's: a name (see `naoisis list teams`), or your own program, which is
    /// started for each robot: "exec:python3 team.py"
    #[arg(long, value_name = "TEAM")]
    pub blue: Option<String>,
    /// The pink team, instead of the scenario's
    #[arg(long, value_name = "TEAM")]
    pub pink: Option<String>,
}

impl TeamArguments {
    /// Returns the chosen team of a colour.
    pub fn of(&self, team: Team) -> Option<&str> {
        match team {
            Team::Blue => self.blue.as_deref(),
            Team::Pink => self.pink.as_deref(),
        }
    }

    /// Returns whether a team is chosen.
    pub fn are_given(&self) -> bool {
        Team::BOTH.into_iter().any(|team| self.of(team).is_some())
    }

    /// Returns the files of the chosen teams that are learned policies.
    pub fn policies(&self) -> impl Iterator<Item = &Path> {
        Team::BOTH.into_iter().filter_map(|team| TeamsSpec::policy(self.of(team)?)).map(Path::new)
    }

    /// Sets the chosen teams in the scenario.
    pub fn choose(&self, world: &World, file: &mut ScenarioFile) -> Result<(), String> {
        let registry = world.resource::<BehaviourRegistry>();
        for team in Team::BOTH {
            let Some(name) = self.of(team) else { continue };
            if let Some(fault) = names::wrong_team(registry, &FieldPath::default(), name) {
                return Err(format!("--{}: {}", team.name(), fault.in_words()));
            }
            if name.trim().is_empty() {
                return Err(format!("--{}: expected the name of a team", team.name()));
            }
            if file.scenario.from.is_some() && file.scenario.teams.is_none() {
                give_to_robots(registry, &mut file.scenario, team, name)?;
                continue;
            }
            let Some(teams) = &mut file.scenario.teams else {
                return Err(format!(
                    "--{}: `{}` places its robots itself: expected a scenario with `teams`, such as `match3v3`",
                    team.name(),
                    file.source.name
                ));
            };
            *side_of(teams, team) = name.to_owned();
        }
        Ok(())
    }
}

/// Gives the robots of a saved match the behaviours of a team.
fn give_to_robots(registry: &BehaviourRegistry, scenario: &mut Scenario, team: Team, name: &str) -> Result<(), String> {
    let mut robots: Vec<&mut RobotSpec> = scenario.robots.iter_mut().filter(|robot| robot.team == team).collect();
    if robots.is_empty() {
        return Err(format!("--{}: the saved match has no robot of this team", team.name()));
    }
    robots.sort_by_key(|robot| robot.number);
    let size = robots.len() as u8;
    for (number, robot) in (1..).zip(robots) {
        if let Some(file) = TeamsSpec::policy(name) {
            robot.behaviour = BehaviourSpec::Policy(file.to_owned());
            continue;
        }
        robot.behaviour = match (TeamsSpec::command_line(name).flatten(), registry.team(name)) {
            (Some(words), _) => BehaviourSpec::Program(words),
            (None, Some(recipe)) => BehaviourSpec::Named(recipe.behaviour_of(number, size).into_owned()),
            (None, None) => BehaviourSpec::Named(name.to_owned()),
        };
    }
    Ok(())
}

fn side_of(teams: &mut TeamsSpec, team: Team) -> &mut String {
    match team {
        Team::Blue => &mut teams.blue,
        Team::Pink => &mut teams.pink,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::simulation::NaoisisPlugins;

    fn chosen(scenario: &str, blue: Option<&str>) -> Result<ScenarioFile, String> {
        let mut file = ScenarioFile::named(scenario).map_err(|error| error.to_string())?;
        let arguments = TeamArguments { blue: blue.map(str::to_owned), pink: None };
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        arguments.choose(app.world(), &mut file).map(|()| file)
    }

    #[test]
    fn a_team_is_one_that_there_is_or_the_command_line_of_a_program() {
        let teams = |blue| chosen("match3v3", blue).map(|file| file.scenario.teams.unwrap().blue);
        assert_eq!(teams(Some("passers")).as_deref(), Ok("passers"));
        assert_eq!(teams(Some("exec:python3 my.py")).as_deref(), Ok("exec:python3 my.py"));
        let wrong = |blue| teams(Some(blue)).unwrap_err();
        assert!(wrong("nobody").starts_with("--blue: there is no team `nobody`; expected `chasers`"));
        #[cfg(not(feature = "booster"))]
        assert!(wrong("booster").contains("built with `--features booster`"), "{}", wrong("booster"));
        assert!(wrong("exec:").contains("names no program"));
        assert!(wrong("exec:\"a b").contains("a quote that is not closed"));
        assert!(chosen("kick_right_straight", Some("roles")).unwrap_err().contains("places its robots itself"));
    }
}
