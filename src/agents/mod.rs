//! Robots that somebody outside the match decides for: a loop, a program, a policy.
//!
//! Such a robot has the behaviour `"remote"`. In each cycle, whoever plays it gets a [`Perception`], which is a trace's robot
//! without what it cannot know, and gives a [`RobotCommand`], which is a trace's `"command"`. A loop of one's own stops each
//! cycle between its halves, and so plays in lock-step:
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::agents::{self, RobotCommand};
//! use naoisis::cycle::perceive;
//! use naoisis::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins(NaoisisPlugins);
//! app.start_match(&Scenario::from_json(
//!     r#"{ "rules": "free", "ball": { "position_m": [1.0, 0.2] },
//!          "robots": [{ "team": "blue", "number": 1, "behaviour": "remote" }] }"#,
//! )?)?;
//! let robot = agents::remote_robots(app.world())[0];
//! for _ in 0..30 {
//!     perceive(app.world_mut());
//!     let perception = agents::perception(app.world_mut(), robot)?;
//!     let ball = perception.percepts.ball.map(|ball| ball.position_m);
//!     let turn_deg = ball.map_or(0.0, |ball| ball.y.signum());
//!     let command = RobotCommand::from_json(format!(r#"{{ "walk": [0.006, 0.0, {turn_deg}] }}"#).as_bytes())?;
//!     agents::command(app.world_mut(), robot, command)?;
//!     run_cycle(app.world_mut());
//! }
//! assert!(app.robot_pose(robot).unwrap().position.x > 0.15);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

use bevy::prelude::*;

mod command;

pub use crate::record::vocabulary::{Perception, RobotCommand};
pub use command::CommandError;

use crate::behaviour::{REMOTE, Remote};
use crate::belief::Belief;
use crate::communication::Outbox;
use crate::record::vocabulary::Perceived;
use crate::robot::Roster;
use crate::robot::head::HeadCommand;
use crate::robot::kick::KickCommand;
use crate::robot::motion::WalkCommand;
use crate::robot::posture::PostureCommand;
use crate::scenario::{BehaviourSpec, FieldPath, Scenario, ScenarioFault, wording};
use crate::simulation::{give_belief, resolved};
use crate::team::RobotId;

/// A robot that nobody outside may decide for.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AgentError {
    /// There is none of this id.
    #[error("there is no robot `{0}` in the match")]
    NoSuchRobot(RobotId),
    /// It has a behaviour of its own.
    #[error("the robot `{0}` has a behaviour of its own; expected one whose behaviour is `remote`")]
    NotRemote(RobotId),
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
/// When there is no such robot, or it is not remote.
pub fn command(world: &mut World, id: RobotId, command: RobotCommand) -> Result<(), AgentError> {
    let entity = remote_entity(world, id)?;
    let RobotCommand { walk, head, kick, posture, say } = command;
    let mut robot = world.entity_mut(entity);
    if let (Some(walk), Some(mut of_robot)) = (walk, robot.get_mut::<WalkCommand>()) {
        *of_robot = walk;
    }
    if let (Some(head), Some(mut of_robot)) = (head, robot.get_mut::<HeadCommand>()) {
        *of_robot = head;
    }
    if let (Some(kick), Some(mut of_robot)) = (kick, robot.get_mut::<KickCommand>()) {
        of_robot.0 = Some(kick);
    }
    if let (Some(posture), Some(mut of_robot)) = (posture, robot.get_mut::<PostureCommand>()) {
        of_robot.0 = Some(posture);
    }
    if let (Some(say), Some(mut outbox)) = (say, robot.get_mut::<Outbox>()) {
        outbox.0 = Some(say);
    }
    Ok(())
}

fn remote_entity(world: &World, id: RobotId) -> Result<Entity, AgentError> {
    let entity = world.resource::<Roster>().get(id).ok_or(AgentError::NoSuchRobot(id))?;
    if world.get::<Remote>(entity).is_some() { Ok(entity) } else { Err(AgentError::NotRemote(id)) }
}
