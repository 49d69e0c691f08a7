//! Whose number it is.

use naoisis_core::team::RobotId;

/// What a number is of.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Subject {
    /// A robot.
    Robot(RobotId),
    /// The ball.
    Ball,
}

impl Subject {
    /// Its name, for people.
    pub fn name(self) -> String {
        match self {
            Subject::Robot(id) => id.to_string(),
            Subject::Ball => "ball".to_owned(),
        }
    }
}
