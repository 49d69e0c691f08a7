//! The subject of a number: a robot or the ball.

use naoisis_core::team::RobotId;

/// The subject of a number.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Subject {
    /// A robot.
    Robot(RobotId),
    /// The ball.
    Ball,
}

impl Subject {
    /// Returns the name in the window.
    pub fn name(self) -> String {
        match self {
            Subject::Robot(id) => id.to_string(),
            Subject::Ball => "ball".to_owned(),
        }
    }
}
