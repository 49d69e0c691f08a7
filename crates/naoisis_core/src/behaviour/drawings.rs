//! What behaviours draw for people: lines, circles, words and targets on the pitch, shown by the viewer and written into traces.
//!
//! Every robot has [`Drawings`], empty at the start of every cycle. A behaviour draws what it thinks of, and nobody on the
//! pitch sees it:
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//!
//! #[derive(Component, Default)]
//! struct Planner;
//!
//! fn plan(mut robots: Query<(&Percepts, &mut Drawings), With<Planner>>) {
//!     for (percepts, mut drawings) in &mut robots {
//!         let Some(ball) = percepts.ball else { continue };
//!         // In the robot's own frame: it is at the origin and looks along x.
//!         drawings.line(Frame::Robot, Vec2::ZERO, ball.position_m, Ink::Yellow);
//!         drawings.circle(Frame::Robot, ball.position_m, 0.1, Ink::Yellow);
//!         drawings.text(Frame::Robot, ball.position_m, "mine", Ink::White);
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
//! Drawings change nothing in the match. They are not private, though: a system that has all robots of a behaviour may
//! read them, as it may read the robots' other commands.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use crate::cycle::{BeginCycle, Cycle, CycleSystems};
use crate::knowledge::Knowledge;

/// More drawings of a robot in a cycle are dropped.
pub const MOST: usize = 1000;
/// Longer texts are cut, bytes.
pub const LONGEST_TEXT_BYTES: usize = 200;

/// Clears the [`Drawings`] at the start of every cycle.
pub struct DrawingsPlugin;

impl Plugin for DrawingsPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Drawings>().add_systems(Cycle, wipe_drawings.in_set(CycleSystems::First).after(BeginCycle));
    }
}

/// The frame in which a drawing's places are.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// The team frame: the own goal is at -x. Beliefs are in it.
    #[default]
    Team,
    /// The robot frame: the robot is at the origin and looks along x. Percepts are in it.
    Robot,
}

/// Colours to draw with: those of Okabe and Ito (2008), which people with any kind of colour blindness tell apart.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Ink {
    /// White.
    #[default]
    White,
    /// Black.
    Black,
    /// Yellow.
    Yellow,
    /// Orange.
    Orange,
    /// Vermilion: for what went wrong.
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

impl Ink {
    /// All of them.
    pub const ALL: [Ink; 9] = [
        Ink::White,
        Ink::Black,
        Ink::Yellow,
        Ink::Orange,
        Ink::Vermilion,
        Ink::Purple,
        Ink::Blue,
        Ink::Sky,
        Ink::Green,
    ];

    /// Red, green and blue, sRGB.
    pub const fn rgb(self) -> [u8; 3] {
        match self {
            Ink::White => [255, 255, 255],
            Ink::Black => [0, 0, 0],
            Ink::Yellow => [240, 228, 66],
            Ink::Orange => [230, 159, 0],
            Ink::Vermilion => [213, 94, 0],
            Ink::Purple => [204, 121, 167],
            Ink::Blue => [0, 114, 178],
            Ink::Sky => [86, 180, 233],
            Ink::Green => [0, 158, 115],
        }
    }
}

/// One line, circle or text on the ground.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct Drawing {
    /// The frame of its places.
    pub frame: Frame,
    /// In which colour it is drawn.
    pub ink: Ink,
    /// What it is.
    #[serde(flatten)]
    pub shape: DrawnShape,
}

/// What is drawn.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DrawnShape {
    /// A straight line.
    Line {
        /// From here, m.
        start_m: Vec2,
        /// To here, m.
        end_m: Vec2,
    },
    /// A circle.
    Circle {
        /// Its centre, m.
        centre_m: Vec2,
        /// Its radius, m.
        radius_m: f32,
    },
    /// Some words.
    Text {
        /// Above this place, m.
        position_m: Vec2,
        /// At most [`LONGEST_TEXT_BYTES`] of them are kept.
        words: Cow<'static, str>,
    },
    /// Where the robot means to go.
    Target {
        /// The place, m, in the drawing's frame.
        position_m: Vec2,
        /// What it wants there, in a word or none.
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

/// What a robot's behaviour has drawn in this cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct Drawings(Vec<Drawing>);

impl Drawings {
    /// Draws a line from a place to another, m.
    pub fn line(&mut self, frame: Frame, start_m: Vec2, end_m: Vec2, ink: Ink) {
        self.add(Drawing { frame, ink, shape: DrawnShape::Line { start_m, end_m } });
    }

    /// Draws a circle about a place, m.
    pub fn circle(&mut self, frame: Frame, centre_m: Vec2, radius_m: f32, ink: Ink) {
        self.add(Drawing { frame, ink, shape: DrawnShape::Circle { centre_m, radius_m } });
    }

    /// Writes words at a place, m.
    pub fn text(&mut self, frame: Frame, position_m: Vec2, words: impl Into<Cow<'static, str>>, ink: Ink) {
        self.add(Drawing { frame, ink, shape: DrawnShape::Text { position_m, words: shortened(words.into()) } });
    }

    /// Marks a place where the robot means to go, m, and why, in a word or none.
    pub fn target(&mut self, frame: Frame, position_m: Vec2, words: impl Into<Cow<'static, str>>, ink: Ink) {
        self.add(Drawing { frame, ink, shape: DrawnShape::Target { position_m, words: shortened(words.into()) } });
    }

    /// Adds a drawing. One with a number that is not finite is dropped, and one beyond [`MOST`].
    pub fn add(&mut self, drawing: Drawing) {
        if self.0.len() < MOST && drawing.shape.is_finite() {
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

/// No longer than [`LONGEST_TEXT_BYTES`].
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
        drawings.line(Frame::Team, Vec2::ZERO, Vec2::new(f32::NAN, 0.0), Ink::White);
        drawings.circle(Frame::Team, Vec2::ZERO, f32::INFINITY, Ink::White);
        assert!(drawings.is_empty());
        drawings.text(Frame::Robot, Vec2::X, "ü".repeat(150), Ink::Sky);
        let DrawnShape::Text { words, .. } = &drawings.0[0].shape else { panic!("a text") };
        assert_eq!(words.chars().count(), 100);
        for _ in 0..2 * MOST {
            drawings.circle(Frame::Team, Vec2::ZERO, 1.0, Ink::White);
        }
        assert_eq!(drawings.iter().len(), MOST);
    }

    #[test]
    fn files_say_the_frame_the_ink_and_the_shape() {
        let mut drawings = Drawings::default();
        drawings.line(Frame::Robot, Vec2::ZERO, Vec2::X, Ink::Vermilion);
        let json = serde_json::to_value(&drawings).unwrap();
        let line = serde_json::json!({ "start_m": [0.0, 0.0], "end_m": [1.0, 0.0] });
        assert_eq!(json, serde_json::json!([{ "frame": "robot", "ink": "vermilion", "line": line }]));
        assert_eq!(serde_json::from_value::<Drawings>(json).unwrap(), drawings);
    }

    /// How a colour looks to people without one kind of cones: sRGB to sRGB, in linear light (Machado, Oliveira and
    /// Fernandes 2009, severity 1).
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
            for (index, one) in Ink::ALL.into_iter().enumerate() {
                for other in &Ink::ALL[index + 1..] {
                    let [one_seen, other_seen] = [one, *other].map(|ink| lab(seen_by(ink.rgb(), matrix)));
                    // A difference of 2.3 is just noticeable.
                    let difference = one_seen.distance(other_seen);
                    assert!(difference > 8.0, "{kind}: {one:?} and {other:?} differ by {difference}");
                }
            }
        }
    }
}
