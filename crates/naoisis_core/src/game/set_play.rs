//! Free kicks, and the kick-off as long as the ball is one team's own (2025 rule book,
//! section 3.9). How they go on is the
//! referee's: [`referee::set_play`](crate::referee::set_play).

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::team::Team;

/// Why the ball belongs to one team.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SetPlayKind {
    /// Kick-off.
    KickOff,
    /// The ball was out over a side line.
    KickIn,
    /// The attackers put it out over the goal line, or a goal of theirs did not count.
    GoalKick,
    /// The defenders put it out over the goal line.
    CornerKick,
    /// An opponent pushed near the ball: a direct free kick.
    PushingFreeKick,
    /// An opponent committed another offence near the ball.
    IndirectFreeKick,
    /// An opponent pushed near the ball in its own penalty area. It has a `ready` and a `set` of its own.
    PenaltyKick,
}

impl SetPlayKind {
    /// Whether a goal of the team that takes it counts directly, where the rules know the difference.
    pub fn is_direct(self) -> bool {
        match self {
            SetPlayKind::GoalKick
            | SetPlayKind::CornerKick
            | SetPlayKind::PushingFreeKick
            | SetPlayKind::PenaltyKick => true,
            SetPlayKind::KickOff | SetPlayKind::KickIn | SetPlayKind::IndirectFreeKick => false,
        }
    }

    /// Its name, as at the start of a sentence.
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

/// A free kick under way.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct SetPlay {
    /// What it is given for.
    pub kind: SetPlayKind,
    /// The team that the ball belongs to.
    pub team: Team,
    /// Where the ball was put, m, pitch frame.
    pub ball_m: Vec2,
    /// Cycles for which it has gone on.
    pub cycles: u64,
    /// Cycles until the ball is free.
    pub cycles_left: u64,
    /// Whether the team has touched the ball.
    pub touched: bool,
}

impl SetPlay {
    /// A free kick that begins now.
    pub fn new(kind: SetPlayKind, team: Team, ball_m: Vec2, cycles_left: u64) -> Self {
        Self { kind, team, ball_m, cycles: 0, cycles_left, touched: false }
    }

    /// The same a cycle later: its time runs while the ball is in play.
    #[must_use]
    pub fn later(self, in_play: bool) -> Self {
        Self { cycles: self.cycles + 1, cycles_left: self.cycles_left.saturating_sub(u64::from(in_play)), ..self }
    }
}
