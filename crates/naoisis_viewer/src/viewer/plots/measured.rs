//! Measured numbers of robots and the ball, from the records of the match.

use bevy::math::Vec2;

use super::subject::Subject;
use crate::viewer::cycle_samples::{CycleSample, RobotSample};
use naoisis_core::geometry::to_degrees;

/// A measured number of a robot or of the ball.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Measured {
    /// The key by which it is stored.
    pub(super) key: &'static str,
    /// The name in the window.
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    of: Of,
}

#[derive(Clone, Copy, Debug)]
enum Of {
    /// The value of a robot in a cycle of the given duration, s.
    Robot(fn(&RobotSample, f32) -> Option<f32>),
    Ball(fn(Vec2) -> f32),
}

impl PartialEq for Of {
    fn eq(&self, _other: &Self) -> bool {
        // Each key has one function, so the key alone decides equality.
        true
    }
}

const fn of_robot(
    key: &'static str,
    name: &'static str,
    unit: &'static str,
    of: fn(&RobotSample, f32) -> Option<f32>,
) -> Measured {
    Measured { key, name, unit, of: Of::Robot(of) }
}

const fn of_ball(key: &'static str, name: &'static str, unit: &'static str, of: fn(Vec2) -> f32) -> Measured {
    Measured { key, name, unit, of: Of::Ball(of) }
}

/// All measured numbers.
pub(super) const ALL: [Measured; 19] = [
    of_robot("own_place_error", "error of its own position", "m", |robot, _| Some(robot.error?.position_m)),
    of_robot("own_heading_error", "error of its own heading", "°", |robot, _| Some(to_degrees(robot.error?.heading))),
    of_robot("ball_error", "error of the ball", "m", |robot, _| Some(robot.error?.ball?.position_m)),
    of_robot("opponent_error", "error of the opponents", "m", |robot, _| robot.error?.opponent_m),
    of_robot("ball_distance", "distance to the ball", "m", |robot, _| robot.ball_m.filter(|_| !robot.penalised)),
    of_robot("speed", "speed", "m/s", |robot, _| Some(robot.speed_mps)),
    of_robot("wanted_speed", "commanded speed", "m/s", |robot, period_s| {
        robot.command.as_ref().map(|command| command.walk.unwrap_or_default().translation().length() / period_s)
    }),
    of_robot("wanted_ahead", "commanded walk, forward", "m/s", |robot, period_s| {
        robot.command.as_ref().map(|command| command.walk.unwrap_or_default().dx / period_s)
    }),
    of_robot("wanted_left", "commanded walk, to the left", "m/s", |robot, period_s| {
        robot.command.as_ref().map(|command| command.walk.unwrap_or_default().dy / period_s)
    }),
    of_robot("wanted_turn", "commanded turn", "°/s", |robot, period_s| {
        robot.command.as_ref().map(|command| to_degrees(command.walk.unwrap_or_default().dtheta) / period_s)
    }),
    of_robot("x", "place x", "m", |robot, _| Some(robot.pose.position.x)),
    of_robot("y", "place y", "m", |robot, _| Some(robot.pose.position.y)),
    of_robot("heading", "heading", "°", |robot, _| Some(to_degrees(robot.pose.heading))),
    of_robot("head_yaw", "head yaw", "°", |robot, _| Some(to_degrees(robot.head.yaw))),
    of_robot("head_pitch", "head pitch", "°", |robot, _| Some(to_degrees(robot.head.pitch))),
    of_robot("left_sonar", "left sonar", "m", |robot, _| robot.sonar.left),
    of_robot("right_sonar", "right sonar", "m", |robot, _| robot.sonar.right),
    of_ball("ball_x", "ball, place x", "m", |ball| ball.x),
    of_ball("ball_y", "ball, place y", "m", |ball| ball.y),
];

impl Measured {
    /// Whether it is of the ball.
    pub(super) fn is_of_ball(self) -> bool {
        matches!(self.of, Of::Ball(_))
    }

    /// The values of all robots, or of the ball, in a cycle of this duration, s.
    pub(super) fn values(self, sample: &CycleSample, period_s: f64) -> Vec<(Subject, f32)> {
        match self.of {
            Of::Ball(of) => sample.ball.map(|ball| (Subject::Ball, of(ball))).into_iter().collect(),
            Of::Robot(of) => {
                let robots = sample.robots.iter();
                robots.filter_map(|(id, robot)| Some((Subject::Robot(*id), of(robot, period_s as f32)?))).collect()
            }
        }
    }
}
