//! The rules about single robots, as a table.

use super::memory::RobotMemory;
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use super::{ball_holding, fallen, illegal_defender, inactive, leaving_field, obstruction, set_play, stalling};
use crate::game::{Evidence, GameState, PenaltyReason, Rules};

/// The case of a robot to be judged, with the data of the match.
#[derive(Clone, Copy)]
pub struct RobotCase<'a> {
    /// The match at the end of the cycle.
    pub seen: &'a MatchSnapshot<'a>,
    /// The memories of all robots, in their order, including this cycle.
    pub records: &'a [RobotMemory],
    /// The index of the robot.
    pub index: usize,
}

impl<'a> RobotCase<'a> {
    /// The robot that is judged.
    pub fn robot(&self) -> &'a RobotSnapshot {
        &self.seen.robots[self.index]
    }

    /// The memory of the robot.
    pub fn record(&self) -> &'a RobotMemory {
        &self.records[self.index]
    }
}

/// A rule whose breach removes single robots.
pub struct RobotRule {
    /// The offence.
    pub reason: PenaltyReason,
    /// Whether the rules of the match include this rule.
    pub is_on: fn(&Rules) -> bool,
    /// Whether this rule also applies in `ready`, if [fouls are judged](Rules::fouls_in_ready) then.
    pub in_ready: bool,
    /// The evidence against a robot that breaks this rule.
    pub judge: fn(&RobotCase) -> Option<Evidence>,
}

/// All rules about single robots. Only the first rule that a robot breaks is applied.
pub const ROBOT_RULES: &[RobotRule] = &[
    RobotRule {
        reason: PenaltyReason::IllegalPosition,
        // Set plays exist only if the rules have them.
        is_on: |_| true,
        in_ready: false,
        judge: |case| {
            let set_play = case.seen.game.set_play.as_ref()?;
            set_play::judge(case.record().cycles_encroaching, set_play, case.seen, case.robot())
        },
    },
    RobotRule {
        reason: PenaltyReason::BallHolding,
        is_on: |rules| rules.ball_holding,
        in_ready: false,
        judge: |case| ball_holding::judge(case.record().cycles_holding, case.seen, case.robot()),
    },
    RobotRule {
        reason: PenaltyReason::Stalling,
        is_on: |rules| rules.stalling,
        in_ready: false,
        judge: |case| stalling::judge(case.record().stall.as_ref()?, case.seen, case.robot()),
    },
    RobotRule {
        reason: PenaltyReason::LeavingField,
        is_on: |rules| rules.leaving_field,
        in_ready: true,
        judge: |case| leaving_field::judge(case.record().cycles_in_goal, case.seen, case.robot()),
    },
    RobotRule {
        reason: PenaltyReason::IllegalDefender,
        is_on: |rules| rules.illegal_defender,
        in_ready: false,
        judge: |case| illegal_defender::judge(case.records, case.seen, case.index),
    },
    RobotRule {
        reason: PenaltyReason::Obstruction,
        is_on: |rules| rules.obstruction,
        in_ready: false,
        judge: |case| obstruction::judge(case.record().cycles_obstructing, case.seen, case.robot()),
    },
    RobotRule {
        reason: PenaltyReason::Fallen,
        is_on: |rules| rules.fallen,
        in_ready: true,
        judge: |case| fallen::judge(&case.record().get_up, case.seen, case.robot()),
    },
    RobotRule {
        reason: PenaltyReason::Inactive,
        is_on: |rules| rules.inactive,
        in_ready: true,
        judge: |case| inactive::judge(case.record().cycles_inactive, case.seen, case.robot()),
    },
];

/// The first rule that a robot breaks, with the evidence.
pub fn judge(case: &RobotCase) -> Option<(PenaltyReason, Evidence)> {
    ROBOT_RULES
        .iter()
        .filter(|rule| (rule.is_on)(case.seen.rules))
        .filter(|rule| rule.in_ready || case.seen.game.state == GameState::Playing)
        .find_map(|rule| Some((rule.reason, (rule.judge)(case)?)))
}
