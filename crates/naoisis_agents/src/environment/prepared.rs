//! A player that is ready for a challenge, and one episode that it plays.

use base64::prelude::{BASE64_STANDARD, Engine};
use bevy::prelude::*;
use rand::RngExt;
use std::sync::Arc;

use super::action::ActionKind;
use super::attempt::Attempt;
use super::attempt_error::AttemptError;
use super::challenge::{Challenge, ChallengeError};
use super::episode::{EnvironmentSettings, Episode, Start};
use super::kind::ObservationForm;
use super::player::ChallengePlayer;
use super::recorded_commands::{RecordedCommands, record_commands};
use super::start_error::StartError;
use super::state::ball_of;
use crate::agents::{RobotCommand, dismiss, with_remote_robots};
use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::Pose;
use naoisis_core::random::RandomStream;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_sensing::sensing::jobs::SensingThreads;
use naoisis_sim::scenario::wording::did_you_mean;
use naoisis_sim::scenario::{BehaviourSpec, Scenario, TeamsSpec};
use naoisis_sim::simulation::resolved;

/// A world of `simulator` for episodes.
pub(super) fn world(simulator: impl Fn() -> App) -> World {
    let mut app = simulator();
    // The cores are used by the episodes, so each match has one thread.
    app.insert_resource(SensingThreads(1));
    core::mem::take(app.world_mut())
}

/// A simulator that records the commands of robots if `is_recorded`.
pub(super) fn recording(simulator: &(impl Fn() -> App + Sync), is_recorded: bool) -> impl Fn() -> App + Sync {
    move || {
        let mut app = simulator();
        if is_recorded {
            record_commands(&mut app);
        }
        app
    }
}

/// The settings of an environment with the episodes of `challenge`, in which `player` plays the controlled robots.
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
pub(super) fn played_by(
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
pub(super) struct Prepared {
    settings: EnvironmentSettings,
    player: ChallengePlayer,
    /// The commands to play back in all episodes, by cycle and robot, if it plays something back.
    pub(super) commands: Option<Vec<Vec<RobotCommand>>>,
}

impl Prepared {
    pub(super) fn new(
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
    pub(super) fn play(
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
pub(super) const FIRST_RECORDED: u64 = 2_000_000_001;

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
