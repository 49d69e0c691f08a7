//! Details of events: results of kicks, partners of collisions, refused commands.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::team::RobotId;

/// The result of a kick.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum KickResult {
    /// The ball was struck.
    Kicked,
    /// A side kick from the wrong side: a straight kick at reduced speed.
    Reduced,
    /// The ball was not struck; the reason says why.
    Missed,
}

impl KickResult {
    /// Whether the leg swings in a kick with this result and `reason`: a kick that misses the ball does.
    pub fn swings(self, reason: Option<KickMiss>) -> bool {
        self != KickResult::Missed || reason == Some(KickMiss::OutOfReach)
    }
}

/// The cause of a fall.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FallCause {
    /// A collision with another robot, when the contact begins.
    #[default]
    Collision,
    /// Contact with another robot that lasts.
    Contact,
    /// Walking into a robot that lies on the ground.
    Tripping,
    /// Loss of balance in walking.
    Walking,
    /// Loss of balance in a kick.
    Kick,
    /// A failed attempt to get up.
    GettingUp,
}

/// Why a kick missed.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum KickMiss {
    /// The robot is not upright.
    Down,
    /// The ball's centre was outside the kick's rectangle (paper, Table 2).
    OutOfReach,
    /// The robot was already kicking or recovering.
    Busy,
    /// The robot is penalised.
    Penalised,
    /// Play is stopped.
    PlayStopped,
    /// The speed is NaN.
    NotANumber,
    /// There is no ball.
    NoBall,
    /// The robot has no kick of this name.
    NoSuchKick,
}

impl KickMiss {
    /// Whether the robot itself knows that it may not kick now. It does not know that it kicks past the ball, and a speed that is no number
    /// is a [refused command](super::MatchEvent::CommandRefused) of its own.
    pub fn is_not_allowed(self) -> bool {
        !matches!(self, KickMiss::OutOfReach | KickMiss::NoBall | KickMiss::NotANumber)
    }
}

/// The type of a collision.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum CollisionType {
    /// Two moving robots.
    MovingRobots,
    /// A moving and a static robot.
    MovingAndStaticRobot,
    /// A moving robot and a post.
    RobotAndPost,
    /// A moving robot and a moving ball.
    MovingRobotAndMovingBall,
    /// A moving robot and a static ball.
    MovingRobotAndStaticBall,
    /// A standing robot and a rolling ball.
    StandingRobotAndBall,
    /// The ball and a post or a goal's frame.
    BallAndPost,
}

/// The partner with which a robot or the ball collided.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect)]
#[non_exhaustive]
pub enum CollisionPartner {
    /// Another robot.
    Robot(RobotId),
    /// A goal post, a bar or an extra post.
    Post,
    /// The ball.
    Ball,
}

impl Serialize for CollisionPartner {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            CollisionPartner::Robot(id) => id.serialize(serializer),
            CollisionPartner::Post => serializer.serialize_str("post"),
            CollisionPartner::Ball => serializer.serialize_str("ball"),
        }
    }
}

impl<'de> Deserialize<'de> for CollisionPartner {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let word = String::deserialize(deserializer)?;
        match word.as_str() {
            "post" => Ok(CollisionPartner::Post),
            "ball" => Ok(CollisionPartner::Ball),
            word => word.parse().map(CollisionPartner::Robot).map_err(serde::de::Error::custom),
        }
    }
}

/// The kind of a command.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CommandKind {
    /// [`WalkCommand`](crate::robot::motion::WalkCommand).
    Walk,
    /// [`HeadCommand`](crate::robot::head::HeadCommand).
    Head,
    /// [`KickCommand`](crate::robot::kick::KickCommand).
    Kick,
    /// [`Outbox`](crate::communication::Outbox).
    Say,
    /// [`PostureCommand`](crate::robot::posture::PostureCommand).
    Posture,
    /// [`RequestCommand`](crate::robot::request::RequestCommand).
    Request,
}

/// Why a command was refused.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Refusal {
    /// A number in the command is not finite.
    NotFinite,
    /// A number in the command is beyond [`LARGEST_COMMAND`], or a text in it is too long.
    TooLarge,
    /// The team has spent its budget of messages or bytes. Reported once per team.
    BudgetSpent,
    /// The command is not allowed by the rules, or not now because the robot is busy or penalised.
    NotAllowed,
}

impl Refusal {
    /// Why a command with `numbers`, metres or radians, is refused; `None` if it is valid. Numbers up to [`LARGEST_COMMAND`] are scaled
    /// down to the robot's limits; larger ones are an error of the behaviour.
    pub fn of_numbers<const COUNT: usize>(numbers: [f32; COUNT]) -> Option<Refusal> {
        if numbers.iter().any(|number| !number.is_finite()) {
            Some(Refusal::NotFinite)
        } else if numbers.iter().any(|number| number.abs() > LARGEST_COMMAND) {
            Some(Refusal::TooLarge)
        } else {
            None
        }
    }
}

/// The largest number that a command may have, in metres or radians.
pub const LARGEST_COMMAND: f32 = 1000.0;

/// Why the program of a robot was lost.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum AgentLoss {
    /// The program could not be started, or requested something that does not exist.
    Refused,
    /// The program exited or closed the connection regularly.
    Closed,
    /// The program exited with an error.
    Crashed,
    /// The program did not answer in time.
    TimedOut,
    /// The program sent a malformed message.
    Malformed,
    /// The program sent a message that is too long.
    TooLong,
    /// The program answered for another cycle.
    WrongCycle,
}

/// The line over which the ball left the pitch.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BoundaryLine {
    /// A side line.
    Side,
    /// A goal line, outside the goal.
    Goal,
}

/// Why a goal does not count.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum DisallowedGoal {
    /// The goal was shot straight from the kick-off.
    KickOffShot,
    /// Only one robot of the team had played the ball since the last restart.
    NotIndirect,
    /// The ball went straight from a set play into the goal of the team that took it.
    OwnSetPlay,
    /// The team has exceeded its message budget.
    TooManyMessages,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_refused_and_what_is_absurd_too() {
        assert_eq!(Refusal::of_numbers([0.0, f32::NAN]), Some(Refusal::NotFinite));
        assert_eq!(Refusal::of_numbers([0.0, f32::INFINITY]), Some(Refusal::NotFinite));
        assert_eq!(Refusal::of_numbers([0.0, -1e9]), Some(Refusal::TooLarge));
        assert_eq!(Refusal::of_numbers([0.0, 999.0]), None);
    }
}
