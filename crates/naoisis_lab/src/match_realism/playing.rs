//! Plays and measures matches.

use bevy::math::{FloatPow, ops};
use bevy::prelude::*;
use core::f32::consts::FRAC_PI_2;
use core::sync::atomic::AtomicBool;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::measures::MatchMeasures;
use super::meter::MatchMeter;
use naoisis_core::cycle::{CycleClock, run_cycle};
use naoisis_core::events::{CycleEvents, MatchEvent};
use naoisis_core::game::{Game, GameState};
use naoisis_core::team::Team;
use naoisis_sensing::sensing::jobs::SensingThreads;
use naoisis_sim::interface::gather::{CurrentRecord, GatherPlugin, gather_start};
use naoisis_sim::scenario::{Scenario, ScenarioFault};
use naoisis_sim::simulation::{MatchApp, play_in_order};

/// Why a match has no measures.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum MatchFailure {
    /// The match cannot be started.
    #[error("it cannot be started: {0}")]
    Start(#[from] ScenarioFault),
    /// The match panicked.
    #[error("it panicked: {0}")]
    Panicked(String),
    /// An invariant of the simulation was broken.
    #[error("it broke an invariant: {0}")]
    InvariantBroken(String),
}

naoisis_core::debug_as_displayed!(MatchFailure);

/// Plays and measures one match of `scenario`, to its end but without a shoot-out, in an app made by `simulator`.
///
/// # Errors
/// If the match cannot be started, panics, or breaks an invariant.
pub fn play_match(simulator: impl Fn() -> App, scenario: &Scenario) -> Result<MatchMeasures, MatchFailure> {
    let played = catch_unwind(AssertUnwindSafe(|| {
        let mut app = simulator();
        if !app.is_plugin_added::<GatherPlugin>() {
            app.add_plugins(GatherPlugin);
        }
        // The matches themselves use the cores.
        app.insert_resource(SensingThreads(1));
        play_to_the_end(app.start_match(scenario)?.world_mut(), scenario)
    }));
    played.unwrap_or_else(|payload| {
        let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
        Err(MatchFailure::Panicked(text.unwrap_or_else(|| "without a message".to_owned())))
    })
}

fn play_to_the_end(world: &mut World, scenario: &Scenario) -> Result<MatchMeasures, MatchFailure> {
    gather_start(world);
    let mut meter = MatchMeter::new(scenario);
    let last_cycle = scenario.last_cycle();
    loop {
        meter.look(&world.resource::<CurrentRecord>().record);
        let is_broken = |event: &MatchEvent| match event {
            MatchEvent::InvariantBroken { message } => Some(message.clone()),
            _ => None,
        };
        if let Some(message) = world.resource::<CycleEvents>().iter().find_map(is_broken) {
            return Err(MatchFailure::InvariantBroken(message));
        }
        let game = world.resource::<Game>();
        let is_over = game.state == GameState::Finished || game.shoot_out.is_some();
        if is_over || last_cycle.is_some_and(|last| world.resource::<CycleClock>().cycle >= last) {
            return Ok(meter.finish());
        }
        run_cycle(world);
    }
}

/// Returns the match of `scenario` with `seed` as in a tournament of unequal teams: a team without a handicap gets one between 0 and
/// `spread` (0 to 0.9), drawn from the seed. More teams are strong or weak than in between: with uniform draws, high wins were too rare.
///
/// The draws of successive seeds are spread evenly over all pairs of handicaps. With independent draws, the goals of 60 matches depended
/// more on the pairs that happened to be drawn than on the play.
fn with_drawn_handicaps(scenario: &Scenario, seed: u64, spread: f32) -> Scenario {
    let mut scenario = Scenario { seed, ..scenario.clone() };
    for (team, share) in Team::BOTH.into_iter().zip(evenly_spread(seed)) {
        let drawn = spread * to_the_ends(to_the_ends(share));
        if let Some(teams) = &mut scenario.teams
            && teams.robots[team].handicap == 0.0
        {
            teams.robots[team].handicap = drawn;
        }
    }
    scenario
}

/// Returns two numbers from 0 to 1, which for successive seeds fill the unit square evenly: the additive recurrence with the powers of the
/// inverse of the plastic number (M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018).
fn evenly_spread(seed: u64) -> [f32; 2] {
    /// The inverse of the plastic number and its square, as shares of 2^64.
    const STEPS: [u64; 2] = [0xC13F_A9A9_02A6_328F, 0x91E1_0DA5_C79E_7B1C];
    // The upper 24 bits are a number that an `f32` holds exactly.
    STEPS.map(|step| (seed.wrapping_mul(step) >> 40) as f32 / (1 << 24) as f32)
}

/// Moves a number from 0 to 1 towards the nearer end.
fn to_the_ends(share: f32) -> f32 {
    ops::sin(FRAC_PI_2 * share).squared()
}

/// Plays `matches` matches of `scenario` on `threads` threads with seeds from `first_seed` on, and passes each seed with its measures to
/// `finished`, in the order of the seeds. In each match, teams have handicaps between 0 and `spread` (0 to 0.9), drawn from the seed. When
/// `stop` becomes true, the matches under way are finished and no others begin.
pub fn play_matches(
    scenario: &Scenario,
    spread: f32,
    matches: usize,
    first_seed: u64,
    threads: usize,
    simulator: impl Fn() -> App + Sync,
    stop: &AtomicBool,
    mut finished: impl FnMut(u64, Result<MatchMeasures, MatchFailure>),
) {
    let play = |(): &mut (), index: usize| {
        let seed = first_seed.wrapping_add(index as u64);
        (seed, play_match(&simulator, &with_drawn_handicaps(scenario, seed, spread)))
    };
    let Ok(()) = play_in_order(
        0..matches,
        threads,
        stop,
        || (),
        play,
        |(seed, measures)| {
            finished(seed, measures);
            Ok::<(), core::convert::Infallible>(())
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::simulation::NaoisisPlugins;

    fn simulator() -> App {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        app
    }

    fn measured(threads: usize) -> Vec<(u64, MatchMeasures)> {
        let scenario = Scenario { duration_s: Some(30.0), ..Scenario::named("match3v3").unwrap() };
        let mut played = Vec::new();
        let keep = |seed, measures: Result<MatchMeasures, _>| played.push((seed, measures.unwrap()));
        play_matches(&scenario, 0.5, 3, 5, threads, simulator, &AtomicBool::new(false), keep);
        played
    }

    #[test]
    fn measures_are_the_same_for_any_number_of_threads() {
        let played = measured(1);
        assert_eq!(played.iter().map(|(seed, _)| *seed).collect::<Vec<_>>(), [5, 6, 7]);
        let field = played[0].1.field.as_ref().unwrap();
        assert!(field.walked_m > 5.0 && field.robot_play_s > 60.0 && field.ball_seen.is_some(), "{field:?}");
        assert_eq!(measured(3), played);
    }

    #[test]
    fn handicaps_are_drawn_for_teams_that_have_none() {
        let teams = r#"{ "teams": { "blue": { "team": "roles", "handicap": 0.2 }, "pink": "roles" } }"#;
        let scenario = Scenario::from_json(teams).unwrap();
        let handicap = |seed, spread, team: Team| {
            with_drawn_handicaps(&scenario, seed, spread).teams.unwrap().robots[team].handicap
        };
        let drawn: Vec<f32> = (0..1000).map(|seed| handicap(seed, 0.6, Team::Pink)).collect();
        assert!(drawn.iter().all(|drawn| (0.0..=0.6).contains(drawn)));
        assert!((drawn.iter().sum::<f32>() / 1000.0 - 0.3).abs() < 0.005);
        // sin²(π/2 sin²(π/2 · 0.33)) is 0.15: two thirds are in the lowest and highest 15 %.
        let extreme = drawn.iter().filter(|drawn| !(0.15 * 0.6..=0.85 * 0.6).contains(*drawn)).count();
        assert!((660..=680).contains(&extreme), "{extreme}");
        assert_eq!((handicap(7, 0.6, Team::Pink), handicap(7, 0.6, Team::Blue)), (drawn[7], 0.2));
        assert_eq!(handicap(7, 0.0, Team::Pink), 0.0);
    }

    #[test]
    fn any_forty_successive_matches_have_all_pairs_of_strong_and_weak_teams_alike() {
        for first in [0, 1, 977, 1 << 40] {
            let mut pairs = [[0; 2]; 2];
            for seed in first..first + 40 {
                let [blue, pink] = evenly_spread(seed).map(|share| usize::from(share > 0.5));
                pairs[blue][pink] += 1;
            }
            assert!(pairs.as_flattened().iter().all(|count| (8..=12).contains(count)), "{first}: {pairs:?}");
        }
    }

    #[test]
    fn a_match_that_cannot_start_or_panics_says_so() {
        let teams = r#"{ "teams": { "blue": "nobody", "pink": "roles" } }"#;
        let unknown = play_match(simulator, &Scenario::from_json(teams).unwrap()).unwrap_err();
        assert!(unknown.to_string().starts_with("it cannot be started: "), "{unknown}");
        let panics = || -> App { panic!("out of chalk") };
        let panicked = play_match(panics, &Scenario::default()).unwrap_err();
        assert_eq!(panicked.to_string(), "it panicked: out of chalk");
    }
}
