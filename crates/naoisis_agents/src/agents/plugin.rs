//! The plugin that lets programs play. They are asked after the robots have perceived, and before behaviours decide.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;
use std::time::Instant;

use super::loss::Loss;
use super::player::{Agent, AgentPlayer, FAREWELL};
use super::protocol::{Answer, RefusedCommand};
use super::remote::{CommandComponents, PlayedElsewhere};
use super::replayed::{ReplayedCommands, command_robots_without_program};
use super::settings::AgentSettings;
use super::start::{LostAgents, first_silent, greet, start_waiting};

use naoisis_core::behaviour::drawings::Drawings;
use naoisis_core::behaviour::reasons::Reasons;
use naoisis_core::behaviour::remarks::Remarks;
use naoisis_core::behaviour::{AskAhead, DecideSystems, Program};
use naoisis_core::cycle::{Cycle, CycleClock, CyclePanic, CycleSystems, try_perceive};
use naoisis_core::events::{AgentLoss, CommandKind, CycleEvents, MatchEvent, Refusal};
use naoisis_core::game::Game;
use naoisis_core::robot::kick::UnknownKick;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::camera::CameraImages;
use naoisis_sim::interface::vocabulary::Perceived;

/// Lets programs play: starts the programs of robots, and asks them in every cycle.
pub struct AgentsPlugin;

impl Plugin for AgentsPlugin {
    fn build(&self, app: &mut App) {
        let programs_wait = |waiting: Query<(), (With<Program>, Without<AgentPlayer>)>| !waiting.is_empty();
        app.register_type::<PlayedElsewhere>();
        app.insert_resource(AskAhead(ask_ahead))
            .init_resource::<AgentSettings>()
            .init_resource::<LostAgents>()
            .add_systems(
                Cycle,
                (
                    (
                        start_waiting.run_if(programs_wait),
                        greet.run_if(somebody_waits_to_be_greeted),
                        ask.run_if(somebody_plays),
                        receive.run_if(somebody_plays),
                        command_robots_without_program.run_if(resource_exists::<ReplayedCommands>),
                    )
                        .chain()
                        .in_set(DecideSystems::Ask),
                    note_refusals.run_if(somebody_plays).in_set(CycleSystems::Last),
                ),
            );
    }
}

/// Whether a program plays.
fn somebody_plays(players: Query<(), With<AgentPlayer>>) -> bool {
    !players.is_empty()
}

fn somebody_waits_to_be_greeted(players: Query<&AgentPlayer>) -> bool {
    players.iter().any(AgentPlayer::waits_to_be_greeted)
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

/// Asks all programs that were not asked ahead, so that they think at the same time.
fn ask(
    mut commands: Commands,
    clock: Res<CycleClock>,
    settings: Res<AgentSettings>,
    mut lost: ResMut<LostAgents>,
    mut robots: Query<Played>,
) {
    let mut players: Vec<_> = robots.iter_mut().collect();
    players.sort_by_key(|robot| *robot.id);
    for robot in &mut players {
        let Some(agent) = robot.player.0.as_mut().filter(|agent| !agent.is_asked) else { continue };
        if let Err(loss) = agent.ask(&clock, &robot.perceived.perception(), robot.belief, robot.images, &settings) {
            lost.0.push((*robot.id, loss));
            robot.lose(&mut commands);
        }
    }
}

/// Receives the answers of all programs.
fn receive(
    mut commands: Commands,
    clock: Res<CycleClock>,
    mut lost: ResMut<LostAgents>,
    mut events: ResMut<CycleEvents>,
    replayed: Option<Res<ReplayedCommands>>,
    mut robots: Query<Played>,
) {
    let mut players: Vec<_> = robots.iter_mut().collect();
    players.sort_by_key(|robot| *robot.id);
    let mut losses = core::mem::take(&mut lost.0);
    // The program that was asked last is likely to be ready last: when it is, none of the others has to be waited for.
    for robot in players.iter_mut().rev() {
        let Some(agent) = &mut robot.player.0 else { continue };
        let answer = agent.answer(clock.cycle);
        let malformed = |error: UnknownKick| Loss::new(AgentLoss::Malformed, error.to_string());
        let applied = answer.and_then(|mut answer| {
            let own = core::mem::take(&mut answer.command);
            let traced = replayed.as_ref().and_then(|replayed| replayed.0.get(robot.id).cloned());
            let command = traced.unwrap_or_else(|| own.rounded());
            robot.command.apply(command).map(|()| answer).map_err(malformed)
        });
        match applied {
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

/// Begins a cycle in which programs play, as [`AskAhead`] says.
fn ask_ahead(world: &mut World) -> Result<Option<RobotId>, CyclePanic> {
    if world.query_filtered::<(), (With<Program>, Without<AgentPlayer>)>().iter(world).next().is_some() {
        start_waiting(world);
    }
    if world.query_filtered::<(), With<AgentPlayer>>().iter(world).next().is_none() {
        return Ok(None);
    }
    if let Some(robot) = first_silent(world) {
        return Ok(Some(robot));
    }
    greet(world);
    try_perceive(world)?;
    if let Err(error) = world.run_system_cached(ask) {
        error!("programs could not be asked: {error}");
    }
    Ok(first_silent(world))
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
            **reasons = answer.reasons.unwrap_or_default();
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
            MatchEvent::Kick { robot, reason: Some(reason), .. } if robot == id && reason.is_not_allowed() => {
                Some(RefusedCommand { command: CommandKind::Kick, reason: Refusal::NotAllowed })
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
