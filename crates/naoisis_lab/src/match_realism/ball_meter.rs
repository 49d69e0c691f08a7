//! Measures the ball in a match: its path, the kicks and their results, and the robots around it.

use bevy::prelude::*;
use std::collections::BTreeMap;

use super::measures::{FieldMeasures, NextTouch};
use super::metered_cycle::MeteredCycle;
use naoisis_core::events::{CollisionPartner, KickMiss, KickResult, MatchEvent};
use naoisis_core::team::{PerTeam, RobotId};
use naoisis_record::record::match_counts::Observed;
use naoisis_record::record::match_counts::kicks::{KickEnd, KickFollower, StruckKick};
use naoisis_sim::interface::cycle_record::{BallRecord, RobotRecord};
use naoisis_sim::scenario::Scenario;

/// Distance to the ball within which a robot is at the ball, m.
const AT_BALL_M: f32 = 0.5;
/// Distance to the ball within which a robot belongs to the crowd, m.
const CROWD_M: f32 = 1.0;
/// Number of robots that make a crowd.
const CROWD: usize = 4;
/// Speed from which on the ball rolls, m/s.
const ROLLS_MPS: f32 = 0.05;
/// Time without motion or touch after which a ball is left alone, s.
const LEFT_ALONE_S: f64 = 2.0;
/// Distance to a touchline within which the ball is at the side, m.
const AT_SIDE_M: f32 = 0.5;

/// Measures the ball.
pub(super) struct BallMeter {
    follower: KickFollower,
    /// The position of the ball after the previous cycle, m.
    last_m: Option<Vec2>,
    /// The time at which each robot arrived at the ball, s.
    at_ball_since: BTreeMap<RobotId, f64>,
    /// The time at which `playing` began, s. `None` after the first touch.
    whistled_at: Option<f64>,
    was_playing: bool,
    /// The time since when the ball has rested without a touch, s.
    alone_since: Option<f64>,
}

impl BallMeter {
    pub(super) fn new(scenario: &Scenario) -> Self {
        Self {
            follower: KickFollower::new(scenario),
            last_m: None,
            at_ball_since: BTreeMap::new(),
            whistled_at: None,
            was_playing: false,
            alone_since: None,
        }
    }

    pub(super) fn look(&mut self, cycle: MeteredCycle, field: &mut FieldMeasures) {
        let MeteredCycle { record, is_playing, duration_s } = cycle;
        // Events before the start of measuring do not count.
        let is_touched = duration_s > 0.0 && self.note_kicks(cycle, field);
        for (kick, end) in self.follower.look(&Observed::from(record)) {
            self.note_end(kick, end, field);
        }
        if is_playing && !self.was_playing && duration_s > 0.0 {
            self.whistled_at = Some(record.time_s);
        }
        self.was_playing = is_playing;
        let ball = record.ball.filter(|_| is_playing);
        match ball {
            Some(ball) => self.look_at(&ball, is_touched, cycle, field),
            None => {
                self.at_ball_since.clear();
                (self.whistled_at, self.alone_since) = (None, None);
            }
        }
        self.last_m = record.ball.map(|ball| ball.position_m.truncate());
    }

    /// Counts the kicks of a cycle. Returns whether a robot touched the ball in it.
    fn note_kicks(&mut self, MeteredCycle { record, .. }: MeteredCycle, field: &mut FieldMeasures) -> bool {
        let mut is_touched = false;
        for event in &record.events {
            match event {
                MatchEvent::Kick { robot, kick_type, result: KickResult::Kicked | KickResult::Reduced, .. } => {
                    is_touched = true;
                    let name = kick_type.name();
                    let name = name.strip_prefix("left_").or_else(|| name.strip_prefix("right_")).unwrap_or(name);
                    *field.kicks.entry(name.to_owned()).or_default() += 1;
                    let since = self.at_ball_since.insert(*robot, record.time_s);
                    field.near_before_kick_s.extend(since.map(|since_s| record.time_s - since_s));
                }
                MatchEvent::Kick { reason: Some(KickMiss::OutOfReach), .. } => field.kicks_missed += 1,
                MatchEvent::Collision { robot: Some(_), with: CollisionPartner::Ball, .. } => is_touched = true,
                _ => {}
            }
        }
        is_touched
    }

    fn note_end(&self, kick: StruckKick, end: KickEnd, field: &mut FieldMeasures) {
        let touch = match end {
            KickEnd::Touched(robot) if robot == kick.robot => NextTouch::Kicker,
            KickEnd::Touched(robot) if robot.team == kick.robot.team => NextTouch::Mate,
            KickEnd::Touched(_) => NextTouch::Opponent,
            KickEnd::Out => NextTouch::Out,
            KickEnd::Goal(_) => NextTouch::Goal,
            KickEnd::Stopped => NextTouch::Stopped,
        };
        *field.next_touches.entry(touch).or_default() += 1;
        // After the cycle the ball may have been kicked again or put down, so its last position is used.
        let way_m = self.last_m.map(|last_m| f64::from(last_m.distance(kick.position_m)));
        field.kick_ways_m.extend(way_m);
    }

    /// Measures the ball in play and the robots around it.
    fn look_at(&mut self, ball: &BallRecord, is_touched: bool, cycle: MeteredCycle, field: &mut FieldMeasures) {
        let MeteredCycle { record, duration_s, .. } = cycle;
        let place_m = ball.position_m.truncate();
        if let Some(since_s) = self.whistled_at.take_if(|_| is_touched) {
            field.first_touch_s.push(record.time_s - since_s);
        }
        let is_put_down = record.events.iter().any(puts_the_ball_down);
        if let Some(last_m) = self.last_m.filter(|_| !is_put_down) {
            field.ball_way_m += f64::from(last_m.distance(place_m));
        }
        let rolls = ball.velocity_mps.truncate().length() > ROLLS_MPS;
        field.ball_rolls_s += if rolls { duration_s } else { 0.0 };
        let is_at_side = self.follower.pitch().half_width() - place_m.y.abs() < AT_SIDE_M;
        field.ball_at_side_s += if is_at_side { duration_s } else { 0.0 };
        if rolls || is_touched || is_put_down {
            self.alone_since = None;
        } else {
            self.alone_since.get_or_insert(record.time_s);
        }
        let (mut near, mut is_at_ball) = (0, PerTeam::<bool>::default());
        for robot in record.robots.iter() {
            let away_m = robot.pose.position.distance(place_m);
            let can_play = robot.penalised.is_none() && robot.posture.is_upright();
            near += usize::from(can_play && away_m <= CROWD_M);
            is_at_ball[robot.id.team] |= can_play && away_m <= AT_BALL_M;
            self.note_presence(robot, can_play && away_m <= AT_BALL_M, record.time_s);
        }
        field.robots_near_ball_s += near as f64 * duration_s;
        field.contested_s += if is_at_ball.blue && is_at_ball.pink { duration_s } else { 0.0 };
        if near >= CROWD {
            field.four_near_ball_s += duration_s;
            let is_alone = self.alone_since.is_some_and(|since_s| record.time_s - since_s > LEFT_ALONE_S);
            field.left_alone_s += if is_alone { duration_s } else { 0.0 };
        }
    }

    fn note_presence(&mut self, robot: &RobotRecord, is_at_ball: bool, time_s: f64) {
        if is_at_ball {
            self.at_ball_since.entry(robot.id).or_insert(time_s);
        } else {
            self.at_ball_since.remove(&robot.id);
        }
    }

    /// Ends the kick whose ball is still rolling.
    pub(super) fn finish(&mut self, field: &mut FieldMeasures) {
        if let Some((kick, end)) = self.follower.finish() {
            self.note_end(kick, end, field);
        }
    }
}

/// Returns whether the event puts the ball down somewhere else.
fn puts_the_ball_down(event: &MatchEvent) -> bool {
    matches!(
        event,
        MatchEvent::Goal { .. }
            | MatchEvent::BallOut { .. }
            | MatchEvent::KickOff { .. }
            | MatchEvent::DropBall { .. }
            | MatchEvent::FreeKick { .. }
            | MatchEvent::ThrowIn { .. }
            | MatchEvent::Intervention { .. }
    )
}
