//! Kinds of mistakes of robots.

use bevy::prelude::*;
use core::fmt;
use serde::Serialize;
use strum::{IntoStaticStr, VariantArray};

/// The kind of a mistake.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect, Serialize, IntoStaticStr, VariantArray)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[non_exhaustive]
pub enum MistakeKind {
    /// The robot believed the ball elsewhere.
    BallMisplaced,
    /// The robot believed itself elsewhere.
    OwnPoseLost,
    /// The robot did not see the ball next to it.
    BallNotSeen,
    /// A kick missed the ball.
    KickMissed,
    /// The robot kicked towards its own goal.
    KickAtOwnGoal,
    /// The robot kicked the ball to an opponent, or out.
    BallGivenAway,
    /// Two team-mates collided.
    TeamMatesCollide,
    /// Two team-mates went for the same ball.
    SameBall,
}

impl MistakeKind {
    /// All kinds.
    pub const ALL: [MistakeKind; MistakeKind::VARIANTS.len()] =
        *MistakeKind::VARIANTS.first_chunk().expect("as many as there are");

    /// Name of the mistake, for people.
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
    pub fn key(self) -> &'static str {
        self.into()
    }
}

impl fmt::Display for MistakeKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.words())
    }
}
