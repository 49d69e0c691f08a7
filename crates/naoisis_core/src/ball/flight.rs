//! The ball in the air: gravity, drag, and bounces off the ground.
//!
//! A rolling ball is not handled here: its height and its climb are zero, and it moves by [`Rolling`](super::Rolling) alone.

use bevy::math::ops;
use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{BallPhysics, REST_SPEED_MPS};
use crate::knowledge::Knowledge;

/// Acceleration of free fall, m/s².
pub const GRAVITY_MPS2: f32 = 9.81;

/// Longest step in which a flight is computed, s.
pub(crate) const LONGEST_STEP_S: f32 = 1.0 / 120.0;

/// Speed after a bounce off the ground below which the ball rolls, m/s: it would rise by half a millimetre.
const LEAST_REBOUND_MPS: f32 = 0.1;

/// The share of its speed along the ground that a ball without spin loses before it rolls: 2/7, that of a solid sphere.
const SPEED_LOST_TO_SPIN: f32 = 2.0 / 7.0;

/// Height and vertical velocity of the ball. Both are zero for a ball on the ground.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct BallFlight {
    /// Height of its lowest point above the ground, m.
    pub height_m: f32,
    /// Vertical velocity, m/s, positive upwards.
    pub climb_mps: f32,
}

impl BallFlight {
    /// Whether the ball is in the air, or about to leave the ground.
    pub fn is_airborne(self) -> bool {
        self.height_m > 0.0 || self.climb_mps > 0.0
    }
}

/// Physical parameters of the ball in the air.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FlightPhysics {
    /// Deceleration by the air as a share of the squared speed, 1/m: 0.05 for a ball of 10 cm and 44 g with a drag coefficient
    /// of 0.5, density of the air 1.2 kg/m³.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "/m"))]
    pub drag_per_m: f32,
    /// Share of the vertical speed that is left after a bounce off the ground: 0.5 (a guess).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub ground_restitution: f32,
    /// Friction coefficient between ball and ground in a bounce: 0.4 (a guess).
    #[schemars(range(min = 0.0, max = 10.0))]
    pub ground_friction: f32,
}

impl Default for FlightPhysics {
    fn default() -> Self {
        Self { drag_per_m: 0.05, ground_restitution: 0.5, ground_friction: 0.4 }
    }
}

/// The state of a ball in the air at one instant, and its physics.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct FlyingBall {
    /// Position of its centre, m, pitch frame; z is the height above a ball on the ground.
    pub position: Vec3,
    /// Its velocity, m/s, pitch frame.
    pub velocity: Vec3,
    /// Its size, and its rolling, flight and bounces.
    pub physics: BallPhysics,
}

impl FlyingBall {
    /// Its height and vertical velocity.
    pub fn flight(&self) -> BallFlight {
        BallFlight { height_m: self.position.z, climb_mps: self.velocity.z }
    }

    /// Its centre, m, pitch frame.
    pub fn centre(&self) -> Vec3 {
        self.position + Vec3::Z * self.physics.radius_m
    }

    /// Moves the ball on by `time` seconds: it flies, bounces off the ground, and rolls once it no longer bounces.
    pub fn advance(&mut self, time: f32) {
        let mut left = time;
        while left > 0.0 {
            if !self.flight().is_airborne() {
                return self.roll(left);
            }
            let until_ground = self.time_until_ground();
            let step = until_ground.min(left).min(LONGEST_STEP_S);
            self.glide(step);
            left -= step;
            if step == until_ground {
                self.bounce_off_ground();
            }
        }
    }

    /// Time until the ball touches the ground, neglecting drag, s.
    fn time_until_ground(&self) -> f32 {
        let BallFlight { height_m, climb_mps } = self.flight();
        (climb_mps + (climb_mps * climb_mps + 2.0 * GRAVITY_MPS2 * height_m).sqrt()) / GRAVITY_MPS2
    }

    /// Flies for `time` seconds. Drag is computed from the speed at the start: v(t) = v0 / (1 + k v0 t).
    fn glide(&mut self, time: f32) {
        let slowed = self.physics.flight.drag_per_m * self.velocity.length() * time;
        let way_share = if slowed > 1e-6 { ops::ln_1p(slowed) / slowed } else { 1.0 };
        self.position += self.velocity * (way_share * time) - Vec3::Z * (GRAVITY_MPS2 * time * time / 2.0);
        self.velocity = self.velocity / (1.0 + slowed) - Vec3::Z * (GRAVITY_MPS2 * time);
    }

    /// Bounces off the ground. Friction slows a ball without spin down, at most until it rolls.
    fn bounce_off_ground(&mut self) {
        let FlightPhysics { ground_restitution, ground_friction, .. } = self.physics.flight;
        let fall_mps = (-self.velocity.z).max(0.0);
        let along = self.velocity.truncate();
        let speed = along.length();
        let lost = (ground_friction * (1.0 + ground_restitution) * fall_mps).min(SPEED_LOST_TO_SPIN * speed);
        let rebound = ground_restitution * fall_mps;
        let climb = if rebound < LEAST_REBOUND_MPS { 0.0 } else { rebound };
        self.velocity = (along.normalize_or_zero() * (speed - lost)).extend(climb);
        self.position.z = 0.0;
    }

    /// Rolls on the ground for `time` seconds.
    fn roll(&mut self, time: f32) {
        let start = self.physics.rolling_ball(self.position.truncate(), self.velocity.truncate());
        let end = start.after(time);
        self.position = end.position.extend(0.0);
        self.velocity = end.velocity.extend(0.0);
    }
}

impl BallPhysics {
    /// The ball at `position` with `velocity`, m and m/s on the ground, and `flight`.
    pub fn flying_ball(&self, position: Vec2, velocity: Vec2, flight: BallFlight) -> FlyingBall {
        FlyingBall {
            position: position.extend(flight.height_m.max(0.0)),
            velocity: velocity.extend(flight.climb_mps),
            physics: *self,
        }
    }
}

/// The horizontal and the vertical part, m/s, of a launch with `speed` m/s at `elevation` radians above the ground.
pub(crate) fn launch(speed: f32, elevation: f32) -> (f32, f32) {
    if elevation == 0.0 || speed <= REST_SPEED_MPS {
        return (speed, 0.0);
    }
    let (sin, cos) = ops::sin_cos(elevation);
    (speed * cos, speed * sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ball::Rolling;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    fn ball(velocity: Vec3, flight: FlightPhysics) -> FlyingBall {
        let physics = BallPhysics { rolling: Rolling::ConstantMps2(0.3), flight, ..BallPhysics::default() };
        FlyingBall { position: Vec3::ZERO, velocity, physics }
    }

    const NO_DRAG: FlightPhysics = FlightPhysics { drag_per_m: 0.0, ground_restitution: 0.5, ground_friction: 0.0 };

    #[test]
    fn without_drag_it_flies_on_a_parabola() {
        let mut flying = ball(Vec3::new(2.0, 0.0, 3.0), NO_DRAG);
        flying.advance(0.3);
        assert_abs_diff_eq!(
            flying.position,
            Vec3::new(0.6, 0.0, 3.0 * 0.3 - GRAVITY_MPS2 * 0.09 / 2.0),
            epsilon = 1e-4
        );
        // It lands after 2 v / g = 0.6116 s, and rises again at half the speed.
        flying.advance(0.3117);
        assert_abs_diff_eq!(flying.velocity, Vec3::new(2.0, 0.0, 1.5), epsilon = 2e-3);
        assert_abs_diff_eq!(flying.position.x, 2.0 * 0.6117, epsilon = 1e-3);
    }

    #[test]
    fn each_bounce_leaves_the_squared_restitution_of_the_height() {
        let mut flying = ball(Vec3::ZERO, NO_DRAG);
        flying.position.z = 1.0;
        let mut peaks = Vec::new();
        let mut before = flying;
        for _ in 0..4000 {
            flying.advance(0.001);
            if before.velocity.z > 0.0 && flying.velocity.z <= 0.0 {
                peaks.push(before.position.z);
            }
            before = flying;
        }
        assert_abs_diff_eq!(peaks[0], 0.25, epsilon = 1e-3);
        assert_abs_diff_eq!(peaks[1], 0.0625, epsilon = 1e-3);
        // In the end the ball lies on the ground.
        assert!(!flying.flight().is_airborne(), "{flying:?}");
    }

    #[test]
    fn the_air_slows_it_down_with_the_square_of_its_speed() {
        let drag = FlightPhysics { drag_per_m: 0.1, ..NO_DRAG };
        let mut flying = ball(Vec3::new(10.0, 0.0, 0.0), drag);
        flying.position.z = 10.0;
        flying.advance(0.2);
        // v = v0 / (1 + k v0 t), as long as the ball falls slowly.
        assert_abs_diff_eq!(flying.velocity.x, 10.0 / 1.2, epsilon = 0.02);
        assert_abs_diff_eq!(flying.position.x, 1.2_f32.ln() / 0.1, epsilon = 0.01);
    }

    #[test]
    fn friction_takes_at_most_what_it_needs_to_roll() {
        let rough = FlightPhysics { ground_friction: 10.0, ..NO_DRAG };
        let mut flying = ball(Vec3::new(1.4, 0.0, 1.0), rough);
        flying.advance(2.0 / GRAVITY_MPS2 + 1e-3);
        assert_abs_diff_eq!(flying.velocity.x, 1.0, epsilon = 1e-3);
        // mu (1 + e) v = 0.1 * 1.5 * 1, for a ball that hits the ground at 1 m/s.
        let smooth = FlightPhysics { ground_friction: 0.1, ..NO_DRAG };
        let mut flying = ball(Vec3::new(1.4, 0.0, 1.0), smooth);
        flying.advance(2.0 / GRAVITY_MPS2 + 1e-3);
        assert_abs_diff_eq!(flying.velocity.x, 1.25, epsilon = 1e-3);
    }

    #[test]
    fn a_launch_is_flat_without_elevation() {
        assert_eq!(launch(2.0, 0.0), (2.0, 0.0));
        let (along, up) = launch(2.0, core::f32::consts::FRAC_PI_6);
        assert_abs_diff_eq!(along, 3.0_f32.sqrt(), epsilon = 1e-6);
        assert_abs_diff_eq!(up, 1.0, epsilon = 1e-6);
    }

    proptest! {
        #[test]
        fn the_cycle_length_changes_a_flight_by_little(
            vx in -5.0f32..5.0, vz in 0.5f32..6.0, period in 0.005f32..0.2,
        ) {
            let start = ball(Vec3::new(vx, 1.0, vz), FlightPhysics { ground_restitution: 0.0, ..FlightPhysics::default() });
            let end = |period: f32| {
                let mut flying = start;
                let steps = (0.4 / period).ceil() as usize;
                for _ in 0..steps {
                    flying.advance(0.4 / steps as f32);
                }
                flying.position
            };
            prop_assert!(end(period).distance(end(0.4)) < 0.02, "{} {}", end(period), end(0.4));
        }

        #[test]
        fn it_never_gets_under_the_ground_and_comes_to_rest(
            vx in -20.0f32..20.0, vz in -20.0f32..20.0, height in 0.0f32..3.0, restitution in 0.0f32..=0.9,
        ) {
            let mut flying = ball(Vec3::new(vx, 0.0, vz), FlightPhysics { ground_restitution: restitution, ..FlightPhysics::default() });
            flying.position.z = height;
            for _ in 0..6000 {
                flying.advance(1.0 / 30.0);
                prop_assert!(flying.position.z >= -1e-4 && flying.position.is_finite(), "{flying:?}");
            }
            prop_assert!(!flying.flight().is_airborne() && flying.velocity == Vec3::ZERO, "{flying:?}");
        }
    }
}
