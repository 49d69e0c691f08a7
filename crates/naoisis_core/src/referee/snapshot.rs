//! The match at the end of a cycle as plain data, the input of the rules.

use bevy::prelude::*;
use std::borrow::Cow;

use super::touch::Touch;
use crate::cycle::CycleClock;
use crate::game::{Evidence, Game, Intervention, OutsideReferee, Penalty, RobotEvidence, Rules};
use crate::geometry::Pose;
use crate::pitch::Pitch;
use crate::robot::body::Body;
use crate::robot::head::HeadAngles;
use crate::robot::posture::Posture;
use crate::team::{PerTeam, RobotId};

/// The state of the match at the end of a cycle, which the rules judge.
#[derive(Clone, Copy, Debug)]
pub struct MatchSnapshot<'a> {
    /// The clock; the instant is the end of its cycle.
    pub clock: CycleClock,
    /// Lines, goals and posts.
    pub pitch: &'a Pitch,
    /// The rules of the match.
    pub rules: &'a Rules,
    /// The state of the match.
    pub game: &'a Game,
    /// The ball, if there is one.
    pub ball: Option<BallSnapshot<'a>>,
    /// All robots, ordered by id.
    pub robots: &'a [RobotSnapshot],
    /// Posts, including goal posts.
    pub posts: &'a [Disc],
    /// The touches of the ball in this cycle, in their order: the robot, and whether it was a kick.
    pub touches: &'a [(RobotId, bool)],
    /// The last touch of the ball before this cycle; while the referee judges, including this cycle.
    pub last_touch: Option<Touch>,
    /// Messages that each team has sent in the match, including this cycle.
    pub messages_sent: PerTeam<u32>,
    /// The interventions at the end of this cycle.
    pub interventions: &'a [Intervention],
    /// The referee outside the match that makes the decisions instead, if any.
    pub outside: Option<&'a OutsideReferee>,
    /// Robots that touched each other in this cycle, by their indices.
    pub contacts: &'a [[usize; 2]],
}

impl MatchSnapshot<'_> {
    /// `cycles` in seconds.
    pub fn seconds(&self, cycles: u64) -> f32 {
        (cycles as f64 * self.clock.period_s) as f32
    }

    /// `seconds` in cycles.
    pub fn cycles(&self, seconds: f32) -> u64 {
        u64::from(self.clock.cycles_in(seconds))
    }

    /// Evidence of an event at `position_m`, with the position of the ball.
    pub fn evidence(&self, rule: &'static str, position_m: Vec2) -> Evidence {
        let ball_m = self.ball.map(|ball| ball.position);
        Evidence { rule: Cow::Borrowed(rule), position_m, ball_m, ..Evidence::default() }
    }

    /// Evidence against one robot, at its position.
    pub fn evidence_against(&self, rule: &'static str, robot: &RobotSnapshot) -> Evidence {
        self.evidence(rule, robot.pose.position).with_robot(robot.evidence())
    }

    /// The index of a robot in [`MatchSnapshot::robots`].
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
    /// The vertices of its path in the cycle, m: the first is its position at the start, the last at the end.
    pub path: &'a [Vec2],
    /// The heights at these vertices, m above a ball on the ground; empty if the ball was on the ground during the whole cycle.
    pub heights_m: &'a [f32],
    /// Its position, m, pitch frame.
    pub position: Vec2,
    /// Its velocity, m/s, pitch frame.
    pub velocity: Vec2,
    /// Radius, m.
    pub radius: f32,
}

/// A robot as the referee sees it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RobotSnapshot {
    /// Team and number.
    pub id: RobotId,
    /// Its pose at the end of the cycle, pitch frame.
    pub pose: Pose,
    /// Its pose at the start of the cycle, pitch frame.
    pub previous: Pose,
    /// Velocity of its walk in this cycle, before collisions, m/s, pitch frame.
    pub wanted_velocity: Vec2,
    /// Angles of its head.
    pub head: HeadAngles,
    /// Whether it kicks, or recovers from a kick.
    pub is_kicking: bool,
    /// Its body.
    pub bounds: Body,
    /// Its posture.
    pub posture: Posture,
    /// The penalty that it serves, if any.
    pub penalty: Penalty,
}

impl RobotSnapshot {
    /// Its state, as evidence.
    pub fn evidence(&self) -> RobotEvidence {
        RobotEvidence { robot: self.id, position_m: self.pose.position, speed_mps: self.wanted_velocity.length() }
    }

    /// Whether it takes part in play, rather than serving a penalty.
    pub fn is_present(&self) -> bool {
        !self.penalty.is_active()
    }

    /// Whether the robot takes no part in the match: it is sent off, or a substitute.
    pub fn is_out(&self) -> bool {
        self.penalty.0.is_some_and(|penalty| penalty.is_for_the_match())
    }
}
