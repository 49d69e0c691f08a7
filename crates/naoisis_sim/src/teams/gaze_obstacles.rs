//! Looking for opponents on the way and near by. Most collisions are with opponents that were not seen, because the player walked
//! sideways or backwards while it looked at the ball.

use bevy::prelude::*;

use super::gaze_history::GazeHistory;
use super::giving_way::HARMLESS_MPS;
use super::obstacles::{OBSTACLE_MEMORY_S, ROBOT_CLEARANCE_M};
use super::player::Player;
use naoisis_core::geometry::{angle_of, unit};
use naoisis_core::robot::motion::WalkCommand;

/// The player looks at the ball for the first [`BALL_S`] of each such period, s.
const EVERY_S: f32 = 1.5;
/// How long it looks at the ball in each period, s.
const BALL_S: f32 = 0.5;
/// The direction of the walk is checked again after this time, s.
const WAY_S: f32 = 1.2;
/// The directions beside the way are checked again after this time, s.
const FLANKS_S: f32 = 3.0;
/// The directions beside the way, radians.
const FLANKS: [f32; 4] = [0.6, -0.6, 1.2, -1.2];
/// An opponent near by is checked again after this time, s.
const NEIGHBOUR_S: f32 = 0.7;
/// An opponent is near if the player could reach it within this time, s.
const NEAR_S: f32 = 2.2;
/// The player looks only at a ball that is nearer than this, m, for the feet of a NAO. The distance grows with the length of the feet.
const AT_FEET_M: f32 = 0.4;
/// How far ahead the player looks: the time to walk there, s, and the least distance, m.
const AHEAD: (f32, f32) = (3.0, 0.8);

/// Returns a place (m, robot frame) that a player with this `walk` should look at now: on its way, at an opponent, or beside its way.
/// `None` while nothing is due.
pub fn place_to_check(player: &Player, looked: &GazeHistory, walk: &WalkCommand) -> Option<Vec2> {
    let now_s = player.status.time_s;
    let is_harmless = walk.translation().length() < HARMLESS_MPS * player.period;
    if is_harmless || now_s.rem_euclid(EVERY_S) < BALL_S || !player.head.turns() {
        return None;
    }
    let at_feet_m = AT_FEET_M + player.longer_than_nao_m();
    if player.ball().is_some_and(|ball| ball.position_m.distance(player.position()) < at_feet_m) {
        return None;
    }
    let reach = player.head.reach_cosine();
    let can_see = |place: Vec2| place.x > reach * place.length();
    let way = angle_of(walk.translation());
    let (ahead_s, least_m) = AHEAD;
    let ahead_m = (ahead_s * player.motion.max_linear_mps).max(least_m);
    let unseen_for = |after_s: f32, aside: f32| {
        let is_old = looked.age_s(player.pose().heading + way + aside, now_s) > after_s;
        is_old.then(|| ahead_m * unit(way + aside)).filter(|&place| can_see(place))
    };
    unseen_for(WAY_S, 0.0)
        .or_else(|| neighbour(player).filter(|place| can_see(*place)))
        .or_else(|| FLANKS.into_iter().find_map(|aside| unseen_for(FLANKS_S, aside)))
}

/// The believed place (m, robot frame) of the opponent near by that was not seen for the longest time.
fn neighbour(player: &Player) -> Option<Vec2> {
    let near_m = ROBOT_CLEARANCE_M + 2.0 * player.wider_than_nao_m() + NEAR_S * player.motion.max_linear_mps;
    let opponents = player.belief.opponents.iter();
    let old = opponents.filter(|other| (NEIGHBOUR_S..OBSTACLE_MEMORY_S).contains(&other.age_s));
    old.filter(|other| other.position_m.distance_squared(player.position()) < near_m * near_m)
        .max_by(|first, second| first.age_s.total_cmp(&second.age_s))
        .map(|other| player.in_robot(other.position_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::gaze_history::{DIRECTIONS, HALF_VIEW};
    use crate::teams::player::tests::PlayerFixture;
    use core::f32::consts::TAU;
    use naoisis_core::geometry::{Pose, wrap_angle};
    use naoisis_sensing::belief::RobotBelief;

    const PERIOD: f32 = 1.0 / 30.0;

    /// Returns the yaw of each look away from the ball, cycle by cycle, of a player whose head moves at once; `None` while it watches the
    /// ball straight ahead.
    fn looks(situation: &mut PlayerFixture, walk: WalkCommand, seconds: f32) -> Vec<Option<f32>> {
        let mut looked = GazeHistory::default();
        let mut gaze = 0.0;
        let cycles = (seconds / PERIOD) as usize;
        // The robot has stood for long.
        (1..=cycles)
            .map(|cycle| {
                situation.status.time_s = 99.0 + cycle as f32 * PERIOD;
                looked.note(situation.belief.pose.heading + gaze, situation.status.time_s);
                let angle = place_to_check(&situation.player(), &looked, &walk).map(angle_of);
                gaze = angle.unwrap_or(0.0);
                angle
            })
            .collect()
    }

    fn at(heading: f32) -> PlayerFixture {
        PlayerFixture::new(Pose::new(0.3, -0.2, heading), Vec2::new(2.0, 0.0))
    }

    /// Returns whether the player looks to `angle` (radians) at least every 1.5 s.
    fn looks_often_to(looks: &[Option<f32>], angle: f32) -> bool {
        let is_there = |look: &Option<f32>| look.is_some_and(|look| wrap_angle(look - angle).abs() < HALF_VIEW);
        looks.chunks(60).all(|two_seconds| two_seconds.iter().any(is_there))
    }

    #[test]
    fn a_player_that_walks_sideways_looks_there_and_has_the_ball_in_view_most_of_the_time() {
        for heading in [0.0, 1.0, -3.0] {
            for side in [1.0, -1.0] {
                let aside = WalkCommand::new(-0.001, side * 0.004, 0.0);
                let looks = looks(&mut at(heading), aside, 12.0);
                assert!(looks_often_to(&looks, side * 1.8), "heading {heading}: {looks:?}");
                let at_ball = looks.iter().filter(|look| look.is_none()).count();
                assert!(at_ball > looks.len() / 2, "heading {heading}: {at_ball} of {}", looks.len());
            }
        }
    }

    #[test]
    fn a_player_that_walks_ahead_looks_beside_its_way_from_time_to_time() {
        let looks = looks(&mut at(0.5), WalkCommand::new(0.006, 0.0, 0.0), 12.0);
        for side in [1.0, -1.0] {
            let there = looks.iter().flatten().filter(|look| side * **look > HALF_VIEW).count();
            // Once or twice in 3 s each: a cycle is enough for a head that moves at once.
            assert!((3..=16).contains(&there), "{there} of {}", looks.len());
        }
    }

    #[test]
    fn a_player_that_stands_or_cannot_see_there_watches_the_ball() {
        let standing = looks(&mut at(0.0), WalkCommand::default(), 6.0);
        assert!(standing.iter().all(Option::is_none), "{standing:?}");
        // A NAO's head does not reach straight back, so the player looks to both sides of its way instead.
        let back = looks(&mut at(0.0), WalkCommand::new(-0.004, 0.0, 0.0), 6.0);
        assert!(back.iter().flatten().all(|look| look.abs() < 2.6), "{back:?}");
    }

    #[test]
    fn a_ball_at_the_feet_is_not_let_out_of_sight() {
        let aside = WalkCommand::new(0.0, 0.004, 0.0);
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::new(0.3, 0.0));
        assert!(looks(&mut situation, aside, 6.0).iter().all(Option::is_none));
        situation.belief.ball.as_mut().unwrap().position_m.x = 0.5;
        assert!(looks_often_to(&looks(&mut situation, aside, 6.0), core::f32::consts::FRAC_PI_2));
    }

    #[test]
    fn an_opponent_that_is_near_is_looked_at_again() {
        let mut situation = at(0.0);
        let ahead = WalkCommand::new(0.006, 0.0, 0.0);
        let opponent = |y: f32, age_s: f32| RobotBelief {
            id: None,
            position_m: situation.belief.pose.position + Vec2::new(0.0, y),
            covariance: [0.0; 3],
            age_s,
        };
        let (near, far, fresh) = (opponent(0.6, 1.0), opponent(2.0, 2.0), opponent(-0.6, 0.2));
        // In this 1.5 s period the time for the ball is over, and the player has just looked all around.
        situation.status.time_s = 66.0 * EVERY_S + BALL_S + 0.1;
        let mut looked = GazeHistory::default();
        for direction in 0..DIRECTIONS {
            looked.note(direction as f32 * TAU / DIRECTIONS as f32, situation.status.time_s);
        }
        let mut checks = |opponents: &[RobotBelief]| {
            situation.belief.opponents = opponents.to_vec();
            place_to_check(&situation.player(), &looked, &ahead)
        };
        assert_eq!(checks(&[far, fresh]), None);
        let place = checks(&[far, near, fresh]).unwrap();
        assert!(place.distance(Vec2::new(0.0, 0.6)) < 1e-5, "{place}");
    }
}
