//! Inactive robots: a robot that has ceased activity is removed (2010 rule book, section 4.7; 2025 rule book, section 4.6). Robots
//! that walk, turn, kick, move the head, or look at the ball are active; another rule covers robots that lie.

use bevy::prelude::*;

use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::Evidence;
use crate::geometry::{angle_of, wrap_angle};
use crate::robot::head::HeadAngles;

/// Half the angle within which a robot looks at the ball, radians: half the cameras' horizontal field of view
/// (23.9 degrees).
const LOOKING: f32 = 0.417;

/// The number of cycles for which the robot has been inactive, including this one. `head` are its head angles in the last cycle.
pub fn advance(cycles: u64, head: HeadAngles, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> u64 {
    let moves = robot.pose != robot.previous || robot.wanted_velocity != Vec2::ZERO || robot.head != head;
    if moves || robot.is_kicking || !robot.posture.is_upright() || looks_at_ball(snapshot, robot) {
        0
    } else {
        cycles + 1
    }
}

fn looks_at_ball(snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    let Some(ball) = snapshot.ball else { return false };
    let bearing = angle_of(robot.pose.inverse_transform_point(ball.position));
    wrap_angle(bearing - robot.head.yaw).abs() <= LOOKING
}

/// The evidence against a robot that has been inactive for too long.
pub fn judge(cycles: u64, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence> {
    (cycles >= snapshot.cycles(snapshot.rules.inactive_s)).then(|| {
        snapshot
            .evidence_against("A robot that has ceased activity for too long is removed.", robot)
            .with_measurement("s without activity", snapshot.seconds(cycles), snapshot.rules.inactive_s)
            .otherwise("It had to walk, turn, kick, move its head or look at the ball in time.")
    })
}
