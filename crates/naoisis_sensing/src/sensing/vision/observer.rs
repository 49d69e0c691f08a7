//! The view of one robot in one cycle: which parts of the scene its cameras see, and which are hidden.

use bevy::prelude::*;

use super::VisionNoise;
use super::gaze::GazeError;
use super::occlusion::{Occluders, Target};
use crate::sensing::camera::CameraSettings;
use naoisis_core::camera_model::{CameraName, CameraView, CameraViews, ViewSide};
use naoisis_core::geometry::{Pose, unrotate};
use naoisis_core::random::RandomStream;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;

/// The vision of one robot in one cycle.
pub(super) struct Observer<'a> {
    pub(super) pose: Pose,
    forward: Vec2,
    /// The true views of the cameras.
    pub(super) actual: &'a [CameraView],
    /// The index of the view that reaches furthest to the side.
    pub(super) guide: usize,
    /// The views that follow from the measured head angles.
    pub(super) believed: &'a [CameraView],
    pub(super) names: &'a [CameraName],
    pub(super) noise: &'a VisionNoise,
    occluders: &'a Occluders,
    pub(super) stream: &'a mut RandomStream,
    /// Random numbers for errors that depend on the distance and on occlusion.
    pub(super) recognition: &'a mut RandomStream,
}

/// The camera views of a robot that follow from its measured head angles, and the true ones. Reused from robot to robot, to save memory.
#[derive(Default)]
pub(super) struct Views {
    believed: CameraViews,
    actual: CameraViews,
    look_as_believed: bool,
}

impl Views {
    /// Computes the views of a robot in this cycle, with an error of the head angles drawn from `stream`.
    pub(super) fn update(
        &mut self,
        (cameras, body): (&CameraSettings, &Body),
        (measured, gaze): (HeadAngles, &GazeError),
        noise: &VisionNoise,
        stream: &mut RandomStream,
    ) {
        let HeadAngles { yaw, pitch } = gaze.actual(measured);
        let yaw = yaw + stream.gaussian(noise.head_angle_sd);
        let pitch = pitch + stream.gaussian(noise.head_angle_sd);
        self.look_as_believed = measured == HeadAngles { yaw, pitch };
        cameras.update_views(body, measured, &mut self.believed);
        if !self.look_as_believed {
            self.actual.set_as(&self.believed, &cameras.mounts, body.neck_m, HeadAngles { yaw, pitch });
        }
    }

    /// The true views of the cameras.
    pub(super) fn actual(&self) -> &CameraViews {
        if self.look_as_believed { &self.believed } else { &self.actual }
    }
}

impl<'a> Observer<'a> {
    pub(super) fn new(
        views: &'a Views,
        pose: Pose,
        noise: &'a VisionNoise,
        occluders: &'a Occluders,
        [stream, recognition]: [&'a mut RandomStream; 2],
    ) -> Self {
        let (actual, believed, names) = (views.actual(), &views.believed, views.believed.names());
        let guide = widest(believed);
        Self { pose, forward: pose.forward(), guide, actual, believed, names, noise, occluders, stream, recognition }
    }

    /// The same vision, with its noise drawn from `stream`.
    pub(super) fn with_stream<'b>(&'b mut self, stream: &'b mut RandomStream) -> Observer<'b> {
        Observer { stream, recognition: self.recognition, ..*self }
    }

    /// A point of the pitch in the robot's frame.
    pub(super) fn in_robot_frame(&self, point: Vec2) -> Vec2 {
        unrotate(self.forward, point - self.pose.position)
    }

    /// The side of all camera views on which `place` (robot frame, m) certainly lies.
    pub(super) fn side_of(&self, place: Vec2) -> ViewSide {
        self.actual[self.guide].side_of(place)
    }

    /// Whether a point (robot frame, m) of a target is visible to a camera.
    // Inlined, as arguments passed in memory would be read back at once, which takes longer than the rest.
    #[inline(always)]
    pub(super) fn is_visible(&self, camera: usize, point: Vec3, target: Target) -> bool {
        self.visible_pixel(camera, point, target).is_some()
    }

    /// The pixel of a point (robot frame, m) of a target, if it is visible to a camera.
    #[inline(always)]
    pub(super) fn visible_pixel(&self, camera: usize, point: Vec3, target: Target) -> Option<Vec2> {
        self.actual[camera].pixel_in_image(point).filter(|_| !self.is_hidden(camera, point, target))
    }

    /// Whether a robot or post hides a point (robot frame, m) of a target from a camera.
    #[inline(always)]
    pub(super) fn is_hidden(&self, camera: usize, point: Vec3, target: Target) -> bool {
        self.occluders.hide(&self.actual[camera].lens, point.truncate(), point.z, target)
    }

    /// The robot or post that hides a point (robot frame, m) of a target from a camera.
    pub(super) fn hider(&self, camera: usize, point: Vec3, target: Target) -> Option<Target> {
        self.occluders.hider(&self.actual[camera].lens, point.truncate(), point.z, target)
    }

    /// Whether the whole part of a target within `radius` m of `centre` (robot frame, m) is certainly visible to a camera.
    pub(super) fn sees_all(&self, camera: usize, centre: Vec3, radius: f32, target: Target) -> bool {
        target == Target::Unobstructed && self.actual[camera].surely_sees(centre, radius)
    }

    /// Whether at least `needed` of these points are visible to a camera.
    pub(super) fn sees_enough(&self, camera: usize, points: &[Vec3], target: Target, needed: usize) -> bool {
        are_enough(points, needed, |point| self.is_visible(camera, point, target))
    }

    /// Returns the target, or [`Target::Unobstructed`] for all cameras: see [`Occluders::judge`].
    pub(super) fn judge(&self, target: Target, place: Vec2, radius: f32) -> Target {
        // Seen from above, two lenses of a head are at most 5 cm apart at any pitch; more lenses may be further apart.
        let lens = self.actual[self.guide].lens;
        let apart = |view: &CameraView| (view.lens - lens).truncate().length();
        let apart = if self.actual.len() > 2 { self.actual.iter().map(apart).fold(0.05, f32::max) } else { 0.05 };
        self.occluders.judge(target, lens, place, radius + apart)
    }

    /// The index of the camera with the least score; `None` if no camera has one.
    pub(super) fn best_camera(&self, score: impl Fn(&Self, usize) -> Option<f32>) -> Option<usize> {
        let mut best: Option<(usize, f32)> = None;
        for index in 0..self.actual.len() {
            if let Some(score) = score(self, index)
                && best.is_none_or(|(_, least)| score < least)
            {
                best = Some((index, score));
            }
        }
        best.map(|(index, _)| index)
    }
}

/// Whether at least `needed` of these points are visible. Checks no more points than necessary.
pub(super) fn are_enough(points: &[Vec3], needed: usize, is_visible: impl Fn(Vec3) -> bool) -> bool {
    let mut visible = 0;
    for (index, &point) in points.iter().enumerate() {
        visible += usize::from(is_visible(point));
        let left = points.len() - index - 1;
        if visible >= needed || visible + left < needed {
            break;
        }
    }
    visible >= needed
}

/// The horizontal unit vector across the line of sight to `place`, to the left.
pub(super) fn across_sight(view: &CameraView, place: Vec2) -> Vec2 {
    (place - view.lens.truncate()).normalize_or(Vec2::X).perp()
}

/// The index of the view that reaches furthest to the side; the first of several.
fn widest(views: &[CameraView]) -> usize {
    let slope = |view: &CameraView| view.intrinsics.half_slopes().x;
    let widest = |best: usize, next: usize| if slope(&views[next]) > slope(&views[best]) { next } else { best };
    (1..views.len()).fold(0, widest)
}
