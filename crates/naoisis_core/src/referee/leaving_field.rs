//! Leaving the field: robots stay on the carpet and out of the goals (2010 and 2025 rule books, section 4.12).

use super::areas::{base_corners, in_goal};
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::Evidence;
use crate::pitch::End;

/// The number of cycles for which the robot has been in a goal, including this one.
pub fn advance(cycles_in_goal: u64, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> u64 {
    let inside = End::BOTH.into_iter().any(|end| in_goal(snapshot.pitch, end, robot.pose.position));
    if inside { cycles_in_goal + 1 } else { 0 }
}

/// The evidence against a robot with a part of its feet beyond the carpet, or that has been in a goal for too long.
pub fn judge(cycles_in_goal: u64, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence> {
    let carpet = snapshot.pitch.carpet_half_extents();
    let beyond = base_corners(robot)
        .into_iter()
        .map(|corner| (corner.abs() - carpet).max_element())
        .fold(f32::NEG_INFINITY, f32::max);
    if beyond > 0.0 {
        let evidence = snapshot.evidence_against("A robot that leaves the carpet is penalised.", robot);
        return Some(
            evidence
                .with_measurement("m beyond the carpet's edge", beyond, 0.0)
                .otherwise("It had to stay on the carpet."),
        );
    }
    (cycles_in_goal >= snapshot.cycles(snapshot.rules.in_goal_s)).then(|| {
        snapshot
            .evidence_against("A robot that stays in a goal for too long is penalised.", robot)
            .with_measurement("s in the goal", snapshot.seconds(cycles_in_goal), snapshot.rules.in_goal_s)
            .otherwise("It had to come out of the goal in time.")
    })
}
