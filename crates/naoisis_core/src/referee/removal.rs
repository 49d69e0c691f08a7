//! The positions at which penalised robots wait, and return.

use core::f32::consts::{FRAC_PI_2, PI};

use bevy::prelude::*;

use super::areas::{feet, in_area, penalty_mark};
use super::placing::Occupied;
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::ReturnPlace;
use crate::geometry::Pose;
use crate::pitch::{End, Pitch};
use crate::robot::body::Body;

/// Distance of a waiting robot from the side line, m (2025 rule book).
const WAITING_DISTANCE: f32 = 0.5;
/// Distance between the positions along a side line that are tried, m: wider robots occupy every second one.
const PLACE_DISTANCE: f32 = 0.35;
/// Number of rows of positions where penalised robots wait: enough for all jersey numbers.
const WAITING_ROWS: u32 = 64;

/// The pose at which a robot that was removed from `position` waits: beyond the side line nearest to that position, level with the robot's
/// own penalty mark, at the next free position. The robot faces away from the pitch (2010), or towards it (2025).
pub fn waiting_pose(
    pitch: &Pitch,
    return_place: ReturnPlace,
    own_end: End,
    position: Vec2,
    bounds: &Body,
    waiting: &Occupied,
) -> Pose {
    let side = side_of(position.y);
    let faces_pitch = return_place == ReturnPlace::PenaltyMark;
    let heading = if faces_pitch { -side } else { side } * FRAC_PI_2;
    let y = side * (pitch.half_width() + WAITING_DISTANCE.min(pitch.border_m));
    let mark = penalty_mark(pitch, own_end).x;
    // First towards the halfway line, then beyond the mark: always in the robot's own half.
    let inwards = (mark.abs() / PLACE_DISTANCE) as u32;
    let steps = (0..=inwards).map(|step| mark - own_end.sign() * step as f32 * PLACE_DISTANCE);
    let outwards = (1..=8).map(|step| mark + own_end.sign() * step as f32 * PLACE_DISTANCE);
    let along = steps.chain(outwards);
    (0..WAITING_ROWS)
        .flat_map(|row| {
            let y = y + side * row as f32 * PLACE_DISTANCE;
            along.clone().map(move |x| Pose::new(x, y, heading))
        })
        .find(|pose| waiting.admits_robot(*pose, bounds))
        .unwrap_or(Pose::new(mark, y, heading))
}

/// The pose at which a robot returns: at the halfway line, or by the rules of 2025 at its waiting position.
pub(crate) fn return_pose(
    snapshot: &MatchSnapshot,
    own_end: End,
    waiting: Pose,
    bounds: &Body,
    occupied: &Occupied,
) -> Pose {
    match snapshot.rules.return_place {
        ReturnPlace::HalfwayLine => halfway_pose(snapshot, own_end, bounds, occupied),
        ReturnPlace::PenaltyMark => occupied.free_pose(waiting, bounds),
    }
}

/// The pose on the halfway line at the side line farther from the ball, facing the opposite side line. If it is occupied, at the nearest
/// free position along the side line, preferably away from the ball (2010 rule book, section 4.3).
pub fn halfway_pose(snapshot: &MatchSnapshot, own_end: End, bounds: &Body, occupied: &Occupied) -> Pose {
    let pitch = snapshot.pitch;
    let ball = snapshot.ball.map_or(Vec2::ZERO, |ball| ball.position);
    let side = -side_of(ball.y);
    let away = if ball.x == 0.0 { own_end.sign() } else { -ball.x.signum() };
    let steps = (pitch.half_length() / PLACE_DISTANCE) as u32;
    let along = |direction: f32| (1..=steps).map(move |step| direction * step as f32 * PLACE_DISTANCE);
    let places = core::iter::once(0.0).chain(along(away)).chain(along(-away));
    let wanted = |side: f32, x: f32| Pose::new(x, side * pitch.half_width(), -side * FRAC_PI_2);
    let free = |pose: &Pose| occupied.admits_robot(*pose, bounds);
    places
        .clone()
        .map(|x| wanted(side, x))
        .find(free)
        .or_else(|| places.map(|x| wanted(-side, x)).find(free))
        .unwrap_or_else(|| occupied.free_pose(wanted(side, 0.0), bounds))
}

/// The pose to which a goalkeeper that is stuck at the ball in its own penalty area is moved: on its penalty mark, facing its goal (2010
/// rule book, section 3.10). `None` for any other robot.
pub(crate) fn stuck_keeper_pose(snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Pose> {
    let own_end = snapshot.game.own_end(robot.id.team);
    let area = snapshot.pitch.penalty_area;
    let at_home = feet(robot).iter().all(|foot| in_area(snapshot.pitch, area, own_end, *foot));
    let heading = if own_end == End::PositiveX { 0.0 } else { PI };
    let position = penalty_mark(snapshot.pitch, own_end);
    (snapshot.game.is_goalkeeper(robot.id) && at_home).then_some(Pose { position, heading })
}

/// The side of the pitch as the sign of y: -1 or +1.
fn side_of(y: f32) -> f32 {
    if y < 0.0 { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::events::MatchEvent;
    use crate::game::{ActivePenalty, Penalty, PenaltyReason};
    use crate::team::{RobotId, Team};
    use approx::assert_abs_diff_eq;

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
    const BLUE3: RobotId = RobotId::new(Team::Blue, 3);
    const PINK2: RobotId = RobotId::new(Team::Pink, 2);

    /// Blue 2 has walked into pink 2 at this position.
    fn collision_at(x: f32, y: f32) -> MatchFixture {
        MatchFixture::three_a_side()
            .robot_at(BLUE2, Pose::new(x, y, 0.0))
            .robot_at(PINK2, Pose::new(x + 0.1, y, 0.0))
            .walking(BLUE2, [0.2, 0.0])
            .contact(BLUE2, PINK2)
    }

    #[test]
    fn a_penalised_robot_waits_beyond_the_nearer_side_line_in_its_own_half() {
        let pose = collision_at(1.0, -0.5).pass().robots[1].pose;
        // Level with the penalty mark, 3 - 1.8 = 1.2 m from the halfway line, 0.5 m beyond the side line; its back
        // to the pitch.
        assert_abs_diff_eq!(pose.position, Vec2::new(-1.2, -2.5), epsilon = 1e-5);
        assert_abs_diff_eq!(pose.heading, -FRAC_PI_2, epsilon = 1e-5);
    }

    #[test]
    fn two_that_wait_do_not_stand_in_each_other() {
        let mut situation = collision_at(1.0, 0.5);
        situation.pass();
        let mut situation = MatchFixture { contacts: vec![], ..situation }
            .robot_at(BLUE3, Pose::new(0.0, 1.0, 0.0))
            .walking(BLUE3, [0.2, 0.0])
            .contact(BLUE3, PINK2);
        let robots = situation.pass().robots;
        assert!(robots[1].penalty.is_active() && robots[2].penalty.is_active());
        assert_abs_diff_eq!(robots[2].pose.position, Vec2::new(-0.85, 2.5), epsilon = 1e-5);
    }

    /// The pose at which blue 2 returns, with the ball at this position.
    fn comes_back(ball: [f32; 2], change: impl FnOnce(MatchFixture) -> MatchFixture) -> Pose {
        let mut situation = MatchFixture::three_a_side().ball_rolled(ball, ball);
        situation.robot_mut(BLUE2).penalty =
            Penalty(Some(ActivePenalty { reason: PenaltyReason::Pushing, cycles_left: 1 }));
        let decided = change(situation).decide();
        assert!(matches!(decided.events[0], MatchEvent::PenaltyOver { robot: BLUE2, .. }));
        assert!(!decided.robots[1].penalty.is_active());
        decided.robots[1].pose
    }

    #[test]
    fn it_comes_back_at_the_halfway_line_on_the_side_away_from_the_ball() {
        let pose = comes_back([1.0, 0.5], |situation| situation);
        assert_abs_diff_eq!(pose.position, Vec2::new(0.0, -2.0), epsilon = 1e-5);
        assert_abs_diff_eq!(pose.heading, FRAC_PI_2, epsilon = 1e-5);
        assert_abs_diff_eq!(comes_back([1.0, -0.5], |situation| situation).position.y, 2.0, epsilon = 1e-5);
    }

    #[test]
    fn where_somebody_stands_it_comes_back_beside_rather_away_from_the_ball() {
        let taken = |situation: MatchFixture| situation.robot_at(PINK2, Pose::new(0.0, -2.0, 0.0));
        assert_abs_diff_eq!(comes_back([1.0, 0.5], taken).position, Vec2::new(-0.35, -2.0), epsilon = 1e-5);
        assert_abs_diff_eq!(comes_back([-1.0, 0.5], taken).position, Vec2::new(0.35, -2.0), epsilon = 1e-5);
    }

    #[test]
    fn by_the_rules_of_2025_it_comes_back_where_it_waited() {
        let waiting = Pose::new(-1.2, 2.5, -FRAC_PI_2);
        let pose = comes_back([1.0, 0.5], |situation| {
            let mut situation = situation.robot_at(BLUE2, waiting);
            situation.rules.return_place = ReturnPlace::PenaltyMark;
            situation
        });
        assert_eq!(pose, waiting);
    }

    #[test]
    fn a_penalty_lasts_its_time_of_play_and_does_not_count_when_play_is_stopped() {
        let mut situation = collision_at(1.0, 0.5);
        assert!(
            matches!(situation.pass().events[0], MatchEvent::Penalty { until_s, .. } if (until_s - 33.333).abs() < 1e-2)
        );
        situation.contacts.clear();
        let back = (1..2000)
            .find(|_| situation.pass().events.iter().any(|event| matches!(event, MatchEvent::PenaltyOver { .. })));
        // 30 s of 1/30 s.
        assert_eq!(back, Some(900));
    }

    #[test]
    fn at_half_time_penalties_are_over_and_after_a_goal_where_the_rules_say_so() {
        let penalised_after = |change: fn(&mut MatchFixture)| {
            let mut situation = collision_at(1.0, 0.5);
            situation.pass();
            situation.contacts.clear();
            change(&mut situation);
            situation.pass().robots[1].penalty.is_active()
        };
        assert!(!penalised_after(|situation| situation.game.cycles_left = Some(1)));
        let goal = |situation: &mut MatchFixture| situation.path = vec![Vec2::new(2.9, 0.0), Vec2::new(3.2, 0.0)];
        assert!(penalised_after(goal));
        assert!(!penalised_after(|situation| {
            situation.rules.penalties_end_at_kick_off = true;
            situation.path = vec![Vec2::new(2.9, 0.0), Vec2::new(3.2, 0.0)];
        }));
    }
}
