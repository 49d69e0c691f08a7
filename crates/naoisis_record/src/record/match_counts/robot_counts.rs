//! The counts of a robot, or of all robots of a team together.

use bevy::prelude::*;
use std::collections::BTreeMap;

use super::ObservedRobot;
use naoisis_core::game::PenaltyReason;
use naoisis_core::pitch::End;
use naoisis_sensing::belief::{pitch_from_team, point_pitch_from_team};

/// The counts of a robot, by the [definitions](super).
#[derive(Clone, PartialEq, Debug, Default)]
pub struct RobotCounts {
    /// Kicks that struck the ball.
    pub kicks: u32,
    /// Shots.
    pub shots: u32,
    /// Shots on target.
    pub shots_on_target: u32,
    /// Goals, without own goals.
    pub goals: u32,
    /// Saves.
    pub saves: u32,
    /// Passes, completed or not.
    pub passes: u32,
    /// Passes completed.
    pub passes_completed: u32,
    /// Penalties, by reason.
    pub penalties: BTreeMap<PenaltyReason, u32>,
    /// Falls.
    pub falls: u32,
    /// How often the robot's program was lost.
    pub programs_lost: u32,
    /// The distance walked, m.
    pub distance_m: f64,
    /// The pose errors.
    pub pose_errors: ErrorCounts,
    /// The ball errors.
    pub ball_errors: ErrorCounts,
    play_cycles: u64,
    ball_seen_cycles: u64,
}

/// Errors of a belief, with one value for each cycle.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct ErrorCounts {
    cycles: u64,
    sum_m: f64,
    over_half_m: u64,
    over_1_m: u64,
}

impl ErrorCounts {
    fn note(&mut self, error_m: f64, cycles: u64) {
        self.cycles += cycles;
        self.sum_m += error_m * cycles as f64;
        self.over_half_m += if error_m > 0.5 { cycles } else { 0 };
        self.over_1_m += if error_m > 1.0 { cycles } else { 0 };
    }

    fn add(&mut self, other: Self) {
        self.cycles += other.cycles;
        self.sum_m += other.sum_m;
        self.over_half_m += other.over_half_m;
        self.over_1_m += other.over_1_m;
    }

    /// Returns the mean, m. Returns `None` without values.
    pub fn mean_m(&self) -> Option<f64> {
        (self.cycles > 0).then(|| self.sum_m / self.cycles as f64)
    }

    /// Returns the share of the time in which the error is over 0.5 m, from 0 to 1. Returns `None` without values.
    pub fn over_half_m(&self) -> Option<f64> {
        share(self.over_half_m, self.cycles)
    }

    /// Returns the share of the time in which the error is over 1 m, from 0 to 1. Returns `None` without values.
    pub fn over_1_m(&self) -> Option<f64> {
        share(self.over_1_m, self.cycles)
    }
}

impl RobotCounts {
    /// Counts `cycles` in play that end with `cycle`. `robot` is the robot after it.
    pub(super) fn play(&mut self, robot: &ObservedRobot, sensed: &SensedPlaces, cycles: u64, period_s: f64) {
        self.distance_m += f64::from(robot.speed_mps) * period_s * cycles as f64;
        self.play_cycles += cycles;
        self.ball_seen_cycles += if robot.sees_ball { cycles } else { 0 };
        if let Some(error_m) = sensed.pose_error_m(robot) {
            self.pose_errors.note(error_m, cycles);
        }
        let ball_m = sensed.ball_m.filter(|_| sensed.robot_m.is_some());
        if let (Some(ball), Some(believed)) = (ball_m, robot.belief.and_then(|belief| belief.ball.as_ref())) {
            let believed = point_pitch_from_team(believed.position_m, sensed.own_end);
            self.ball_errors.note(f64::from(believed.distance(ball)), cycles);
        }
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.kicks += other.kicks;
        self.shots += other.shots;
        self.shots_on_target += other.shots_on_target;
        self.goals += other.goals;
        self.saves += other.saves;
        self.passes += other.passes;
        self.passes_completed += other.passes_completed;
        for (reason, count) in &other.penalties {
            *self.penalties.entry(*reason).or_default() += count;
        }
        self.falls += other.falls;
        self.programs_lost += other.programs_lost;
        self.distance_m += other.distance_m;
        self.pose_errors.add(other.pose_errors);
        self.ball_errors.add(other.ball_errors);
        self.play_cycles += other.play_cycles;
        self.ball_seen_cycles += other.ball_seen_cycles;
    }

    /// Returns the number of penalties for all reasons.
    pub fn penalty_count(&self) -> u32 {
        self.penalties.values().sum()
    }

    /// Returns the share of the time in which the robot recognised the ball, from 0 to 1. Returns `None` if it was not in play.
    pub fn ball_seen(&self) -> Option<f64> {
        share(self.ball_seen_cycles, self.play_cycles)
    }
}

/// The places of a robot and of the ball when the robot sensed, m, pitch frame, and the end that its team defends. Without a place of the
/// robot, it did not sense.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct SensedPlaces {
    pub(super) robot_m: Option<Vec2>,
    pub(super) ball_m: Option<Vec2>,
    pub(super) own_end: End,
}

impl SensedPlaces {
    /// Returns the pose error of `robot`, m. `None` if it has no belief or did not sense.
    pub(super) fn pose_error_m(&self, robot: &ObservedRobot) -> Option<f64> {
        let believed = pitch_from_team(robot.belief?.pose, self.own_end);
        Some(f64::from(believed.position.distance(self.robot_m?)))
    }
}

fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}
