//! Goals (2010 and 2025 rule books, section 3.3).

use super::boundary::{Boundary, Crossing};
use super::snapshot::MatchSnapshot;
use crate::game::Evidence;
use crate::team::{RobotId, Team};

/// A goal that counts.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ScoredGoal {
    /// The team that it counts for.
    pub team: Team,
    /// The [scorer], if any robot touched the ball.
    pub scorer: Option<RobotId>,
}

impl ScoredGoal {
    /// Whether the scorer is of the team that defends the goal.
    pub(crate) fn is_own_goal(&self) -> bool {
        self.scorer.is_some_and(|scorer| scorer.team != self.team)
    }
}

/// The goal for a crossing, if the rules count goals. It counts for the team that attacks the end of the crossing. `kicker` is the robot
/// whose kick the ball still rolls from.
pub fn judge(snapshot: &MatchSnapshot, kicker: Option<RobotId>, crossing: &Crossing) -> Option<ScoredGoal> {
    let Boundary::Goal(end) = crossing.boundary else { return None };
    let team = snapshot.game.defender_of(end).opponent();
    let last_touch = snapshot.last_touch.map(|touch| touch.robot);
    snapshot.rules.goals.then(|| ScoredGoal { team, scorer: scorer(team, last_touch, kicker) })
}

/// The robot to which a goal of `team` counts: the one that touched the ball last. A kick of `team` that the other team only deflected is
/// the kicker's.
pub fn scorer(team: Team, last_touch: Option<RobotId>, kicker: Option<RobotId>) -> Option<RobotId> {
    let by = last_touch?;
    kicker.filter(|kicker| by.team != team && kicker.team == team).or(Some(by))
}

/// The evidence for a goal.
pub fn evidence(snapshot: &MatchSnapshot, goal: &ScoredGoal, crossing: &Crossing) -> Evidence {
    let half_width = snapshot.pitch.goal.width_m / 2.0;
    let mut evidence = snapshot
        .evidence(
            "A goal is scored when the whole ball passes the outer edge of the goal line between the posts.",
            crossing.position,
        )
        .with_measurement(
            "m between the ball's centre and the middle of the goal",
            crossing.position.y.abs(),
            half_width,
        )
        .otherwise(format!(
            "No goal if the ball had crossed the line more than {half_width} m from its middle, or not wholly."
        ));
    if let Some(index) = goal.scorer.and_then(|scorer| snapshot.robot_index(scorer)) {
        evidence = evidence.with_robot(snapshot.robots[index].evidence());
    }
    evidence
}
