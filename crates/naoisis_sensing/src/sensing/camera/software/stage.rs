//! A stage: anything that software cameras can draw, in any colours and any light. Pictures of matches need none; labelled images of pitches
//! that look different from each other do.

use bevy::math::Vec3;

use super::light::Light;
use crate::appearance::colours::Colour;
use crate::appearance::field::GroundMark;
use crate::appearance::shapes::Part;

/// What a camera sees: the ground with its markings, nets, and bodies.
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
    /// The greatest number of a body. The least that is no label of the ground is 4.
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

/// A patch of another colour on an ellipsoid: where the product of `axis` with a point of the unit sphere, in the frame of its part, is between
/// `from` and `to`. With `to` of 1 it is a cap about the axis, with `from` of `-to` a band.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PatchArea {
    /// The axis, unit vector.
    pub axis: Vec3,
    /// The least product.
    pub from: f32,
    /// The greatest product.
    pub to: f32,
    /// Its colour.
    pub colour: Colour,
}
