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
use core::convert::Infallible;
use core::fmt;
use core::str::FromStr;
use rand::RngExt;
use serde::Serialize;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::action::ActionKind;
use super::challenge::{Challenge, ChallengeError, SuccessRate};
use super::episode::{EnvironmentSettings, Episode, Start, StartError};
use super::observation::ObservationKind;
use crate::agents::with_remote_robots;
use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::cycle::CycleClock;
use naoisis_core::random::RandomStream;
use naoisis_core::statistics;
use naoisis_sensing::sensing::jobs::SensingThreads;
use naoisis_sim::scenario::wording::did_you_mean;
use naoisis_sim::scenario::{BehaviourSpec, Scenario};
use naoisis_sim::simulation::{play_in_order, resolved};

/// The controller of the robots of a challenge.
#[derive(Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum ChallengePlayer {
    /// Random actions.
    Random,
    /// The behaviour with this name, for each robot.
    Behaviour(String),
    /// The team with this name.
    Team(String),
}

impl FromStr for ChallengePlayer {
    type Err = Infallible;

    /// Parses `random`, the name of a behaviour, or `team` and the name of a team.
    fn from_str(word: &str) -> Result<Self, Infallible> {
        Ok(match (word, word.strip_prefix("team ")) {
            ("random", _) => ChallengePlayer::Random,
            (_, Some(team)) => ChallengePlayer::Team(team.to_owned()),
            _ => ChallengePlayer::Behaviour(word.to_owned()),
        })
    }
}

impl fmt::Display for ChallengePlayer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ChallengePlayer::Random => formatter.write_str("random"),
            ChallengePlayer::Behaviour(name) => formatter.write_str(name),
            ChallengePlayer::Team(name) => write!(formatter, "team {name}"),
        }
    }
}

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

/// The result of an episode.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
#[non_exhaustive]
pub struct Attempt {
    /// Its seed.
    pub seed: u64,
    /// Whether it ended with a success.
    pub is_success: bool,
    /// Its duration, s.
    pub time_s: f64,
}

/// The success rate of `attempts`.
pub fn success_rate(attempts: &[Attempt]) -> SuccessRate {
    let times: Vec<f64> = attempts.iter().filter(|attempt| attempt.is_success).map(|attempt| attempt.time_s).collect();
    let mean_time_s = statistics::mean(&times).map(|mean| mean.value);
    SuccessRate { episodes: attempts.len(), successes: times.len(), mean_time_s }
}

/// Why a challenge cannot be played.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum AttemptError {
    /// The challenge is invalid.
    #[error(transparent)]
    Challenge(#[from] ChallengeError),
    /// No team has this name.
    #[error("there is no team `{name}`{meant}; expected one of {known}")]
    NoTeam {
        /// Its name.
        name: String,
        /// A suggestion, in words.
        meant: String,
        /// All names of teams.
        known: String,
    },
    /// An episode cannot start, for example because a behaviour does not exist.
    #[error(transparent)]
    Start(#[from] StartError),
}

naoisis_core::debug_as_displayed!(AttemptError);

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
    let settings = settings(challenge, player, simulator().world())?;
    let worker = || {
        let mut app = simulator();
        // The cores are used by the episodes, so each match has one thread.
        app.insert_resource(SensingThreads(1));
        Episode::new(core::mem::take(app.world_mut()), 0)
    };
    let play = |episode: &mut Episode, index: usize| {
        play(episode, &settings, player, attempts.first_seed.wrapping_add(index as u64))
    };
    play_in_order(0..attempts.episodes, attempts.threads, stop, worker, play, |attempt| attempt.map(&mut finished))
}

fn settings(
    challenge: &Challenge,
    player: &ChallengePlayer,
    world: &World,
) -> Result<EnvironmentSettings, AttemptError> {
    let scenario = challenge.scenario().map_err(ChallengeError::from)?.scenario;
    Ok(EnvironmentSettings {
        start: Arc::new(Start::Scenarios {
            first: Box::new(played_by(player, &scenario, challenge, world)?),
            others: Vec::new(),
            situation: challenge.situation.clone(),
        }),
        control: challenge.control.clone(),
        end: challenge.end,
        observation: ObservationKind::Perception,
        camera: None,
        action: ActionKind::Continuous,
        cycles_per_step: challenge.cycles_per_step,
        reward: challenge.reward,
    })
}

/// The scenario, with its controlled robots played by `player`.
fn played_by(
    player: &ChallengePlayer,
    scenario: &Scenario,
    challenge: &Challenge,
    world: &World,
) -> Result<Scenario, AttemptError> {
    let registry = world.resource::<BehaviourRegistry>();
    let team = match player {
        ChallengePlayer::Random => {
            let scenario = with_remote_robots(world, scenario, &challenge.control);
            return Ok(scenario.map_err(StartError::from)?);
        }
        ChallengePlayer::Behaviour(_) => None,
        ChallengePlayer::Team(name) => Some(registry.team(name).ok_or_else(|| {
            let known: Vec<&str> = registry.teams().map(|(name, _)| name).collect();
            let meant = did_you_mean(name, known.iter().copied());
            AttemptError::NoTeam { name: name.clone(), meant, known: known.join(", ") }
        })?),
    };
    let mut scenario = resolved(world, scenario);
    let size = challenge.control.len().try_into().unwrap_or(u8::MAX);
    for robot in scenario.robots.iter_mut().filter(|robot| challenge.control.contains(&robot.id())) {
        robot.behaviour = BehaviourSpec::Named(match (team, player) {
            (Some(team), _) => team.behaviour_of(robot.id().number, size).into_owned(),
            (None, player) => player.to_string(),
        });
    }
    Ok(scenario)
}

fn play(
    episode: &mut Episode,
    settings: &EnvironmentSettings,
    player: &ChallengePlayer,
    seed: u64,
) -> Result<Attempt, AttemptError> {
    episode.seed(seed);
    episode.begin(settings)?;
    let mut chance = RandomStream::for_match(seed, "random actions");
    let numbers = match player {
        ChallengePlayer::Random => settings.control.len() * settings.action.len(),
        // The robots decide for themselves.
        ChallengePlayer::Behaviour(_) | ChallengePlayer::Team(_) => 0,
    };
    let mut actions = vec![0.0; numbers];
    let mut rewards = vec![0.0; settings.control.len()];
    while !episode.progress.is_over() {
        actions.fill_with(|| chance.random_range(-1.0..=1.0));
        episode.step(settings, &actions, &mut rewards);
    }
    // Robots have already perceived in the cycle that would come next.
    let time_s = episode.world.resource::<CycleClock>().start_time_s();
    Ok(Attempt { seed, is_success: episode.progress.is_success, time_s })
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::simulation::NaoisisPlugins;

    fn attempts(challenge: &str, player: &str, attempts: &Attempts) -> Result<Vec<Attempt>, AttemptError> {
        let simulator = || {
            let mut app = App::new();
            app.add_plugins(NaoisisPlugins);
            app
        };
        let mut played = Vec::new();
        let challenge = Challenge::named(challenge)?;
        let Ok(player) = player.parse();
        play_attempts(&challenge, &player, attempts, simulator, &AtomicBool::new(false), |attempt| {
            played.push(attempt);
        })?;
        Ok(played)
    }

    #[test]
    fn what_comes_of_attempts_does_not_depend_on_threads() {
        let some = |threads| attempts("FindBall", "random", &Attempts { episodes: 6, first_seed: 3, threads }).unwrap();
        assert_eq!(some(1), some(3));
        assert_eq!(some(1).iter().map(|attempt| attempt.seed).collect::<Vec<_>>(), [3, 4, 5, 6, 7, 8]);
    }

    #[test]
    fn the_rates_of_the_files_are_those_that_come_out() {
        for name in ["FindBall", "ScoreEmptyGoal"] {
            let challenge = Challenge::named(name).unwrap();
            assert!(["idle", "random"].iter().all(|player| challenge.success_rates.contains_key(*player)), "{name}");
            assert!(challenge.success_rates.len() > 2, "{name}");
            for (player, written) in &challenge.success_rates {
                let few = Attempts { episodes: 8, first_seed: 1, threads: 2 };
                let found = success_rate(&attempts(name, player, &few).unwrap()).share().unwrap();
                let written = written.share().unwrap();
                assert!(
                    found.low <= written.high && written.low <= found.high,
                    "{name} {player} {found:?} {written:?}"
                );
            }
        }
    }

    #[test]
    fn who_does_not_exist_cannot_play() {
        let one = Attempts { episodes: 1, first_seed: 1, threads: 1 };
        let error = attempts("TwoOnTwo", "team nobody", &one).unwrap_err().to_string();
        assert!(error.starts_with("there is no team `nobody`; expected one of chasers"), "{error}");
        let error = attempts("TwoOnTwo", "nobody", &one).unwrap_err().to_string();
        assert!(error.contains("nobody"), "{error}");
    }

    #[test]
    fn a_player_is_a_word() {
        for word in ["random", "striker", "team roles"] {
            let Ok(player) = word.parse::<ChallengePlayer>();
            assert_eq!(player.to_string(), word);
        }
    }
}
