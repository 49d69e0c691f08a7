//! The renderer on a graphics card: Bevy draws images of a [scene](naoisis_sensing::appearance::scene::Scene) without a window.
//!
//! It is a separate Bevy app that contains only the renderer. [`GpuRenderer::draw`] is synchronous, so that an image belongs to the cycle
//! that requested it: it turns the scene into entities, one camera per image draws into a texture, and the textures are read back before
//! the method returns. The cameras see only these entities: the overlays of the viewer are in another world.
//!
//! Any adapter works, including software adapters. Without one, [`GpuRenderer::new`] returns an error. Images show the same scene with the
//! same light as those of the [software renderer](naoisis_sensing::sensing::camera::software). Pixels on edges may differ, also between
//! adapters, so a match in which robots use these images is only repeatable on the same machine.

use bevy::app::{SubApp, SubApps};
use bevy::camera::{ClearColorConfig, PerspectiveProjection, RenderTarget};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::math::{Affine3A, Mat3};
use bevy::mesh::MeshMergeError;
use bevy::platform::cell::SyncCell;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::{Buffer, PipelineCache};
use bevy::render::renderer::{RenderAdapterInfo, RenderDevice};
use bevy::render::settings::{RenderCreation, WgpuSettings};

mod material;
mod read_back;
mod render_scene;

use material::SceneMaterialPlugin;
use naoisis_sensing::appearance::scene::Scene;
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::appearance::{Label, colours};
use naoisis_sensing::sensing::camera::image::ImageRequest;
use naoisis_sensing::sensing::camera::software::NEAR;
use naoisis_sensing::sensing::camera::{GpuBackend, RenderingUnavailable, SceneRenderer};
use read_back::{read_back, take_colours, take_depth, take_labels, texture};
use render_scene::{RenderScene, SceneVariant};

/// Distance of the camera's far plane, m.
const FAR_M: f32 = 600.0;
/// Number of updates after which a renderer that is not ready is considered as failed.
const MOST_WARM_UP_UPDATES: usize = 200;

/// Draws the camera images of matches with `"cameras": { "render": "gpu" }` on a graphics card.
///
/// The renderer starts with the first match that needs it.
pub struct GpuCamerasPlugin;

impl Plugin for GpuCamerasPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(GpuBackend(|| {
            let renderer = GpuRenderer::new().map_err(|error| RenderingUnavailable(error.to_string()))?;
            Ok(Box::new(SharedRenderer(SyncCell::new(renderer))))
        }));
    }
}

/// A renderer that is used by one thread at a time.
struct SharedRenderer(SyncCell<GpuRenderer>);

impl SceneRenderer for SharedRenderer {
    fn draw(&mut self, scene: &Scene, requests: &mut [&mut ImageRequest]) -> Result<(), RenderingUnavailable> {
        self.0.get().draw(scene, requests).map_err(|error| RenderingUnavailable(error.to_string()))
    }
}

/// Reason why there are no images.
#[derive(thiserror::Error)]
pub enum GpuError {
    /// There is no graphics card and no software adapter.
    #[error("no graphics adapter with Vulkan, Metal or DirectX 12 was found")]
    NoAdapter,
    /// An image is larger than the adapter can draw.
    #[error("a picture of {width} x {height} samples is too large: the adapter draws {most} in each direction at most")]
    TooLarge {
        /// Width, samples.
        width: u32,
        /// Height, samples.
        height: u32,
        /// The adapter's limit for each of them, samples.
        most: u32,
    },
    /// The adapter stopped working.
    #[error("the graphics adapter failed: {0}")]
    Failed(String),
}

naoisis_core::debug_as_displayed!(GpuError);

impl From<MeshMergeError> for GpuError {
    fn from(error: MeshMergeError) -> Self {
        GpuError::Failed(error.to_string())
    }
}

/// Checks whether there is a graphics card or a software adapter to draw with.
///
/// # Errors
/// [`GpuError::NoAdapter`] if there is none.
pub fn check_adapter() -> Result<(), GpuError> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::PRIMARY,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapter = bevy::tasks::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
    adapter.map(drop).map_err(|_| GpuError::NoAdapter)
}

/// Draws images on a graphics card.
pub struct GpuRenderer {
    apps: SubApps,
    render_scene: RenderScene,
    cameras: Vec<Camera3>,
    adapter: String,
    most_samples: u32,
}

/// A Bevy camera with its texture, and the buffer into which the texture is read back.
struct Camera3 {
    entity: Entity,
    target: Handle<Image>,
    size: UVec2,
    msaa: Msaa,
    buffer: Option<Buffer>,
}

/// One drawing of an image.
struct Pass {
    /// Index of the requested image.
    index: usize,
    variant: SceneVariant,
    msaa: Msaa,
    takes: Takes,
}

/// Data that are taken from a drawing.
#[derive(Clone, Copy)]
enum Takes {
    /// Colours, and labels if every pixel has a single sample of them.
    Colours {
        /// Whether labels are taken, too.
        labels: bool,
    },
    Labels,
    Depth,
}

impl GpuRenderer {
    /// Starts the renderer.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] if there is no adapter.
    pub fn new() -> Result<Self, GpuError> {
        let settings = WgpuSettings { backends: Some(wgpu::Backends::PRIMARY), ..default() };
        check_adapter()?;
        let mut app = App::new();
        app.add_plugins((
            TaskPoolPlugin::default(),
            bevy::diagnostic::FrameCountPlugin,
            bevy::time::TimePlugin,
            AssetPlugin::default(),
            WindowPlugin { primary_window: None, exit_condition: bevy::window::ExitCondition::DontExit, ..default() },
            RenderPlugin {
                render_creation: RenderCreation::Automatic(Box::new(settings)),
                synchronous_pipeline_compilation: true,
                ..default()
            },
            ImagePlugin::default(),
            bevy::mesh::MeshPlugin,
            bevy::camera::CameraPlugin,
            bevy::light::LightPlugin,
            // With the feature `gizmos`, Bevy's lights need this plugin. No camera of this app sees gizmos.
            #[cfg(feature = "gizmos")]
            bevy::gizmos::GizmoPlugin,
            bevy::core_pipeline::CorePipelinePlugin,
            bevy::pbr::PbrPlugin::default(),
            SceneMaterialPlugin,
        ));
        app.insert_resource(ClearColor(Color::NONE));
        while app.plugins_state() == bevy::app::PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();
        let mut apps = core::mem::take(app.sub_apps_mut());
        let render = render_world(&mut apps)?;
        let info = render.resource::<RenderAdapterInfo>();
        let adapter = format!("{} ({:?})", info.name, info.backend);
        let most_samples = render.resource::<RenderDevice>().limits().max_texture_dimension_2d;
        Ok(Self { apps, render_scene: RenderScene::default(), cameras: Vec::new(), adapter, most_samples })
    }

    /// Returns the name of the adapter and its graphics API.
    pub fn adapter(&self) -> &str {
        &self.adapter
    }

    /// Draws pictures of a scene.
    ///
    /// # Errors
    /// When an image is too large or the adapter fails. The images are invalid then.
    pub fn draw(&mut self, scene: &Scene, requests: &mut [&mut ImageRequest]) -> Result<(), GpuError> {
        // Depth needs a drawing of its own. So do labels if the samples of a pixel are mixed.
        let mut passes: Vec<Pass> = Vec::new();
        for (index, request) in requests.iter().enumerate() {
            let variant = SceneVariant { design: request.design, shadows: request.view.shadows, depth: false };
            let is_smooth = request.view.antialiasing && request.view.supersampling <= 1;
            let (msaa, labels) = if is_smooth { (Msaa::Sample4, false) } else { (Msaa::Off, request.layers.labels) };
            passes.push(Pass { index, variant, msaa, takes: Takes::Colours { labels } });
            if request.layers.labels && is_smooth {
                passes.push(Pass { index, variant, msaa: Msaa::Off, takes: Takes::Labels });
            }
            if request.layers.depth {
                let variant = SceneVariant { depth: true, ..variant };
                passes.push(Pass { index, variant, msaa: Msaa::Off, takes: Takes::Depth });
            }
        }
        let variants: Vec<SceneVariant> = passes.iter().map(|pass| pass.variant).collect();
        let world = self.apps.main.world_mut();
        let mut is_new = self.render_scene.set(world, scene, &variants)?;
        for (number, pass) in passes.iter().enumerate() {
            is_new |= self.aim(number, &requests[pass.index].view, pass)?;
        }
        for camera in &self.cameras[passes.len()..] {
            if let Some(mut unused) = self.apps.main.world_mut().get_mut::<Camera>(camera.entity) {
                unused.is_active = false;
            }
        }
        self.apps.update();
        if is_new {
            self.warm_up()?;
        }
        let samples = read_back(render_world(&mut self.apps)?, &mut self.cameras[..passes.len()])?;
        for (pass, samples) in passes.iter().zip(&samples) {
            let ImageRequest { view, image, .. } = &mut *requests[pass.index];
            match pass.takes {
                Takes::Colours { labels } => {
                    take_colours(samples, view, image);
                    image.labels.clear();
                    image.depth_m.clear();
                    if labels {
                        take_labels(samples, view, image);
                    }
                }
                Takes::Labels => take_labels(samples, view, image),
                Takes::Depth => take_depth(samples, view, image),
            }
        }
        Ok(())
    }

    /// Points a camera at the view of a pass, and creates it if necessary. Returns whether it is new.
    fn aim(&mut self, number: usize, view: &View, pass: &Pass) -> Result<bool, GpuError> {
        let Pass { variant, msaa, .. } = *pass;
        let [width, height] = view.size();
        let samples = view.supersampling.max(1);
        let size = UVec2::new(width as u32, height as u32) * samples;
        if size.max_element() > self.most_samples {
            return Err(GpuError::TooLarge { width: size.x, height: size.y, most: self.most_samples });
        }
        let world = self.apps.main.world_mut();
        let is_new = self.cameras.get(number).is_none_or(|camera| (camera.size, camera.msaa) != (size, msaa));
        if is_new {
            let target = world.resource_mut::<Assets<Image>>().add(texture(size));
            let entity =
                world.spawn((Camera3d::default(), RenderTarget::from(target.clone()), Tonemapping::None, msaa)).id();
            let camera = Camera3 { entity, target, size, msaa, buffer: None };
            match self.cameras.get_mut(number) {
                None => self.cameras.push(camera),
                Some(old) => {
                    world.despawn(old.entity);
                    *old = camera;
                }
            }
        }
        let rotation = Mat3::from_cols(view.right, -view.down, -view.forward);
        let place = GlobalTransform::from(Affine3A::from_mat3_translation(rotation, view.eye));
        let half_height = view.intrinsics.size.y / 2.0;
        let projection = PerspectiveProjection {
            fov: 2.0 * ops::atan(half_height / view.intrinsics.focal_length),
            aspect_ratio: width as f32 / height as f32,
            near: NEAR,
            far: FAR_M,
            ..default()
        };
        let sky = if variant.depth { [0.0; 4] } else { sky() };
        let camera = Camera {
            is_active: true,
            order: number as isize,
            clear_color: ClearColorConfig::Custom(Color::linear_rgba(sky[0], sky[1], sky[2], sky[3])),
            ..default()
        };
        let layers = self.render_scene.layers(view, variant);
        let entity = self.cameras[number].entity;
        let mut entity = world.entity_mut(entity);
        entity.insert((place, Projection::Perspective(projection), layers));
        if let Some(mut old) = entity.get_mut::<Camera>() {
            let computed = old.computed.clone();
            *old = Camera { computed, ..camera };
        }
        Ok(is_new)
    }

    /// Updates the renderer until all shaders are loaded and compiled.
    fn warm_up(&mut self) -> Result<(), GpuError> {
        for update in 0..MOST_WARM_UP_UPDATES {
            bevy::tasks::tick_global_task_pools_on_main_thread();
            self.apps.update();
            let cache = render_world(&mut self.apps)?.resource::<PipelineCache>();
            if update >= 3 && cache.waiting_pipelines().next().is_none() {
                return Ok(());
            }
        }
        Err(GpuError::Failed("its shaders do not get ready".to_owned()))
    }
}

fn render_world(apps: &mut SubApps) -> Result<&mut World, GpuError> {
    use bevy::app::AppLabel;
    let render = apps.sub_apps.get_mut(&RenderApp.intern());
    render.map(SubApp::world_mut).ok_or(GpuError::NoAdapter)
}

/// Returns the colour of the sky, linear, with its label as the alpha value.
fn sky() -> [f32; 4] {
    let [red, green, blue] = colours::SKY.0;
    let [red, green, blue, _] = LinearRgba::from(Color::srgb_u8(red, green, blue)).to_f32_array();
    [red, green, blue, f32::from(Label::Sky as u8) / 255.0]
}
