//! The plugin that lets programs play. They are asked after the robots have perceived, and before behaviours decide.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;
use std::time::Instant;

use super::connection::Connection;
use super::loss::Loss;
use super::player::{Agent, AgentPlayer, FAREWELL};
use super::process::Process;
use super::protocol::{Answer, Hello, RefusedCommand};
use super::remote::{CommandComponents, PlayedElsewhere, believe};
use super::settings::{AgentSettings, LeagueNumbers};

use naoisis_core::behaviour::drawings::Drawings;
use naoisis_core::behaviour::reasons::Reasons;
use naoisis_core::behaviour::remarks::Remarks;
use naoisis_core::behaviour::{DecideSystems, Program};
use naoisis_core::cycle::{Cycle, CycleClock, CycleSystems};
use naoisis_core::events::{AgentLoss, CycleEvents, MatchEvent};
use naoisis_core::game::Game;
use naoisis_core::geometry::Pose;
use naoisis_core::robot::Roster;
use naoisis_core::robot::kick::UnknownKick;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::{Belief, SimpleBelief, team_from_pitch};
use naoisis_sensing::sensing::camera::{CameraImages, CameraRendering, CameraSettings};
use naoisis_sim::interface::vocabulary::Perceived;
use naoisis_sim::scenario::Scenario;

/// Lets programs play: starts the programs of robots, and asks them in every cycle.
pub struct AgentsPlugin;

impl Plugin for AgentsPlugin {
    fn build(&self, app: &mut App) {
        let programs_wait = |waiting: Query<(), (With<Program>, Without<AgentPlayer>)>| !waiting.is_empty();
        app.register_type::<PlayedElsewhere>();
        app.init_resource::<AgentSettings>().init_resource::<LostAgents>().add_systems(
            Cycle,
            (
                (start_waiting.run_if(programs_wait), ask.run_if(somebody_plays)).chain().in_set(DecideSystems::Ask),
                note_refusals.run_if(somebody_plays).in_set(CycleSystems::Last),
            ),
        );
    }
}

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
        agents.push((entity, robot, Agent::new(connection, Some(process))));
    }
    // All programs are started before any is waited for, so that they load at the same time.
    let deadline = settings.start_timeout.map(|time| Instant::now() + time);
    for (entity, robot, mut agent) in agents {
        let begun = agent.hello(deadline).and_then(|hello| begin(world, robot, &mut agent, &hello, deadline));
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
    Ok(())
}

/// Lets a program that has said hello play a robot.
pub(super) fn begin(
    world: &mut World,
    robot: RobotId,
    agent: &mut Agent,
    hello: &Hello,
    deadline: Option<Instant>,
) -> Result<(), Loss> {
    let entity = world.resource::<Roster>().get(robot);
    let pose = pose_at_the_start(world, robot);
    if hello.belief && pose.is_none() && entity.is_none_or(|entity| world.get::<SimpleBelief>(entity).is_none()) {
        // An estimator that begins now would begin at the true pose.
        let message = "it asks for beliefs in the middle of a match, and no estimator has run for its robot; expected a hello without \
                       `belief`, or one before the match begins";
        return Err(agent.refuse(message.to_owned(), deadline));
    }
    let scenario = world.resource::<Scenario>();
    agent.welcome(
        hello,
        (robot, pose),
        scenario,
        scenario.settings.cameras.render != CameraRendering::Off,
        deadline,
    )?;
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
fn start_waiting(world: &mut World) {
    if let Err(ProgramStartError { robot, message }) = start_programs(world) {
        world.resource_mut::<LostAgents>().0.push((robot, Loss::new(AgentLoss::Refused, message)));
        let mut waiting = world.query_filtered::<Entity, (With<Program>, Without<AgentPlayer>)>();
        let waiting: Vec<Entity> = waiting.iter(world).collect();
        for entity in waiting {
            world.entity_mut(entity).insert(AgentPlayer(None));
        }
    }
}

/// Whether a program plays.
fn somebody_plays(players: Query<(), With<AgentPlayer>>) -> bool {
    !players.is_empty()
}

/// A robot that a program plays.
#[derive(QueryData)]
#[query_data(mutable)]
struct Played {
    entity: Entity,
    id: &'static RobotId,
    player: &'static mut AgentPlayer,
    perceived: Perceived,
    belief: Option<&'static Belief>,
    images: Option<&'static CameraImages>,
    remarks: Option<&'static Remarks>,
    reasons: Option<&'static mut Reasons>,
    drawings: Option<&'static mut Drawings>,
    command: CommandComponents,
}

fn ask(
    mut commands: Commands,
    clock: Res<CycleClock>,
    settings: Res<AgentSettings>,
    mut lost: ResMut<LostAgents>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<Played>,
) {
    let mut players: Vec<_> = robots.iter_mut().collect();
    players.sort_by_key(|robot| *robot.id);
    let mut losses = core::mem::take(&mut lost.0);
    // All programs are asked first, so that they think at the same time.
    for robot in &mut players {
        let Some(agent) = &mut robot.player.0 else { continue };
        if let Err(loss) = agent.ask(&clock, &robot.perceived.perception(), robot.belief, robot.images, &settings) {
            losses.push((*robot.id, loss));
            robot.lose(&mut commands);
        }
    }
    // The program that was asked last is likely to be ready last: when it is, none of the others has to be waited for.
    for robot in players.iter_mut().rev() {
        let Some(agent) = &mut robot.player.0 else { continue };
        let answer = agent.answer(clock.cycle);
        let malformed = |error: UnknownKick| Loss::new(AgentLoss::Malformed, error.to_string());
        let obeyed = answer.and_then(|mut answer| {
            robot.command.apply(core::mem::take(&mut answer.command)).map(|()| answer).map_err(malformed)
        });
        match obeyed {
            Ok(answer) => robot.note(answer, &mut commands),
            Err(loss) => {
                losses.push((*robot.id, loss));
                robot.lose(&mut commands);
            }
        }
    }
    losses.sort_by_key(|(robot, _)| *robot);
    let event = |(robot, Loss { reason, message })| MatchEvent::AgentLost { robot, reason, message };
    events.extend(losses.into_iter().map(event));
}

impl PlayedItem<'_, '_> {
    /// Stores what the answer says beside the command.
    fn note(&mut self, mut answer: Answer, commands: &mut Commands) {
        let has_estimator = self.player.0.as_ref().is_some_and(Agent::wants_belief);
        let remarks = answer.take_remarks();
        if self.remarks.map_or(!remarks.is_empty(), |before| *before != remarks) {
            commands.entity(self.entity).insert(remarks);
        }
        match answer.belief {
            Some(belief) => _ = commands.entity(self.entity).insert(belief),
            // A belief holds for the cycle in which it is told.
            None if self.belief.is_some() && !has_estimator => _ = commands.entity(self.entity).remove::<Belief>(),
            None => {}
        }
        if let Some(reasons) = &mut self.reasons {
            let Reasons { options, chosen } = answer.reasons.unwrap_or_default();
            **reasons = Reasons { chosen: chosen.filter(|chosen| *chosen < options.len()), options };
        }
        if let Some(drawings) = &mut self.drawings {
            answer.drawings.into_iter().for_each(|drawing| drawings.add(drawing));
        }
    }

    /// Removes a program that is lost, and what it has told last.
    fn lose(&mut self, commands: &mut Commands) {
        if self.player.0.take().is_some_and(|agent| !agent.wants_belief()) {
            commands.entity(self.entity).remove::<Belief>();
        }
        commands.entity(self.entity).remove::<Remarks>();
        if let Some(reasons) = &mut self.reasons {
            **reasons = Reasons::default();
        }
    }
}

/// Keeps the commands of each program that were refused in this cycle, to tell the program.
fn note_refusals(events: Res<CycleEvents>, mut players: Query<(&RobotId, &mut AgentPlayer)>) {
    for (id, mut player) in &mut players {
        // Unchanged for change detection: nobody looks at it here.
        let Some(agent) = &mut player.bypass_change_detection().0 else { continue };
        agent.refused.clear();
        agent.refused.extend(events.iter().filter_map(|event| match event {
            MatchEvent::CommandRefused { robot, command, reason } if robot == id => {
                Some(RefusedCommand { command: *command, reason: *reason })
            }
            _ => None,
        }));
    }
}

/// Tells all programs that the match is over, with `reason`, and waits for them to end. Returns the robots whose
/// programs had to be killed.
pub fn dismiss(world: &mut World, reason: &str) -> Vec<RobotId> {
    let Some(score) = world.get_resource::<Game>().map(|game| game.score) else { return Vec::new() };
    let mut players = world.query::<(&RobotId, &mut AgentPlayer)>();
    let taken = players.iter_mut(world).filter_map(|(id, mut player)| player.0.take().map(|agent| (*id, agent)));
    let mut agents: Vec<(RobotId, Agent)> = taken.collect();
    agents.sort_by_key(|(id, _)| *id);
    for (_, agent) in &mut agents {
        agent.say_goodbye(reason, score);
    }
    // All programs end at the same time.
    let deadline = Instant::now() + FAREWELL;
    agents.into_iter().filter_map(|(id, agent)| (!agent.wait_for_end(deadline)).then_some(id)).collect()
}
