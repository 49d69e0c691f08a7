//! Free kicks, and kick-offs while the ball belongs to one team (2025 rule book, section 3.9).
//! [`referee::set_play`](crate::referee::set_play) judges them.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::team::Team;

/// The kind of a set play, in which the ball belongs to one team.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SetPlayKind {
    /// Kick-off.
    KickOff,
    /// The ball was out over a side line.
    KickIn,
    /// The attackers put the ball out over the goal line, or their goal did not count.
    GoalKick,
    /// The defenders put the ball out over the goal line.
    CornerKick,
    /// An opponent pushed near the ball: a direct free kick.
    PushingFreeKick,
    /// An opponent committed another offence near the ball.
    IndirectFreeKick,
    /// An opponent pushed near the ball in its own penalty area. The penalty kick has its own `ready` and `set`.
    PenaltyKick,
}

impl SetPlayKind {
    /// Whether a goal of the kicking team counts directly, if the rules make a difference.
    pub fn is_direct(self) -> bool {
        match self {
            SetPlayKind::GoalKick
            | SetPlayKind::CornerKick
            | SetPlayKind::PushingFreeKick
            | SetPlayKind::PenaltyKick => true,
            SetPlayKind::KickOff | SetPlayKind::KickIn | SetPlayKind::IndirectFreeKick => false,
        }
    }

    /// The name in words, capitalised for the start of a sentence.
    pub fn words(self) -> &'static str {
        match self {
            SetPlayKind::KickOff => "Kick-off",
            SetPlayKind::KickIn => "Kick-in",
            SetPlayKind::GoalKick => "Goal kick",
            SetPlayKind::CornerKick => "Corner kick",
            SetPlayKind::PushingFreeKick => "Pushing free kick",
            SetPlayKind::IndirectFreeKick => "Indirect free kick",
            SetPlayKind::PenaltyKick => "Penalty kick",
        }
    }
}

/// A set play under way.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct SetPlay {
    /// Its kind.
    pub kind: SetPlayKind,
    /// The team that the ball belongs to.
    pub team: Team,
    /// Position at which the ball was placed, m, pitch frame.
    pub ball_m: Vec2,
    /// Cycles since it began.
    pub cycles: u64,
    /// Cycles until the ball is free.
    pub cycles_left: u64,
    /// Whether the team has touched the ball.
    pub touched: bool,
}

impl SetPlay {
    /// A set play that begins now.
    pub fn new(kind: SetPlayKind, team: Team, ball_m: Vec2, cycles_left: u64) -> Self {
        Self { kind, team, ball_m, cycles: 0, cycles_left, touched: false }
    }

    /// The set play one cycle later. Its time runs only if the ball is `in_play`.
    #[must_use]
    pub fn later(self, in_play: bool) -> Self {
        Self { cycles: self.cycles + 1, cycles_left: self.cycles_left.saturating_sub(u64::from(in_play)), ..self }
    }
}
