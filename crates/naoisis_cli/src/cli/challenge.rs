//! `naoisis challenge`: success rates of a learning task.

use clap::Args;
use core::fmt::Write;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::batch::progress_bar;
use super::interrupt::Interrupt;
use super::outputs::{Output, check_files};
use super::terminal::Printer;
use super::{Program, report};
use naoisis_agents::environment::Challenge;
use naoisis_agents::environment::attempts::{Attempt, Attempts, ChallengePlayer, play_attempts, success_rate};
use naoisis_core::replace_file::replace_file;

/// Arguments of `naoisis challenge`.
#[derive(Args, Debug, Clone)]
pub struct ChallengeArguments {
    /// The task, see `naoisis list challenges`
    #[arg(value_name = "NAME")]
    name: String,
    /// The behaviour of its robots, or `random` for random actions [default: each one with a rate in the task's file]
    #[arg(long, value_name = "B", conflicts_with = "team")]
    behaviour: Option<String>,
    /// The team that plays its robots
    #[arg(long, value_name = "T")]
    team: Option<String>,
    /// Number of episodes
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    episodes: u32,
    /// Seed of the first episode; each further episode has the next seed
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Write the rates, as in the task's file, and the result of each episode
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

/// Runs the command.
pub fn challenge(program: Program, arguments: &ChallengeArguments) -> ExitCode {
    let challenge = match Challenge::named(&arguments.name) {
        Ok(challenge) => challenge,
        Err(error) => return report::usage_error(&error.to_string()),
    };
    if let Some(path) = &arguments.json {
        let output = Output { option: "--json", path: path.clone() };
        if let Err(message) = check_files(Path::new(""), &[output], arguments.force) {
            return report::usage_error(&message);
        }
    }
    let watched = Interrupt::watch(|| report::note("finishing the running ones; interrupt again to stop at once"));
    let interrupt = match watched {
        Ok(interrupt) => interrupt,
        Err(message) => return report::failure(&message),
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let attempts = Attempts {
        episodes: arguments.episodes as usize,
        first_seed: arguments.seed,
        threads: arguments.threads.map_or(cores, usize::from),
    };
    let mut played: Vec<(ChallengePlayer, Vec<Attempt>)> = Vec::new();
    for player in players(&challenge, arguments) {
        let progress = progress_bar(attempts.episodes, 0, arguments.quiet);
        let mut rows = Vec::new();
        let done = play_attempts(
            &challenge,
            &player,
            &attempts,
            || program.simulator(),
            interrupt.stop(),
            |attempt| {
                progress.inc(1);
                rows.push(attempt);
            },
        );
        progress.finish_and_clear();
        if let Err(error) = done {
            return report::usage_error(&error.to_string());
        }
        played.push((player, rows));
    }
    if let Some(path) = &arguments.json {
        let value = as_json(&challenge, &played);
        let written = replace_file(path, |mut file| {
            serde_json::to_writer_pretty(&mut file, &value)?;
            std::io::Write::write_all(&mut file, b"\n")
        });
        if let Err(problem) = written {
            return report::failure(&format!("--json: {}: {problem}", path.display()));
        }
    }
    let mut printer = Printer::default();
    if !arguments.quiet {
        printer.print(in_words(&challenge, &played));
    }
    interrupt.finish(printer.finish(ExitCode::SUCCESS))
}

/// Returns the players of the arguments, by default all that have a rate in the challenge.
fn players(challenge: &Challenge, arguments: &ChallengeArguments) -> Vec<ChallengePlayer> {
    let player = |word: &str| {
        let Ok(player) = word.parse();
        player
    };
    match (&arguments.behaviour, &arguments.team) {
        (Some(behaviour), _) => vec![player(behaviour)],
        (None, Some(team)) => vec![ChallengePlayer::Team(team.clone())],
        (None, None) => challenge.success_rates.keys().map(|word| player(word)).collect(),
    }
}

fn as_json(challenge: &Challenge, played: &[(ChallengePlayer, Vec<Attempt>)]) -> Value {
    let rates = played.iter().map(|(player, rows)| (player.to_string(), json!(success_rate(rows))));
    let episodes = played.iter().map(|(player, rows)| (player.to_string(), json!(rows)));
    json!({
        "challenge": challenge.name, "version": challenge.version,
        "success_rates": rates.collect::<Map<_, _>>(), "episodes": episodes.collect::<Map<_, _>>(),
    })
}

/// Returns the success rates as text.
fn in_words(challenge: &Challenge, played: &[(ChallengePlayer, Vec<Attempt>)]) -> String {
    let mut text = format!("{}-v{}: {}\n", challenge.name, challenge.version, challenge.description);
    for (player, rows) in played {
        let rate = success_rate(rows);
        let Some(share) = rate.share() else { continue };
        let [value, low, high] = [share.value, share.low, share.high].map(|share| 100.0 * share);
        let time = rate.mean_time_s.map(|mean_s| format!(", after {mean_s:.1} s on average")).unwrap_or_default();
        let _ = writeln!(
            text,
            "{:14} {value:5.1} % of {} succeed ({low:.1} to {high:.1}){time}",
            player.to_string(),
            rate.episodes
        );
    }
    text.push_str("Intervals are those of 95 % confidence.\n");
    text
}
