//! `naoisis check`: whether scenario files are right.

use bevy::prelude::*;
use clap::Args;
use std::process::ExitCode;

use super::agents::AgentArguments;
use super::check_program::check_program;
use super::terminal::Printer;
use super::{Program, report};
use crate::scenario::{ScenarioError, ScenarioFile, TeamsSpec};
use crate::simulation::{MatchApp, names};

/// Arguments of `naoisis check`.
#[derive(Args, Debug, Clone)]
pub struct CheckArguments {
    /// Scenario files (.ron or .json), names of built-in scenarios, or programs that are to play: "exec:python3 my_team.py"
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<String>,
    #[command(flatten)]
    pub agents: AgentArguments,
}

/// Checks every file, and says `ok` or all that is wrong of each; exit status 2 if anything is wrong.
pub fn check(program: Program, arguments: &CheckArguments) -> ExitCode {
    let mut status = ExitCode::SUCCESS;
    let mut printer = Printer::default();
    let mut app = program.simulator();
    for file in &arguments.files {
        if file.starts_with(TeamsSpec::EXEC) {
            printer.print(format_args!("{file}:\n"));
            if !check_program(program, file, &arguments.agents, &mut printer) {
                status = ExitCode::from(report::USAGE_ERROR);
            }
            continue;
        }
        let errors = errors_of(file, &mut app);
        if errors.is_empty() {
            printer.print(format_args!("{file}: ok\n"));
        }
        for error in &errors {
            status = report::scenario_error(error);
        }
        if errors.len() == ScenarioFile::MOST_ERRORS {
            report::note(&format!("{file}: there may be more errors than these {}", errors.len()));
        }
    }
    printer.finish(status)
}

/// What is wrong with a file: with its fields, with the names in it, and at last with starting its match.
fn errors_of(file: &str, app: &mut App) -> Vec<ScenarioError> {
    match ScenarioFile::check(file, |scenario| names::unknown(app.world(), scenario)) {
        Ok(file) => app.start_match(&file.scenario).err().map(|fault| file.source.error(&fault)).into_iter().collect(),
        Err(errors) => errors,
    }
}
