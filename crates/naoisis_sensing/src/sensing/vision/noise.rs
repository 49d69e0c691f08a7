//! Errors of the geometric vision, class by class, and their presets.

use bevy::math::ops;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use naoisis_core::geometry::{file_units, to_radians};
use naoisis_core::random::RandomStream;

/// How well one class of things is recognised.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassNoise {
    /// Standard deviation of the pixel, along u and v each, pixels.
    pub pixel_sd: f32,
    /// Probability that a thing in view is not recognised in a cycle.
    pub miss_probability: f32,
    /// Probability that in a cycle one is recognised where there is none, somewhere else each time. Only things that have
    /// a place of their own are taken for granted falsely: balls, goal posts and robots.
    pub false_positive_probability: f32,
    /// Greatest distance at which it is recognised, m; none for unlimited.
    pub max_distance_m: Option<f32>,
    /// How it is recognised less often the further away and the smaller it seems; none for equally often.
    #[serde(default)]
    pub falloff: Option<Falloff>,
}

/// How recognition falls off with distance: at a distance d with probability 1 / (1 + (d / `half_distance_m`)^`exponent`), the
/// [misses](ClassNoise::miss_probability) aside. A thing of which only a share of the area is visible seems as small as a
/// whole one that is further away by one over the root of that share, and is recognised as often as that.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Falloff {
    /// Where it is recognised half as often as from near by, m.
    pub half_distance_m: f32,
    /// How steeply it falls off: from twice that distance it is recognised 2 to the power of this times less often than not.
    pub exponent: f32,
}

impl Falloff {
    /// The share of those at this distance, m, that is recognised of what would be from near by.
    pub fn share_at(&self, distance_m: f32) -> f32 {
        (1.0 + self.odds_against(distance_m)).recip()
    }

    /// How much more often a thing at this distance, m, is not recognised than it is.
    pub fn odds_against(&self, distance_m: f32) -> f32 {
        power(distance_m / self.half_distance_m, self.exponent)
    }

    /// How much a thing may have against it, by [`odds_against`](Falloff::odds_against), to be recognised this time: as much as
    /// one at d has with the probability that it is recognised. Less than nothing if it is missed at any distance, with this
    /// probability.
    pub fn draw_odds(miss_probability: f32, stream: &mut RandomStream) -> f32 {
        // From (0, 1].
        let share = 1.0 - stream.uniform();
        (1.0 - miss_probability - share) / share
    }

    /// The distance at which things have so much against them, m.
    pub fn distance_of(&self, odds_against: f32) -> f32 {
        // By the logarithm, which takes half as long as a power.
        self.half_distance_m * ops::exp(ops::ln(odds_against) / self.exponent)
    }
}

/// A power, by products alone if the exponent is one of the usual: otherwise it takes as long as the rest of the vision of a thing.
fn power(base: f32, exponent: f32) -> f32 {
    const MOST: u32 = 16;
    // What is negative, or no number, becomes 0, and is not that.
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

/// How the cameras look elsewhere than the robot thinks by its joints and its upright body: as it rocks, as its joints have
/// play, and as it was never exactly calibrated. In yaw and pitch each; independent of how long cycles are.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GazeNoise {
    /// Standard deviation of what never changes in a match, radians (degrees in files).
    #[serde(rename = "bias_sd_deg", with = "file_units::degrees")]
    pub bias_sd: f32,
    /// Standard deviation of what changes while the robot stands, radians (degrees in files).
    #[serde(rename = "standing_sd_deg", with = "file_units::degrees")]
    pub standing_sd: f32,
    /// Standard deviation of what changes while it walks, radians (degrees in files).
    #[serde(rename = "walking_sd_deg", with = "file_units::degrees")]
    pub walking_sd: f32,
    /// How long what changes stays alike, s: after this time the correlation is 1/e (a Gauss-Markov process of first order).
    /// Zero for an error of its own in each cycle.
    pub correlation_s: f32,
}

/// Places on the pitch that look like something else, to one robot: for many images, from wherever it looks at them.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FalsePlaces {
    /// How many appear in a minute, on the whole pitch; most of them out of view.
    pub per_minute: f32,
    /// How long one lasts on average, s; the times are distributed exponentially.
    pub life_s: f32,
}

/// The error of the distance to a robot whose feet are hidden, or below the image. As shares of the distance, if it is
/// hidden up to its waistband; proportionally less if less of it is.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HiddenFeet {
    /// On average: positive if it seems further away than it is.
    pub bias: f32,
    /// Standard deviation, a draw in each cycle.
    pub sd: f32,
}

/// How much of what changes of a gaze's error is left a cycle later. Robots have mostly the same figures, so that it is worked out
/// once for all of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct GazeDecay {
    correlation_s: f32,
    period_s: f32,
    left: f32,
}

impl GazeDecay {
    /// The share that is left `period` seconds later.
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

    /// Whether a thing at this place, m, robot frame, is too far away.
    pub fn is_too_far(&self, place: Vec2) -> bool {
        self.max_distance_m.is_some_and(|distance| place.length_squared() > distance * distance)
    }
}

/// Errors of the geometric vision. In scenario files: `"none"`, `"default"`, or an object with a `preset` and the fields that
/// differ from it.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VisionNoise {
    /// The ball.
    pub ball: ClassNoise,
    /// Goal posts.
    pub goal_posts: ClassNoise,
    /// Other robots.
    pub robots: ClassNoise,
    /// Stretches of line: the spread of their ends.
    pub lines: ClassNoise,
    /// Places where lines meet.
    pub junctions: ClassNoise,
    /// Penalty crosses.
    pub penalty_crosses: ClassNoise,
    /// The centre circle: the spread of its centre.
    pub centre_circle: ClassNoise,
    /// Standard deviation of the difference between the measured head angles and where the cameras really look, yaw
    /// and pitch each, radians (degrees in files). Drawn in every cycle.
    #[serde(rename = "head_angle_sd_deg", with = "file_units::degrees")]
    pub head_angle_sd: f32,
    /// The part of that difference that lasts. Rendered images have it, too.
    pub gaze: GazeNoise,
    /// Line crossings and penalty crosses that look like a ball.
    pub false_balls: FalsePlaces,
    /// Places on the carpet, or beside the pitch, where something looks like a robot.
    pub false_robots: FalsePlaces,
    /// How far away robots without feet seem.
    pub hidden_feet: HiddenFeet,
}

impl Default for VisionNoise {
    fn default() -> Self {
        Self::standard()
    }
}

impl VisionNoise {
    /// The presets by name.
    pub const PRESETS: [(&'static str, fn() -> Self); 2] = [("none", Self::none), ("default", Self::standard)];

    /// The preset `none`: everything in view is recognised, exactly and at any distance.
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
            false_balls: FalsePlaces::default(),
            false_robots: FalsePlaces::default(),
            hidden_feet: HiddenFeet::default(),
        }
    }

    /// The preset `default`: what B-Human's simulator assumes of B-Human's vision (`oracledPerceptsProvider.cfg`,
    /// 2025). There, line crossings are computed from lines and have no figures: here they are missed as often as
    /// lines, with the spread of the penalty mark and the range of the centre circle. The head's error is that of
    /// SimSpark's restricted vision perceptor (0.12° and 0.15°). Nothing of it lasts from one image to the next.
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
        let draws: Vec<f32> = (0..20_000).map(|_| Falloff::draw_odds(0.0, &mut stream)).collect();
        // 1 / (1 + (d / 4)³): 8/9 at 2 m, a half at 4 m, 1/9 at 8 m. Binomial: four standard errors are at most 0.0141.
        for (distance, expected) in [(2.0, 8.0 / 9.0), (4.0, 0.5), (8.0, 1.0 / 9.0)] {
            let share = draws.iter().filter(|&&odds| odds >= falloff.odds_against(distance)).count() as f32 / 20_000.0;
            assert!((share - expected).abs() < 0.0141, "{share} at {distance} m");
            assert!((falloff.share_at(distance) - expected).abs() < 1e-6);
        }
        assert!(draws.iter().all(|odds| falloff.distance_of(*odds).is_finite()));
        // Of a half three fifths, if two fifths are missed anyway.
        let recognised =
            (0..20_000).filter(|_| Falloff::draw_odds(0.4, &mut stream) >= falloff.odds_against(4.0)).count();
        assert!((recognised as f32 / 20_000.0 - 0.3).abs() < 0.0141, "{recognised}");
        assert!((0..1000).all(|_| Falloff::draw_odds(1.0, &mut stream) < 0.0));
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
