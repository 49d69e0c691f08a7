//! The command line: one file a command.

use bevy::app::App;
use clap::{Parser, Subcommand};
use std::io;
use std::process::ExitCode;

use crate::behaviour::BehaviourRegistry;
use crate::simulation::{MatchApp, NaoisisPlugins};

mod batch;
mod begin;
mod check;
mod figures;
mod interrupt;
mod list;
mod outputs;
mod pictures;
mod play;
mod replay;
mod report;
mod run;
mod terminal;
mod vision;
mod window;

/// A behavioural simulator of NAO robot soccer.
#[derive(Parser, Debug)]
#[command(version, about, propagate_version = true)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Watch a match in a window; the same as no command
    Play(play::PlayArguments),
    /// Run a match headless, as fast as it goes
    Run(run::RunArguments),
    /// Watch a match that a trace was written of
    Replay(replay::ReplayArguments),
    /// Play many matches with different seeds, on all cores
    Batch(batch::BatchArguments),
    /// Check scenario files
    Check(check::CheckArguments),
    /// Draw the paper's figures from the running system
    Figures(figures::FiguresArguments),
    /// List what comes with the program
    List(list::ListArguments),
    /// Measure image vision: what it finds in pictures of random scenes, against what is there
    Vision(vision::VisionArguments),
}

/// Parses the command line and carries it out.
pub fn main() -> ExitCode {
    let command_line = match CommandLine::try_parse() {
        Ok(command_line) => command_line,
        Err(error) => return said_by_clap(&error),
    };
    match command_line.command {
        Some(Command::Play(arguments)) => play::play(&arguments),
        Some(Command::Run(arguments)) => run::run(&arguments),
        Some(Command::Replay(arguments)) => replay::replay(&arguments),
        Some(Command::Batch(arguments)) => batch::batch(&arguments),
        Some(Command::Check(arguments)) => {
            let mut app = simulator();
            check::check(&arguments, |scenario| app.start_match(scenario).map(|_| ()))
        }
        Some(Command::Figures(arguments)) => figures::figures(&arguments),
        Some(Command::List(arguments)) => {
            let app = simulator();
            let teams = app.world().resource::<BehaviourRegistry>().teams();
            list::list(&arguments, teams.map(|(name, team)| (name.to_owned(), team.description.clone())))
        }
        Some(Command::Vision(arguments)) => vision::vision(&arguments),
        None => play::play(&play::PlayArguments::default()),
    }
}

/// Prints what is wrong with the command line, or what was asked of it: help, or the version.
fn said_by_clap(error: &clap::Error) -> ExitCode {
    let status = ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(1));
    match error.print() {
        Err(problem) if !error.use_stderr() && problem.kind() != io::ErrorKind::BrokenPipe => {
            report::failure(&format!("cannot write to standard output: {problem}"))
        }
        _ => status,
    }
}

/// A simulator without a match, with all built-in behaviours and teams.
fn simulator() -> App {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    app
}
