//! Walking step by step: how the gait and the ground change walk commands.
//!
//! The paper's robots execute commands at once and exactly. The legs of a real robot change their speed only from step to step,
//! within limits; turning and walking sideways reduce the forward speed; and commands below a least speed are steps on the spot.
//! In addition the feet slip: by a share and a heading drift that are constant for each robot and match, and by noise of each
//! step. Odometry (`naoisis_sensing::sensing::odometry`) measures the motion of the legs, without the slip.
//!
//! Nothing here depends on the duration of a cycle.

use bevy::math::ops;
use bevy::prelude::*;
use core::f32::consts::{FRAC_PI_2, PI};
use serde::{Deserialize, Serialize};

use super::motion_settings::MotionSettings;
pub use super::motion_settings::{BallTouch, Gait, Slip, StepNoise, WalkVolume};
use super::walk_command::WalkCommand;
use crate::knowledge::Knowledge;
use crate::random::RandomStream;

impl StepNoise {
    /// Draws the error of `step`: forward and to the left, m, and of the turn, radians.
    pub fn draw(&self, step: WalkCommand, stream: &mut RandomStream) -> WalkCommand {
        let (way, turn) = (step.translation().length(), step.dtheta.abs());
        let translation_sd = self.translation_sd_m * way.sqrt();
        let heading_variance =
            self.heading_per_metre_sd * self.heading_per_metre_sd * way + self.rotation_sd * self.rotation_sd * turn;
        WalkCommand {
            dx: stream.gaussian(translation_sd),
            dy: stream.gaussian(translation_sd),
            dtheta: stream.gaussian(heading_variance.sqrt()),
        }
    }
}

/// The displacement of the last cycle after slip, m and radians, in the robot frame before the turn. A collision may have
/// shortened it further.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct GroundStep(pub WalkCommand);

/// The state of a robot's gait.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct GaitState {
    /// Velocity of the legs in the current step: forward and to the left, m/s, and counter-clockwise, rad/s.
    velocity: Vec3,
    /// The same velocity after slip.
    on_ground: Vec3,
    /// Remaining duration of the current step, s.
    left_s: f32,
    /// Deviation of this robot's slip and drift from the mean, in standard deviations; `None` before its first step.
    footing: Option<[f32; 2]>,
}

impl GaitState {
    /// Stops at once.
    pub fn stand(&mut self) {
        if self.left_s != 0.0 || self.velocity != Vec3::ZERO {
            (self.velocity, self.on_ground, self.left_s) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        }
    }

    /// The displacements of a cycle of `period` seconds with `command`: of the legs, and after slip. Each step follows the command
    /// at its beginning, and slips as a whole.
    pub fn walk(
        &mut self,
        command: WalkCommand,
        gait: &Gait,
        motion: &MotionSettings,
        period: f32,
        stream: &mut RandomStream,
    ) -> [WalkCommand; 2] {
        /// Durations below this are zero, s.
        const NOTHING_S: f32 = 1e-6;

        let ([mut way, mut on_ground], mut left_s) = ([Vec3::ZERO; 2], period);
        while left_s > NOTHING_S {
            if self.left_s <= NOTHING_S {
                let wanted = gait.reachable(Vec3::new(command.dx, command.dy, command.dtheta) / period, motion);
                self.velocity = gait.velocity_after(gait.within(self.velocity, motion), wanted, gait.step_s);
                if self.velocity == Vec3::ZERO {
                    self.stand();
                    break;
                }
                self.on_ground = self.slip(self.velocity * gait.step_s, &gait.slip, stream) / gait.step_s;
                self.left_s = gait.step_s;
            }
            let time_s = left_s.min(self.left_s);
            way += self.velocity * time_s;
            on_ground += self.on_ground * time_s;
            left_s -= time_s;
            self.left_s -= time_s;
        }
        [way, on_ground].map(|way| WalkCommand::new(way.x, way.y, way.z))
    }

    /// The velocity of the swinging foot relative to the robot, m/s, robot frame; zero for a robot that stands. A foot lifts off and lands
    /// with the speed of the body, and is fastest in between.
    pub fn foot_velocity(&self, gait: &Gait) -> Vec2 {
        // The mean of the sine over half a period is 2/π.
        let swing = FRAC_PI_2 * ops::sin(PI * (self.left_s / gait.step_s).clamp(0.0, 1.0));
        self.on_ground.truncate() * (gait.touch.foot_speed - 1.0) * swing
    }

    /// The step of the legs after slip.
    fn slip(&mut self, step: Vec3, slip: &Slip, stream: &mut RandomStream) -> Vec3 {
        let [scale, drift] = *self.footing.get_or_insert_with(|| [stream.gaussian(1.0), stream.gaussian(1.0)]);
        // Slip does not reverse the direction.
        let scale = (slip.scale + scale * slip.scale_sd).max(0.0);
        let translation = step.truncate();
        let drift = drift * slip.drift_sd * translation.length();
        let error = slip.error.draw(WalkCommand::new(step.x, step.y, step.z), stream);
        let error = Vec3::new(error.dx, error.dy, error.dtheta);
        (scale * translation).extend(step.z + drift) + error
    }
}

impl BallTouch {
    /// Draws the angle by which a touched ball leaves aside of the direction in which it is pushed, radians. The ball never leaves
    /// backwards.
    pub fn deflection(&self, stream: &mut RandomStream) -> f32 {
        /// The greatest angle, radians.
        const MOST: f32 = 0.7;
        stream.gaussian(self.direction_sd).clamp(-MOST, MOST)
    }
}

impl WalkVolume {
    /// The size of a velocity, given in `shares` of the limits ahead, sideways and of turning; 1 for the fastest possible velocities.
    fn size(&self, shares: Vec3) -> f32 {
        let combined = |a: f32, b: f32, exponent: f32| {
            if exponent == 1.0 || a == 0.0 || b == 0.0 {
                return a + b;
            }
            // (a^e + b^e)^(1/e), with logarithms, which take half the time of powers.
            let (less, more) = (a.min(b), a.max(b));
            let share = ops::exp(exponent * ops::ln(less / more));
            more * ops::exp(ops::ln(1.0 + share) / exponent)
        };
        combined(combined(shares.x, shares.y, self.translation_exponent), shares.z, self.rotation_exponent)
    }
}

impl Gait {
    /// `velocity` (m/s, m/s, rad/s) scaled down to what the robot can walk.
    fn within(&self, velocity: Vec3, motion: &MotionSettings) -> Vec3 {
        let forward = if velocity.x < 0.0 { self.backward_mps } else { motion.max_linear_mps };
        let greatest = Vec3::new(forward, self.sideways_mps, motion.max_angular);
        // A direction in which the robot cannot walk does not reduce the others.
        let possible = Vec3::select(greatest.cmpgt(Vec3::ZERO), velocity, Vec3::ZERO);
        let shares = possible.abs() / greatest.max(Vec3::splat(f32::MIN_POSITIVE));
        // The size is at most the sum of the shares.
        if shares.element_sum() <= 1.0 {
            return possible;
        }
        let size = self.volume.size(shares);
        if size > 1.0 { possible / size } else { possible }
    }

    /// The steady velocity for the commanded velocity `wanted`: limited to what the robot can walk, and zero below the least
    /// speeds.
    pub fn reachable(&self, wanted: Vec3, motion: &MotionSettings) -> Vec3 {
        self.walked(self.within(wanted, motion))
    }

    /// The steady velocity for a `velocity` that the robot can walk: zero below the least speeds.
    pub fn walked(&self, velocity: Vec3) -> Vec3 {
        let Vec3 { x, y, z } = velocity;
        let gets_ahead = Vec2::new(x, y).length() >= self.least_mps;
        let turns = z.abs() >= self.least_angular;
        let [x, y] = if gets_ahead { [x, y] } else { [0.0; 2] };
        Vec3::new(x, y, if turns { z } else { 0.0 })
    }

    /// The velocity (m/s, m/s, rad/s) that the legs have `seconds` after a `velocity`, for the commanded velocity `wanted`.
    pub fn velocity_after(&self, velocity: Vec3, wanted: Vec3, seconds: f32) -> Vec3 {
        let translation = velocity.truncate().move_towards(wanted.truncate(), self.acceleration_mps2 * seconds);
        let most_turn = self.angular_acceleration * seconds;
        translation.extend(velocity.z + (wanted.z - velocity.z).clamp(-most_turn, most_turn))
    }

    /// The greatest speed from which the robot comes to rest within `distance_m`, m/s. The step in progress is still walked at that speed.
    pub fn braking_speed(&self, distance_m: f32) -> f32 {
        braking_speed(distance_m, self.acceleration_mps2, self.step_s)
    }

    /// The greatest turning speed from which the robot comes to rest within `angle`, rad/s.
    pub fn braking_turn(&self, angle: f32) -> f32 {
        braking_speed(angle, self.angular_acceleration, self.step_s)
    }
}

/// The greatest speed v from which steps of duration s, each slower by a s, end within a distance d. The first step still has
/// speed v: d = v s + v²/(2 a) - v s/2, therefore v = -a s/2 + √((a s/2)² + 2 a d).
fn braking_speed(distance: f32, acceleration: f32, step_s: f32) -> f32 {
    let half = acceleration * step_s / 2.0;
    (half * half + 2.0 * acceleration * distance.max(0.0)).sqrt() - half
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    /// The displacement of the legs in `seconds` of a constant command, and how long each velocity lasted.
    fn walked(velocity: [f32; 3], cycles_per_second: u32, seconds: u32, state: &mut GaitState) -> Vec3 {
        let period = 1.0 / cycles_per_second as f32;
        let [x, y, z] = velocity.map(|velocity| velocity * period);
        let mut stream = RandomStream::for_match(1, "gait test");
        let mut way = Vec3::ZERO;
        for _ in 0..cycles_per_second * seconds {
            let [step, on_ground] =
                state.walk(WalkCommand::new(x, y, z), &Gait::default(), &motion(), period, &mut stream);
            assert_eq!(step, on_ground);
            way += Vec3::new(step.dx, step.dy, step.dtheta);
        }
        way
    }

    #[test]
    fn over_a_step_the_foot_is_on_average_as_fast_as_the_setting_says() {
        let touch = BallTouch { foot_speed: 2.0, direction_sd: 0.0 };
        let gait = Gait { touch, ..Gait::default() };
        let mean = |count: u32| {
            let phases = (0..count).map(|step| (step as f32 + 0.5) / count as f32);
            let speeds = phases.map(|phase| {
                let state = GaitState { on_ground: Vec3::new(0.2, 0.0, 0.3), left_s: phase * gait.step_s, ..default() };
                state.foot_velocity(&gait).x
            });
            speeds.sum::<f32>() / count as f32
        };
        // The body walks at 0.2 m/s, the foot at 0.4 m/s.
        assert_abs_diff_eq!(mean(1000), 0.2, epsilon = 1e-4);
        assert_eq!(GaitState::default().foot_velocity(&gait), Vec2::ZERO, "it stands");
    }

    fn motion() -> MotionSettings {
        MotionSettings { max_linear_mps: 0.24, max_angular: 1.6, ..MotionSettings::default() }
    }

    #[test]
    fn speed_grows_from_step_to_step_and_does_not_depend_on_the_cycle() {
        for cycles_per_second in [4, 10, 30, 83] {
            let mut state = GaitState::default();
            // Steps of 0.25 s at 0.075, 0.15, 0.225 and then 0.24 m/s.
            let way = walked([1.0, 0.0, 0.0], cycles_per_second, 1, &mut state);
            assert_abs_diff_eq!(way.x, 0.25 * (0.075 + 0.15 + 0.225 + 0.24), epsilon = 1e-4);
            // And back: two steps at 0.165 and 0.09 forwards, two at 0.015 and -0.06.
            let way = walked([-1.0, 0.0, 0.0], cycles_per_second, 1, &mut state);
            assert_abs_diff_eq!(way.x, 0.25 * (0.165 + 0.09 + 0.015 - 0.06), epsilon = 1e-4);
        }
    }

    #[test]
    fn sideways_and_turning_take_from_forward() {
        let (gait, motion) = (Gait::default(), motion());
        assert_eq!(gait.reachable(Vec3::new(9.0, 0.0, 0.0), &motion), Vec3::new(0.24, 0.0, 0.0));
        assert_eq!(gait.reachable(Vec3::new(-9.0, 0.0, 0.0), &motion), Vec3::new(-0.15, 0.0, 0.0));
        // Half of each.
        let all = gait.reachable(Vec3::new(0.24, 0.0, 1.6), &motion);
        assert_abs_diff_eq!(all, Vec3::new(0.12, 0.0, 0.8), epsilon = 1e-6);
        // A third of each.
        let all = gait.reachable(Vec3::new(0.24, -0.19, 1.6), &motion);
        assert_abs_diff_eq!(all, Vec3::new(0.24, -0.19, 1.6) / 3.0, epsilon = 1e-6);
        // Too slow to get anywhere.
        assert_eq!(gait.reachable(Vec3::new(0.01, 0.01, 0.05), &motion), Vec3::ZERO);
        let cannot_turn = MotionSettings { max_angular: 0.0, ..motion };
        assert_eq!(gait.reachable(Vec3::new(0.2, 0.0, 1.0), &cannot_turn), Vec3::new(0.2, 0.0, 0.0));
    }

    #[test]
    fn with_greater_exponents_speeds_are_combined_with_less_loss() {
        let speeds = |translation_exponent: f32, rotation_exponent: f32, wanted: Vec3| {
            let volume = WalkVolume { translation_exponent, rotation_exponent };
            let gait = Gait { volume, ..Gait::default() };
            gait.reachable(wanted * Vec3::new(0.24, 0.19, 1.6), &motion()) / Vec3::new(0.24, 0.19, 1.6)
        };
        // In an ellipsoid, equal shares are 1/√2 of two limits and 1/√3 of three.
        let slant = speeds(2.0, 2.0, Vec3::new(1.0, -1.0, 0.0));
        assert_abs_diff_eq!(slant, Vec3::new(1.0, -1.0, 0.0) * 0.5f32.sqrt(), epsilon = 1e-5);
        assert_abs_diff_eq!(speeds(2.0, 2.0, Vec3::ONE), Vec3::ONE / 3.0f32.sqrt(), epsilon = 1e-5);
        // The solutions of 2 s^1.6 = 1, and of (2 s^1.6)^(5/3 / 1.6) + s^(5/3) = 1.
        assert_abs_diff_eq!(speeds(1.6, 5.0 / 3.0, Vec3::new(1.0, 1.0, 0.0)).x, 0.6484, epsilon = 1e-4);
        assert_abs_diff_eq!(speeds(1.6, 5.0 / 3.0, Vec3::ONE).z, 0.5113, epsilon = 1e-4);
        // A velocity within the volume, or in one direction, is as with exponents of 1.
        assert_eq!(speeds(1.6, 5.0 / 3.0, Vec3::new(0.5, 0.5, 0.0)), Vec3::new(0.5, 0.5, 0.0));
        assert_abs_diff_eq!(speeds(1.6, 5.0 / 3.0, Vec3::Z * 2.0), Vec3::Z, epsilon = 1e-6);
    }

    #[test]
    fn who_brakes_in_time_stops_where_it_should() {
        let gait = Gait::default();
        let velocity = Vec3::new(0.225, 0.0, 0.0);
        let mut state = GaitState { velocity, on_ground: velocity, left_s: gait.step_s, footing: None };
        let way = walked([0.0; 3], 30, 3, &mut state);
        // The step under way, and two of 0.15 and 0.075 m/s.
        assert_abs_diff_eq!(way.x, 0.25 * (0.225 + 0.15 + 0.075), epsilon = 1e-4);
        assert_abs_diff_eq!(gait.braking_speed(way.x), 0.225, epsilon = 1e-4);
        assert_eq!((state.velocity, state.left_s), (Vec3::ZERO, 0.0));
        assert_abs_diff_eq!(gait.braking_speed(0.0), 0.0, epsilon = 1e-6);
    }

    #[test]
    fn slip_is_a_bias_of_each_robot_and_the_rest_grows_with_the_roots_of_way_and_turn() {
        let error = StepNoise { translation_sd_m: 0.02, heading_per_metre_sd: 0.05, rotation_sd: 0.1 };
        let slip = Slip { scale: 0.9, scale_sd: 0.05, drift_sd: 0.1, error };
        let mut stream = RandomStream::for_match(3, "gait test");
        let robots = 4000;
        let mut squares = [0.0f64; 3];
        let mut mean = 0.0;
        for _ in 0..robots {
            // A metre in a straight line, in 20 steps.
            let mut state = GaitState::default();
            let mut way = Vec3::ZERO;
            for _ in 0..20 {
                way += state.slip(Vec3::new(0.05, 0.0, 0.0), &slip, &mut stream);
            }
            mean += f64::from(way.x) / f64::from(robots);
            for (square, error) in squares.iter_mut().zip([way.x - 0.9, way.y, way.z]) {
                *square += f64::from(error * error) / f64::from(robots);
            }
        }
        // Bias and error add up as squares. A standard deviation of 4000 is known to 1.1 %: four of them, 99.99 % confidence.
        assert_abs_diff_eq!(mean, 0.9, epsilon = 4.0 * 0.054 / 4000.0_f64.sqrt());
        for (square, expected) in squares.into_iter().zip([0.05_f64.hypot(0.02), 0.02, 0.1_f64.hypot(0.05)]) {
            assert!((square.sqrt() / expected - 1.0).abs() < 4.0 * 0.0112, "{} instead of {expected}", square.sqrt());
        }
    }
}
