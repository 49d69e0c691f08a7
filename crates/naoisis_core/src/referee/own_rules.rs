//! Rules of a program's own: about single robots, judged after the built-in ones.

use bevy::prelude::*;
use core::fmt;

use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::{Evidence, PenaltyReason, RuleName};

/// A rule of a program's own, with its settings. While it is broken for some cycles, a robot is penalised and removed, as for
/// a built-in rule.
pub trait OwnRule: Send + Sync + 'static {
    /// For how many cycles the robot has done what it should not, this one included; `cycles` is what that was before this
    /// cycle. It is none again whenever the robot is put somewhere.
    fn advance(&self, cycles: u64, seen: &MatchSnapshot, robot: &RobotSnapshot) -> u64;

    /// The case against a robot that has done so for so many cycles, if there is one.
    fn judge(&self, cycles: u64, seen: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence>;
}

/// So many rules of its own a program can have.
pub const MOST_OWN_RULES: usize = 8;

/// A rule that is in force.
struct InForce {
    name: RuleName,
    /// The place of its cycles in the referee's memory: the same whichever other rules are in force.
    place: usize,
    rule: Box<dyn OwnRule>,
}

/// The rules of the program's own that are in force in this match.
#[derive(Resource, Default)]
pub struct OwnRules(Vec<InForce>);

impl OwnRules {
    /// Takes a rule into force. `place` is below [`MOST_OWN_RULES`] and belongs to it alone.
    pub fn add(&mut self, name: RuleName, place: usize, rule: Box<dyn OwnRule>) {
        self.0.push(InForce { name, place, rule });
    }

    /// Counts this cycle.
    pub(super) fn advance(&self, cycles: &mut [u64; MOST_OWN_RULES], seen: &MatchSnapshot, robot: &RobotSnapshot) {
        for InForce { place, rule, .. } in &self.0 {
            if let Some(cycles) = cycles.get_mut(*place) {
                *cycles = rule.advance(*cycles, seen, robot);
            }
        }
    }

    /// The first rule that a robot breaks, and the case against it.
    pub(super) fn judge(
        &self,
        cycles: &[u64; MOST_OWN_RULES],
        seen: &MatchSnapshot,
        robot: &RobotSnapshot,
    ) -> Option<(PenaltyReason, Evidence)> {
        self.0.iter().find_map(|InForce { name, place, rule }| {
            let evidence = rule.judge(*cycles.get(*place)?, seen, robot)?;
            Some((PenaltyReason::Own(*name), evidence))
        })
    }
}

impl fmt::Debug for OwnRules {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_list().entries(self.0.iter().map(|rule| rule.name)).finish()
    }
}
