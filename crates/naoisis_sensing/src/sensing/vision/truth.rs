//! Percepts for debugging: all objects on the pitch at their true positions.

use bevy::prelude::*;

use super::{BallPercept, GoalPostPercept, LandmarkKind, LandmarkPercept, Percepts, RobotPercept};
use crate::appearance::scene::Scene;
use crate::sensing::camera::CameraSettings;
use naoisis_core::geometry::Pose;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;

/// Fills the percepts with all objects, in view or not. The camera is the last one that has the object in its image (on a NAO, the lower
/// one), otherwise the first; the pixel of an object that no camera sees is outside the image. A robot without cameras has no percepts.
pub(super) fn know_everything(
    percepts: &mut Percepts,
    scene: &Scene,
    own_index: Option<usize>,
    pose: Pose,
    (cameras, body): (&CameraSettings, &Body),
    head: HeadAngles,
) {
    let views = cameras.views(body, head);
    let Some(last) = views.len().checked_sub(1) else { return };
    let pixel_of = |point: Vec3| {
        let index = (0..=last).rev().find(|&index| views[index].pixel_in_image(point).is_some()).unwrap_or(0);
        (views.names()[index], views[index].project_anywhere(point))
    };
    let look_at = |point: Vec2| {
        let position_m = pose.inverse_transform_point(point);
        let (name, pixel) = pixel_of(position_m.extend(0.0));
        (name, pixel, position_m)
    };
    percepts.set_balls(scene.balls().map(|ball| {
        let position_m = pose.inverse_transform_point(ball.position);
        let (camera, pixel) = pixel_of(position_m.extend(ball.radius + ball.height));
        BallPercept::new(camera, pixel, position_m)
    }));
    percepts.goal_posts.extend(scene.posts.iter().filter_map(|post| {
        let colour = post.post.colour?;
        let (camera, pixel, position_m) = look_at(post.position);
        Some(GoalPostPercept::new(camera, colour, pixel, position_m))
    }));
    let others = scene.robots.iter().enumerate().filter(|&(index, _)| Some(index) != own_index);
    percepts.robots.extend(others.map(|(_, robot)| {
        let (camera, pixel, position_m) = look_at(robot.pose.position);
        RobotPercept::new(camera, robot.id.team, pixel, position_m)
    }));
    let landmark = |kind: LandmarkKind, point: Vec2| {
        let (camera, pixel, position_m) = look_at(point);
        LandmarkPercept::new(camera, kind, pixel, position_m)
    };
    let markings = &scene.markings;
    percepts.landmarks.extend(markings.lines.iter().map(|line| {
        let end_position_m = pose.inverse_transform_point(line.end);
        let mut percept = landmark(LandmarkKind::Line { end_pixel: Vec2::ZERO, end_position_m }, line.start);
        let view = &views[cameras.mounts.order(percept.camera).min(last)];
        let end_pixel = view.project_anywhere(end_position_m.extend(0.0));
        percept.kind = LandmarkKind::Line { end_pixel, end_position_m };
        percept
    }));
    percepts.landmarks.extend(
        markings
            .junctions
            .iter()
            .map(|junction| landmark(LandmarkKind::Junction { shape: junction.shape }, junction.position)),
    );
    percepts.landmarks.extend(markings.penalty_crosses.map(|cross| landmark(LandmarkKind::PenaltyCross, cross)));
    percepts.landmarks.push(landmark(LandmarkKind::CentreCircle, Vec2::ZERO));
}
