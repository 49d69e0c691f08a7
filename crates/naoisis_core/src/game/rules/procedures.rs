//! The procedures that the rules select.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The restart after the ball has left the pitch.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum BallOutRestart {
    /// A kick-off of the team that did not touch the ball last, as in the paper's match mode (section 3.4).
    #[default]
    KickOff,
    /// Play continues; the ball is thrown in (2010 rule book, section 3.9).
    ThrowIn,
    /// A kick-in, a goal kick or a corner kick (2025 rule book, section 3.8).
    FreeKick,
}

/// The procedure of a kick-off.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum KickOffProcedure {
    /// Ball and robots are repositioned, and play continues at once (paper, section 3.4).
    #[default]
    Placed,
    /// Robots walk to their places (`ready`), wait there (`set`), and play begins with the whistle.
    ReadyAndSet,
}

/// The rule book that defines legal positions at a kick-off.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum KickOffPositions {
    /// 2010 rule book, section 3.5.
    #[default]
    Spl2010,
    /// 2025 rule book, section 3.7.
    Spl2025,
}

/// Where a robot returns after a penalty.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ReturnPlace {
    /// On the halfway line, at the side line farther from the ball (2010).
    #[default]
    HalfwayLine,
    /// At the side line, level with its own penalty mark (2025).
    PenaltyMark,
}

/// Which robots of a team may be in front of their own goal.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum DefenderLimit {
    /// Only the goalkeeper may have both feet in the penalty area (2010).
    #[default]
    KeeperOnly,
    /// At most this many robots may touch the goal area, or on a pitch without one the penalty area (2025: 3).
    AtMost(u8),
}

/// Whether contacts with a robot's side, its arm or shoulder, on its way to the ball are legal.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum SideContacts {
    /// They are judged like any collision.
    #[default]
    Count,
    /// They are legal if the other robot goes to the ball, too (2010 rule book, section 4.9.1).
    FreeIfBothGoToBall,
    /// They are legal (2025 rule book, section 4.10).
    FreeOnTheWayToBall,
}

/// The procedure of a penalty shoot-out.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ShootOutProcedure {
    /// The attacker begins in the centre of the pitch and may play the ball until it is in the penalty area; in sudden death the
    /// faster goal wins, or the ball that came nearer (2010 rule book, sections 3.7 and 3.8).
    #[default]
    Spl2010,
    /// The attacker begins at the edge of the penalty area and may play the ball once; in sudden death the better shot
    /// wins (2025 rule book, section 3.19).
    Spl2025,
}

/// When a substitute may replace a player, besides time-outs and half time. In these it takes the player's place at once.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum SubstitutionProcedure {
    /// At no other time (2010 rule book).
    #[default]
    InTimeouts,
    /// In any stoppage: the substitute enters where penalised robots return (HSL 2026, 3.4).
    InStoppages,
    /// At any time, in place of a robot that is picked up, whose penalty the substitute serves (2025 rule book, section 3.12).
    AsPickUp,
}
