//! Ball holding: a robot must leave enough open space around the ball (2010 rule book, section 4.6; 2025 rule book, section 4.8). A robot
//! holds the ball if the ball's centre is within the convex hull of its body on the ground, which then covers more than half of the ball.
//! The ball is put back where it was.

use bevy::prelude::*;

use super::areas::{feet, in_area};
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::Evidence;
use crate::robot::body::{Body, BodyBox};

/// The number of cycles for which the robot has held the ball, including this one. Released cycles are subtracted: the rule asks
/// for a release about as long as the hold.
pub fn advance(cycles: u64, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> u64 {
    if holds_ball(snapshot, robot) { cycles + 1 } else { cycles.saturating_sub(1) }
}

fn holds_ball(snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    snapshot.ball.is_some_and(|ball| {
        let place = robot.pose.inverse_transform_point(ball.position);
        place.length_squared() < 1.0 && is_in_hull(&robot.bounds, place)
    })
}

/// Whether `place`, robot frame, is within the convex hull of the robot's two boxes, seen from above.
fn is_in_hull(bounds: &Body, place: Vec2) -> bool {
    // Both boxes are symmetric about the x axis, and so is the hull: its half above the axis decides.
    let corners = |part: &BodyBox| part.x_m.map(|x| Vec2::new(x, part.half_width_m));
    let [a, b] = corners(&bounds.torso);
    let [c, d] = corners(&bounds.base);
    let corners = [a, b, c, d];
    let place = Vec2::new(place.x, place.y.abs());
    // The hull's edge is the highest of the chords between two corners.
    corners.iter().any(|left| {
        corners.iter().any(|right| {
            let spans = left.x < right.x && left.x <= place.x && place.x <= right.x;
            spans && place.y <= left.y + (place.x - left.x) / (right.x - left.x) * (right.y - left.y)
        })
    })
}

/// The evidence against a robot that has held the ball for too long.
pub fn judge(cycles: u64, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence> {
    let own_end = snapshot.game.own_end(robot.id.team);
    let area = snapshot.pitch.penalty_area;
    let keeper_at_home = snapshot.game.is_goalkeeper(robot.id)
        && feet(robot).iter().any(|foot| in_area(snapshot.pitch, area, own_end, *foot));
    let limit = if keeper_at_home { snapshot.rules.keeper_ball_holding_s } else { snapshot.rules.ball_holding_s };
    (cycles >= snapshot.cycles(limit) && holds_ball(snapshot, robot)).then(|| {
        snapshot
            .evidence_against("A robot may not cover more than half of the ball for long.", robot)
            .with_measurement("s of holding", snapshot.seconds(cycles), limit)
            .otherwise("It had to release the ball in time.")
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::events::MatchEvent;
    use crate::geometry::Pose;
    use crate::team::{RobotId, Team};

    #[test]
    fn a_ball_that_was_held_is_put_back_even_from_the_goal() {
        let blue2 = RobotId::new(Team::Blue, 2);
        let mut situation = MatchFixture::three_a_side()
            .robot_at(blue2, Pose::new(2.86, 0.0, 0.0))
            .ball_rolled([2.9, 0.0], [2.9, 0.0])
            .touched_by(blue2);
        (situation.rules.ball_holding, situation.rules.ball_holding_s) = (true, 1.0);
        let penalised = (0..60).find_map(|_| {
            let decided = situation.pass();
            let goal = decided.events.iter().any(|event| matches!(event, MatchEvent::Goal { .. }));
            assert!(!goal);
            decided.robots[1].penalty.is_active().then_some(decided.ball)
        });
        assert_eq!(penalised, Some(Some(Vec2::new(2.9, 0.0))));
    }
}
