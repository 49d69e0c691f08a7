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

use base64::prelude::{BASE64_STANDARD, Engine};
use bevy::prelude::*;
use rand::RngExt;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::action::ActionKind;
pub use super::attempt_error::AttemptError;
use super::challenge::{Challenge, ChallengeError, SuccessRate};
use super::episode::{EnvironmentSettings, Episode, Start};
use super::kind::ObservationForm;
pub use super::player::ChallengePlayer;
use super::recorded_commands::{self, RecordedCommands, record_commands};
use super::start_error::StartError;
use super::state::ball_of;
use crate::agents::{RobotCommand, dismiss, with_remote_robots};
use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::Pose;
use naoisis_core::random::RandomStream;
use naoisis_core::robot::Roster;
use naoisis_core::statistics;
use naoisis_core::team::RobotId;
use naoisis_sensing::sensing::jobs::SensingThreads;
use naoisis_sim::scenario::wording::did_you_mean;
use naoisis_sim::scenario::{BehaviourSpec, Scenario, TeamsSpec};
use naoisis_sim::simulation::{play_in_order, resolved, start_match};

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
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Attempt {
    /// Its seed.
    pub seed: u64,
    /// Whether it ended with a success.
    pub is_success: bool,
    /// Its duration, s.
    pub time_s: f64,
    /// A number that depends on where ball and robots were at its end, as sixteen hexadecimal digits.
    pub end_state: String,
    /// A byte for each step that depends on where ball and robots were after it, in base64; empty in older files.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub steps: String,
    /// The commands of the controlled robots in each cycle, if programs gave them: JSON, compressed by zstd, in base64.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commands: Option<String>,
}

impl Attempt {
    /// Whether it came out as `written`, which has no steps if it is of an earlier version. The commands need not be the same.
    pub(super) fn is_as(&self, written: &Self) -> bool {
        *self
            == Self {
                steps: if written.steps.is_empty() { self.steps.clone() } else { written.steps.clone() },
                commands: self.commands.clone(),
                ..written.clone()
            }
    }

    /// The time of the first step after which ball or robots were elsewhere than in `other`, s. `None` if all common steps are the same.
    /// A byte differs with a probability of 255 / 256, so the time may be one of the next steps.
    pub fn first_difference_s(&self, other: &Self) -> Option<f64> {
        let [own, others] = [self, other].map(|attempt| BASE64_STANDARD.decode(&attempt.steps).unwrap_or_default());
        let step = own.iter().zip(&others).position(|(own, other)| own != other)?;
        Some(self.time_s * (step + 1) as f64 / own.len() as f64)
    }
}

/// The success rate of `attempts`.
pub fn success_rate(attempts: &[Attempt]) -> SuccessRate {
    let times: Vec<f64> = attempts.iter().filter(|attempt| attempt.is_success).map(|attempt| attempt.time_s).collect();
    let mean_time_s = statistics::mean(&times).map(|mean| mean.value);
    SuccessRate { episodes: attempts.len(), successes: times.len(), mean_time_s }
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

/// A simulator that records the commands of robots if `is_recorded`.
fn recording(simulator: &(impl Fn() -> App + Sync), is_recorded: bool) -> impl Fn() -> App + Sync {
    move || {
        let mut app = simulator();
        if is_recorded {
            record_commands(&mut app);
        }
        app
    }
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

pub(super) fn world(simulator: impl Fn() -> App) -> World {
    let mut app = simulator();
    // The cores are used by the episodes, so each match has one thread.
    app.insert_resource(SensingThreads(1));
    core::mem::take(app.world_mut())
}

pub(super) fn settings(
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
        observed: ObservationForm::default(),
        camera: None,
        blind: false,
        action: ActionKind::Continuous,
        cycles_per_step: challenge.cycles_per_step,
        reward: challenge.reward,
        counter: None,
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
    let size = challenge.control.len().try_into().unwrap_or(u8::MAX);
    let behaviour: Box<dyn Fn(RobotId) -> BehaviourSpec> = match player {
        ChallengePlayer::Random | ChallengePlayer::Ahead | ChallengePlayer::OpenLoop(_) => {
            let scenario = with_remote_robots(world, scenario, &challenge.control);
            return Ok(scenario.map_err(StartError::from)?);
        }
        ChallengePlayer::Behaviour(name) => Box::new(|_| BehaviourSpec::Named(name.clone())),
        ChallengePlayer::Policy(file) => Box::new(|_| BehaviourSpec::Policy(file.clone())),
        ChallengePlayer::Team(name) => match TeamsSpec::command_line(name) {
            Some(words) => {
                let words = words.filter(|words| !words.is_empty());
                let words = words.ok_or_else(|| AttemptError::NoProgram(name.clone()))?;
                Box::new(move |_| BehaviourSpec::Program(words.clone()))
            }
            None => {
                let team = registry.team(name).ok_or_else(|| {
                    let known: Vec<&str> = registry.teams().map(|(name, _)| name).collect();
                    let meant = did_you_mean(name, known.iter().copied());
                    AttemptError::NoTeam { name: name.clone(), meant, known: known.join(", ") }
                })?;
                Box::new(move |id| BehaviourSpec::Named(team.behaviour_of(id.number, size).into_owned()))
            }
        },
    };
    let mut scenario = resolved(world, scenario);
    for robot in scenario.robots.iter_mut().filter(|robot| challenge.control.contains(&robot.id())) {
        robot.behaviour = behaviour(robot.id());
    }
    Ok(scenario)
}

/// A player that is ready for a challenge.
struct Prepared {
    settings: EnvironmentSettings,
    player: ChallengePlayer,
    /// The commands to play back in all episodes, by cycle and robot, if it plays something back.
    commands: Option<Vec<Vec<RobotCommand>>>,
}

impl Prepared {
    fn new(
        challenge: &Challenge,
        player: &ChallengePlayer,
        simulator: &(impl Fn() -> App + Sync),
    ) -> Result<Self, AttemptError> {
        let mut settings = settings(challenge, player, simulator().world())?;
        if *player != ChallengePlayer::Random {
            settings.cycles_per_step = 1;
        }
        let commands = match player {
            ChallengePlayer::OpenLoop(player) => Some(commands_of_success(challenge, player, simulator)?),
            _ => None,
        };
        Ok(Self { settings, player: player.clone(), commands })
    }

    /// Plays the episode with `seed`, by commands for each cycle and robot if they are given.
    fn play(
        &self,
        episode: &mut Episode,
        seed: u64,
        commands: Option<&[Vec<RobotCommand>]>,
    ) -> Result<Attempt, AttemptError> {
        let settings = &self.settings;
        episode.seed(seed);
        episode.begin(settings)?;
        let mut chance = RandomStream::for_match(seed, "random actions");
        let numbers = if self.player.has_own_robots() { 0 } else { settings.control.len() * settings.action.len() };
        let mut actions = vec![0.0; numbers];
        if self.player == ChallengePlayer::Ahead {
            // No walk to the side, no turn, the head straight, and no kick.
            for action in actions.chunks_mut(settings.action.len()) {
                action[0] = 1.0;
            }
        }
        let mut rewards = vec![0.0; settings.control.len()];
        let mut cycles = commands.map(<[_]>::iter);
        let mut steps = Vec::new();
        while !episode.progress.is_over() {
            if let Some(cycles) = &mut cycles {
                let nothing = || vec![RobotCommand::default(); settings.control.len()];
                episode.step_with(settings, cycles.next().cloned().unwrap_or_else(nothing), &mut rewards);
            } else {
                if self.player == ChallengePlayer::Random {
                    actions.fill_with(|| chance.random_range(-1.0..=1.0));
                }
                episode.step(settings, &actions, &mut rewards);
            }
            steps.push((digest(&episode.world) >> 56) as u8);
            if let Some((robot, message)) = episode.lost.take() {
                return Err(AttemptError::Lost { seed, robot, message });
            }
        }
        dismiss(&mut episode.world, "the episode is over");
        // Robots have already perceived in the cycle that would come next.
        let time_s = episode.world.resource::<CycleClock>().start_time_s();
        let end_state = format!("{:016x}", digest(&episode.world));
        let steps = BASE64_STANDARD.encode(steps);
        Ok(Attempt { seed, is_success: episode.progress.is_success, time_s, end_state, steps, commands: None })
    }
}

/// The seed of the first episode that is tried for playing back: none of those that are counted.
const FIRST_RECORDED: u64 = 2_000_000_001;

/// The commands of `player` in its first successful episode, by cycle and robot.
fn commands_of_success(
    challenge: &Challenge,
    player: &ChallengePlayer,
    simulator: &(impl Fn() -> App + Sync),
) -> Result<Vec<Vec<RobotCommand>>, AttemptError> {
    /// The most episodes that are tried.
    const MOST_TRIES: u64 = 100;

    let prepared = Prepared::new(challenge, player, simulator)?;
    let mut episode = Episode::new(world(recording(simulator, true)), 0);
    for seed in FIRST_RECORDED..FIRST_RECORDED + MOST_TRIES {
        let attempt = prepared.play(&mut episode, seed, prepared.commands.as_deref())?;
        let mut cycles = episode.world.resource_mut::<RecordedCommands>().take(&challenge.control);
        if attempt.is_success {
            // Only what the robots did: what they said and asked for belongs to that episode.
            for command in cycles.iter_mut().flatten() {
                *command = RobotCommand { say: None, request: None, ..core::mem::take(command) };
            }
            return Ok(cycles);
        }
    }
    Err(AttemptError::NothingToPlayBack { player: player.to_string(), tried: MOST_TRIES })
}

/// A number that depends on the positions of ball and robots, by the method of Fowler, Noll and Vo (FNV-1a).
fn digest(world: &World) -> u64 {
    let pose = |pose: &Pose| [pose.position.x, pose.position.y, pose.heading];
    let ball = ball_of(world).map(|(ball, velocity)| [ball.x, ball.y, velocity.length()]);
    let robots = world.resource::<Roster>().iter().filter_map(|(_, robot)| world.get::<Pose>(robot).map(pose));
    let bytes = ball.into_iter().chain(robots).flatten().flat_map(|value| value.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::challenge::CHALLENGES;
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
