//! Fills [`CameraImages`] by the software renderer.

use bevy::prelude::*;

use super::image::{Image, Layers};
use super::model::CameraView;
use super::noise::{Darkroom, Exposure};
use super::software::{Detail, PreparedScene, Renderer};
use super::{CameraImages, CameraRendering, CameraSettings, CameraSide};
use crate::appearance::gather::MatchScene;
use crate::appearance::robot::RobotDesign;
use crate::appearance::scene::SceneDescription;
use crate::appearance::view::View;
use crate::cycle::CycleClock;
use crate::random::RandomStreams;
use crate::robot::RobotId;
use crate::robot::head::HeadAngles;
use crate::sensing::jobs::{self, SensingThreads};
use crate::sensing::vision::{VisionSettings, VisionSource};

/// Memory that is kept from cycle to cycle.
#[derive(Default)]
pub(super) struct Studio {
    scene: SceneDescription,
    /// One a design.
    prepared: [PreparedScene; 2],
    jobs: Vec<Job>,
    workers: Vec<Worker>,
}

/// An image to be drawn.
struct Job {
    robot: Entity,
    side: CameraSide,
    design: RobotDesign,
    view: View,
    layers: Layers,
    exposure: Exposure,
    image: Image,
}

#[derive(Default)]
struct Worker {
    renderer: Renderer,
    darkroom: Darkroom,
}

impl CameraSettings {
    /// Whether the software renderer draws the images of a robot with these settings.
    fn is_drawn_by_software(&self, vision: Option<&VisionSettings>) -> bool {
        match self.render {
            CameraRendering::Software => true,
            CameraRendering::Auto => vision.is_some_and(|vision| vision.source == VisionSource::Image),
            CameraRendering::Off | CameraRendering::Gpu => false,
        }
    }

    /// Whether images are taken in this cycle.
    pub(crate) fn is_due(&self, clock: &CycleClock) -> bool {
        // The first cycle has images.
        clock.cycle % u64::from(self.every_cycles.max(1)) == 1 % u64::from(self.every_cycles.max(1))
    }
}

/// Draws the images that are due in this cycle.
pub(super) fn take_images(
    mut studio: Local<Studio>,
    clock: Res<CycleClock>,
    threads: Res<SensingThreads>,
    mut source: MatchScene,
    mut robots: Query<(
        Entity,
        &RobotId,
        &HeadAngles,
        &CameraSettings,
        Option<&VisionSettings>,
        &mut CameraImages,
        &mut RandomStreams,
    )>,
) {
    let studio = &mut *studio;
    let is_due = |settings: &CameraSettings, vision: Option<&VisionSettings>| {
        settings.is_drawn_by_software(vision) && settings.is_due(&clock)
    };
    if !robots.iter().any(|(_, _, _, settings, vision, ..)| is_due(settings, vision)) {
        return;
    }
    source.gather(clock.start_time_s(), &mut studio.scene);
    let mut is_wanted = [false; 2];
    for (entity, id, head, settings, vision, mut images, mut streams) in &mut robots {
        if !is_due(settings, vision) {
            continue;
        }
        // Robots that are not on the pitch, and those that lie, have no images.
        let place = studio.scene.robots.iter().find(|robot| robot.id == *id);
        let Some(place) = place.filter(|robot| robot.is_upright()) else {
            images.clear();
            continue;
        };
        is_wanted[settings.design as usize] = true;
        images.cycle = Some(clock.cycle);
        let views = CameraView::both(settings.into(), *head);
        for (side, camera) in CameraSide::BOTH.into_iter().zip(views) {
            if !settings.which.includes(side) {
                continue;
            }
            let mut view = View::of_robot(&camera, place.world_from_robot, *id);
            view.shadows = settings.shadows;
            studio.jobs.push(Job {
                robot: entity,
                side,
                design: settings.design,
                view,
                layers: Layers { labels: settings.labels, depth: settings.depth },
                exposure: settings.noise.draw(&mut streams.camera),
                image: core::mem::take(images.side_mut(side)),
            });
        }
    }
    for design in RobotDesign::BOTH {
        if is_wanted[design as usize] {
            studio.prepared[design as usize].prepare(&studio.scene, Detail { design, ..Detail::default() });
        }
    }
    let prepared = &studio.prepared;
    jobs::for_each(*threads, &mut studio.workers, &mut studio.jobs, |worker, job| {
        worker.renderer.draw(&prepared[job.design as usize], &job.view, job.layers, &mut job.image);
        job.exposure.apply(&mut job.image, &mut worker.darkroom);
    });
    for job in studio.jobs.drain(..) {
        if let Ok((.., mut images, _)) = robots.get_mut(job.robot) {
            *images.side_mut(job.side) = job.image;
        }
    }
}
