//! Success rates of challenges, with random actions or with behaviours.
//!
//! ```
//! use core::sync::atomic::AtomicBool;
//! use bevy::prelude::*;
//! use naoisis::environment::Challenge;
//! use naoisis::environment::attempts::{Attempts, ChallengePlayer, play_attempts};
//! use naoisis::prelude::*;
//!
//! let simulator = || {
//!     let mut app = App::new();
//!     app.add_plugins(NaoisisPlugins);
//!     app
//! };
//! let attempts = Attempts { episodes: 4, first_seed: 1, threads: 1 };
//! let mut successes = 0;
//! let idle = ChallengePlayer::Behaviour("idle".to_owned());
//! play_attempts(&Challenge::named("ScoreEmptyGoal")?, &idle, &attempts, simulator, &AtomicBool::new(false), |attempt| {
//!     successes += usize::from(attempt.is_success);
//! })?;
//! assert_eq!(successes, 0);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

use bevy::prelude::*;
use std::sync::atomic::AtomicBool;

pub use super::attempt::{Attempt, success_rate};
pub use super::attempt_error::AttemptError;
use super::challenge::{Challenge, ChallengeError};
use super::episode::Episode;
pub use super::player::ChallengePlayer;
use super::prepared::{FIRST_RECORDED, Prepared, played_by, recording, world};
use super::recorded_commands::{self, RecordedCommands};
use super::start_error::StartError;
use naoisis_sim::scenario::Scenario;
use naoisis_sim::simulation::{play_in_order, start_match};

/// The episodes to play.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Attempts {
    /// The number of episodes.
    pub episodes: usize,
    /// The seed of the first episode; each further one has the next seed. An environment that is reset with a seed
    /// starts with the same episode.
    pub first_seed: u64,
    /// The number of threads, at least 1.
    pub threads: usize,
}

/// Plays episodes of a challenge and passes their results to the callback in the order of their seeds. When `stop`
/// turns true, running episodes are finished and no new ones start.
///
/// # Errors
/// If an episode cannot start.
pub fn play_attempts(
    challenge: &Challenge,
    player: &ChallengePlayer,
    attempts: &Attempts,
    simulator: impl Fn() -> App + Sync,
    stop: &AtomicBool,
    mut finished: impl FnMut(Attempt),
) -> Result<(), AttemptError> {
    let prepared = Prepared::new(challenge, player, &simulator)?;
    let simulator = recording(&simulator, player.is_program());
    let worker = || Episode::new(world(&simulator), 0);
    let play = |episode: &mut Episode, index: usize| {
        let seed = attempts.first_seed.wrapping_add(index as u64);
        let mut attempt = prepared.play(episode, seed, prepared.commands.as_deref())?;
        if let Some(mut recorded) = episode.world.get_resource_mut::<RecordedCommands>() {
            attempt.commands = recorded_commands::pack(&recorded.take(&challenge.control));
        }
        Ok(attempt)
    };
    play_in_order(0..attempts.episodes, attempts.threads, stop, worker, play, |attempt| attempt.map(&mut finished))
}

/// Plays episodes again by the commands that were recorded in them, like [`play_attempts`]: no program is started.
pub(super) fn play_recorded(
    challenge: &Challenge,
    attempts: &[Attempt],
    threads: usize,
    simulator: impl Fn() -> App + Sync,
    stop: &AtomicBool,
    mut finished: impl FnMut(Attempt),
) -> Result<(), AttemptError> {
    // Robots that are commanded from outside, cycle by cycle.
    let prepared = Prepared::new(challenge, &ChallengePlayer::Ahead, &simulator)?;
    let worker = || Episode::new(world(&simulator), 0);
    let play = |episode: &mut Episode, index: usize| {
        let seed = attempts[index].seed;
        let commands = attempts[index].commands.as_deref().and_then(recorded_commands::unpack);
        prepared.play(episode, seed, Some(&commands.ok_or(AttemptError::DamagedCommands { seed })?))
    };
    play_in_order(0..attempts.len(), threads, stop, worker, play, |attempt| attempt.map(&mut finished))
}

/// Checks that `player` can play in `challenge`: that it exists, and that its files can be read. Programs are not started.
///
/// # Errors
/// Why it cannot.
pub fn check_player(
    challenge: &Challenge,
    player: &ChallengePlayer,
    simulator: impl Fn() -> App,
) -> Result<(), AttemptError> {
    let player = if let ChallengePlayer::OpenLoop(recorded) = player { recorded } else { player };
    if player.has_own_robots() {
        let mut world = world(simulator);
        let scenario = scenario_of_episode(challenge, player, FIRST_RECORDED, &world)?;
        start_match(&mut world, &scenario).map_err(StartError::from)?;
    }
    Ok(())
}

/// The scenario of the episode with `seed`, in which `player` plays the controlled robots.
///
/// # Errors
/// If the player does not exist, or decides outside of the match, like `random`.
pub fn scenario_of_episode(
    challenge: &Challenge,
    player: &ChallengePlayer,
    seed: u64,
    world: &World,
) -> Result<Scenario, AttemptError> {
    if !player.has_own_robots() {
        return Err(AttemptError::Outside(player.clone()));
    }
    let scenario = challenge.scenario().map_err(ChallengeError::from)?.scenario;
    let first = played_by(player, &scenario, challenge, world)?;
    Ok(Episode::scenario_of(&first, &[], &challenge.situation, Episode::first_seed(seed)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::challenge::{CHALLENGES, SuccessRate};
    use crate::policy::PolicyPlugin;
    use naoisis_sim::scenario::Realism;
    use naoisis_sim::simulation::NaoisisPlugins;

    fn simulator() -> App {
        let mut app = App::new();
        app.add_plugins((NaoisisPlugins, PolicyPlugin));
        app
    }

    fn attempts(
        challenge: &str,
        realism: Realism,
        player: &str,
        attempts: &Attempts,
    ) -> Result<Vec<Attempt>, AttemptError> {
        let mut played = Vec::new();
        let challenge = Challenge::named(challenge)?.with(realism, None)?;
        let Ok(player) = player.parse();
        play_attempts(&challenge, &player, attempts, simulator, &AtomicBool::new(false), |attempt| {
            played.push(attempt);
        })?;
        Ok(played)
    }

    #[test]
    fn what_comes_of_attempts_does_not_depend_on_threads() {
        let some = |threads| {
            attempts("FindBall", Realism::Paper, "random", &Attempts { episodes: 6, first_seed: 3, threads }).unwrap()
        };
        assert_eq!(some(1), some(3));
        assert_eq!(some(1).iter().map(|attempt| attempt.seed).collect::<Vec<_>>(), [3, 4, 5, 6, 7, 8]);
    }

    #[test]
    fn every_task_is_solved_by_some_player_and_not_by_one_that_does_nothing() {
        for (name, _) in CHALLENGES.iter().filter(|(name, _)| !name.starts_with("Match")) {
            let challenge = Challenge::named(name).unwrap();
            let rates_in = |level: Realism| challenge.success_rates.get(level.name());
            let Some(rates) = rates_in(Realism::Ideal) else { continue };
            for share in ["idle", "random", "ahead"].iter().filter_map(|blind| rates.get(*blind)?.share()) {
                assert!(share.value < 0.1, "{name} {share:?}");
            }
            let share = |rate: &SuccessRate| rate.share().map_or(0.0, |share| share.value);
            let some = |level, player: &str, episodes| {
                let few = Attempts { episodes, first_seed: 1, threads: 2 };
                success_rate(&attempts(name, level, player, &few).unwrap())
            };
            // The rates of the table are those of the players today.
            for level in [Realism::Ideal, Realism::Realistic] {
                let rates = rates_in(level).unwrap().iter();
                let (best, written) = rates.max_by(|one, other| share(one.1).total_cmp(&share(other.1))).unwrap();
                let (found, written) = (some(level, best, 16).share().unwrap(), written.share().unwrap());
                assert!(found.value > 0.0 || level == Realism::Realistic, "{name} {best}");
                assert!(found.low <= written.high && written.low <= found.high, "{name} {best} {found:?} {written:?}");
            }
            let idle = some(Realism::Ideal, "idle", 4);
            assert!(idle.successes < idle.episodes, "{name} {idle:?}");
        }
    }

    #[test]
    fn what_is_played_back_succeeds_where_it_was_recorded() {
        let challenge = Challenge::named("GoToBall").unwrap().with(Realism::Ideal, None).unwrap();
        let player = ChallengePlayer::OpenLoop(Box::new(ChallengePlayer::Behaviour("chaser".to_owned())));
        let prepared = Prepared::new(&challenge, &player, &simulator).unwrap();
        let mut episode = Episode::new(world(simulator), 0);
        let mut is_success = |seed| prepared.play(&mut episode, seed, prepared.commands.as_deref()).unwrap().is_success;
        assert!((FIRST_RECORDED..FIRST_RECORDED + 5).any(&mut is_success));
        assert!((1..6).filter(|seed| is_success(*seed)).count() <= 1);
    }

    #[test]
    fn who_does_not_exist_cannot_play() {
        let one = Attempts { episodes: 1, first_seed: 1, threads: 1 };
        let error = attempts("TwoOnTwo", Realism::Paper, "team nobody", &one).unwrap_err().to_string();
        assert!(error.starts_with("there is no team `nobody`; expected one of chasers"), "{error}");
        let error = attempts("TwoOnTwo", Realism::Paper, "nobody", &one).unwrap_err().to_string();
        assert!(error.contains("nobody"), "{error}");
        let error = attempts("TwoOnTwo", Realism::Paper, "exec:'", &one).unwrap_err().to_string();
        assert_eq!(error, "`exec:'` names no program; expected a command line after `exec:`, with closed quotes");
    }
}
