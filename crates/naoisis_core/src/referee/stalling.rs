//! Stalling: a robot that stands near the ball for a long time keeps others from the ball (paper, section 3.4).

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::Evidence;
use crate::geometry::{Pose, wrap_angle};

/// Distance from which a robot counts as having moved, m.
const MOVED_M: f32 = 0.05;
/// Angle from which a robot counts as having turned, radians (15 degrees).
const TURNED: f32 = 0.262;

/// A robot that stands near the ball.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct Stall {
    /// The pose at which it stopped.
    pub anchor: Pose,
    /// Cycles for which the robot has stood there, near the ball.
    pub cycles: u64,
}

/// The stay of a robot near the ball, including this cycle; `None` if it is not near, or has just struck the ball.
pub fn advance(stall: Option<Stall>, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Stall> {
    let ball = snapshot.ball?;
    let near = robot.pose.position.distance(ball.position) <= snapshot.rules.stall_radius_m;
    let struck_now = snapshot
        .last_touch
        .is_some_and(|touch| touch.kick && touch.robot == robot.id && touch.cycle == snapshot.clock.cycle);
    if !near || struck_now || !robot.posture.is_upright() {
        return None;
    }
    let stands = |stall: &Stall| {
        stall.anchor.position.distance(robot.pose.position) <= MOVED_M
            && wrap_angle(stall.anchor.heading - robot.pose.heading).abs() <= TURNED
    };
    Some(match stall.filter(stands) {
        Some(stall) => Stall { cycles: stall.cycles + 1, ..stall },
        None => Stall { anchor: robot.pose, cycles: 1 },
    })
}

/// The evidence against a robot that has stood near the ball for too long.
pub fn judge(stall: &Stall, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence> {
    let limit = snapshot.cycles(snapshot.rules.stall_s);
    (stall.cycles >= limit).then(|| {
        snapshot
            .evidence_against(
                "A robot that does not move for a long time while it is close to the ball is penalised.",
                robot,
            )
            .with_measurement("s without moving", snapshot.seconds(stall.cycles), snapshot.rules.stall_s)
            .otherwise(format!(
                "It had to move by more than {MOVED_M} m, or leave the {} m around the ball, in time.",
                snapshot.rules.stall_radius_m
            ))
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use crate::events::MatchEvent;
    use crate::game::PenaltyReason;
    use crate::geometry::Pose;
    use crate::team::{RobotId, Team};

    const BLUE3: RobotId = RobotId::new(Team::Blue, 3);

    /// Blue 3 stands in front of the ball at this distance, with no other robot near the ball.
    fn standing_at(distance: f32) -> MatchFixture {
        MatchFixture::three_a_side()
            .robot_at(BLUE3, Pose::new(1.0 - distance, 1.0, 0.0))
            .ball_rolled([1.0, 1.0], [1.0, 1.0])
    }

    /// The first cycle, from 1, in which the robot is penalised for stalling.
    fn penalised_in(
        situation: &mut MatchFixture,
        cycles: u32,
        mut change: impl FnMut(u32, &mut MatchFixture),
    ) -> Option<u32> {
        (1..=cycles).find(|cycle| {
            change(*cycle, situation);
            situation
                .pass()
                .events
                .iter()
                .any(|event| matches!(event, MatchEvent::Penalty { robot: BLUE3, reason: PenaltyReason::Stalling, .. }))
        })
    }

    #[test]
    fn after_its_time_near_the_ball_a_standing_robot_is_penalised() {
        // 15 s of 1/30 s; the radius is 0.5 m.
        assert_eq!(penalised_in(&mut standing_at(0.499), 500, |_, _| ()), Some(450));
        assert_eq!(penalised_in(&mut standing_at(0.501), 500, |_, _| ()), None);
    }

    #[test]
    fn moving_turning_or_striking_the_ball_restarts_the_time() {
        let moved = |by: Pose| {
            penalised_in(&mut standing_at(0.4), 900, move |cycle, situation| {
                if cycle == 400 {
                    let robot = situation.robot_mut(BLUE3);
                    robot.pose = robot.pose.compose(by);
                }
            })
        };
        assert_eq!(moved(Pose::new(0.049, 0.0, 0.0)), Some(450));
        assert_eq!(moved(Pose::new(0.051, 0.0, 0.0)), Some(849));
        assert_eq!(moved(Pose::new(0.0, 0.0, 14.0_f32.to_radians())), Some(450));
        assert_eq!(moved(Pose::new(0.0, 0.0, 16.0_f32.to_radians())), Some(849));
        let struck = penalised_in(&mut standing_at(0.4), 900, |cycle, situation| {
            if cycle == 400 {
                *situation = situation.clone().touched_by(BLUE3);
                situation.memory.last_touch.as_mut().unwrap().cycle = situation.clock.cycle;
            }
        });
        assert_eq!(struck, Some(850));
    }

    #[test]
    fn the_time_is_not_saved_up_by_leaving() {
        let left = penalised_in(&mut standing_at(0.4), 900, |cycle, situation| {
            let x = if cycle == 400 { 2.0 } else { 1.0 };
            situation.path = vec![[x, 1.0].into(); 2];
        });
        assert_eq!(left, Some(850));
    }
}
