//! `naoisis check`: whether scenario files are right.

use clap::Args;
use std::process::ExitCode;

use super::report;
use super::terminal::Printer;
use crate::scenario::{Scenario, ScenarioError, ScenarioFault, ScenarioFile};

/// Arguments of `naoisis check`.
#[derive(Args, Debug, Clone)]
pub struct CheckArguments {
    /// Scenario files (.ron or .json), or names of built-in scenarios
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<String>,
}

/// Checks every file, and says `ok` or what is wrong of each; exit status 2 if anything is wrong.
///
/// `starts` tells whether a match could start: whether the behaviours and teams that a scenario names exist.
pub fn check(arguments: &CheckArguments, mut starts: impl FnMut(&Scenario) -> Result<(), ScenarioFault>) -> ExitCode {
    let mut status = ExitCode::SUCCESS;
    let mut printer = Printer::default();
    for file in &arguments.files {
        match check_one(file, &mut starts) {
            Ok(()) => printer.print(format_args!("{file}: ok\n")),
            Err(error) => status = report::scenario_error(&error),
        }
    }
    printer.finish(status)
}

fn check_one(file: &str, starts: &mut impl FnMut(&Scenario) -> Result<(), ScenarioFault>) -> Result<(), ScenarioError> {
    let file = ScenarioFile::find(file)?;
    starts(&file.scenario).map_err(|fault| file.source.error(&fault))
}
