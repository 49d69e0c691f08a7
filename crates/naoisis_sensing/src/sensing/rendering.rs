//! Takes the [`CameraImages`]: selects the cameras that are due, and draws their images.
//!
//! This module depends on the cameras and the vision: robots whose vision uses images have some by default.

use bevy::ecs::query::QueryData;
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
    /// The scene prepared for the software renderer, one per design of robots.
    prepared: [PreparedScene; 2],
    jobs: Vec<Job>,
    workers: Vec<Worker>,
}

/// An image to be drawn.
struct Job {
    robot: Entity,
    camera: CameraName,
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
    /// The renderer for a robot with these settings; `None` if no images are rendered.
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

    /// Whether the camera `mount` takes an image in this cycle.
    fn is_camera_due(&self, mount: &CameraMount, clock: &CycleClock) -> bool {
        let every = u64::from(mount.every_cycles.unwrap_or(self.every_cycles).max(1));
        // Images are taken in the first cycle.
        self.which.includes(mount.name) && clock.cycle % every == 1 % every
    }
}

/// The components of a robot with cameras.
#[derive(QueryData)]
#[query_data(mutable)]
struct RobotCameras {
    entity: Entity,
    id: &'static RobotId,
    head: &'static HeadAngles,
    gaze: Option<&'static GazeError>,
    settings: &'static CameraSettings,
    vision: Option<&'static VisionSettings>,
    images: &'static mut CameraImages,
    last_look: &'static mut LastLook,
    streams: &'static mut RandomStreams,
}

/// Takes the images that are due in this cycle: moves them out of their robots, draws them, and moves them back.
fn take_images(
    mut buffers: Local<RenderBuffers>,
    clock: Res<CycleClock>,
    threads: Res<SensingThreads>,
    mut gpu: Option<ResMut<GpuCameras>>,
    scene: Res<Scene>,
    mut robots: Query<RobotCameras>,
) {
    let buffers = &mut *buffers;
    for robot in &mut robots {
        robot.add_jobs(&clock, &scene, &mut buffers.jobs);
    }
    if buffers.jobs.is_empty() {
        return;
    }
    if let Some(gpu) = &mut gpu {
        buffers.draw_on_gpu(gpu, &scene, clock.cycle);
    }
    buffers.draw_by_software(&scene, *threads);
    for job in buffers.jobs.drain(..) {
        if let Ok(mut robot) = robots.get_mut(job.robot) {
            *robot.images.of_mut(job.camera) = job.request.image;
        }
    }
}

impl RobotCamerasItem<'_, '_> {
    /// Adds a job for each image that is due in this cycle.
    fn add_jobs(mut self, clock: &CycleClock, scene: &Scene, jobs: &mut Vec<Job>) {
        let Self { settings, id, .. } = self;
        let Some(renderer) = settings.renderer(self.vision).filter(|_| settings.is_due(clock)) else { return };
        // Robots that are off the pitch or lie on the ground have no images.
        let Some(robot) = scene.robot(*id).filter(|robot| robot.is_upright()) else {
            self.images.clear();
            return;
        };
        (self.images.cycle, self.images.arrived) = (Some(clock.cycle), Some(clock.cycle));
        let head = self.gaze.map_or(*self.head, |gaze| gaze.actual(*self.head));
        let turn = if settings.lens.sees_turns() {
            let angles = Vec2::new(robot.pose.heading + head.yaw, head.pitch);
            self.last_look.turn(clock.cycle, angles, clock.period())
        } else {
            Vec2::ZERO
        };
        let views = settings.views(&robot.body, head);
        for (mount, (camera, view)) in settings.mounts.as_slice().iter().zip(views.named()) {
            let image = self.images.of_mut(camera);
            if !settings.is_camera_due(mount, clock) {
                image.clear();
                continue;
            }
            let lens = settings.lens.effect(view.intrinsics, turn);
            let view = View {
                antialiasing: settings.antialiasing,
                shadows: settings.shadows,
                ..View::of_robot(view, robot.world_from_robot(), *id)
            };
            jobs.push(Job {
                robot: self.entity,
                camera,
                lens,
                noise: settings.noise.draw(&mut self.streams.camera),
                is_gpu: renderer == CameraRendering::Gpu,
                request: ImageRequest {
                    view,
                    design: settings.design,
                    layers: Layers { labels: settings.labels, depth: settings.depth },
                    image: core::mem::take(image),
                },
            });
        }
    }
}

impl RenderBuffers {
    /// Draws the images of jobs for the graphics card. On an error, the images are empty.
    fn draw_on_gpu(&mut self, gpu: &mut GpuCameras, scene: &Scene, cycle: u64) {
        let mut requests: Vec<&mut ImageRequest> =
            self.jobs.iter_mut().filter(|job| job.is_gpu).map(|job| &mut job.request).collect();
        if !requests.is_empty()
            && let Err(error) = gpu.0.draw(scene, &mut requests)
        {
            error!("no camera images in cycle {cycle}: {error}");
            requests.iter_mut().for_each(|request| request.image.clear());
        }
    }

    /// Draws the images of jobs for the software renderer, and adds lens and noise to all images.
    fn draw_by_software(&mut self, scene: &Scene, threads: SensingThreads) {
        for design in RobotDesign::BOTH {
            if self.jobs.iter().any(|job| !job.is_gpu && job.request.design == design) {
                self.prepared[design as usize].prepare(scene, Detail { design, ..Detail::default() });
            }
        }
        let prepared = &self.prepared;
        jobs::for_each(threads, &mut self.workers, &mut self.jobs, |worker, job| {
            let ImageRequest { view, design, layers, image } = &mut job.request;
            if !job.is_gpu {
                worker.renderer.draw(&prepared[*design as usize], view, *layers, image);
            }
            job.lens.apply(image, &mut worker.lens_buffer);
            job.noise.apply(image, &mut worker.noise_buffer);
        });
    }
}
