//! The renderer of the graphics card: pictures of a [scene](naoisis_sensing::appearance::scene::Scene) by Bevy, without a
//! window.
//!
//! It is a Bevy app of its own with nothing but the renderer in it. A picture is asked for and returned at once, so that it
//! belongs to the cycle that asked for it: the scene becomes entities, one camera a picture draws into a texture, and
//! the textures are read back before [`GpuRenderer::draw`] returns. The cameras see those entities and nothing else: what a viewer
//! draws over a match is in another world.
//!
//! Any adapter will do, one in software too; where there is none, [`GpuRenderer::new`] says so. Pictures show the same scene
//! as the [software renderer](naoisis_sensing::sensing::camera::software)'s, from the same description with the same light; pixels on edges may differ,
//! and between adapters too, so a match that is played by these images is the same again on the same machine only.

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

/// The camera does not look further than this, m.
const FAR_M: f32 = 600.0;
/// A renderer that is not ready by now never will be.
const MOST_WARM_UP_UPDATES: usize = 200;

/// Lets matches of the app have camera images that are drawn on a graphics card (`"cameras": { "render": "gpu" }`).
///
/// The renderer starts with the first match that asks for it.
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

/// Why there are no pictures.
#[derive(thiserror::Error)]
pub enum GpuError {
    /// There is no graphics card, and nothing that stands in for one.
    #[error("no graphics adapter with Vulkan, Metal or DirectX 12 was found")]
    NoAdapter,
    /// A picture is greater than what the adapter can draw.
    #[error("a picture of {width} x {height} samples is too large: the adapter draws {most} in each direction at most")]
    TooLarge {
        /// Width in samples.
        width: u32,
        /// Height in samples.
        height: u32,
        /// The adapter's limit.
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

/// Draws pictures on a graphics card.
pub struct GpuRenderer {
    apps: SubApps,
    render_scene: RenderScene,
    cameras: Vec<Camera3>,
    adapter: String,
    most_samples: u32,
}

/// A camera of Bevy's, its texture, and where this is read back to.
struct Camera3 {
    entity: Entity,
    target: Handle<Image>,
    size: UVec2,
    msaa: Msaa,
    buffer: Option<Buffer>,
}

/// One drawing of a picture.
struct Pass {
    /// Of which of the pictures that were asked for.
    index: usize,
    variant: SceneVariant,
    msaa: Msaa,
    takes: Takes,
}

/// What is taken of it.
#[derive(Clone, Copy)]
enum Takes {
    /// Colours, and with them labels, if they are not mixed.
    Colours {
        /// Whether they are there, and wanted.
        labels: bool,
    },
    Labels,
    Depth,
}

impl GpuRenderer {
    /// Starts the renderer.
    ///
    /// # Errors
    /// When there is no adapter.
    pub fn new() -> Result<Self, GpuError> {
        let settings = WgpuSettings { backends: Some(wgpu::Backends::PRIMARY), ..default() };
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::PRIMARY,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapter = bevy::tasks::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
        if adapter.is_err() {
            return Err(GpuError::NoAdapter);
        }
        drop((adapter, instance));
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
            // Bevy's lights bring gizmos along where there are any; no camera here sees them.
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

    /// The name of the adapter, and what drives it.
    pub fn adapter(&self) -> &str {
        &self.adapter
    }

    /// Draws pictures of a scene.
    ///
    /// # Errors
    /// When one is too large, or the adapter fails. The pictures are not to be used then.
    pub fn draw(&mut self, scene: &Scene, requests: &mut [&mut ImageRequest]) -> Result<(), GpuError> {
        // Distances are a picture of their own, and so are labels where the samples of a pixel are mixed.
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

    /// Points a camera, which is made if there are not enough. Whether it is new.
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

    /// Draws until everything that is needed for it is there: shaders are loaded and compiled.
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

/// The colour of the sky, linear, with its label.
fn sky() -> [f32; 4] {
    let [red, green, blue] = colours::SKY.0;
    let [red, green, blue, _] = LinearRgba::from(Color::srgb_u8(red, green, blue)).to_f32_array();
    [red, green, blue, f32::from(Label::Sky as u8) / 255.0]
}
