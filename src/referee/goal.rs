//! Goals (2010 rule book, section 3.5).

use super::boundary::{Boundary, Crossing};
use super::snapshot::MatchSnapshot;
use crate::robot::{RobotId, Team};

/// A goal.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Goal {
    /// The team that it counts for.
    pub team: Team,
    /// Who touched the ball last, if anybody did.
    pub scorer: Option<RobotId>,
}

impl Goal {
    /// Whether it was put in by the team that defends the goal.
    pub fn is_own_goal(&self) -> bool {
        self.scorer.is_some_and(|scorer| scorer.team != self.team)
    }
}

/// The goal that a crossing is, if the rules count goals: it counts for the team that attacks that end.
pub fn judge(snapshot: &MatchSnapshot, crossing: &Crossing) -> Option<Goal> {
    let Boundary::Goal(end) = crossing.boundary else { return None };
    snapshot.rules.goals.then(|| Goal {
        team: snapshot.game.defender_of(end).opponent(),
        scorer: snapshot.last_touch.map(|touch| touch.robot),
    })
}
