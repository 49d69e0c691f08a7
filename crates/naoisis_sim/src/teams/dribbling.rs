//! Dribbling: a player walks straight on into the ball, and its feet push the ball ahead, touch by touch.

use bevy::prelude::*;

use super::aiming::Aim;
use super::player::Player;
use super::worth::{Company, dribble_worth, is_first, standing, time_worth};
use naoisis_core::geometry::{angle_of, unit, unrotate};
use naoisis_core::robot::motion::WalkCommand;

/// The wanted distance between two touches, m. Slow robots touch the ball more often.
const TOUCH_M: f32 = 1.5;
/// The speed of a touched ball, as a multiple of the foot's: the restitution of balls is 0.4 to 0.5.
const BOUNCE: f32 = 1.4;
/// Directions that are considered, radians to the left of the opponents' goal.
const ANGLES: [f32; 5] = [0.0, 0.4, -0.4, 0.8, -0.8];
/// A ball is dribbled at least this far between two touches, m; robots that push it less far kick it.
const LEAST_TOUCH_M: f32 = 0.3;

/// Returns the walking speed at which the ball rolls about [`TOUCH_M`] after a touch, at most the greatest speed, m/s, and how far the ball
/// rolls then, m. `None` for a robot that does not dribble: one whose feet do not swing ahead of it, or that hardly moves the ball.
pub fn dribbling(player: &Player) -> Option<(f32, f32)> {
    let gait = player.motion.gait.as_ref().filter(|gait| gait.touch.foot_speed > 1.0)?;
    let multiple = BOUNCE * gait.touch.foot_speed;
    let speed_mps = (player.rolling.speed_for_distance(TOUCH_M) / multiple).min(player.motion.max_linear_mps);
    let rolls_m = player.rolling.distance(multiple * speed_mps);
    (rolls_m > LEAST_TOUCH_M).then_some((speed_mps, rolls_m))
}

/// Returns the ways in which the player could dribble a ball at `ball`: the aim, the place of the next touch, m, team frame, and the value, in
/// goals.
pub fn dribbles(player: &Player, company: Company, ball: Vec2) -> impl Iterator<Item = (Aim, Vec2, f32)> {
    let theirs_s = company.opponents_walk_s(player, ball);
    let contested = standing(player, ball, 0.5);
    let towards_goal = (player.opponent_goal() - ball).normalize_or(Vec2::X);
    dribbling(player).into_iter().flat_map(move |(speed_mps, rolls_m)| {
        ANGLES.into_iter().map(move |angle| {
            let place = ball + rolls_m * unit(angle).rotate(towards_goal);
            let aim = Aim { dribbles: true, ..Aim::at(ball, place) };
            let ready_s = ready_s(player, ball, aim.direction, speed_mps);
            let ready = is_first(player, ready_s, theirs_s);
            let follows_s = 2.0 * rolls_m / (speed_mps + player.motion.max_linear_mps);
            let value = ready * dribble_worth(player, company, [ball, place], follows_s) + (1.0 - ready) * contested;
            (aim, place, value - time_worth(player, ready_s))
        })
    })
}

/// The time until the player's foot touches the ball, s: it walks behind the ball, turns to `direction`, and walks on at `speed_mps`.
fn ready_s(player: &Player, ball: Vec2, direction: Vec2, speed_mps: f32) -> f32 {
    let clearance_m = player.ball_clearance_m();
    let way_m = player.position().distance(ball - direction * clearance_m);
    let turn = angle_of(unrotate(player.forward, direction)).abs();
    let stretch_m = (clearance_m - player.own_body.base.x_m[1] - player.ball_radius_m).max(0.0);
    way_m / player.motion.max_linear_mps.max(1e-3)
        + 0.5 * turn / player.motion.max_angular.max(0.1)
        + stretch_m / speed_mps
}

/// Returns the step of a player that walks on into a ball at `ball` to push it in `direction` (team frame): straight at the ball, so fast that
/// the touch is as strong as wanted. `None` if the ball does not lie ahead of the feet, or the player does not face `direction`.
pub fn walk_into(player: &Player, ball: Vec2, direction: Vec2) -> Option<WalkCommand> {
    /// The player walks on from this distance between toes and ball, m.
    const FROM_M: f32 = 0.8;
    /// The ball must be ahead of this share of the feet's width, and may be further aside by [`ASIDE`] times the distance.
    const WIDTH_SHARE: f32 = 0.7;
    const ASIDE: f32 = 0.25;
    /// The greatest angle between the facing and the direction, radians.
    const ALIGNED: f32 = 0.4;
    /// The turning speed for each radian that is missing, 1/s.
    const TURN_PER_S: f32 = 1.0;
    let (speed_mps, _) = dribbling(player)?;
    let gait = player.motion.gait.as_ref()?;
    let place = player.in_robot(ball);
    let to_touch_m = place.x - player.own_body.base.x_m[1] - player.ball_radius_m;
    let off = angle_of(unrotate(player.forward, direction));
    let is_ahead = place.x > 0.0
        && to_touch_m < FROM_M
        && place.y.abs() < WIDTH_SHARE * player.own_body.base.half_width_m + ASIDE * to_touch_m.max(0.0);
    if !is_ahead || off.abs() > ALIGNED {
        return None;
    }
    // As fast as it can be and still brake to the speed of the touch.
    let most_mps = (speed_mps * speed_mps + 2.0 * gait.acceleration_mps2 * to_touch_m.max(0.0)).sqrt();
    let wanted = place.normalize_or(Vec2::X) * most_mps.min(player.motion.max_linear_mps);
    let Vec3 { x, y, z } = gait.reachable(wanted.extend(TURN_PER_S * off), player.motion) * player.period;
    Some(WalkCommand { dx: x, dy: y, dtheta: z })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::passer::decide;
    use crate::teams::player::PlayerMemory;
    use crate::teams::player::tests::PlayerFixture;
    use approx::assert_abs_diff_eq;
    use naoisis_core::ball::Rolling;
    use naoisis_core::geometry::Pose;
    use naoisis_core::robot::gait::{BallTouch, Gait};
    use naoisis_sensing::belief::RobotBelief;

    fn with_feet(max_linear_mps: f32, foot_speed: f32) -> PlayerFixture {
        let mut situation = PlayerFixture::new(Pose::new(-0.25, 0.0, 0.0), Vec2::ZERO);
        situation.rolling = Rolling::ConstantMps2(0.35);
        situation.motion.max_linear_mps = max_linear_mps;
        let touch = BallTouch { foot_speed, direction_sd: 0.0 };
        situation.motion.gait = Some(Gait { touch, ..Gait::default() });
        situation
    }

    #[test]
    fn a_fast_robot_slows_down_for_the_ball_and_a_slow_one_pushes_it_as_far_as_it_can() {
        // 1.5 m at 0.35 m/s² need 1.025 m/s: the foot meets the ball at 0.732 m/s, 1.5 times 0.488 m/s.
        let (speed_mps, rolls_m) = dribbling(&with_feet(1.0, 1.5).player()).unwrap();
        assert_abs_diff_eq!(speed_mps, 0.488, epsilon = 1e-3);
        assert_abs_diff_eq!(rolls_m, 1.5, epsilon = 1e-3);
        // 1.4 * 2 * 0.2 m/s = 0.56 m/s: 0.448 m.
        let (speed_mps, rolls_m) = dribbling(&with_feet(0.2, 2.0).player()).unwrap();
        assert_eq!(speed_mps, 0.2);
        assert_abs_diff_eq!(rolls_m, 0.448, epsilon = 1e-3);
        assert_eq!(dribbling(&with_feet(0.2, 1.0).player()), None, "its feet do not swing ahead");
        assert_eq!(dribbling(&PlayerFixture::new(Pose::default(), Vec2::ZERO).player()), None, "it has no gait");
    }

    #[test]
    fn a_ball_is_dribbled_away_from_an_opponent() {
        let situation = with_feet(1.0, 1.5);
        let opponents = [RobotBelief { id: None, position_m: Vec2::new(1.2, 0.3), covariance: [0.0; 3], age_s: 0.0 }];
        let company = Company { mates: &[], opponents: &opponents };
        let options: Vec<_> = dribbles(&situation.player(), company, Vec2::ZERO).collect();
        let (aim, ..) = options.iter().max_by(|(.., a), (.., b)| a.total_cmp(b)).unwrap();
        assert!(aim.direction.y < -0.3, "{options:?}");
    }

    #[test]
    fn it_walks_straight_at_the_ball_and_brakes_before_it() {
        let situation = with_feet(1.0, 1.5);
        let into = |x: f32, y: f32, angle: f32| {
            let ball = situation.player().position() + Vec2::new(x, y);
            let walk = walk_into(&situation.player(), ball, unit(angle))?;
            Some(walk.translation() / situation.period)
        };
        // The toes are 0.11 m ahead, the ball's radius is 3 cm.
        assert_abs_diff_eq!(into(0.14, 0.0, 0.0).unwrap(), Vec2::new(0.488, 0.0), epsilon = 1e-3);
        // √(0.488² + 2 * 0.3 * 0.5) m/s half a metre before.
        assert_abs_diff_eq!(into(0.64, 0.0, 0.0).unwrap(), Vec2::new(0.733, 0.0), epsilon = 1e-3);
        assert!(into(0.3, 0.05, 0.0).unwrap().y > 0.0);
        assert_eq!([into(-0.2, 0.0, 0.0), into(0.2, 0.2, 0.0), into(0.2, 0.0, 1.0)], [None; 3]);
    }

    #[test]
    fn a_dribbling_player_walks_on_into_the_ball() {
        let mut situation = with_feet(1.0, 1.5);
        // It has no kick that could be better.
        for kick in [&mut situation.kicks.left_straight, &mut situation.kicks.right_straight] {
            kick.max_distance_m = 0.0;
        }
        situation.kicks.left_side.max_distance_m = 0.0;
        situation.kicks.right_side.max_distance_m = 0.0;
        let decision = decide(&situation.player(), &mut PlayerMemory::default());
        assert_eq!(decision.kick, None);
        // The ball is 0.11 m ahead of the toes: √(0.488² + 2 * 0.3 * 0.11) m/s.
        assert_abs_diff_eq!(decision.walk.dx / situation.period, 0.551, epsilon = 1e-3);
    }
}
