//! Errors of the geometric vision, class by class, and their presets.

use bevy::prelude::*;
use serde::{Deserialize, Deserializer, Serialize};

use crate::geometry::{file_units, radians_of, to_radians};
use crate::sensing::preset::{self, Preset};

/// How well one class of things is recognised.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
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

/// Errors of the geometric vision. In files: `"none"`, `"default"`, or an object with a `preset` and the fields that
/// differ from it.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize)]
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

impl<'de> Deserialize<'de> for VisionNoise {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        preset::deserialize(deserializer)
    }
}

impl Preset for VisionNoise {
    type Changes = VisionNoiseChanges;

    const NAMES: &'static [&'static str] = &["none", "default"];

    fn preset(name: &str) -> Option<Self> {
        match name {
            "none" => Some(Self::none()),
            "default" => Some(Self::standard()),
            _ => None,
        }
    }

    fn base(changes: &VisionNoiseChanges) -> Option<&str> {
        changes.preset.as_deref()
    }

    fn changed(self, changes: VisionNoiseChanges) -> Self {
        Self {
            ball: changes.ball.applied_to(self.ball),
            goal_posts: changes.goal_posts.applied_to(self.goal_posts),
            robots: changes.robots.applied_to(self.robots),
            lines: changes.lines.applied_to(self.lines),
            junctions: changes.junctions.applied_to(self.junctions),
            penalty_crosses: changes.penalty_crosses.applied_to(self.penalty_crosses),
            centre_circle: changes.centre_circle.applied_to(self.centre_circle),
            head_angle_sd: changes.head_angle_sd_deg.map_or(self.head_angle_sd, radians_of),
        }
    }
}

/// The fields of a [`VisionNoise`] that an object changes.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct VisionNoiseChanges {
    #[serde(default, deserialize_with = "preset::present")]
    preset: Option<String>,
    #[serde(default)]
    ball: ClassChanges,
    #[serde(default)]
    goal_posts: ClassChanges,
    #[serde(default)]
    robots: ClassChanges,
    #[serde(default)]
    lines: ClassChanges,
    #[serde(default)]
    junctions: ClassChanges,
    #[serde(default)]
    penalty_crosses: ClassChanges,
    #[serde(default)]
    centre_circle: ClassChanges,
    #[serde(default, deserialize_with = "preset::present")]
    head_angle_sd_deg: Option<f64>,
}

/// The fields of a [`ClassNoise`] that an object changes.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct ClassChanges {
    #[serde(default, deserialize_with = "preset::present")]
    pixel_sd: Option<f32>,
    #[serde(default, deserialize_with = "preset::present")]
    miss_probability: Option<f32>,
    #[serde(default, deserialize_with = "preset::present")]
    false_positive_probability: Option<f32>,
    /// Absent, or present and null for unlimited.
    #[serde(default, deserialize_with = "preset::present")]
    max_distance_m: Option<Option<f32>>,
}

impl ClassChanges {
    fn applied_to(self, class: ClassNoise) -> ClassNoise {
        ClassNoise {
            pixel_sd: self.pixel_sd.unwrap_or(class.pixel_sd),
            miss_probability: self.miss_probability.unwrap_or(class.miss_probability),
            false_positive_probability: self.false_positive_probability.unwrap_or(class.false_positive_probability),
            max_distance_m: self.max_distance_m.unwrap_or(class.max_distance_m),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(json: &str) -> Result<VisionNoise, serde_json::Error> {
        serde_json::from_str(json)
    }

    #[test]
    fn noise_is_a_presets_name_or_what_differs_from_one() {
        assert_eq!(read("\"none\"").unwrap(), VisionNoise::none());
        assert_eq!(read("\"default\"").unwrap(), VisionNoise::default());
        let changed = read(r#"{ "preset": "none", "ball": { "pixel_sd": 2 }, "head_angle_sd_deg": 180 }"#).unwrap();
        assert_eq!(changed.ball, ClassNoise { pixel_sd: 2.0, ..default() });
        assert_eq!(changed.head_angle_sd, core::f32::consts::PI);
        assert_eq!(changed.robots, ClassNoise::default());
        // Without a preset, what is not said is as by default.
        let changed = read(r#"{ "ball": { "max_distance_m": null } }"#).unwrap();
        assert_eq!(changed.ball, ClassNoise { max_distance_m: None, ..VisionNoise::default().ball });
        assert_eq!(changed.goal_posts, VisionNoise::default().goal_posts);
    }

    #[test]
    fn noise_written_by_a_program_reads_back() {
        for noise in [VisionNoise::none(), VisionNoise::default()] {
            assert_eq!(read(&serde_json::to_string(&noise).unwrap()).unwrap(), noise);
            assert_eq!(ron::from_str::<VisionNoise>(&ron::to_string(&noise).unwrap()).unwrap(), noise);
        }
        assert_eq!(ron::from_str::<VisionNoise>("\"none\"").unwrap(), VisionNoise::none());
    }

    #[test]
    fn what_is_not_understood_is_refused_in_words() {
        let error = read("\"loud\"").unwrap_err().to_string();
        assert!(error.contains("expected one of the presets `none`, `default`"), "{error}");
        assert!(read(r#"{ "balls": {} }"#).unwrap_err().to_string().contains("unknown field `balls`"));
        let error = read("{ \"ball\": {\n \"pixel\": 1 } }").unwrap_err();
        assert_eq!(error.line(), 2);
    }
}
