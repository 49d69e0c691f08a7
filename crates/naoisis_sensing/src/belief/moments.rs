//! The odometry and the gaze of a robot at recent times, to which delayed percepts belong.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use crate::sensing::vision::Percepts;
use naoisis_core::geometry::Pose;

/// The greatest age of a moment that is kept, s.
const LONGEST_S: f64 = 2.5;
/// Times that differ by less than this are equal, s.
const SAME_S: f64 = 1e-4;

/// The odometry and the gaze at a time.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub(super) struct Moment {
    /// The time, s since the start of the match.
    pub(super) time_s: f64,
    /// The odometry at that time.
    pub(super) odometry: Pose,
    /// The yaw of the head, radians.
    pub(super) head_yaw: f32,
    /// Whether the robot walked.
    pub(super) is_walking: bool,
}

/// The recent moments, the oldest first.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub(super) struct Moments(VecDeque<Moment>);

impl Moments {
    /// Records `now`, and returns the moment at `time_s`, or `now` if that moment is not recorded.
    pub(super) fn at(&mut self, time_s: f64, now: Moment) -> Moment {
        while self.0.front().is_some_and(|oldest| oldest.time_s < now.time_s - LONGEST_S) {
            self.0.pop_front();
        }
        // The match may have been continued from an earlier time.
        while self.0.back().is_some_and(|latest| latest.time_s >= now.time_s) {
            self.0.pop_back();
        }
        self.0.push_back(now);
        self.0.iter().rev().find(|moment| moment.time_s < time_s + SAME_S).copied().unwrap_or(now)
    }
}

/// Transforms percepts of the moment `then` into the robot frame of `now`. The ball is moved on by its velocity `ball_mps` (m/s, robot
/// frame), if it is known.
pub(super) fn as_seen_now<'a>(
    percepts: &'a Percepts,
    (then, now): (Moment, Moment),
    ball_mps: Option<Vec2>,
    late: &'a mut Percepts,
) -> &'a Percepts {
    let late_s = now.time_s - then.time_s;
    if late_s == 0.0 {
        return percepts;
    }
    late.copy_from(percepts);
    late.move_to(then.odometry.relative(now.odometry));
    if let (Some(seen), Some(velocity)) = (&mut late.ball, ball_mps) {
        seen.position_m += velocity * late_s as f32;
    }
    late
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensing::vision::BallPercept;
    use approx::assert_abs_diff_eq;
    use naoisis_core::camera_model::CameraName;

    fn moment(time_s: f64, x: f32) -> Moment {
        Moment { time_s, odometry: Pose::new(x, 0.0, 0.0), head_yaw: x, is_walking: x > 0.0 }
    }

    #[test]
    fn delayed_percepts_belong_to_the_place_of_the_robot_at_their_time() {
        let mut moments = Moments::default();
        for tenth in 0..10 {
            moments.at(0.1 * f64::from(tenth), moment(0.1 * f64::from(tenth), 0.02 * tenth as f32));
        }
        let now = moment(1.0, 0.2);
        let then = moments.at(0.7, now);
        assert_eq!((then.time_s, then.head_yaw), (0.7000000000000001, 0.14));
        let ball = BallPercept::new(CameraName::TOP, Vec2::ZERO, Vec2::new(1.0, 0.5));
        let percepts = Percepts { ball: Some(ball), ..default() };
        let mut late = Percepts::default();
        // The ball is 0.06 m nearer because of the step, and it rolled away from the robot for 0.3 s at 1 m/s.
        let seen = as_seen_now(&percepts, (then, now), Some(Vec2::X), &mut late).ball.as_ref().unwrap();
        assert_abs_diff_eq!(seen.position_m, Vec2::new(1.24, 0.5), epsilon = 1e-5);
    }

    #[test]
    fn what_is_not_remembered_is_taken_for_new() {
        let mut moments = Moments::default();
        let now = moment(5.0, 0.3);
        assert_eq!(moments.at(4.9, now), now);
        // After 2.5 s a moment is forgotten.
        let later = moment(8.0, 0.4);
        assert_eq!(moments.at(5.0, later), later);
        let percepts = Percepts { time_s: 5.0, ..default() };
        assert_eq!(as_seen_now(&percepts, (later, later), None, &mut Percepts::default()), &percepts);
    }
}
