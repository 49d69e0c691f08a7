//! What the cameras recognise.
//!
//! **What it measures.** [`Percepts`]: the ball, goal posts with their colour, robots with their team by the waistband,
//! stretches of line, line junctions (L, T, X), penalty crosses, the centre circle and corner arcs. Of each, the pixel in the
//! camera's image, and the place on the ground that follows from that pixel and from where the robot, by its measured
//! head angles, thinks that its camera looks. No image is rendered for it: what is in view follows from the
//! [camera model](naoisis_core::camera_model), and from what hides it, robots' boxes and posts.
//!
//! | class | counts as seen when | measured at |
//! |---|---|---|
//! | ball | 3 of 5 points of its disc (centre, left, right, above, below) are visible | its centre, a ball's radius above the ground |
//! | goal post | 2 of 5 points of its axis are visible | its foot; if that is not visible its top; else by its apparent width |
//! | robot | 3 of 9 points of its waistband (25 to 35 cm high) are visible | its foot; else its waistband, at the height of which something is visible |
//! | line | a stretch of at least 10 pixels is in the image, and 2 of 3 points of it are visible | both ends of the stretch |
//! | junction, cross | it is visible | itself |
//! | centre circle, corner arc | 3 of 8 points of it are visible, of an arc 3 of 5 | its centre, wherever that is; the corner |
//!
//! A visible point is in the image, and no robot or post is in front of it. A thing that both cameras see is one
//! percept, from the camera which sees its foot, or else nearer to the middle of the image; of a line each camera
//! reports its own stretch. Percepts come in the order of the image from left to right, so that their order tells
//! nothing more.
//!
//! **Units and rate.** Pixels and metres, the robot frame; once a cycle, both cameras.
//!
//! **Noise** lives in the image ([`VisionNoise`]): the pixel's spread, misses, false detections and a greatest distance
//! for each class, and an error of the head angles, which puts the cameras elsewhere than the robot thinks. So the
//! error of a place grows with the square of its distance, as it does on the robot. The preset `default` has the
//! figures of B-Human's simulator of its own vision: in it, one image knows nothing of the one before.
//!
//! A real vision errs for longer than an image, and so do robots that are `realistic`: the [`gaze`] errs alike for a step, the more
//! while walking, and by a bias for a whole match ([`GazeNoise`]); what is far or half hidden is recognised less often, without a
//! distance at which all ends ([`Falloff`]); a crossing of lines looks like a ball for seconds, from wherever the robot
//! looks at it ([`FalsePlaces`]); and a robot whose feet are hidden seems further away ([`HiddenFeet`]).
//!
//! **By images** ([`VisionSource::Image`]), everything is recognised in the [rendered images](crate::sensing::camera)
//! alone: see [`image`]. The noise is then that of the images. A vision of a program's own works on the images in
//! [`SensingSystems::Custom`], and fills the percepts in its place.
//!
//! **Truth** ([`VisionSource::Truth`]) is for debugging: everything on the pitch in its true place, wherever the robot
//! looks and whatever is in the way.
//!
//! **The real NAO** in 2011 found colours in 160 x 120 or 320 x 240 images at 15 to 30 images per second, knew its camera's
//! pose to about a degree, and saw a ball at up to 3 m, goals across the pitch.

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
use naoisis_core::geometry::{Pose, angle_of, unrotate};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::pitch::{GoalColour, JunctionShape};
use naoisis_core::random::RandomStreams;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::motion::ExecutedStep;
use naoisis_core::team::{RobotId, Team};

mod ahead;
mod false_places;
pub mod gaze;
mod geometric;
pub mod image;
mod landmarks;
mod noise;
mod occlusion;
mod robots;
mod truth;

use ahead::LandmarksAhead;
pub use false_places::MistakenPlaces;
use gaze::GazeError;
use geometric::{Observer, Views};
pub use noise::{ClassNoise, Falloff, FalsePlaces, GazeDecay, GazeNoise, HiddenFeet, VisionNoise};
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
            .register_type::<MistakenPlaces>()
            .init_resource::<SensingThreads>()
            .add_systems(Cycle, gaze::move_cameras.in_set(SensingSystems::Scene))
            .add_systems(Cycle, (recognise, image::seeing::look_through_images).chain().in_set(SensingSystems::Vision));
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
    /// Its estimated place on the ground, m, robot frame.
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
    /// The pixel where it stands on the ground, [u, v].
    #[schemars(with = "[f32; 2]")]
    pub pixel: Vec2,
    /// Its estimated place on the ground, m, robot frame.
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
    /// The pixel where it stands on the ground, [u, v].
    #[schemars(with = "[f32; 2]")]
    pub pixel: Vec2,
    /// Its estimated place on the ground, m, robot frame.
    #[schemars(with = "[f32; 2]")]
    pub position_m: Vec2,
}

/// A line, crossing or mark in an image.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct LandmarkPercept {
    /// The camera that sees it.
    pub camera: CameraName,
    /// What it is.
    #[serde(flatten)]
    pub kind: LandmarkKind,
    /// Its pixel, [u, v].
    #[schemars(with = "[f32; 2]")]
    pub pixel: Vec2,
    /// Its estimated place on the ground, m, robot frame.
    #[schemars(with = "[f32; 2]")]
    pub position_m: Vec2,
}

macro_rules! percepts {
    ($($percept:ident($($what:ident: $type:ty)?))*) => {
        $(impl $percept {
            /// A percept of this camera, at this pixel, [u, v], and at this place on the ground, m, robot frame.
            pub const fn new(camera: CameraName, $($what: $type,)? pixel: Vec2, position_m: Vec2) -> Self {
                Self { camera, $($what,)? pixel, position_m }
            }

            /// The direction of its estimated place, radians, robot frame: counter-clockwise from straight ahead.
            pub fn bearing(&self) -> f32 {
                angle_of(self.position_m)
            }
        })*
    };
}

percepts! {
    BallPercept()
    GoalPostPercept(colour: GoalColour)
    RobotPercept(team: Team)
    LandmarkPercept(kind: LandmarkKind)
}

/// What a landmark on the ground is.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum LandmarkKind {
    /// A stretch of a line; the percept's own place is one end.
    Line {
        /// The other end's pixel, [u, v].
        #[schemars(with = "[f32; 2]")]
        end_pixel: Vec2,
        /// The other end on the ground, m, robot frame.
        #[schemars(with = "[f32; 2]")]
        end_position_m: Vec2,
    },
    /// A place where lines meet.
    Junction {
        /// In which shape.
        shape: JunctionShape,
    },
    /// A penalty cross.
    PenaltyCross,
    /// The centre of the centre circle.
    CentreCircle,
    /// The corner about which an arc is painted.
    CornerArc,
}

/// What a robot's cameras recognised in this cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Sensor)]
#[non_exhaustive]
pub struct Percepts {
    /// When it was seen: the exposure of the images, s since the start of the match.
    #[serde(default)]
    pub time_s: f64,
    /// The ball.
    pub ball: Option<BallPercept>,
    /// Goal posts.
    pub goal_posts: Vec<GoalPostPercept>,
    /// Other robots.
    pub robots: Vec<RobotPercept>,
    /// Lines, crossings and marks.
    pub landmarks: Vec<LandmarkPercept>,
}

impl Percepts {
    /// Forgets everything, and keeps the memory.
    pub fn clear(&mut self) {
        let Percepts { time_s: _, ball, goal_posts, robots, landmarks } = self;
        *ball = None;
        goal_posts.clear();
        robots.clear();
        landmarks.clear();
    }

    /// Whether every number in them is finite.
    pub fn is_finite(&self) -> bool {
        let Percepts { time_s, ball, goal_posts, robots, landmarks } = self;
        let is_finite = |pixel: Vec2, place: Vec2| pixel.is_finite() && place.is_finite();
        let is_kind_finite = |kind: &LandmarkKind| match *kind {
            LandmarkKind::Line { end_pixel, end_position_m } => is_finite(end_pixel, end_position_m),
            LandmarkKind::Junction { .. }
            | LandmarkKind::PenaltyCross
            | LandmarkKind::CentreCircle
            | LandmarkKind::CornerArc => true,
        };
        time_s.is_finite()
            && ball.is_none_or(|seen| is_finite(seen.pixel, seen.position_m))
            && goal_posts.iter().all(|seen| is_finite(seen.pixel, seen.position_m))
            && robots.iter().all(|seen| is_finite(seen.pixel, seen.position_m))
            && landmarks.iter().all(|seen| is_finite(seen.pixel, seen.position_m) && is_kind_finite(&seen.kind))
    }

    /// Takes over what others are, and keeps the memory.
    pub fn copy_from(&mut self, other: &Percepts) {
        let Percepts { time_s, ball, goal_posts, robots, landmarks } = self;
        (*time_s, *ball) = (other.time_s, other.ball);
        goal_posts.clone_from(&other.goal_posts);
        robots.clone_from(&other.robots);
        landmarks.clone_from(&other.landmarks);
    }

    /// The same things in the frame in which the robot is now, if `now` is that in the frame in which it saw them.
    pub fn move_to(&mut self, now: Pose) {
        let Percepts { time_s: _, ball, goal_posts, robots, landmarks } = self;
        let forward = now.forward();
        let shift = |place: &mut Vec2| *place = unrotate(forward, *place - now.position);
        ball.iter_mut().for_each(|seen| shift(&mut seen.position_m));
        goal_posts.iter_mut().for_each(|seen| shift(&mut seen.position_m));
        robots.iter_mut().for_each(|seen| shift(&mut seen.position_m));
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

    /// Puts everything in the order of the images: camera by camera, from left to right.
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

/// Where a robot's percepts come from.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum VisionSource {
    /// From the geometry of what is in view, with the noise of a real vision system.
    #[default]
    Geometric,
    /// From the robot's camera images alone.
    Image,
    /// Perfect and unlimited, for debugging: everything on the pitch, wherever the robot looks.
    Truth,
}

/// What a robot recognises in its images, and how well.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[require(Percepts, CameraSettings, GazeError, MistakenPlaces, ExecutedStep)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct VisionSettings {
    /// Where the percepts come from.
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
        (&HeadAngles, &GazeError),
        &CameraSettings,
        &VisionSettings,
        &mut MistakenPlaces,
        &mut Percepts,
        &mut RandomStreams,
    )>,
) {
    for (&id, &pose, (&head, gaze), camera, settings, mut mistaken, mut percepts, mut streams) in &mut robots {
        percepts.clear();
        let RandomStreams { vision, recognition, false_places, .. } = &mut *streams;
        let own_index = scene.robots.iter().position(|robot| robot.id == id);
        match settings.source {
            VisionSource::Truth => truth::know_everything(&mut percepts, &scene, own_index, pose, camera, head),
            // That comes next.
            VisionSource::Image => {}
            VisionSource::Geometric => {
                views.look(camera, (head, gaze), &settings.noise, vision);
                occluders.gather(&scene, own_index, pose, views.actual());
                let streams = [vision, recognition];
                let mut observer = Observer::new(&views, pose, &settings.noise, &occluders, streams);
                observer.recognise_everything(&mut percepts, &scene, own_index, &mut ahead);
                mistaken.bypass_change_detection().advance(&settings.noise, &scene, clock.period(), false_places);
                mistaken.see(&mut observer.with_stream(false_places), &mut percepts, &scene);
            }
        }
        percepts.sort(&camera.mounts);
    }
}

#[cfg(test)]
mod tests;
