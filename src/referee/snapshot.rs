//! The world as the referee sees it at the end of a cycle: plain data that rules are functions of.

use bevy::prelude::*;

use super::game::Game;
use super::rules::Rules;
use super::touch::Touch;
use crate::cycle::CycleClock;
use crate::geometry::Pose;
use crate::pitch::Pitch;
use crate::robot::body::BodyBounds;
use crate::robot::{RobotId, Velocity};

/// Everything that the rules judge by.
#[derive(Clone, Copy, Debug)]
pub struct MatchSnapshot<'a> {
    /// The clock; the instant is the end of its cycle.
    pub clock: CycleClock,
    /// The pitch.
    pub pitch: &'a Pitch,
    /// The rules.
    pub rules: &'a Rules,
    /// The state of the match.
    pub game: &'a Game,
    /// The ball, if there is one.
    pub ball: Option<BallSnapshot<'a>>,
    /// All robots, ordered by id.
    pub robots: &'a [RobotSnapshot],
    /// Posts, goal posts included.
    pub posts: &'a [Disc],
    /// Who touched the ball last, up to the end of this cycle.
    pub last_touch: Option<Touch>,
}

impl MatchSnapshot<'_> {
    /// The index of a robot.
    pub fn robot_index(&self, id: RobotId) -> Option<usize> {
        self.robots.binary_search_by_key(&id, |robot| robot.id).ok()
    }
}

/// A disc on the ground.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Disc {
    /// Centre, m, pitch frame.
    pub centre: Vec2,
    /// Radius, m.
    pub radius: f32,
}

/// The ball as the referee sees it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BallSnapshot<'a> {
    /// The corners of its way through the cycle, m: the first is its place at the start, the last at the end.
    pub path: &'a [Vec2],
    /// Its place, m, pitch frame.
    pub position: Vec2,
    /// Its velocity, m/s, pitch frame.
    pub velocity: Vec2,
    /// Radius, m.
    pub radius: f32,
}

/// A robot as the referee sees it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RobotSnapshot {
    /// Who.
    pub id: RobotId,
    /// Where.
    pub pose: Pose,
    /// How fast it moved in this cycle.
    pub velocity: Velocity,
    /// Its body.
    pub bounds: BodyBounds,
    /// Whether it serves a penalty.
    pub penalised: bool,
}
