//! Requests of a robot's team to the referee: a time-out, a pick-up of the robot, or a substitute for it.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::game::Intervention;
use crate::knowledge::Knowledge;
use crate::team::RobotId;

/// A request of a robot's team to the referee, which the rules may refuse.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TeamRequest {
    /// A time-out in the next stoppage of play, for as long as the rules allow.
    Timeout,
    /// The robot is to be picked up.
    PickUp,
    /// The robot is to be replaced by the substitute with this number, as soon as the rules allow it.
    Substitute(u8),
}

impl TeamRequest {
    /// The request as an intervention, for `robot`.
    pub fn intervention(self, robot: RobotId) -> Intervention {
        match self {
            TeamRequest::Timeout => Intervention::Timeout { team: Some(robot.team), duration_s: None },
            TeamRequest::PickUp => Intervention::PickUp { robot },
            TeamRequest::Substitute(number) => Intervention::Substitute { robot, by: RobotId::new(robot.team, number) },
        }
    }
}

/// The request of this cycle, if any. Reset to `None` after every cycle.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct RequestCommand(pub Option<TeamRequest>);
