//! The choice of the place to kick the ball to, for players that do not pass.

use bevy::prelude::*;

use naoisis_core::pitch::Pitch;
use naoisis_sensing::belief::RobotBelief;

/// Distance by which an opponent steps aside while the ball rolls a metre towards it, m: it walks 0.2 m/s, and a ball rolls 1 to 2 m/s.
const BLOCKED_PER_METRE: f32 = 0.12;
/// The greatest useful distance between the ball's path and robots or posts, m: more is no better.
const ENOUGH_ROOM_M: f32 = 0.35;
/// The least distance of a shot from both posts, m.
const LEAST_ROOM_M: f32 = 0.04;
/// The places along the goal line that are considered, as shares of its width.
const GOAL_AIMS: [f32; 7] = [0.0, 0.17, -0.17, 0.34, -0.34, 0.5, -0.5];
/// The advantage of the aim chosen before, m.
const AIM_PREFERENCE_M: f32 = 0.05;
/// The tolerance of the direction of a pass, as a sine.
const PASS_TOLERANCE: f32 = 0.26;
/// The tolerance of the direction near the own goal, as a sine: there it matters most that the ball goes away.
const CLEARANCE_TOLERANCE: f32 = 0.6;
/// A ball nearer to the own goal line than this is cleared, m.
const CLEARANCE_DEPTH_M: f32 = 1.2;

/// The sizes of robots and the ball.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sizes {
    /// Half the width that an opponent blocks: its feet and the ball's radius, m.
    pub blocked_half_width_m: f32,
    /// The ball's radius, m.
    pub ball_radius_m: f32,
}

/// The place that a kick aims at.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Aim {
    /// The direction, unit vector, team frame.
    pub direction: Vec2,
    /// The distance, m.
    pub distance_m: f32,
    /// The tolerance of the direction: the sine of the angle.
    pub tolerance: f32,
    /// Whether it is a shot at the goal, with the full strength.
    pub is_shot: bool,
    /// Whether the player dribbles the ball there: it walks into the ball instead of kicking it.
    pub dribbles: bool,
}

impl Aim {
    /// Aims at `place`, where the ball is to stop.
    pub fn at(ball: Vec2, place: Vec2) -> Self {
        Self {
            direction: (place - ball).normalize_or(Vec2::X),
            distance_m: place.distance(ball),
            tolerance: PASS_TOLERANCE,
            is_shot: false,
            dribbles: false,
        }
    }

    /// Aims into the goal, where there is the most room between posts and opponents, if `range_m` reaches it. Otherwise aims towards the
    /// goal, or from the side in front of it, past opponents and not over the lines.
    pub fn choose(
        ball: Vec2,
        opponents: &[RobotBelief],
        pitch: &Pitch,
        range_m: f32,
        sizes: Sizes,
        previous: Option<Vec2>,
    ) -> Self {
        let half_goal = pitch.goal.width_m / 2.0;
        let post_radius = pitch.goal.post_diameter_m / 2.0;
        let goal_x = pitch.half_length() + pitch.line_width_m;
        let posts = [-half_goal, half_goal].map(|y| Vec2::new(pitch.goal_post_x(), y));
        let preference = |direction: Vec2| {
            previous.map_or(0.0, |previous| if direction.dot(previous) > 0.99 { AIM_PREFERENCE_M } else { 0.0 })
        };
        let mut best: Option<(f32, f32, Aim)> = None;
        for y in GOAL_AIMS.map(|share| 2.0 * share * half_goal) {
            let way = Vec2::new(goal_x, y) - ball;
            let distance_m = way.length();
            let direction = way / distance_m;
            let between_posts = posts
                .map(|post| direction.perp_dot(post - ball).abs() - post_radius - sizes.ball_radius_m)
                .into_iter()
                .fold(f32::MAX, f32::min);
            let room = room_along(ball, direction, distance_m, opponents, sizes).min(between_posts);
            let score = room.min(ENOUGH_ROOM_M) + preference(direction);
            if best.is_none_or(|(least, ..)| score > least) {
                let tolerance = (0.8 * room.max(0.05) / distance_m).clamp(0.03, 0.3);
                let aim = Aim { direction, distance_m, tolerance, is_shot: true, dribbles: false };
                best = Some((score, between_posts, aim));
            }
        }
        let Some((score, between_posts, aim)) = best else { return Self::at(ball, Vec2::new(goal_x, 0.0)) };
        let reaches = aim.distance_m < range_m;
        if reaches && between_posts > LEAST_ROOM_M && score > 0.0 {
            return aim;
        }
        if reaches && between_posts <= LEAST_ROOM_M {
            // There is no opening from the side: aim in front of the goal.
            return Self::at(ball, Vec2::new(pitch.half_length() - 0.9, 0.0));
        }
        // Ahead, or along a wing if it is free and the middle is not.
        let wing_x = (ball.x + 1.6).min(pitch.half_length() - 0.7);
        let wing_y = pitch.half_width() - 0.5;
        let ahead = if reaches {
            (score, aim)
        } else {
            let place = ball + aim.direction * range_m.min(aim.distance_m - 0.5);
            (score, Self::at(ball, place))
        };
        let wings = [wing_y, -wing_y].map(|y| {
            let aim = Self::at(ball, Vec2::new(wing_x, y));
            let room = room_along(ball, aim.direction, aim.distance_m, opponents, sizes).min(ENOUGH_ROOM_M);
            (room - 0.15 + preference(aim.direction), aim)
        });
        let (_, aim) = wings.into_iter().fold(ahead, |best, wing| if wing.0 > best.0 { wing } else { best });
        let must_clear = ball.x < CLEARANCE_DEPTH_M - pitch.half_length();
        Self { tolerance: if must_clear { CLEARANCE_TOLERANCE } else { aim.tolerance }, ..aim }
    }

    /// Aims a gentle first touch at the own kick-off to the left or right: a direct shot is not allowed.
    pub fn kick_off(ball: Vec2, left: bool) -> Self {
        let side = if left { 1.0 } else { -1.0 };
        Self::at(ball, ball + Vec2::new(0.8, side * 0.7))
    }
}

/// Returns the least distance between the ball's path and what opponents can block, at most [`ENOUGH_ROOM_M`], m.
pub fn room_along(ball: Vec2, direction: Vec2, distance_m: f32, opponents: &[RobotBelief], sizes: Sizes) -> f32 {
    opponents
        .iter()
        .filter_map(|opponent| {
            let offset = opponent.position_m - ball;
            let along = direction.dot(offset);
            let across = direction.perp_dot(offset).abs();
            (along > 0.0 && along < distance_m + 0.2)
                .then_some(across - sizes.blocked_half_width_m - BLOCKED_PER_METRE * along)
        })
        .fold(ENOUGH_ROOM_M, f32::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn opponent(x: f32, y: f32) -> RobotBelief {
        RobotBelief { id: None, position_m: Vec2::new(x, y), covariance: [0.0; 3], age_s: 0.0 }
    }

    const NAO: Sizes = Sizes { blocked_half_width_m: 0.15, ball_radius_m: 0.03 };

    fn aim(ball: Vec2, opponents: &[RobotBelief]) -> Aim {
        Aim::choose(ball, opponents, &Pitch::default(), 3.8, NAO, None)
    }

    /// Returns the place at which a ball kicked with this aim crosses the opponents' goal line, m from its middle.
    fn crossing(ball: Vec2, aim: &Aim) -> f32 {
        ball.y + aim.direction.y / aim.direction.x * (3.0 - ball.x)
    }

    #[test]
    fn a_free_ball_is_shot_between_the_posts() {
        for ball in [Vec2::new(1.0, 0.5), Vec2::new(2.0, -1.0), Vec2::new(0.0, 1.2), Vec2::new(2.6, 0.0)] {
            let aim = aim(ball, &[]);
            assert!(aim.is_shot, "{ball}");
            // Clear of the posts by the ball's radius: 0.7 - 0.05 - 0.03 = 0.62 m from the middle.
            assert!(crossing(ball, &aim).abs() < 0.62, "{ball} {aim:?}");
        }
    }

    #[test]
    fn a_keeper_is_passed_on_its_wider_side() {
        let ball = Vec2::new(1.5, 0.0);
        assert!(crossing(ball, &aim(ball, &[opponent(2.7, 0.25)])) < -0.1);
        assert!(crossing(ball, &aim(ball, &[opponent(2.7, -0.25)])) > 0.1);
    }

    #[test]
    fn wider_robots_block_more_and_a_larger_ball_keeps_further_from_the_posts() {
        let room = |blocked_half_width_m: f32| {
            let sizes = Sizes { blocked_half_width_m, ..NAO };
            room_along(Vec2::ZERO, Vec2::X, 2.0, &[opponent(1.0, 0.4)], sizes)
        };
        // 0.4 m aside, minus the 15 cm that a NAO blocks and the 12 cm that it steps aside while the ball rolls a metre.
        assert_abs_diff_eq!(room(0.15), 0.13, epsilon = 1e-6);
        assert_abs_diff_eq!(room(0.25), 0.03, epsilon = 1e-6);
        let wide = |ball_radius_m: f32| {
            let sizes = Sizes { ball_radius_m, ..NAO };
            let aim = Aim::choose(Vec2::new(2.7, 1.0), &[], &Pitch::default(), 3.8, sizes, None);
            aim.is_shot
        };
        assert!(wide(0.03) && !wide(0.12), "beside the goal there is an opening for a small ball only");
    }

    #[test]
    fn from_beside_the_goal_the_ball_goes_to_its_front() {
        let ball = Vec2::new(2.9, 1.6);
        let aim = aim(ball, &[]);
        assert!(!aim.is_shot);
        assert_abs_diff_eq!(ball + aim.direction * aim.distance_m, Vec2::new(2.1, 0.0), epsilon = 1e-5);
    }
}
