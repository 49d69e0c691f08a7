//! The two cameras of a NAO (paper, section 3.1 and Table 1).

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::{file_units, to_radians};
use crate::knowledge::Knowledge;

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
