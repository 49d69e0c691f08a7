//! What the referee remembers from one cycle to the next, beside the state of the match.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::game::Score;
use super::snapshot::RobotSnapshot;
use super::stalling::Stall;
use super::touch::Touch;
use crate::knowledge::Knowledge;
use crate::robot::RobotId;

/// The referee's memory.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct RefereeMemory {
    /// The last touch of the ball since it was last placed, if any.
    pub last_touch: Option<Touch>,
    /// How often each team was penalised for pushing in this half.
    pub pushes: Score,
    /// What is remembered of each robot, ordered by id.
    pub robots: Vec<RobotRecord>,
}

/// What the referee remembers of a robot.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct RobotRecord {
    /// Which robot.
    pub id: RobotId,
    /// Since when, and where, it stands near the ball, if it does.
    pub stall: Option<Stall>,
}

impl RobotRecord {
    /// Nothing is held against this robot.
    pub fn clean(id: RobotId) -> Self {
        Self { id, stall: None }
    }
}

impl RefereeMemory {
    /// Makes the records those of the robots that there are.
    pub(super) fn match_robots(&mut self, robots: &[RobotSnapshot]) {
        let same = self.robots.len() == robots.len()
            && self.robots.iter().zip(robots).all(|(record, robot)| record.id == robot.id);
        if !same {
            let old = core::mem::take(&mut self.robots);
            self.robots.extend(robots.iter().map(|robot| {
                old.iter().find(|record| record.id == robot.id).copied().unwrap_or(RobotRecord::clean(robot.id))
            }));
        }
    }

    /// Forgets whatever was held against the robots: they were placed, or play was stopped.
    pub(super) fn forget_robots(&mut self) {
        for record in &mut self.robots {
            *record = RobotRecord::clean(record.id);
        }
    }
}
