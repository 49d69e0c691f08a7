//! The names of the teams of a match.

use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::team::{PerTeam, Team};
use naoisis_sim::scenario::{BehaviourSpec, Scenario, TeamsSpec};
use std::path::Path;

/// The endings of files that another program runs.
const SCRIPTS: [&str; 10] = ["jar", "jl", "js", "lua", "mjs", "php", "py", "rb", "sh", "ts"];

/// Returns the names of both teams: those of the scenario, or those of the registered teams with the behaviours of its robots. A team
/// without a name is named by its colour, a program by its file.
pub fn team_names(scenario: &Scenario, registry: &BehaviourRegistry) -> PerTeam<String> {
    PerTeam::new(|team| match &scenario.teams {
        Some(teams) => short(teams.name(team)),
        None => name_by_behaviours(team, scenario, registry).unwrap_or(team.name()).to_owned(),
    })
}

/// Returns the name of the registered team with the behaviours of the robots of `team`; `None` for a single robot.
fn name_by_behaviours<'a>(team: Team, scenario: &Scenario, registry: &'a BehaviourRegistry) -> Option<&'a str> {
    let robots = scenario.robots.iter().filter(|robot| robot.team == team);
    let behaviours = robots.map(|robot| match &robot.behaviour {
        BehaviourSpec::Named(name) => Some((robot.number, name.as_str())),
        _ => None,
    });
    // One robot is no team: its behaviour is in several.
    registry.team_of(&behaviours.collect::<Option<Vec<_>>>().filter(|behaviours| behaviours.len() > 1)?)
}

/// The name of a team; of a command line or a policy, the name of the file without folders and ending.
fn short(name: &str) -> String {
    if let Some(file) = TeamsSpec::policy(name) {
        return Path::new(file).file_stem().and_then(|stem| stem.to_str()).unwrap_or(name).to_owned();
    }
    let Some(Some(words)) = TeamsSpec::command_line(name) else { return name.to_owned() };
    let is_script = |word: &&String| {
        Path::new(word).extension().is_some_and(|ending| SCRIPTS.iter().any(|script| ending == *script))
    };
    let is_python = words.first().is_some_and(|program| program.contains("python"));
    let module = words.iter().skip_while(|word| *word != "-m").nth(1).filter(|_| is_python);
    let file = words.iter().find(is_script).or(module).or(words.first());
    let stem = file.and_then(|file| Path::new(file).file_stem()?.to_str());
    stem.unwrap_or(name).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_are_named_by_their_files() {
        let names = [
            ("exec:python3 'my team.py' --option one", "my team"),
            ("exec:/usr/bin/python3 -u ~/robots/strikers.py", "strikers"),
            ("exec:python3 -m strikers", "strikers"),
            ("exec:./target/release/strikers --config fast.toml -m 3", "strikers"),
            ("exec:java -jar build/strikers.jar", "strikers"),
            ("roles", "roles"),
            ("exec:", "exec:"),
            ("exec:'open", "exec:'open"),
        ];
        for (name, expected) in names {
            assert_eq!(short(name), expected, "{name}");
        }
    }
}
