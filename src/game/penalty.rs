//! Penalties of robots.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::cycle::CycleClock;
use crate::knowledge::Knowledge;
use crate::state::ReflectState;

/// The penalty that a robot serves, if any. A penalised robot cannot act, is no obstacle, and is not seen.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(State, @Knowledge::Truth)]
pub struct Penalty(pub Option<ActivePenalty>);

impl Penalty {
    /// Whether the robot is off the pitch.
    pub fn is_active(&self) -> bool {
        self.0.is_some()
    }
}

/// A penalty that is being served.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct ActivePenalty {
    /// What for.
    pub reason: PenaltyReason,
    /// Cycles of play until the robot may come back.
    pub cycles_left: u64,
}

impl ActivePenalty {
    /// Time of play until the robot may come back, s.
    pub fn left_s(&self, clock: &CycleClock) -> f64 {
        self.cycles_left as f64 * clock.period_s
    }
}

/// What a robot can be penalised for.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
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
    /// It did nothing for too long.
    Inactive,
    /// It lay on the ground for too long.
    Fallen,
    /// It takes no part in this shot of the shoot-out.
    ShootOut,
    /// Play was stuck, and it was the nearest to the ball.
    GameStuck,
    /// Whoever runs the match removed it.
    #[default]
    Manual,
}

impl PenaltyReason {
    /// Whether it makes the team's later penalties longer (2025 rule book, "Standard Removal Penalty").
    pub fn is_infraction(self) -> bool {
        match self {
            PenaltyReason::Pushing
            | PenaltyReason::Stalling
            | PenaltyReason::BallHolding
            | PenaltyReason::LeavingField
            | PenaltyReason::IllegalDefender
            | PenaltyReason::IllegalPosition => true,
            PenaltyReason::Inactive
            | PenaltyReason::Fallen
            | PenaltyReason::ShootOut
            | PenaltyReason::GameStuck
            | PenaltyReason::Manual => false,
        }
    }

    /// The reason in words, as after "penalised for".
    pub fn words(self) -> &'static str {
        match self {
            PenaltyReason::Pushing => "pushing",
            PenaltyReason::Stalling => "stalling",
            PenaltyReason::BallHolding => "ball holding",
            PenaltyReason::LeavingField => "leaving the field",
            PenaltyReason::IllegalDefender => "illegal defending",
            PenaltyReason::IllegalPosition => "an illegal position",
            PenaltyReason::Inactive => "inactivity",
            PenaltyReason::Fallen => "lying on the ground",
            PenaltyReason::ShootOut => "the shoot-out",
            PenaltyReason::GameStuck => "a stuck game",
            PenaltyReason::Manual => "a reason of its own",
        }
    }
}
