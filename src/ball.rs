//! The ball: how it rolls.

use bevy::math::ops;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::knowledge::Knowledge;

/// Marks the ball. Its [`Pose`](crate::geometry::Pose) is its centre's place above the ground.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct Ball;

/// The ball's velocity, m/s, pitch frame.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct BallVelocity(pub Vec2);

/// The ball's size and how it rolls and bounces.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
pub struct BallPhysics {
    /// Radius, m: 0.03 (paper, section 3.1).
    pub radius_m: f32,
    /// How it slows down.
    pub rolling: Rolling,
    /// Share of the approach speed that is left after a bounce: 0.4 (rUNSWift 2019).
    pub restitution: f32,
}

impl Default for BallPhysics {
    fn default() -> Self {
        Self { radius_m: 0.03, rolling: Rolling::default(), restitution: 0.4 }
    }
}

/// Below this speed the ball rests, m/s. Exponential drag alone would never stop it.
pub const REST_SPEED_MPS: f32 = 1e-3;

/// The law by which a rolling ball slows down.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rolling {
    /// Drag proportional to the speed, per second: v(t) = v0 exp(-k t), until [`REST_SPEED_MPS`].
    ///
    /// B-Human 2013 used 0.5 /s for the orange 55 g ball, which makes the travel exactly proportional to the speed.
    ExponentialPerS(f32),
    /// Constant deceleration, m/s²: v(t) = v0 - a t. Teams use 0.30 to 0.39 for today's foam ball.
    ConstantMps2(f32),
}

impl Default for Rolling {
    fn default() -> Self {
        Rolling::ExponentialPerS(0.5)
    }
}

impl Rolling {
    /// The distance rolled and the speed left after `time` seconds, from `speed` m/s.
    pub fn advance(self, speed: f32, time: f32) -> (f32, f32) {
        if speed <= REST_SPEED_MPS {
            return (0.0, 0.0);
        }
        match self {
            // s(t) = v0 (1 - exp(-k t)) / k; exp_m1 keeps the digits for small k t.
            Rolling::ExponentialPerS(drag) if drag > 0.0 => {
                let left = speed * ops::exp(-drag * time);
                if left <= REST_SPEED_MPS {
                    ((speed - REST_SPEED_MPS) / drag, 0.0)
                } else {
                    (-speed * ops::exp_m1(-drag * time) / drag, left)
                }
            }
            Rolling::ConstantMps2(deceleration) if deceleration > 0.0 => {
                let left = speed - deceleration * time;
                if left <= REST_SPEED_MPS { (self.distance(speed), 0.0) } else { ((speed + left) / 2.0 * time, left) }
            }
            _ => (speed * time, speed),
        }
    }

    /// The distance after which a ball of this speed rests, m.
    pub fn distance(self, speed: f32) -> f32 {
        if speed <= REST_SPEED_MPS {
            return 0.0;
        }
        match self {
            Rolling::ExponentialPerS(drag) => (speed - REST_SPEED_MPS) / drag,
            Rolling::ConstantMps2(deceleration) => {
                (speed * speed - REST_SPEED_MPS * REST_SPEED_MPS) / (2.0 * deceleration)
            }
        }
    }

    /// The speed at which a ball must leave to rest after `distance` m: the inverse of [`Rolling::distance`].
    pub fn speed_for_distance(self, distance: f32) -> f32 {
        match self {
            Rolling::ExponentialPerS(drag) => distance * drag + REST_SPEED_MPS,
            Rolling::ConstantMps2(deceleration) => {
                (2.0 * deceleration * distance + REST_SPEED_MPS * REST_SPEED_MPS).sqrt()
            }
        }
    }
}
