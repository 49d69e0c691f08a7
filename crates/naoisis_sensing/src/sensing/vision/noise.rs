//! The errors of the geometric vision, for each class of objects, and their presets.

use bevy::math::ops;
use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use naoisis_core::geometry::{file_units, to_radians};
use naoisis_core::random::RandomStream;

/// The detection errors of one class of objects.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClassNoise {
    /// Standard deviation of the measured pixel along u and along v, pixels.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "pixels"))]
    pub pixel_sd: f32,
    /// Probability that an object in view is not detected in a cycle.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub miss_probability: f32,
    /// Probability of a false detection in a cycle, at a new random place each time. Used for balls, goal posts and robots only.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub false_positive_probability: f32,
    /// Greatest distance of detection, m; `None` for unlimited.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub max_distance_m: Option<f32>,
    /// How the detection probability falls off with distance and visible size; `None` for a constant probability.
    #[serde(default)]
    pub falloff: Option<Falloff>,
}

/// The fall-off of the detection probability with distance: at a distance d it is 1 / (1 + (d / `half_distance_m`)^`exponent`), without the
/// [misses](ClassNoise::miss_probability). A partly visible object is treated as a whole one of the same visible area further away: its
/// distance is divided by the square root of the visible share.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Falloff {
    /// The distance at which the detection probability is 1/2, m.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1000.0))]
    pub half_distance_m: f32,
    /// The steepness: at twice that distance the odds against a detection are 2 to the power of this.
    #[schemars(range(min = 0.5, max = 100.0))]
    pub exponent: f32,
}

impl Falloff {
    /// The detection probability at a distance, m.
    pub fn share_at(&self, distance_m: f32) -> f32 {
        (1.0 + self.odds_against(distance_m)).recip()
    }

    /// The odds against a detection at a distance, m: the probability of a miss divided by that of a detection.
    pub fn odds_against(&self, distance_m: f32) -> f32 {
        power(distance_m / self.half_distance_m, self.exponent)
    }

    /// Draws a detection threshold. An object is detected unless [`odds_against`](Falloff::odds_against) its distance exceeds the
    /// threshold. With the probability `miss_probability` the threshold is negative: then the object is missed at every distance.
    pub fn draw_threshold(miss_probability: f32, stream: &mut RandomStream) -> f32 {
        // In (0, 1].
        let share = 1.0 - stream.uniform();
        (1.0 - miss_probability - share) / share
    }

    /// The distance at which the odds against a detection are `odds_against`, m.
    pub fn distance_of(&self, odds_against: f32) -> f32 {
        // The logarithm takes half the time of a power.
        self.half_distance_m * ops::exp(ops::ln(odds_against) / self.exponent)
    }
}

/// Returns `base` to the power of `exponent`. Small whole exponents are computed by multiplication, as `powf` would take as long as the
/// rest of a detection.
fn power(base: f32, exponent: f32) -> f32 {
    const MOST: u32 = 16;
    // The cast turns negative numbers and NaN into 0, which differs from them.
    let whole = exponent as u32;
    if whole as f32 != exponent || whole > MOST {
        return ops::powf(base, exponent);
    }
    let (mut left, mut square, mut product) = (whole, base, 1.0);
    while left > 0 {
        if left % 2 == 1 {
            product *= square;
        }
        square *= square;
        left /= 2;
    }
    product
}

/// The lasting error of the camera directions that follow from the measured joint angles: the body rocks, joints have play, and no robot is
/// calibrated exactly. The same for yaw and pitch; independent of the duration of a cycle.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GazeNoise {
    /// Standard deviation of the bias, which is constant in a match, radians (degrees in files).
    #[serde(rename = "bias_sd_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 180.0))]
    pub bias_sd: f32,
    /// Standard deviation of the drift while the robot stands, radians (degrees in files).
    #[serde(rename = "standing_sd_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 180.0))]
    pub standing_sd: f32,
    /// Standard deviation of the drift while the robot walks, radians (degrees in files).
    #[serde(rename = "walking_sd_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 180.0))]
    pub walking_sd: f32,
    /// The correlation time of the drift, s: after it the correlation is 1/e (a Gauss-Markov process of first order). Zero for an
    /// independent error in each cycle.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub correlation_s: f32,
}

/// The rate of lasting false positives: positions on the pitch at which a robot detects an object that is not there, in every image.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FalsePositives {
    /// Number of false positives that appear in a minute on the whole pitch; most of them are out of view.
    #[schemars(range(min = 0.0, max = 600.0))]
    pub per_minute: f32,
    /// Mean duration, s; durations are distributed exponentially.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub life_s: f32,
}

/// The error of the distance to a robot whose feet are hidden or below the image, as shares of the distance, if it is hidden up to its
/// waistband; in proportion if less is hidden.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct HiddenFeet {
    /// Mean: positive if the measured distance is too great.
    #[schemars(range(min = -1.0, max = 10.0), extend("unit" = ", a share of the distance"))]
    pub bias: f32,
    /// Standard deviation, drawn in each cycle.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = ", a share of the distance"))]
    pub sd: f32,
}

/// What the vision recognises of a robot's jersey and posture, besides its team. By default nothing.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct JerseyVision {
    /// The distance within which the number on chest and back is read, m.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub number_m: f32,
    /// Probability that another number is read, from 1 to 9.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub number_error: f32,
    /// The distance within which the direction in which the robot faces is recognised, m.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub heading_m: f32,
    /// Standard deviation of that direction, radians (degrees in files).
    #[serde(rename = "heading_sd_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 180.0))]
    pub heading_sd: f32,
    /// The distance within which the colour of the jersey is recognised, m.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub colour_m: f32,
    /// Probability that any of the ten colours of the GameController is recognised instead.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub colour_error: f32,
}

/// The share of a gaze's drift that is left a cycle later. Cached, as most robots have the same noise.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GazeDecay {
    correlation_s: f32,
    period_s: f32,
    left: f32,
}

impl GazeDecay {
    /// The share that is left after `period` seconds.
    pub fn after(&mut self, period: f32, noise: &GazeNoise) -> f32 {
        if [self.correlation_s, self.period_s] != [noise.correlation_s, period] {
            let left = if noise.correlation_s > 0.0 { ops::exp(-period / noise.correlation_s) } else { 0.0 };
            *self = Self { correlation_s: noise.correlation_s, period_s: period, left };
        }
        self.left
    }
}

impl ClassNoise {
    const fn new(pixel_sd: f32, miss_probability: f32, false_positive_probability: f32, max_distance_m: f32) -> Self {
        Self {
            pixel_sd,
            miss_probability,
            false_positive_probability,
            max_distance_m: Some(max_distance_m),
            falloff: None,
        }
    }

    /// The probability that an object at this distance, m, is detected if all of it is visible.
    pub fn detection_probability(&self, distance_m: f32) -> f32 {
        (1.0 - self.miss_probability) * self.falloff.map_or(1.0, |falloff| falloff.share_at(distance_m))
    }

    /// Whether an object at `place`, m, robot frame, is beyond the greatest distance.
    pub fn is_too_far(&self, place: Vec2) -> bool {
        self.max_distance_m.is_some_and(|distance| place.length_squared() > distance * distance)
    }
}

/// Errors of the geometric vision. In scenario files: `"none"`, `"default"`, or an object with a `preset` and the fields that
/// differ from it.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct VisionNoise {
    /// The ball.
    pub ball: ClassNoise,
    /// Goal posts.
    pub goal_posts: ClassNoise,
    /// Other robots.
    pub robots: ClassNoise,
    /// Line segments: the error of their ends.
    pub lines: ClassNoise,
    /// Line junctions.
    pub junctions: ClassNoise,
    /// Penalty crosses.
    pub penalty_crosses: ClassNoise,
    /// The centre circle: the error of its centre.
    pub centre_circle: ClassNoise,
    /// Standard deviation of the difference between the measured and the true camera directions, for yaw and pitch each, radians (degrees
    /// in files). Drawn in every cycle.
    #[serde(rename = "head_angle_sd_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 180.0))]
    pub head_angle_sd: f32,
    /// The lasting part of that difference. It also applies to rendered images.
    pub gaze: GazeNoise,
    /// Line junctions and penalty crosses that look like a ball.
    pub false_balls: FalsePositives,
    /// Places on the carpet that look like a robot.
    pub false_robots: FalsePositives,
    /// The error of the distance to robots whose feet are hidden.
    pub hidden_feet: HiddenFeet,
    /// The numbers and the headings of robots.
    pub jerseys: JerseyVision,
    /// Whether percepts have a confidence, which is higher for true detections than for false ones.
    pub confidence: bool,
}

impl Default for VisionNoise {
    fn default() -> Self {
        Self::standard()
    }
}

impl VisionNoise {
    /// The presets by name.
    pub const PRESETS: [(&'static str, fn() -> Self); 2] = [("none", Self::none), ("default", Self::standard)];

    /// The preset `none`: everything in view is detected, exactly and at any distance.
    pub fn none() -> Self {
        let exact = ClassNoise::default();
        Self {
            ball: exact,
            goal_posts: exact,
            robots: exact,
            lines: exact,
            junctions: exact,
            penalty_crosses: exact,
            centre_circle: exact,
            head_angle_sd: 0.0,
            gaze: GazeNoise::default(),
            false_balls: FalsePositives::default(),
            false_robots: FalsePositives::default(),
            hidden_feet: HiddenFeet::default(),
            jerseys: JerseyVision::default(),
            confidence: false,
        }
    }

    /// The preset `default`: what B-Human's simulator assumes of B-Human's vision (`oracledPerceptsProvider.cfg`,
    /// 2025). There, line junctions are computed from lines and have no figures: here they are missed as often as lines, with the error of
    /// the penalty mark and the range of the centre circle. The error of the head angles is that of SimSpark's restricted vision perceptor
    /// (0.12° and 0.15°). No error lasts from one image to the next.
    pub fn standard() -> Self {
        Self {
            ball: ClassNoise::new(1.0, 0.1, 0.0005, 5.0),
            goal_posts: ClassNoise::new(3.0, 0.1, 0.0, 8.0),
            robots: ClassNoise::new(3.0, 0.4, 0.005, 4.0),
            lines: ClassNoise::new(0.5, 0.4, 0.0, 5.0),
            junctions: ClassNoise::new(1.0, 0.4, 0.0, 3.5),
            penalty_crosses: ClassNoise::new(1.0, 0.2, 0.0, 2.5),
            centre_circle: ClassNoise::new(3.0, 0.8, 0.0, 3.5),
            head_angle_sd: to_radians(0.15),
            ..Self::none()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recognition_falls_off_as_a_function_of_the_distance() {
        let falloff = Falloff { half_distance_m: 4.0, exponent: 3.0 };
        let mut stream = RandomStream::for_match(3, "falloff");
        let draws: Vec<f32> = (0..20_000).map(|_| Falloff::draw_threshold(0.0, &mut stream)).collect();
        // 1 / (1 + (d / 4)³): 8/9 at 2 m, a half at 4 m, 1/9 at 8 m. Binomial: four standard errors are at most 0.0141.
        for (distance, expected) in [(2.0, 8.0 / 9.0), (4.0, 0.5), (8.0, 1.0 / 9.0)] {
            let share = draws.iter().filter(|&&odds| odds >= falloff.odds_against(distance)).count() as f32 / 20_000.0;
            assert!((share - expected).abs() < 0.0141, "{share} at {distance} m");
            assert!((falloff.share_at(distance) - expected).abs() < 1e-6);
        }
        assert!(draws.iter().all(|odds| falloff.distance_of(*odds).is_finite()));
        // Of a half three fifths, if two fifths are missed anyway.
        let recognised =
            (0..20_000).filter(|_| Falloff::draw_threshold(0.4, &mut stream) >= falloff.odds_against(4.0)).count();
        assert!((recognised as f32 / 20_000.0 - 0.3).abs() < 0.0141, "{recognised}");
        assert!((0..1000).all(|_| Falloff::draw_threshold(1.0, &mut stream) < 0.0));
    }

    #[test]
    fn odds_and_distances_are_the_same_thing_for_any_exponent() {
        for exponent in [0.5, 1.0, 3.0, 6.0, 7.3, 16.0, 17.0] {
            let falloff = Falloff { half_distance_m: 4.0, exponent };
            for distance in [0.5, 2.0, 4.0, 5.0, 9.0] {
                let there_and_back = falloff.distance_of(falloff.odds_against(distance));
                assert!((there_and_back - distance).abs() < 1e-4 * distance, "{there_and_back} {distance} {exponent}");
            }
        }
    }

    #[test]
    fn noise_written_by_a_program_reads_back() {
        for (_, noise) in VisionNoise::PRESETS {
            let noise = noise();
            assert_eq!(serde_json::from_str::<VisionNoise>(&serde_json::to_string(&noise).unwrap()).unwrap(), noise);
            assert_eq!(ron::from_str::<VisionNoise>(&ron::to_string(&noise).unwrap()).unwrap(), noise);
        }
    }
}
