//! `naoisis batch`: many seeded matches on all cores, as a table and a summary.

use clap::Args;
use core::ops::Range;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Instant;

use super::agents::{AgentArguments, connected};
use super::batch_summary::{print_summaries, what_was_played};
use super::game_controller::GameControllerArguments;
use super::interrupt::Interrupt;
use super::outputs::{Output, STANDARD_OUTPUT, check_files};
use super::report::{CommandResult, OrReport};
use super::shard::Shard;
use super::teams::TeamArguments;
use super::terminal::Printer;
use super::{Program, report};
use naoisis_agents::agents::AgentSettings;
use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::team::PerTeam;
use naoisis_record::batch::merge::merge;
use naoisis_record::batch::mistakes::{FindMistakes, MistakeTable};
use naoisis_record::batch::pairs::Pairs;
use naoisis_record::batch::sweep::Sweep;
use naoisis_record::batch::table::{Table, TableError};
use naoisis_record::batch::{Batch, MatchOutcome, MatchRow, Variants, run_part};
use naoisis_sim::scenario::wording::one_of;
use naoisis_sim::scenario::{FieldPath, Realism, ScenarioError, Setting};
use naoisis_sim::simulation::{MatchApp, names};

/// Arguments of `naoisis batch`.
#[derive(Args, Debug, Clone)]
pub struct BatchArguments {
    /// A scenario file (.ron or .json), or the name of a built-in scenario (see `naoisis list scenarios`)
    pub scenario: String,
    /// Number of matches for each combination of settings; with --pairs, for each pair, half of them with the sides
    /// changed
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub matches: u32,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Seed of the first match; each further match has the next seed [default: the scenario's]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Set a field of the scenario; with several values, play the batch with each: messages.loss=0,0.2,0.5
    #[arg(long, value_name = "PATH=VALUE[,VALUE...]", value_parser = Setting::sweep)]
    pub set: Vec<Vec<Setting>>,
    /// Level of realism, instead of the scenario's; with several, play the batch with each
    #[arg(long, value_name = "WORD[,WORD...]", value_parser = realisms)]
    pub realism: Option<Settings>,
    /// Play each of these teams against each other, in both colours, and report who beats whom; `all` stands for all
    /// teams
    #[arg(long, value_name = "TEAM,TEAM[,TEAM...]", value_delimiter = ',')]
    pub pairs: Vec<String>,
    /// Write one row per match; continues an existing file of the same batch
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Write the mistakes of robots, one row each (match, kind, robot, time, place), and count them in the summary;
    /// continues together with --csv
    #[arg(long, value_name = "FILE", conflicts_with = "merge")]
    pub mistakes: Option<PathBuf>,
    /// Play only part I of N of the matches, from 1/N to N/N; --merge joins the parts into one table
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Play nothing; join the tables of all parts of this batch into one table and one summary
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["shard", "threads"])]
    pub merge: Vec<PathBuf>,
    /// Stop each match after this many simulated seconds
    #[arg(long, value_name = "S", value_parser = super::run_arguments::positive_seconds, allow_negative_numbers = true)]
    pub duration: Option<f32>,
    #[command(flatten)]
    pub agents: AgentArguments,
    #[command(flatten)]
    pub game_controller: GameControllerArguments,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
}

/// The values of a setting.
#[derive(Clone, Debug)]
pub struct Settings(Vec<Setting>);

/// Parses a list of levels of realism.
fn realisms(words: &str) -> Result<Settings, String> {
    match words.split(',').find(|word| !Realism::NAMES.contains(word)) {
        Some(word) => Err(format!("`{word}` is no level of realism; expected {}", one_of(Realism::NAMES))),
        None => Setting::sweep(&format!("realism={words}")).map(Settings).map_err(|error| error.to_string()),
    }
}

impl BatchArguments {
    /// Returns the values of all settings of the command line.
    fn settings(&self) -> Vec<Vec<Setting>> {
        self.realism.iter().map(|Settings(values)| values).chain(&self.set).cloned().collect()
    }
}

/// Runs the command.
pub fn batch(program: Program, arguments: &BatchArguments) -> CommandResult {
    let sweep = sweep(program, arguments)?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    // With --pairs, half of the matches of a pair have changed sides.
    let sides = if sweep.pairs().is_some() { 2 } else { 1 };
    let first_seed = arguments.seed.or_else(|| Some(sweep.scenario(0).ok()?.seed)).unwrap_or(1);
    let threads = arguments.threads.map_or(cores, usize::from);
    let network = arguments.game_controller.of_many(threads).or_usage_error()?;
    let batch = Batch { variants: sweep, matches: arguments.matches as usize / sides, first_seed, threads };
    if !arguments.merge.is_empty() {
        return merge_parts(&batch, arguments);
    }
    let part = arguments.shard.map_or(0..batch.len(), |shard| batch.part(shard.part, shard.parts));
    let (mut table, mut rows, mut mistakes) = open_tables(arguments, &batch, part.clone())?;
    let interrupt = Interrupt::finish_running().or_failure()?;
    let earlier = rows.len();
    let progress = progress_bar(part.len(), earlier, arguments.quiet);
    let mut failed_to_write: Option<TableError> = None;
    silence_panics();
    let agents = agent_settings(arguments);
    let started = Instant::now();
    run_part(
        &batch,
        part.start + earlier..part.end,
        || {
            let finds_mistakes = arguments.mistakes.is_some();
            let app = if finds_mistakes { program.simulator_with(FindMistakes) } else { program.simulator() };
            connected(app, &agents, network.as_ref())
        },
        interrupt.stop(),
        |mut row| {
            if !row.outcome.is_valid() {
                progress.suspend(|| report::note(&failure(&row)));
            } else if !row.note.is_empty() {
                progress.suspend(|| report::note(&format!("match {}, seed {}: {}", row.index + 1, row.seed, row.note)));
            }
            // Behind what could not be written nothing else may stand.
            if failed_to_write.is_none() {
                // Mistakes are written before the row: an interrupted batch repeats the matches without a row when it continues.
                let written = mistakes.as_mut().map_or(Ok(()), |mistakes| mistakes.write(&batch, &row));
                if let Err(error) = written.and_then(|()| table.write(&batch, &row)) {
                    interrupt.stop().store(true, Ordering::SeqCst);
                    failed_to_write = Some(error);
                }
            }
            row.mistakes = Vec::new();
            progress.inc(1);
            rows.push(row);
        },
    );
    let wall_s = started.elapsed().as_secs_f64();
    progress.finish_and_clear();
    let is_interrupted = rows.len() < part.len();
    if let Some(error) = failed_to_write {
        return Err(report::failure(&error.to_string()));
    }
    let mut printer = Printer::default();
    if !arguments.quiet {
        let what_was_played = what_was_played(&batch, &rows, earlier, wall_s);
        print_summaries(&mut printer, &batch.variants, &mut rows, mistakes.as_ref());
        printer.print(what_was_played);
        if rows.len() > 1 {
            printer.print("Intervals are those of 95 % confidence.\n");
        }
    }
    if is_interrupted && let Some(path) = &arguments.csv {
        report::note(&format!("interrupted; the same command continues after the last row of {}", path.display()));
    }
    let all_valid = rows.iter().all(|row| row.outcome.is_valid());
    let status = printer.finish(if all_valid { ExitCode::SUCCESS } else { ExitCode::FAILURE });
    Ok(if is_interrupted { interrupt.finish(status) } else { status })
}

/// Opens the tables of matches and of mistakes, and reads the rows of matches that were played earlier.
///
/// # Errors
/// The exit status of an error, which has been reported.
fn open_tables(
    arguments: &BatchArguments,
    batch: &Batch<Sweep>,
    part: Range<usize>,
) -> Result<(Table, Vec<MatchRow>, Option<MistakeTable>), ExitCode> {
    let told = |option: &str, error: TableError| match error {
        TableError::NotWritten { .. } => report::failure(&format!("{option}{error}")),
        _ => report::usage_error(&format!("{option}{error}")),
    };
    if let Some(path) = &arguments.mistakes {
        if path.as_os_str() == STANDARD_OUTPUT {
            return Err(report::usage_error(
                "--mistakes: the table must be a file, so that it can be continued; expected a file name",
            ));
        }
        let outputs: Vec<Output> = [("--csv", arguments.csv.as_ref()), ("--mistakes", Some(path))]
            .into_iter()
            .filter_map(|(option, path)| Some(Output { option, path: path?.clone() }))
            .collect();
        check_files(Path::new(&arguments.scenario), &outputs, true).or_usage_error()?;
        if arguments.csv.is_none() && path.metadata().is_ok_and(|there| there.is_file()) {
            let path = path.display();
            return Err(report::usage_error(&format!(
                "--mistakes: {path}: the file exists already; expected another name, or --csv with the table to continue"
            )));
        }
    }
    let (mut table, mut rows) = match &arguments.csv {
        Some(path) => Table::open_part(path, batch, part.clone()).map_err(|error| told("", error))?,
        None => (Table::unwritten(), Vec::new()),
    };
    let mistakes = arguments
        .mistakes
        .as_ref()
        .map(|path| MistakeTable::open(path, batch, part.start, &rows))
        .transpose()
        .map_err(|error| told("--mistakes: ", error))?;
    let whole = mistakes.as_ref().map_or(rows.len(), |mistakes| mistakes.next() - part.start);
    if let Some(path) = &arguments.mistakes
        && whole < rows.len()
    {
        let (path, again) = (path.display(), rows.len() - whole);
        report::note(&format!("{path} lost its end: {again} of the earlier matches are played again"));
        table.cut(whole).map_err(|error| told("", error))?;
        rows.truncate(whole);
    }
    Ok((table, rows, mistakes))
}

/// Returns the settings for programs. Those of --pairs and --set run in the current folder.
fn agent_settings(arguments: &BatchArguments) -> AgentSettings {
    let settings = arguments.agents.settings(&arguments.scenario, &TeamArguments::default());
    let sets_teams = arguments.set.iter().flatten().any(|setting| setting.path().to_string().starts_with("teams"));
    if arguments.pairs.is_empty() && !sets_teams {
        settings
    } else {
        AgentSettings { folders: PerTeam::default(), ..settings }
    }
}

/// Joins the tables of parts into one table and one summary.
fn merge_parts(batch: &Batch<Sweep>, arguments: &BatchArguments) -> CommandResult {
    if let Some(path) = &arguments.csv {
        let output = [Output { option: "--csv", path: path.clone() }];
        arguments.merge.iter().try_for_each(|part| check_files(part, &output, true)).or_usage_error()?;
    }
    let mut rows = merge(batch, &arguments.merge).map_err(|error| format!("--merge: {error}")).or_usage_error()?;
    if let Some(path) = &arguments.csv {
        let written = Table::open(path, batch)
            .and_then(|(mut table, there)| rows[there.len()..].iter().try_for_each(|row| table.write(batch, row)));
        match written {
            Ok(()) => {}
            Err(error @ TableError::NotWritten { .. }) => return Err(report::failure(&error.to_string())),
            Err(error) => return Err(report::usage_error(&error.to_string())),
        }
    }
    let mut printer = Printer::default();
    if !arguments.quiet {
        print_summaries(&mut printer, &batch.variants, &mut rows, None);
        let tables = if arguments.merge.len() == 1 { "1 table" } else { &format!("{} tables", arguments.merge.len()) };
        printer.print(format_args!("{} matches of {tables}\n", rows.len()));
        printer.print("Intervals are those of 95 % confidence.\n");
    }
    let all_valid = rows.iter().all(|row| row.outcome.is_valid());
    Ok(printer.finish(if all_valid { ExitCode::SUCCESS } else { ExitCode::FAILURE }))
}

/// Returns the sweep of the arguments. Checks that a match can be started with each value of every setting, combined with the first values
/// of the others.
///
/// # Errors
/// The exit status of an error, which has been reported.
fn sweep(program: Program, arguments: &BatchArguments) -> Result<Sweep, ExitCode> {
    let usage_error = |message: String| report::usage_error(&message);
    let scenario_error = |error: ScenarioError| report::scenario_error(&error);
    check_settings(arguments).map_err(usage_error)?;
    let pairs = if arguments.pairs.is_empty() { None } else { Some(pairs(program, arguments).map_err(usage_error)?) };
    let file = super::begin::scenario_file(&arguments.scenario)?;
    if pairs.is_some() && !file.scenario.robots.is_empty() {
        let scenario = &arguments.scenario;
        return Err(usage_error(format!("--pairs: {scenario} lists its robots; expected a scenario with `teams`")));
    }
    let sweep = Sweep::new(&file, arguments.settings(), pairs, arguments.duration).map_err(scenario_error)?;
    let matches = sweep.combinations().and_then(|combinations| {
        combinations.checked_mul(sweep.variants_of_combination())?.checked_mul(arguments.matches as usize)
    });
    if matches.is_none() {
        return Err(usage_error("--set: there are too many combinations; expected fewer".to_owned()));
    }
    let mut app = program.simulator();
    let mut notes: Vec<String> = Vec::new();
    for sample in sweep.samples() {
        let mut file = sweep.variant(sample).map_err(scenario_error)?;
        if let Some(duration_s) = arguments.duration {
            super::begin::set_duration(&mut file.scenario, duration_s)?;
        }
        app.start_match(&file.scenario).map_err(|fault| scenario_error(file.source.error(&fault)))?;
        notes.extend(super::notes::of_scenario(&file));
    }
    notes.sort();
    notes.dedup();
    if !arguments.quiet {
        super::notes::tell(&notes);
    }
    Ok(sweep)
}

/// Checks that every field is set only once, and that teams are not set beside --pairs.
fn check_settings(arguments: &BatchArguments) -> Result<(), String> {
    let paths: Vec<String> =
        arguments.settings().iter().filter_map(|sweep| Some(sweep.first()?.path().to_string())).collect();
    if let Some((_, path)) = paths.iter().enumerate().find(|(index, path)| paths[..*index].contains(path)) {
        return Err(format!("--set: `{path}` is set twice; expected all values in one --set, such as {path}=A,B"));
    }
    let is_of_teams = |path: &&String| *path == "teams" || path.starts_with("teams.");
    match paths.iter().find(is_of_teams) {
        Some(path) if !arguments.pairs.is_empty() => {
            Err(format!("--set: --pairs sets `{path}`; expected only one of the two"))
        }
        _ => Ok(()),
    }
}

/// Returns the teams that play each other: at least two, each once.
fn pairs(program: Program, arguments: &BatchArguments) -> Result<Pairs, String> {
    let app = program.simulator();
    let registry = app.world().resource::<BehaviourRegistry>();
    let known: Vec<&str> = registry.teams().map(|(name, _)| name).collect();
    let teams = match arguments.pairs.as_slice() {
        [all] if all == "all" => known.iter().map(|team| (*team).to_owned()).collect(),
        teams => teams.to_vec(),
    };
    if let Some(fault) = teams.iter().find_map(|team| names::wrong_team(registry, &FieldPath::default(), team)) {
        return Err(format!("--pairs: {}", fault.in_words()));
    }
    if let Some((_, team)) = teams.iter().enumerate().find(|(index, team)| teams[..*index].contains(team)) {
        return Err(format!("--pairs: the team `{team}` is listed twice; expected each team once"));
    }
    if teams.len() < 2 {
        return Err("--pairs: expected at least two teams, such as --pairs chasers,roles".to_owned());
    }
    if !arguments.matches.is_multiple_of(2) {
        return Err(
            "--matches: with --pairs, half of the matches are played with changed sides; expected an even number"
                .to_owned(),
        );
    }
    Ok(Pairs::of(teams))
}

/// Silences the messages of panics. A match that panics is reported as failed.
fn silence_panics() {
    std::panic::set_hook(Box::new(|_| {}));
}

fn failure(row: &MatchRow) -> String {
    let what = match row.outcome {
        MatchOutcome::Panicked => "panicked",
        MatchOutcome::InvariantBroken => "broke an invariant",
        _ => "could not be started",
    };
    format!("match {} with seed {} {what}: {}", row.index + 1, row.seed, row.note)
}

/// Returns a progress bar that starts at the matches that were played earlier.
pub(super) fn progress_bar(matches: usize, earlier: usize, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let progress = ProgressBar::new(matches as u64).with_position(earlier as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} matches, {per_sec}, {eta} left") {
        progress.set_style(style);
    }
    progress.reset_eta();
    progress
}
