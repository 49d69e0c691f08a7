//! The geometric vision: decides which objects of the scene a robot detects. This module covers balls and goal posts.

use bevy::prelude::*;

use super::ahead::LandmarksAhead;
use super::measuring::{Cue, on_pitch};
use super::missed::{Miss, MissedObject};
use super::noise::Falloff;
use super::observer::{Observer, across_sight};
use super::occlusion::Target;
use super::{BallPercept, ClassNoise, GoalPostPercept, Percepts};
use crate::appearance::scene::{Scene, SceneBall, ScenePost};
use naoisis_core::camera_model::{CameraView, ViewSide};
use naoisis_core::pitch::GoalColour;

/// The sample points of a goal post, as shares of its height.
pub(super) const POST_HEIGHTS: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// The least number of visible sample points, of five, with which a post is in view.
pub(super) const POST_POINTS_NEEDED: usize = 2;

/// The sample points of a ball's disc, as shares of its radius across and up.
pub(super) const BALL_OFFSETS: [[f32; 2]; 5] = [[0.0, 0.0], [-0.7, 0.0], [0.7, 0.0], [0.0, -0.7], [0.0, 0.7]];

/// The least number of visible sample points, of five, with which a ball is in view.
pub(super) const BALL_POINTS_NEEDED: usize = 3;

/// The least difference between the heights of a point and of the lens at which the distance follows from its pixel, m.
const LEAST_HEIGHT_DIFFERENCE_M: f32 = 0.1;

impl Observer<'_> {
    /// Fills in the true detections of this cycle, and adds the other objects to `missed`, if it is wanted. `own_index` is the index of the
    /// robot itself in the scene.
    pub(super) fn recognise_everything(
        &mut self,
        percepts: &mut Percepts,
        scene: &Scene,
        own_index: Option<usize>,
        ahead: &mut LandmarksAhead,
        mut missed: Option<&mut Vec<MissedObject>>,
    ) {
        if self.actual.is_empty() {
            return;
        }
        percepts.set_balls(scene.balls().enumerate().filter_map(|(index, ball)| {
            let seen = self.see_ball(*ball);
            note(&mut missed, seen, |miss| self.missed_ball(scene, index, ball, miss))
        }));
        for (index, post) in scene.posts.iter().enumerate() {
            let Some(colour) = post.post.colour else { continue };
            let seen = self.see_goal_post(index, post, colour);
            percepts.goal_posts.extend(note(&mut missed, seen, |miss| self.missed_post(scene, index, miss)));
        }
        for (index, robot) in scene.robots.iter().enumerate() {
            if Some(index) != own_index {
                let seen = self.see_robot(index, robot);
                percepts.robots.extend(note(&mut missed, seen, |miss| self.missed_robot(scene, index, miss)));
            }
        }
        self.see_landmarks(&mut percepts.landmarks, &scene.markings, ahead);
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

    /// Whether an object at `place` (robot frame, m) is detected, given that `visible` of its `of` sample points are visible; at least
    /// `at_least` must be. `threshold` is from [`may_detect`](Self::may_detect). The points are only counted if the result depends on them.
    pub(super) fn is_detected(
        &self,
        class: &ClassNoise,
        (place, threshold): (Vec2, f32),
        (at_least, of): (usize, usize),
        visible: impl FnOnce(&Self) -> usize,
    ) -> bool {
        let Some(falloff) = class.falloff else { return true };
        let is_near_enough =
            |visible: usize| falloff.odds_against(seems_at_m(place.length(), visible, of)) <= threshold;
        is_near_enough(at_least) || is_near_enough(visible(self))
    }

    pub(super) fn see_ball(&mut self, ball: SceneBall) -> Result<BallPercept, Miss> {
        let class = &self.noise.ball;
        let place = self.in_robot_frame(ball.position);
        if class.is_too_far(place) || self.side_of(place) != ViewSide::Inside {
            return Err(Miss::NotDetected);
        }
        let threshold = self.may_detect(class, place).ok_or(Miss::NotDetected)?;
        let target = self.judge(Target::Other, place, ball.radius);
        let camera = self.ball_camera(&ball, place, target).ok_or(Miss::NotDetected)?;
        let counts = (BALL_POINTS_NEEDED, BALL_OFFSETS.len());
        let is_detected = self.is_detected(class, (place, threshold), counts, |observer| {
            observer.visible_points_of_ball(camera, &ball, place, target)
        });
        if !is_detected {
            return Err(Miss::NotDetected);
        }
        let centre = place.extend(ball.radius + ball.height);
        let pixel = self.measured_pixel_in_image(camera, centre, class.pixel_sd).ok_or(Miss::NotMeasured)?;
        let position_m =
            on_pitch(self.believed[camera].point_at_height(pixel, ball.radius)).ok_or(Miss::NotMeasured)?;
        Ok(BallPercept::new(self.names[camera], pixel, position_m))
    }

    /// The camera that sees a ball at `place` (robot frame, m) best, if one sees enough of it.
    pub(super) fn ball_camera(&self, ball: &SceneBall, place: Vec2, target: Target) -> Option<usize> {
        let centre = place.extend(ball.radius + ball.height);
        self.best_camera(|observer, camera| {
            let view = &observer.actual[camera];
            let pixel = view.may_see(centre, ball.radius).then(|| view.project(centre))??;
            let is_seen = observer.sees_all(camera, centre, ball.radius, target)
                || observer.sees_enough(camera, &ball_points(view, ball, place), target, BALL_POINTS_NEEDED);
            is_seen.then(|| view.offset_from_centre_squared(pixel))
        })
    }

    /// The number of the sample points of a ball at `place` (robot frame, m) that are visible to a camera.
    pub(super) fn visible_points_of_ball(&self, camera: usize, ball: &SceneBall, place: Vec2, target: Target) -> usize {
        if self.sees_all(camera, place.extend(ball.radius + ball.height), ball.radius, target) {
            return BALL_OFFSETS.len();
        }
        let points = ball_points(&self.actual[camera], ball, place);
        points.iter().filter(|&&point| self.is_visible(camera, point, target)).count()
    }

    fn see_goal_post(&mut self, index: usize, post: &ScenePost, colour: GoalColour) -> Result<GoalPostPercept, Miss> {
        let class = &self.noise.goal_posts;
        let place = self.in_robot_frame(post.position);
        let height = post.post.height;
        if class.is_too_far(place) || self.is_post_beside(place, height) {
            return Err(Miss::NotDetected);
        }
        let threshold = self.may_detect(class, place).ok_or(Miss::NotDetected)?;
        let target = self.judge(Target::Post(index), place, 0.0);
        let (camera, cue) = self.post_cue(place, height, target).ok_or(Miss::NotDetected)?;
        // The foot alone may be in this image, and the rest in another.
        let is_detected = self.is_detected(class, (place, threshold), (1, POST_HEIGHTS.len()), |observer| {
            observer.visible_points_of_post(camera, place, height, target)
        });
        if !is_detected {
            return Err(Miss::NotDetected);
        }
        let (pixel, position_m) = self
            .measured_standing_point(camera, place, post.post.radius, cue, class.pixel_sd)
            .ok_or(Miss::NotMeasured)?;
        Ok(GoalPostPercept::new(self.names[camera], colour, pixel, position_m))
    }

    /// Whether a post of this height at `place` (robot frame, m) is certainly beside all images.
    pub(super) fn is_post_beside(&self, place: Vec2, height: f32) -> bool {
        height <= 2.0 * self.actual[self.guide].lens.z && self.side_of(place) != ViewSide::Inside
    }

    /// The camera and the cue by which a post at `place` (robot frame, m) is located, if enough of it is visible.
    pub(super) fn post_cue(&self, place: Vec2, height: f32, target: Target) -> Option<(usize, Cue)> {
        self.best_cue(place, target, |observer, camera| {
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
        })
    }

    /// The number of the sample points of a post at `place` (robot frame, m) that are visible to a camera.
    pub(super) fn visible_points_of_post(&self, camera: usize, place: Vec2, height: f32, target: Target) -> usize {
        let is_visible = |share: f32| self.is_visible(camera, place.extend(share * height), target);
        POST_HEIGHTS.into_iter().filter(|&share| is_visible(share)).count()
    }
}

/// The distance, m, at which a whole object would look as large as one at `distance_m` of which only `visible` of `of` points are visible.
pub(super) fn seems_at_m(distance_m: f32, visible: usize, of: usize) -> f32 {
    distance_m * (of as f32 / visible as f32).sqrt()
}

/// The sample points of a ball at `place` (robot frame, m).
pub(super) fn ball_points(view: &CameraView, ball: &SceneBall, place: Vec2) -> [Vec3; BALL_OFFSETS.len()] {
    let across = across_sight(view, place) * ball.radius;
    // A loop, as a closure for `map` would be called for each point.
    let mut points = [place.extend(ball.radius + ball.height); BALL_OFFSETS.len()];
    for (point, [right, up]) in points.iter_mut().zip(BALL_OFFSETS) {
        *point += (right * across).extend(up * ball.radius);
    }
    points
}

/// Returns the percept in `seen`, if there is one. Otherwise adds the object to `missed`, if it is wanted.
fn note<P>(
    missed: &mut Option<&mut Vec<MissedObject>>,
    seen: Result<P, Miss>,
    object: impl FnOnce(Miss) -> MissedObject,
) -> Option<P> {
    match seen {
        Ok(percept) => Some(percept),
        Err(miss) => {
            if let Some(missed) = missed {
                missed.push(object(miss));
            }
            None
        }
    }
}
