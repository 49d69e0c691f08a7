//! Judges expectations by one match or by many.

use bevy::prelude::*;
use core::fmt;
use core::sync::atomic::AtomicBool;

use super::measure;
use crate::batch::{PlayError, begin_programs};
use crate::record::match_counts::MatchCounter;
use crate::record::mistakes::{Mistake, MistakeFinder, MistakeKind};
use naoisis_agents::agents;
use naoisis_core::cycle::{CycleClock, run_cycle};
use naoisis_core::game::{Game, GameState};
use naoisis_core::statistics::rounded;
use naoisis_core::team::RobotId;
use naoisis_sensing::sensing::jobs::SensingThreads;
use naoisis_sim::interface::gather::{CurrentRecord, gather_on_demand, record_now};
use naoisis_sim::scenario::{Expectation, Frequency, Quantity, RobotQuantity, Scenario, TeamQuantity};
use naoisis_sim::simulation::{MatchApp, play_in_order};

/// The verdict on an expectation.
#[derive(Clone, PartialEq, Debug)]
pub struct Verdict {
    /// The expectation.
    pub expectation: Expectation,
    /// Whether it holds.
    pub holds: bool,
    /// The value, or the share of matches, in words.
    pub found: String,
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {}", self.expectation, self.found)
    }
}

/// Watches a match for expectations and keeps the value of each when its time is over.
#[derive(Default)]
pub struct Watch {
    /// Counts the match. `None` until the match begins.
    counter: Option<MatchCounter>,
    /// Finds mistakes, if any are expected.
    finder: Option<MistakeFinder>,
    /// Time at which watching began, s since the start of the match.
    began_s: f64,
    /// The value of each expectation. The outer `None`: its time is not over; the inner one: there was nothing to measure.
    values: Vec<Option<Option<f64>>>,
}

impl Watch {
    /// Begins to watch the match in `world` in its present state. Earlier events do not count.
    pub fn begin(world: &mut World, expected: &[Expectation]) -> Self {
        let began_s = world.resource::<CycleClock>().end_time_s();
        let finder = looks_for_mistakes(expected).then(|| {
            // Another system may gather the record already.
            if !world.contains_resource::<CurrentRecord>() {
                gather_on_demand(world);
            }
            let mut finder = MistakeFinder::new(world.resource::<Scenario>());
            finder.look(record_now(world));
            finder
        });
        Self { counter: Some(MatchCounter::begin(world)), finder, began_s, values: Vec::new() }
    }

    /// Reads the last completed cycle.
    pub fn observe(&mut self, world: &mut World, expected: &[Expectation]) {
        if let Some(counter) = &mut self.counter {
            counter.observe(world);
        }
        if let Some(finder) = &mut self.finder {
            finder.look(record_now(world));
        }
        self.values.resize(expected.len(), None);
        let clock = world.resource::<CycleClock>();
        let now_s = clock.end_time_s() - self.began_s + clock.period_s / 1000.0;
        for (index, expectation) in expected.iter().enumerate() {
            if self.values[index].is_none() && expectation.within_s.is_some_and(|within_s| within_s <= now_s) {
                self.values[index] = Some(self.value(expectation.quantity));
            }
        }
    }

    /// Returns the value of `quantity` up to now.
    fn value(&self, quantity: Quantity) -> Option<f64> {
        let count = |is_meant: &dyn Fn(RobotId) -> bool, kind: Option<MistakeKind>| {
            let is_of_kind =
                |mistake: &&Mistake| kind.is_none_or(|kind| mistake.kind == kind) && is_meant(mistake.robot);
            let is_of_beliefs = matches!(kind, Some(MistakeKind::OwnPoseLost | MistakeKind::BallMisplaced));
            // Robots without beliefs are not right about anything.
            let finder = self.finder.as_ref().filter(|finder| !is_of_beliefs || finder.knows_beliefs(is_meant));
            finder.map(|finder| finder.mistakes().iter().filter(is_of_kind).count() as f64)
        };
        match quantity {
            Quantity::OfTeam(team, TeamQuantity::Mistakes(kind)) => count(&|robot| robot.team == team, kind),
            Quantity::OfRobot(robot, RobotQuantity::Mistakes(kind)) => count(&|other| other == robot, kind),
            quantity => measure::value(self.counter.as_ref()?.counts(), quantity),
        }
    }

    /// Returns the value of each expectation at the end of its time or of the match.
    fn values<'a>(&'a self, expected: &'a [Expectation]) -> impl Iterator<Item = Option<f64>> + 'a {
        expected.iter().enumerate().map(|(index, expectation)| {
            let at_its_time = self.values.get(index).copied().flatten();
            at_its_time.unwrap_or_else(|| self.value(expectation.quantity))
        })
    }
}

fn looks_for_mistakes(expected: &[Expectation]) -> bool {
    expected.iter().any(|expectation| expectation.quantity.is_of_mistakes())
}

/// Judges expectations by one match, which `watch` has followed to its end.
pub fn judge(watch: &Watch, expected: &[Expectation]) -> Vec<Verdict> {
    let verdict = |(expectation, value): (&Expectation, Option<f64>)| Verdict {
        expectation: *expectation,
        holds: holds(expectation, value),
        found: value
            .map_or_else(|| "there was nothing to measure".to_owned(), |value| format!("it was {}", rounded(value, 3))),
    };
    expected.iter().zip(watch.values(expected)).map(verdict).collect()
}

fn holds(expectation: &Expectation, value: Option<f64>) -> bool {
    value.is_some_and(|value| expectation.comparison.holds(value, expectation.number))
}

/// Plays a match to its end and judges `expected` by it.
///
/// # Errors
/// [`PlayError`] if the match cannot be started.
pub fn play(
    simulator: impl Fn() -> App,
    scenario: &Scenario,
    expected: &[Expectation],
) -> Result<Vec<Verdict>, PlayError> {
    watched(&simulator, scenario, expected).map(|watch| judge(&watch, expected))
}

fn watched(simulator: &impl Fn() -> App, scenario: &Scenario, expected: &[Expectation]) -> Result<Watch, PlayError> {
    let mut app = simulator();
    app.start_match(scenario)?;
    let world = app.world_mut();
    begin_programs(world)?;
    let mut watch = Watch::begin(world, expected);
    let last_cycle = scenario.last_cycle();
    while world.resource::<Game>().state != GameState::Finished
        && last_cycle.is_none_or(|last| world.resource::<CycleClock>().cycle < last)
    {
        run_cycle(world);
        watch.observe(world, expected);
    }
    agents::dismiss(world, "end");
    Ok(watch)
}

/// Plays the matches that `expected` asks for, each with the next seed, on `threads` threads, and judges them. Expectations about a single
/// match are judged by the match with the scenario's own seed.
///
/// # Errors
/// [`PlayError`] if a match cannot be started, or `stop` becomes true before all are played.
pub fn play_all(
    simulator: impl Fn() -> App + Sync,
    scenario: &Scenario,
    expected: &[Expectation],
    threads: usize,
    stop: &AtomicBool,
) -> Result<Vec<Verdict>, PlayError> {
    let of_all = |expectation: &Expectation| expectation.frequency.map_or(1, |frequency| frequency.matches);
    let matches = expected.iter().map(of_all).max().unwrap_or(0);
    let alone = || {
        let mut app = simulator();
        // The matches themselves use the cores.
        app.insert_resource(SensingThreads(1));
        app
    };
    let play = |(): &mut (), index: usize| {
        let scenario = Scenario { seed: scenario.seed.wrapping_add(index as u64), ..scenario.clone() };
        watched(&alone, &scenario, expected).map(|watch| watch.values(expected).collect::<Vec<Option<f64>>>())
    };
    let mut values = Vec::new();
    play_in_order(0..matches as usize, threads, stop, || (), play, |result| result.map(|of_one| values.push(of_one)))?;
    if values.len() < matches as usize {
        return Err(PlayError::Interrupted { played: values.len(), matches: matches as usize });
    }
    let verdict = |(index, expectation): (usize, &Expectation)| {
        let values = values.iter().take(of_all(expectation) as usize).map(|values| values[index]);
        judge_all(expectation, &values.collect::<Vec<_>>())
    };
    Ok(expected.iter().enumerate().map(verdict).collect())
}

/// Judges an expectation by its `values`, one from each match.
fn judge_all(expectation: &Expectation, values: &[Option<f64>]) -> Verdict {
    let Some(Frequency { percent, .. }) = expectation.frequency else {
        let watch = Watch { values: vec![values.first().copied()], ..Watch::default() };
        return judge(&watch, core::slice::from_ref(expectation)).remove(0);
    };
    let count = values.iter().filter(|value| holds(expectation, **value)).count();
    let share = 100.0 * count as f64 / values.len().max(1) as f64;
    Verdict {
        expectation: *expectation,
        holds: share >= percent,
        found: format!("it was so in {} % ({count} of {})", rounded(share, 3), values.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_of_matches_is_counted_and_what_could_not_be_measured_does_not_hold() {
        let values = [Some(0.0), Some(1.0), None, Some(2.0)];
        let verdict = |text: &str| judge_all(&text.parse().unwrap(), &values);
        assert!(verdict("blue.goals >= 1 in 50 % of 4").holds);
        let short = verdict("blue.goals >= 1 in 51 % of 4");
        assert!(!short.holds);
        assert_eq!(short.to_string(), "blue.goals >= 1 in 51 % of 4: it was so in 50 % (2 of 4)");
        assert!(verdict("blue.goals <= 0").holds);
        assert!(!judge_all(&"blue1.pose_error_m < 9".parse().unwrap(), &[None]).holds);
    }
}
