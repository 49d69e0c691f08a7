//! The two cameras of a NAO (paper, section 3.1 and Table 1).
//!
//! **What it measures.** Two images, one from the upper camera that looks ahead and one from the lower that looks
//! 40° further down, of 320 x 240 pixels with a field of view of 58° along the diagonal (47.8° x 36.8°). The
//! geometry of both is the [model](crate::camera_model). What is recognised in them is the [vision](crate::sensing::vision)'s matter,
//! which need not have an image rendered.
//!
//! **Images** ([`CameraImages`]) are rendered on request (`"render": "software"` or `"gpu"`), and for robots that see by them
//! (`"source": "image"`): of either design of robots, in every cycle or every few, with changing light, noise and blur
//! ([`noise`]), a lens that distorts and an exposure that smears ([`lens`]), and for learning with what each pixel is and how far away. A robot does not see itself. One that is off the
//! pitch or lies has no images. Pixels integrate the light over their area: far lines are faint lines, not dashes.
//!
//! **Units and rate.** Pixels, u to the right and v down, from the outer corner of the top-left pixel; 30 images per
//! second, which is the cycle.
//!
//! **The real NAO** of the paper's time (V3) has two OV7670 sensors at 30 images per second with exactly this field
//! of view, of which only one could be read at a time; today's (V6) reads both. With a level head the upper camera
//! sees the floor from 1.67 m on, the lower from 0.34 to 1.24 m: what lies between is seen by neither.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::appearance::gait::{Gait, GaitPlugin};
use crate::appearance::robot::RobotDesign;
use crate::camera_model::{CameraIntrinsics, CameraSide};
use crate::geometry::{file_units, to_radians};
use crate::knowledge::Knowledge;
use crate::pitch::Pitch;

#[cfg(feature = "gpu")]
pub mod gpu;
pub mod image;
pub mod lens;
pub mod noise;
pub mod software;

use image::Image;
use lens::{LastLook, Lens};
use noise::ImageNoise;

/// Robots with cameras. Their images are the [rendering](crate::sensing::rendering)'s matter.
pub struct CameraPlugin;

impl Plugin for CameraPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<GaitPlugin>() {
            app.add_plugins(GaitPlugin);
        }
        app.register_type::<CameraSettings>()
            .register_type::<CameraImages>()
            .register_type::<LastLook>()
            .init_resource::<Pitch>();
    }
}

/// Whether, and by what, camera images are rendered.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum CameraRendering {
    /// By software, for robots that see by their images; no images for others.
    #[default]
    Auto,
    /// No images.
    Off,
    /// By the software renderer.
    Software,
    /// By Bevy on a graphics card: of the same scene, but pixel by pixel the same only on the same machine.
    Gpu,
}

/// Why camera images cannot be rendered as they should be.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{0}")]
pub struct RenderingUnavailable(pub String);

impl CameraRendering {
    /// Gets a match ready for it.
    ///
    /// # Errors
    /// Why it cannot be done here.
    pub fn make_ready(self, world: &mut World) -> Result<(), RenderingUnavailable> {
        #[cfg(feature = "gpu")]
        if self == CameraRendering::Gpu {
            return gpu::GpuCameras::ready(world).map_err(|error| RenderingUnavailable(error.to_string()));
        }
        let _ = (self, world);
        Ok(())
    }

    /// Whether this program can do it.
    pub const fn is_available(self) -> bool {
        cfg!(feature = "gpu") || !matches!(self, CameraRendering::Gpu)
    }
}

/// Which of a robot's cameras return images.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum CameraChoice {
    /// Both.
    #[default]
    Both,
    /// The upper one.
    Top,
    /// The lower one.
    Bottom,
}

impl CameraChoice {
    /// Whether this camera is among them.
    pub const fn includes(self, side: CameraSide) -> bool {
        match self {
            CameraChoice::Both => true,
            CameraChoice::Top => matches!(side, CameraSide::Top),
            CameraChoice::Bottom => matches!(side, CameraSide::Bottom),
        }
    }
}

/// The images of a robot's cameras, where they are rendered.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
#[require(Gait)]
pub struct CameraImages {
    /// The cycle at the start of which they were taken; none without images.
    pub cycle: Option<u64>,
    /// The upper camera's; empty without one.
    pub top: Image,
    /// The lower camera's; empty without one.
    pub bottom: Image,
}

impl CameraImages {
    /// The image of one camera.
    pub fn side(&self, side: CameraSide) -> &Image {
        match side {
            CameraSide::Top => &self.top,
            CameraSide::Bottom => &self.bottom,
        }
    }

    /// The image of one camera.
    pub fn side_mut(&mut self, side: CameraSide) -> &mut Image {
        match side {
            CameraSide::Top => &mut self.top,
            CameraSide::Bottom => &mut self.bottom,
        }
    }

    /// Forgets the images, and keeps the memory.
    pub fn clear(&mut self) {
        self.cycle = None;
        self.top.clear();
        self.bottom.clear();
    }
}

/// The lens and the image of both cameras.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[require(CameraImages, LastLook)]
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
    /// Which cameras return images.
    pub which: CameraChoice,
    /// Images are taken in every so many cycles, at least 1.
    pub every_cycles: u32,
    /// How robots look in the images.
    pub design: RobotDesign,
    /// Light and noise.
    pub noise: ImageNoise,
    /// Distortion, dark corners and exposure.
    pub lens: Lens,
    /// Whether pixels integrate the light over all of their area, as a sensor's do: far lines stay lines instead of dashes.
    pub antialiasing: bool,
    /// Whether bodies cast shadows on the ground.
    pub shadows: bool,
    /// Whether images say of each pixel what it is: ground truth, for learning.
    pub labels: bool,
    /// Whether images say of each pixel how far away it is: ground truth, for learning.
    pub depth: bool,
}

impl Default for CameraSettings {
    fn default() -> Self {
        Self {
            render: CameraRendering::default(),
            width: 320,
            height: 240,
            diagonal_fov: to_radians(58.0),
            which: CameraChoice::default(),
            every_cycles: 1,
            design: RobotDesign::default(),
            noise: ImageNoise::default(),
            lens: Lens::default(),
            antialiasing: true,
            shadows: false,
            labels: false,
            depth: false,
        }
    }
}

impl From<&CameraSettings> for CameraIntrinsics {
    fn from(settings: &CameraSettings) -> Self {
        CameraIntrinsics::new(Vec2::new(settings.width as f32, settings.height as f32), settings.diagonal_fov)
    }
}

#[cfg(test)]
mod tests;
