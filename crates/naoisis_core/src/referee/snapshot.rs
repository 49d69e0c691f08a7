//! The world as the referee sees it at the end of a cycle: plain data that rules are functions of.

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

/// Everything that the rules judge by.
#[derive(Clone, Copy, Debug)]
pub struct MatchSnapshot<'a> {
    /// The clock; the instant is the end of its cycle.
    pub clock: CycleClock,
    /// Lines, goals and posts.
    pub pitch: &'a Pitch,
    /// The rules that are played by.
    pub rules: &'a Rules,
    /// The state of the match.
    pub game: &'a Game,
    /// The ball, if there is one.
    pub ball: Option<BallSnapshot<'a>>,
    /// All robots, ordered by id.
    pub robots: &'a [RobotSnapshot],
    /// Posts, goal posts included.
    pub posts: &'a [Disc],
    /// The touches of the ball in this cycle, in their order: who, and whether by a kick.
    pub touches: &'a [(RobotId, bool)],
    /// Who touched the ball last before this cycle; while the referee judges, those of this cycle included.
    pub last_touch: Option<Touch>,
    /// Messages that each team has sent in the match, this cycle included.
    pub messages_sent: PerTeam<u32>,
    /// What the referee is made to do at the end of this cycle.
    pub interventions: &'a [Intervention],
    /// Who decides about the match instead, if somebody outside it does.
    pub outside: Option<&'a OutsideReferee>,
    /// Robots that touched each other in this cycle, by their indices.
    pub contacts: &'a [[usize; 2]],
}

impl MatchSnapshot<'_> {
    /// A number of cycles in seconds.
    pub fn seconds(&self, cycles: u64) -> f32 {
        (cycles as f64 * self.clock.period_s) as f32
    }

    /// A duration in cycles.
    pub fn cycles(&self, seconds: f32) -> u64 {
        u64::from(self.clock.cycles_in(seconds))
    }

    /// Whether a robot is its team's keeper: number 1.
    pub fn is_keeper(&self, robot: &RobotSnapshot) -> bool {
        robot.id.number == 1
    }

    /// Evidence of what happened at `position_m`, with the ball's place.
    pub fn evidence(&self, rule: &'static str, position_m: Vec2) -> Evidence {
        let ball_m = self.ball.map(|ball| ball.position);
        Evidence { rule: Cow::Borrowed(rule), position_m, ball_m, ..Evidence::default() }
    }

    /// Evidence against one robot, where it stands.
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
    /// Team and number.
    pub id: RobotId,
    /// Where it is at the end of the cycle, pitch frame.
    pub pose: Pose,
    /// Where it was at the start of the cycle, pitch frame.
    pub previous: Pose,
    /// How fast it wanted to walk in this cycle, m/s, pitch frame; a collision may have kept it from it.
    pub wanted_velocity: Vec2,
    /// Where its head points.
    pub head: HeadAngles,
    /// Whether it kicks, or regains its balance after a kick.
    pub is_kicking: bool,
    /// The outlines of its body, robot frame.
    pub bounds: Body,
    /// Whether it is on its feet.
    pub posture: Posture,
    /// The penalty that it serves, if any.
    pub penalty: Penalty,
}

impl RobotSnapshot {
    /// How it is when a verdict is given.
    pub fn evidence(&self) -> RobotEvidence {
        RobotEvidence { robot: self.id, position_m: self.pose.position, speed_mps: self.wanted_velocity.length() }
    }

    /// Whether it is on the pitch, rather than serving a penalty.
    pub fn is_present(&self) -> bool {
        !self.penalty.is_active()
    }

    /// Whether it plays no more in this match.
    pub fn is_sent_off(&self) -> bool {
        self.penalty.0.is_some_and(|penalty| penalty.is_for_the_match())
    }
}
