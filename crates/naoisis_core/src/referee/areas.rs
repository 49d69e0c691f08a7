//! Positions of robots relative to the areas of the pitch, and robots that go to the ball.

use bevy::prelude::*;

use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::pitch::{AreaDimensions, End, Pitch};

/// Cosine of the greatest angle between a robot's walk and the direction to the ball at which it goes to the ball: 60 degrees.
const TO_BALL_COSINE: f32 = 0.5;

/// The positions of a robot's feet, m, pitch frame.
pub fn feet(robot: &RobotSnapshot) -> [Vec2; 2] {
    let foot_y = robot.bounds.foot_y_m;
    [foot_y, -foot_y].map(|y| robot.pose.transform_point(Vec2::new(0.0, y)))
}

/// The corners of a robot's base, m, pitch frame.
pub fn base_corners(robot: &RobotSnapshot) -> [Vec2; 4] {
    robot.bounds.base.footprint(robot.pose).corners()
}

/// Whether `point` is in the area in front of the goal at `end`, including its lines.
pub fn in_area(pitch: &Pitch, area: AreaDimensions, end: End, point: Vec2) -> bool {
    let half_line = pitch.line_width_m / 2.0;
    let depth = pitch.half_length() + half_line - end.sign() * point.x;
    (0.0..=area.depth_m + pitch.line_width_m).contains(&depth) && point.y.abs() <= area.width_m / 2.0 + half_line
}

/// Whether any part of a robot's base touches the area in front of the goal at `end`.
pub fn touches_area(pitch: &Pitch, area: AreaDimensions, end: End, robot: &RobotSnapshot) -> bool {
    // Most robots are elsewhere, so that their corners are not needed.
    let beyond = end.sign() * robot.pose.position.x - (pitch.half_length() - area.depth_m - pitch.line_width_m);
    beyond > -robot.bounds.base.reach() && base_corners(robot).iter().any(|corner| in_area(pitch, area, end, *corner))
}

/// Whether any part of a robot's base touches the goal line at `end`.
pub fn touches_goal_line(pitch: &Pitch, end: End, robot: &RobotSnapshot) -> bool {
    let beyond = base_corners(robot).map(|corner| end.sign() * corner.x - pitch.half_length());
    let half_line = pitch.line_width_m / 2.0;
    beyond.iter().any(|distance| *distance >= -half_line) && beyond.iter().any(|distance| *distance <= half_line)
}

/// The penalty mark in front of the goal at `end`, m, pitch frame.
pub fn penalty_mark(pitch: &Pitch, end: End) -> Vec2 {
    Vec2::new(end.sign() * (pitch.half_length() - pitch.penalty_mark_distance_m), 0.0)
}

/// Whether a robot is a goalkeeper in its own penalty area.
pub fn is_keeper_at_home(snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    snapshot.game.is_goalkeeper(robot.id)
        && snapshot.pitch.in_penalty_area(snapshot.game.own_end(robot.id.team), robot.pose.position)
}

/// Whether `point` is inside the goal at `end`, behind the goal line.
pub fn in_goal(pitch: &Pitch, end: End, point: Vec2) -> bool {
    let behind = end.sign() * point.x - pitch.outer_half_extents().x;
    behind > 0.0
        && end.sign() * point.x <= pitch.goal_post_x() + pitch.goal.depth_m
        && point.y.abs() < pitch.goal.width_m / 2.0
}

/// `point` in the frame of the team that defends `own_end`, with the team's own goal at -x.
pub fn in_team_frame(own_end: End, point: Vec2) -> Vec2 {
    point * -own_end.sign()
}

/// The position of the ball at the start of the cycle, m, pitch frame. At the end of the cycle the ball may have been squeezed out.
pub fn place_of_ball(snapshot: &MatchSnapshot) -> Option<Vec2> {
    snapshot.ball.map(|ball| *ball.path.first().unwrap_or(&ball.position))
}

/// Whether a robot walks to the ball.
pub fn goes_to_ball(snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    let Some(place) = place_of_ball(snapshot) else { return false };
    let direction = (place - robot.previous.position).normalize_or_zero();
    robot.wanted_velocity.normalize_or_zero().dot(direction) > TO_BALL_COSINE
}
