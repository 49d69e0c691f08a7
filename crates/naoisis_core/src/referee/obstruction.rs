//! Obstruction: a robot that does not go to the ball moves into the way of an opponent that does (2010 rule book, section 4.14). Standing
//! in the way is not obstruction; stepping aside with an opponent that walks around the robot is. The duration stands for the intention.

use super::areas::{goes_to_ball, is_keeper_at_home};
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::Evidence;

/// Greatest distance ahead of an opponent at which a robot is in its way to the ball, m, if it is also within [`BESIDE_M`].
const AHEAD_M: f32 = 0.6;
/// Margin of the lateral distance over half of both robots' widths, m.
const BESIDE_M: f32 = 0.05;
/// Least lateral speed of walking around a robot, and of stepping into its way, m/s.
const ASIDE_MPS: f32 = 0.03;
/// Cosine of the greatest angle from straight across an opponent's way at which a robot steps into it: 30 degrees.
const ACROSS_COSINE: f32 = 0.866;

/// Whether `robot` steps into the way to the ball of `other`.
pub(crate) fn steps_into_way(snapshot: &MatchSnapshot, robot: &RobotSnapshot, other: &RobotSnapshot) -> bool {
    let Some(ball) = &snapshot.ball else { return false };
    let way = ball.position - other.pose.position;
    let Some(direction) = way.try_normalize() else { return false };
    let between = robot.pose.position - other.pose.position;
    let (ahead, beside) = (between.dot(direction), between.perp_dot(direction));
    let aside = |robot: &RobotSnapshot| direction.perp_dot(robot.wanted_velocity);
    robot.id.team != other.id.team
        && other.is_present()
        && (0.0..AHEAD_M.min(way.length())).contains(&ahead)
        && beside.abs() < robot.bounds.torso.half_width_m + other.bounds.torso.half_width_m + BESIDE_M
        && goes_to_ball(snapshot, other)
        && !goes_to_ball(snapshot, robot)
        && !is_keeper_at_home(snapshot, robot)
        && aside(other).abs() > ASIDE_MPS
        && aside(robot) * aside(other).signum() > ASIDE_MPS.max(ACROSS_COSINE * robot.wanted_velocity.length())
}

/// The number of cycles for which the robot has stepped into an opponent's way, including this one. Cycles without obstruction are
/// subtracted.
pub fn advance(cycles: u64, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> u64 {
    let obstructs = snapshot.rules.obstruction
        && robot.posture.is_upright()
        && snapshot.robots.iter().any(|other| steps_into_way(snapshot, robot, other));
    if obstructs { cycles + 1 } else { cycles.saturating_sub(1) }
}

/// The evidence against a robot that has obstructed for too long.
pub fn judge(cycles: u64, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence> {
    let limit = snapshot.rules.obstruction_s;
    (cycles >= snapshot.cycles(limit)).then(|| {
        snapshot
            .evidence_against("A robot that does not go to the ball may not move into the way of one that does.", robot)
            .with_measurement("s of moving into the way", snapshot.seconds(cycles), limit)
            .otherwise("It had to stand, to leave the way, or to go to the ball itself.")
    })
}
