//! Boundary crossings: the whole ball passes the outer edge of a line (2010 rule book, sections 3.3 and 3.9; a line is part of the pitch).
//!
//! The ball's whole path in the cycle is checked: at its end a fast ball may be far beyond the line, or back on the pitch.

use bevy::prelude::*;

use super::snapshot::BallSnapshot;
use crate::pitch::{End, Pitch};

/// A boundary that the ball crossed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Boundary {
    /// The goal line between the posts of the goal at this end, and under the bar.
    Goal(End),
    /// The goal line at this end, outside the goal.
    GoalLine(End),
    /// A side line.
    SideLine,
}

/// A crossing of a line.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Crossing {
    /// The boundary.
    pub boundary: Boundary,
    /// Position of the ball's centre when the whole ball had left, m, pitch frame.
    pub position: Vec2,
}

/// The first crossing of a boundary by the whole ball in this cycle, if any.
pub fn crossing(ball: &BallSnapshot, pitch: &Pitch) -> Option<Crossing> {
    let limit = pitch.outer_half_extents() + ball.radius;
    let vertex = |index: usize| {
        let place = ball.path.get(index).copied().unwrap_or(ball.position);
        place.extend(ball.radius + ball.heights_m.get(index).or(ball.heights_m.last()).copied().unwrap_or(0.0))
    };
    let start = vertex(0);
    if let Some(boundary) = beyond(start, limit, pitch) {
        return Some(Crossing { boundary, position: start.truncate() });
    }
    (0..ball.path.len()).find_map(|index| leaving(vertex(index), vertex(index + 1), limit, pitch))
}

/// The boundary beyond which the position of the ball's centre lies: in the goal, or outside the given limits.
fn beyond(point: Vec3, limit: Vec2, pitch: &Pitch) -> Option<Boundary> {
    let end = if point.x > 0.0 { End::PositiveX } else { End::NegativeX };
    if point.x.abs() > limit.x {
        let in_goal = is_in_goal_mouth(point, pitch) && point.x.abs() <= pitch.goal_post_x() + pitch.goal.depth_m;
        return Some(if in_goal { Boundary::Goal(end) } else { Boundary::GoalLine(end) });
    }
    (point.y.abs() > limit.y).then_some(Boundary::SideLine)
}

/// Whether a point is between the posts' centres and below the crossbar's. The ball's centre cannot come nearer to the line between the
/// posts' centres than their radius, nor can a ball outside the net, so that line divides balls that passed between the posts from those
/// that passed beside them. The same is true of the crossbar.
fn is_in_goal_mouth(point: Vec3, pitch: &Pitch) -> bool {
    point.y.abs() < pitch.goal.width_m / 2.0 && point.z < pitch.goal.height_m - pitch.goal.bar_diameter_m / 2.0
}

/// The first crossing of the limits on a straight path from a position on the pitch.
fn leaving(from: Vec3, to: Vec3, limit: Vec2, pitch: &Pitch) -> Option<Crossing> {
    beyond(to, limit, pitch)?;
    let way = to - from;
    let share = |from: f32, way: f32, limit: f32| match way {
        way if from + way > limit => (limit - from) / way,
        way if from + way < -limit => (-limit - from) / way,
        _ => f32::INFINITY,
    };
    let (over_x, over_y) = (share(from.x, way.x, limit.x), share(from.y, way.y, limit.y));
    let position = from + way * over_x.min(over_y).clamp(0.0, 1.0);
    let boundary = if over_y < over_x {
        Boundary::SideLine
    } else {
        let end = if way.x > 0.0 { End::PositiveX } else { End::NegativeX };
        if is_in_goal_mouth(position, pitch) { Boundary::Goal(end) } else { Boundary::GoalLine(end) }
    };
    Some(Crossing { boundary, position: position.truncate() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    const RADIUS: f32 = 0.03;
    /// Outer edge of the goal line plus the ball's radius: 3 + 0.025 + 0.03 m.
    const GOAL_X: f32 = 3.055;
    /// Outer edge of the side line plus the ball's radius: 2 + 0.025 + 0.03 m.
    const SIDE_Y: f32 = 2.055;

    fn crossed(path: &[[f32; 2]]) -> Option<Crossing> {
        let path: Vec<Vec2> = path.iter().copied().map(Vec2::from).collect();
        let position = path[path.len() - 1];
        let ball = BallSnapshot { path: &path, heights_m: &[], position, velocity: Vec2::ZERO, radius: RADIUS };
        crossing(&ball, &Pitch::default())
    }

    fn boundary(path: &[[f32; 2]]) -> Option<Boundary> {
        crossed(path).map(|crossing| crossing.boundary)
    }

    #[test]
    fn a_ball_that_still_overlaps_the_line_is_in_play() {
        assert_eq!(boundary(&[[2.9, 0.0], [GOAL_X - 1e-4, 0.0]]), None);
        assert_eq!(boundary(&[[2.9, 0.0], [GOAL_X + 1e-4, 0.0]]), Some(Boundary::Goal(End::PositiveX)));
        assert_eq!(boundary(&[[0.0, 1.9], [0.1, SIDE_Y - 1e-4]]), None);
        assert_eq!(boundary(&[[0.0, 1.9], [0.1, SIDE_Y + 1e-4]]), Some(Boundary::SideLine));
        assert_eq!(boundary(&[[-2.9, 1.0], [-GOAL_X - 1e-4, 1.0]]), Some(Boundary::GoalLine(End::NegativeX)));
    }

    #[test]
    fn between_the_posts_it_is_a_goal_and_beside_them_it_is_out() {
        assert_eq!(boundary(&[[-2.9, 0.69], [-3.1, 0.69]]), Some(Boundary::Goal(End::NegativeX)));
        assert_eq!(boundary(&[[-2.9, 0.71], [-3.1, 0.71]]), Some(Boundary::GoalLine(End::NegativeX)));
    }

    #[test]
    fn a_fast_ball_is_judged_where_it_crossed_not_where_it_is() {
        // From (2.5, 0.5) towards (4.5, 1.5): at x = 3.055 it is at y = 0.5 + 0.555 / 2 = 0.7775, beside the goal.
        let out = crossed(&[[2.5, 0.5], [4.5, 1.5]]).unwrap();
        assert_eq!(out.boundary, Boundary::GoalLine(End::PositiveX));
        assert_abs_diff_eq!(out.position, Vec2::new(GOAL_X, 0.7775), epsilon = 1e-5);
        // From (2.8, 1.5) it is past the side line before it is past the goal line.
        assert_eq!(boundary(&[[2.8, 1.5], [3.8, 4.5]]), Some(Boundary::SideLine));
        // The whole ball was out, bounced, and is back.
        assert_eq!(boundary(&[[0.0, 1.5], [0.5, 2.5], [1.0, 1.5]]), Some(Boundary::SideLine));
    }

    #[test]
    fn a_ball_that_lies_in_the_goal_has_been_scored_and_one_behind_it_has_not() {
        assert_eq!(boundary(&[[3.2, 0.3], [3.2, 0.3]]), Some(Boundary::Goal(End::PositiveX)));
        assert_eq!(boundary(&[[3.5, 0.3], [3.5, 0.3]]), Some(Boundary::GoalLine(End::PositiveX)));
    }

    #[test]
    fn over_the_crossbar_it_is_out_and_under_it_a_goal() {
        let at_height = |height_m: f32| {
            let path = [Vec2::new(2.9, 0.0), Vec2::new(3.3, 0.0)];
            let ball = BallSnapshot {
                path: &path,
                heights_m: &[height_m; 2],
                position: path[1],
                velocity: Vec2::ZERO,
                radius: RADIUS,
            };
            crossing(&ball, &Pitch::default()).map(|crossing| crossing.boundary)
        };
        let goal_height_m = Pitch::default().goal.height_m;
        assert_eq!(at_height(goal_height_m - 0.1), Some(Boundary::Goal(End::PositiveX)));
        assert_eq!(at_height(goal_height_m), Some(Boundary::GoalLine(End::PositiveX)));
    }
}
