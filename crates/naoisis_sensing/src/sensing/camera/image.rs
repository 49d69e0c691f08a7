//! Camera images: RGB, and on request the label and the depth of each pixel.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::appearance::Label;
use crate::appearance::robot::RobotDesign;
use crate::appearance::view::View;

/// An image, row by row from the top, each from left to right.
// Serialised in one piece in saved matches: reflecting each byte individually would take fifty times the space.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Serialize, Deserialize)]
pub struct Image {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Red, green and blue of each pixel, sRGB.
    pub rgb: Vec<u8>,
    /// The number of the [`Label`] of each pixel. Empty unless requested.
    pub labels: Vec<u8>,
    /// The depth of each pixel along the axis of the camera, m; zero for the sky. Empty unless requested.
    pub depth_m: Vec<f32>,
}

/// The layers of an image besides its colours.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Layers {
    /// Labels.
    pub labels: bool,
    /// Depth.
    pub depth: bool,
}

impl Layers {
    /// Both layers.
    pub const ALL: Layers = Layers { labels: true, depth: true };
}

/// A request to draw an image.
#[derive(Debug)]
pub struct ImageRequest {
    /// The view from which it is taken.
    pub view: View,
    /// The design of robots.
    pub design: RobotDesign,
    /// The layers besides colours.
    pub layers: Layers,
    /// The image; its memory is reused.
    pub image: Image,
}

impl Image {
    /// Whether the image has no pixels.
    pub fn is_empty(&self) -> bool {
        self.rgb.is_empty()
    }

    /// The depth of each pixel in whole millimetres, as 16-bit numbers in little-endian order: at most 65.535 m, 0 for the sky.
    pub fn depth_mm(&self) -> Vec<u8> {
        let in_mm = |depth_m: &f32| ((depth_m * 1000.0).round() as u16).to_le_bytes();
        self.depth_m.iter().flat_map(in_mm).collect()
    }

    /// Removes all pixels, but keeps the memory.
    pub fn clear(&mut self) {
        (self.width, self.height) = (0, 0);
        self.rgb.clear();
        self.labels.clear();
        self.depth_m.clear();
    }

    /// The colour of a pixel, `u` from the left and `v` from the top; `None` outside the image.
    pub fn colour(&self, u: u32, v: u32) -> Option<[u8; 3]> {
        let first = 3 * self.index(u, v)?;
        self.rgb.get(first..first + 3)?.try_into().ok()
    }

    /// The label of a pixel; `None` outside the image, or without labels.
    pub fn label(&self, u: u32, v: u32) -> Option<Label> {
        Label::from_number(*self.labels.get(self.index(u, v)?)?)
    }

    /// The depth of a pixel, m; `None` outside the image, or without depth.
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
    fn depths_are_whole_millimetres() {
        let image = Image { depth_m: vec![0.0, 0.2561, 1e6], ..Image::default() };
        assert_eq!(image.depth_mm(), [0, 0, 0, 1, 255, 255]);
    }

    #[test]
    fn pixels_are_found_by_column_and_row() {
        let image = Image { width: 2, height: 2, rgb: (0..12).collect(), labels: vec![0, 1, 2, 3], depth_m: vec![] };
        assert_eq!(image.colour(1, 0), Some([3, 4, 5]));
        assert_eq!(image.label(0, 1), Some(Label::Carpet));
        assert_eq!((image.colour(2, 0), image.label(0, 2), image.depth(0, 0)), (None, None, None));
    }
}
