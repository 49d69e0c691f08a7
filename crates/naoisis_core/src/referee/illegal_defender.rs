//! Illegal defenders: limits of the robots in front of their own goal (2010 rule book, section 4.13; 2025 rule book, section 4.4.2).

use super::areas::{feet, in_area, touches_area};
use super::memory::RobotMemory;
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::{DefenderLimit, Evidence};

/// Whether a robot counts as being in the area with limited defenders.
pub(crate) fn is_in_area(snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    match snapshot.rules.defender_limit {
        DefenderLimit::KeeperOnly => {
            let (pitch, area) = (snapshot.pitch, snapshot.pitch.penalty_area);
            let own_end = snapshot.game.own_end(robot.id.team);
            // Most robots are far from the area, so that their feet are not needed.
            let depth = pitch.half_length() - own_end.sign() * robot.pose.position.x;
            let is_near = depth < area.depth_m + pitch.line_width_m + robot.bounds.foot_y_m;
            is_near && feet(robot).iter().all(|foot| in_area(pitch, area, own_end, *foot))
        }
        DefenderLimit::AtMost(_) => is_in_goal_area(snapshot, robot),
    }
}

/// Whether any part of a robot's base touches its own goal area, or its penalty area on a pitch without goal areas.
pub(crate) fn is_in_goal_area(snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    let area = snapshot.pitch.goal_area.unwrap_or(snapshot.pitch.penalty_area);
    let own_end = snapshot.game.own_end(robot.id.team);
    touches_area(snapshot.pitch, area, own_end, robot)
}

/// The number of cycles for which the robot has been in the area, including this one.
pub fn advance(cycles_in_area: u64, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> u64 {
    if is_in_area(snapshot, robot) { cycles_in_area + 1 } else { 0 }
}

/// The evidence against the robot with `index`, if it is an illegal defender. If the rules allow a number of robots, the last ones to enter
/// are illegal. `records` must be up to date for all robots.
pub fn judge(records: &[RobotMemory], snapshot: &MatchSnapshot, index: usize) -> Option<Evidence> {
    let (robot, own) = (&snapshot.robots[index], &records[index]);
    // The reaction time of the referee must have passed with too many robots in the area.
    if own.cycles_in_area <= snapshot.cycles(snapshot.rules.illegal_defender_s) {
        return None;
    }
    let evidence = |rule| {
        snapshot.evidence_against(rule, robot).with_measurement(
            "s in the area",
            snapshot.seconds(own.cycles_in_area),
            snapshot.rules.illegal_defender_s,
        )
    };
    match snapshot.rules.defender_limit {
        DefenderLimit::KeeperOnly => (!snapshot.game.is_goalkeeper(robot.id)).then(|| {
            evidence("Only the keeper may have both feet in its own penalty area.")
                .otherwise("It had to keep a foot outside the area, or leave it at once.")
        }),
        DefenderLimit::AtMost(most) => {
            let before = records.iter().zip(snapshot.robots).filter(|(record, other)| {
                other.is_present()
                    && other.id.team == robot.id.team
                    && record.cycles_in_area > 0
                    && (record.cycles_in_area, robot.id) > (own.cycles_in_area, other.id)
            });
            (before.count() >= usize::from(most)).then(|| {
                evidence("Only so many robots of a team may be in their own goal area at a time.")
                    .otherwise(format!("At most {most} robots, with those that came before it, had to be there."))
            })
        }
    }
}
