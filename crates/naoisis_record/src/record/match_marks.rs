//! Moments of a match that users look for: marks on the timeline, and kicks.

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
    /// Cycle of the event.
    pub cycle: u64,
    /// Kind of the event.
    pub kind: MarkKind,
    /// Team that scored, touched the ball last, or was penalised.
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

/// A kick, for the animation of the leg.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct KickMark {
    /// Cycle in which the foot meets the ball.
    pub cycle: u64,
    /// The robot.
    pub robot: RobotId,
    /// Type of the kick.
    pub kick_type: KickType,
    /// Whether the ball was on the wrong side, so that the kick had reduced speed.
    pub is_reduced: bool,
}

impl KickMark {
    /// Returns the kick of `event`, if a leg swings for it.
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
