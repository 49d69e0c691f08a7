//! The percepts: what a robot's vision tells it of the objects in its images.

use bevy::prelude::*;
use core::cmp::Ordering;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use naoisis_core::camera_model::{CameraMounts, CameraName};
use naoisis_core::geometry::{Pose, angle_of, file_units, unrotate, wrap_angle};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::pitch::{GoalColour, JunctionShape};
use naoisis_core::robot::jersey::Jersey;
use naoisis_core::team::Team;

/// A ball in an image.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct BallPercept {
    /// The camera that sees it.
    pub camera: CameraName,
    /// The centre's pixel, [u, v].
    #[schemars(with = "[f32; 2]")]
    pub pixel: Vec2,
    /// Its estimated position on the ground, m, robot frame.
    #[schemars(with = "[f32; 2]")]
    pub position_m: Vec2,
    /// How sure the vision is, from 0 to 1, if it says so.
    #[reflect(default)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f32>,
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
    /// How sure the vision is, from 0 to 1, if it says so.
    #[reflect(default)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f32>,
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
    /// The colour of its jersey, if it wears one.
    #[reflect(default)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colour: Option<Jersey>,
    /// How sure the vision is, from 0 to 1, if it says so.
    #[reflect(default)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f32>,
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
    /// How sure the vision is, from 0 to 1, if it says so.
    #[reflect(default)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f32>,
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
    BallPercept() confidence;
    GoalPostPercept(colour: GoalColour) confidence;
    RobotPercept(team: Team) number heading colour confidence;
    LandmarkPercept(kind: LandmarkKind) confidence;
}

/// A point on the ground in an image.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct GroundPoint {
    /// The camera that sees it.
    pub camera: CameraName,
    /// Its pixel, [u, v].
    #[schemars(with = "[f32; 2]")]
    pub pixel: Vec2,
    /// Its estimated position on the ground, m, robot frame.
    #[schemars(with = "[f32; 2]")]
    pub position_m: Vec2,
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
    /// Points along the lines, if the robot's vision has points.
    #[reflect(default)]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub line_points: Vec<GroundPoint>,
    /// Points along the edge of the carpet, if the robot's vision has points.
    #[reflect(default)]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub border_points: Vec<GroundPoint>,
}

impl Percepts {
    /// All balls: the one, or the several.
    pub fn all_balls(&self) -> impl Iterator<Item = &BallPercept> {
        self.ball.iter().filter(|_| self.balls.is_empty()).chain(&self.balls)
    }

    /// Fills in the balls that it sees.
    pub(super) fn set_balls(&mut self, seen: impl Iterator<Item = BallPercept>) {
        self.balls.extend(seen);
        self.balls.sort_by(|a, b| a.position_m.length_squared().total_cmp(&b.position_m.length_squared()));
        self.ball = self.balls.first().copied();
        if self.balls.len() == 1 {
            self.balls.clear();
        }
    }

    /// Removes all percepts, and keeps the memory.
    pub fn clear(&mut self) {
        let Percepts { time_s: _, ball, balls, goal_posts, robots, landmarks, line_points, border_points } = self;
        *ball = None;
        balls.clear();
        goal_posts.clear();
        robots.clear();
        landmarks.clear();
        line_points.clear();
        border_points.clear();
    }

    /// Whether every number in the percepts is finite.
    pub fn is_finite(&self) -> bool {
        let Percepts { time_s, ball, balls, goal_posts, robots, landmarks, line_points, border_points } = self;
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
            && line_points.iter().chain(border_points).all(|point| is_finite(point.pixel, point.position_m))
    }

    /// Copies `other`, reusing the memory.
    pub fn copy_from(&mut self, other: &Percepts) {
        let Percepts { time_s, ball, balls, goal_posts, robots, landmarks, line_points, border_points } = self;
        (*time_s, *ball) = (other.time_s, other.ball);
        balls.clone_from(&other.balls);
        goal_posts.clone_from(&other.goal_posts);
        robots.clone_from(&other.robots);
        landmarks.clone_from(&other.landmarks);
        line_points.clone_from(&other.line_points);
        border_points.clone_from(&other.border_points);
    }

    /// Transforms the positions into another robot frame, whose pose in the current one is `now`.
    pub fn move_to(&mut self, now: Pose) {
        let Percepts { time_s: _, ball, balls, goal_posts, robots, landmarks, line_points, border_points } = self;
        let forward = now.forward();
        let shift = |place: &mut Vec2| *place = unrotate(forward, *place - now.position);
        ball.iter_mut().chain(balls).for_each(|seen| shift(&mut seen.position_m));
        goal_posts.iter_mut().for_each(|seen| shift(&mut seen.position_m));
        line_points.iter_mut().chain(border_points).for_each(|point| shift(&mut point.position_m));
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
    pub(super) fn sort(&mut self, mounts: &CameraMounts) {
        let order = |a: (CameraName, Vec2), b: (CameraName, Vec2)| {
            let cameras = if a.0 == b.0 { Ordering::Equal } else { mounts.order(a.0).cmp(&mounts.order(b.0)) };
            cameras.then(a.1.x.total_cmp(&b.1.x)).then(a.1.y.total_cmp(&b.1.y))
        };
        self.goal_posts.sort_unstable_by(|a, b| order((a.camera, a.pixel), (b.camera, b.pixel)));
        self.robots.sort_unstable_by(|a, b| order((a.camera, a.pixel), (b.camera, b.pixel)));
        self.landmarks.sort_unstable_by(|a, b| order((a.camera, a.pixel), (b.camera, b.pixel)));
    }
}
