//! `naoisis check`: reports errors in the files of scenarios and robot models.

use bevy::prelude::*;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

use super::agents::AgentArguments;
use super::check_program::check_program;
use super::expect::{play_many, print_verdicts, write_junit};
use super::notes;
use super::teams::TeamArguments;
use super::terminal::Printer;
use super::{Program, report};
use naoisis_record::expectations::Verdict;
use naoisis_sim::scenario::{RobotModel, ScenarioError, ScenarioFile, Setting, TeamsSpec};
use naoisis_sim::simulation::{MatchApp, names};

/// Arguments of `naoisis check`.
#[derive(Args, Debug, Clone)]
pub struct CheckArguments {
    /// Scenario files (.ron or .json), names of built-in scenarios, robot models (.ron), or programs that are to play:
    /// "exec:python3 team.py"
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<String>,
    /// Also play the scenarios and check what they expect; exit status 1 if an expectation fails
    #[arg(long)]
    pub play: bool,
    /// With --play, write the verdicts on expectations as JUnit XML
    #[arg(long, value_name = "FILE", requires = "play")]
    pub junit: Option<PathBuf>,
    /// With --play, set a field of the scenarios: teams.blue=passers
    #[arg(long, value_name = "PATH=VALUE", requires = "play")]
    pub set: Vec<Setting>,
    /// With --play, the teams.
    #[command(flatten)]
    pub teams: TeamArguments,
    #[command(flatten)]
    pub agents: AgentArguments,
}

/// Checks every file, and prints `ok` or all its errors. Returns exit status 2 if there are any.
pub fn check(program: Program, arguments: &CheckArguments) -> ExitCode {
    let mut status = ExitCode::SUCCESS;
    let mut printer = Printer::default();
    let mut app = program.simulator();
    let mut played = Vec::new();
    for file in &arguments.files {
        if file.starts_with(TeamsSpec::EXEC) {
            printer.print(format_args!("{file}:\n"));
            if !check_program(program, file, &arguments.agents, &mut printer) {
                status = ExitCode::from(report::USAGE_ERROR);
            }
            continue;
        }
        let model = RobotModel::check(file);
        if let Some(Ok(model)) = &model {
            printer.print(format_args!("{file}: ok, the model of a robot\n"));
            for words in notes::of_model(model).into_iter().chain(notes::unsourced(model)) {
                printer.print(format_args!("{file}: note: {words}\n"));
            }
        }
        let is_scenario = model.is_none();
        let errors = match model {
            Some(model) => model.err().unwrap_or_default(),
            None => errors_of(file, &mut app),
        };
        if is_scenario && errors.is_empty() {
            printer.print(format_args!("{file}: ok\n"));
            let notes = ScenarioFile::find(file).map(|file| notes::of_scenario(&file)).unwrap_or_default();
            for words in notes {
                printer.print(format_args!("{file}: note: {words}\n"));
            }
            if arguments.play {
                match play(program, file, arguments) {
                    Ok(verdicts) => {
                        if !print_verdicts(&mut printer, &verdicts, false) && status == ExitCode::SUCCESS {
                            status = ExitCode::FAILURE;
                        }
                        played.push((file.clone(), verdicts));
                    }
                    Err(message) => status = report::failure(&format!("{file}: {message}")),
                }
            }
        }
        for error in &errors {
            status = report::scenario_error(error);
        }
        if errors.len() == ScenarioFile::MOST_ERRORS {
            report::note(&format!("{file}: there may be more errors than the first {}", errors.len()));
        }
    }
    if let Some(Err(message)) = arguments.junit.as_ref().map(|path| write_junit(path, &played)) {
        status = report::failure(&message);
    }
    printer.finish(status)
}

/// Plays a valid scenario and returns the verdicts on its expectations.
fn play(program: Program, file: &str, arguments: &CheckArguments) -> Result<Vec<Verdict>, String> {
    let file = ScenarioFile::find(file).map_err(|error| error.to_string())?;
    let mut file = file.with(&arguments.set).map_err(|error| error.to_string())?;
    arguments.teams.choose(program.simulator().world(), &mut file)?;
    let settings = arguments.agents.settings(&file.source.name, &arguments.teams);
    let simulator = || {
        let mut app = program.simulator();
        app.insert_resource(settings.clone());
        app
    };
    play_many(simulator, &file.scenario, &file.scenario.expectations)
}

/// Returns the errors of a file: those of its fields, then of the names in it, and finally of starting its match.
fn errors_of(file: &str, app: &mut App) -> Vec<ScenarioError> {
    match ScenarioFile::check(file, |scenario| names::unknown(app.world(), scenario)) {
        Ok(file) => app.start_match(&file.scenario).err().map(|fault| file.source.error(&fault)).into_iter().collect(),
        Err(errors) => errors,
    }
}
