//! Which kick to make now with a ball at the feet.

use bevy::prelude::*;

use super::aiming::Aim;
use naoisis_core::ball::Rolling;
use naoisis_core::geometry::{unit, unrotate};
use naoisis_core::kick_geometry::KickType;
use naoisis_core::pitch::Pitch;
use naoisis_core::robot::kick::{KickRequest, KickSettings};
use naoisis_sensing::belief::RobotBelief;

/// The distance of passes from the lines, m.
const LINE_MARGIN_M: f32 = 0.35;
/// The ball must lie this far inside the rectangle of a kick, m: it is not seen to the millimetre.
const RECTANGLE_MARGIN_M: f32 = 0.004;
/// In walking, the ball must lie inside the rectangle of a kick by this multiple of the standard deviation of its place.
const MARGIN_SDS: f32 = 0.5;
/// The greatest such margin, m.
const MOST_MARGIN_M: f32 = 0.02;
/// A kick is aimed no more exactly than this share of its own spread.
const SPREAD_SHARE: f32 = 0.7;
/// The least useful distance of a kick, m.
pub(super) const LEAST_KICK_M: f32 = 0.4;

/// A ball at the feet of a player.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct BallAtFeet {
    /// The place of the ball, m, team frame.
    pub place: Vec2,
    /// The place of the ball, m, robot frame.
    pub in_robot: Vec2,
    /// The velocity of the ball, m/s, robot frame; zero if it lies still.
    pub rolls_mps: Vec2,
    /// The standard deviation of the place along an axis, m; zero in a hurry, as if the place were sure.
    pub place_sd_m: f32,
    /// The direction that the robot faces, unit vector, team frame.
    pub forward: Vec2,
    /// The first and the last velocity of the legs until the robot strikes in a kick in walking: ahead and to the left, m/s, and
    /// counter-clockwise, rad/s.
    pub walks: [Vec3; 2],
    /// The delay of commands for kicks, s.
    pub delay_s: f32,
}

impl BallAtFeet {
    /// The places of the ball when a kick of this type strikes, m, robot frame, if the robot walks at either velocity until then, and the
    /// angle by which it turns, radians. Kicks without walking are made where the ball lies.
    fn when_struck(self, settings: &KickSettings, kick_type: KickType) -> ([Vec2; 2], f32) {
        if !settings.is_in_walk(kick_type) {
            return ([self.in_robot; 2], 0.0);
        }
        let until_s = settings.wind_up_of_s(kick_type) + self.delay_s;
        let rolled = self.in_robot + self.rolls_mps * until_s;
        let places = self.walks.map(|walks| unrotate(unit(walks.z * until_s), rolled - walks.truncate() * until_s));
        let [first, last] = self.walks;
        (places, 0.5 * (first.z + last.z) * until_s)
    }

    /// The distance from the edges of a kick's rectangle within which the ball may be missed, m.
    fn margin_m(self, settings: &KickSettings, kick_type: KickType) -> f32 {
        let in_walk = settings.is_in_walk(kick_type);
        let unsure_m = if in_walk { (MARGIN_SDS * self.place_sd_m).min(MOST_MARGIN_M) } else { 0.0 };
        unsure_m.max(RECTANGLE_MARGIN_M)
    }

    /// Returns the kicks that reach the ball, aimed at `aim` as far as possible, each with the direction in which the ball leaves, unit
    /// vector, team frame.
    pub fn kicks(self, settings: &KickSettings, aim: Vec2) -> impl Iterator<Item = (KickRequest, Vec2)> {
        settings.types().filter_map(move |kick_type| {
            let geometry = settings.geometry(kick_type)?;
            let (places, turned) = self.when_struck(settings, kick_type);
            let rectangle = geometry.rectangle().inflate(-self.margin_m(settings, kick_type));
            if !places.into_iter().all(|place| rectangle.contains(place)) {
                return None;
            }
            let forward = if turned == 0.0 { self.forward } else { self.forward.rotate(unit(turned)) };
            let wanted = geometry.wanted_for(unrotate(forward, aim));
            let strike = settings.strike(kick_type, places[0].midpoint(places[1]), wanted)?;
            let request = KickRequest { direction: wanted, ..KickRequest::new(kick_type, 1.0) };
            Some((request, forward.rotate(strike.direction)))
        })
    }
}

/// Returns the most accurate kick that sends the ball where `aim` says from where it lies, if there is one. `patience` scales the tolerance
/// of the direction.
pub fn kick_now(
    ball: BallAtFeet,
    aim: &Aim,
    (kicks, rolling): (&KickSettings, Rolling),
    pitch: &Pitch,
    patience: f32,
) -> Option<KickRequest> {
    ball.kicks(kicks, aim.direction)
        .filter_map(|(kick, direction)| {
            let kick_type = kick.kick_type;
            let error = aim.direction.perp_dot(direction).abs();
            let reach_m = kicks.max_distance_m(kick_type);
            let distance_m =
                if aim.is_shot { reach_m } else { aim.distance_m.min(room_inside(ball.place, direction, pitch)) };
            let is_good = direction.dot(aim.direction) > 0.3
                && error < patience * aim.tolerance.max(SPREAD_SHARE * kicks.direction_sd_of(kick_type))
                && distance_m > LEAST_KICK_M.max(kicks.min_distance_m(kick_type))
                && (!aim.is_shot || reach_m > 1.1 * aim.distance_m);
            is_good.then_some((error, KickRequest { speed: rolling.speed_share(distance_m, reach_m), ..kick }))
        })
        .min_by(|(first, _), (second, _)| first.total_cmp(second))
        .map(|(_, kick)| kick)
}

/// Returns a kick in whatever direction the ball leaves from where it lies, past opponents, who block `blocked_half_width_m` to either
/// side, and not backwards.
pub fn any_kick(
    ball: BallAtFeet,
    opponents: &[RobotBelief],
    blocked_half_width_m: f32,
    (kicks, rolling): (&KickSettings, Rolling),
    pitch: &Pitch,
) -> Option<KickRequest> {
    /// Opponents further away than this do not stop the ball, m.
    const OPPONENT_RANGE_M: f32 = 0.8;
    /// The least x component of the direction.
    const LEAST_FORWARDS: f32 = -0.2;
    ball.kicks(kicks, Vec2::X)
        .filter_map(|(kick, direction)| {
            let is_free = opponents.iter().all(|opponent| {
                let offset = opponent.position_m - ball.place;
                offset.length_squared() > OPPONENT_RANGE_M * OPPONENT_RANGE_M
                    || direction.dot(offset) < 0.0
                    || direction.perp_dot(offset).abs() > blocked_half_width_m
            });
            let reach_m = kicks.max_distance_m(kick.kick_type);
            let distance_m = room_inside(ball.place, direction, pitch).min(reach_m);
            let least_m = LEAST_KICK_M.max(kicks.min_distance_m(kick.kick_type));
            (is_free && direction.x > LEAST_FORWARDS && distance_m > least_m)
                .then_some((direction.x, KickRequest { speed: rolling.speed_share(distance_m, reach_m), ..kick }))
        })
        .max_by(|(first, _), (second, _)| first.total_cmp(second))
        .map(|(_, kick)| kick)
}

/// The distance that a ball can roll in `direction` until it is too near to a line, m.
pub(super) fn room_inside(ball: Vec2, direction: Vec2, pitch: &Pitch) -> f32 {
    let along = |place: f32, direction: f32, half: f32| {
        if direction.abs() < 1e-3 {
            f32::MAX
        } else {
            ((half - LINE_MARGIN_M) * direction.signum() - place) / direction
        }
    };
    along(ball.x, direction.x, pitch.half_length()).min(along(ball.y, direction.y, pitch.half_width())).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use naoisis_core::robot::kick::CustomKicks;

    #[test]
    fn a_ball_is_kicked_when_it_goes_where_it_should_and_only_then() {
        let kick = |in_robot: Vec2, tolerance: f32| {
            let ball = BallAtFeet { in_robot, forward: Vec2::X, ..default() };
            let aim = Aim { direction: Vec2::X, distance_m: 2.0, tolerance, is_shot: false, dribbles: false };
            kick_now(ball, &aim, (&KickSettings::default(), Rolling::default()), &Pitch::default(), 1.0)
        };
        let straight = kick(Vec2::new(0.17, 0.05), 0.1).unwrap();
        // 2 m of the left foot's 4 m.
        assert_eq!(straight, KickRequest::new(KickType::LeftStraight, 0.5));
        // The ray from the tip (0.10, 0.05) to (0.17, 0.08) leaves at atan(3 / 7) = 23°, of sine 0.39.
        assert_eq!(kick(Vec2::new(0.17, 0.08), 0.3), None);
        assert!(kick(Vec2::new(0.17, 0.08), 0.45).is_some());
        assert_eq!(kick(Vec2::new(0.25, 0.05), 0.3), None);
    }

    #[test]
    fn a_kick_in_walking_is_made_where_the_ball_will_be_and_with_a_margin_for_its_place() {
        let own: CustomKicks = serde_json::from_str(
            r#"{ "walk": { "max_distance_m": 4.5, "wind_up_s": 0.25, "in_walk": true,
                           "region": { "x_m": [0.12, 0.24], "y_m": [-0.09, 0.09], "foot_m": [0.1, 0.0], "best_m": [0.2, 0.05] } } }"#,
        )
        .unwrap();
        let settings = KickSettings { own, ..KickSettings::default() };
        let is_kicked =
            |ball: BallAtFeet| ball.kicks(&settings, Vec2::X).any(|(kick, _)| settings.is_in_walk(kick.kick_type));
        let ball = BallAtFeet { in_robot: Vec2::new(0.2, 0.08), forward: Vec2::X, ..default() };
        assert!(is_kicked(ball));
        assert!(!is_kicked(BallAtFeet { place_sd_m: 0.03, ..ball }), "1.5 cm from the edge would be needed");
        assert!(is_kicked(BallAtFeet { place_sd_m: 0.01, ..ball }));
        // In a quarter of a second it rolls 5 cm.
        assert!(!is_kicked(BallAtFeet { rolls_mps: Vec2::new(0.2, 0.0), ..ball }));
        assert!(is_kicked(BallAtFeet { in_robot: Vec2::new(0.27, 0.08), rolls_mps: Vec2::new(-0.2, 0.0), ..ball }));
        // A robot that walks ahead is there in time, one that walks back is not, and one that turns by 0.6 rad/s has the ball aside.
        let ahead = BallAtFeet { in_robot: Vec2::new(0.27, 0.0), ..ball };
        assert!(!is_kicked(ahead) && is_kicked(BallAtFeet { walks: [Vec3::X * 0.15, Vec3::X * 0.2], ..ahead }));
        let far = BallAtFeet { in_robot: Vec2::new(0.22, 0.0), ..ball };
        assert!(is_kicked(far) && !is_kicked(BallAtFeet { walks: [Vec3::X * -0.15, Vec3::X * -0.1], ..far }));
        assert!(!is_kicked(BallAtFeet { walks: [Vec3::Z * -0.6; 2], ..ball }));
        assert!(is_kicked(BallAtFeet { walks: [Vec3::Z * 0.6; 2], ..ball }));
    }

    #[test]
    fn a_pass_does_not_roll_over_the_lines() {
        let ball =
            BallAtFeet { place: Vec2::new(0.0, 1.2), in_robot: Vec2::new(0.17, 0.05), forward: Vec2::Y, ..default() };
        let aim = Aim { direction: Vec2::Y, distance_m: 3.0, tolerance: 0.2, is_shot: false, dribbles: false };
        let kick =
            kick_now(ball, &aim, (&KickSettings::default(), Rolling::default()), &Pitch::default(), 1.0).unwrap();
        // Until 0.35 m before the line at y = 2: 0.45 m of 4 m.
        assert_abs_diff_eq!(kick.speed, 0.1125, epsilon = 1e-4);
    }

    #[test]
    fn for_want_of_better_the_ball_goes_forwards_past_the_opponent() {
        let ball = BallAtFeet { in_robot: Vec2::new(0.16, 0.08), forward: Vec2::X, ..default() };
        let (settings, pitch) = (KickSettings::default(), Pitch::default());
        let kicks = (&settings, Rolling::default());
        let kick = any_kick(ball, &[], 0.15, kicks, &pitch).unwrap();
        assert_eq!(kick.kick_type, KickType::LeftStraight);
        let opponent = RobotBelief { id: None, position_m: Vec2::new(0.4, 0.2), covariance: [0.0; 3], age_s: 0.0 };
        let kick = any_kick(ball, &[opponent], 0.15, kicks, &pitch).unwrap();
        assert_eq!(kick.kick_type, KickType::RightSide);
        let backwards = BallAtFeet { forward: -Vec2::X, ..ball };
        assert_eq!(any_kick(backwards, &[], 0.15, kicks, &pitch).map(|kick| kick.kick_type), None);
    }
}
