//! Cameras of the robot's model. A NAO has two (paper, section 3.1 and Table 1).
//!
//! **What they measure.** One image per camera. A NAO has an upper camera that looks ahead and a lower one that looks 40° further down,
//! with 320 x 240 pixels and a field of view of 58° along the diagonal (47.8° x 36.8°). Their geometry is in the [camera
//! model](naoisis_core::camera_model). The [vision](crate::sensing::vision) detects objects, with or without rendered images.
//!
//! **Images** ([`CameraImages`]) are rendered on request (`"render": "software"` or `"gpu"`), and for robots whose vision uses them
//! (`"source": "image"`): with either design of robots, in every cycle or every few, with changing light, noise and blur ([`noise`]), the
//! distortion of the lens and the blur of the exposure ([`lens`]), and for learning with the label and the depth of each pixel. A robot
//! does not see itself. A robot that is off the pitch or lies on the ground has no images. Pixels integrate the light over their area, so
//! that distant lines are faint but continuous.
//!
//! **Units and rate.** Pixels, u to the right and v down, from the outer corner of the top-left pixel; 30 images per
//! second, which is the cycle.
//!
//! **The real NAO** of the paper's time (V3) has two OV7670 sensors at 30 images per second with exactly this field
//! of view, of which only one could be read at a time; the current one (V6) reads both. With a level head the upper camera sees the floor
//! from 1.67 m on, the lower one from 0.34 to 1.24 m: neither sees the floor in between.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::appearance::robot::RobotDesign;
use crate::appearance::scene::Scene;
use crate::appearance::stride::{Stride, StridePlugin};
use naoisis_core::camera_model::{
    CameraCalibration, CameraIntrinsics, CameraMount, CameraMounts, CameraName, CameraView, CameraViews, Distortion,
};
use naoisis_core::geometry::{file_units, to_radians};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::pitch::Pitch;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;

pub mod ball_in_view;
pub mod field_of_view;
pub mod image;
pub mod lens;
pub mod noise;
pub mod software;

use image::{Image, ImageRequest};
use lens::{LastLook, Lens};
use noise::ImageNoise;

/// Registers cameras. The [rendering](crate::sensing::rendering) takes their images.
pub struct CameraPlugin;

impl Plugin for CameraPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<StridePlugin>() {
            app.add_plugins(StridePlugin);
        }
        app.register_type::<CameraSettings>()
            .register_type::<CameraImages>()
            .register_type::<LastLook>()
            .init_resource::<Pitch>();
    }
}

/// Whether camera images are rendered, and by which renderer.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum CameraRendering {
    /// The software renderer for robots whose vision uses images; no images for others.
    #[default]
    Auto,
    /// No images.
    Off,
    /// The software renderer.
    Software,
    /// Bevy's renderer on a graphics card. Images are reproducible only on the same machine.
    Gpu,
}

/// The chosen renderer is not available.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct RenderingUnavailable(pub String);

naoisis_core::debug_as_displayed!(RenderingUnavailable);

/// A renderer of scenes on a graphics card. The crate `naoisis_gpu` has one.
pub trait SceneRenderer: Send + Sync {
    /// Draws the requested images of `scene`.
    ///
    /// # Errors
    /// When an image is too large, or the adapter fails. The images are then undefined.
    fn draw(&mut self, scene: &Scene, requests: &mut [&mut ImageRequest]) -> Result<(), RenderingUnavailable>;
}

/// The function that starts the renderer of the graphics card. Absent in programs without such a renderer.
#[derive(Resource, Clone, Copy)]
pub struct GpuBackend(pub fn() -> Result<Box<dyn SceneRenderer>, RenderingUnavailable>);

/// The renderer of the graphics card, in the world of the match whose images it draws.
#[derive(Resource)]
pub struct GpuCameras(pub Box<dyn SceneRenderer>);

impl CameraRendering {
    /// Prepares the world of a match for this renderer.
    ///
    /// # Errors
    /// If this program, or this machine, cannot render on a graphics card.
    pub fn make_ready(self, world: &mut World) -> Result<(), RenderingUnavailable> {
        if self == CameraRendering::Gpu && !world.contains_resource::<GpuCameras>() {
            let backend = world.get_resource::<GpuBackend>().copied();
            let GpuBackend(start) = backend
                .ok_or_else(|| RenderingUnavailable("this program cannot render on a graphics card".to_owned()))?;
            let renderer = start()?;
            world.insert_resource(GpuCameras(renderer));
        }
        Ok(())
    }
}

/// The cameras of a robot that take images.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect)]
#[reflect(opaque)]
#[reflect(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
pub enum CameraChoice {
    /// All cameras: `both` or `all` in files.
    #[default]
    All,
    /// The camera with this name.
    Only(CameraName),
}

impl CameraChoice {
    /// Whether `camera` takes images.
    pub fn includes(self, camera: CameraName) -> bool {
        match self {
            CameraChoice::All => true,
            CameraChoice::Only(name) => camera == name,
        }
    }
}

impl Serialize for CameraChoice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            CameraChoice::All => serializer.serialize_str("both"),
            CameraChoice::Only(name) => name.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for CameraChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let word = String::deserialize(deserializer)?;
        match word.as_str() {
            "both" | "all" => Ok(CameraChoice::All),
            name => name.parse().map(CameraChoice::Only).map_err(serde::de::Error::custom),
        }
    }
}

/// The images of a robot's cameras, if they are rendered.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
#[require(Stride)]
pub struct CameraImages {
    /// The cycle at the start of which the images were taken; `None` without images.
    pub cycle: Option<u64>,
    /// The cycle in which the images arrived: the same, unless they are [delayed](naoisis_core::robot::latency).
    #[serde(default)]
    pub arrived: Option<u64>,
    /// The images of all cameras that have ever taken one, by camera.
    images: Vec<(CameraName, Image)>,
}

static NO_IMAGE: Image = Image { width: 0, height: 0, rgb: Vec::new(), labels: Vec::new(), depth_m: Vec::new() };

impl CameraImages {
    /// The image of `camera`; empty if there is none.
    pub fn of(&self, camera: CameraName) -> &Image {
        self.iter().find(|(name, _)| *name == camera).map_or(&NO_IMAGE, |(_, image)| image)
    }

    /// The image of `camera`, mutably.
    pub fn of_mut(&mut self, camera: CameraName) -> &mut Image {
        let index = self.images.iter().position(|(name, _)| *name == camera).unwrap_or_else(|| {
            self.images.push((camera, Image::default()));
            self.images.len() - 1
        });
        &mut self.images[index].1
    }

    /// All images with their cameras.
    pub fn iter(&self) -> impl Iterator<Item = (CameraName, &Image)> {
        self.images.iter().map(|(name, image)| (*name, image))
    }

    /// Whether there has never been an image.
    pub fn are_unused(&self) -> bool {
        self.images.is_empty()
    }

    /// Removes all images, and keeps the memory.
    pub fn clear(&mut self) {
        (self.cycle, self.arrived) = (None, None);
        self.images.iter_mut().for_each(|(_, image)| image.clear());
    }
}

/// The cameras of a robot, and their images.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Public)]
#[require(CameraImages, LastLook)]
#[serde(default, deny_unknown_fields)]
pub struct CameraSettings {
    /// Whether images are rendered.
    pub render: CameraRendering,
    /// Width of the image, pixels.
    #[schemars(range(min = 1, max = 4096), extend("unit" = "pixels"))]
    pub width: u32,
    /// Height of the image, pixels.
    #[schemars(range(min = 1, max = 4096), extend("unit" = "pixels"))]
    pub height: u32,
    /// Field of view along the diagonal, radians (degrees in files): 58° (paper, section 3.1). For cameras without `intrinsics`.
    #[serde(rename = "diagonal_fov_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 1.0, max = 170.0))]
    pub diagonal_fov: f32,
    /// The calibration of the cameras, which overrides the field of view.
    #[serde(rename = "intrinsics", skip_serializing_if = "Option::is_none")]
    pub calibration: Option<CameraCalibration>,
    /// The cameras.
    pub mounts: CameraMounts,
    /// The cameras that take images.
    #[schemars(with = "String")]
    pub which: CameraChoice,
    /// Cycles from one image to the next, at least 1. A camera may have its own number; it has no image in cycles in which only other
    /// cameras take one.
    #[schemars(range(min = 1, max = 100_000))]
    pub every_cycles: u32,
    /// The design of robots in the images.
    pub design: RobotDesign,
    /// Light and noise.
    pub noise: ImageNoise,
    /// Distortion, vignetting, exposure and readout.
    pub lens: Lens,
    /// Whether pixels integrate the light over their area, as those of a sensor do, so that distant lines remain continuous.
    pub antialiasing: bool,
    /// Whether bodies cast shadows on the ground.
    pub shadows: bool,
    /// Whether images contain the label of each pixel: ground truth, for learning.
    pub labels: bool,
    /// Whether images contain the depth of each pixel, as those of depth cameras do; with the noise `depth_sd_m`, and otherwise exact.
    pub depth: bool,
}

impl Default for CameraSettings {
    fn default() -> Self {
        Self {
            render: CameraRendering::default(),
            width: 320,
            height: 240,
            diagonal_fov: to_radians(58.0),
            calibration: None,
            mounts: CameraMounts::default(),
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
    /// The intrinsics of cameras that have no settings of their own.
    fn from(settings: &CameraSettings) -> Self {
        let size = [settings.width, settings.height];
        match settings.calibration {
            Some(calibration) => calibration.intrinsics(size, size),
            None => with_lens(size, settings.diagonal_fov, settings.lens.distortion),
        }
    }
}

fn with_lens([width, height]: [u32; 2], diagonal_fov: f32, distortion: Distortion) -> CameraIntrinsics {
    CameraIntrinsics::with_lens(Vec2::new(width as f32, height as f32), diagonal_fov, distortion)
}

impl CameraSettings {
    /// The intrinsics of one of the cameras.
    pub fn intrinsics(&self, mount: &CameraMount) -> CameraIntrinsics {
        let size = mount.size.unwrap_or([self.width, self.height]);
        let common = self.calibration.filter(|_| mount.diagonal_fov.is_none());
        if let Some(calibration) = mount.calibration {
            return calibration.intrinsics(size, size);
        }
        if let Some(calibration) = common {
            return calibration.intrinsics(size, [self.width, self.height]);
        }
        let distortion = mount.distortion.unwrap_or(self.lens.distortion);
        with_lens(size, mount.diagonal_fov.unwrap_or(self.diagonal_fov), distortion)
    }

    /// The views of all cameras of a robot with this `body`, with the head at the angles `head`.
    pub fn views(&self, body: &Body, head: HeadAngles) -> CameraViews {
        let mut views = CameraViews::default();
        self.update_views(body, head, &mut views);
        views
    }

    /// Like [`views`](Self::views), but reuses the memory of `views`.
    pub fn update_views(&self, body: &Body, head: HeadAngles, views: &mut CameraViews) {
        let common = CameraIntrinsics::from(self);
        let own = |mount: &CameraMount| if mount.is_as_others() { common } else { self.intrinsics(mount) };
        views.set(&self.mounts, own, body.neck_m, head);
    }

    /// The view of one camera of a robot with this `body`, with the head at the angles `head`; `None` if there is no such camera.
    pub fn view(&self, camera: CameraName, body: &Body, head: HeadAngles) -> Option<CameraView> {
        let mount = self.mounts.get(camera)?;
        Some(CameraView::new(self.intrinsics(mount), mount, body.neck_m, head))
    }
}

#[cfg(test)]
mod tests;
