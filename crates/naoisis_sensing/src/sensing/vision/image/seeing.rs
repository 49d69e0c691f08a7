//! Fills the [`Percepts`] of robots whose vision processes their images.

use bevy::prelude::*;

use super::{ImageDetections, ImageVision, ObjectModel};
use crate::sensing::camera::image::Image;
use crate::sensing::camera::{CameraImages, CameraSettings};
use crate::sensing::jobs::{self, SensingThreads};
use crate::sensing::vision::{LandmarkKind, LandmarkPercept, Percepts, VisionSettings, VisionSource};
use naoisis_core::ball::BallPhysics;
use naoisis_core::camera_model::{CameraName, CameraView};
use naoisis_core::cycle::CycleClock;
use naoisis_core::pitch::Pitch;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::team::RobotId;

/// Landmarks of one kind within this distance are the same, m.
const SAME_LANDMARK_M: f32 = 0.25;

/// Memory that is kept from cycle to cycle.
#[derive(Default)]
pub(in crate::sensing::vision) struct VisionBuffers {
    jobs: Vec<Job>,
    done: Vec<ImageDetections>,
    workers: Vec<ImageVision>,
}

/// An image to be processed.
struct Job {
    robot: Entity,
    camera: CameraName,
    view: CameraView,
    image: Image,
    detections: ImageDetections,
}

/// Processes the images that were taken in this cycle.
pub(in crate::sensing::vision) fn process_images(
    mut buffers: Local<VisionBuffers>,
    clock: Res<CycleClock>,
    threads: Res<SensingThreads>,
    pitch: Res<Pitch>,
    balls: Query<&BallPhysics>,
    bodies: Query<(&RobotId, &Body)>,
    mut robots: Query<(
        Entity,
        (&HeadAngles, &Body),
        &CameraSettings,
        &VisionSettings,
        &mut CameraImages,
        &mut Percepts,
    )>,
) {
    let buffers = &mut *buffers;
    for (robot, (head, body), cameras, settings, mut images, _) in &mut robots {
        if settings.source != VisionSource::Image || images.cycle != Some(clock.cycle) {
            continue;
        }
        for (camera, &view) in cameras.views(body, *head).named() {
            let image = core::mem::take(images.of_mut(camera));
            let detections = buffers.done.pop().unwrap_or_default();
            buffers.jobs.push(Job { robot, camera, view, image, detections });
        }
    }
    if buffers.jobs.is_empty() {
        return;
    }
    // All robots know the size and the colours of the ball,
    let ball = balls.iter().next().copied().unwrap_or_default();
    // and the bodies of the robots of each team.
    let mut of_teams: Vec<(RobotId, &Body)> = bodies.iter().map(|(id, body)| (*id, body)).collect();
    of_teams.sort_unstable_by_key(|(id, _)| *id);
    let model = ObjectModel { ball_look: ball.look, ..ObjectModel::new(&pitch, ball.radius_m) };
    let model = model.with_robots(of_teams.iter().map(|(id, body)| (id.team, *body)));
    jobs::for_each(*threads, &mut buffers.workers, &mut buffers.jobs, |vision, job| {
        vision.recognise(&job.image, job.camera, &job.view, &model, &mut job.detections);
    });
    // The jobs of a robot follow each other.
    for job in buffers.jobs.drain(..) {
        let Ok((_, _, cameras, settings, mut images, mut percepts)) = robots.get_mut(job.robot) else { continue };
        *images.of_mut(job.camera) = job.image;
        let is_lower = cameras.mounts.order(job.camera) > 0;
        merge(&mut percepts, is_lower, &job.detections);
        if settings.points {
            percepts.line_points.extend(&job.detections.line_points);
            percepts.border_points.extend(&job.detections.border_points);
        }
        buffers.done.push(job.detections);
    }
    for (_, _, cameras, settings, _, mut percepts) in &mut robots {
        if settings.source == VisionSource::Image {
            percepts.sort(&cameras.mounts);
        }
    }
}

/// Adds the detections in the image of one camera to those of earlier cameras. An object that several cameras see becomes one percept.
pub(super) fn merge(percepts: &mut Percepts, is_lower: bool, detections: &ImageDetections) {
    // Of two balls, the one that is seen better is kept: a lower camera, which comes later in the model, is nearer to the objects in its
    // image.
    if let Some((_, ball)) = detections.ball
        && (percepts.ball.is_none() || is_lower)
    {
        percepts.ball = Some(ball);
    }
    for (has_foot, post) in &detections.goal_posts {
        let same = percepts.goal_posts.iter_mut().find(|other| {
            let along = other.position_m.normalize_or(Vec2::X).dot(post.position_m.normalize_or(Vec2::X));
            other.colour == post.colour && along > 0.998
        });
        match same {
            Some(other) if *has_foot => *other = *post,
            Some(_) => {}
            None => percepts.goal_posts.push(*post),
        }
    }
    for (has_lower_edge, robot) in &detections.robots {
        let same = percepts.robots.iter_mut().find(|other| {
            let apart = other.position_m.distance(robot.position_m);
            other.team == robot.team && apart < 0.2 + 0.1 * robot.position_m.length()
        });
        match same {
            Some(other) if *has_lower_edge => *other = *robot,
            Some(_) => {}
            None => percepts.robots.push(*robot),
        }
    }
    for landmark in &detections.landmarks {
        let is_same = |other: &LandmarkPercept| {
            other.kind == landmark.kind
                && !matches!(landmark.kind, LandmarkKind::Line { .. })
                && other.position_m.distance(landmark.position_m) < SAME_LANDMARK_M
        };
        if !percepts.landmarks.iter().any(is_same) {
            percepts.landmarks.push(*landmark);
        }
    }
}
