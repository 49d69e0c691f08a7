//! Penalties of robots.

use bevy::prelude::*;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error as _, Unexpected};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use strum::{EnumIter, IntoEnumIterator, IntoStaticStr};

use crate::cycle::CycleClock;
use crate::knowledge::Knowledge;
use crate::short_name::short_name;

/// The penalty that a robot serves, if any. A penalised robot cannot act. A robot off the pitch is neither an obstacle nor visible.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct Penalty(pub Option<ActivePenalty>);

impl Penalty {
    /// The penalty of a substitute, until it enters the pitch.
    pub const SUBSTITUTE: Penalty = Penalty(Some(ActivePenalty { reason: PenaltyReason::Substitute, cycles_left: 0 }));

    /// Whether the robot serves a penalty.
    pub fn is_active(&self) -> bool {
        self.0.is_some()
    }

    /// Whether the robot is off the pitch, rather than serving its penalty [in place](PenaltyReason::is_in_place).
    pub fn is_off_pitch(&self) -> bool {
        self.0.is_some_and(|penalty| !penalty.reason.is_in_place())
    }
}

/// A penalty that is being served.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct ActivePenalty {
    /// The offence.
    pub reason: PenaltyReason,
    /// Cycles of play until the robot may return, or until the end of the match if it may not; 0 for substitutes.
    pub cycles_left: u64,
}

impl ActivePenalty {
    /// Whether the penalty ends at no given time: the robot is out for the rest of the match, or until it enters as a substitute.
    pub fn is_for_the_match(&self) -> bool {
        matches!(self.reason, PenaltyReason::SentOff | PenaltyReason::Substitute)
    }

    /// Time of play until the robot may return, s.
    pub fn left_s(&self, clock: &CycleClock) -> f64 {
        self.cycles_left as f64 * clock.period_s
    }
}

/// The offence that a robot is penalised for.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default, Reflect, IntoStaticStr, EnumIter)]
#[reflect(Serialize, Deserialize)]
#[strum(serialize_all = "snake_case")]
pub enum PenaltyReason {
    /// The robot is responsible for a collision with another robot.
    Pushing,
    /// The robot stood near the ball for too long.
    Stalling,
    /// The robot covered the ball for too long.
    BallHolding,
    /// The robot left the carpet, or stayed in a goal.
    LeavingField,
    /// The robot defended in front of its own goal where the rules forbid it.
    IllegalDefender,
    /// The robot was at an illegal position at a kick-off or free kick.
    IllegalPosition,
    /// The robot kept an opponent from the ball without going to the ball itself.
    Obstruction,
    /// The robot did nothing for too long.
    Inactive,
    /// The robot lay on the ground for too long.
    Fallen,
    /// The robot takes no part in the current shot of the shoot-out.
    ShootOut,
    /// Play was stuck, and the robot was nearest to the ball.
    GameStuck,
    /// The robot began to walk in `set`.
    MotionInSet,
    /// The robot moved in a brief stop.
    MotionInStop,
    /// A robot of the same team began to walk in `standby`.
    MotionInStandby,
    /// The team asked for the robot to be picked up.
    PickUp,
    /// The robot was cautioned too often, and is out for the rest of the match.
    SentOff,
    /// The robot is a substitute, or was replaced by one.
    Substitute,
    /// The robot was removed by an [intervention](crate::game::Intervention::Penalise).
    #[default]
    Manual,
    /// The robot broke a [custom rule](crate::referee::CustomRule).
    #[strum(disabled)]
    Custom(RuleName),
}

impl PenaltyReason {
    /// All reasons but [`Custom`](Self::Custom) ones.
    pub fn built_in() -> impl Iterator<Item = PenaltyReason> + Clone {
        PenaltyReason::iter()
    }

    /// The names of the [built-in](Self::built_in) reasons, as files spell them.
    pub fn built_in_names<'a>() -> impl Iterator<Item = &'a str> + Clone {
        PenaltyReason::iter().map(|reason| -> &'a str { <&'static str>::from(reason) })
    }

    /// The name of the reason in files.
    pub fn name(&self) -> &str {
        match self {
            PenaltyReason::Custom(rule) => rule.as_str(),
            built_in => built_in.into(),
        }
    }

    /// Whether the penalty makes later penalties of the team longer (2025 rule book, section 4.2).
    pub fn is_infraction(self) -> bool {
        !matches!(
            self,
            PenaltyReason::Inactive
                | PenaltyReason::Fallen
                | PenaltyReason::ShootOut
                | PenaltyReason::GameStuck
                | PenaltyReason::MotionInSet
                | PenaltyReason::MotionInStandby
                | PenaltyReason::SentOff
                | PenaltyReason::Substitute
        )
    }

    /// Whether a robot serves the penalty where it stands, rather than off the pitch (2025 rule book, section 4.5).
    pub fn is_in_place(self) -> bool {
        matches!(self, PenaltyReason::MotionInSet | PenaltyReason::MotionInStandby)
    }

    /// The reason in words, as after "penalised for".
    pub fn words(self) -> Cow<'static, str> {
        Cow::Borrowed(match self {
            PenaltyReason::LeavingField => "leaving the field",
            PenaltyReason::IllegalDefender => "illegal defending",
            PenaltyReason::IllegalPosition => "an illegal position",
            PenaltyReason::Inactive => "inactivity",
            PenaltyReason::Fallen => "lying on the ground",
            PenaltyReason::ShootOut => "the shoot-out",
            PenaltyReason::GameStuck => "a stuck game",
            PenaltyReason::MotionInStandby => "its team's motion in standby",
            PenaltyReason::PickUp => "a request for pick-up",
            PenaltyReason::SentOff => "being cautioned too often",
            PenaltyReason::Substitute => "being a substitute",
            PenaltyReason::Manual => "a decision by hand",
            named => return Cow::Owned(named.name().replace('_', " ")),
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
        let built_in = PenaltyReason::built_in().find(|reason| reason.name() == word);
        built_in.or_else(|| word.parse().ok().map(PenaltyReason::Custom)).ok_or_else(|| {
            let names: Vec<String> = PenaltyReason::built_in_names().map(|name| format!("`{name}`")).collect();
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
        let names: Vec<&str> = PenaltyReason::built_in_names().collect();
        json_schema!({
            "description": "What a robot is penalised for, or the name of a rule of the program's own.",
            "anyOf": [{ "enum": names }, { "type": "string", "pattern": "^[a-z0-9_]{1,32}$" }]
        })
    }
}

short_name! {
    /// The name of a custom rule.
    RuleName, NotARuleName, 32, "a rule", "The name of a custom rule.", "^[a-z0-9_]{1,32}$"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_reads_as_it_is_written() {
        let own = PenaltyReason::Custom("time_wasting".parse().unwrap());
        for reason in PenaltyReason::built_in().chain([own]) {
            let text = serde_json::to_string(&reason).unwrap();
            assert_eq!(text, format!("\"{}\"", reason.name()));
            assert_eq!(serde_json::from_str::<PenaltyReason>(&text).unwrap(), reason);
        }
        assert_eq!(own.words(), "time wasting");
        for wrong in ["", "Time", "time wasting", "a_name_of_more_than_thirty_two_letters"] {
            assert!(wrong.parse::<RuleName>().is_err());
            assert!(serde_json::from_value::<PenaltyReason>(wrong.into()).is_err());
        }
        assert_eq!("x".repeat(32).parse::<RuleName>().unwrap().as_str().len(), 32);
    }
}
