//! The geometric vision: which things are in view, and what their pixels make of them.

use bevy::prelude::*;

use super::ahead::LandmarksAhead;
use super::gaze::GazeError;
use super::noise::Falloff;
use super::occlusion::{Occluders, Target};
use super::{BallPercept, ClassNoise, GoalPostPercept, Percepts, RobotPercept, VisionNoise};
use crate::appearance::scene::{Scene, SceneBall, ScenePost};
use crate::sensing::camera::CameraSettings;
use naoisis_core::camera_model::{CameraMounts, CameraName, CameraView, CameraViews, ViewSide};
use naoisis_core::geometry::{Pose, unrotate};
use naoisis_core::random::RandomStream;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::team::Team;

/// Heights at which a goal post is looked for, as shares of its own.
const POST_HEIGHTS: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Visible points that make a post seen, of five.
const POST_POINTS_NEEDED: usize = 2;

/// Where on its disc a ball is looked for, as shares of its radius across and up.
const BALL_OFFSETS: [[f32; 2]; 5] = [[0.0, 0.0], [-0.7, 0.0], [0.7, 0.0], [0.0, -0.7], [0.0, 0.7]];

/// Visible points that make a ball seen, of five.
const BALL_POINTS_NEEDED: usize = 3;

/// The distance of a thing cannot be told from its height in the image when that is nearer than this to the lens's, m.
const LEAST_HEIGHT_DIFFERENCE_M: f32 = 0.1;

/// What seems further away than this is not on any pitch, m.
const GREATEST_DISTANCE_M: f32 = 20.0;

/// How often a false detection is tried until it has a place on the ground.
const FALSE_POSITIVE_ATTEMPTS: usize = 8;

/// A robot that looks, in one cycle.
pub(super) struct Observer<'a> {
    pub(super) pose: Pose,
    forward: Vec2,
    /// Where the cameras are.
    pub(super) actual: &'a [CameraView],
    /// Which of them sees furthest aside.
    guide: usize,
    /// Where the robot thinks that they are.
    pub(super) believed: &'a [CameraView],
    pub(super) names: &'a [CameraName],
    pub(super) noise: &'a VisionNoise,
    occluders: &'a Occluders,
    pub(super) stream: &'a mut RandomStream,
    /// For what depends on distance and on what is hidden.
    pub(super) recognition: &'a mut RandomStream,
}

/// What of a thing that stands on the ground its place is told by, best first.
#[derive(Clone, Copy, PartialEq, PartialOrd, Debug)]
pub(super) enum Cue {
    /// The point where it stands.
    Foot,
    /// A point of it this high above the ground, m.
    Height(f32),
    /// Its width in the image, seen at this height, m.
    Width(f32),
}

/// What a robot's cameras see by the angles that its head measures, and what they do see. Kept from robot to robot, so that
/// its memory is written in its place.
#[derive(Default)]
pub(super) struct Views {
    believed: CameraViews,
    actual: CameraViews,
    look_as_believed: bool,
}

impl Views {
    pub(super) fn look(
        &mut self,
        camera: &CameraSettings,
        (measured, gaze): (HeadAngles, &GazeError),
        noise: &VisionNoise,
        stream: &mut RandomStream,
    ) {
        let HeadAngles { yaw, pitch } = gaze.actual(measured);
        let yaw = yaw + stream.gaussian(noise.head_angle_sd);
        let pitch = pitch + stream.gaussian(noise.head_angle_sd);
        self.look_as_believed = measured == HeadAngles { yaw, pitch };
        camera.look(measured, &mut self.believed);
        if !self.look_as_believed {
            camera.look(HeadAngles { yaw, pitch }, &mut self.actual);
        }
    }

    /// Where the cameras are.
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

    /// The same robot in the same cycle, whose noise is drawn from another stream.
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
        self.imagine(percepts, scene);
    }

    /// Whether a thing at a place (robot frame, m) is recognised this time if all of it is in view: how much it may then have against
    /// it, as [`Falloff::draw_odds`] has it. Asked before it is known what of it is in view, which takes longer.
    pub(super) fn may_recognise(&mut self, class: &ClassNoise, place: Vec2) -> Option<f32> {
        match class.falloff {
            None => (!self.stream.chance(class.miss_probability)).then_some(f32::INFINITY),
            Some(falloff) => {
                let odds = Falloff::draw_odds(class.miss_probability, self.recognition);
                (falloff.odds_against(place.length()) <= odds).then_some(odds)
            }
        }
    }

    /// Whether a thing at a place (robot frame, m) that may have so much against it is recognised by its size in the image: of which
    /// so many of the points are `visible`, at least `at_least` and at most `of`. They are counted only where it depends on them.
    pub(super) fn is_noticed(
        &self,
        class: &ClassNoise,
        (place, odds): (Vec2, f32),
        (at_least, of): (usize, usize),
        visible: impl FnOnce(&Self) -> usize,
    ) -> bool {
        let Some(falloff) = class.falloff else { return true };
        let is_near_enough = |visible: usize| {
            let seems_at_m = place.length() * (of as f32 / visible as f32).sqrt();
            falloff.odds_against(seems_at_m) <= odds
        };
        is_near_enough(at_least) || is_near_enough(visible(self))
    }

    pub(super) fn see_ball(&mut self, ball: SceneBall) -> Option<BallPercept> {
        let class = &self.noise.ball;
        let place = self.in_robot_frame(ball.position);
        if class.is_too_far(place) || self.side_of(place) != ViewSide::Inside {
            return None;
        }
        let odds = self.may_recognise(class, place)?;
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
        let side = self.best_camera(|observer, side| {
            let view = &observer.actual[side];
            let pixel = view.may_see(centre, ball.radius).then(|| view.project(centre))??;
            let is_seen = observer.sees_all(side, centre, ball.radius, target)
                || observer.sees_enough(side, &points(view), target, BALL_POINTS_NEEDED);
            is_seen.then(|| view.offset_from_centre_squared(pixel))
        })?;
        let counts = (BALL_POINTS_NEEDED, BALL_OFFSETS.len());
        let is_noticed = self.is_noticed(class, (place, odds), counts, |observer| {
            if observer.sees_all(side, centre, ball.radius, target) {
                return BALL_OFFSETS.len();
            }
            let points = points(&observer.actual[side]);
            points.iter().filter(|&&point| observer.is_visible(side, point, target)).count()
        });
        if !is_noticed {
            return None;
        }
        let pixel = self.measured_pixel_in_image(side, centre, class.pixel_sd)?;
        let position_m = on_pitch(self.believed[side].point_at_height(pixel, ball.radius))?;
        Some(BallPercept { camera: self.names[side], pixel, position_m })
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
        let odds = self.may_recognise(class, place)?;
        let target = self.judge(Target::Post(index), place, 0.0);
        let (side, cue) = self.best_cue(place, target, |observer, side| {
            let view = &observer.actual[side];
            if !view.may_see(place.extend(height / 2.0), height / 2.0) {
                return None;
            }
            let mut visible = [false; POST_HEIGHTS.len()];
            for (is_visible, share) in visible.iter_mut().zip(POST_HEIGHTS) {
                *is_visible = observer.is_visible(side, place.extend(share * height), target);
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
        // Its foot alone may be in this image, and the rest in the other.
        let is_noticed = self.is_noticed(class, (place, odds), (1, POST_HEIGHTS.len()), |observer| {
            let is_visible = |share: f32| observer.is_visible(side, place.extend(share * height), target);
            POST_HEIGHTS.into_iter().filter(|&share| is_visible(share)).count()
        });
        if !is_noticed {
            return None;
        }
        let (pixel, position_m) = self.measured_standing_point(side, place, post.post.radius, cue, class.pixel_sd)?;
        Some(GoalPostPercept { camera: self.names[side], colour, pixel, position_m })
    }

    /// Things where there are none.
    fn imagine(&mut self, percepts: &mut Percepts, scene: &Scene) {
        let VisionNoise { ball, goal_posts, robots, .. } = self.noise;
        if percepts.ball.is_none() && self.stream.chance(ball.false_positive_probability) {
            let radius = scene.ball.map_or(0.0, |ball| ball.radius);
            percepts.ball = self.imagined_place(ball, radius).map(|(camera, pixel, position_m)| BallPercept {
                camera,
                pixel,
                position_m,
            });
        }
        if self.stream.chance(goal_posts.false_positive_probability) {
            let [one, other] = scene.markings.goal_colours;
            let colour = if self.stream.chance(0.5) { one } else { other };
            percepts.goal_posts.extend(
                self.imagined_place(goal_posts, 0.0).map(|(camera, pixel, position_m)| GoalPostPercept {
                    camera,
                    colour,
                    pixel,
                    position_m,
                }),
            );
        }
        if self.stream.chance(robots.false_positive_probability) {
            let team = if self.stream.chance(0.5) { Team::Blue } else { Team::Pink };
            percepts.robots.extend(self.imagined_place(robots, 0.0).map(|(camera, pixel, position_m)| RobotPercept {
                camera,
                team,
                pixel,
                position_m,
            }));
        }
    }

    /// A pixel anywhere in the two images that has a place on the ground within the class's greatest distance.
    fn imagined_place(&mut self, class: &ClassNoise, height: f32) -> Option<(CameraName, Vec2, Vec2)> {
        (0..FALSE_POSITIVE_ATTEMPTS).find_map(|_| {
            let count = self.believed.len();
            let side = count - 1 - ((self.stream.uniform() * count as f32) as usize).min(count - 1);
            let view = &self.believed[side];
            let pixel = view.intrinsics.size * Vec2::new(self.stream.uniform(), self.stream.uniform());
            let place = on_pitch(view.point_at_height(pixel, height)).filter(|&place| !class.is_too_far(place))?;
            Some((self.names[side], pixel, place))
        })
    }

    /// A point of the pitch in the robot's frame.
    pub(super) fn in_robot_frame(&self, point: Vec2) -> Vec2 {
        unrotate(self.forward, point - self.pose.position)
    }

    /// On which side of the view of both cameras a place certainly is (robot frame, m).
    pub(super) fn side_of(&self, place: Vec2) -> ViewSide {
        self.actual[self.guide].side_of(place)
    }

    /// Whether a camera sees a point (robot frame, m) of a target.
    // What a call would pass in memory is read again at once, which takes longer than the rest.
    #[inline(always)]
    pub(super) fn is_visible(&self, side: usize, point: Vec3, target: Target) -> bool {
        self.visible_pixel(side, point, target).is_some()
    }

    /// The pixel of a point (robot frame, m) of a target that a camera sees.
    #[inline(always)]
    pub(super) fn visible_pixel(&self, side: usize, point: Vec3, target: Target) -> Option<Vec2> {
        self.actual[side].pixel_in_image(point).filter(|_| !self.is_hidden(side, point, target))
    }

    /// Whether something hides a point (robot frame, m) of a target from a camera.
    #[inline(always)]
    pub(super) fn is_hidden(&self, side: usize, point: Vec3, target: Target) -> bool {
        self.occluders.hide(&self.actual[side].lens, point.truncate(), point.z, target)
    }

    /// Whether a camera certainly sees all of a target, which is within `radius` m of a point (robot frame, m).
    pub(super) fn sees_all(&self, side: usize, centre: Vec3, radius: f32, target: Target) -> bool {
        target == Target::Unobstructed && self.actual[side].surely_sees(centre, radius)
    }

    /// Whether a camera sees `needed` of these points.
    pub(super) fn sees_enough(&self, side: usize, points: &[Vec3], target: Target, needed: usize) -> bool {
        are_enough(points, needed, |point| self.is_visible(side, point, target))
    }

    /// The target as [`Occluders::judge`] sees it, for either camera.
    pub(super) fn judge(&self, target: Target, place: Vec2, radius: f32) -> Target {
        // The lenses of a head are less than 5 cm apart on the ground, whatever its pitch, or so much further.
        let lens = self.actual[self.guide].lens;
        let apart = |view: &CameraView| (view.lens - lens).truncate().length();
        let apart = if self.actual.len() > 2 { self.actual.iter().map(apart).fold(0.05, f32::max) } else { 0.05 };
        self.occluders.judge(target, lens, place, radius + apart)
    }

    /// The camera with the least score, if any has one.
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

    /// The camera and the cue by which a target that stands at `place` is best located, if a camera recognises it by a
    /// cue at all. Then the foot of the target counts, whichever camera sees it: of two, that which has it nearer to the
    /// middle of its image.
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
    pub(super) fn measured_pixel(&mut self, side: usize, point: Vec3, pixel_sd: f32) -> Option<Vec2> {
        let pixel = self.actual[side].project(point)?;
        Some(pixel + self.pixel_error(pixel_sd))
    }

    fn pixel_error(&mut self, pixel_sd: f32) -> Vec2 {
        Vec2::new(self.stream.gaussian(pixel_sd), self.stream.gaussian(pixel_sd))
    }

    /// The measured pixel of a point in view: noise does not push it out of the image.
    pub(super) fn measured_pixel_in_image(&mut self, side: usize, point: Vec3, pixel_sd: f32) -> Option<Vec2> {
        let pixel = self.actual[side].project(point)?;
        Some(self.measured_in_image(side, pixel, pixel_sd))
    }

    /// What is measured of a pixel of the image: noise does not push it out.
    pub(super) fn measured_in_image(&mut self, side: usize, pixel: Vec2, pixel_sd: f32) -> Vec2 {
        let pixel = pixel + self.pixel_error(pixel_sd);
        self.actual[side].clamp_to_image(pixel)
    }

    /// Where a pixel lies on the ground, as the robot sees it.
    pub(super) fn place_on_ground(&self, side: usize, pixel: Vec2) -> Option<Vec2> {
        on_pitch(self.believed[side].ground_point(pixel))
    }

    /// The pixel where a thing at `place` stands, and its estimated place, measured by one of its cues. The pixel
    /// belongs to the estimate, and is outside the image when the cue is not the foot.
    pub(super) fn measured_standing_point(
        &mut self,
        side: usize,
        place: Vec2,
        radius: f32,
        cue: Cue,
        pixel_sd: f32,
    ) -> Option<(Vec2, Vec2)> {
        let position = match cue {
            Cue::Foot => {
                let pixel = self.measured_pixel_in_image(side, place.extend(0.0), pixel_sd)?;
                return Some((pixel, self.place_on_ground(side, pixel)?));
            }
            Cue::Height(height) => {
                let pixel = self.measured_pixel(side, place.extend(height), pixel_sd)?;
                self.believed[side].point_at_height(pixel, height)
            }
            Cue::Width(height) => {
                let point = place.extend(height);
                let pixel = self.measured_pixel(side, point, pixel_sd)?;
                // At depth z a diameter d is f d / z wide; each of the two edges has its own error.
                let scale = 2.0 * radius * self.actual[side].intrinsics.focal_length;
                let width = scale / self.actual[side].camera_from_robot(point).z
                    + self.stream.gaussian(core::f32::consts::SQRT_2 * pixel_sd);
                let view = &self.believed[side];
                Some((view.lens + scale / width.max(1.0) * view.ray(pixel)).truncate())
            }
        };
        let position = on_pitch(position)?;
        Some((self.believed[side].project_anywhere(position.extend(0.0)), position))
    }
}

/// Whether `needed` of these points are visible, looking at no more of them than it takes.
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

/// Which of the cameras sees furthest aside; the first of several. They all look the same way.
fn widest(views: &[CameraView]) -> usize {
    let slope = |view: &CameraView| view.intrinsics.centre.x / view.intrinsics.focal_length;
    let widest = |best: usize, next: usize| if slope(&views[next]) > slope(&views[best]) { next } else { best };
    (1..views.len()).fold(0, widest)
}

/// The horizontal unit vector across the line of sight to `place`, to the left.
pub(super) fn across_sight(view: &CameraView, place: Vec2) -> Vec2 {
    (place - view.lens.truncate()).normalize_or(Vec2::X).perp()
}

/// A place that something on a pitch may have.
pub(super) fn on_pitch(place: Option<Vec2>) -> Option<Vec2> {
    place.filter(|place| place.length_squared() <= GREATEST_DISTANCE_M * GREATEST_DISTANCE_M)
}
