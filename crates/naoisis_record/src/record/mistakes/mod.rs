//! Finds mistakes of robots that a team wants to look at after a match, in the [records of its cycles](CycleRecord), from a running match
//! or from a trace.
//!
//! | mistake | when |
//! |---|---|
//! | `ball_misplaced` | for half a second a robot believes the ball to be more than 0.5 m from its true position, and the ball was not put elsewhere in the last 3 s |
//! | `own_pose_lost` | for a second a robot believes itself to be more than 0.5 m, or 30°, from its true pose |
//! | `ball_not_seen` | the team's robot nearest to the ball, within 2 m of it, has not seen it for 3 s |
//! | `kick_missed` | a kick did not reach the ball |
//! | `kick_at_own_goal` | the ball left towards the own goal, fast enough to get there |
//! | `ball_given_away` | a [pass](super::match_counts) that was not completed: an opponent touched the ball next, or it was out |
//! | `team_mates_collide` | two robots of a team ran into each other |
//! | `same_ball` | for a second two robots of a team, neither its keeper, walked to the ball within 0.75 m of it |
//!
//! Mistakes are found in play only, and none of beliefs while the robot's program restarts. A mistake that lasts counts once, with its beginning, its end and its worst value.

use bevy::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

use super::match_counts::kicks::{KickEnd, KickFollower, KickOutcome, StruckKick};
pub use naoisis_core::events::MistakeKind;
use naoisis_core::events::{CollisionPartner, KickMiss, KickResult, MatchEvent};
use naoisis_core::game::{GameState, Intervention};
use naoisis_core::geometry::wrap_angle;
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::belief::{pitch_from_team, point_pitch_from_team};
use naoisis_sim::interface::cycle_record::{CycleRecord, RobotRecord};
use naoisis_sim::scenario::Scenario;

/// Error above which a believed ball or pose is misplaced, m.
const MISPLACED_M: f32 = 0.5;
/// Error above which a heading is misplaced, radians.
const TURNED: f32 = core::f32::consts::FRAC_PI_6;
/// Distance to the ball within which the team's nearest robot should see it, m.
const OWN_BALL_M: f32 = 2.0;
/// Distance to the ball within which two robots go for the same ball, m; and their least speed towards it, m/s.
const SAME_BALL_M: f32 = 0.75;
const TOWARDS_MPS: f32 = 0.05;
/// Time that robots have to find a ball that was put elsewhere, s.
const FIND_PUT_BALL_S: f64 = 3.0;
/// Time within which a repeated mistake counts as the same mistake, s.
const SAME_S: f64 = 2.0;

/// A mistake of a robot.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Mistake {
    /// Its kind.
    pub kind: MistakeKind,
    /// The robot that made it.
    pub robot: RobotId,
    /// The other robot involved: the team-mate, or the opponent that got the ball.
    pub other: Option<RobotId>,
    /// Time at which the mistake began, s since the start of the match.
    pub from_s: f64,
    /// Time at which the mistake was over, s.
    pub until_s: f64,
    /// Position of the robot when the mistake began, m, pitch frame.
    pub position_m: Vec2,
    /// The largest value during the mistake, in the [unit](Mistake::unit) of its kind: a distance to the ball or to a place, the speed of a
    /// collision or of the ball. `None` for kinds without a value.
    pub worst: Option<f32>,
}

impl Mistake {
    /// Returns the unit of [`Mistake::worst`].
    pub fn unit(&self) -> &'static str {
        match self.kind {
            MistakeKind::BallMisplaced | MistakeKind::OwnPoseLost | MistakeKind::BallNotSeen => "m",
            MistakeKind::TeamMatesCollide | MistakeKind::KickAtOwnGoal => "m/s",
            _ => "",
        }
    }

    fn is_of(&self, kind: MistakeKind, robot: RobotId) -> bool {
        self.kind == kind && self.robot == robot
    }
}

/// Finds mistakes, cycle by cycle.
#[derive(Clone, Debug)]
pub struct MistakeFinder {
    kicks: KickFollower,
    /// Mistakes under way, which may not have lasted long enough yet.
    under_way: Vec<Mistake>,
    found: Vec<Mistake>,
    /// The robots that have had a belief.
    believers: BTreeSet<RobotId>,
    /// The times until which programs restart, s.
    down_until_s: BTreeMap<RobotId, f64>,
    /// The time at which the ball was last put elsewhere, s.
    ball_put_s: f64,
}

impl MistakeFinder {
    /// Creates a finder for matches of `scenario`.
    pub fn new(scenario: &Scenario) -> Self {
        let kicks = KickFollower::new(scenario);
        Self {
            kicks,
            under_way: Vec::new(),
            found: Vec::new(),
            believers: BTreeSet::new(),
            down_until_s: BTreeMap::new(),
            ball_put_s: f64::NEG_INFINITY,
        }
    }

    /// Reads the next cycle.
    pub fn look(&mut self, record: &CycleRecord) {
        for (kick, end) in self.kicks.look(&record.into()) {
            self.judge_kick(kick, end, record.time_s);
        }
        for event in &record.events {
            self.note_circumstances(event, record.time_s);
        }
        if record.game.state != GameState::Playing {
            self.end(|_| true);
            return;
        }
        for robot in record.robots.iter().filter(|robot| robot.penalised.is_none()) {
            if self.down_until_s.get(&robot.id).is_none_or(|until_s| *until_s < record.time_s) {
                self.look_at_beliefs(record, robot);
            }
        }
        self.look_at_teams(record);
        for event in &record.events {
            self.look_at_event(record, event);
        }
        // Mistakes that did not continue in this cycle are over.
        self.end(|mistake| mistake.until_s < record.time_s);
    }

    /// Returns the mistakes up to now, in the order in which they began.
    pub fn mistakes(&self) -> Vec<Mistake> {
        let mut whole = self.clone();
        if let Some((kick, end)) = whole.kicks.finish() {
            whole.judge_kick(kick, end, kick.time_s);
        }
        whole.end(|_| true);
        let mut all = whole.found;
        all.sort_by(|one, other| one.from_s.total_cmp(&other.from_s).then(one.robot.cmp(&other.robot)));
        all
    }

    /// Returns whether a robot of which `is_meant` holds has had a belief, so that mistakes of beliefs can be found.
    pub fn knows_beliefs(&self, is_meant: impl Fn(RobotId) -> bool) -> bool {
        self.believers.iter().any(|robot| is_meant(*robot))
    }

    /// Notes what excuses wrong beliefs: the ball was put elsewhere, or a program restarts.
    fn note_circumstances(&mut self, event: &MatchEvent, time_s: f64) {
        match event {
            MatchEvent::Goal { .. }
            | MatchEvent::BallOut { .. }
            | MatchEvent::KickOff { .. }
            | MatchEvent::DropBall { .. }
            | MatchEvent::ThrowIn { .. }
            | MatchEvent::FreeKick { .. }
            | MatchEvent::Intervention { intervention: Intervention::PlaceBall { .. } } => self.ball_put_s = time_s,
            MatchEvent::ProgramRestarts { robot, duration_s } => {
                self.down_until_s.insert(*robot, time_s + f64::from(*duration_s));
            }
            _ => {}
        }
    }

    /// Compares a robot's beliefs with the truth.
    fn look_at_beliefs(&mut self, record: &CycleRecord, robot: &RobotRecord) {
        let Some(belief) = &robot.belief else { return };
        self.believers.insert(robot.id);
        let own_end = record.game.own_end(robot.id.team);
        let pose = pitch_from_team(belief.pose, own_end);
        let away_m = pose.position.distance(robot.pose.position);
        let turned = wrap_angle(pose.heading - robot.pose.heading).abs();
        if away_m > MISPLACED_M || turned > TURNED {
            self.goes_on(MistakeKind::OwnPoseLost, record, robot, None, Some(away_m));
        }
        let ball = record.ball.map(|ball| ball.position_m.truncate());
        let was_put = record.time_s - self.ball_put_s < FIND_PUT_BALL_S;
        if let (Some(ball), Some(believed)) = (ball.filter(|_| !was_put), belief.ball) {
            let away_m = point_pitch_from_team(believed.position_m, own_end).distance(ball);
            if away_m > MISPLACED_M {
                self.goes_on(MistakeKind::BallMisplaced, record, robot, None, Some(away_m));
            }
        }
    }

    /// Compares the actions of the robots of each team.
    fn look_at_teams(&mut self, record: &CycleRecord) {
        let Some(ball) = record.ball.map(|ball| ball.position_m.truncate()) else { return };
        for team in Team::BOTH {
            let is_there =
                |robot: &&RobotRecord| robot.id.team == team && robot.penalised.is_none() && robot.posture.is_upright();
            let distance = |robot: &RobotRecord| robot.pose.position.distance(ball);
            let robots = || record.robots.iter().filter(is_there);
            let nearest = robots().min_by(|one, other| distance(one).total_cmp(&distance(other)));
            if let Some(robot) = nearest.filter(|robot| distance(robot) < OWN_BALL_M && robot.percepts.ball.is_none()) {
                self.goes_on(MistakeKind::BallNotSeen, record, robot, None, Some(distance(robot)));
            }
            let goes = |robot: &&RobotRecord| {
                let towards = (ball - robot.pose.position).normalize_or_zero();
                !robot.id.is_goalkeeper_of(&record.game.goalkeepers)
                    && distance(robot) < SAME_BALL_M
                    && robot.velocity.linear.dot(towards) > TOWARDS_MPS
            };
            let mut both = robots().filter(goes);
            if let (Some(one), Some(other)) = (both.next(), both.next()) {
                // The robot further away makes the mistake.
                let (near, far) = if distance(one) < distance(other) { (one, other) } else { (other, one) };
                self.goes_on(MistakeKind::SameBall, record, far, Some(near.id), None);
            }
        }
    }

    fn look_at_event(&mut self, record: &CycleRecord, event: &MatchEvent) {
        match event {
            MatchEvent::Kick { robot, result: KickResult::Missed, reason: Some(KickMiss::OutOfReach), .. } => {
                self.happened(MistakeKind::KickMissed, record, *robot, None, None);
            }
            MatchEvent::Collision { robot: Some(robot), with: CollisionPartner::Robot(other), speed_mps, .. }
                if robot.team == other.team =>
            {
                self.happened(MistakeKind::TeamMatesCollide, record, *robot, Some(*other), Some(*speed_mps));
            }
            _ => {}
        }
    }

    /// Notes the mistakes of a kick when its end is known.
    fn judge_kick(&mut self, kick: StruckKick, end: KickEnd, until_s: f64) {
        let mistake = |kind, other, worst| Mistake {
            kind,
            robot: kick.robot,
            other,
            from_s: kick.time_s,
            until_s,
            position_m: kick.position_m,
            worst,
        };
        let pitch = self.kicks.pitch();
        if kick.is_at_own_goal(pitch) {
            self.found.push(mistake(MistakeKind::KickAtOwnGoal, None, Some(kick.speed_mps)));
        }
        if let KickOutcome::PassFailed { to } = kick.outcome(end, pitch) {
            self.found.push(mistake(MistakeKind::BallGivenAway, to, None));
        }
    }

    /// Notes that a mistake continues in this cycle.
    fn goes_on(
        &mut self,
        kind: MistakeKind,
        record: &CycleRecord,
        robot: &RobotRecord,
        other: Option<RobotId>,
        measured: Option<f32>,
    ) {
        let known = self.under_way.iter_mut().find(|mistake| mistake.is_of(kind, robot.id));
        match known {
            Some(mistake) => {
                mistake.until_s = record.time_s;
                mistake.worst = greater(mistake.worst, measured);
            }
            None => self.under_way.push(Mistake {
                kind,
                robot: robot.id,
                other,
                from_s: record.time_s,
                until_s: record.time_s,
                position_m: robot.pose.position,
                worst: measured,
            }),
        }
    }

    /// Notes a mistake without a duration. Soon after the last one it counts as the same mistake.
    fn happened(
        &mut self,
        kind: MistakeKind,
        record: &CycleRecord,
        robot: RobotId,
        other: Option<RobotId>,
        measured: Option<f32>,
    ) {
        let is_same = |mistake: &&mut Mistake| mistake.is_of(kind, robot) && record.time_s - mistake.until_s < SAME_S;
        if let Some(mistake) = self.found.iter_mut().rev().find(is_same) {
            mistake.until_s = record.time_s;
            mistake.worst = greater(mistake.worst, measured);
            return;
        }
        let position_m = record.robot(robot).map_or(Vec2::ZERO, |robot| robot.pose.position);
        let (from_s, until_s) = (record.time_s, record.time_s);
        self.found.push(Mistake { kind, robot, other, from_s, until_s, position_m, worst: measured });
    }

    /// Ends the mistakes for which `is_over` holds. They count if they lasted long enough.
    fn end(&mut self, is_over: impl Fn(&Mistake) -> bool) {
        let found = &mut self.found;
        self.under_way.retain(|mistake| {
            let over = is_over(mistake);
            if over && has_lasted(mistake) {
                let is_same = |before: &&mut Mistake| {
                    before.is_of(mistake.kind, mistake.robot) && mistake.from_s - before.until_s < SAME_S
                };
                match found.iter_mut().rev().find(is_same) {
                    Some(before) => {
                        before.until_s = mistake.until_s;
                        before.worst = greater(before.worst, mistake.worst);
                    }
                    None => found.push(*mistake),
                }
            }
            !over
        });
    }
}

/// Returns the least duration of a mistake, s. Returns `None` for mistakes without a duration.
fn least_s(kind: MistakeKind) -> Option<f64> {
    match kind {
        MistakeKind::BallMisplaced => Some(0.5),
        MistakeKind::OwnPoseLost | MistakeKind::SameBall => Some(1.0),
        MistakeKind::BallNotSeen => Some(3.0),
        _ => None,
    }
}

fn has_lasted(mistake: &Mistake) -> bool {
    least_s(mistake.kind).is_none_or(|least_s| mistake.until_s - mistake.from_s >= least_s)
}

fn greater(one: Option<f32>, other: Option<f32>) -> Option<f32> {
    match (one, other) {
        (Some(one), Some(other)) => Some(one.max(other)),
        (one, other) => one.or(other),
    }
}

#[cfg(test)]
mod tests;
