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
    /// The robot that touched the ball last, if any.
    pub scorer: Option<RobotId>,
}

impl ScoredGoal {
    /// Whether the scorer is of the team that defends the goal.
    pub(crate) fn is_own_goal(&self) -> bool {
        self.scorer.is_some_and(|scorer| scorer.team != self.team)
    }
}

/// The goal for a crossing, if the rules count goals. It counts for the team that attacks the end of the crossing.
pub fn judge(snapshot: &MatchSnapshot, crossing: &Crossing) -> Option<ScoredGoal> {
    let Boundary::Goal(end) = crossing.boundary else { return None };
    snapshot.rules.goals.then(|| ScoredGoal {
        team: snapshot.game.defender_of(end).opponent(),
        scorer: snapshot.last_touch.map(|touch| touch.robot),
    })
}

/// The evidence for a goal.
pub fn evidence(snapshot: &MatchSnapshot, goal: &ScoredGoal, crossing: &Crossing) -> Evidence {
    let edge = snapshot.pitch.outer_half_extents().x;
    let radius = snapshot.ball.map_or(0.0, |ball| ball.radius);
    let mut evidence = snapshot
        .evidence(
            "A goal is scored when the whole ball passes the outer edge of the goal line between the posts.",
            crossing.position,
        )
        .with_measurement("m of the ball's rear from the halfway line", crossing.position.x.abs() - radius, edge)
        .otherwise(format!(
            "No goal if the ball had crossed the line more than {} m from its middle, or not wholly.",
            snapshot.pitch.goal.width_m / 2.0
        ));
    if let Some(index) = goal.scorer.and_then(|scorer| snapshot.robot_index(scorer)) {
        evidence = evidence.with_robot(snapshot.robots[index].evidence());
    }
    evidence
}
