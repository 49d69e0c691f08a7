//! Remote robots: their perceptions, and commands for them from outside.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;

use naoisis_core::behaviour::{REMOTE, Remote};
use naoisis_core::communication::Outbox;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::robot::Roster;
use naoisis_core::robot::head::HeadCommand;
use naoisis_core::robot::kick::{KickCommand, KickSettings, UnknownKick};
use naoisis_core::robot::motion::WalkCommand;
use naoisis_core::robot::posture::PostureCommand;
use naoisis_core::robot::request::RequestCommand;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::Belief;
use naoisis_sim::interface::vocabulary::{Perceived, Perception, RobotCommand};
use naoisis_sim::scenario::{BehaviourSpec, FieldPath, Scenario, ScenarioFault, wording};
use naoisis_sim::simulation::{SensorRegistry, give_belief, resolved};
use serde_json::Value;

/// The error that a robot cannot be controlled from outside.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AgentError {
    /// No robot has this id.
    #[error("there is no robot `{0}` in the match")]
    NoSuchRobot(RobotId),
    /// The robot has a behaviour of its own.
    #[error("the robot `{0}` has a behaviour of its own; expected a robot with the behaviour `remote`")]
    NotRemote(RobotId),
    /// The robot has no kick of this name.
    #[error(transparent)]
    UnknownKick(#[from] UnknownKick),
}

naoisis_core::debug_as_displayed!(AgentError);

/// Marks a remote robot that something else plays than the programs of this module, such as a plugin with a protocol of its own.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[require(Remote)]
#[reflect(Component, @Knowledge::Belief)]
pub struct PlayedElsewhere;

/// The robots that something else plays than the programs of this module, sorted by id.
pub fn robots_played_elsewhere(world: &World) -> Vec<RobotId> {
    let is_played = |(id, entity)| world.get::<PlayedElsewhere>(entity).map(|_| id);
    world.resource::<Roster>().iter().filter_map(is_played).collect()
}

/// The robots that are controlled from outside, sorted by id.
pub fn remote_robots(world: &World) -> Vec<RobotId> {
    let is_remote = |(id, entity)| world.get::<Remote>(entity).map(|_| id);
    world.resource::<Roster>().iter().filter_map(is_remote).collect()
}

/// Returns `scenario` with the robots `ids` controlled from outside instead of by their behaviours. Teams become a list
/// of robots. Environments observe no sensor that robots have only for programs, so it is left out where the scenario does not name it.
///
/// # Errors
/// [`ScenarioFault`] if the scenario has no such robot.
pub fn with_remote_robots(world: &World, scenario: &Scenario, ids: &[RobotId]) -> Result<Scenario, ScenarioFault> {
    let mut scenario = resolved(world, scenario);
    for name in world.get_resource::<SensorRegistry>().iter().flat_map(|sensors| sensors.optional_names()) {
        scenario.settings.sensors.0.entry(name.to_owned()).or_insert(Value::Null);
    }
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

/// The perception of any robot: in the current cycle, or, between cycles, in the last one.
///
/// # Errors
/// If there is no such robot.
pub fn perception(world: &mut World, id: RobotId) -> Result<Perception, AgentError> {
    let entity = world.resource::<Roster>().get(id).ok_or(AgentError::NoSuchRobot(id))?;
    let mut robots = world.query::<Perceived>();
    robots.get(world, entity).map(|robot| robot.perception()).map_err(|_| AgentError::NoSuchRobot(id))
}

/// The belief of a robot, if it has one.
///
/// # Errors
/// If there is no such robot.
pub fn belief(world: &World, id: RobotId) -> Result<Option<&Belief>, AgentError> {
    let entity = world.resource::<Roster>().get(id).ok_or(AgentError::NoSuchRobot(id))?;
    Ok(world.get::<Belief>(entity))
}

/// Runs the built-in estimator for a remote robot from now on. Before the first cycle it starts at the true pose.
///
/// # Errors
/// If there is no such robot, or it is not remote.
pub fn believe(world: &mut World, id: RobotId) -> Result<(), AgentError> {
    remote_entity(world, id)?;
    give_belief(world, id);
    Ok(())
}

/// Commands a remote robot: in the current cycle if the robots have already perceived, otherwise in the next one. Parts that `command` does
/// not set keep their state: without `walk` the robot stands, and its head stays in the direction of the last command.
///
/// # Errors
/// If there is no such robot, it is not remote, or it has no kick with the name in `command`.
pub fn command(world: &mut World, id: RobotId, command: RobotCommand) -> Result<(), AgentError> {
    let entity = remote_entity(world, id)?;
    let mut robot = world.get_entity_mut(entity).map_err(|_| AgentError::NoSuchRobot(id))?;
    let mut robot = robot.get_components_mut::<CommandComponents>().map_err(|_| AgentError::NoSuchRobot(id))?;
    Ok(robot.apply(command)?)
}

/// Commands a robot, whatever it is controlled by.
///
/// # Errors
/// If the robot has no kick with the name in `command`, or lacks the components of a robot.
pub(crate) fn give_command(world: &mut World, entity: Entity, command: RobotCommand) -> Result<(), String> {
    let mut robot = world.entity_mut(entity);
    let mut robot = robot.get_components_mut::<CommandComponents>().map_err(|error| error.to_string())?;
    robot.apply(command).map_err(|error| error.to_string())
}

/// Commands for the robots of one world. It finds their components faster than [`command`] does, which looks them up in each call.
pub(crate) struct Commander(QueryState<CommandComponents, With<Remote>>);

impl Commander {
    /// Creates a commander for remote robots of `world`.
    pub fn new(world: &mut World) -> Self {
        Self(world.query_filtered())
    }

    /// Commands a remote robot of the same world, like [`command`]. Does nothing if there is no such robot, or if it has no kick with the name in
    /// `command`.
    pub fn command(&mut self, world: &mut World, id: RobotId, command: RobotCommand) {
        let Some(robot) = world.resource::<Roster>().get(id) else { return };
        if let Ok(mut robot) = self.0.get_mut(world, robot) {
            let _ = robot.apply(command);
        }
    }
}

/// The command components of a robot.
#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct CommandComponents {
    walk: &'static mut WalkCommand,
    head: &'static mut HeadCommand,
    kick: &'static mut KickCommand,
    posture: &'static mut PostureCommand,
    request: &'static mut RequestCommand,
    outbox: &'static mut Outbox,
    kicks: &'static KickSettings,
}

impl CommandComponentsItem<'_, '_> {
    /// Writes all parts of `command`, or none of them.
    ///
    /// # Errors
    /// If the robot has no kick with the name in `command`.
    pub(super) fn apply(&mut self, command: RobotCommand) -> Result<(), UnknownKick> {
        let RobotCommand { walk, head, kick, posture, request, say } = command;
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
        if request.is_some() {
            self.request.0 = request;
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
