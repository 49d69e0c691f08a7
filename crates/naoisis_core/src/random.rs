//! Random numbers: one stream for each robot and purpose, derived from the match's seed.
//!
//! Because every purpose has a stream of its own, switching on the noise of one sensor of one robot changes neither the noise of other
//! robots nor that of the same robot's other sensors.

use bevy::prelude::*;
use core::convert::Infallible;
use rand::{Rng, SeedableRng, TryRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use crate::knowledge::Knowledge;
use crate::team::RobotId;

/// A reproducible stream of random numbers (xoshiro256++): the same on every platform.
#[derive(Clone, Debug, PartialEq, Eq, Reflect, Serialize)]
#[reflect(opaque)]
#[reflect(Serialize, Deserialize)]
pub struct RandomStream(Xoshiro256PlusPlus);

// By hand: the all-zero state is a fixed point of xoshiro, from which every draw would be 0. Reject it.
impl<'de> Deserialize<'de> for RandomStream {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let stream = Xoshiro256PlusPlus::deserialize(deserializer)?;
        let mut ahead = stream.clone();
        // Any other state yields four zeros in a row only with a probability of 2^-256.
        if (0..4).all(|_| ahead.next_u64() == 0) {
            return Err(D::Error::custom("a stream of random numbers in the all-zero state, which is a fixed point"));
        }
        Ok(Self(stream))
    }
}

impl RandomStream {
    /// The stream for `purpose` of `owner` in the match with this seed.
    pub fn new(seed: u64, owner: RobotId, purpose: &str) -> Self {
        Self::from_parts(seed, owner.stable_number(), purpose)
    }

    /// The stream for a purpose that belongs to no robot, such as the referee's choices.
    pub fn for_match(seed: u64, purpose: &str) -> Self {
        Self::from_parts(seed, 0, purpose)
    }

    fn from_parts(seed: u64, owner: u64, purpose: &str) -> Self {
        let mut hash = mix(seed ^ 0x006e_616f_6973_6973);
        hash = mix(hash ^ owner);
        for byte in purpose.bytes() {
            hash = mix(hash ^ u64::from(byte));
        }
        Self(Xoshiro256PlusPlus::seed_from_u64(hash))
    }

    /// Draws from the normal distribution with mean zero and `standard_deviation`. If that is zero, returns zero without a
    /// draw.
    pub fn gaussian(&mut self, standard_deviation: f32) -> f32 {
        if standard_deviation == 0.0 {
            return 0.0;
        }
        let draw: f32 = StandardNormal.sample(self);
        standard_deviation * draw
    }

    /// Draws from the uniform distribution over [0, 1).
    pub fn uniform(&mut self) -> f32 {
        // The upper 24 bits fill the mantissa exactly.
        (self.0.next_u64() >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Returns true with `probability`. Draws no number if `probability` is 0 or 1.
    pub fn chance(&mut self, probability: f32) -> bool {
        probability > 0.0 && (probability >= 1.0 || self.uniform() < probability)
    }
}

impl TryRng for RandomStream {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(self.0.next_u32())
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.0.next_u64())
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        self.0.fill_bytes(bytes);
        Ok(())
    }
}

/// The random streams of one robot, one for each purpose.
#[derive(Component, Clone, Debug, PartialEq, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct RandomStreams {
    seed: u64,
    robot: RobotId,
    /// Streams for custom purposes, by name.
    own: Vec<(String, RandomStream)>,
    /// Motion error of the walk.
    pub motion: RandomStream,
    /// Error of a kick's direction and speed, and of the direction of a ball that is touched in walking.
    pub kick: RandomStream,
    /// Noise, misses and false detections of the geometric vision.
    pub vision: RandomStream,
    /// Errors of the camera pose that last longer than a cycle.
    pub gaze: RandomStream,
    /// Detection of far and partly hidden objects by the geometric vision.
    pub recognition: RandomStream,
    /// Places of false positives of the vision.
    pub false_places: RandomStream,
    /// Noise and missed echoes of the sonars.
    pub sonar: RandomStream,
    /// Times of sonar pings, and crosstalk.
    pub sonar_pings: RandomStream,
    /// Error of the measured steps.
    pub odometry: RandomStream,
    /// Loss and delay of the messages to this robot.
    pub messages: RandomStream,
    /// Pixel noise of the camera images.
    pub camera: RandomStream,
    /// Falls of the robot.
    pub balance: RandomStream,
    /// Breakdowns.
    pub breakdowns: RandomStream,
    /// Slip of the robot's steps.
    pub slip: RandomStream,
}

impl RandomStreams {
    /// The streams of a robot in the match with this seed.
    pub fn new(seed: u64, robot: RobotId) -> Self {
        let stream = |purpose| RandomStream::new(seed, robot, purpose);
        Self {
            seed,
            robot,
            own: Vec::new(),
            motion: stream("motion"),
            kick: stream("kick"),
            vision: stream("vision"),
            gaze: stream("gaze"),
            recognition: stream("recognition"),
            false_places: stream("false places"),
            sonar: stream("sonar"),
            sonar_pings: stream("sonar pings"),
            odometry: stream("odometry"),
            messages: stream("messages"),
            camera: stream("camera"),
            balance: stream("balance"),
            breakdowns: stream("breakdowns"),
            slip: stream("slip"),
        }
    }

    /// Returns the robot's stream for a custom purpose, such as the noise of a custom sensor. The first call creates the stream, which is
    /// saved with the match.
    pub fn own(&mut self, purpose: &str) -> &mut RandomStream {
        let index = self.own.iter().position(|(name, _)| name == purpose).unwrap_or_else(|| {
            // No stream of the simulation itself has this prefix.
            let stream = RandomStream::new(self.seed, self.robot, &format!("own {purpose}"));
            self.own.push((purpose.to_owned(), stream));
            self.own.len() - 1
        });
        &mut self.own[index].1
    }
}

/// The random numbers of a robot's behaviour. A behaviour's marker [requires](Component#required-components) it, and its system
/// draws from it. The stream follows from the match's seed and the robot when the match starts, and is saved with the match.
///
/// ```
/// use bevy::prelude::*;
/// use naoisis::prelude::*;
///
/// #[derive(Component, Default)]
/// #[require(BehaviourRandom)]
/// struct Hesitant;
///
/// fn hesitate(clock: Res<CycleClock>, mut robots: Query<(&mut BehaviourRandom, &mut WalkCommand), With<Hesitant>>) {
///     for (mut random, mut walk) in &mut robots {
///         let speed_mps = if random.chance(0.5) { 0.1 } else { 0.0 };
///         *walk = WalkCommand::at_velocity(speed_mps, 0.0, 0.0, &clock);
///     }
/// }
///
/// App::new().add_plugins(NaoisisPlugins).add_behaviour::<Hesitant, _>("hesitant", hesitate);
/// ```
#[derive(Component, Clone, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize, Deref, DerefMut)]
#[reflect(Component, @Knowledge::Belief)]
pub struct BehaviourRandom(RandomStream);

impl BehaviourRandom {
    /// The stream of a robot's behaviour in the match with this seed.
    pub fn new(seed: u64, robot: RobotId) -> Self {
        Self(RandomStream::new(seed, robot, "behaviour"))
    }
}

impl Default for BehaviourRandom {
    /// A stream that is the same for all robots, used until the match starts.
    fn default() -> Self {
        Self(RandomStream::for_match(0, "behaviour"))
    }
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood: Fast Splittable Pseudorandom Number Generators, 2014).
fn mix(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::team::Team;

    #[test]
    fn streams_differ_by_seed_robot_and_purpose_and_repeat() {
        let blue1 = RobotId::new(Team::Blue, 1);
        let first = |mut stream: RandomStream| stream.next_u64();
        let reference = first(RandomStream::new(1, blue1, "motion"));
        assert_eq!(reference, first(RandomStream::new(1, blue1, "motion")));
        assert_ne!(reference, first(RandomStream::new(2, blue1, "motion")));
        assert_ne!(reference, first(RandomStream::new(1, blue1, "kick")));
        assert_ne!(reference, first(RandomStream::new(1, RobotId::new(Team::Pink, 1), "motion")));
    }

    #[test]
    fn a_purpose_of_ones_own_has_a_stream_that_disturbs_no_other() {
        let robot = RobotId::new(Team::Blue, 1);
        let mut streams = RandomStreams::new(1, robot);
        let first = streams.own("ear").next_u64();
        assert_ne!(streams.own("nose").next_u64(), first);
        assert_ne!(streams.own("ear").next_u64(), first);
        assert_eq!(RandomStreams::new(1, robot).own("ear").next_u64(), first);
        assert_ne!(RandomStreams::new(1, robot).own("sonar").next_u64(), streams.sonar.next_u64());
    }

    #[test]
    fn gaussian_draws_have_the_mean_and_deviation_asked_for() {
        let mut stream = RandomStream::for_match(7, "test");
        let count = 100_000;
        let draws: Vec<f64> = (0..count).map(|_| f64::from(stream.gaussian(0.5))).collect();
        let mean = draws.iter().sum::<f64>() / f64::from(count);
        let variance = draws.iter().map(|draw| (draw - mean).powi(2)).sum::<f64>() / f64::from(count);
        // Standard error of the mean: 0.5 / sqrt(1e5) = 0.0016; of the deviation: 0.5 / sqrt(2e5) = 0.0011.
        // Four of them hold with 99.99 % confidence.
        assert!(mean.abs() < 4.0 * 0.0016);
        assert!((variance.sqrt() - 0.5).abs() < 4.0 * 0.0011);
    }

    #[test]
    fn a_certain_outcome_draws_nothing() {
        let mut stream = RandomStream::for_match(7, "test");
        let before = stream.clone();
        assert!(stream.chance(1.0) && !stream.chance(0.0) && stream.gaussian(0.0) == 0.0);
        assert_eq!(stream, before);
    }
}
