//! The geometric vision: which objects are in view, and the places that are measured from their pixels.

use bevy::prelude::*;

use super::ahead::LandmarksAhead;
use super::gaze::GazeError;
use super::noise::Falloff;
use super::occlusion::{Occluders, Target};
use super::{BallPercept, ClassNoise, GoalPostPercept, Percepts, VisionNoise};
use crate::appearance::scene::{Scene, SceneBall, ScenePost};
use crate::sensing::camera::CameraSettings;
use naoisis_core::camera_model::{CameraMounts, CameraName, CameraView, CameraViews, ViewSide};
use naoisis_core::geometry::{Pose, unrotate};
use naoisis_core::random::RandomStream;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;

/// The sample points of a goal post, as shares of its height.
const POST_HEIGHTS: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// The number of visible sample points from which a post is in view, of five.
const POST_POINTS_NEEDED: usize = 2;

/// The sample points of a ball's disc, as shares of its radius across and up.
const BALL_OFFSETS: [[f32; 2]; 5] = [[0.0, 0.0], [-0.7, 0.0], [0.7, 0.0], [0.0, -0.7], [0.0, 0.7]];

/// The number of visible sample points from which a ball is in view, of five.
const BALL_POINTS_NEEDED: usize = 3;

/// The least difference between the heights of a point and of the lens at which the distance follows from its pixel, m.
const LEAST_HEIGHT_DIFFERENCE_M: f32 = 0.1;

/// The greatest measured distance of an object on a pitch, m.
const GREATEST_DISTANCE_M: f32 = 20.0;

/// The vision of one robot in one cycle.
pub(super) struct Observer<'a> {
    pub(super) pose: Pose,
    forward: Vec2,
    /// The true views of the cameras.
    pub(super) actual: &'a [CameraView],
    /// The index of the view that reaches furthest to the side.
    guide: usize,
    /// The views that follow from the measured head angles.
    pub(super) believed: &'a [CameraView],
    pub(super) names: &'a [CameraName],
    pub(super) noise: &'a VisionNoise,
    occluders: &'a Occluders,
    pub(super) stream: &'a mut RandomStream,
    /// Random numbers for errors that depend on the distance and on occlusion.
    pub(super) recognition: &'a mut RandomStream,
}

/// The part of an upright object by which its place is measured, best first.
#[derive(Clone, Copy, PartialEq, PartialOrd, Debug)]
pub(super) enum Cue {
    /// Its foot.
    Foot,
    /// A point at this height above the ground, m.
    Height(f32),
    /// Its width in the image, at this height, m.
    Width(f32),
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
            cameras.update_views(body, HeadAngles { yaw, pitch }, &mut self.actual);
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

    /// The same vision with its noise drawn from `stream`.
    pub(super) fn with_stream<'b>(&'b mut self, stream: &'b mut RandomStream) -> Observer<'b> {
        Observer { stream, recognition: self.recognition, ..*self }
    }

    pub(super) fn recognise_everything(
        &mut self,
        percepts: &mut Percepts,
        scene: &Scene,
        own_index: Option<usize>,
        ahead: &mut LandmarksAhead,
    ) {
        if self.actual.is_empty() {
            return;
        }
        percepts.ball = scene.ball.and_then(|ball| self.see_ball(ball));
        for (index, post) in scene.posts.iter().enumerate() {
            percepts.goal_posts.extend(self.see_goal_post(index, post));
        }
        for (index, robot) in scene.robots.iter().enumerate() {
            if Some(index) != own_index {
                percepts.robots.extend(self.see_robot(index, robot));
            }
        }
        self.see_landmarks(&mut percepts.landmarks, &scene.markings, ahead);
        self.add_false_positives(percepts, scene);
    }

    /// Draws whether an object at `place` (robot frame, m) is detected if all of it is visible. Returns the threshold of
    /// [`Falloff::draw_threshold`] if so. Called before occlusion is computed, which takes longer.
    pub(super) fn may_detect(&mut self, class: &ClassNoise, place: Vec2) -> Option<f32> {
        match class.falloff {
            None => (!self.stream.chance(class.miss_probability)).then_some(f32::INFINITY),
            Some(falloff) => {
                let threshold = Falloff::draw_threshold(class.miss_probability, self.recognition);
                (falloff.odds_against(place.length()) <= threshold).then_some(threshold)
            }
        }
    }

    /// Whether an object at `place` (robot frame, m) is detected, given its visible share of sample points: `visible` of `of`, at least
    /// `at_least`. `threshold` is from [`may_detect`](Self::may_detect). The points are only counted if the result depends on them.
    pub(super) fn is_detected(
        &self,
        class: &ClassNoise,
        (place, threshold): (Vec2, f32),
        (at_least, of): (usize, usize),
        visible: impl FnOnce(&Self) -> usize,
    ) -> bool {
        let Some(falloff) = class.falloff else { return true };
        let is_near_enough = |visible: usize| {
            let seems_at_m = place.length() * (of as f32 / visible as f32).sqrt();
            falloff.odds_against(seems_at_m) <= threshold
        };
        is_near_enough(at_least) || is_near_enough(visible(self))
    }

    pub(super) fn see_ball(&mut self, ball: SceneBall) -> Option<BallPercept> {
        let class = &self.noise.ball;
        let place = self.in_robot_frame(ball.position);
        if class.is_too_far(place) || self.side_of(place) != ViewSide::Inside {
            return None;
        }
        let threshold = self.may_detect(class, place)?;
        let centre = place.extend(ball.radius);
        let target = self.judge(Target::Other, place, ball.radius);
        let points = |view: &CameraView| {
            let across = across_sight(view, place) * ball.radius;
            // In a loop, as a closure of `map` would be called for each point.
            let mut points = [centre; BALL_OFFSETS.len()];
            for (point, [right, up]) in points.iter_mut().zip(BALL_OFFSETS) {
                *point += (right * across).extend(up * ball.radius);
            }
            points
        };
        let camera = self.best_camera(|observer, camera| {
            let view = &observer.actual[camera];
            let pixel = view.may_see(centre, ball.radius).then(|| view.project(centre))??;
            let is_seen = observer.sees_all(camera, centre, ball.radius, target)
                || observer.sees_enough(camera, &points(view), target, BALL_POINTS_NEEDED);
            is_seen.then(|| view.offset_from_centre_squared(pixel))
        })?;
        let counts = (BALL_POINTS_NEEDED, BALL_OFFSETS.len());
        let is_detected = self.is_detected(class, (place, threshold), counts, |observer| {
            if observer.sees_all(camera, centre, ball.radius, target) {
                return BALL_OFFSETS.len();
            }
            let points = points(&observer.actual[camera]);
            points.iter().filter(|&&point| observer.is_visible(camera, point, target)).count()
        });
        if !is_detected {
            return None;
        }
        let pixel = self.measured_pixel_in_image(camera, centre, class.pixel_sd)?;
        let position_m = on_pitch(self.believed[camera].point_at_height(pixel, ball.radius))?;
        Some(BallPercept { camera: self.names[camera], pixel, position_m })
    }

    fn see_goal_post(&mut self, index: usize, post: &ScenePost) -> Option<GoalPostPercept> {
        let colour = post.post.colour?;
        let class = &self.noise.goal_posts;
        let place = self.in_robot_frame(post.position);
        let height = post.post.height;
        let is_beside = height <= 2.0 * self.actual[self.guide].lens.z && self.side_of(place) != ViewSide::Inside;
        if class.is_too_far(place) || is_beside {
            return None;
        }
        let threshold = self.may_detect(class, place)?;
        let target = self.judge(Target::Post(index), place, 0.0);
        let (camera, cue) = self.best_cue(place, target, |observer, camera| {
            let view = &observer.actual[camera];
            if !view.may_see(place.extend(height / 2.0), height / 2.0) {
                return None;
            }
            let mut visible = [false; POST_HEIGHTS.len()];
            for (is_visible, share) in visible.iter_mut().zip(POST_HEIGHTS) {
                *is_visible = observer.is_visible(camera, place.extend(share * height), target);
            }
            if visible.iter().filter(|&&visible| visible).count() < POST_POINTS_NEEDED {
                return None;
            }
            let lowest = visible.iter().position(|&visible| visible)?;
            let can_tell_by_top = (height - view.lens.z).abs() >= LEAST_HEIGHT_DIFFERENCE_M;
            Some(match visible {
                [true, ..] => Cue::Foot,
                [.., true] if can_tell_by_top => Cue::Height(height),
                _ => Cue::Width(POST_HEIGHTS[lowest] * height),
            })
        })?;
        // The foot alone may be in this image, and the rest in another.
        let is_detected = self.is_detected(class, (place, threshold), (1, POST_HEIGHTS.len()), |observer| {
            let is_visible = |share: f32| observer.is_visible(camera, place.extend(share * height), target);
            POST_HEIGHTS.into_iter().filter(|&share| is_visible(share)).count()
        });
        if !is_detected {
            return None;
        }
        let (pixel, position_m) = self.measured_standing_point(camera, place, post.post.radius, cue, class.pixel_sd)?;
        Some(GoalPostPercept { camera: self.names[camera], colour, pixel, position_m })
    }

    /// A point of the pitch in the robot's frame.
    pub(super) fn in_robot_frame(&self, point: Vec2) -> Vec2 {
        unrotate(self.forward, point - self.pose.position)
    }

    /// The side of all camera views on which `place` (robot frame, m) certainly is.
    pub(super) fn side_of(&self, place: Vec2) -> ViewSide {
        self.actual[self.guide].side_of(place)
    }

    /// Whether a point (robot frame, m) of a target is visible to a camera.
    // Inlined: arguments passed in memory would be read again at once, which takes longer than the rest.
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

    /// Whether all of a target within `radius` m of `centre` (robot frame, m) is certainly visible to a camera.
    pub(super) fn sees_all(&self, camera: usize, centre: Vec3, radius: f32, target: Target) -> bool {
        target == Target::Unobstructed && self.actual[camera].surely_sees(centre, radius)
    }

    /// Whether at least `needed` of these points are visible to a camera.
    pub(super) fn sees_enough(&self, camera: usize, points: &[Vec3], target: Target, needed: usize) -> bool {
        are_enough(points, needed, |point| self.is_visible(camera, point, target))
    }

    /// The target, or [`Target::Unobstructed`], for all cameras: see [`Occluders::judge`].
    pub(super) fn judge(&self, target: Target, place: Vec2, radius: f32) -> Target {
        // Seen from above, two lenses of a head are at most 5 cm apart at any pitch; more lenses may be further apart.
        let lens = self.actual[self.guide].lens;
        let apart = |view: &CameraView| (view.lens - lens).truncate().length();
        let apart = if self.actual.len() > 2 { self.actual.iter().map(apart).fold(0.05, f32::max) } else { 0.05 };
        self.occluders.judge(target, lens, place, radius + apart)
    }

    /// The camera with the least score; `None` if no camera has one.
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

    /// The camera and the cue by which a target that stands at `place` is best located; `None` if no camera has a cue. If a camera sees
    /// the foot, it is the cue: among several cameras, of the one that has it nearest to the middle of its image.
    pub(super) fn best_cue(
        &self,
        place: Vec2,
        target: Target,
        cue: impl Fn(&Self, usize) -> Option<Cue>,
    ) -> Option<(usize, Cue)> {
        let foot = place.extend(0.0);
        let mut best: Option<(usize, Cue)> = None;
        let mut have_foot = [false; CameraMounts::MOST];
        for (index, has_foot) in have_foot.iter_mut().enumerate().take(self.actual.len()) {
            if let Some(cue) = cue(self, index) {
                *has_foot = cue == Cue::Foot;
                if best.is_none_or(|(_, least)| cue < least) {
                    best = Some((index, cue));
                }
            }
        }
        best?;
        let by_foot = self.best_camera(|observer, index| {
            let view = &observer.actual[index];
            let sees_foot = have_foot[index] || observer.is_visible(index, foot, target);
            sees_foot.then(|| view.offset_from_centre_squared(view.project_anywhere(foot)))
        });
        by_foot.map(|index| (index, Cue::Foot)).or(best)
    }

    /// The measured pixel of a point (robot frame, m).
    pub(super) fn measured_pixel(&mut self, camera: usize, point: Vec3, pixel_sd: f32) -> Option<Vec2> {
        let pixel = self.actual[camera].project(point)?;
        Some(pixel + self.pixel_error(pixel_sd))
    }

    fn pixel_error(&mut self, pixel_sd: f32) -> Vec2 {
        Vec2::new(self.stream.gaussian(pixel_sd), self.stream.gaussian(pixel_sd))
    }

    /// The measured pixel of a point in view; noise does not move it out of the image.
    pub(super) fn measured_pixel_in_image(&mut self, camera: usize, point: Vec3, pixel_sd: f32) -> Option<Vec2> {
        let pixel = self.actual[camera].project(point)?;
        Some(self.measured_in_image(camera, pixel, pixel_sd))
    }

    /// A pixel of the image with its error; noise does not move it out of the image.
    pub(super) fn measured_in_image(&mut self, camera: usize, pixel: Vec2, pixel_sd: f32) -> Vec2 {
        let pixel = pixel + self.pixel_error(pixel_sd);
        self.actual[camera].clamp_to_image(pixel)
    }

    /// The place on the ground that the robot computes from a pixel, m, robot frame.
    pub(super) fn place_on_ground(&self, camera: usize, pixel: Vec2) -> Option<Vec2> {
        on_pitch(self.believed[camera].ground_point(pixel))
    }

    /// The measured pixel of the foot of an object at `place`, and its measured place, by `cue`. If the cue is not the foot, the pixel
    /// follows from the measured place, and may be outside the image.
    pub(super) fn measured_standing_point(
        &mut self,
        camera: usize,
        place: Vec2,
        radius: f32,
        cue: Cue,
        pixel_sd: f32,
    ) -> Option<(Vec2, Vec2)> {
        let position = match cue {
            Cue::Foot => {
                let pixel = self.measured_pixel_in_image(camera, place.extend(0.0), pixel_sd)?;
                return Some((pixel, self.place_on_ground(camera, pixel)?));
            }
            Cue::Height(height) => {
                let pixel = self.measured_pixel(camera, place.extend(height), pixel_sd)?;
                self.believed[camera].point_at_height(pixel, height)
            }
            Cue::Width(height) => {
                let point = place.extend(height);
                let pixel = self.measured_pixel(camera, point, pixel_sd)?;
                // At depth z a diameter d is f d / z wide; each of the two edges has its own error.
                let scale = 2.0 * radius * self.actual[camera].intrinsics.focal_length;
                let width = scale / self.actual[camera].camera_from_robot(point).z
                    + self.stream.gaussian(core::f32::consts::SQRT_2 * pixel_sd);
                let view = &self.believed[camera];
                Some((view.lens + scale / width.max(1.0) * view.ray(pixel)).truncate())
            }
        };
        let position = on_pitch(position)?;
        Some((self.believed[camera].project_anywhere(position.extend(0.0)), position))
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

/// The index of the view that reaches furthest to the side; the first of several.
fn widest(views: &[CameraView]) -> usize {
    let slope = |view: &CameraView| view.intrinsics.centre.x / view.intrinsics.focal_length;
    let widest = |best: usize, next: usize| if slope(&views[next]) > slope(&views[best]) { next } else { best };
    (1..views.len()).fold(0, widest)
}

/// The horizontal unit vector across the line of sight to `place`, to the left.
pub(super) fn across_sight(view: &CameraView, place: Vec2) -> Vec2 {
    (place - view.lens.truncate()).normalize_or(Vec2::X).perp()
}

/// Filters out places that are too far away to be on a pitch.
pub(super) fn on_pitch(place: Option<Vec2>) -> Option<Vec2> {
    place.filter(|place| place.length_squared() <= GREATEST_DISTANCE_M * GREATEST_DISTANCE_M)
}
