//! `naoisis realism --match`: plays whole matches and compares them with real ones.

use clap::{ArgGroup, Args};
use core::fmt::Write as _;
use serde_json::{Value, json};
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::batch::progress_bar;
use super::begin::scenario_file;
use super::interrupt::Interrupt;
use super::match_logs::CountedLogs;
use super::match_realism_table::{definitions, table};
use super::outputs::{Output, check_files};
use super::report::{CommandResult, OrReport};
use super::teams::TeamArguments;
use super::terminal::Printer;
use super::{Program, report};
use naoisis_core::replace_file::replace_file;
use naoisis_core::team::Team;
use naoisis_lab::match_realism::{Comparison, MatchMeasures, RealFigures, play_matches, quantities};
use naoisis_sim::interface::gather::GatherPlugin;
use naoisis_sim::scenario::{ScenarioFile, Setting};

/// Arguments of `naoisis realism` for whole matches.
#[derive(Args, Debug, Clone)]
#[command(group = ArgGroup::new("counted").args(["scenario", "logs"]).multiple(true))]
pub struct MatchRealismArguments {
    /// Play whole matches of this scenario instead, passers against roles, and compare them with real ones [default:
    /// spl2025]
    #[arg(long = "match", value_name = "LEAGUE", num_args = 0..=1, default_missing_value = "spl2025", conflicts_with_all = ["robot", "repetitions"])]
    pub scenario: Option<String>,
    /// Number of matches
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000), requires = "scenario")]
    matches: u32,
    /// Seed of the first match; each further match has the next seed
    #[arg(long, value_name = "N", default_value_t = 1, requires = "scenario")]
    seed: u64,
    #[command(flatten)]
    teams: TeamArguments,
    /// Differences in strength, as between teams of a tournament: in each match, each team has a handicap between 0 and this
    /// (at most 0.9), drawn from the seed; 0 for teams as strong as they are [default: that of the real figures, or 0.85]
    #[arg(long, value_name = "SHARE", value_parser = spread, requires = "scenario")]
    spread: Option<f32>,
    /// Set a field of the scenario: messages.loss=0.2
    #[arg(long, value_name = "PATH=VALUE", requires = "scenario")]
    set: Vec<Setting>,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1024), requires = "scenario")]
    threads: Option<u16>,
    /// Figures of real matches that come before those of the program: a .ron or .json file, or a folder of them
    #[arg(long, value_name = "PATH", requires = "scenario")]
    real: Vec<PathBuf>,
    /// Count real matches in the logs of the league's GameController, a .yaml file or a folder of them, and compare with these
    #[arg(long, value_name = "PATH", conflicts_with_all = ["robot", "repetitions"])]
    pub logs: Option<PathBuf>,
    /// Write what was counted in the logs as a file for --real, to compare with the league of --match
    #[arg(long, value_name = "FILE", requires = "logs")]
    write_real: Option<PathBuf>,
    /// Print what each quantity of whole matches is, and play nothing
    #[arg(long)]
    pub explain: bool,
    /// Write the table as JSON
    #[arg(long, value_name = "FILE", requires = "counted")]
    json: Option<PathBuf>,
    /// Write the table as CSV
    #[arg(long, value_name = "FILE", requires = "counted")]
    csv: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

/// Reads the value of `--spread`.
fn spread(word: &str) -> Result<f32, &'static str> {
    let spread = word.parse().ok().filter(|spread| (0.0..=0.9).contains(spread));
    spread.ok_or("expected a number from 0 to 0.9")
}

impl MatchRealismArguments {
    /// Returns whether the arguments are about matches rather than robots.
    pub fn are_given(&self) -> bool {
        self.scenario.is_some() || self.logs.is_some() || self.teams.are_given()
    }

    /// Checks that teams are only given for matches, and that no file is replaced. Returns the real figures: those of `--real` before the
    /// built-in ones.
    fn check(&self) -> Result<Vec<RealFigures>, String> {
        if self.scenario.is_none() && self.teams.are_given() {
            return Err("--blue, --pink: teams play matches only; expected --match beside them".to_owned());
        }
        let output = |(option, path): (&'static str, &Option<PathBuf>)| Some(Output { option, path: path.clone()? });
        let outputs: Vec<Output> = [("--json", &self.json), ("--csv", &self.csv), ("--write-real", &self.write_real)]
            .into_iter()
            .filter_map(output)
            .collect();
        let scenario = self.scenario.as_deref().unwrap_or_default();
        check_files(Path::new(scenario), &outputs, self.force)?;
        let mut real = Vec::new();
        for path in &self.real {
            real.extend(RealFigures::read(path).map_err(|error| format!("--real: {error}"))?);
        }
        real.extend(RealFigures::built_in());
        Ok(real)
    }
}

/// Counts the matches of `--logs`, plays those of `--match`, and prints the results.
pub fn match_realism(program: Program, arguments: &MatchRealismArguments) -> CommandResult {
    let mut real = arguments.check().or_usage_error()?;
    let file = arguments.scenario.as_ref().map(|scenario| chosen(program, arguments, scenario)).transpose()?;
    if let Some(path) = &arguments.logs {
        let logs = CountedLogs::read(path, arguments.quiet)
            .map_err(|message| format!("--logs: {message}"))
            .or_usage_error()?;
        if let Some(path) = &arguments.write_real {
            logs.write_figures(path, file.as_ref().map(|file| file.scenario.name.as_str()))
                .map_err(|problem| format!("--write-real: {}: {problem}", path.display()))
                .or_failure()?;
        }
        if file.is_none() {
            let mut printer = Printer::default();
            if !arguments.quiet {
                printer.print(&logs);
            }
            let heading = json!({ "logs": path, "matches": logs.len() });
            write_tables(arguments, heading, &logs.comparison).or_failure()?;
            return Ok(printer.finish(ExitCode::SUCCESS));
        }
        real.insert(0, logs.figures(None));
    }
    file.map_or(Ok(ExitCode::SUCCESS), |file| play_and_compare(program, arguments, &file, &real))
}

/// Plays the matches of `file` and prints the comparison.
fn play_and_compare(
    program: Program,
    arguments: &MatchRealismArguments,
    file: &ScenarioFile,
    real: &[RealFigures],
) -> CommandResult {
    let interrupt = Interrupt::finish_running().or_failure()?;
    let spread = arguments.spread.unwrap_or_else(|| RealFigures::spread(real, &file.scenario.name));
    let (played, failed) = play(program, arguments, file, spread, &interrupt);
    let comparison = Comparison::of(&played, real, &file.scenario.name);
    let what = what_was_played(arguments, file, spread, played.len());
    let mut printer = Printer::default();
    if !arguments.quiet && !played.is_empty() {
        printer.print(format_args!("{what}\n{}", table(&comparison)));
    }
    let heading = json!({
        "scenario": file.scenario.name,
        "teams": file.scenario.teams,
        "realism": file.scenario.realism_in_words(),
        "spread": spread,
        "matches": played.len(),
        "first_seed": arguments.seed,
    });
    write_tables(arguments, heading, &comparison).or_failure()?;
    let status = if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS };
    Ok(interrupt.finish(printer.finish(status)))
}

/// Prints the definition of each quantity.
pub fn explain() -> CommandResult {
    let mut printer = Printer::default();
    printer.print(definitions(&quantities(&[])));
    Ok(printer.finish(ExitCode::SUCCESS))
}

/// Returns the scenario with realistic robots, and the teams and settings of the command line.
///
/// # Errors
/// The exit status of an error, which has been reported.
fn chosen(program: Program, arguments: &MatchRealismArguments, scenario: &str) -> Result<ScenarioFile, ExitCode> {
    let realistic: Setting = "realism=realistic".parse().map_err(|_| ExitCode::FAILURE)?;
    let settings: Vec<Setting> = [realistic].into_iter().chain(arguments.set.iter().cloned()).collect();
    let file = scenario_file(scenario)?;
    let mut file = file.check_with(&settings).map_err(|errors| report::scenario_errors(&errors))?;
    let app = program.simulator();
    let teams = TeamArguments {
        blue: Some(arguments.teams.blue.clone().unwrap_or_else(|| "passers".to_owned())),
        pink: Some(arguments.teams.pink.clone().unwrap_or_else(|| "roles".to_owned())),
    };
    for team in Team::BOTH {
        let name = teams.of(team).unwrap_or_default();
        if name.starts_with("exec:") || name == "remote" {
            return Err(report::usage_error(&format!(
                "--{}: programs take no part here; expected the name of a team (see `naoisis list teams`)",
                team.name()
            )));
        }
    }
    teams.choose(app.world(), &mut file).or_usage_error()?;
    Ok(file)
}

/// Plays the matches and reports those that failed. Returns the measures of the others, and whether any failed.
fn play(
    program: Program,
    arguments: &MatchRealismArguments,
    file: &ScenarioFile,
    spread: f32,
    interrupt: &Interrupt,
) -> (Vec<MatchMeasures>, bool) {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let progress = progress_bar(arguments.matches as usize, 0, arguments.quiet);
    let (mut played, mut failed) = (Vec::new(), false);
    play_matches(
        &file.scenario,
        spread,
        arguments.matches as usize,
        arguments.seed,
        arguments.threads.map_or(cores, usize::from),
        || program.simulator_with(GatherPlugin),
        interrupt.stop(),
        |seed, measures| {
            match measures {
                Ok(measures) => played.push(measures),
                Err(failure) => {
                    failed = true;
                    progress.suspend(|| report::note(&format!("the match with seed {seed}: {failure}")));
                }
            }
            progress.inc(1);
        },
    );
    progress.finish_and_clear();
    (played, failed)
}

fn what_was_played(arguments: &MatchRealismArguments, file: &ScenarioFile, spread: f32, played: usize) -> String {
    let scenario = &file.scenario;
    let mut text = format!("{}, ", scenario.name);
    if let Some(teams) = &scenario.teams {
        let _ = write!(text, "{} (blue) against {} (pink), ", teams.name(Team::Blue), teams.name(Team::Pink));
    }
    let _ = write!(text, "{}", scenario.realism_in_words());
    if spread > 0.0 && scenario.teams.is_some() {
        let _ = write!(text, ", handicaps up to {spread}");
    }
    text.push_str(": ");
    let last = arguments.seed.wrapping_add(played.saturating_sub(1) as u64);
    let _ = match played {
        1 => write!(text, "1 match, seed {}", arguments.seed),
        _ => write!(text, "{played} matches, seeds {} to {last}", arguments.seed),
    };
    if played < arguments.matches as usize {
        let _ = write!(text, " (of {} matches)", arguments.matches);
    }
    text
}

/// Writes the files of `--json` (heading and rows) and `--csv` (rows).
fn write_tables(arguments: &MatchRealismArguments, heading: Value, comparison: &Comparison) -> Result<(), String> {
    if let Some(path) = &arguments.json {
        let mut value = heading;
        value["rows"] = comparison.to_json();
        let written = replace_file(path, |mut file| {
            serde_json::to_writer_pretty(&mut file, &value)?;
            io::Write::write_all(&mut file, b"\n")
        });
        written.map_err(|problem| format!("--json: {}: {problem}", path.display()))?;
    }
    if let Some(path) = &arguments.csv {
        let written = replace_file(path, |file| comparison.write_csv(file));
        written.map_err(|problem| format!("--csv: {}: {problem}", path.display()))?;
    }
    Ok(())
}
