//! The ball: how it rolls and flies. In training there may be several.

pub mod flight;

use bevy::math::ops;
use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::cycle::{Cycle, CycleClock, CycleSystems};
use crate::geometry::Pose;
use crate::knowledge::Knowledge;
use flight::{BallFlight, FlightPhysics};

/// Moves the ball in [`CycleSystems::RollBall`] without collisions, which are resolved in [`CycleSystems::Collide`].
pub struct BallPlugin;

impl Plugin for BallPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Ball>()
            .register_type::<ExtraBall>()
            .register_type::<BallFlight>()
            .register_type::<BallPhysics>()
            .register_type::<BallVelocity>()
            .register_type::<BallPath>()
            .add_systems(Cycle, roll.in_set(CycleSystems::RollBall));
    }
}

/// Marks the ball: of several balls, the first. Its [`Pose`] is the position of its centre on the ground plane.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct Ball;

/// Marks a further ball of a training, with its number from 1 on. It has all components of the ball but [`Ball`]: the referee and
/// reports know one ball only.
#[derive(Component, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct ExtraBall(pub u8);

/// The ball's velocity along the ground, m/s, pitch frame.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct BallVelocity(pub Vec2);

/// Properties of the ball: its size, rolling, bounces, flight and look.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
pub struct BallPhysics {
    /// Radius, m: 0.03 (paper, section 3.1).
    pub radius_m: f32,
    /// The law by which it slows down.
    pub rolling: Rolling,
    /// Share of the approach speed that is left after a bounce: 0.4 (rUNSWift 2019).
    pub restitution: f32,
    /// The parameters of its flight.
    pub flight: FlightPhysics,
    /// Its colours, in images only.
    #[reflect(default)]
    #[serde(default)]
    pub look: BallLook,
}

impl Default for BallPhysics {
    fn default() -> Self {
        Self {
            radius_m: 0.03,
            rolling: Rolling::default(),
            restitution: 0.4,
            flight: FlightPhysics::default(),
            look: BallLook::default(),
        }
    }
}

/// The colours of a ball.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum BallLook {
    /// Orange, as the street hockey ball of 2010.
    #[default]
    Orange,
    /// White with twelve black pentagons, as footballs since 2016.
    Pentagons,
}

impl BallLook {
    /// Whether the ball is orange.
    pub fn is_orange(&self) -> bool {
        *self == BallLook::Orange
    }
}

/// The ball's path in the current cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct BallPath {
    /// Velocity at the start of the cycle, after any kick, m/s.
    pub start_velocity: Vec2,
    /// The vertices of the path, m: the position at the start of the cycle, at every bounce, and at the end.
    pub corners: Vec<Vec2>,
    /// Height and climb at the start of the cycle, after any kick.
    pub start_flight: BallFlight,
    /// The heights at the vertices, m above a ball on the ground; empty if the ball was on the ground during the whole cycle.
    pub heights_m: Vec<f32>,
}

/// Greatest speed at which a ball may be placed, m/s.
pub const FASTEST_MPS: f32 = 100.0;

/// Speed below which the ball is at rest, m/s. Exponential drag alone would never stop it.
pub const REST_SPEED_MPS: f32 = 1e-3;

/// The law by which a rolling ball slows down.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rolling {
    /// Drag proportional to the speed, per second: v(t) = v0 exp(-k t), until [`REST_SPEED_MPS`].
    ///
    /// B-Human 2013 used 0.5 /s for the orange 55 g ball, which makes the travel exactly proportional to the speed.
    ExponentialPerS(#[schemars(extend("exclusiveMinimum" = 0.0, "unit" = "/s"), range(max = 1000.0))] f32),
    /// Constant deceleration, m/s²: v(t) = v0 - a t. Teams use 0.30 to 0.39 for today's foam ball.
    ConstantMps2(#[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1000.0))] f32),
}

impl Default for Rolling {
    fn default() -> Self {
        Rolling::ExponentialPerS(0.5)
    }
}

impl Rolling {
    /// The distance rolled, m, and the remaining speed, m/s, after `time` seconds from `speed` m/s.
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

    /// The distance after which a ball with `speed`, m/s, is at rest, m.
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

    /// The launch speed of a ball that is at rest after `distance` m: the inverse of [`Rolling::distance`].
    pub fn speed_for_distance(self, distance: f32) -> f32 {
        match self {
            Rolling::ExponentialPerS(drag) => distance * drag + REST_SPEED_MPS,
            Rolling::ConstantMps2(deceleration) => {
                (2.0 * deceleration * distance + REST_SPEED_MPS * REST_SPEED_MPS).sqrt()
            }
        }
    }
}

impl Rolling {
    /// The launch speed that reaches `distance_m`, as a share of the launch speed that reaches `reach_m`.
    pub fn speed_share(self, distance_m: f32, reach_m: f32) -> f32 {
        let share = (distance_m / reach_m).clamp(0.0, 1.0);
        match self {
            // Neglects the speed below which a ball is at rest.
            Rolling::ExponentialPerS(_) => share,
            Rolling::ConstantMps2(_) => share.sqrt(),
        }
    }
}

/// The state of a ball at one instant, and its rolling law.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RollingBall {
    /// Position of its centre, m, pitch frame.
    pub position: Vec2,
    /// Its velocity, m/s, pitch frame.
    pub velocity: Vec2,
    /// Radius, m.
    pub radius: f32,
    /// The law by which it slows down.
    pub rolling: Rolling,
    /// Share of the approach speed left after a bounce.
    pub restitution: f32,
}

impl RollingBall {
    /// The ball `time` seconds later, without collisions.
    pub fn after(&self, time: f32) -> RollingBall {
        let speed = self.velocity.length();
        let (distance, left) = self.rolling.advance(speed, time);
        if speed <= REST_SPEED_MPS {
            return RollingBall { velocity: Vec2::ZERO, ..*self };
        }
        let direction = self.velocity / speed;
        RollingBall { position: self.position + direction * distance, velocity: direction * left, ..*self }
    }
}

impl BallPhysics {
    /// The ball at `position` with `velocity`.
    pub fn rolling_ball(&self, position: Vec2, velocity: Vec2) -> RollingBall {
        RollingBall { position, velocity, radius: self.radius_m, rolling: self.rolling, restitution: self.restitution }
    }
}

fn roll(
    clock: Res<CycleClock>,
    mut balls: Query<(&mut Pose, &BallPhysics, &mut BallVelocity, &mut BallFlight, &mut BallPath)>,
) {
    for (mut pose, physics, mut velocity, mut flight, mut path) in &mut balls {
        path.start_velocity = velocity.0;
        path.start_flight = *flight;
        path.corners.clear();
        path.heights_m.clear();
        path.corners.push(pose.position);
        if flight.is_airborne() {
            let mut ball = physics.flying_ball(pose.position, velocity.0, *flight);
            ball.advance(clock.period());
            path.heights_m.extend([flight.height_m, ball.position.z]);
            (pose.position, velocity.0) = (ball.position.truncate(), ball.velocity.truncate());
            *flight = ball.flight();
        } else {
            let end = physics.rolling_ball(pose.position, velocity.0).after(clock.period());
            pose.position = end.position;
            velocity.0 = end.velocity;
        }
        path.corners.push(pose.position);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    #[test]
    fn a_share_of_the_speed_goes_a_share_of_the_way() {
        for rolling in [Rolling::ExponentialPerS(0.5), Rolling::ConstantMps2(0.3)] {
            let full = rolling.speed_for_distance(5.0);
            let speed = full * rolling.speed_share(2.0, 5.0);
            assert_relative_eq!(rolling.distance(speed), 2.0, max_relative = 2e-3);
            assert_eq!(rolling.speed_share(6.0, 5.0), 1.0);
        }
    }

    #[test]
    fn exponential_drag_rolls_in_proportion_to_the_speed() {
        let rolling = Rolling::ExponentialPerS(0.5);
        // s = (v0 - v_rest) / k
        assert_relative_eq!(rolling.distance(2.0), (2.0 - 0.001) / 0.5);
        // s(t) = v0 (1 - exp(-k t)) / k, v(t) = v0 exp(-k t)
        let (distance, left) = rolling.advance(2.0, 1.0);
        assert_relative_eq!(distance, 4.0 * (1.0 - (-0.5_f32).exp()), max_relative = 1e-6);
        assert_relative_eq!(left, 2.0 * (-0.5_f32).exp(), max_relative = 1e-6);
    }

    #[test]
    fn constant_deceleration_rolls_with_the_square_of_the_speed() {
        let rolling = Rolling::ConstantMps2(0.3);
        // s = v0² / (2 a), apart from the speed at which the ball rests; after 2 s: s = v0 t - a t² / 2.
        assert_relative_eq!(rolling.distance(1.2), 1.2 * 1.2 / 0.6, max_relative = 1e-5);
        let (distance, left) = rolling.advance(1.2, 2.0);
        assert_relative_eq!(distance, 2.4 - 0.6, max_relative = 1e-6);
        assert_relative_eq!(left, 0.6, max_relative = 1e-6);
    }

    proptest! {
        #[test]
        fn the_cycle_length_does_not_change_where_the_ball_rests(
            speed in 0.0f32..30.0, drag in 0.1f32..2.0, period in 0.01f32..0.5, constant: bool,
        ) {
            let rolling = if constant { Rolling::ConstantMps2(drag) } else { Rolling::ExponentialPerS(drag) };
            let (mut left, mut distance, mut cycles) = (speed, 0.0f64, 0);
            while left > 0.0 && cycles < 100_000 {
                let (step, next) = rolling.advance(left, period);
                distance += f64::from(step);
                left = next;
                cycles += 1;
            }
            let expected = f64::from(rolling.distance(speed));
            prop_assert!((distance - expected).abs() < 1e-3 * expected.max(1.0), "{distance} {expected}");
        }

        #[test]
        fn speed_for_distance_is_the_inverse_of_distance(distance in 0.001f32..50.0, drag in 0.1f32..2.0) {
            for rolling in [Rolling::ExponentialPerS(drag), Rolling::ConstantMps2(drag)] {
                assert_relative_eq!(
                    rolling.distance(rolling.speed_for_distance(distance)), distance, max_relative = 1e-3
                );
            }
        }
    }
}
