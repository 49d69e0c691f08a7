//! Errors of the geometric vision, class by class, and their presets.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::{file_units, to_radians};

/// How well one class of things is recognised.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassNoise {
    /// Standard deviation of the pixel, along u and v each, pixels.
    pub pixel_sd: f32,
    /// Probability that a thing in view is not recognised in a cycle.
    pub miss_probability: f32,
    /// Probability that in a cycle one is recognised where there is none. Only things that have a place of their own
    /// are taken for granted falsely: balls, goal posts and robots.
    pub false_positive_probability: f32,
    /// Greatest distance at which it is recognised, m; none for unlimited.
    pub max_distance_m: Option<f32>,
}

impl ClassNoise {
    const fn new(pixel_sd: f32, miss_probability: f32, false_positive_probability: f32, max_distance_m: f32) -> Self {
        Self { pixel_sd, miss_probability, false_positive_probability, max_distance_m: Some(max_distance_m) }
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
        }
    }

    /// The preset `default`: what B-Human's simulator assumes of B-Human's vision (`oracledPerceptsProvider.cfg`,
    /// 2025). There, line crossings are computed from lines and have no figures: here they are missed as often as
    /// lines, with the spread of the penalty mark and the range of the centre circle. The head's error is that of
    /// SimSpark's restricted vision perceptor (0.12° and 0.15°).
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
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_written_by_a_program_reads_back() {
        for (_, noise) in VisionNoise::PRESETS {
            let noise = noise();
            assert_eq!(serde_json::from_str::<VisionNoise>(&serde_json::to_string(&noise).unwrap()).unwrap(), noise);
            assert_eq!(ron::from_str::<VisionNoise>(&ron::to_string(&noise).unwrap()).unwrap(), noise);
        }
    }
}
