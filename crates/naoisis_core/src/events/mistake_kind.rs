//! What robots do wrong, in a word.

use bevy::prelude::*;
use core::fmt;
use serde::Serialize;

/// What went wrong.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum MistakeKind {
    /// It believed the ball elsewhere.
    BallMisplaced,
    /// It believed itself elsewhere.
    OwnPoseLost,
    /// It did not see the ball next to it.
    BallNotSeen,
    /// Its kick did not reach the ball.
    KickMissed,
    /// It kicked towards its own goal.
    KickAtOwnGoal,
    /// It kicked the ball to an opponent, or out.
    BallGivenAway,
    /// It ran into a team-mate, or a team-mate into it.
    TeamMatesCollide,
    /// It and a team-mate went for the same ball.
    SameBall,
}

impl MistakeKind {
    /// All kinds.
    pub const ALL: [MistakeKind; 8] = [
        MistakeKind::BallMisplaced,
        MistakeKind::OwnPoseLost,
        MistakeKind::BallNotSeen,
        MistakeKind::KickMissed,
        MistakeKind::KickAtOwnGoal,
        MistakeKind::BallGivenAway,
        MistakeKind::TeamMatesCollide,
        MistakeKind::SameBall,
    ];

    /// Its name, for people.
    pub fn words(self) -> &'static str {
        match self {
            MistakeKind::BallMisplaced => "ball misplaced",
            MistakeKind::OwnPoseLost => "own pose lost",
            MistakeKind::BallNotSeen => "ball not seen",
            MistakeKind::KickMissed => "kick missed",
            MistakeKind::KickAtOwnGoal => "kick at own goal",
            MistakeKind::BallGivenAway => "ball given away",
            MistakeKind::TeamMatesCollide => "team-mates collide",
            MistakeKind::SameBall => "same ball",
        }
    }

    /// Its name in files, such as `ball_misplaced`.
    pub fn key(self) -> String {
        self.words().replace([' ', '-'], "_")
    }
}

impl fmt::Display for MistakeKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.words())
    }
}
