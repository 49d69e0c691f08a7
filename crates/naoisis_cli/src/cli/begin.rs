//! Starts the match of `naoisis run`, from a scenario or from a saved match.

use bevy::prelude::*;
use std::path::Path;
use std::process::ExitCode;

use super::agents::AgentArguments;
use super::notes;
use super::report;
use super::report::OrReport;
use super::run_arguments::RunArguments;
use super::teams::TeamArguments;
use naoisis_core::cycle::CycleClock;
use naoisis_core::team::Team;
use naoisis_sim::scenario::wording::one_of;
use naoisis_sim::scenario::{FieldPath, Format, Scenario, ScenarioFile, Setting};
use naoisis_sim::simulation::snapshot::EXTENSION;
use naoisis_sim::simulation::{MatchApp, Snapshot, change_settings, changeable, is_changeable};

/// Whether `path` is the path of a saved match.
pub fn is_snapshot(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(EXTENSION))
}

/// Starts the match of the command line in `app`.
///
/// # Errors
/// The exit status of an error, which has been reported.
pub fn begin(app: &mut App, arguments: &RunArguments) -> Result<(), ExitCode> {
    if is_snapshot(Path::new(&arguments.scenario)) {
        return go_on(app, arguments);
    }
    begin_with(app, &scenario_file(&arguments.scenario)?, arguments)
}

/// Reads the scenario of a path or a name.
///
/// # Errors
/// The exit status of the errors, which have all been reported.
pub fn scenario_file(path_or_name: &str) -> Result<ScenarioFile, ExitCode> {
    ScenarioFile::check(path_or_name, |_| Vec::new()).map_err(|errors| report::scenario_errors(&errors))
}

/// Starts the match of a scenario with the changes of the command line.
///
/// # Errors
/// The exit status of an error, which has been reported.
pub fn begin_with(app: &mut App, file: &ScenarioFile, arguments: &RunArguments) -> Result<(), ExitCode> {
    let mut file = file.check_with(&arguments.settings()).map_err(|errors| report::scenario_errors(&errors))?;
    arguments.teams.choose(app.world(), &mut file).or_usage_error()?;
    change_from_command_line(&mut file.scenario, arguments)?;
    if !arguments.quiet {
        notes::tell(&notes::of_scenario(&file));
    }
    app.insert_resource(arguments.agents.settings(&file.source.name, &arguments.teams));
    app.start_match(&file.scenario).map_err(|fault| match arguments.cameras {
        Some(_) if fault.path == FieldPath::from("cameras").field("render") => {
            report::usage_error(&format!("--cameras: {}", fault.in_words()))
        }
        _ => report::scenario_error(&file.source.error(&fault)),
    })?;
    Ok(())
}

fn change_from_command_line(scenario: &mut Scenario, arguments: &RunArguments) -> Result<(), ExitCode> {
    if let Some(seed) = arguments.seed {
        scenario.seed = seed;
    }
    if let Some(duration_s) = arguments.duration {
        set_duration(scenario, duration_s)?;
    }
    if let Some(cameras) = arguments.cameras {
        scenario.settings.cameras.render = cameras.into();
        // Robots of another model have camera settings of their own.
        for own in scenario.robots.iter_mut().filter_map(|robot| robot.own.cameras.as_mut()) {
            own.render = cameras.into();
        }
        if let Some(teams) = &mut scenario.teams {
            for team in Team::BOTH {
                if let Some(own) = &mut teams.robots[team].own.cameras {
                    own.render = cameras.into();
                }
            }
        }
        if let Err(fault) = scenario.validate() {
            return Err(report::usage_error(&format!("--cameras: {}", fault.in_words())));
        }
    }
    Ok(())
}

/// Sets the duration of a match, s.
///
/// # Errors
/// The exit status of an error, which has been reported.
pub fn set_duration(scenario: &mut Scenario, duration_s: f32) -> Result<(), ExitCode> {
    scenario.duration_s = Some(duration_s);
    scenario.validate().map_err(|fault| report::usage_error(&format!("--duration: {}", fault.in_words())))
}

/// Changes settings of the running match in `app`. `settings` are applied to the text of its scenario, then the differences to the match.
/// `name` is the name of the match in errors.
///
/// # Errors
/// The exit status of an error, which has been reported.
pub fn change_match(app: &mut App, name: &str, settings: &[Setting]) -> Result<(), ExitCode> {
    if let Some(setting) = settings.iter().find(|setting| !is_changeable(setting.path())) {
        let message = format!(
            "--set {setting}: `{}` cannot change in the middle of a match; expected {}, of all robots, of a team or of one; or a new match",
            setting.path(),
            one_of(changeable())
        );
        return Err(report::usage_error(&message));
    }
    let scenario = app.world().resource::<Scenario>();
    let text = scenario.resolved_json().or_usage_error()?;
    let as_saved =
        ScenarioFile::from_text(&text, Format::Json, name).map_err(|error| report::scenario_error(&error))?;
    let changed = as_saved.check_with(settings).map_err(|errors| report::scenario_errors(&errors))?;
    app.insert_resource(as_saved.scenario);
    change_settings(app.world_mut(), &changed.scenario)
        .map_err(|fault| report::scenario_error(&changed.source.error(&fault)))
}

/// Puts a saved match into `app`, which keeps its teams and random numbers.
///
/// # Errors
/// A message about the command line or the file.
pub fn restore(
    app: &mut App,
    name: &str,
    teams: &TeamArguments,
    agents: &AgentArguments,
    seed: Option<u64>,
) -> Result<(), String> {
    if teams.are_given() {
        return Err(
            "--blue, --pink: a saved match has its teams; expected neither, or a scenario with `from` and this file"
                .to_owned(),
        );
    }
    if seed.is_some() {
        return Err("--seed: a saved match continues with its own random numbers; expected no seed".to_owned());
    }
    app.insert_resource(agents.settings(name, teams));
    let snapshot = Snapshot::load(Path::new(name), app.world()).map_err(|error| error.to_string())?;
    snapshot.restore(app.world_mut()).map_err(|error| format!("{name}: {error}"))
}

/// Continues a saved match, with the settings of the command line.
fn go_on(app: &mut App, arguments: &RunArguments) -> Result<(), ExitCode> {
    let usage_error = |message: &str| report::usage_error(message);
    if arguments.realism.is_some() {
        return Err(usage_error("--realism: a saved match has its settings; expected --set for settings to change"));
    }
    let path = Path::new(&arguments.scenario);
    restore(app, &arguments.scenario, &arguments.teams, &arguments.agents, arguments.seed)
        .map_err(|message| usage_error(&message))?;
    if !arguments.settings().is_empty() {
        change_match(app, &arguments.scenario, &arguments.settings())?;
    }
    let mut scenario = app.world().resource::<Scenario>().clone();
    change_from_command_line(&mut scenario, arguments)?;
    change_settings(app.world_mut(), &scenario).map_err(|fault| usage_error(&fault.to_string()))?;
    let clock = app.world().resource::<CycleClock>();
    match scenario.last_cycle() {
        // The duration of the match is saved with it.
        Some(last) if last <= clock.cycle => Err(usage_error(&format!(
            "{}: the match is over after {:.1} s; expected a longer duration, such as --duration {:.0}",
            path.display(),
            clock.end_time_s(),
            2.0 * clock.end_time_s().max(1.0),
        ))),
        _ => Ok(()),
    }
}
