//! The appearance of everything on the pitch: one description of shapes, sizes, colours and postures, which every renderer draws.
//!
//! This module does not depend on a render crate. A [`Scene`](scene::Scene) is the state of the pitch at one instant, a
//! [`View`](view::View) a camera. Robots consist of [`Part`](shapes::Part)s ([`robot`]) on [limbs](posing::Limb), which [`posing`] places.
//! Each part has a [`Label`].

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use strum::VariantArray;

pub mod ball;
pub mod colours;
pub mod field;
pub mod gather;
pub mod people;
pub mod posing;
pub mod robot;
pub mod scene;
pub mod shapes;
pub mod stride;
pub mod turf;
pub mod view;

/// The object in a pixel of an image.
#[derive(
    Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default, Reflect, Serialize, Deserialize, VariantArray,
)]
#[serde(rename_all = "snake_case")]
#[repr(u8)]
pub enum Label {
    /// Above the horizon.
    #[default]
    Sky = 0,
    /// The floor of the hall, around the carpet.
    Floor = 1,
    /// The green carpet.
    Carpet = 2,
    /// A white line.
    Line = 3,
    /// The ball.
    Ball = 4,
    /// A yellow goal's posts and bar.
    YellowGoal = 5,
    /// A sky-blue goal's posts and bar.
    BlueGoal = 6,
    /// A white goal's posts and bar.
    WhiteGoal = 7,
    /// The frame of a goal's net. The net itself is transparent, and has no label.
    GoalFrame = 8,
    /// A post that belongs to no goal.
    Post = 9,
    /// The body of a robot of the blue team.
    BlueRobot = 10,
    /// The body of a robot of the pink team.
    PinkRobot = 11,
    /// The waistband of a robot of the blue team.
    BlueWaistband = 12,
    /// The waistband of a robot of the pink team.
    PinkWaistband = 13,
    /// An object beside the pitch. Occurs only in data sets of images.
    Clutter = 14,
    /// A person beside the pitch.
    Person = 15,
}

impl Label {
    /// All labels, in the order of their numbers.
    pub const ALL: [Label; Label::VARIANTS.len()] = *Label::VARIANTS.first_chunk().expect("as many as there are");

    /// The label with this number in label images.
    pub fn from_number(number: u8) -> Option<Label> {
        Label::ALL.get(usize::from(number)).copied()
    }

    /// Whether the label is that of the ground or of a marking on it.
    pub fn is_ground(self) -> bool {
        matches!(self, Label::Floor | Label::Carpet | Label::Line)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_stand_at_their_numbers() {
        for (number, label) in Label::ALL.into_iter().enumerate() {
            assert_eq!(label as usize, number);
            assert_eq!(Label::from_number(number as u8), Some(label));
        }
        assert_eq!(Label::from_number(16), None);
    }
}
