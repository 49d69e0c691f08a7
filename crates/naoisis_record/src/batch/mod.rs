//! Plays many seeded matches on many threads.
//!
//! A match is a `World` on one thread, and each thread takes the next match when it is done with one. The results are the same for any
//! number of threads: each match depends on its scenario and seed only, and the [`MatchRow`]s come in the order of the matches.
//!
//! ```
//! use core::sync::atomic::AtomicBool;
//! use naoisis::batch::{Batch, run_batch};
//! use naoisis::prelude::*;
//! use bevy::prelude::*;
//!
//! let scenario = Scenario { duration_s: Some(2.0), ..Scenario::named("match3v3")? };
//! let batch = Batch { variants: vec![scenario], matches: 4, first_seed: 1, threads: 2 };
//! let mut rows = Vec::new();
//! let simulator = || {
//!     let mut app = App::new();
//!     app.add_plugins(NaoisisPlugins);
//!     app
//! };
//! run_batch(&batch, 0, simulator, &AtomicBool::new(false), |row| rows.push(row));
//! assert_eq!(rows.iter().map(|row| row.seed).collect::<Vec<_>>(), [1, 2, 3, 4]);
//! # Ok::<(), naoisis::scenario::ScenarioError>(())
//! ```

use bevy::prelude::*;
use core::convert::Infallible;
use core::ops::Range;
use core::sync::atomic::AtomicBool;
use std::panic::{AssertUnwindSafe, catch_unwind};

mod columns;
mod csv_lines;
pub mod merge;
pub mod mistakes;
pub mod observer;
pub mod pairs;
mod ratings;
mod start;
pub mod summary;
pub mod sweep;
pub mod table;
mod table_file;
pub mod variants;

use mistakes::MistakesAreFound;
use observer::MatchObserver;
pub use observer::{MatchOutcome, MatchRow};
pub use start::{PlayError, begin_programs, refuse_real_time};
pub use variants::Variants;

use crate::record::mistakes::MistakeFinder;
use naoisis_agents::agents;
use naoisis_core::cycle::{CycleClock, run_cycle};
use naoisis_core::game::{Game, GameState};
use naoisis_sensing::sensing::jobs::SensingThreads;
use naoisis_sim::interface::gather::{CurrentRecord, gather_start};
use naoisis_sim::scenario::Scenario;
use naoisis_sim::simulation::{MatchApp, play_in_order};

/// The matches to be played: every seed with every variant.
#[derive(Clone, Debug)]
pub struct Batch<V = Vec<Scenario>> {
    /// The scenarios, each with its own settings. Their seeds are ignored.
    pub variants: V,
    /// Matches of each variant.
    pub matches: usize,
    /// Seed of the first match of each variant; it grows by one from match to match.
    pub first_seed: u64,
    /// Number of matches that are played at the same time, at least 1.
    pub threads: usize,
}

impl<V: Variants> Batch<V> {
    /// Returns the number of matches of all variants.
    pub fn len(&self) -> usize {
        self.matches.saturating_mul(self.variants.count())
    }

    /// Returns whether there are no matches.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the indices of part `shard` (from 1 to `shards`) of the matches. Each match is in one part. The tables of all parts, one
    /// after the other, make up the table of the batch.
    pub fn part(&self, shard: usize, shards: usize) -> Range<usize> {
        let until = |shard: usize| (self.len() as u128 * shard as u128 / shards.max(1) as u128) as usize;
        until(shard.saturating_sub(1))..until(shard)
    }

    /// Returns the variant and the seed of match `index`. Matches with the same seed follow each other, so that a larger batch begins with
    /// the matches of a smaller one.
    pub fn job(&self, index: usize) -> (usize, u64) {
        let variants = self.variants.count().max(1);
        (index % variants, self.first_seed.wrapping_add((index / variants) as u64))
    }
}

/// Plays the matches of a batch from index `first` on, as [`run_part`] does.
pub fn run_batch<V: Variants>(
    batch: &Batch<V>,
    first: usize,
    simulator: impl Fn() -> App + Sync,
    stop: &AtomicBool,
    finished: impl FnMut(MatchRow),
) {
    run_part(batch, first..batch.len(), simulator, stop, finished);
}

/// Plays the matches of a batch with these indices, each in a new app, and passes their rows to `finished` in the order of the indices.
/// When `stop` becomes true, the matches under way are finished and no others begin.
///
/// A match whose behaviour panics, or that cannot be started, has that [outcome](MatchRow::outcome) in its row; the others are played.
pub fn run_part<V: Variants>(
    batch: &Batch<V>,
    indices: Range<usize>,
    simulator: impl Fn() -> App + Sync,
    stop: &AtomicBool,
    mut finished: impl FnMut(MatchRow),
) {
    let play = |(): &mut (), index: usize| {
        let (variant, seed) = batch.job(index);
        let row = match batch.variants.scenario(variant) {
            Ok(scenario) => play(&simulator, &Scenario { seed, ..scenario }),
            Err(error) => MatchRow::failed(seed, MatchOutcome::Refused, error.to_string()),
        };
        MatchRow { index, variant, ..row }
    };
    let Ok(()) = play_in_order(
        indices,
        batch.threads,
        stop,
        || (),
        play,
        |row| {
            finished(row);
            Ok::<(), Infallible>(())
        },
    );
}

/// Plays one match to its end.
pub fn play(simulator: impl Fn() -> App, scenario: &Scenario) -> MatchRow {
    let played = catch_unwind(AssertUnwindSafe(|| {
        let mut app = simulator();
        // The matches themselves use the cores.
        app.insert_resource(SensingThreads(1));
        match app.start_match(scenario) {
            Ok(app) => play_to_the_end(app.world_mut(), scenario),
            Err(fault) => MatchRow::failed(scenario.seed, MatchOutcome::Refused, fault.to_string()),
        }
    }));
    played.unwrap_or_else(|payload| {
        let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
        let message = text.unwrap_or_else(|| "without a message".to_owned());
        MatchRow::failed(scenario.seed, MatchOutcome::Panicked, message)
    })
}

fn play_to_the_end(world: &mut World, scenario: &Scenario) -> MatchRow {
    if let Err(error) = begin_programs(world) {
        return MatchRow::failed(scenario.seed, MatchOutcome::Refused, error.to_string());
    }
    let mut observer = MatchObserver::begin(world);
    let mut finder = world.contains_resource::<MistakesAreFound>().then(|| {
        gather_start(world);
        MistakeFinder::new(scenario)
    });
    let last_cycle = scenario.last_cycle();
    let (outcome, farewell) = loop {
        if let Some(finder) = &mut finder {
            finder.look(&world.resource::<CurrentRecord>().record);
        }
        if world.resource::<Game>().state == GameState::Finished {
            break (MatchOutcome::FinalWhistle, "final whistle");
        }
        let cycle = world.resource::<CycleClock>().cycle;
        if last_cycle.is_some_and(|last| cycle >= last) {
            break (MatchOutcome::Duration, "end");
        }
        run_cycle(world);
        observer.observe(world);
    };
    agents::dismiss(world, farewell);
    let mistakes = finder.map(|finder| finder.mistakes());
    MatchRow {
        mistakes_found: mistakes.as_ref().map(|mistakes| mistakes.len().try_into().unwrap_or(u32::MAX)),
        mistakes: mistakes.unwrap_or_default(),
        ..observer.row(world, scenario.seed, outcome)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::sync::atomic::Ordering;
    use naoisis_sim::simulation::NaoisisPlugins;

    fn simulator() -> App {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        app
    }

    fn short_match() -> Scenario {
        Scenario { duration_s: Some(4.0), ..Scenario::named("match3v3").unwrap() }
    }

    fn rows_of(batch: &Batch, first: usize) -> Vec<MatchRow> {
        let mut rows = Vec::new();
        run_batch(batch, first, simulator, &AtomicBool::new(false), |row| rows.push(row));
        rows
    }

    #[test]
    fn the_rows_are_the_same_whatever_the_number_of_threads_and_wherever_a_batch_goes_on() {
        let quiet = Scenario { duration_s: Some(1.0), ..short_match() };
        let batch = Batch { variants: vec![short_match(), quiet], matches: 3, first_seed: 5, threads: 1 };
        let rows = rows_of(&batch, 0);
        assert_eq!(
            rows.iter().map(|row| (row.index, row.variant, row.seed)).collect::<Vec<_>>(),
            [(0, 0, 5), (1, 1, 5), (2, 0, 6), (3, 1, 6), (4, 0, 7), (5, 1, 7)]
        );
        assert!(rows.iter().all(|row| row.outcome == MatchOutcome::Duration));
        assert_eq!(rows_of(&Batch { threads: 3, ..batch.clone() }, 0), rows);
        assert_eq!(rows_of(&Batch { threads: 2, ..batch }, 4), rows[4..]);
    }

    #[test]
    fn after_a_stop_no_match_begins() {
        let stop = AtomicBool::new(false);
        let batch = Batch { variants: vec![short_match()], matches: 100, first_seed: 1, threads: 2 };
        let mut rows = 0;
        run_batch(&batch, 0, simulator, &stop, |_| {
            rows += 1;
            stop.store(true, Ordering::Relaxed);
        });
        // Matches under way are still finished.
        assert!((1..100).contains(&rows), "{rows}");
        run_batch(&batch, 0, simulator, &stop, |_| panic!("it was stopped before it began"));
    }
}
