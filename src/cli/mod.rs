//! The command line: one file a command.

use clap::{Parser, Subcommand};
use std::process::ExitCode;

mod check;
mod list;
mod report;
mod run;

/// A behavioural simulator of NAO robot soccer.
#[derive(Parser, Debug)]
#[command(version, about, propagate_version = true)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Run a match headless, as fast as it goes
    Run(run::RunArguments),
    /// Check scenario files
    Check(check::CheckArguments),
    /// List what comes with the program
    List(list::ListArguments),
}

/// Parses the command line and carries it out.
pub fn main() -> ExitCode {
    match CommandLine::parse().command {
        Some(Command::Run(arguments)) => run::run(&arguments),
        Some(Command::Check(arguments)) => check::check(&arguments, |_| Ok(())),
        Some(Command::List(arguments)) => list::list(&arguments, []),
        None => ExitCode::SUCCESS,
    }
}
