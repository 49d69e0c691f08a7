//! A stage: anything that software cameras can draw, in any colours and any light. Pictures of matches do not need stages; labelled images
//! of pitches that look different from each other do.

use bevy::math::Vec3;

use super::light::Light;
pub use crate::appearance::ball::PatchArea;
use crate::appearance::colours::Colour;
use crate::appearance::field::GroundMark;
use crate::appearance::shapes::Part;

/// The scene before a camera: the ground with its markings, nets, and bodies.
#[derive(Clone, PartialEq, Debug)]
pub struct Stage {
    /// The light.
    pub light: Light,
    /// The colour of the sky, or of the walls of a hall.
    pub sky: Colour,
    /// The colour of the floor around the carpet.
    pub floor: Colour,
    /// The carpet and its markings, from the bottom up. Their labels are the numbers of their pixels.
    pub ground: Vec<GroundMark>,
    /// The colour of nets.
    pub net: Colour,
    /// The strings of each net, by their ends.
    pub nets: Vec<Vec<[Vec3; 2]>>,
    /// The bodies.
    pub bodies: Vec<StageBody>,
}

impl Stage {
    /// The greatest number of a body. The least number that is not a label of the ground is 4.
    pub const MOST_BODIES: u8 = 127;
}

/// A body: parts that have the same number in an image, pitch frame.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct StageBody {
    /// Its number in the labels of an image, up to [`Stage::MOST_BODIES`].
    pub number: u8,
    /// Its parts.
    pub parts: Vec<Part<()>>,
    /// The pattern on its ellipsoids: later patches cover earlier ones.
    pub patches: Vec<PatchArea>,
}
