//! Where to stand for a kick, and which kick to prepare.

use bevy::prelude::*;
use core::f32::consts::FRAC_PI_2;

use super::aiming::Aim;
use super::obstacles::Obstacles;
use super::walking::{least_walking_time_s, walking_time_s};
use naoisis_core::geometry::{Pose, angle_of, unrotate};
use naoisis_core::kick_geometry::{KickGeometry, KickType};
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::robot::motion::MotionSettings;

/// A kick that can be aimed is prepared for at most this share of its greatest angle: the rest is a reserve for errors.
pub(super) const AIMED_SHARE: f32 = 0.7;
/// The advantage of the type of kick chosen before, s.
const KICK_PREFERENCE_S: f32 = 0.5;
/// The cost of a side kick, which is weaker, s.
const SIDE_KICK_COST_S: f32 = 0.6;
/// The cost of a place next to which another robot stands, s.
const OCCUPIED_COST_S: f32 = 2.5;
/// A place is taken if it is in the circle of an obstacle, reduced to this share.
const OCCUPIED_SHARE: f32 = 0.8;

/// Returns the position, m, and the direction to face for a kick that sends a ball at `ball` in `direction` (team frame). For a kick that
/// can be aimed, the direction to face is the possible one nearest to the way from `own` to the ball.
pub fn stand_for(kick: &KickGeometry, ball: Vec2, direction: Vec2, own: Vec2) -> (Vec2, Vec2) {
    let most = AIMED_SHARE * kick.aims_within();
    let wanted = if most > 0.0 { angle_of(unrotate(ball - own, direction)).clamp(-most, most) } else { 0.0 };
    let facing = unrotate(kick.leaves(kick.best_m, wanted), direction);
    (ball - facing.rotate(kick.best_m), facing)
}

/// A kick to prepare.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct KickPlan {
    /// The kind of kick, and with which foot.
    pub kick_type: KickType,
    /// Where to stand, m, team frame.
    pub position: Vec2,
    /// Where to face, unit vector, team frame.
    pub facing: Vec2,
}

impl KickPlan {
    /// Chooses the kick that can be made soonest; `None` for a robot without kicks.
    pub fn choose(
        ball: Vec2,
        aim: &Aim,
        own: Pose,
        obstacles: &Obstacles,
        (kicks, motion): (&KickSettings, &MotionSettings),
        previous: Option<KickType>,
    ) -> Option<Self> {
        let forward = own.forward();
        let turns_radps = 1.4 * (motion.max_angular / FRAC_PI_2).max(0.1);
        let furthest_m = kicks.types().map(|kick| kicks.max_distance_m(kick)).fold(0.0, f32::max);
        let mut best: Option<(f32, Self)> = None;
        for kick_type in kicks.types() {
            let Some(geometry) = kicks.geometry(kick_type) else { continue };
            let (position, facing) = stand_for(&geometry, ball, aim.direction, own.position);
            let way = position - own.position;
            // The chord of the angle to turn by is near enough to it.
            let turn_s = (facing - forward).length() / turns_radps;
            let passes_ball =
                way.dot(ball - own.position) > 0.0 && way.length_squared() > ball.distance_squared(own.position);
            let speed_mps = motion.max_linear_mps.max(0.01);
            let detour_s = if passes_ball {
                let ball_side = -way.normalize_or_zero().perp_dot(ball - own.position).abs();
                0.8 * (0.25 + ball_side).max(0.0) / speed_mps
            } else {
                0.0
            };
            let is_side_kick = kick_type.is_side_kick();
            let reach_m = kicks.max_distance_m(kick_type);
            let is_weak = is_side_kick || reach_m < furthest_m;
            let falls_short = is_weak && aim.is_shot && aim.distance_m > 0.7 * reach_m;
            let cost_of = |walk_s: f32| {
                let cost_s = walk_s + detour_s + if is_side_kick { SIDE_KICK_COST_S } else { 0.0 };
                cost_s + if falls_short { 5.0 } else { 0.0 }
            };
            let advantage_s = if previous == Some(kick_type) { KICK_PREFERENCE_S } else { 0.0 };
            // The first of equal plans is the best. Whether the place is taken is not checked for a kick that is worse already, and the
            // angles are not computed for one that is too far away.
            let is_worse = |cost_s: f32| best.is_some_and(|(least_s, _)| cost_s - advantage_s >= least_s);
            let mut cost_s = cost_of(match &motion.gait {
                Some(_) if is_worse(cost_of(least_walking_time_s(forward, way, facing, motion))) => continue,
                Some(gait) => walking_time_s(forward, way, facing, gait, motion),
                None => (way.length() / speed_mps).max(turn_s) + 0.4 * turn_s,
            });
            if is_worse(cost_s) {
                continue;
            }
            // The place itself, and the one where the last stretch begins, must be free.
            let taken = obstacles.iter().any(|obstacle| {
                let least = OCCUPIED_SHARE * obstacle.radius_m;
                [position, position - facing * 0.09]
                    .into_iter()
                    .any(|place| place.distance_squared(obstacle.centre) < least * least)
            });
            if taken {
                cost_s += OCCUPIED_COST_S;
            }
            if !is_worse(cost_s) {
                best = Some((cost_s - advantage_s, Self { kick_type, position, facing }));
            }
        }
        best.map(|(_, plan)| plan)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use naoisis_core::geometry::unit;

    #[test]
    fn a_kick_from_the_planned_place_sends_the_ball_in_the_planned_direction() {
        let ball = Vec2::new(0.4, -0.3);
        for kick_type in KickType::ALL {
            for angle in [-2.5, -1.0, 0.0, 0.4, 3.0] {
                let direction = unit(angle);
                let kick = KickGeometry::of_paper(kick_type).unwrap();
                let (position, facing) = stand_for(&kick, ball, direction, Vec2::ZERO);
                let in_robot = unrotate(facing, ball - position);
                assert!(kick_type.admissible_rectangle().contains(in_robot));
                let strike = KickSettings::default().strike(kick_type, in_robot, 0.0).unwrap();
                assert!(!strike.reduced);
                assert_abs_diff_eq!(facing.rotate(strike.direction), direction, epsilon = 1e-5);
                // Far enough away for the toes, at x = 11 cm, not to touch a ball of 3 cm radius.
                assert!(in_robot.x > 0.14);
            }
        }
    }

    #[test]
    fn the_foot_that_is_nearer_is_chosen_and_a_side_kick_when_that_spares_the_turn() {
        let ball = Vec2::new(1.0, 0.0);
        let choose = |own: Pose, direction: Vec2| {
            let aim = Aim { direction, distance_m: 1.0, tolerance: 0.2, is_shot: false, dribbles: false };
            KickPlan::choose(
                ball,
                &aim,
                own,
                &Obstacles::default(),
                (&KickSettings::default(), &MotionSettings::default()),
                None,
            )
            .unwrap()
            .kick_type
        };
        assert_eq!(choose(Pose::new(0.7, -0.1, 0.0), Vec2::X), KickType::LeftStraight);
        assert_eq!(choose(Pose::new(0.7, 0.1, 0.0), Vec2::X), KickType::RightStraight);
        assert_eq!(choose(Pose::new(0.8, 0.0, 0.0), Vec2::Y), KickType::RightSide);
        assert_eq!(choose(Pose::new(0.8, 0.0, 0.0), -Vec2::Y), KickType::LeftSide);
    }

    #[test]
    fn a_place_taken_by_another_robot_is_avoided() {
        let ball = Vec2::new(1.0, 0.0);
        let aim = Aim { direction: Vec2::X, distance_m: 1.0, tolerance: 0.2, is_shot: false, dribbles: false };
        let own = Pose::new(0.7, -0.1, 0.0);
        let mut obstacles = Obstacles::default();
        obstacles.add(Vec2::new(0.8, -0.25), 0.36);
        let plan =
            KickPlan::choose(ball, &aim, own, &obstacles, (&KickSettings::default(), &MotionSettings::default()), None)
                .unwrap();
        assert!(plan.position.distance(Vec2::new(0.8, -0.25)) > 0.2, "{plan:?}");
    }
}
