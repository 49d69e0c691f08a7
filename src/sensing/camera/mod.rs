//! The two cameras of a NAO (paper, section 3.1 and Table 1).
//!
//! **What it measures.** Two images, one from the upper camera that looks ahead and one from the lower that looks
//! 40° further down, of 320 x 240 pixels with a field of view of 58° along the diagonal (47.8° x 36.8°). The
//! geometry of both is the [`model`]. What is recognised in them is the [vision](crate::sensing::vision)'s matter,
//! which needs no image to be rendered.
//!
//! **Units and rate.** Pixels, u to the right and v down, from the outer corner of the top-left pixel; 30 images per
//! second, which is the cycle.
//!
//! **The real NAO** of the paper's time (V3) has two OV7670 sensors at 30 images per second with exactly this field
//! of view, of which only one could be read at a time; today's (V6) reads both. With a level head the upper camera
//! sees the floor from 1.67 m on, the lower from 0.34 to 1.24 m: what lies between is seen by neither.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::{file_units, to_radians};
use crate::knowledge::Knowledge;

pub mod image;
pub mod model;
pub mod software;

/// Registers the cameras' types.
pub struct CameraPlugin;

impl Plugin for CameraPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<CameraSettings>();
    }
}

/// One of the two cameras in the head.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraSide {
    /// The upper camera, which looks ahead.
    Top,
    /// The lower camera, which looks 40° further down.
    Bottom,
}

impl CameraSide {
    /// Both cameras, top first.
    pub const BOTH: [CameraSide; 2] = [CameraSide::Top, CameraSide::Bottom];
}

/// Whether, and by what, camera images are rendered.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraRendering {
    /// No images.
    #[default]
    Off,
    /// By the software renderer.
    Software,
    /// By the GPU.
    Gpu,
}

/// The lens and the image of both cameras.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct CameraSettings {
    /// Whether images are rendered.
    pub render: CameraRendering,
    /// Width of the image, pixels.
    pub width: u32,
    /// Height of the image, pixels.
    pub height: u32,
    /// Field of view along the diagonal, radians (degrees in files): 58° (paper, section 3.1).
    #[serde(rename = "diagonal_fov_deg", with = "file_units::degrees")]
    pub diagonal_fov: f32,
}

impl Default for CameraSettings {
    fn default() -> Self {
        Self { render: CameraRendering::Off, width: 320, height: 240, diagonal_fov: to_radians(58.0) }
    }
}
