//! Vision: the objects that the cameras detect.
//!
//! **What it measures.** [`Percepts`]: the ball, goal posts with their colour, robots with their team by the waistband, line segments, line
//! junctions (L, T, X), penalty crosses, the centre circle and corner arcs. Each has the pixel in the camera's image, and the position on
//! the ground that follows from that pixel and the measured head angles. No image is rendered: which objects are in view follows from the
//! [camera model](naoisis_core::camera_model), and from the robots' boxes and the posts, which hide other objects.
//!
//! | class | detected when | measured at |
//! |---|---|---|
//! | ball | 3 of 5 points of its disc (centre, left, right, above, below) are visible | its centre, a ball's radius above the ground |
//! | goal post | 2 of 5 points of its axis are visible | its foot; if that is not visible, its top; otherwise by its width in the image |
//! | robot | 3 of 9 points of its waistband (25 to 35 cm high) are visible | its foot; otherwise the highest visible row of its waistband |
//! | line | a segment of at least 10 pixels is in the image, and 2 of 3 points of it are visible | both ends of the segment |
//! | junction, cross | it is visible | itself |
//! | centre circle, corner arc | 3 of 8 points of it are visible, of an arc 3 of 5 | its centre, in the image or not; the corner |
//!
//! A visible point is in the image, and no robot or post is in front of it. An object that two cameras see is one percept, from the camera
//! that sees its foot, or otherwise has it nearer to the middle of the image; of a line, each camera reports its own segment. Percepts are
//! ordered from left to right in the image, so that their order carries no other information. Of several balls the nearest is the ball.
//!
//! **Units and rate.** Pixels and metres, the robot frame; once a cycle, both cameras.
//!
//! **Noise** is added in the image ([`VisionNoise`]): an error of the pixel, misses, false detections and a greatest distance for each
//! class, and an error of the head angles. So the error of a position grows with the square of its distance, as on a real robot. The preset
//! `default` has the figures of B-Human's simulator for its own vision, in which the errors of successive images are independent.
//!
//! The errors of a real vision last longer than an image, and so do those of `realistic` robots: the [`gaze`] has a drift that lasts for
//! about a step, greater while walking, and a bias for a whole match ([`GazeNoise`]); objects that are far away or partly hidden are
//! detected less often, without a greatest distance ([`Falloff`]); a line junction looks like a ball for seconds, from any direction
//! ([`FalsePositives`]); and the distance to a robot whose feet are hidden is too great ([`HiddenFeet`]).
//!
//! **By images** ([`VisionSource::Image`]), everything is detected in the [rendered images](crate::sensing::camera) alone: see [`image`].
//! The noise is then that of the images. A program's own vision processes the images in [`SensingSystems::Custom`], and fills the percepts
//! itself.
//!
//! **Truth** ([`VisionSource::Truth`]) is for debugging: all objects on the pitch at their true positions, in view or not.
//!
//! **The real NAO** in 2011 segmented colours in 160 x 120 or 320 x 240 images at 15 to 30 images per second, knew the pose of its camera to
//! about a degree, and detected a ball at up to 3 m, and goals across the pitch.

use bevy::prelude::*;
use core::cmp::Ordering;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::appearance::scene::Scene;
use crate::sensing::camera::CameraSettings;
use crate::sensing::jobs::SensingThreads;
use crate::sensing::scene::{ScenePlugin, SensingSystems};
use naoisis_core::camera_model::{CameraMounts, CameraName};
use naoisis_core::cycle::{Cycle, CycleClock};
use naoisis_core::geometry::{Pose, angle_of, file_units, unrotate, wrap_angle};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::pitch::{GoalColour, JunctionShape};
use naoisis_core::random::RandomStreams;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::motion::ExecutedStep;
use naoisis_core::team::{RobotId, Team};

mod ahead;
mod false_positives;
pub mod gaze;
mod geometric;
pub mod image;
mod landmarks;
mod measuring;
mod noise;
mod observer;
mod occlusion;
mod robots;
mod truth;

use ahead::LandmarksAhead;
use false_positives::ActiveFalsePositives;
use gaze::GazeError;
pub(crate) use noise::GazeDecay;
pub use noise::{ClassNoise, Falloff, FalsePositives, GazeNoise, HiddenFeet, JerseyVision, VisionNoise};
use observer::{Observer, Views};
use occlusion::Occluders;

/// Fills every robot's [`Percepts`].
pub struct VisionPlugin;

impl Plugin for VisionPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<ScenePlugin>() {
            app.add_plugins(ScenePlugin);
        }
        app.register_type::<VisionSettings>()
            .register_type::<Percepts>()
            .register_type::<GazeError>()
            .register_type::<ActiveFalsePositives>()
            .init_resource::<SensingThreads>()
            .add_systems(Cycle, gaze::move_cameras.in_set(SensingSystems::Scene))
            .add_systems(Cycle, (recognise, image::seeing::process_images).chain().in_set(SensingSystems::Vision));
    }
}

/// A ball in an image.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
pub struct BallPercept {
    /// The camera that sees it.
    pub camera: CameraName,
    /// The centre's pixel, [u, v].
    #[schemars(with = "[f32; 2]")]
    pub pixel: Vec2,
    /// Its estimated position on the ground, m, robot frame.
    #[schemars(with = "[f32; 2]")]
    pub position_m: Vec2,
}

/// A goal post in an image.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct GoalPostPercept {
    /// The camera that sees it.
    pub camera: CameraName,
    /// The post's colour.
    pub colour: GoalColour,
    /// The pixel of its foot, [u, v].
    #[schemars(with = "[f32; 2]")]
    pub pixel: Vec2,
    /// Its estimated position on the ground, m, robot frame.
    #[schemars(with = "[f32; 2]")]
    pub position_m: Vec2,
}

/// Another robot in an image, by its waistband.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct RobotPercept {
    /// The camera that sees it.
    pub camera: CameraName,
    /// The team, by the colour of the waistband.
    pub team: Team,
    /// The pixel of its foot, [u, v].
    #[schemars(with = "[f32; 2]")]
    pub pixel: Vec2,
    /// Its estimated position on the ground, m, robot frame.
    #[schemars(with = "[f32; 2]")]
    pub position_m: Vec2,
    /// The number on its jersey, if it could be read.
    #[reflect(default)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<u8>,
    /// The direction in which it faces, deg, robot frame, if it was recognised.
    #[reflect(default)]
    #[serde(
        rename = "heading_deg",
        default,
        with = "file_units::optional_degrees",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(with = "Option<f32>")]
    pub heading: Option<f32>,
}

/// A marking in an image.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct LandmarkPercept {
    /// The camera that sees it.
    pub camera: CameraName,
    /// The kind of the marking.
    #[serde(flatten)]
    pub kind: LandmarkKind,
    /// Its pixel, [u, v].
    #[schemars(with = "[f32; 2]")]
    pub pixel: Vec2,
    /// Its estimated position on the ground, m, robot frame.
    #[schemars(with = "[f32; 2]")]
    pub position_m: Vec2,
}

macro_rules! percepts {
    ($($percept:ident($($what:ident: $type:ty)?) $($unknown:ident)*;)*) => {
        $(impl $percept {
            /// A percept of this camera, at this pixel, [u, v], and at this position on the ground, m, robot frame.
            pub const fn new(camera: CameraName, $($what: $type,)? pixel: Vec2, position_m: Vec2) -> Self {
                Self { camera, $($what,)? pixel, position_m, $($unknown: None,)* }
            }

            /// The direction of its estimated position, radians, robot frame: counter-clockwise from straight ahead.
            pub fn bearing(&self) -> f32 {
                angle_of(self.position_m)
            }
        })*
    };
}

percepts! {
    BallPercept();
    GoalPostPercept(colour: GoalColour);
    RobotPercept(team: Team) number heading;
    LandmarkPercept(kind: LandmarkKind);
}

/// The kind of a landmark on the ground.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum LandmarkKind {
    /// A line segment; the percept's own position is one end.
    Line {
        /// The other end's pixel, [u, v].
        #[schemars(with = "[f32; 2]")]
        end_pixel: Vec2,
        /// The other end on the ground, m, robot frame.
        #[schemars(with = "[f32; 2]")]
        end_position_m: Vec2,
    },
    /// A line junction.
    Junction {
        /// Its shape.
        shape: JunctionShape,
    },
    /// A penalty cross.
    PenaltyCross,
    /// The centre of the centre circle.
    CentreCircle,
    /// A corner arc, by the corner.
    CornerArc,
}

/// The objects that a robot's cameras detected in this cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Sensor)]
#[non_exhaustive]
pub struct Percepts {
    /// The time of the exposure of the images, s since the start of the match.
    #[serde(default)]
    pub time_s: f64,
    /// The ball; of several, the nearest.
    pub ball: Option<BallPercept>,
    /// All balls, the nearest first, if it sees more than one.
    #[reflect(default)]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub balls: Vec<BallPercept>,
    /// Goal posts.
    pub goal_posts: Vec<GoalPostPercept>,
    /// Other robots.
    pub robots: Vec<RobotPercept>,
    /// Lines, junctions and marks.
    pub landmarks: Vec<LandmarkPercept>,
}

impl Percepts {
    /// All balls: the one, or the several.
    pub fn all_balls(&self) -> impl Iterator<Item = &BallPercept> {
        self.ball.iter().filter(|_| self.balls.is_empty()).chain(&self.balls)
    }

    /// Fills in the balls that it sees.
    fn set_balls(&mut self, seen: impl Iterator<Item = BallPercept>) {
        self.balls.extend(seen);
        self.balls.sort_by(|a, b| a.position_m.length_squared().total_cmp(&b.position_m.length_squared()));
        self.ball = self.balls.first().copied();
        if self.balls.len() == 1 {
            self.balls.clear();
        }
    }

    /// Removes all percepts, and keeps the memory.
    pub fn clear(&mut self) {
        let Percepts { time_s: _, ball, balls, goal_posts, robots, landmarks } = self;
        *ball = None;
        balls.clear();
        goal_posts.clear();
        robots.clear();
        landmarks.clear();
    }

    /// Whether every number in the percepts is finite.
    pub fn is_finite(&self) -> bool {
        let Percepts { time_s, ball, balls, goal_posts, robots, landmarks } = self;
        let is_finite = |pixel: Vec2, place: Vec2| pixel.is_finite() && place.is_finite();
        let is_kind_finite = |kind: &LandmarkKind| match *kind {
            LandmarkKind::Line { end_pixel, end_position_m } => is_finite(end_pixel, end_position_m),
            LandmarkKind::Junction { .. }
            | LandmarkKind::PenaltyCross
            | LandmarkKind::CentreCircle
            | LandmarkKind::CornerArc => true,
        };
        time_s.is_finite()
            && ball.iter().chain(balls).all(|seen| is_finite(seen.pixel, seen.position_m))
            && goal_posts.iter().all(|seen| is_finite(seen.pixel, seen.position_m))
            && robots
                .iter()
                .all(|seen| is_finite(seen.pixel, seen.position_m) && seen.heading.is_none_or(f32::is_finite))
            && landmarks.iter().all(|seen| is_finite(seen.pixel, seen.position_m) && is_kind_finite(&seen.kind))
    }

    /// Copies `other`, reusing the memory.
    pub fn copy_from(&mut self, other: &Percepts) {
        let Percepts { time_s, ball, balls, goal_posts, robots, landmarks } = self;
        (*time_s, *ball) = (other.time_s, other.ball);
        balls.clone_from(&other.balls);
        goal_posts.clone_from(&other.goal_posts);
        robots.clone_from(&other.robots);
        landmarks.clone_from(&other.landmarks);
    }

    /// Transforms the positions into another robot frame, whose pose in the current one is `now`.
    pub fn move_to(&mut self, now: Pose) {
        let Percepts { time_s: _, ball, balls, goal_posts, robots, landmarks } = self;
        let forward = now.forward();
        let shift = |place: &mut Vec2| *place = unrotate(forward, *place - now.position);
        ball.iter_mut().chain(balls).for_each(|seen| shift(&mut seen.position_m));
        goal_posts.iter_mut().for_each(|seen| shift(&mut seen.position_m));
        for seen in robots {
            shift(&mut seen.position_m);
            seen.heading = seen.heading.map(|heading| wrap_angle(heading - now.heading));
        }
        for seen in landmarks {
            shift(&mut seen.position_m);
            match &mut seen.kind {
                LandmarkKind::Line { end_position_m, .. } => shift(end_position_m),
                LandmarkKind::Junction { .. }
                | LandmarkKind::PenaltyCross
                | LandmarkKind::CentreCircle
                | LandmarkKind::CornerArc => {}
            }
        }
    }

    /// Sorts the percepts by camera, and from left to right in the image.
    fn sort(&mut self, mounts: &CameraMounts) {
        let order = |a: (CameraName, Vec2), b: (CameraName, Vec2)| {
            let cameras = if a.0 == b.0 { Ordering::Equal } else { mounts.order(a.0).cmp(&mounts.order(b.0)) };
            cameras.then(a.1.x.total_cmp(&b.1.x)).then(a.1.y.total_cmp(&b.1.y))
        };
        self.goal_posts.sort_unstable_by(|a, b| order((a.camera, a.pixel), (b.camera, b.pixel)));
        self.robots.sort_unstable_by(|a, b| order((a.camera, a.pixel), (b.camera, b.pixel)));
        self.landmarks.sort_unstable_by(|a, b| order((a.camera, a.pixel), (b.camera, b.pixel)));
    }
}

/// The source of a robot's percepts.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum VisionSource {
    /// The geometry of the objects in view, with the noise of a real vision system.
    #[default]
    Geometric,
    /// The robot's camera images alone.
    Image,
    /// All objects on the pitch at their true positions, for debugging.
    Truth,
}

/// The vision of a robot.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[require(Percepts, CameraSettings, GazeError, ActiveFalsePositives, ExecutedStep)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct VisionSettings {
    /// The source of the percepts.
    pub source: VisionSource,
    /// Errors of the geometric vision.
    pub noise: VisionNoise,
}

fn recognise(
    scene: Res<Scene>,
    clock: Res<CycleClock>,
    (mut occluders, mut views, mut ahead): (Local<Occluders>, Local<Views>, Local<LandmarksAhead>),
    mut robots: Query<(
        &RobotId,
        &Pose,
        (&HeadAngles, &GazeError, &Body),
        &CameraSettings,
        &VisionSettings,
        &mut ActiveFalsePositives,
        &mut Percepts,
        &mut RandomStreams,
    )>,
) {
    for (&id, &pose, (&head, gaze, body), cameras, settings, mut false_positives, mut percepts, mut streams) in
        &mut robots
    {
        percepts.clear();
        let RandomStreams { vision, recognition, false_places, .. } = &mut *streams;
        let own_index = scene.robots.iter().position(|robot| robot.id == id);
        match settings.source {
            VisionSource::Truth => {
                truth::know_everything(&mut percepts, &scene, own_index, pose, (cameras, body), head);
            }
            // These images are processed by the next system.
            VisionSource::Image => {}
            VisionSource::Geometric => {
                views.update((cameras, body), (head, gaze), &settings.noise, vision);
                occluders.gather(&scene, own_index, pose, views.actual());
                let streams = [vision, recognition];
                let mut observer = Observer::new(&views, pose, &settings.noise, &occluders, streams);
                observer.recognise_everything(&mut percepts, &scene, own_index, &mut ahead);
                false_positives.bypass_change_detection().advance(
                    &settings.noise,
                    &scene,
                    clock.period(),
                    false_places,
                );
                false_positives.see(&mut observer.with_stream(false_places), &mut percepts, &scene);
            }
        }
        percepts.sort(&cameras.mounts);
    }
}

#[cfg(test)]
mod tests;
