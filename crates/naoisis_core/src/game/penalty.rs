//! Penalties of robots.

use bevy::prelude::*;
use core::fmt;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error as _, Unexpected};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;

use crate::cycle::CycleClock;
use crate::knowledge::Knowledge;

/// The penalty that a robot serves, if any. A penalised robot cannot act; one that is off the pitch is no obstacle, and is not
/// seen.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct Penalty(pub Option<ActivePenalty>);

impl Penalty {
    /// Whether the robot serves one.
    pub fn is_active(&self) -> bool {
        self.0.is_some()
    }

    /// Whether the robot is off the pitch: not one that serves its penalty where it stood.
    pub fn is_off_pitch(&self) -> bool {
        self.0.is_some_and(|penalty| !penalty.reason.is_in_place())
    }
}

/// A penalty that is being served.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct ActivePenalty {
    /// The offence.
    pub reason: PenaltyReason,
    /// Cycles of play until the robot may come back; of one that does not, those that the halves have left.
    pub cycles_left: u64,
}

impl ActivePenalty {
    /// Whether the robot does not come back in this match.
    pub fn is_for_the_match(&self) -> bool {
        self.reason == PenaltyReason::SentOff
    }

    /// Time of play until the robot may come back, s.
    pub fn left_s(&self, clock: &CycleClock) -> f64 {
        self.cycles_left as f64 * clock.period_s
    }
}

/// What a robot can be penalised for.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default, Reflect)]
#[reflect(Serialize, Deserialize)]
pub enum PenaltyReason {
    /// It is responsible for a collision with another robot.
    Pushing,
    /// It stood near the ball for too long.
    Stalling,
    /// It covered the ball for too long.
    BallHolding,
    /// It left the carpet, or stayed in a goal.
    LeavingField,
    /// It was in front of its own goal where it may not be.
    IllegalDefender,
    /// It was at an illegal place at a kick-off or free kick.
    IllegalPosition,
    /// It kept an opponent from the ball without going to it.
    Obstruction,
    /// It did nothing for too long.
    Inactive,
    /// It lay on the ground for too long.
    Fallen,
    /// It takes no part in this shot of the shoot-out.
    ShootOut,
    /// Play was stuck, and it was the nearest to the ball.
    GameStuck,
    /// It began to walk in `set`.
    MotionInSet,
    /// Somebody of its team began to walk in `standby`.
    MotionInStandby,
    /// It was cautioned too often, and plays no more in this match.
    SentOff,
    /// Whoever runs the match removed it.
    #[default]
    Manual,
    /// It broke a rule of the program's own.
    Own(RuleName),
}

impl PenaltyReason {
    /// All but those of a program's own.
    pub const BUILT_IN: [PenaltyReason; 15] = [
        PenaltyReason::Pushing,
        PenaltyReason::Stalling,
        PenaltyReason::BallHolding,
        PenaltyReason::LeavingField,
        PenaltyReason::IllegalDefender,
        PenaltyReason::IllegalPosition,
        PenaltyReason::Obstruction,
        PenaltyReason::Inactive,
        PenaltyReason::Fallen,
        PenaltyReason::ShootOut,
        PenaltyReason::GameStuck,
        PenaltyReason::MotionInSet,
        PenaltyReason::MotionInStandby,
        PenaltyReason::SentOff,
        PenaltyReason::Manual,
    ];

    /// The reason as files spell it.
    pub fn name(&self) -> &str {
        match self {
            PenaltyReason::Pushing => "pushing",
            PenaltyReason::Stalling => "stalling",
            PenaltyReason::BallHolding => "ball_holding",
            PenaltyReason::LeavingField => "leaving_field",
            PenaltyReason::IllegalDefender => "illegal_defender",
            PenaltyReason::IllegalPosition => "illegal_position",
            PenaltyReason::Obstruction => "obstruction",
            PenaltyReason::Inactive => "inactive",
            PenaltyReason::Fallen => "fallen",
            PenaltyReason::ShootOut => "shoot_out",
            PenaltyReason::GameStuck => "game_stuck",
            PenaltyReason::MotionInSet => "motion_in_set",
            PenaltyReason::MotionInStandby => "motion_in_standby",
            PenaltyReason::SentOff => "sent_off",
            PenaltyReason::Manual => "manual",
            PenaltyReason::Own(rule) => rule.as_str(),
        }
    }

    /// Whether it makes the team's later penalties longer (2025 rule book, section 4.2).
    pub fn is_infraction(self) -> bool {
        match self {
            PenaltyReason::Pushing
            | PenaltyReason::Stalling
            | PenaltyReason::BallHolding
            | PenaltyReason::LeavingField
            | PenaltyReason::IllegalDefender
            | PenaltyReason::IllegalPosition
            | PenaltyReason::Obstruction
            | PenaltyReason::Manual
            | PenaltyReason::Own(_) => true,
            PenaltyReason::Inactive
            | PenaltyReason::Fallen
            | PenaltyReason::ShootOut
            | PenaltyReason::GameStuck
            | PenaltyReason::MotionInSet
            | PenaltyReason::MotionInStandby
            | PenaltyReason::SentOff => false,
        }
    }

    /// Whether a robot serves the penalty where it stands, rather than off the pitch (2025 rule book, section 4.5).
    pub fn is_in_place(self) -> bool {
        matches!(self, PenaltyReason::MotionInSet | PenaltyReason::MotionInStandby)
    }

    /// The reason in words, as after "penalised for".
    pub fn words(self) -> Cow<'static, str> {
        Cow::Borrowed(match self {
            PenaltyReason::Own(rule) => return Cow::Owned(rule.as_str().replace('_', " ")),
            PenaltyReason::Pushing => "pushing",
            PenaltyReason::Stalling => "stalling",
            PenaltyReason::BallHolding => "ball holding",
            PenaltyReason::LeavingField => "leaving the field",
            PenaltyReason::IllegalDefender => "illegal defending",
            PenaltyReason::IllegalPosition => "an illegal position",
            PenaltyReason::Obstruction => "obstruction",
            PenaltyReason::Inactive => "inactivity",
            PenaltyReason::Fallen => "lying on the ground",
            PenaltyReason::ShootOut => "the shoot-out",
            PenaltyReason::GameStuck => "a stuck game",
            PenaltyReason::MotionInSet => "motion in set",
            PenaltyReason::MotionInStandby => "its team's motion in standby",
            PenaltyReason::SentOff => "being cautioned too often",
            PenaltyReason::Manual => "a reason of its own",
        })
    }
}

impl Serialize for PenaltyReason {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for PenaltyReason {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let word = String::deserialize(deserializer)?;
        let built_in = PenaltyReason::BUILT_IN.into_iter().find(|reason| reason.name() == word);
        built_in.or_else(|| RuleName::new(&word).map(PenaltyReason::Own)).ok_or_else(|| {
            let names: Vec<String> =
                PenaltyReason::BUILT_IN.iter().map(|reason| format!("`{}`", reason.name())).collect();
            let expected = format!("one of {}, or the name of a rule of the program's own", names.join(", "));
            D::Error::invalid_value(Unexpected::Str(&word), &expected.as_str())
        })
    }
}

impl JsonSchema for PenaltyReason {
    fn schema_name() -> Cow<'static, str> {
        "PenaltyReason".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let names: Vec<&str> = PenaltyReason::BUILT_IN.iter().map(PenaltyReason::name).collect();
        json_schema!({
            "description": "What a robot is penalised for, or the name of a rule of the program's own.",
            "anyOf": [{ "enum": names }, { "type": "string", "pattern": "^[a-z0-9_]{1,32}$" }]
        })
    }
}

/// The name of a rule of the program's own: lower-case letters, digits and underscores, as files spell it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Reflect)]
#[reflect(opaque)]
#[reflect(Clone, PartialEq, Debug, Hash, Serialize, Deserialize)]
pub struct RuleName {
    /// The name, and zeros after it.
    bytes: [u8; RuleName::LONGEST],
}

impl RuleName {
    /// The longest name, bytes.
    pub const LONGEST: usize = 32;

    /// This word as a name; none if it is no such word.
    pub fn new(word: &str) -> Option<Self> {
        let is_name = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_';
        let mut bytes = [0; Self::LONGEST];
        bytes
            .get_mut(..word.len())
            .filter(|_| !word.is_empty() && word.bytes().all(is_name))?
            .copy_from_slice(word.as_bytes());
        Some(Self { bytes })
    }

    /// The name, as in scenarios and traces.
    pub fn as_str(&self) -> &str {
        let length = self.bytes.iter().position(|byte| *byte == 0).unwrap_or(Self::LONGEST);
        str::from_utf8(&self.bytes[..length]).unwrap_or_default()
    }
}

impl fmt::Debug for RuleName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), formatter)
    }
}

impl fmt::Display for RuleName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.as_str())
    }
}

impl Serialize for RuleName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl<'de> Deserialize<'de> for RuleName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let word = String::deserialize(deserializer)?;
        let expected = "a word of at most 32 lower-case letters, digits and underscores";
        RuleName::new(&word).ok_or_else(|| D::Error::invalid_value(Unexpected::Str(&word), &expected))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_reads_as_it_is_written() {
        let own = PenaltyReason::Own(RuleName::new("time_wasting").unwrap());
        for reason in PenaltyReason::BUILT_IN.into_iter().chain([own]) {
            let text = serde_json::to_string(&reason).unwrap();
            assert_eq!(text, format!("\"{}\"", reason.name()));
            assert_eq!(serde_json::from_str::<PenaltyReason>(&text).unwrap(), reason);
        }
        assert_eq!(own.words(), "time wasting");
        for wrong in ["", "Time", "time wasting", "a_name_of_more_than_thirty_two_letters"] {
            assert_eq!(RuleName::new(wrong), None);
            assert!(serde_json::from_value::<PenaltyReason>(wrong.into()).is_err());
        }
        assert_eq!(RuleName::new(&"x".repeat(32)).unwrap().as_str().len(), 32);
    }
}
