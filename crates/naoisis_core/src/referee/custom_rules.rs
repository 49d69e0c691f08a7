//! Custom rules of a program about single robots, which are judged after the built-in rules.

use bevy::prelude::*;
use core::fmt;

use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::{Evidence, PenaltyReason, RuleName};

/// A custom rule with its settings. A robot that breaks the rule for some cycles is penalised and removed, as for a built-in rule.
pub trait CustomRule: Send + Sync + 'static {
    /// The number of cycles for which the robot has broken the rule, including this one. `cycles` is the number before this cycle;
    /// it is reset to zero when the robot is placed.
    fn advance(&self, cycles: u64, seen: &MatchSnapshot, robot: &RobotSnapshot) -> u64;

    /// The evidence against a robot that has broken the rule for `cycles`; `None` if that is legal.
    fn judge(&self, cycles: u64, seen: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence>;
}

/// The greatest number of custom rules of a program.
pub const MOST_CUSTOM_RULES: usize = 8;

/// A rule that is in force.
struct InForce {
    name: RuleName,
    /// The index of its cycle count in the referee's memory, independent of the other rules in force.
    place: usize,
    rule: Box<dyn CustomRule>,
}

/// The custom rules that are in force in this match.
#[derive(Resource, Default)]
pub struct CustomRules(Vec<InForce>);

impl CustomRules {
    /// Adds a rule. `place` is below [`MOST_CUSTOM_RULES`] and unique.
    pub fn add(&mut self, name: RuleName, place: usize, rule: Box<dyn CustomRule>) {
        self.0.push(InForce { name, place, rule });
    }

    /// Counts this cycle.
    pub(super) fn advance(&self, cycles: &mut [u64; MOST_CUSTOM_RULES], seen: &MatchSnapshot, robot: &RobotSnapshot) {
        for InForce { place, rule, .. } in &self.0 {
            if let Some(cycles) = cycles.get_mut(*place) {
                *cycles = rule.advance(*cycles, seen, robot);
            }
        }
    }

    /// The first rule that a robot breaks, with the evidence.
    pub(super) fn judge(
        &self,
        cycles: &[u64; MOST_CUSTOM_RULES],
        seen: &MatchSnapshot,
        robot: &RobotSnapshot,
    ) -> Option<(PenaltyReason, Evidence)> {
        self.0.iter().find_map(|InForce { name, place, rule }| {
            let evidence = rule.judge(*cycles.get(*place)?, seen, robot)?;
            Some((PenaltyReason::Custom(*name), evidence))
        })
    }
}

impl fmt::Debug for CustomRules {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_list().entries(self.0.iter().map(|rule| rule.name)).finish()
    }
}
