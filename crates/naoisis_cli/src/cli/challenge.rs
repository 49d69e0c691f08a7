//! `naoisis challenge`: success rates of learning tasks, as a file that others verify.

use clap::Args;
use core::fmt::Write;
use core::sync::atomic::AtomicBool;
use serde_json::to_string_pretty;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::batch::progress_bar;
use super::interrupt::Interrupt;
use super::outputs::{Output, check_files, check_files_of_policy, check_folder_of};
use super::play::{PlayArguments, display, play_file};
use super::report::{CommandResult, OrReport};
use super::terminal::Printer;
use super::{Program, report};
use naoisis_agents::environment::Challenge;
use naoisis_agents::environment::attempts::{
    Attempt, AttemptError, Attempts, ChallengePlayer, check_player, play_attempts, scenario_of_episode,
};
use naoisis_agents::environment::challenge::{CHALLENGES, ChallengeError, RECORD_SEED, SuccessRate};
use naoisis_agents::environment::results::{ChallengeResult, MethodScore, PlayedBy, ResultFile};
use naoisis_agents::policy::interactions;
use naoisis_core::replace_file::replace_file;
use naoisis_sim::scenario::{Format, Realism, Scenario, ScenarioFile, TeamsSpec};

/// Arguments of `naoisis challenge`.
#[derive(Args, Debug, Clone)]
pub struct ChallengeArguments {
    /// The task, see `naoisis list challenges`, or `all`
    #[arg(value_name = "NAME", required_unless_present = "verify", conflicts_with = "verify")]
    name: Option<String>,
    /// The behaviour of its robots, `random`, `ahead`, or `open loop of PLAYER`; repeatable [default: those with a rate in the task's file]
    #[arg(long, value_name = "B")]
    behaviour: Vec<String>,
    /// The team that plays its robots, or a program: "exec:python3 team.py"
    #[arg(long, value_name = "T", conflicts_with = "behaviour")]
    team: Option<String>,
    /// The learned policy that plays its robots: an ONNX file, with its layout in a JSON file beside it; repeatable, for policies that one
    /// method trained with different seeds: their mean and interquartile mean are printed, too
    #[arg(long, value_name = "FILE.onnx", conflicts_with_all = ["behaviour", "team"])]
    policy: Vec<String>,
    /// The realism [default: paper, and for `all` ideal and realistic]
    #[arg(long, value_name = "paper|ideal|realistic", value_parser = realism)]
    realism: Option<Realism>,
    /// The model of the robots, instead of the task's
    #[arg(long, value_name = "MODEL")]
    robot: Option<String>,
    /// Number of episodes
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    episodes: u32,
    /// Seed of the first episode; each further episode has the next seed
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Play the seeds for results that are published, from 1000000001
    #[arg(long, conflicts_with = "seed")]
    record: bool,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Write a file of results: the rates, and each episode
    #[arg(long, value_name = "FILE", visible_alias = "json")]
    out: Option<PathBuf>,
    /// Play nothing, and write the episode of the seed as a scenario for `run` and `play`
    #[arg(long, value_name = "FILE", conflicts_with = "out")]
    scenario: Option<PathBuf>,
    /// Play the episode of this seed in a window
    #[arg(long, value_name = "SEED", conflicts_with_all = ["out", "scenario", "seed", "record"])]
    watch: Option<u64>,
    /// Play a file of results again, and report whether everything comes out the same
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = [
            "behaviour", "team", "policy", "realism", "robot", "episodes", "seed", "record", "out", "scenario", "watch",
        ],
    )]
    verify: Option<PathBuf>,
    /// Start the programs that a file of results names, for --verify, instead of playing their recorded commands; they can do whatever you can do
    #[arg(long, requires = "verify")]
    programs: bool,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

/// Parses a level of realism.
pub(super) fn realism(word: &str) -> Result<Realism, String> {
    [Realism::Paper, Realism::Ideal, Realism::Realistic]
        .into_iter()
        .find(|realism| realism.name() == word)
        .ok_or_else(|| format!("expected one of {}", Realism::NAMES.join(", ")))
}

/// Runs the command.
pub fn challenge(program: Program<'static>, arguments: &ChallengeArguments) -> CommandResult {
    let challenges = challenges(arguments).or_usage_error()?;
    check_outputs(arguments)?;
    if first_seed(arguments).checked_add(u64::from(arguments.episodes).saturating_sub(1)).is_none() {
        let message =
            format!("--seed: {} episodes have seeds beyond {}; expected a smaller seed", arguments.episodes, u64::MAX);
        return Err(report::usage_error(&message));
    }
    if let Some(path) = &arguments.scenario {
        let scenario = scenario_of("--scenario", program, arguments, &challenges, first_seed(arguments));
        write(path, "--scenario", to_string_pretty(&scenario.or_usage_error()?)).or_failure()?;
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(seed) = arguments.watch {
        let scenario = scenario_of("--watch", program, arguments, &challenges, seed);
        let file = scenario.and_then(|scenario| as_file(&scenario)).or_usage_error()?;
        return play_file(program, file.scenario.name.clone(), &file, display(), &PlayArguments::default());
    }
    let interrupt = Interrupt::finish_running().or_failure()?;
    let mut printer = Printer::default();
    if let Some(path) = &arguments.verify {
        let file = read_results(path).or_usage_error()?;
        let verified = verify(program, &file, (arguments.threads, arguments.programs), &interrupt, &mut printer);
        let status = verified.unwrap_or_else(|status| status);
        return Ok(interrupt.finish(printer.finish(status)));
    }
    // What is wrong with the last player is said before the first one plays.
    for (realism, challenge) in &challenges {
        for player in players(challenge, *realism, arguments) {
            check_player(challenge, &player, || program.simulator()).or_usage_error()?;
        }
    }
    let (file, status) = play_all(program, &challenges, arguments, &interrupt, &mut printer)?;
    if let Some(path) = &arguments.out {
        write(path, "--out", to_string_pretty(&file)).or_failure()?;
    }
    if !arguments.quiet {
        printer.print("Intervals are those of 95 % confidence.\n");
    }
    Ok(interrupt.finish(printer.finish(status)))
}

/// Checks that the files of `--out` and `--scenario` can be written, and are none that the command reads.
fn check_outputs(arguments: &ChallengeArguments) -> Result<(), ExitCode> {
    for (option, path) in [("--out", &arguments.out), ("--scenario", &arguments.scenario)] {
        let Some(path) = path else { continue };
        let outputs = [Output { option, path: path.clone() }];
        let mut policies = arguments.policy.iter().map(Path::new);
        let checked = check_files(Path::new(""), &outputs, arguments.force)
            .and_then(|()| policies.try_for_each(|policy| check_files_of_policy(policy, &outputs, arguments.force)));
        checked.and_then(|()| check_folder_of(path)).or_usage_error()?;
    }
    Ok(())
}

/// Plays the episodes of all players and prints their success rates. Returns the results, and the exit status: a failure if a player that was asked
/// for had nothing to play back.
fn play_all(
    program: Program<'static>,
    challenges: &[(Realism, Challenge)],
    arguments: &ChallengeArguments,
    interrupt: &Interrupt,
    printer: &mut Printer,
) -> Result<(ResultFile, ExitCode), ExitCode> {
    let mut file = ResultFile::default();
    let mut status = ExitCode::SUCCESS;
    for (realism, challenge) in challenges {
        if !arguments.quiet {
            let Challenge { name, version, description, .. } = challenge;
            printer.print(format_args!("{name}-v{version}, realism {realism}: {description}\n"));
        }
        for player in players(challenge, *realism, arguments) {
            let episodes = match play(program, challenge, &player, arguments, interrupt) {
                Ok(episodes) => episodes,
                // In tables of baselines, a player without a success has nothing to play back.
                Err(AttemptError::NothingToPlayBack { .. }) if arguments.behaviour.is_empty() => continue,
                Err(error @ AttemptError::NothingToPlayBack { .. }) => {
                    status = report::failure(&error.to_string());
                    continue;
                }
                Err(error) => return Err(report::usage_error(&error.to_string())),
            };
            let mut result = ChallengeResult::new(challenge, (*realism, arguments.robot.as_deref()), &player, episodes);
            result.interactions = interactions(&player);
            if !arguments.quiet {
                printer.print(in_words(&result.player, &result.rate));
            }
            if !result.episodes.is_empty() {
                file.results.push(result);
            }
        }
        let is_of_challenge =
            |result: &&ChallengeResult| result.challenge == challenge.name && result.realism == *realism;
        print_score(printer, arguments, "", file.results.iter().filter(is_of_challenge));
    }
    if challenges.len() > 1 {
        print_score(printer, arguments, "All tasks, ", &file.results);
    }
    Ok((file, status))
}

/// Prints the score of several policies.
fn print_score<'a>(
    printer: &mut Printer,
    arguments: &ChallengeArguments,
    what: &str,
    results: impl IntoIterator<Item = &'a ChallengeResult>,
) {
    if let Some(score) = MethodScore::of(results).filter(|_| !arguments.quiet) {
        printer.print(format_args!("{what}{score}\n"));
    }
}

/// The challenges of the arguments, each in each realism.
fn challenges(arguments: &ChallengeArguments) -> Result<Vec<(Realism, Challenge)>, ChallengeError> {
    let Some(name) = &arguments.name else { return Ok(Vec::new()) };
    let (names, default): (Vec<&str>, &[Realism]) = if name == "all" {
        (CHALLENGES.iter().map(|(name, _)| *name).collect(), &[Realism::Ideal, Realism::Realistic])
    } else {
        (vec![name], &[Realism::Paper])
    };
    let realisms = arguments.realism.as_ref().map_or(default, core::slice::from_ref);
    let variants = names.iter().flat_map(|name| realisms.iter().map(move |realism| (*realism, *name)));
    variants
        .map(|(realism, name)| Ok((realism, Challenge::named(name)?.with(realism, arguments.robot.as_deref())?)))
        .collect()
}

/// The players of the arguments, by default those that have a rate in the challenge.
fn players(challenge: &Challenge, realism: Realism, arguments: &ChallengeArguments) -> Vec<ChallengePlayer> {
    let player = |word: &str| {
        let Ok(player) = word.parse();
        player
    };
    if let Some(team) = &arguments.team {
        return vec![ChallengePlayer::Team(team.clone())];
    }
    if !arguments.policy.is_empty() {
        return arguments.policy.iter().cloned().map(ChallengePlayer::Policy).collect();
    }
    if !arguments.behaviour.is_empty() {
        return arguments.behaviour.iter().map(|word| player(word)).collect();
    }
    let rates = challenge.success_rates.get(realism.name()).or(challenge.success_rates.values().next());
    rates.into_iter().flat_map(|rates| rates.keys()).map(|word| player(word)).collect()
}

fn play(
    program: Program,
    challenge: &Challenge,
    player: &ChallengePlayer,
    arguments: &ChallengeArguments,
    interrupt: &Interrupt,
) -> Result<Vec<Attempt>, AttemptError> {
    let attempts = Attempts {
        episodes: arguments.episodes as usize,
        first_seed: first_seed(arguments),
        threads: threads(arguments.threads),
    };
    let progress = progress_bar(attempts.episodes, 0, arguments.quiet);
    let mut rows = Vec::new();
    let simulator = || program.simulator();
    let done = play_attempts(challenge, player, &attempts, simulator, interrupt.stop(), |attempt| {
        progress.inc(1);
        rows.push(attempt);
    });
    progress.finish_and_clear();
    done.map(|()| rows)
}

fn first_seed(arguments: &ChallengeArguments) -> u64 {
    if arguments.record { RECORD_SEED } else { arguments.seed }
}

/// The number of threads: one per core, unless another number is wanted.
pub(super) fn threads(wanted: Option<u16>) -> usize {
    wanted.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from)
}

/// The episode of a seed as the first player plays it, up to its end. Its name has the seed and the outcome, which is printed, too. Errors name the
/// `option` for which it is wanted.
fn scenario_of(
    option: &str,
    program: Program,
    arguments: &ChallengeArguments,
    challenges: &[(Realism, Challenge)],
    seed: u64,
) -> Result<Scenario, String> {
    let [(realism, challenge)] = challenges else {
        return Err(format!("{option}: expected one task in one realism, not all"));
    };
    let named = arguments.behaviour.len() + usize::from(arguments.team.is_some()) + arguments.policy.len();
    let mut players = players(challenge, *realism, arguments);
    let Some(mut player) = players.pop().filter(|_| named == 1) else {
        return Err(format!("{option}: expected one player, by --behaviour, --team or --policy"));
    };
    if let ChallengePlayer::Policy(file) = &mut player {
        // The scenario may be a file in another folder.
        let path = std::path::absolute(&*file).map_err(|error| format!("{file}: {error}"))?;
        *file = path.to_string_lossy().into_owned();
    }
    let scenario = scenario_of_episode(challenge, &player, seed, program.simulator().world());
    let scenario = scenario.map_err(|error| error.to_string())?;
    let attempts = Attempts { episodes: 1, first_seed: seed, threads: 1 };
    let mut played = None;
    let simulator = || program.simulator();
    play_attempts(challenge, &player, &attempts, simulator, &AtomicBool::new(false), |attempt| played = Some(attempt))
        .map_err(|error| error.to_string())?;
    let Some(attempt) = played else { return Ok(scenario) };
    let name = format!("{}, seed {seed}: {}", scenario.name, outcome(&attempt));
    if !arguments.quiet {
        report::note(&name);
    }
    Ok(Scenario { name, duration_s: Some(attempt.time_s as f32), ..scenario })
}

/// The scenario of an episode as that of a file.
fn as_file(scenario: &Scenario) -> Result<ScenarioFile, String> {
    let text = to_string_pretty(scenario).map_err(|error| error.to_string())?;
    ScenarioFile::from_text(&text, Format::Json, &scenario.name).map_err(|error| error.to_string())
}

/// Writes a text in JSON as a file.
pub(super) fn write(path: &Path, option: &str, text: serde_json::Result<String>) -> Result<(), String> {
    let written =
        replace_file(path, |mut file| std::io::Write::write_all(&mut file, format!("{}\n", text?).as_bytes()));
    written.map_err(|problem| format!("{option}: {}: {problem}", path.display()))
}

/// Reads a file of results.
///
/// # Errors
/// A message with the name of the file.
pub(super) fn read_results(path: &Path) -> Result<ResultFile, String> {
    let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let file = ResultFile::from_text(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    if file.results.is_empty() {
        return Err(format!(
            "{}: there are no results in it; expected those of `naoisis challenge --out`",
            path.display()
        ));
    }
    Ok(file)
}

/// Plays all results of a file again and prints what comes out otherwise. Programs are started only if `programs` is true; otherwise their recorded
/// commands are played.
pub(super) fn verify(
    program: Program,
    file: &ResultFile,
    (wanted, programs): (Option<u16>, bool),
    interrupt: &Interrupt,
    printer: &mut Printer,
) -> CommandResult {
    let mut status = ExitCode::SUCCESS;
    for result in &file.results {
        let name = format!("{}-v{}, {}, {}", result.challenge, result.version, result.realism, result.player);
        let is_program = result.player.contains(TeamsSpec::EXEC);
        let by = if is_program && !programs { PlayedBy::Commands } else { PlayedBy::Player };
        if by == PlayedBy::Commands && !result.has_commands() {
            let why = "it would start this program, which can do whatever you can do; allow it with --programs";
            return Err(report::failure(&format!("{name}: {why}")));
        }
        let progress = progress_bar(result.episodes.len(), 0, false);
        let played = result.challenge().map_err(|error| error.to_string()).and_then(|challenge| {
            let simulator = || program.simulator();
            let found = result.verify(&challenge, by, threads(wanted), simulator, interrupt.stop(), || progress.inc(1));
            found.map_err(|error| error.to_string())
        });
        progress.finish_and_clear();
        let different = played.map_err(|message| format!("{name}: {message}")).or_failure()?;
        let Some(found) = different else {
            if interrupt.is_stopped() {
                printer.print(format_args!("{name}: broken off\n"));
                return Ok(ExitCode::FAILURE);
            }
            let Ok(player) = result.player.parse();
            let trained = interactions(&player);
            if trained != result.interactions {
                let words = |number: Option<u64>| number.map_or("no number".to_owned(), |number| number.to_string());
                let [written, found] = [words(result.interactions), words(trained)];
                printer.print(format_args!("{name}: interactions: {written} in the file, {found} in the layout\n"));
                status = ExitCode::FAILURE;
                continue;
            }
            let how = if by == PlayedBy::Commands { ", by the recorded commands" } else { "" };
            printer.print(format_args!("{name}: the same in {} episodes{how}\n", result.episodes.len()));
            continue;
        };
        status = ExitCode::FAILURE;
        let index = result.episodes.iter().position(|written| written.seed == found.seed).unwrap_or_default();
        let at_s = result.episodes.get(index).and_then(|written| found.first_difference_s(written));
        let written = result.episodes.get(index).map(outcome).unwrap_or_default();
        let now = outcome(&found);
        let elsewhere = "robots or ball elsewhere";
        let how = match at_s {
            Some(at_s) => format!("now {now}, with {elsewhere} from {at_s:.2} s on"),
            None if written == now => format!("with {elsewhere} at the end"),
            None => format!("now {now}"),
        };
        printer.print(format_args!(
            "{name}: differs at episode {} (seed {}): {written} in the file, {how}\n",
            index + 1,
            found.seed
        ));
        if result.naoisis != env!("CARGO_PKG_VERSION") {
            printer.print(format_args!("It was played by naoisis {}.\n", result.naoisis));
        }
    }
    Ok(status)
}

fn outcome(attempt: &Attempt) -> String {
    format!("a {} after {:.2} s", if attempt.is_success { "success" } else { "failure" }, attempt.time_s)
}

/// Returns a success rate as a line of text.
fn in_words(player: &str, rate: &SuccessRate) -> String {
    let Some(share) = rate.share() else { return String::new() };
    let [value, low, high] = [share.value, share.low, share.high].map(|share| 100.0 * share);
    let time = rate.mean_time_s.map(|mean_s| format!(", after {mean_s:.1} s on average")).unwrap_or_default();
    let mut text = String::new();
    let _ = writeln!(text, "{player:22} {value:5.1} % of {} succeed ({low:.1} to {high:.1}){time}", rate.episodes);
    text
}
