//! Game stuck: no substantial change for a time (2010 rule book, section 3.10; 2025 rule book, section 3.11).
//!
//! A substantial change is a motion of the ball. By the rules of 2025 it is also a robot that approaches the ball or explores the pitch,
//! but not one that walks around the ball. If a robot is at the ball, the nearest one is removed; otherwise play is stopped, provided that
//! the ball was touched since the last kick-off.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::Evidence;

/// Distance from which the ball counts as moved, m.
const MOVED_M: f32 = 0.1;
/// Distance within which a robot is at the ball, m.
const AT_BALL_M: f32 = 0.5;

/// Distance from which a robot that is not at the ball counts as exploring the pitch, m.
const EXPLORED_M: f32 = 0.5;

/// A ball that does not move.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct Stuck {
    /// Its position, m, pitch frame.
    pub ball: Vec2,
    /// Cycles for which it has not moved.
    pub cycles: u64,
    /// Cycles for which it has not moved and a robot has been at it.
    #[reflect(default)]
    #[serde(default)]
    pub at_ball: u64,
    /// Whether a robot has touched the ball since the last kick-off.
    pub touched: bool,
    /// Cycles for which no robot has been [near](crate::game::Rules::global_stuck_m) the ball.
    pub alone: u64,
}

/// The remedy for a stuck game.
#[derive(Clone, PartialEq, Debug)]
pub enum Remedy {
    /// Remove the robot with this index, which is the nearest to the ball.
    Local(usize, Evidence),
    /// Stop play for a kick-off.
    Global(Evidence),
}

/// The state of the ball after this cycle.
pub fn advance(stuck: Stuck, snapshot: &MatchSnapshot) -> Stuck {
    let touched = stuck.touched || !snapshot.touches.is_empty();
    let Some(ball) = snapshot.ball else { return Stuck { cycles: 0, alone: 0, touched, ..stuck } };
    let is_near = |near_m: f32| {
        let mut present = snapshot.robots.iter().filter(|robot| robot.is_present());
        present.any(|robot| robot.pose.position.distance(ball.position) <= near_m)
    };
    let alone = if snapshot.rules.global_stuck_m.is_some_and(|near_m| !is_near(near_m)) { stuck.alone + 1 } else { 0 };
    let is_same = stuck.cycles > 0 && stuck.ball.distance(ball.position) <= MOVED_M;
    let before = if is_same { stuck } else { Stuck { ball: ball.position, cycles: 0, at_ball: 0, ..stuck } };
    let at_ball = if is_near(AT_BALL_M) { before.at_ball + 1 } else { 0 };
    Stuck { cycles: before.cycles + 1, at_ball, touched, alone, ..before }
}

/// The state of a robot at its last progress.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct Progress {
    /// Its position, m, pitch frame.
    pub from: Vec2,
    /// Its least distance from the ball, m.
    pub nearest_m: f32,
}

impl Progress {
    /// The state of a robot after this cycle, and whether it made progress.
    pub fn advance(before: Option<Progress>, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> (Option<Self>, bool) {
        let Some(ball) = snapshot.ball.filter(|_| robot.is_present()) else { return (None, false) };
        let place = robot.pose.position;
        let now = Progress { from: place, nearest_m: place.distance(ball.position) };
        let Some(before) = before else { return (Some(now), false) };
        let comes_nearer = now.nearest_m < before.nearest_m - MOVED_M;
        let explores = now.nearest_m > AT_BALL_M && place.distance(before.from) > EXPLORED_M;
        if comes_nearer || explores { (Some(now), true) } else { (Some(before), false) }
    }
}

/// The remedy if for too long the ball has not moved, or no robot has been near it.
pub fn judge(stuck: &Stuck, snapshot: &MatchSnapshot) -> Option<Remedy> {
    let rules = snapshot.rules;
    let is_over = |cycles: u64, seconds: f32| cycles >= snapshot.cycles(seconds);
    // In 2026 the time runs while a robot is at the ball, so that a robot that arrives is not removed at once.
    let (local_s, cycles) =
        rules.local_stuck_s.map_or((rules.game_stuck_s, stuck.cycles), |local_s| (local_s, stuck.at_ball));
    let ball = snapshot.ball?.position;
    let distance = |index: &usize| snapshot.robots[*index].pose.position.distance(ball);
    let present = (0..snapshot.robots.len()).filter(|index| snapshot.robots[*index].is_present());
    let nearest = present.min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let measured = |evidence: Evidence, cycles: u64, limit_s: f32| {
        evidence
            .with_measurement("s without change", snapshot.seconds(cycles), limit_s)
            .otherwise(format!("The ball had to move by more than {MOVED_M} m in time."))
    };
    if let Some(index) = nearest.filter(|index| distance(index) <= AT_BALL_M) {
        let rule = "When play is stuck, the robot nearest to the ball is taken away.";
        let evidence = snapshot.evidence_against(rule, &snapshot.robots[index]);
        return is_over(cycles, local_s).then(|| Remedy::Local(index, measured(evidence, cycles, local_s)));
    }
    let rule = "When play is stuck with nobody at the ball, it is stopped for a kick-off.";
    match rules.global_stuck_m {
        Some(near_m) => is_over(stuck.alone, rules.game_stuck_s).then(|| {
            let evidence = snapshot.evidence(rule, ball).with_measurement(
                "s without a robot near the ball",
                snapshot.seconds(stuck.alone),
                rules.game_stuck_s,
            );
            Remedy::Global(evidence.otherwise(format!("A robot had to be within {near_m} m of the ball in time.")))
        }),
        None => (stuck.touched && is_over(stuck.cycles, rules.game_stuck_s))
            .then(|| Remedy::Global(measured(snapshot.evidence(rule, ball), stuck.cycles, rules.game_stuck_s))),
    }
}
