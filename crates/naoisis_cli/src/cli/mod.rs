//! The command line, one file per command. Your own program gets all commands by calling [`run()`]:
//!
//! ```no_run
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//! use std::process::ExitCode;
//!
//! #[derive(Component, Default)]
//! struct Rusher;
//!
//! fn rush(mut robots: Query<(&Percepts, &mut WalkCommand), With<Rusher>>) {
//!     for (percepts, mut walk) in &mut robots {
//!         walk.dx = if percepts.ball.is_some() { 0.005 } else { 0.0 };
//!     }
//! }
//!
//! fn main() -> ExitCode {
//!     naoisis::cli::run(|app| {
//!         app.add_behaviour::<Rusher, _>("rusher", rush);
//!         app.add_team("rushers", "Everybody rushes.", |_, _| "rusher");
//!     })
//! }
//! ```
//!
//! `my_team batch match3v3 --matches 100 --pairs rushers,roles` then plays the team on all cores, `my_team` alone opens
//! the window, and `my_team list teams` and `my_team check` know the team.

use bevy::app::{App, Plugins};
use clap::{Parser, Subcommand};
use std::env;
use std::ffi::OsString;
use std::io;
use std::process::ExitCode;

use naoisis_agents::agents::AgentsPlugin;
use naoisis_agents::policy::PolicyPlugin;
use naoisis_record::record::RecordPlugin;
use naoisis_sim::simulation::NaoisisPlugins;

mod agents;
mod batch;
mod batch_summary;
mod begin;
#[cfg(feature = "booster")]
mod booster;
mod calibrate;
mod challenge;
mod check;
mod check_program;
mod convert;
mod dataset;
mod episodes;
mod expect;
mod figures;
mod game_controller;
mod interrupt;
mod leaderboard;
mod list;
mod live;
mod logs;
mod match_logs;
mod match_realism;
mod match_realism_table;
mod notes;
mod outputs;
mod pace;
mod pictures;
mod play;
mod realism;
mod recording;
mod recordings;
mod replay;
mod report;
mod reviews;
mod robot;
mod robot_import;
mod robot_sheet;
mod run;
mod run_arguments;
mod run_summary;
mod schema;
mod serve;
mod shard;
mod teams;
mod terminal;
mod traces;
mod visible;
mod vision;
mod whatif;
mod window;

/// A simulator of humanoid robot soccer: coarse motion, strict perception.
#[derive(Parser, Debug)]
#[command(name = "naoisis", version, propagate_version = true)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Watch a match in a window; the same as no command
    Play(play::PlayArguments),
    /// Play a match without a window, as fast as possible
    Run(Box<run_arguments::RunArguments>),
    /// Run a match that programs connect to, in lock-step
    Serve(Box<serve::ServeArguments>),
    /// Print JSON Schema of the messages between a match and a program, or of a kind of file
    Schema(schema::SchemaArguments),
    /// Watch a recorded match, from its trace
    Replay(replay::ReplayArguments),
    /// Write a trace in another format, such as a page for a browser
    Convert(convert::ConvertArguments),
    /// Play many matches with different seeds, on all cores
    Batch(batch::BatchArguments),
    /// Check scenario files, robot models, and programs that are to play
    Check(check::CheckArguments),
    /// Draw the figures of the paper from running matches
    Figures(figures::FiguresArguments),
    /// List what is available
    List(list::ListArguments),
    /// Show a robot model, or make one from a robot's description
    Robot(robot::RobotArguments),
    /// Measure simulated robots, or whole matches, and compare them with real ones
    Realism(Box<realism::RealismArguments>),
    /// Play on from one moment of a match many times, with other random numbers
    #[command(name = "whatif")]
    WhatIf(whatif::WhatIfArguments),
    /// Measure success rates in learning tasks, and verify those of others
    Challenge(challenge::ChallengeArguments),
    /// Write what players observe and do in learning tasks, as a data set for imitation and offline learning
    Episodes(episodes::EpisodesArguments),
    /// Make a table from results of learning tasks
    Leaderboard(leaderboard::LeaderboardArguments),
    /// Fit a robot model to logs of a real robot
    Calibrate(calibrate::CalibrateArguments),
    /// Make a data set of labelled images, for training detectors
    Dataset(Box<dataset::DatasetArguments>),
    /// Measure image vision: what it detects in images of random scenes, compared with what is there
    Vision(vision::VisionArguments),
}

/// Parses and executes the command line: the complete body of a `main` function. `extend` adds behaviours, teams, sensors and plugins to
/// the app of every match after [`NaoisisPlugins`]. It is called once for the window, and once per match and thread of a batch.
///
/// # Panics
/// When `extend` does, for example for a behaviour that the information barrier refuses.
pub fn run(extend: impl Fn(&mut App) + Sync + 'static) -> ExitCode {
    run_with(env::args_os(), extend)
}

/// Like [`run()`], with the given command line; its first word is the name of the program.
///
/// # Panics
/// When `extend` does.
pub fn run_with(words: impl IntoIterator<Item = OsString>, extend: impl Fn(&mut App) + Sync + 'static) -> ExitCode {
    // The program is leaked, because the window plays matches in threads that run until the process ends.
    let program = Program { extend: Box::leak(Box::new(extend)) };
    let command_line = match CommandLine::try_parse_from(words) {
        Ok(command_line) => command_line,
        Err(error) => return said_by_clap(&error),
    };
    let result = match command_line.command {
        Some(Command::Play(arguments)) => play::play(program, &arguments),
        Some(Command::Run(arguments)) => run::run(program, &arguments),
        Some(Command::Serve(arguments)) => serve::serve(program, &arguments),
        Some(Command::Schema(arguments)) => schema::print_schema(&arguments),
        Some(Command::Replay(arguments)) => replay::replay(program, &arguments),
        Some(Command::Convert(arguments)) => convert::convert(program, &arguments),
        Some(Command::Batch(arguments)) => batch::batch(program, &arguments),
        Some(Command::Check(arguments)) => check::check(program, &arguments),
        Some(Command::Figures(arguments)) => figures::figures(&arguments),
        Some(Command::List(arguments)) => list::list(&arguments, program.simulator_with(RecordPlugin).world()),
        Some(Command::Robot(arguments)) => robot::robot(&arguments),
        Some(Command::Realism(arguments)) => realism::realism(program, &arguments),
        Some(Command::WhatIf(arguments)) => whatif::whatif(program, &arguments),
        Some(Command::Challenge(arguments)) => challenge::challenge(program, &arguments),
        Some(Command::Episodes(arguments)) => episodes::episodes(program, &arguments),
        Some(Command::Leaderboard(arguments)) => leaderboard::leaderboard(program, &arguments),
        Some(Command::Calibrate(arguments)) => calibrate::calibrate(&arguments),
        Some(Command::Dataset(arguments)) => dataset::dataset(program, &arguments),
        Some(Command::Vision(arguments)) => vision::vision(&arguments),
        None => play::play(program, &play::PlayArguments::default()),
    };
    result.unwrap_or_else(|status| status)
}

/// Prints an error of the command line, or the requested help or version. Returns the exit status.
fn said_by_clap(error: &clap::Error) -> ExitCode {
    let status = ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(1));
    let text = error.render().to_string();
    let shown = report::with_short_words(&text);
    if error.use_stderr() && shown != text {
        report::note(shown.trim_end());
        return status;
    }
    match error.print() {
        Err(problem) if !error.use_stderr() && problem.kind() != io::ErrorKind::BrokenPipe => {
            report::failure(&format!("cannot write to standard output: {problem}"))
        }
        _ => status,
    }
}

/// The program that runs the commands, with its additions to each match.
#[derive(Clone, Copy)]
struct Program<'a> {
    extend: &'a (dyn Fn(&mut App) + Sync),
}

impl Program<'_> {
    /// Returns a simulator without a match, with all behaviours and teams.
    fn simulator(self) -> App {
        self.simulator_with(())
    }

    /// Returns such a simulator with further plugins.
    fn simulator_with<M>(self, plugins: impl Plugins<M>) -> App {
        let mut app = App::new();
        app.add_plugins(plugins);
        self.add_to(&mut app);
        // An app that is not run by a runner has to be finished here.
        app.finish();
        app.cleanup();
        app
    }

    /// Adds the simulation, and the additions of the program.
    fn add_to(self, app: &mut App) {
        app.add_plugins((NaoisisPlugins, AgentsPlugin, PolicyPlugin));
        #[cfg(feature = "gpu")]
        app.add_plugins(naoisis_gpu::renderer::GpuCamerasPlugin);
        #[cfg(feature = "booster")]
        app.add_plugins(naoisis_booster::player::BoosterPlugin);
        (self.extend)(app);
    }
}
