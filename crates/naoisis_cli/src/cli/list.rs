//! `naoisis list`: names and descriptions of what is available.

use bevy::ecs::world::World;
use clap::{Args, ValueEnum};
use std::process::ExitCode;

use super::report;
use super::report::CommandResult;
use super::terminal::Printer;
use naoisis_agents::environment::Challenge;
use naoisis_agents::environment::challenge::CHALLENGES;
use naoisis_core::ball::Rolling;
use naoisis_core::behaviour::{BehaviourRegistry, TeamRecipe};
use naoisis_record::record::formats::LogFormats;
use naoisis_sim::scenario::{
    BALL_PRESETS, BallSpec, FIELD_PRESETS, LEAGUES, LIBRARY, League, MODELS, RULES_PRESETS, RobotModel, ScenarioError,
    pitch_preset, rules_preset,
};

/// The number of robots in the largest possible team.
const LARGEST_TEAM: u8 = 11;

/// Arguments of `naoisis list`.
#[derive(Args, Debug, Clone)]
pub struct ListArguments {
    /// What to list
    #[arg(value_enum)]
    pub what: Listing,
}

/// What can be listed.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub enum Listing {
    /// Built-in scenarios
    Scenarios,
    /// Teams that scenarios can line up
    Teams,
    /// Behaviours that scenarios can give to robots
    Behaviours,
    /// Presets of fields
    Fields,
    /// Presets of rules
    Rules,
    /// Presets of balls
    Balls,
    /// Models of robots
    #[value(alias = "models")]
    Robots,
    /// Leagues: field, ball, rules, robots and realism together
    Leagues,
    /// Learning tasks
    Challenges,
    /// Log formats
    Logs,
}

/// Prints names and descriptions, one line each.
pub fn list(arguments: &ListArguments, world: &World) -> CommandResult {
    let registry = world.resource::<BehaviourRegistry>();
    let rows = match arguments.what {
        Listing::Scenarios => scenarios(),
        Listing::Teams => {
            Ok(registry.teams().map(|(name, team)| (name.to_owned(), team.description.clone())).collect())
        }
        Listing::Behaviours => Ok(behaviours(registry)),
        Listing::Fields => Ok(fields()),
        Listing::Rules => Ok(rules()),
        Listing::Balls => Ok(balls()),
        Listing::Robots => Ok(robots()),
        Listing::Leagues => Ok(leagues()),
        Listing::Challenges => Ok(challenges()),
        Listing::Logs => {
            let formats = world.resource::<LogFormats>().iter();
            Ok(formats.map(|(name, format)| (name.to_owned(), format.description.clone())).collect())
        }
    };
    let mut printer = Printer::default();
    printer.print(table(&rows.map_err(|error| report::scenario_error(&error))?));
    Ok(printer.finish(ExitCode::SUCCESS))
}

fn scenarios() -> Result<Vec<(String, String)>, ScenarioError> {
    LIBRARY.iter().map(|entry| Ok((entry.name.to_owned(), entry.description()?))).collect()
}

fn challenges() -> Vec<(String, String)> {
    // A test checks that all of them can be read.
    let challenges = CHALLENGES.iter().filter_map(|(name, _)| Challenge::named(name).ok());
    challenges.map(|challenge| (challenge.name, challenge.description)).collect()
}

/// Returns every behaviour with the teams that use it.
fn behaviours(registry: &BehaviourRegistry) -> Vec<(String, String)> {
    let plays = |team: &TeamRecipe, behaviour: &str| {
        let sizes = 1..=LARGEST_TEAM;
        sizes
            .flat_map(|size| (1..=size).map(move |number| (number, size)))
            .any(|(number, size)| team.behaviour_of(number, size) == behaviour)
    };
    let row = |behaviour: &str| {
        let teams: Vec<&str> =
            registry.teams().filter(|(_, team)| plays(team, behaviour)).map(|(name, _)| name).collect();
        let description = if teams.is_empty() { String::new() } else { format!("plays in {}", teams.join(", ")) };
        (behaviour.to_owned(), description)
    };
    registry.behaviour_names().map(row).collect()
}

fn fields() -> Vec<(String, String)> {
    let row = |name: &str| {
        let pitch = pitch_preset(name)?;
        let description = format!("{} x {} m, goals {} m wide", pitch.length_m, pitch.width_m, pitch.goal.width_m);
        Some((name.to_owned(), description))
    };
    FIELD_PRESETS.iter().filter_map(|preset| row(preset.name)).collect()
}

fn balls() -> Vec<(String, String)> {
    let row = |name: &str| {
        let BallSpec { radius_m, rolling, .. } = BallSpec::preset(name)?;
        let slows = match rolling {
            Rolling::ExponentialPerS(drag) => format!("slows down by {drag} of its speed per second"),
            Rolling::ConstantMps2(deceleration) => format!("slows down by {deceleration} m/s²"),
        };
        Some((name.to_owned(), format!("{} cm wide, {slows}", 200.0 * radius_m)))
    };
    BALL_PRESETS.iter().filter_map(|preset| row(preset.name)).collect()
}

fn leagues() -> Vec<(String, String)> {
    LEAGUES
        .iter()
        .filter_map(|preset| Some((preset.name.to_owned(), League::named(preset.name)?.description)))
        .collect()
}

fn robots() -> Vec<(String, String)> {
    MODELS
        .iter()
        .filter_map(|preset| Some((preset.name.to_owned(), RobotModel::named(preset.name)?.description)))
        .collect()
}

fn rules() -> Vec<(String, String)> {
    let row = |name: &str| {
        let rules = rules_preset(name)?;
        let play = match (rules.clock, rules.goals || rules.ball_out) {
            (true, _) => format!("{} x {} s, teams of {}", rules.halves, rules.half_s, rules.team_size),
            (false, true) => format!("no clock, teams of {}", rules.team_size),
            (false, false) => "no referee, nothing is repositioned".to_owned(),
        };
        Some((name.to_owned(), play))
    };
    RULES_PRESETS.iter().filter_map(|preset| row(preset.name)).collect()
}

/// Returns a text with two columns.
fn table(rows: &[(String, String)]) -> String {
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or_default();
    rows.iter()
        .map(|(name, description)| format!("{name:width$}  {description}").trim_end().to_owned() + "\n")
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_has_a_line_that_begins_with_it() {
        let names: Vec<&str> = LIBRARY.iter().map(|entry| entry.name).collect();
        let text = table(&scenarios().expect("the embedded scenarios load"));
        assert_eq!(text.lines().filter_map(|line| line.split_whitespace().next()).collect::<Vec<_>>(), names);
        let fields = table(&fields());
        assert!(fields.contains("naoisis         6 x 4 m, goals 1.4 m wide\n"), "{fields}");
        assert!(fields.contains("hsl2026_middle  13.95 x 8.95 m, goals 2.5 m wide\n"), "{fields}");
        let rules = table(&rules());
        assert!(rules.lines().any(|line| line.starts_with("free ") && line.contains(" no referee")), "{rules}");
    }
}
