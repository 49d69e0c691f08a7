//! Remote robots: what they perceive, and what is commanded of them from outside.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;

use naoisis_core::behaviour::{REMOTE, Remote};
use naoisis_core::communication::Outbox;
use naoisis_core::robot::Roster;
use naoisis_core::robot::head::HeadCommand;
use naoisis_core::robot::kick::{KickCommand, KickSettings, UnknownKick};
use naoisis_core::robot::motion::WalkCommand;
use naoisis_core::robot::posture::PostureCommand;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::Belief;
use naoisis_sim::interface::vocabulary::{Perceived, Perception, RobotCommand};
use naoisis_sim::scenario::{BehaviourSpec, FieldPath, Scenario, ScenarioFault, wording};
use naoisis_sim::simulation::{give_belief, resolved};

/// A robot that nobody outside may decide for.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AgentError {
    /// There is none of this id.
    #[error("there is no robot `{0}` in the match")]
    NoSuchRobot(RobotId),
    /// It has a behaviour of its own.
    #[error("the robot `{0}` has a behaviour of its own; expected one whose behaviour is `remote`")]
    NotRemote(RobotId),
    /// It has no kick of this name.
    #[error(transparent)]
    UnknownKick(#[from] UnknownKick),
}

/// The robots that are decided for from outside, in the order of their ids.
pub fn remote_robots(world: &World) -> Vec<RobotId> {
    let is_remote = |(id, entity)| world.get::<Remote>(entity).map(|_| id);
    world.resource::<Roster>().iter().filter_map(is_remote).collect()
}

/// The scenario with these of its robots decided for from outside, whatever behaviour they have in it. Teams that are lined
/// up become a list of robots.
///
/// # Errors
/// [`ScenarioFault`] when it has no such robot.
pub fn with_remote_robots(world: &World, scenario: &Scenario, ids: &[RobotId]) -> Result<Scenario, ScenarioFault> {
    let mut scenario = resolved(world, scenario);
    for id in ids {
        match scenario.robots.iter_mut().find(|robot| robot.id() == *id) {
            Some(robot) => robot.behaviour = BehaviourSpec::Named(REMOTE.to_owned()),
            None => {
                let there: Vec<String> = scenario.robots.iter().map(|robot| robot.id().to_string()).collect();
                let message = format!("there is no robot `{id}` in the match");
                let expected = wording::one_of(there.iter().map(String::as_str));
                return Err(ScenarioFault::new(FieldPath::from("robots"), message, expected));
            }
        }
    }
    Ok(scenario)
}

/// What a robot perceives, any robot: in the cycle under way, or in the one that ended last.
///
/// # Errors
/// When there is no such robot.
pub fn perception(world: &mut World, id: RobotId) -> Result<Perception, AgentError> {
    let entity = world.resource::<Roster>().get(id).ok_or(AgentError::NoSuchRobot(id))?;
    let mut robots = world.query::<Perceived>();
    robots.get(world, entity).map(|robot| robot.perception()).map_err(|_| AgentError::NoSuchRobot(id))
}

/// What a robot believes, if it estimates anything.
///
/// # Errors
/// When there is no such robot.
pub fn belief(world: &World, id: RobotId) -> Result<Option<&Belief>, AgentError> {
    let entity = world.resource::<Roster>().get(id).ok_or(AgentError::NoSuchRobot(id))?;
    Ok(world.get::<Belief>(entity))
}

/// Lets the built-in estimator run for a remote robot, from now on. Before the first cycle it knows where it stands.
///
/// # Errors
/// When there is no such robot, or it is not remote.
pub fn believe(world: &mut World, id: RobotId) -> Result<(), AgentError> {
    remote_entity(world, id)?;
    give_belief(world, id);
    Ok(())
}

/// Decides for a remote robot, in the cycle under way if its robots have perceived already, and else in the next one. What
/// the command does not say stays as it is: without a step the robot stands, and its head goes where it was told to go.
///
/// # Errors
/// When there is no such robot, it is not remote, or it has no kick of the name that the command says.
pub fn command(world: &mut World, id: RobotId, command: RobotCommand) -> Result<(), AgentError> {
    let entity = remote_entity(world, id)?;
    let mut robot = world.get_entity_mut(entity).map_err(|_| AgentError::NoSuchRobot(id))?;
    let mut robot = robot.get_components_mut::<ObeyingRobot>().map_err(|_| AgentError::NoSuchRobot(id))?;
    Ok(robot.obey(command)?)
}

/// What is commanded of a robot.
#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct ObeyingRobot {
    walk: &'static mut WalkCommand,
    head: &'static mut HeadCommand,
    kick: &'static mut KickCommand,
    posture: &'static mut PostureCommand,
    outbox: &'static mut Outbox,
    kicks: &'static KickSettings,
}

impl ObeyingRobotItem<'_, '_> {
    /// Commands what the command says, all of it or nothing.
    ///
    /// # Errors
    /// When the robot has no kick of the name that it says.
    pub(super) fn obey(&mut self, command: RobotCommand) -> Result<(), UnknownKick> {
        let RobotCommand { walk, head, kick, posture, say } = command;
        kick.map_or(Ok(()), |kick| self.kicks.check(kick.kick_type))?;
        if let Some(walk) = walk {
            *self.walk = walk;
        }
        if let Some(head) = head {
            *self.head = head;
        }
        if kick.is_some() {
            self.kick.0 = kick;
        }
        if posture.is_some() {
            self.posture.0 = posture;
        }
        if say.is_some() {
            self.outbox.0 = say;
        }
        Ok(())
    }
}

fn remote_entity(world: &World, id: RobotId) -> Result<Entity, AgentError> {
    let entity = world.resource::<Roster>().get(id).ok_or(AgentError::NoSuchRobot(id))?;
    if world.get::<Remote>(entity).is_some() { Ok(entity) } else { Err(AgentError::NotRemote(id)) }
}
