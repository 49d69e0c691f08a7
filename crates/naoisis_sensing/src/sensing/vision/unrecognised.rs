//! Finds why objects on the pitch are not among a robot's percepts, for people who look at its images.
//!
//! The vision notes this only if the program has inserted [`Unrecognised`], and detects the same with and without it: the reason is found
//! after the detection, from the same views, occluders and settings.

use bevy::prelude::*;

use super::gaze::GazeError;
use super::geometric::{BALL_OFFSETS, BALL_POINTS_NEEDED, POST_HEIGHTS, POST_POINTS_NEEDED, ball_points, seems_at_m};
use super::missed::{Cover, Miss, MissedObject, SceneObject, Unrecognised, WhyMissed};
use super::noise::ClassNoise;
use super::observer::Observer;
use super::occlusion::{Occluders, Target};
use super::robots::{WAISTBAND_POINTS, WAISTBAND_POINTS_NEEDED, radius_of, waistband};
use super::{Percepts, VisionSettings, VisionSource};
use crate::appearance::scene::{Scene, SceneBall};
use crate::sensing::camera::{CameraImages, CameraSettings};
use naoisis_core::camera_model::{CameraView, ViewSide};
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::GoalColour;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::team::RobotId;

/// How the vision looked for an object.
struct Search<'a> {
    class: &'a ClassNoise,
    /// The place of the object, m, robot frame.
    place: Vec2,
    target: Target,
    /// Whether the object is certainly beside the images.
    is_beside: bool,
    /// The number of its visible points, if they are enough for a detection.
    visible: Option<usize>,
    /// The number of visible points that a detection needs, and the number of points.
    counts: (usize, usize),
    miss: Miss,
}

impl Observer<'_> {
    /// The ball with this index, which has no percept.
    pub(super) fn missed_ball(&self, scene: &Scene, index: usize, ball: &SceneBall, miss: Miss) -> MissedObject {
        let place = self.in_robot_frame(ball.position);
        let target = self.judge(Target::Other, place, ball.radius);
        let camera = self.ball_camera(ball, place, target);
        let search = Search {
            class: &self.noise.ball,
            place,
            target,
            is_beside: self.side_of(place) != ViewSide::Inside,
            visible: camera.map(|camera| self.visible_points_of_ball(camera, ball, place, target)),
            counts: (BALL_POINTS_NEEDED, BALL_OFFSETS.len()),
            miss,
        };
        let why = self.why(scene, &search, |view| ball_points(view, ball, place));
        MissedObject { object: SceneObject::Ball(index), why }
    }

    /// The goal post with this index, which has no percept.
    pub(super) fn missed_post(&self, scene: &Scene, index: usize, miss: Miss) -> MissedObject {
        let post = &scene.posts[index];
        let place = self.in_robot_frame(post.position);
        let height = post.post.height;
        let target = self.judge(Target::Post(index), place, 0.0);
        let cue = self.post_cue(place, height, target);
        let search = Search {
            class: &self.noise.goal_posts,
            place,
            target,
            is_beside: self.is_post_beside(place, height),
            visible: cue.map(|(camera, _)| self.visible_points_of_post(camera, place, height, target).max(1)),
            counts: (POST_POINTS_NEEDED, POST_HEIGHTS.len()),
            miss,
        };
        let why = self.why(scene, &search, |_| POST_HEIGHTS.map(|share| place.extend(share * height)));
        let colour = post.post.colour.unwrap_or(GoalColour::White);
        MissedObject { object: SceneObject::GoalPost { position_m: post.position, colour }, why }
    }

    /// The robot with this index, which has no percept.
    pub(super) fn missed_robot(&self, scene: &Scene, index: usize, miss: Miss) -> MissedObject {
        let robot = &scene.robots[index];
        let band = &robot.body.waistband;
        let place = self.in_robot_frame(robot.pose.position);
        let target = self.judge(Target::Robot(index), place, radius_of(band));
        let cue = self.waistband_cue(place, band, target);
        let search = Search {
            class: &self.noise.robots,
            place,
            target,
            is_beside: self.side_of(place) != ViewSide::Inside,
            visible: cue.map(|(camera, _)| self.visible_points_of_waistband(camera, place, band, target)),
            counts: (WAISTBAND_POINTS_NEEDED, WAISTBAND_POINTS),
            miss,
        };
        let points = |view: &CameraView| -> [Vec3; WAISTBAND_POINTS] {
            let rows = waistband(view, place, band);
            core::array::from_fn(|index| rows[index / 3][index % 3])
        };
        MissedObject { object: SceneObject::Robot(robot.id), why: self.why(scene, &search, points) }
    }

    /// Why an object has no percept. `points` returns its sample points as a camera sees it.
    fn why<const N: usize>(
        &self,
        scene: &Scene,
        search: &Search,
        points: impl Fn(&CameraView) -> [Vec3; N],
    ) -> WhyMissed {
        let Search { class, place, target, visible, counts: (needed, of), .. } = *search;
        let in_image = |camera: usize| {
            let view = &self.actual[camera];
            points(view).into_iter().filter(|point| view.pixel_in_image(*point).is_some())
        };
        let camera = (0..self.actual.len()).max_by_key(|camera| in_image(*camera).count()).unwrap_or(0);
        let count = in_image(camera).count();
        if search.is_beside || (count == 0 && visible.is_none()) {
            return WhyMissed::OutsideImage;
        }
        if class.is_too_far(place) {
            let limit_m = class.max_distance_m.unwrap_or(f32::INFINITY);
            return WhyMissed::TooFar { distance_m: place.length(), limit_m };
        }
        if let Some(visible) = visible {
            return match search.miss {
                Miss::NotMeasured => WhyMissed::NoPosition,
                Miss::NotDetected => {
                    let seems_at_m = seems_at_m(place.length(), visible, of);
                    WhyMissed::Chance { probability: class.detection_probability(seems_at_m) }
                }
            };
        }
        let hiders: Vec<Target> = in_image(camera).filter_map(|point| self.hider(camera, point, target)).collect();
        let most = hiders.iter().copied().max_by_key(|one| hiders.iter().filter(|other| *other == one).count());
        let by = match most {
            _ if count < needed => return WhyMissed::PartlyOutside,
            Some(Target::Robot(index)) => Cover::Robot(scene.robots[index].id),
            Some(Target::Post(_)) => Cover::Post,
            Some(Target::Other | Target::Unobstructed) | None => return WhyMissed::PartlyOutside,
        };
        WhyMissed::Covered { by, share: hiders.len() as f32 / count as f32 }
    }
}

/// Notes which objects are outside the images, and which are in them, of robots whose vision is by images. Objects that others may hide are
/// left out, because what is drawn differs a little from the boxes of the bodies.
pub(super) fn look_at_images(
    scene: Res<Scene>,
    clock: Res<CycleClock>,
    mut unrecognised: ResMut<Unrecognised>,
    mut occluders: Local<Occluders>,
    robots: Query<(
        (&RobotId, &Pose),
        (&HeadAngles, &GazeError, &Body),
        (&CameraSettings, &VisionSettings),
        &CameraImages,
        &Percepts,
    )>,
) {
    for ((id, pose), (head, gaze, body), (cameras, settings), images, percepts) in &robots {
        let missed = match settings.source {
            VisionSource::Geometric => continue,
            VisionSource::Truth => Vec::new(),
            VisionSource::Image if images.cycle != Some(clock.cycle) => continue,
            VisionSource::Image => {
                let own_index = scene.robots.iter().position(|robot| robot.id == *id);
                let all = cameras.views(body, gaze.actual(*head));
                let views: Vec<CameraView> =
                    all.named().filter(|(name, _)| !images.of(*name).is_empty()).map(|(_, view)| *view).collect();
                occluders.gather(&scene, own_index, *pose, &views);
                in_images(&scene, own_index, *pose, &views, &occluders)
            }
        };
        unrecognised.note(*id, clock.start_time_s(), percepts.time_s, missed);
    }
}

/// The objects that are certainly outside all images, and those that are in one with all points by which the geometric vision detects them.
fn in_images(
    scene: &Scene,
    own_index: Option<usize>,
    pose: Pose,
    views: &[CameraView],
    occluders: &Occluders,
) -> Vec<MissedObject> {
    let place_of = |position: Vec2| pose.inverse_transform_point(position);
    let look = |centre: Vec3, radius: f32, target: Target, points: &dyn Fn(&CameraView) -> Vec<Vec3>| {
        if !views.iter().any(|view| view.may_see(centre, radius)) {
            return Some(WhyMissed::OutsideImage);
        }
        let is_seen = |view: &CameraView, point: Vec3| {
            view.pixel_in_image(point).is_some() && !occluders.hide(&view.lens, point.truncate(), point.z, target)
        };
        let sees_all = |view: &CameraView| points(view).into_iter().all(|point| is_seen(view, point));
        views.iter().any(sees_all).then_some(WhyMissed::InImage)
    };
    let balls = scene.balls().enumerate().filter_map(|(index, ball)| {
        let place = place_of(ball.position);
        let centre = place.extend(ball.radius + ball.height);
        let why = look(centre, ball.radius, Target::Other, &|view| ball_points(view, ball, place).to_vec())?;
        Some(MissedObject { object: SceneObject::Ball(index), why })
    });
    let posts = scene.posts.iter().enumerate().filter_map(|(index, post)| {
        let (place, half) = (place_of(post.position), post.post.height / 2.0);
        let points = POST_HEIGHTS.map(|share| place.extend(share * 2.0 * half)).to_vec();
        let radius = Vec2::new(half, post.post.radius).length();
        let why = look(place.extend(half), radius, Target::Post(index), &|_| points.clone())?;
        let object = SceneObject::GoalPost { position_m: post.position, colour: post.post.colour? };
        Some(MissedObject { object, why })
    });
    let robots = scene.robots.iter().enumerate().filter(|(index, _)| Some(*index) != own_index);
    let robots = robots.filter_map(|(index, robot)| {
        let (place, height) = (place_of(robot.pose.position), robot.body.height_m);
        let points = |view: &CameraView| waistband(view, place, &robot.body.waistband).as_flattened().to_vec();
        // A robot that lies or steps aside is within its height of its place.
        let why = look(place.extend(height / 2.0), 1.2 * height, Target::Robot(index), &points)?;
        let is_certain = robot.is_upright() || why == WhyMissed::OutsideImage;
        is_certain.then_some(MissedObject { object: SceneObject::Robot(robot.id), why })
    });
    balls.chain(posts).chain(robots).collect()
}
