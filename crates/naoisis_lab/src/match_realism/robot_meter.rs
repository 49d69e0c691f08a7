//! Measures the robots in a match: walking, standing, falls, getting up, contacts, and how often they see the ball.

use bevy::prelude::*;
use std::collections::BTreeMap;

use super::measures::FieldMeasures;
use super::metered_cycle::MeteredCycle;
use naoisis_core::events::{CollisionPartner, FallCause, MatchEvent};
use naoisis_core::robot::posture::{LyingOn, Posture};
use naoisis_core::team::{PerTeam, RobotId};
use naoisis_sim::interface::cycle_record::RobotRecord;

/// The least step that counts as walking, m, as in the video analysis of B-Human.
const LEAST_STEP_M: f32 = 0.1;
/// Speed below which a robot stands, m/s.
const STANDS_MPS: f32 = 0.02;
/// Time after which a ball that no robot of a team has seen is unknown to the team, s.
const UNKNOWN_AFTER_S: f64 = 1.0;
/// Distance within which the ball should be seen, m.
const NEAR_BALL_M: f32 = 3.0;

/// Measures robots.
#[derive(Default)]
pub(super) struct RobotMeter {
    /// The start of each robot's next step, while the robot is upright in play.
    steps_from: BTreeMap<RobotId, Vec2>,
    /// When each lying robot fell, s, and the side of the body on which it lies.
    fell_at: BTreeMap<RobotId, (f64, LyingOn)>,
    /// When a robot of the team last saw the ball in this play, s.
    ball_seen_at: PerTeam<Option<f64>>,
}

impl RobotMeter {
    pub(super) fn look(&mut self, cycle: MeteredCycle, field: &mut FieldMeasures) {
        for event in &cycle.record.events {
            self.note(event, cycle, field);
        }
        for robot in &cycle.record.robots {
            if let (Some(on), Some((_, side))) = (robot.posture.lying_on(), self.fell_at.get_mut(&robot.id)) {
                *side = on;
            }
            self.look_at(robot, cycle, field);
        }
        self.look_for_ball(cycle, field);
    }

    fn note(&mut self, event: &MatchEvent, cycle: MeteredCycle, field: &mut FieldMeasures) {
        let MeteredCycle { record, is_playing, .. } = cycle;
        match event {
            MatchEvent::Fall { robot, cause, .. } => {
                // If a robot falls again while getting up, the first fall counts.
                if *cause != FallCause::GettingUp {
                    self.fell_at.insert(*robot, (record.time_s, LyingOn::default()));
                }
                if is_playing {
                    *field.falls.entry(*cause).or_default() += 1;
                }
            }
            MatchEvent::GotUp { robot } => {
                let Some((fell_s, on)) = self.fell_at.remove(robot) else { return };
                let times = match on {
                    LyingOn::Front => &mut field.get_up_front_s,
                    LyingOn::Back => &mut field.get_up_back_s,
                };
                times.push(record.time_s - fell_s);
            }
            MatchEvent::Penalty { robot, .. } => {
                self.fell_at.remove(robot);
            }
            MatchEvent::GameStuck { robot: Some(_), .. } => field.stuck_robots += 1,
            MatchEvent::GameStuck { robot: None, .. } => field.stuck_stops += 1,
            MatchEvent::Collision { robot: Some(one), with: CollisionPartner::Robot(other), .. } if is_playing => {
                let contacts = if one.team == other.team {
                    &mut field.contacts_of_mates
                } else {
                    &mut field.contacts_of_opponents
                };
                *contacts += 1;
            }
            _ => {}
        }
    }

    fn look_at(&mut self, robot: &RobotRecord, cycle: MeteredCycle, field: &mut FieldMeasures) {
        let MeteredCycle { record, is_playing, duration_s } = cycle;
        if !is_playing || robot.penalised.is_some() {
            self.steps_from.remove(&robot.id);
            return;
        }
        field.robot_play_s += duration_s;
        if matches!(robot.posture, Posture::Fallen { .. } | Posture::GettingUp { .. }) {
            field.lying_s += duration_s;
        }
        if let Some(ball) = record.ball
            && ball.position_m.truncate().distance(robot.pose.position) <= NEAR_BALL_M
        {
            field.near_3_m_s += duration_s;
            field.seen_within_3_m_s += if robot.percepts.ball.is_some() { duration_s } else { 0.0 };
        }
        if !robot.posture.is_upright() {
            self.steps_from.remove(&robot.id);
            return;
        }
        if !robot.id.is_goalkeeper_of(&record.game.goalkeepers) {
            field.field_player_s += duration_s;
            field.standing_s += if robot.velocity.linear.length() < STANDS_MPS { duration_s } else { 0.0 };
        }
        let from = self.steps_from.entry(robot.id).or_insert(robot.pose.position);
        let step_m = from.distance(robot.pose.position);
        if step_m >= LEAST_STEP_M {
            field.walked_m += f64::from(step_m);
            *from = robot.pose.position;
        }
    }

    fn look_for_ball(&mut self, MeteredCycle { record, is_playing, .. }: MeteredCycle, field: &mut FieldMeasures) {
        if !is_playing {
            self.ball_seen_at = PerTeam::default();
            return;
        }
        let can_see = |robot: &&RobotRecord| robot.penalised.is_none() && robot.percepts.ball.is_some();
        let seen = record.robots.iter().filter(can_see).map(|robot| robot.id.team);
        for team in seen {
            let before = self.ball_seen_at[team].replace(record.time_s);
            let gap_s = before.map(|before_s| record.time_s - before_s);
            field.ball_unknown_s.extend(gap_s.filter(|gap_s| *gap_s > UNKNOWN_AFTER_S));
        }
    }
}
