//! Drawings of behaviours for people: lines, circles, texts and targets on the pitch, shown by the viewer and written to traces.
//!
//! Every robot has [`Drawings`], which are empty at the start of every cycle. A behaviour draws its plans:
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::behaviour::drawings::{DrawColour, Frame};
//! use naoisis::prelude::*;
//!
//! #[derive(Component, Default)]
//! struct Planner;
//!
//! fn plan(mut robots: Query<(&Percepts, &mut Drawings), With<Planner>>) {
//!     for (percepts, mut drawings) in &mut robots {
//!         let Some(ball) = percepts.ball else { continue };
//!         // In the robot's own frame: it is at the origin and looks along x.
//!         drawings.line(Frame::Robot, Vec2::ZERO, ball.position_m, DrawColour::Yellow);
//!         drawings.circle(Frame::Robot, ball.position_m, 0.1, DrawColour::Yellow);
//!         drawings.text(Frame::Robot, ball.position_m, "mine", DrawColour::White);
//!     }
//! }
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, NaoisisPlugins));
//! app.add_behaviour::<Planner, _>("planner", plan);
//! # app.start_match(&Scenario::from_json(r#"{ "rules": "free", "ball": { "position_m": [0.5, 0.0] },
//! #     "robots": [{ "number": 1, "pose": [0.0, 0.0, 0.0], "behaviour": "planner" }] }"#)?)?;
//! # app.run_cycles(3);
//! # let robot = RobotId::new(Team::Blue, 1);
//! # assert_eq!(app.robot::<Drawings>(robot).unwrap().iter().count(), 3);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! Drawings do not influence the match. A system with access to all robots of a behaviour may read them, like the robots' other commands.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use strum::VariantArray;

use crate::cycle::{BeginCycle, Cycle, CycleSystems};
use crate::knowledge::Knowledge;

/// The greatest number of drawings of a robot in a cycle; more are dropped.
pub const MOST: usize = 1000;
/// The greatest length of a text, bytes; longer texts are cut.
pub const LONGEST_TEXT_BYTES: usize = 200;

/// Clears the [`Drawings`] at the start of every cycle.
pub struct DrawingsPlugin;

impl Plugin for DrawingsPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Drawings>().add_systems(Cycle, wipe_drawings.in_set(CycleSystems::First).after(BeginCycle));
    }
}

/// The frame of a drawing's coordinates.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// The team frame, which is that of beliefs: the own goal is at -x.
    #[default]
    Team,
    /// The robot frame, which is that of percepts: the robot is at the origin and looks along x.
    Robot,
}

/// The colours of Okabe and Ito (2008), which people with any kind of colour blindness can distinguish.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema, VariantArray)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum DrawColour {
    /// White.
    #[default]
    White,
    /// Black.
    Black,
    /// Yellow.
    Yellow,
    /// Orange.
    Orange,
    /// Vermilion: for errors.
    Vermilion,
    /// Reddish purple.
    Purple,
    /// Blue.
    Blue,
    /// Sky blue.
    Sky,
    /// Bluish green.
    Green,
}

impl DrawColour {
    /// Red, green and blue, sRGB.
    pub const fn rgb(self) -> [u8; 3] {
        match self {
            DrawColour::White => [255, 255, 255],
            DrawColour::Black => [0, 0, 0],
            DrawColour::Yellow => [240, 228, 66],
            DrawColour::Orange => [230, 159, 0],
            DrawColour::Vermilion => [213, 94, 0],
            DrawColour::Purple => [204, 121, 167],
            DrawColour::Blue => [0, 114, 178],
            DrawColour::Sky => [86, 180, 233],
            DrawColour::Green => [0, 158, 115],
        }
    }
}

/// One line, circle or text on the ground.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
pub struct Drawing {
    /// The frame of its coordinates.
    #[serde(default)]
    pub frame: Frame,
    /// Its colour.
    #[serde(default)]
    pub ink: DrawColour,
    /// Its shape.
    #[serde(flatten)]
    pub shape: DrawnShape,
}

/// The shape of a drawing.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DrawnShape {
    /// A straight line.
    Line {
        /// Start, m.
        #[schemars(with = "[f32; 2]")]
        start_m: Vec2,
        /// End, m.
        #[schemars(with = "[f32; 2]")]
        end_m: Vec2,
    },
    /// A circle.
    Circle {
        /// Its centre, m.
        #[schemars(with = "[f32; 2]")]
        centre_m: Vec2,
        /// Its radius, m.
        radius_m: f32,
    },
    /// A text.
    Text {
        /// Position, m. The text is above it.
        #[schemars(with = "[f32; 2]")]
        position_m: Vec2,
        /// The text, at most [`LONGEST_TEXT_BYTES`].
        words: Cow<'static, str>,
    },
    /// A target of the robot's walk.
    Target {
        /// Position, m.
        #[schemars(with = "[f32; 2]")]
        position_m: Vec2,
        /// The purpose in a word; may be empty.
        #[serde(default)]
        words: Cow<'static, str>,
    },
}

impl DrawnShape {
    fn is_finite(&self) -> bool {
        match self {
            DrawnShape::Line { start_m, end_m } => start_m.is_finite() && end_m.is_finite(),
            DrawnShape::Circle { centre_m, radius_m } => centre_m.is_finite() && radius_m.is_finite(),
            DrawnShape::Text { position_m, .. } | DrawnShape::Target { position_m, .. } => position_m.is_finite(),
        }
    }
}

/// The drawings of a robot's behaviour in this cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct Drawings(Vec<Drawing>);

impl Drawings {
    /// Draws a line between two points, m.
    pub fn line(&mut self, frame: Frame, start_m: Vec2, end_m: Vec2, ink: DrawColour) {
        self.add(Drawing { frame, ink, shape: DrawnShape::Line { start_m, end_m } });
    }

    /// Draws a circle around a point, m.
    pub fn circle(&mut self, frame: Frame, centre_m: Vec2, radius_m: f32, ink: DrawColour) {
        self.add(Drawing { frame, ink, shape: DrawnShape::Circle { centre_m, radius_m } });
    }

    /// Writes a text at a point, m.
    pub fn text(&mut self, frame: Frame, position_m: Vec2, words: impl Into<Cow<'static, str>>, ink: DrawColour) {
        self.add(Drawing { frame, ink, shape: DrawnShape::Text { position_m, words: words.into() } });
    }

    /// Marks a target of the robot's walk, m, with its purpose in a word or an empty string.
    pub fn target(&mut self, frame: Frame, position_m: Vec2, words: impl Into<Cow<'static, str>>, ink: DrawColour) {
        self.add(Drawing { frame, ink, shape: DrawnShape::Target { position_m, words: words.into() } });
    }

    /// Adds a drawing. Drawings with numbers that are not finite, and those beyond [`MOST`], are dropped; long texts are cut.
    pub fn add(&mut self, mut drawing: Drawing) {
        if self.0.len() < MOST && drawing.shape.is_finite() {
            if let DrawnShape::Text { words, .. } | DrawnShape::Target { words, .. } = &mut drawing.shape {
                *words = shortened(core::mem::take(words));
            }
            self.0.push(drawing);
        }
    }

    /// The drawings, in the order in which they were drawn.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Drawing> + '_ {
        self.0.iter()
    }

    /// Whether nothing is drawn.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// `words` cut to [`LONGEST_TEXT_BYTES`].
fn shortened(words: Cow<'static, str>) -> Cow<'static, str> {
    if words.len() <= LONGEST_TEXT_BYTES {
        return words;
    }
    let end = words.floor_char_boundary(LONGEST_TEXT_BYTES);
    Cow::Owned(words[..end].to_owned())
}

fn wipe_drawings(mut drawings: Query<&mut Drawings>) {
    for mut drawings in &mut drawings {
        drawings.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_is_not_drawn_and_texts_are_cut_between_letters() {
        let mut drawings = Drawings::default();
        drawings.line(Frame::Team, Vec2::ZERO, Vec2::new(f32::NAN, 0.0), DrawColour::White);
        drawings.circle(Frame::Team, Vec2::ZERO, f32::INFINITY, DrawColour::White);
        assert!(drawings.is_empty());
        drawings.text(Frame::Robot, Vec2::X, "ü".repeat(150), DrawColour::Sky);
        let DrawnShape::Text { words, .. } = &drawings.0[0].shape else { panic!("a text") };
        assert_eq!(words.chars().count(), 100);
        for _ in 0..2 * MOST {
            drawings.circle(Frame::Team, Vec2::ZERO, 1.0, DrawColour::White);
        }
        assert_eq!(drawings.iter().len(), MOST);
    }

    #[test]
    fn files_say_the_frame_the_ink_and_the_shape() {
        let mut drawings = Drawings::default();
        drawings.line(Frame::Robot, Vec2::ZERO, Vec2::X, DrawColour::Vermilion);
        let json = serde_json::to_value(&drawings).unwrap();
        let line = serde_json::json!({ "start_m": [0.0, 0.0], "end_m": [1.0, 0.0] });
        assert_eq!(json, serde_json::json!([{ "frame": "robot", "ink": "vermilion", "line": line }]));
        assert_eq!(serde_json::from_value::<Drawings>(json).unwrap(), drawings);
    }

    /// Returns the colour as seen by people who lack one kind of cones: sRGB to sRGB, in linear light (Machado, Oliveira and Fernandes
    /// 2009, severity 1).
    fn seen_by(rgb: [u8; 3], matrix: [[f32; 3]; 3]) -> [f32; 3] {
        let linear = rgb.map(|channel| {
            let share = f32::from(channel) / 255.0;
            if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
        });
        matrix.map(|row| row.iter().zip(linear).map(|(weight, channel)| weight * channel).sum::<f32>().clamp(0.0, 1.0))
    }

    /// CIE L*a*b* of linear sRGB, white point D65.
    fn lab(rgb: [f32; 3]) -> Vec3 {
        let dot = |row: [f32; 3]| row.iter().zip(rgb).map(|(weight, channel)| weight * channel).sum::<f32>();
        let curve = |share: f32| if share > 0.008_856 { share.cbrt() } else { 7.787 * share + 16.0 / 116.0 };
        let x = curve(dot([0.4124, 0.3576, 0.1805]) / 0.950_47);
        let y = curve(dot([0.2126, 0.7152, 0.0722]));
        let z = curve(dot([0.0193, 0.1192, 0.9505]) / 1.088_83);
        Vec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
    }

    #[test]
    fn inks_can_be_told_apart_with_any_kind_of_colour_blindness() {
        let kinds = [
            ("none", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
            (
                "protanopia",
                [
                    [0.152_286, 1.052_583, -0.204_868],
                    [0.114_503, 0.786_281, 0.099_216],
                    [-0.003_882, -0.048_116, 1.051_998],
                ],
            ),
            (
                "deuteranopia",
                [
                    [0.367_322, 0.860_646, -0.227_968],
                    [0.280_085, 0.672_501, 0.047_413],
                    [-0.011_820, 0.042_940, 0.968_881],
                ],
            ),
            (
                "tritanopia",
                [
                    [1.255_528, -0.076_749, -0.178_779],
                    [-0.078_411, 0.930_809, 0.147_602],
                    [0.004_733, 0.691_367, 0.303_900],
                ],
            ),
        ];
        for (kind, matrix) in kinds {
            for (index, one) in DrawColour::VARIANTS.iter().enumerate() {
                for other in &DrawColour::VARIANTS[index + 1..] {
                    let [one_seen, other_seen] = [*one, *other].map(|ink| lab(seen_by(ink.rgb(), matrix)));
                    // A difference of 2.3 is just noticeable.
                    let difference = one_seen.distance(other_seen);
                    assert!(difference > 8.0, "{kind}: {one:?} and {other:?} differ by {difference}");
                }
            }
        }
    }
}
