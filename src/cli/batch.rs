//! `naoisis batch`: many seeded matches, on all cores, as a table and a summary.

use bevy::prelude::*;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::{report, simulator};
use crate::batch::summary::Summary;
use crate::batch::table::{Table, TableError, VariantColumns};
use crate::batch::{Batch, MatchRow, run_batch};
use crate::scenario::{Scenario, ScenarioError, ScenarioFile, Setting};
use crate::simulation::MatchApp;

/// Arguments of `naoisis batch`.
#[derive(Args, Debug, Clone)]
pub struct BatchArguments {
    /// A scenario file (.ron or .json), or the name of a built-in scenario (see `naoisis list scenarios`)
    pub scenario: String,
    /// Matches to play, of each combination of settings
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub matches: u32,
    /// Matches at the same time [default: one a core]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Seed of the first match; the next has the next seed [default: the scenario's]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Set a field of the scenario; with several values, play the batch with each: messages.loss=0,0.2,0.5
    #[arg(long, value_name = "PATH=VALUE[,VALUE...]", value_parser = Setting::sweep)]
    pub set: Vec<Vec<Setting>>,
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

/// Runs the command.
pub fn batch(arguments: &BatchArguments) -> ExitCode {
    let (variants, columns) = match variants(arguments) {
        Ok(variants) => variants,
        Err(error) => return report::scenario_error(&error),
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let batch = Batch {
        first_seed: arguments.seed.unwrap_or_else(|| variants.first().map_or(1, |scenario| scenario.seed)),
        variants,
        matches: arguments.matches as usize,
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
    let stop = match stop_on_interrupt() {
        Ok(stop) => stop,
        Err(message) => return report::failure(&message),
    };
    let earlier = rows.len();
    let progress = progress_bar(batch.len(), earlier, arguments.quiet);
    let mut failed_to_write: Option<TableError> = None;
    silence_panics();
    let started = Instant::now();
    run_batch(&batch, earlier, simulator, &stop, |row| {
        if !row.outcome.is_valid() {
            progress.suspend(|| report::note(&failure(&row)));
        }
        if let Err(error) = table.write(&row) {
            stop.store(true, Ordering::Relaxed);
            failed_to_write.get_or_insert(error);
        }
        progress.inc(1);
        rows.push(row);
    });
    let wall_s = started.elapsed().as_secs_f64();
    progress.finish_and_clear();
    if let Some(error) = failed_to_write {
        return report::failure(&format!("cannot write the table: {error}"));
    }
    if !arguments.quiet {
        let text = text(&batch, &columns, &rows, earlier, wall_s);
        if io::stdout().write_all(text.as_bytes()).is_err() {
            return ExitCode::SUCCESS;
        }
    }
    if rows.iter().all(|row| row.outcome.is_valid()) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The scenario with each combination of the settings, the last one changing fastest, and what distinguishes them. All
/// can be started.
fn variants(arguments: &BatchArguments) -> Result<(Vec<Scenario>, VariantColumns), ScenarioError> {
    let file = ScenarioFile::find(&arguments.scenario)?;
    let mut combinations: Vec<Vec<Setting>> = vec![Vec::new()];
    for sweep in &arguments.set {
        combinations = combinations
            .iter()
            .flat_map(|settings| {
                sweep.iter().map(|setting| [settings.as_slice(), core::slice::from_ref(setting)].concat())
            })
            .collect();
    }
    let mut app = simulator();
    let mut variants = Vec::new();
    for settings in &combinations {
        let mut file = file.with(settings)?;
        if arguments.duration.is_some() {
            file.scenario.duration_s = arguments.duration;
        }
        app.start_match(&file.scenario).map_err(|fault| file.source.error(&fault))?;
        variants.push(file.scenario);
    }
    let swept: Vec<usize> = (0..arguments.set.len()).filter(|&index| arguments.set[index].len() > 1).collect();
    let names = swept.iter().filter_map(|&index| Some(arguments.set[index].first()?.path().to_string())).collect();
    let values =
        combinations.iter().map(|settings| swept.iter().map(|&index| settings[index].value()).collect()).collect();
    Ok((variants, VariantColumns { names, values }))
}

/// A flag that the first interrupt sets: matches under way are finished. The second one ends the program at once.
fn stop_on_interrupt() -> Result<Arc<AtomicBool>, String> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        report::note("finishing the matches under way; interrupt again to leave them");
    })
    .map_err(|error| format!("cannot watch for interrupts: {error}"))?;
    Ok(stop)
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

fn text(batch: &Batch, columns: &VariantColumns, rows: &[MatchRow], earlier: usize, wall_s: f64) -> String {
    let mut text = String::new();
    for variant in 0..batch.variants.len() {
        let summary = Summary::of(rows.iter().filter(|row| row.variant == variant));
        let values = columns.values.get(variant).into_iter().flatten();
        let settings: Vec<String> =
            columns.names.iter().zip(values).map(|(name, value)| format!("{name} = {value}")).collect();
        if !settings.is_empty() {
            text += &format!("{}\n", settings.join(", "));
        }
        let failed = if summary.failed > 0 { format!(", {} failed", summary.failed) } else { String::new() };
        text += &format!("{:>24}  {}{failed}\n", "matches", summary.matches);
        for (name, value) in summary.lines() {
            text += &format!("{name:>24}  {value}\n");
        }
    }
    let played = &rows[earlier.min(rows.len())..];
    let simulated_s: f64 = played.iter().map(|row| row.duration_s).sum();
    text += &format!(
        "{} of {} matches{} in {wall_s:.1} s on {} threads: {:.1} matches/s, {:.0} times real time\n",
        rows.len(),
        batch.len(),
        if earlier > 0 { format!(", {earlier} of them earlier,") } else { String::new() },
        batch.threads,
        played.len() as f64 / wall_s.max(1e-9),
        simulated_s / wall_s.max(1e-9),
    );
    if batch.variants.len() > 1 || rows.len() > 1 {
        text += "Intervals are those of 95 % confidence.\n";
    }
    text
}
