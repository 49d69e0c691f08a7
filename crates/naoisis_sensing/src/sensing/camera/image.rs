//! What a camera returns: an RGB image, and on request what each pixel is and how far away.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::appearance::Label;
use crate::appearance::robot::RobotDesign;
use crate::appearance::view::View;

/// A picture, row by row from the top, each from left to right.
// Read from a saved match in one piece: a byte of it would take fifty, were each reflected on its own.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Serialize, Deserialize)]
pub struct Image {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Red, green and blue of each pixel, sRGB.
    pub rgb: Vec<u8>,
    /// What each pixel is: the number of a [`Label`]. Empty unless asked for.
    pub labels: Vec<u8>,
    /// How far away each pixel is along the direction in which the camera looks, m; zero for the sky. Empty unless asked
    /// for.
    pub depth_m: Vec<f32>,
}

/// What an image should have besides colours.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Layers {
    /// What each pixel is.
    pub labels: bool,
    /// How far away it is.
    pub depth: bool,
}

impl Layers {
    /// Everything.
    pub const ALL: Layers = Layers { labels: true, depth: true };
}

/// A picture to be drawn.
#[derive(Debug)]
pub struct ImageRequest {
    /// Where it is taken from, and what it does not show.
    pub view: View,
    /// How robots look.
    pub design: RobotDesign,
    /// What is wanted besides colours.
    pub layers: Layers,
    /// The picture; its memory is used again.
    pub image: Image,
}

impl Image {
    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.rgb.is_empty()
    }

    /// Forgets everything, and keeps the memory.
    pub fn clear(&mut self) {
        (self.width, self.height) = (0, 0);
        self.rgb.clear();
        self.labels.clear();
        self.depth_m.clear();
    }

    /// The colour of a pixel: `u` from the left, `v` from the top. None outside the image.
    pub fn colour(&self, u: u32, v: u32) -> Option<[u8; 3]> {
        let first = 3 * self.index(u, v)?;
        self.rgb.get(first..first + 3)?.try_into().ok()
    }

    /// What a pixel is, where that was asked for.
    pub fn label(&self, u: u32, v: u32) -> Option<Label> {
        Label::from_number(*self.labels.get(self.index(u, v)?)?)
    }

    /// How far away a pixel is, m, where that was asked for.
    pub fn depth(&self, u: u32, v: u32) -> Option<f32> {
        self.depth_m.get(self.index(u, v)?).copied()
    }

    fn index(&self, u: u32, v: u32) -> Option<usize> {
        (u < self.width && v < self.height).then(|| v as usize * self.width as usize + u as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_found_by_column_and_row() {
        let image = Image { width: 2, height: 2, rgb: (0..12).collect(), labels: vec![0, 1, 2, 3], depth_m: vec![] };
        assert_eq!(image.colour(1, 0), Some([3, 4, 5]));
        assert_eq!(image.label(0, 1), Some(Label::Carpet));
        assert_eq!((image.colour(2, 0), image.label(0, 2), image.depth(0, 0)), (None, None, None));
    }
}
