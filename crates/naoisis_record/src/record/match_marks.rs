//! The moments of a match that are found again: marks on the timeline, and kicks.

use naoisis_core::events::{KickResult, MatchEvent};
use naoisis_core::kick_geometry::KickType;
use naoisis_core::team::{RobotId, Team};

/// What a mark on the timeline stands for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum MarkKind {
    /// A goal.
    Goal,
    /// The ball left the pitch.
    Out,
    /// A robot was penalised.
    Penalty,
    /// A half began, or the match ended.
    Whistle,
}

/// A mark on the timeline.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Mark {
    /// Its cycle.
    pub cycle: u64,
    /// What it stands for.
    pub kind: MarkKind,
    /// The team whose goal, ball or penalty it was.
    pub team: Option<Team>,
}

impl Mark {
    /// Returns the mark of `event`, if it has one.
    pub(super) fn of(event: &MatchEvent, cycle: u64) -> Option<Mark> {
        let (kind, team) = match event {
            MatchEvent::Goal { team, .. } => (MarkKind::Goal, Some(*team)),
            MatchEvent::BallOut { last_touch, .. } => (MarkKind::Out, *last_touch),
            MatchEvent::Penalty { robot, .. } => (MarkKind::Penalty, Some(robot.team)),
            MatchEvent::HalfBegins { .. } | MatchEvent::FinalWhistle => (MarkKind::Whistle, None),
            _ => return None,
        };
        Some(Mark { cycle, kind, team })
    }
}

/// A kick, for which the leg swings.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct KickMark {
    /// Its cycle.
    pub cycle: u64,
    /// The robot.
    pub robot: RobotId,
    /// The kick.
    pub kick_type: KickType,
    /// Whether the ball was on the wrong side.
    pub is_reduced: bool,
}

impl KickMark {
    /// Returns the kick of `event`, if it is one for which a leg swings.
    pub(super) fn of(event: &MatchEvent, cycle: u64) -> Option<KickMark> {
        match event {
            MatchEvent::Kick { robot, kick_type, result, reason, .. } if result.swings(*reason) => {
                let is_reduced = *result == KickResult::Reduced;
                Some(KickMark { cycle, robot: *robot, kick_type: *kick_type, is_reduced })
            }
            _ => None,
        }
    }
}
