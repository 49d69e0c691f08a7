//! Percepts for debugging: everything on the pitch, in its true place.

use bevy::prelude::*;

use super::{BallPercept, GoalPostPercept, LandmarkKind, LandmarkPercept, Percepts, RobotPercept};
use crate::appearance::scene::Scene;
use crate::camera_model::{CameraIntrinsics, CameraSide, CameraView};
use crate::geometry::Pose;
use crate::robot::head::HeadAngles;
use crate::sensing::camera::CameraSettings;

/// Fills the percepts with everything, wherever the robot looks. The camera is the lower one if that has the thing in its
/// image, otherwise the upper one; the pixel of what no camera sees is outside the image.
pub(super) fn know_everything(
    percepts: &mut Percepts,
    scene: &Scene,
    own_index: Option<usize>,
    pose: Pose,
    camera: &CameraSettings,
    head: HeadAngles,
) {
    let views = CameraView::both(CameraIntrinsics::from(camera), head);
    let pixel_of = |point: Vec3| {
        let side = usize::from(views[1].pixel_in_image(point).is_some());
        (CameraSide::BOTH[side], views[side].project_anywhere(point))
    };
    let look_at = |point: Vec2| {
        let position_m = pose.inverse_transform_point(point);
        let (camera, pixel) = pixel_of(position_m.extend(0.0));
        (camera, pixel, position_m)
    };
    percepts.ball = scene.ball.map(|ball| {
        let position_m = pose.inverse_transform_point(ball.position);
        let (camera, pixel) = pixel_of(position_m.extend(ball.radius));
        BallPercept { camera, pixel, position_m }
    });
    percepts.goal_posts.extend(scene.posts.iter().filter_map(|post| {
        let colour = post.post.colour?;
        let (camera, pixel, position_m) = look_at(post.position);
        Some(GoalPostPercept { camera, colour, pixel, position_m })
    }));
    let others = scene.robots.iter().enumerate().filter(|&(index, _)| Some(index) != own_index);
    percepts.robots.extend(others.map(|(_, robot)| {
        let (camera, pixel, position_m) = look_at(robot.pose.position);
        RobotPercept { camera, team: robot.id.team, pixel, position_m }
    }));
    let landmark = |kind: LandmarkKind, point: Vec2| {
        let (camera, pixel, position_m) = look_at(point);
        LandmarkPercept { camera, kind, pixel, position_m }
    };
    let markings = &scene.markings;
    percepts.landmarks.extend(markings.lines.iter().map(|line| {
        let end_position_m = pose.inverse_transform_point(line.end);
        let mut percept = landmark(LandmarkKind::Line { end_pixel: Vec2::ZERO, end_position_m }, line.start);
        let view = &views[percept.camera as usize];
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
