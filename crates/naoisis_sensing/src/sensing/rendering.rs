//! Fills [`CameraImages`]: which images are due, and who draws them.
//!
//! It knows the cameras and the vision: robots that see by their images have some without being asked.

use bevy::prelude::*;

use super::camera::image::{ImageRequest, Layers};
use super::camera::lens::{LastLook, LensBuffer, LensEffect};
use super::camera::noise::{DrawnNoise, NoiseBuffer};
use super::camera::software::{Detail, PreparedScene, Renderer};
use super::camera::{CameraImages, CameraRendering, CameraSettings, GpuCameras};
use super::jobs::{self, SensingThreads};
use super::scene::SensingSystems;
use super::vision::gaze::GazeError;
use super::vision::{VisionSettings, VisionSource};
use crate::appearance::robot::RobotDesign;
use crate::appearance::scene::Scene;
use crate::appearance::view::View;
use naoisis_core::camera_model::{CameraMount, CameraName};
use naoisis_core::cycle::{Cycle, CycleClock};
use naoisis_core::random::RandomStreams;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::team::RobotId;

/// Takes the robots' images in [`SensingSystems::Images`].
pub struct RenderingPlugin;

impl Plugin for RenderingPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<SensingThreads>().add_systems(Cycle, take_images.in_set(SensingSystems::Images));
    }
}

/// Memory that is kept from cycle to cycle.
#[derive(Default)]
struct RenderBuffers {
    /// The scene made ready for the software renderer, one a design of robots.
    prepared: [PreparedScene; 2],
    jobs: Vec<Job>,
    workers: Vec<Worker>,
}

/// An image to be drawn.
struct Job {
    robot: Entity,
    side: CameraName,
    lens: LensEffect,
    noise: DrawnNoise,
    is_gpu: bool,
    request: ImageRequest,
}

#[derive(Default)]
struct Worker {
    renderer: Renderer,
    lens_buffer: LensBuffer,
    noise_buffer: NoiseBuffer,
}

impl CameraSettings {
    /// Who draws the images of a robot with these settings, if anyone does.
    pub fn renderer(&self, vision: Option<&VisionSettings>) -> Option<CameraRendering> {
        match self.render {
            CameraRendering::Off => None,
            CameraRendering::Auto => {
                vision.is_some_and(|vision| vision.source == VisionSource::Image).then_some(CameraRendering::Software)
            }
            drawn => Some(drawn),
        }
    }

    /// Whether any camera takes an image in this cycle.
    pub fn is_due(&self, clock: &CycleClock) -> bool {
        self.mounts.as_slice().iter().any(|mount| self.is_camera_due(mount, clock))
    }

    /// Whether one of the cameras takes an image in this cycle.
    fn is_camera_due(&self, mount: &CameraMount, clock: &CycleClock) -> bool {
        let every = u64::from(mount.every_cycles.unwrap_or(self.every_cycles).max(1));
        // The first cycle has images.
        self.which.includes(mount.name) && clock.cycle % every == 1 % every
    }
}

/// Draws the images that are due in this cycle.
fn take_images(
    mut buffers: Local<RenderBuffers>,
    clock: Res<CycleClock>,
    threads: Res<SensingThreads>,
    mut gpu: Option<ResMut<GpuCameras>>,
    scene: Res<Scene>,
    mut robots: Query<(
        Entity,
        &RobotId,
        (&HeadAngles, Option<&GazeError>),
        &CameraSettings,
        Option<&VisionSettings>,
        (&mut CameraImages, &mut LastLook),
        &mut RandomStreams,
    )>,
) {
    let buffers = &mut *buffers;
    let is_due = |settings: &CameraSettings, vision: Option<&VisionSettings>| {
        settings.renderer(vision).filter(|_| settings.is_due(&clock))
    };
    if !robots.iter().any(|(_, _, _, settings, vision, ..)| is_due(settings, vision).is_some()) {
        return;
    }
    let mut is_wanted = [false; 2];
    for (entity, id, (head, gaze), settings, vision, (mut images, mut last_look), mut streams) in &mut robots {
        let Some(renderer) = is_due(settings, vision) else { continue };
        let is_gpu = renderer == CameraRendering::Gpu;
        // Robots that are not on the pitch, and those that lie, have no images.
        let Some(body) = scene.robot(*id).filter(|robot| robot.is_upright()) else {
            images.clear();
            continue;
        };
        is_wanted[settings.design as usize] |= !is_gpu;
        (images.cycle, images.arrived) = (Some(clock.cycle), Some(clock.cycle));
        let looks = gaze.map_or(*head, |gaze| gaze.actual(*head));
        let views = settings.views(looks);
        let turn = if settings.lens.exposure_s > 0.0 {
            let angles = Vec2::new(body.pose.heading + looks.yaw, looks.pitch);
            last_look.turn(clock.cycle, angles, clock.period())
        } else {
            Vec2::ZERO
        };
        for (mount, (side, camera)) in settings.mounts.as_slice().iter().zip(views.named()) {
            let lens = settings.lens_of(mount).effect(camera.intrinsics, turn);
            if !settings.is_camera_due(mount, &clock) {
                images.of_mut(side).clear();
                continue;
            }
            let mut view = View::of_robot(camera, body.world_from_robot(), *id);
            view.intrinsics = lens.drawn();
            view.antialiasing = settings.antialiasing;
            view.shadows = settings.shadows;
            buffers.jobs.push(Job {
                robot: entity,
                side,
                lens,
                noise: settings.noise.draw(&mut streams.camera),
                is_gpu,
                request: ImageRequest {
                    view,
                    design: settings.design,
                    layers: Layers { labels: settings.labels, depth: settings.depth },
                    image: core::mem::take(images.of_mut(side)),
                },
            });
        }
    }
    for design in RobotDesign::BOTH {
        if is_wanted[design as usize] {
            buffers.prepared[design as usize].prepare(&scene, Detail { design, ..Detail::default() });
        }
    }
    if let Some(gpu) = &mut gpu {
        let mut requests: Vec<&mut ImageRequest> =
            buffers.jobs.iter_mut().filter(|job| job.is_gpu).map(|job| &mut job.request).collect();
        if !requests.is_empty()
            && let Err(error) = gpu.0.draw(&scene, &mut requests)
        {
            error!("no camera images in cycle {}: {error}", clock.cycle);
            requests.iter_mut().for_each(|request| request.image.clear());
        }
    }
    let prepared = &buffers.prepared;
    jobs::for_each(*threads, &mut buffers.workers, &mut buffers.jobs, |worker, job| {
        let request = &mut job.request;
        if !job.is_gpu {
            worker.renderer.draw(&prepared[request.design as usize], &request.view, request.layers, &mut request.image);
        }
        job.lens.apply(&mut request.image, &mut worker.lens_buffer);
        job.noise.apply(&mut request.image, &mut worker.noise_buffer);
    });
    for job in buffers.jobs.drain(..) {
        if let Ok((.., (mut images, _), _)) = robots.get_mut(job.robot) {
            *images.of_mut(job.side) = job.request.image;
        }
    }
}
