//! `naoisis batch`: many seeded matches, on all cores, as a table and a summary.

use bevy::prelude::*;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Instant;

use super::interrupt::Interrupt;
use super::terminal::Printer;
use super::{Program, report};
use crate::batch::pairs::{Pairing, Pairs};
use crate::batch::summary::Summary;
use crate::batch::table::{Table, TableError, VariantColumns};
use crate::batch::{Batch, MatchRow, run_batch};
use crate::behaviour::BehaviourRegistry;
use crate::scenario::{Scenario, ScenarioError, ScenarioFile, Setting};
use crate::simulation::MatchApp;

/// Arguments of `naoisis batch`.
#[derive(Args, Debug, Clone)]
pub struct BatchArguments {
    /// A scenario file (.ron or .json), or the name of a built-in scenario (see `naoisis list scenarios`)
    pub scenario: String,
    /// Matches to play, of each combination of settings; with --pairs, of each pair, half of them with changed sides
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub matches: u32,
    /// Matches at the same time [default: one a core]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Seed of the first match; the next has the next seed [default: the scenario's]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Set a field of the scenario; with several values, play the batch with each: messages.loss=0,0.2,0.5
    #[arg(long, value_name = "PATH=VALUE[,VALUE...]", value_parser = Setting::sweep)]
    pub set: Vec<Vec<Setting>>,
    /// Let each of these teams play each other, in both colours, and tell who beats whom; `all` are all there are
    #[arg(long, value_name = "TEAM,TEAM[,TEAM...]", value_delimiter = ',')]
    pub pairs: Vec<String>,
    /// Write a row a match; a file of the same batch that is there already is gone on with
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Stop each match after this many simulated seconds
    #[arg(long, value_name = "S", value_parser = super::run::positive_seconds, allow_negative_numbers = true)]
    pub duration: Option<f32>,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
}

/// The settings of each variant, and what distinguishes them.
struct Plan {
    /// Settings that are the same for all pairs: each combination.
    combinations: Vec<Vec<Setting>>,
    /// The teams that play each other.
    pairs: Option<Pairs>,
}

/// Runs the command.
pub fn batch(program: Program, arguments: &BatchArguments) -> ExitCode {
    let plan = match Plan::of(program, arguments) {
        Ok(plan) => plan,
        Err(message) => return report::usage_error(&message),
    };
    let (variants, columns) = match plan.variants(program, arguments) {
        Ok(variants) => variants,
        Err(status) => return status,
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let batch = Batch {
        first_seed: arguments.seed.unwrap_or_else(|| variants.first().map_or(1, |scenario| scenario.seed)),
        variants,
        matches: arguments.matches as usize / plan.sides(),
        threads: arguments.threads.map_or(cores, usize::from),
    };
    let opened = match &arguments.csv {
        Some(path) => Table::open(path, &batch, columns.clone()),
        None => Ok((Table::unwritten(), Vec::new())),
    };
    let (mut table, mut rows) = match opened {
        Ok(opened) => opened,
        Err(error) => return report::usage_error(&error.to_string()),
    };
    let watched = Interrupt::watch(|| report::note("finishing the matches under way; interrupt again to leave them"));
    let interrupt = match watched {
        Ok(interrupt) => interrupt,
        Err(message) => return report::failure(&message),
    };
    let earlier = rows.len();
    let progress = progress_bar(batch.len(), earlier, arguments.quiet);
    let mut failed_to_write: Option<TableError> = None;
    silence_panics();
    let started = Instant::now();
    run_batch(
        &batch,
        earlier,
        || program.simulator(),
        interrupt.stop(),
        |row| {
            if !row.outcome.is_valid() {
                progress.suspend(|| report::note(&failure(&row)));
            }
            if let Err(error) = table.write(&row) {
                interrupt.stop().store(true, Ordering::SeqCst);
                failed_to_write.get_or_insert(error);
            }
            progress.inc(1);
            rows.push(row);
        },
    );
    let wall_s = started.elapsed().as_secs_f64();
    progress.finish_and_clear();
    let is_interrupted = rows.len() < batch.len();
    if let Some(error) = failed_to_write {
        return report::failure(&error.to_string());
    }
    let mut printer = Printer::default();
    if !arguments.quiet {
        printer.print(text(&plan, &batch, &columns, &rows, earlier, wall_s));
    }
    if is_interrupted && let Some(path) = &arguments.csv {
        report::note(&format!("interrupted; the same command goes on where {} ends", path.display()));
    }
    let all_valid = rows.iter().all(|row| row.outcome.is_valid());
    let status = printer.finish(if all_valid { ExitCode::SUCCESS } else { ExitCode::FAILURE });
    if is_interrupted { interrupt.finish(status) } else { status }
}

impl Plan {
    /// What the arguments ask for: every combination of the settings, the last one changing fastest.
    fn of(program: Program, arguments: &BatchArguments) -> Result<Self, String> {
        check_settings(arguments)?;
        let mut combinations: Vec<Vec<Setting>> = vec![Vec::new()];
        for sweep in &arguments.set {
            combinations = combinations
                .iter()
                .flat_map(|settings| {
                    sweep.iter().map(|setting| [settings.as_slice(), core::slice::from_ref(setting)].concat())
                })
                .collect();
        }
        let pairs = if arguments.pairs.is_empty() { None } else { Some(pairs(program, arguments)?) };
        Ok(Self { combinations, pairs })
    }

    /// Variants that share the matches which were asked for.
    fn sides(&self) -> usize {
        if self.pairs.is_some() { 2 } else { 1 }
    }

    /// The pairings that each combination is played with, in their order.
    fn pairings(&self) -> Vec<Option<Pairing>> {
        self.pairs.as_ref().map_or_else(|| vec![None], |pairs| pairs.pairings().map(Some).collect())
    }

    /// The scenario with each combination of the settings, and with each pairing of it, and what distinguishes them. All
    /// can be started.
    ///
    /// # Errors
    /// The exit status of what is wrong, which is said already.
    fn variants(
        &self,
        program: Program,
        arguments: &BatchArguments,
    ) -> Result<(Vec<Scenario>, VariantColumns), ExitCode> {
        let scenario_error = |error: ScenarioError| report::scenario_error(&error);
        let swept: Vec<usize> = (0..arguments.set.len()).filter(|&index| arguments.set[index].len() > 1).collect();
        let mut names: Vec<String> =
            swept.iter().filter_map(|&index| Some(arguments.set[index].first()?.path().to_string())).collect();
        if self.pairs.is_some() {
            names.extend(["teams.blue", "teams.pink"].map(str::to_owned));
        }
        let (mut variants, mut values) = (Vec::new(), Vec::new());
        let file = ScenarioFile::find(&arguments.scenario).map_err(scenario_error)?;
        if self.pairs.is_some() && !file.scenario.robots.is_empty() {
            let scenario = &arguments.scenario;
            let message = format!("--pairs: {scenario} lists its robots; expected a scenario that lines up `teams`");
            return Err(report::usage_error(&message));
        }
        let mut app = program.simulator();
        for settings in &self.combinations {
            for pairing in self.pairings() {
                let teams = match (&self.pairs, pairing) {
                    (Some(pairs), Some(pairing)) => pairs.names(pairing).map(str::to_owned).to_vec(),
                    _ => Vec::new(),
                };
                let teams_set = ["teams.blue", "teams.pink"].into_iter().zip(&teams).flat_map(|(path, team)| {
                    // A team's name is a word, so that there is one setting.
                    Setting::sweep(&format!("{path}={team}")).unwrap_or_default()
                });
                let settings_of_variant: Vec<_> = settings.iter().cloned().chain(teams_set).collect();
                let mut file = file.with(&settings_of_variant).map_err(scenario_error)?;
                if let Some(duration_s) = arguments.duration {
                    super::begin::set_duration(&mut file.scenario, duration_s)?;
                }
                app.start_match(&file.scenario).map_err(|fault| scenario_error(file.source.error(&fault)))?;
                variants.push(file.scenario);
                values.push(swept.iter().map(|&index| settings[index].value()).chain(teams).collect());
            }
        }
        Ok((variants, VariantColumns { names, values }))
    }
}

/// That every field is set once, and that --pairs has the teams to itself.
fn check_settings(arguments: &BatchArguments) -> Result<(), String> {
    let paths: Vec<String> = arguments.set.iter().filter_map(|sweep| Some(sweep.first()?.path().to_string())).collect();
    if let Some((_, path)) = paths.iter().enumerate().find(|(index, path)| paths[..*index].contains(path)) {
        return Err(format!("--set: `{path}` is set twice; expected all of its values in one, such as {path}=A,B"));
    }
    let is_of_teams = |path: &&String| *path == "teams" || path.starts_with("teams.");
    match paths.iter().find(is_of_teams) {
        Some(path) if !arguments.pairs.is_empty() => {
            Err(format!("--set: `{path}` is what --pairs sets; expected one of the two"))
        }
        _ => Ok(()),
    }
}

/// The teams that play each other: two at least, each once.
fn pairs(program: Program, arguments: &BatchArguments) -> Result<Pairs, String> {
    let app = program.simulator();
    let registry = app.world().resource::<BehaviourRegistry>();
    let known: Vec<&str> = registry.teams().map(|(name, _)| name).collect();
    let teams = match arguments.pairs.as_slice() {
        [all] if all == "all" => known.iter().map(|team| (*team).to_owned()).collect(),
        teams => teams.to_vec(),
    };
    if let Some(team) = teams.iter().find(|team| !known.contains(&team.as_str())) {
        return Err(format!("--pairs: there is no team `{team}`; expected some of {}", known.join(", ")));
    }
    if let Some((_, team)) = teams.iter().enumerate().find(|(index, team)| teams[..*index].contains(team)) {
        return Err(format!("--pairs: the team `{team}` is there twice; expected each team once"));
    }
    if teams.len() < 2 {
        return Err("--pairs: expected two teams at least, such as --pairs chasers,roles".to_owned());
    }
    if !arguments.matches.is_multiple_of(2) {
        return Err(
            "--matches: with --pairs, half of the matches are played with changed sides; expected an even number"
                .to_owned(),
        );
    }
    Ok(Pairs::of(teams))
}

/// A match that panics is reported as one, without the story of its stack.
fn silence_panics() {
    std::panic::set_hook(Box::new(|_| {}));
}

fn failure(row: &MatchRow) -> String {
    let what = match row.outcome {
        crate::batch::MatchOutcome::Panicked => "panicked",
        crate::batch::MatchOutcome::InvariantBroken => "broke what must always hold",
        _ => "could not be started",
    };
    format!("match {} with seed {} {what}: {}", row.index + 1, row.seed, row.note)
}

fn progress_bar(matches: usize, earlier: usize, quiet: bool) -> ProgressBar {
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

fn text(
    plan: &Plan,
    batch: &Batch,
    columns: &VariantColumns,
    rows: &[MatchRow],
    earlier: usize,
    wall_s: f64,
) -> String {
    let mut text = String::new();
    let pairings = plan.pairings();
    for combination in 0..plan.combinations.len() {
        let variants = combination * pairings.len()..(combination + 1) * pairings.len();
        let values = columns.values.get(variants.start).into_iter().flatten();
        let swept = columns.names.iter().zip(values).filter(|(name, _)| plan.pairs.is_none() || !is_of_pairs(name));
        let settings: Vec<String> = swept.map(|(name, value)| format!("{name} = {value}")).collect();
        if !settings.is_empty() {
            text += &format!("{}\n", settings.join(", "));
        }
        let of_combination = rows.iter().filter(|row| variants.contains(&row.variant));
        match &plan.pairs {
            Some(pairs) => {
                let rows = of_combination.filter_map(|row| Some((row, pairings[row.variant - variants.start]?)));
                text += &pairs.table(rows).to_string();
            }
            None => text += &summary_text(&Summary::of(of_combination)),
        }
    }
    text += &what_was_played(batch, rows, earlier, wall_s);
    if batch.variants.len() > 1 || rows.len() > 1 {
        text += "Intervals are those of 95 % confidence.\n";
    }
    text
}

/// How many matches there are, and how fast those were that were played now.
fn what_was_played(batch: &Batch, rows: &[MatchRow], earlier: usize, wall_s: f64) -> String {
    let of_all = format!("{} of {} matches", rows.len(), batch.len());
    let played = &rows[earlier.min(rows.len())..];
    if played.is_empty() {
        return match earlier {
            0 => format!("{of_all}\n"),
            _ => format!("{of_all}, all of them earlier\n"),
        };
    }
    let simulated_s: f64 = played.iter().map(|row| row.duration_s).sum();
    let wall_s = wall_s.max(1e-9);
    format!(
        "{of_all}{} in {wall_s:.1} s on {} thread{}: {:.1} matches/s, {:.0} times real time\n",
        if earlier > 0 { format!(", {earlier} of them earlier,") } else { String::new() },
        batch.threads,
        if batch.threads == 1 { "" } else { "s" },
        played.len() as f64 / wall_s,
        simulated_s / wall_s,
    )
}

fn is_of_pairs(name: &str) -> bool {
    matches!(name, "teams.blue" | "teams.pink")
}

fn summary_text(summary: &Summary) -> String {
    let failed = if summary.failed > 0 { format!(", {} failed", summary.failed) } else { String::new() };
    let mut text = format!("{:>24}  {}{failed}\n", "matches", summary.matches);
    for (name, value) in summary.lines() {
        text += &format!("{name:>24}  {value}\n");
    }
    text
}
