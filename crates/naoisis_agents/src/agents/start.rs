//! The start of programs: their processes, hellos and welcomes.

use bevy::prelude::*;
use std::time::Instant;

use super::connection::Connection;
use super::loss::Loss;
use super::player::{Agent, AgentPlayer, FAREWELL};
use super::process::Process;
use super::protocol::Hello;
use super::remote::believe;
use super::settings::{AgentSettings, LeagueNumbers};

use naoisis_core::behaviour::Program;
use naoisis_core::cycle::CycleClock;
use naoisis_core::events::AgentLoss;
use naoisis_core::game::Game;
use naoisis_core::geometry::Pose;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::{SimpleBelief, team_from_pitch};
use naoisis_sensing::sensing::camera::{CameraRendering, CameraSettings};
use naoisis_sim::scenario::Scenario;

/// Programs that were lost before the match began.
#[derive(Resource, Default)]
pub(super) struct LostAgents(pub Vec<(RobotId, Loss)>);

/// The error that a program cannot be started.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("{robot}: {message}")]
pub struct ProgramStartError {
    /// The robot that it should play.
    pub robot: RobotId,
    /// The reason why the program cannot be started.
    pub message: String,
}

naoisis_core::debug_as_displayed!(ProgramStartError);

/// Starts the programs of all robots that have one and are not played yet, and receives their hellos. Without a call of
/// this function, programs are started in the first cycle.
///
/// Errors of a program that was started are events of the next cycle.
///
/// # Errors
/// The first program that cannot be started; no program is running in that case.
pub fn start_programs(world: &mut World) -> Result<(), ProgramStartError> {
    launch(world)?;
    greet(world);
    Ok(())
}

/// Starts the programs of all robots that have one and are not played yet.
fn launch(world: &mut World) -> Result<(), ProgramStartError> {
    let settings = world.resource::<AgentSettings>().clone();
    let mut waiting = world.query_filtered::<(Entity, &RobotId, &Program), Without<AgentPlayer>>();
    let mut programs: Vec<(Entity, RobotId, Vec<String>)> =
        waiting.iter(world).map(|(entity, id, program)| (entity, *id, program.0.clone())).collect();
    programs.sort_by_key(|(_, id, _)| *id);
    let league = world.get_resource::<LeagueNumbers>().copied();
    let mut agents = Vec::new();
    for (entity, robot, words) in programs {
        let folder = settings.folders[robot.team].as_deref();
        let environment = league.map(|league| league.environment(robot.team)).unwrap_or_default();
        let (process, stream) = Process::start(&words, folder, robot, environment, settings.error_lines.clone())
            .map_err(|message| ProgramStartError { robot, message })?;
        let connection = Connection::new(stream, settings.longest_message, settings.break_off.clone());
        agents.push((entity, connection, process));
    }
    // All programs are started before any is waited for, so that they load at the same time.
    let deadline = settings.start_timeout.map(|time| Instant::now() + time);
    for (entity, connection, process) in agents {
        world.entity_mut(entity).insert(AgentPlayer(Some(Agent::new(connection, Some(process), deadline))));
    }
    Ok(())
}

/// Receives the hellos of all programs that were started, and lets these programs play.
pub(super) fn greet(world: &mut World) {
    let mut players = world.query::<(Entity, &RobotId, &mut AgentPlayer)>();
    let waiting = players.iter_mut(world).filter_map(|(entity, id, mut player)| {
        let agent = if player.waits_to_be_greeted() { player.0.take() } else { None };
        Some((*id, entity, agent?))
    });
    let mut waiting: Vec<(RobotId, Entity, Agent)> = waiting.collect();
    waiting.sort_by_key(|(id, ..)| *id);
    for (robot, entity, mut agent) in waiting {
        let begun = agent.hello().and_then(|hello| begin(world, robot, &mut agent, &hello));
        let player = match begun {
            Ok(()) => AgentPlayer(Some(agent)),
            Err(loss) => {
                // The program may want to read the reason.
                if matches!(loss.reason, AgentLoss::Refused | AgentLoss::Malformed) {
                    agent.wait_for_end(Instant::now() + FAREWELL);
                }
                world.resource_mut::<LostAgents>().0.push((robot, loss));
                AgentPlayer(None)
            }
        };
        world.entity_mut(entity).insert(player);
    }
}

/// Returns the first robot whose program owes a message and may still send it. Waits up to 20 ms for that program.
pub(super) fn first_silent(world: &mut World) -> Option<RobotId> {
    let mut players = world.query::<(&RobotId, &mut AgentPlayer)>();
    let mut players: Vec<(&RobotId, Mut<AgentPlayer>)> = players.iter_mut(world).collect();
    players.sort_by_key(|(id, _)| **id);
    players.into_iter().find_map(|(id, mut player)| player.0.as_mut()?.is_silent().then_some(*id))
}

/// Lets a program that has said hello play a robot.
pub(super) fn begin(world: &mut World, robot: RobotId, agent: &mut Agent, hello: &Hello) -> Result<(), Loss> {
    let entity = world.resource::<Roster>().get(robot);
    let pose = pose_at_the_start(world, robot);
    if hello.belief && pose.is_none() && entity.is_none_or(|entity| world.get::<SimpleBelief>(entity).is_none()) {
        // An estimator that begins now would begin at the true pose.
        let message = "it asks for beliefs in the middle of a match, and no estimator has run for its robot; expected a hello without \
                       `belief`, or one before the match begins";
        return Err(agent.refuse(message.to_owned()));
    }
    let scenario = world.resource::<Scenario>();
    agent.welcome(hello, (robot, pose), scenario, scenario.settings.cameras.render != CameraRendering::Off)?;
    // Without a setting, cameras take images for programs that ask for them.
    if !hello.images.is_empty()
        && let Some(mut cameras) = entity.and_then(|entity| world.get_mut::<CameraSettings>(entity))
        && cameras.render == CameraRendering::Auto
    {
        cameras.render = CameraRendering::Software;
    }
    if hello.belief {
        believe(world, robot).map_err(|error| Loss::new(AgentLoss::Refused, error.to_string()))?;
    }
    Ok(())
}

/// The pose of a robot before the first cycle, in the frame of its team. Later, nobody tells it.
fn pose_at_the_start(world: &World, robot: RobotId) -> Option<Pose> {
    let pose = world.get::<Pose>(world.resource::<Roster>().get(robot)?)?;
    let is_start = world.resource::<CycleClock>().cycle == 0;
    is_start.then(|| team_from_pitch(*pose, world.resource::<Game>().own_end(robot.team)))
}

/// Starts programs in the middle of a match: after a restart, or in a match that was loaded.
pub(super) fn start_waiting(world: &mut World) {
    if let Err(ProgramStartError { robot, message }) = launch(world) {
        world.resource_mut::<LostAgents>().0.push((robot, Loss::new(AgentLoss::Refused, message)));
        let mut waiting = world.query_filtered::<Entity, (With<Program>, Without<AgentPlayer>)>();
        let waiting: Vec<Entity> = waiting.iter(world).collect();
        for entity in waiting {
            world.entity_mut(entity).insert(AgentPlayer(None));
        }
    }
}
