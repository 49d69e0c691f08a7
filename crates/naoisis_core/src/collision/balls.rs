//! Several balls in a match: each is an obstacle to the others, and shares its motion with one that it meets.
//!
//! The balls move one after the other. A ball meets those that have moved already where they went, and the others where they are about
//! to go. It bounces off as from an obstacle; then both have the velocities of two equal balls with the restitution e: of the speed a
//! with which they approach, each takes (1 + e) a / 2 from the other. Places are right to the way that a ball goes in a cycle, and
//! velocities keep the momentum.

use bevy::prelude::*;

use super::ball::BallContact;
use super::ball_obstacle::BallObstacle;
use super::{CollidingBallReadOnlyItem, Scratch};
use crate::ball::ExtraBall;

/// A ball in this cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct MovingBall {
    /// None for the first.
    which: Option<ExtraBall>,
    pub(super) entity: Entity,
    start: Vec2,
    /// Where it goes without collisions, or went.
    pub(super) end: Vec2,
    radius: f32,
    /// Height of its lowest point at the start, m.
    height_m: f32,
    /// What balls that met it have added to its velocity, m/s.
    push: Vec2,
}

impl MovingBall {
    fn of(ball: &CollidingBallReadOnlyItem) -> Self {
        MovingBall {
            which: ball.which.copied(),
            entity: ball.entity,
            start: ball.previous.0.position,
            end: ball.pose.position,
            radius: ball.physics.radius_m,
            height_m: ball.path.start_flight.height_m,
            push: Vec2::ZERO,
        }
    }

    /// Returns the outline of the ball from above, and the heights of its lower and upper edge, m.
    pub(super) fn outline(&self) -> (BallObstacle, [f32; 2]) {
        let outline = BallObstacle::Ball { start: self.start, end: self.end, radius: self.radius };
        (outline, [self.height_m, self.height_m + 2.0 * self.radius])
    }

    /// Returns whether the ball may touch something within `reach` of `place` in this cycle, m.
    pub(super) fn is_within(&self, place: Vec2, reach: f32) -> bool {
        let reach = reach + self.radius + self.start.distance(self.end);
        self.start.distance_squared(place) <= reach * reach
    }

    /// Returns the velocity that other balls have given to this one since the last call, m/s, and sets it to zero.
    pub(super) fn take_push(&mut self) -> Vec2 {
        core::mem::take(&mut self.push)
    }
}

impl Scratch {
    /// Collects the balls of this cycle, the first ball first.
    pub(super) fn gather_balls<'a>(&mut self, balls: impl Iterator<Item = CollidingBallReadOnlyItem<'a, 'a>>) {
        self.balls.clear();
        self.balls.extend(balls.map(|ball| MovingBall::of(&ball)));
        self.balls.sort_by_key(|ball| ball.which);
        self.ball_contacts.clear();
    }

    /// Collects the balls that are in the way of one: all for a flying ball, those near the ground for a rolling one.
    pub(super) fn set_other_balls(&mut self, index: usize, is_flying: bool) {
        self.others.clear();
        let others = (0..self.balls.len()).filter(|&other| other != index);
        self.others.extend(others.filter(|&other| is_flying || self.balls[other].height_m < self.balls[other].radius));
    }

    /// Keeps the contacts of a ball that has just moved, and pushes the balls that it met: the obstacles from `first` on. Returns what
    /// this changes its own velocity by, m/s.
    pub(super) fn share_motion(&mut self, first: usize, restitution: f32) -> Vec2 {
        let mut own = Vec2::ZERO;
        for (index, contact) in self.new_contacts.iter().enumerate() {
            let is_same = |earlier: &BallContact| earlier.obstacle == contact.obstacle;
            let Some(other) = contact.obstacle.checked_sub(first) else {
                // What a robot or a post gave it afterwards stays.
                own = Vec2::ZERO;
                self.ball_contacts.push(*contact);
                continue;
            };
            let push = contact.normal * (-0.5 * (1.0 + restitution) * contact.approach_speed);
            own += push;
            // In a squeeze they meet many times.
            if !self.new_contacts[..index].iter().any(is_same) {
                self.balls[self.others[other]].push += push;
            }
        }
        own
    }
}
