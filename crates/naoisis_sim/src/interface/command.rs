//! Reads and checks commands from outside, whatever their source.

use serde::de::DeserializeOwned;
use serde_json::Value;

use super::trace_numbers::shortest_json;
use super::vocabulary::RobotCommand;
use crate::scenario::{FieldPath, read_settings};
use naoisis_core::communication::MOST_ROBOTS;

/// What is wrong with a command.
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CommandError {
    /// The text is not JSON.
    #[error("{0}; expected a JSON object")]
    NotJson(String),
    /// The command has an unknown field, or a value of the wrong form.
    #[error("{message}; expected {expected}")]
    Malformed {
        /// Path of the field in the command, such as `walk` or `say.ball_m`.
        field: String,
        /// What is wrong.
        message: String,
        /// What was expected.
        expected: String,
    },
    /// A number in this part is not finite in single precision.
    #[error("`{0}` has a number that is not finite; expected finite numbers, of single precision (at most 3.4e38)")]
    NotFinite(&'static str),
    /// The message reports more robots than there can be.
    #[error("`say.robots_m` has {0} places; expected at most {MOST_ROBOTS}")]
    TooManyRobots(usize),
    /// The chosen option is none of those that are given.
    #[error("`reasons.chosen` is {chosen}, of {options} options; expected the index of one of them, from 0")]
    NoSuchOption {
        /// The index.
        chosen: usize,
        /// The number of options.
        options: usize,
    },
    /// A variance in this part is negative.
    #[error("`{0}` has a negative variance; expected covariances, such as xx, xy, yy of a position")]
    NegativeVariance(&'static str),
}

naoisis_core::debug_as_displayed!(CommandError);

impl RobotCommand {
    /// Reads a command in the form of a trace.
    ///
    /// # Errors
    /// The first fault of the command.
    pub fn from_json(text: &[u8]) -> Result<Self, CommandError> {
        // Read a JSON value first: serde alone would accept a list for an object.
        let value = serde_json::from_slice::<Value>(text).map_err(|error| CommandError::NotJson(error.to_string()))?;
        Self::from_value(&value)
    }

    /// Reads a command from a JSON value.
    ///
    /// # Errors
    /// The first fault of the command.
    pub fn from_value(value: &Value) -> Result<Self, CommandError> {
        read_value::<Self>(value).and_then(Self::checked)
    }

    /// Returns the command, after checking that all its numbers are finite and that its message does not report too many robots.
    ///
    /// # Errors
    /// The part that is wrong.
    pub fn checked(self) -> Result<Self, CommandError> {
        let Self { walk, head, kick, posture: _, request: _, say } = &self;
        let parts = [
            ("walk", walk.is_none_or(|walk| [walk.dx, walk.dy, walk.dtheta].iter().all(|part| part.is_finite()))),
            ("head_deg", head.is_none_or(|head| head.yaw.is_finite() && head.pitch.is_finite())),
            ("kick", kick.is_none_or(|kick| kick.speed.is_finite())),
            ("say", say.as_ref().is_none_or(|say| say.is_finite())),
        ];
        match parts.into_iter().find(|(_, is_finite)| !is_finite) {
            Some((part, _)) => Err(CommandError::NotFinite(part)),
            None => match say.as_ref().map_or(0, |say| say.robots_m.len()) {
                0..=MOST_ROBOTS => Ok(self),
                robots => Err(CommandError::TooManyRobots(robots)),
            },
        }
    }

    /// Returns the command with its numbers as a trace has them. With such commands a match can be played again from its trace.
    #[must_use]
    pub fn rounded(self) -> Self {
        let text = shortest_json(&self).unwrap_or_default();
        Self::from_json(text.as_bytes()).unwrap_or(self)
    }
}

/// Reads a message, or a part of one, from a JSON value.
///
/// # Errors
/// The first fault of the value.
pub fn read_value<T: DeserializeOwned>(value: &Value) -> Result<T, CommandError> {
    read_settings(value, &FieldPath::default()).map_err(|fault| CommandError::Malformed {
        field: fault.path.to_string(),
        message: fault.message,
        expected: fault.expected,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn error(text: &str) -> CommandError {
        RobotCommand::from_json(text.as_bytes()).unwrap_err()
    }

    #[test]
    fn what_is_wrong_with_a_command_is_said_with_its_place() {
        assert_eq!(RobotCommand::from_json(b"{}"), Ok(RobotCommand::default()));
        let misspelt = error(r#"{ "wlak": [0, 0, 0] }"#).to_string();
        assert!(misspelt.contains("there is no field `wlak`: did you mean `walk`?"), "{misspelt}");
        let CommandError::Malformed { field, expected, .. } = error(r#"{ "say": { "ball_m": "here" } }"#) else {
            panic!("no wrong field")
        };
        assert_eq!((field.as_str(), expected.as_str()), ("say.ball_m", "a list of two numbers, [x m, y m]"));
        assert!(matches!(error(r#"{ "walk": [0.0, 0.0] }"#), CommandError::Malformed { .. }));
        assert!(matches!(error("hello"), CommandError::NotJson(_)));
        assert!(matches!(error("[]"), CommandError::Malformed { .. }));
        assert!(matches!(error(r#"{ "walk": [NaN, 0, 0] }"#), CommandError::NotJson(_)));
        assert!(error(r#"{ "head_deg": [1e300, 0] }"#).to_string().contains("of single precision"));
        let infinite = RobotCommand::from_json(br#"{ "head_deg": [1, 0] }"#).map(|mut command| {
            command.head.iter_mut().for_each(|head| head.yaw = f32::INFINITY);
            command
        });
        assert_eq!(infinite.and_then(RobotCommand::checked), Err(CommandError::NotFinite("head_deg")));
        let told = |robots: usize| format!(r#"{{ "say": {{ "robots_m": [{}] }} }}"#, vec!["[1,2]"; robots].join(","));
        let checked = |robots: usize| RobotCommand::from_json(told(robots).as_bytes()).and_then(RobotCommand::checked);
        assert!(checked(MOST_ROBOTS).is_ok());
        assert_eq!(checked(MOST_ROBOTS + 1), Err(CommandError::TooManyRobots(MOST_ROBOTS + 1)));
    }

    proptest! {
        #[test]
        fn a_rounded_command_is_read_back_from_a_trace_to_the_last_bit(
            [dx, dy, turn, yaw, pitch, speed] in proptest::array::uniform6(-1.0_f32..1.0),
            scale in proptest::sample::select(vec![1e-6_f32, 1e-4, 1e-2, 1.0, 100.0]),
        ) {
            let scaled = |number: f32| number * scale;
            let command = serde_json::json!({
                "walk": [scaled(dx), scaled(dy), scaled(turn)], "head_deg": [90.0 * yaw, 45.0 * pitch],
                "kick": { "type": "left_straight", "speed": speed.abs() },
                "say": { "pose": [scaled(dx), scaled(dy), 180.0 * yaw], "ball_m": [scaled(yaw), scaled(pitch)] },
            });
            let command = RobotCommand::from_value(&command).unwrap();
            let rounded = command.clone().rounded();
            prop_assert_eq!(&RobotCommand::from_json(shortest_json(&rounded).unwrap().as_bytes()).unwrap(), &rounded);
            let [given, kept] = [command, rounded].map(|command| command.walk.unwrap());
            prop_assert!((given.dx - kept.dx).abs() <= 0.6e-5_f32.max(1e-5 * given.dx.abs()));
        }
    }
}
