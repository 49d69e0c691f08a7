//! An inertial measurement unit: how fast the robot turns and accelerates, how far it leans, and whether it stands on its feet.
//!
//! Robots that programs play have it in realistic matches, and others where `sensors` of a scenario, a league or a robot of a scenario name
//! it: `"sensors": { "imu": {} }`, or `--set sensors.imu={}`.
//!
//! **What it measures.** The angular velocity of the torso, its acceleration including gravity (a robot that stands measures 9.81 m/s²
//! upwards), and roll and pitch. The torso rocks in walking as the [gaze](super::vision) does, so a robot can compensate the error of its
//! camera directions in part. A robot that falls turns faster and faster until it lies, and turns back in the last second of getting up.
//! A lying robot measures on which side it lies, and that its feet carry nothing. There are no shocks of steps and collisions, apart from
//! the change of velocity that they cause, and no rocking to the sides.
//!
//! **Units, frame and rate.** rad/s (degrees in files), m/s² and rad (degrees in files), in the robot's frame: x to the front, y to the left,
//! z up. Roll is positive to the right, pitch to the front. Once a cycle, for the motion of the previous cycle.
//!
//! **Noise.** Gaussian, independent in each cycle, and a bias of the angular velocity that is drawn once per match. The defaults are guesses
//! between the data sheets of MEMS units (0.005 to 0.05 °/s per √Hz, 100 to 200 µg per √Hz) and what a walking robot measures after its
//! filter. With all deviations 0 the unit is exact.

use bevy::math::ops::FloatPow;
use bevy::prelude::*;
use core::f32::consts::FRAC_PI_2;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use super::vision::gaze::GazeError;
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::{Pose, to_degrees, unit};
use naoisis_core::kick_geometry::Side;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::random::{RandomStream, RandomStreams};
use naoisis_core::robot::Velocity;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::posture::{LyingOn, Posture};

/// The acceleration of gravity, m/s².
const GRAVITY_MPS2: f32 = 9.81;

/// The time in which a robot rises at the end of getting up, s.
const RISE_S: f32 = 1.0;

/// The errors of the unit.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[require(ImuMemory)]
#[serde(default, deny_unknown_fields)]
pub struct Imu {
    /// Standard deviation of the angular velocity, °/s.
    #[serde(deserialize_with = "deviation")]
    pub turn_sd_degps: f32,
    /// Standard deviation of the bias of the angular velocity, °/s.
    #[serde(deserialize_with = "deviation")]
    pub turn_bias_sd_degps: f32,
    /// Standard deviation of the acceleration, m/s².
    #[serde(deserialize_with = "deviation")]
    pub acceleration_sd_mps2: f32,
    /// Standard deviation of roll and pitch, degrees.
    #[serde(deserialize_with = "deviation")]
    pub tilt_sd_deg: f32,
}

/// Reads a standard deviation: from 0 to 1000.
fn deviation<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f32, D::Error> {
    let number = f32::deserialize(deserializer)?;
    if (0.0..=1000.0).contains(&number) {
        Ok(number)
    } else {
        Err(D::Error::custom(format!("a standard deviation of {number}; expected 0 to 1000")))
    }
}

impl Default for Imu {
    fn default() -> Self {
        Self { turn_sd_degps: 0.5, turn_bias_sd_degps: 0.1, acceleration_sd_mps2: 0.05, tilt_sd_deg: 0.3 }
    }
}

/// What the unit measures.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
pub struct ImuReading {
    /// The angular velocity about x, y and z, °/s.
    pub turn_degps: [f32; 3],
    /// The acceleration including gravity, m/s².
    pub acceleration_mps2: [f32; 3],
    /// Roll and pitch, degrees.
    pub tilt_deg: [f32; 2],
    /// Whether the feet carry the robot.
    pub ground_contact: bool,
    /// The side of the body that is down, if the robot lies or gets up.
    pub lies_on: Option<LyingOn>,
}

/// What the unit keeps from cycle to cycle.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct ImuMemory {
    /// The true roll and pitch, radians, and velocity, m/s, of the last cycle; `None` before the first.
    before: Option<(Vec2, Vec2)>,
    /// The bias of the angular velocity, °/s; `None` until it is drawn.
    bias: Option<Vec3>,
}

/// Updates the readings of all robots that have the unit.
pub fn measure(
    clock: Res<CycleClock>,
    mut robots: Query<(
        &Imu,
        &mut ImuMemory,
        &mut ImuReading,
        &Pose,
        &Velocity,
        (&Posture, &Body),
        Option<&GazeError>,
        &mut RandomStreams,
    )>,
) {
    for (imu, mut memory, mut reading, pose, velocity, (posture, body), gaze, mut streams) in &mut robots {
        let sway = gaze.map_or(Vec2::ZERO, GazeError::drift);
        let tilt = tilt(*posture, sway, fall_s(body.height_m), clock.period());
        let motion = Motion { heading: pose.heading, velocity: *velocity, tilt };
        let stream = streams.own("imu");
        *reading = memory.reading(imu, &motion, *posture, clock.period(), stream);
    }
}

/// The true motion of a robot in a cycle.
struct Motion {
    /// Its heading, radians, pitch frame.
    heading: f32,
    velocity: Velocity,
    /// Roll and pitch, radians.
    tilt: Vec2,
}

impl ImuMemory {
    fn reading(
        &mut self,
        imu: &Imu,
        motion: &Motion,
        posture: Posture,
        period_s: f32,
        stream: &mut RandomStream,
    ) -> ImuReading {
        let Motion { heading, velocity, tilt } = *motion;
        let mut vector = |sd: f32| Vec3::new(stream.gaussian(sd), stream.gaussian(sd), stream.gaussian(sd));
        let bias = *self.bias.get_or_insert_with(|| vector(imu.turn_bias_sd_degps));
        let (tilt_before, velocity_before) =
            self.before.replace((tilt, velocity.linear)).unwrap_or((tilt, velocity.linear));
        let rocking = (tilt - tilt_before) / period_s;
        let turn = Vec3::from([rocking.x, rocking.y, velocity.angular].map(to_degrees));
        // From the pitch frame to the robot's.
        let forward = unit(heading);
        let change = (velocity.linear - velocity_before) / period_s;
        let acceleration =
            Vec3::new(change.dot(forward), change.dot(forward.perp()), 0.0) + upwards(tilt) * GRAVITY_MPS2;
        let tilt = Vec2::from(tilt.to_array().map(to_degrees)) + vector(imu.tilt_sd_deg).truncate();
        ImuReading {
            turn_degps: (turn + bias + vector(imu.turn_sd_degps)).to_array(),
            acceleration_mps2: (acceleration + vector(imu.acceleration_sd_mps2)).to_array(),
            tilt_deg: tilt.to_array(),
            ground_contact: posture.is_upright(),
            lies_on: posture.lying_on(),
        }
    }
}

/// The upward direction as a torso with this roll and pitch, radians, sees it.
fn upwards(tilt: Vec2) -> Vec3 {
    let (roll, pitch) = (unit(tilt.x), unit(tilt.y));
    Vec3::new(-pitch.y, pitch.x * roll.y, pitch.x * roll.x)
}

/// The time that a body of this height takes to fall over, s: 0.6 s for a NAO, as it takes more than twice the time scale of a pendulum to
/// leave its upright position.
fn fall_s(height_m: f32) -> f32 {
    2.5 * (height_m / GRAVITY_MPS2).sqrt()
}

/// Roll and pitch of the torso, radians; `sway` is the error of the camera directions, yaw and pitch, by which it rocks, and `fall_s` the
/// duration of a fall.
fn tilt(posture: Posture, sway: Vec2, fall_s: f32, period_s: f32) -> Vec2 {
    let lying = |on: LyingOn| match on {
        LyingOn::Front => Vec2::new(0.0, FRAC_PI_2),
        LyingOn::Back => Vec2::new(0.0, -FRAC_PI_2),
    };
    let share = |cycles: u64, duration_s: f32| (cycles as f32 * period_s / duration_s).min(1.0);
    // It falls faster and faster.
    let fallen = |cycles: u64| share(cycles + 1, fall_s).squared();
    match posture {
        // The gaze is down where the torso leans to the front.
        Posture::Upright => Vec2::new(0.0, sway.y),
        Posture::Fallen { on, cycles } => lying(on) * fallen(cycles),
        Posture::GettingUp { on, cycles, cycles_left } => lying(on) * fallen(cycles).min(share(cycles_left, RISE_S)),
        Posture::Diving { side: Side::Left, .. } => Vec2::new(-FRAC_PI_2 / 2.0, 0.0),
        Posture::Diving { side: Side::Right, .. } => Vec2::new(FRAC_PI_2 / 2.0, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use core::f32::consts::PI;

    const EXACT: Imu = Imu { turn_sd_degps: 0.0, turn_bias_sd_degps: 0.0, acceleration_sd_mps2: 0.0, tilt_sd_deg: 0.0 };

    fn readings(imu: &Imu, motions: &[(Motion, Posture)]) -> Vec<ImuReading> {
        let mut stream = RandomStream::for_match(1, "imu test");
        let mut memory = ImuMemory::default();
        motions.iter().map(|(motion, posture)| memory.reading(imu, motion, *posture, 0.1, &mut stream)).collect()
    }

    fn upright(heading: f32, linear: Vec2, angular: f32, sway: f32) -> (Motion, Posture) {
        let velocity = Velocity { linear, angular };
        (Motion { heading, velocity, tilt: tilt(Posture::Upright, Vec2::new(9.0, sway), 0.6, 0.1) }, Posture::Upright)
    }

    #[test]
    fn a_robot_measures_its_turning_its_acceleration_and_how_it_rocks_in_its_own_frame() {
        // It looks along -y of the pitch, and gets faster in that direction.
        let still = upright(-FRAC_PI_2, Vec2::ZERO, 0.0, 0.0);
        let faster = upright(-FRAC_PI_2, Vec2::new(0.0, -0.2), PI / 2.0, 0.01);
        let [first, second] = readings(&EXACT, &[still, faster])[..] else { panic!("two readings") };
        assert_eq!((first.turn_degps, first.tilt_deg, first.ground_contact), ([0.0; 3], [0.0; 2], true));
        assert_abs_diff_eq!(Vec3::from(first.acceleration_mps2), GRAVITY_MPS2 * Vec3::Z, epsilon = 1e-5);
        assert_abs_diff_eq!(Vec3::from(second.turn_degps), Vec3::new(0.0, to_degrees(0.1), 90.0), epsilon = 1e-3);
        let expected = Vec3::new(2.0 - 0.01 * GRAVITY_MPS2, 0.0, GRAVITY_MPS2);
        assert_abs_diff_eq!(Vec3::from(second.acceleration_mps2), expected, epsilon = 1e-3);
        assert_abs_diff_eq!(second.tilt_deg[1], to_degrees(0.01), epsilon = 1e-5);
    }

    #[test]
    fn a_robot_that_lies_knows_on_which_side() {
        for (on, upwards) in [(LyingOn::Front, Vec3::NEG_X), (LyingOn::Back, Vec3::X)] {
            let posture = Posture::Fallen { cycles: 9, on };
            let tilt = tilt(posture, Vec2::ONE, 0.6, 0.1);
            let motion = Motion { heading: 0.3, velocity: Velocity::default(), tilt };
            let reading = readings(&EXACT, &[(motion, posture)])[0];
            assert_eq!((reading.ground_contact, reading.lies_on), (false, Some(on)));
            assert_abs_diff_eq!(Vec3::from(reading.acceleration_mps2), GRAVITY_MPS2 * upwards, epsilon = 1e-4);
        }
    }

    #[test]
    fn a_fall_is_felt_as_it_happens_and_so_is_getting_up() {
        let on = LyingOn::Front;
        let pitch_deg = |posture: Posture| to_degrees(tilt(posture, Vec2::ZERO, fall_s(0.575), 0.1).y);
        let fall: Vec<f32> = (0..8).map(|cycles| pitch_deg(Posture::Fallen { cycles, on })).collect();
        let steps: Vec<f32> = fall.windows(2).map(|two| two[1] - two[0]).collect();
        // 0.6 s to lie, with a greater step each time.
        assert!(fall[0] > 0.0 && fall[0] < 5.0 && fall[4] < 80.0 && fall[6] == 90.0, "{fall:?}");
        assert!(steps[..5].is_sorted() && steps[6] == 0.0, "{steps:?}");
        let rise = [20, 10, 5, 1, 0].map(|cycles_left| pitch_deg(Posture::GettingUp { on, cycles: 40, cycles_left }));
        assert_abs_diff_eq!(&rise[..], &[90.0, 90.0, 45.0, 9.0, 0.0][..], epsilon = 1e-3);
        // One that gets up at once falls first.
        assert!(pitch_deg(Posture::GettingUp { on, cycles: 2, cycles_left: 40 }) < 30.0);
    }

    #[test]
    fn errors_have_their_deviations_and_the_bias_stays() {
        let imu = Imu { turn_bias_sd_degps: 5.0, ..Imu::default() };
        let motions: Vec<_> = (0..2000).map(|_| upright(0.0, Vec2::ZERO, 0.0, 0.0)).collect();
        let readings = readings(&imu, &motions);
        let turns: Vec<f64> = readings.iter().map(|reading| f64::from(reading.turn_degps[2])).collect();
        let mean = turns.iter().sum::<f64>() / 2000.0;
        let deviation = (turns.iter().map(|turn| (turn - mean).powi(2)).sum::<f64>() / 2000.0).sqrt();
        // The deviation of 2000 draws is known to 0.5 / sqrt(4000) = 0.008; four of them.
        assert!((deviation - 0.5).abs() < 0.032 && mean.abs() > 0.1, "{mean} {deviation}");
    }
}
