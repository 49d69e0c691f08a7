//! What the cameras recognise.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::knowledge::Knowledge;
use crate::pitch::{GoalColour, JunctionShape};
use crate::robot::Team;
use crate::sensing::camera::CameraSide;

/// A ball in an image.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct BallPercept {
    /// The camera that sees it.
    pub camera: CameraSide,
    /// The centre's pixel, [u, v].
    pub pixel: Vec2,
    /// Its estimated place on the ground, m, robot frame.
    pub position_m: Vec2,
}

/// A goal post in an image.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct GoalPostPercept {
    /// The camera that sees it.
    pub camera: CameraSide,
    /// The post's colour.
    pub colour: GoalColour,
    /// The pixel where it stands on the ground, [u, v].
    pub pixel: Vec2,
    /// Its estimated place on the ground, m, robot frame.
    pub position_m: Vec2,
}

/// Another robot in an image, by its waistband.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct RobotPercept {
    /// The camera that sees it.
    pub camera: CameraSide,
    /// The team, by the colour of the waistband.
    pub team: Team,
    /// The pixel where it stands on the ground, [u, v].
    pub pixel: Vec2,
    /// Its estimated place on the ground, m, robot frame.
    pub position_m: Vec2,
}

/// A line, crossing or mark in an image.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct LandmarkPercept {
    /// The camera that sees it.
    pub camera: CameraSide,
    /// What it is.
    #[serde(flatten)]
    pub kind: LandmarkKind,
    /// Its pixel, [u, v].
    pub pixel: Vec2,
    /// Its estimated place on the ground, m, robot frame.
    pub position_m: Vec2,
}

/// What a landmark on the ground is.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum LandmarkKind {
    /// A stretch of a line; the percept's own place is one end.
    Line {
        /// The other end's pixel, [u, v].
        end_pixel: Vec2,
        /// The other end on the ground, m, robot frame.
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
}

/// What a robot's cameras recognised in this cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
pub struct Percepts {
    /// The ball.
    pub ball: Option<BallPercept>,
    /// Goal posts.
    pub goal_posts: Vec<GoalPostPercept>,
    /// Other robots.
    pub robots: Vec<RobotPercept>,
    /// Lines, crossings and marks.
    pub landmarks: Vec<LandmarkPercept>,
}

/// Where a robot's percepts come from.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VisionSource {
    /// From the geometry of what is in view, with the noise of a real vision system.
    #[default]
    Geometric,
    /// Perfect and unlimited, for debugging: everything on the pitch, wherever the robot looks.
    Truth,
}

/// Errors of the geometric vision.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VisionNoise {}

/// What a robot recognises in its images, and how well.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct VisionSettings {
    /// Where the percepts come from.
    pub source: VisionSource,
    /// Errors of the geometric vision.
    pub noise: VisionNoise,
}
