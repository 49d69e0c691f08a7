//! Penalties: removal of robots, their wait, and their return.

use bevy::prelude::*;

use super::collision;
use super::decide::Referee;
use super::placing::Occupied;
use super::removal::{halfway_pose, return_pose, stuck_keeper_pose, waiting_pose};
use super::snapshot::RobotSnapshot;
use crate::events::MatchEvent;
use crate::game::{ActivePenalty, Evidence, GameState, Penalty, PenaltyReason, SetPlayKind};
use crate::team::Team;

/// Distance from the ball within which a push gives the other team a free kick, m (2025 rule book, section 4.10).
const PUSHING_FREE_KICK_M: f32 = 0.5;

impl Referee<'_, '_> {
    /// Advances the time of penalties, and brings back robots that have served theirs.
    pub(super) fn count_penalties(&mut self) {
        for index in 0..self.decisions.robots.len() {
            let Some(penalty) = &mut self.decisions.robots[index].penalty.0 else { continue };
            if penalty.is_for_the_match() {
                continue;
            }
            penalty.cycles_left = penalty.cycles_left.saturating_sub(1);
            if penalty.cycles_left == 0 {
                self.bring_back(index);
            }
        }
    }

    /// Penalises the robot that is responsible for a collision. If the push is `mutual`, neither team has a free kick.
    pub(super) fn penalise_push(&mut self, robot: usize, other: usize, mutual: bool) {
        if !self.decisions.robots[robot].is_present() {
            return;
        }
        let id = self.seen.robots[robot].id;
        let evidence = collision::evidence(self.seen, robot, other);
        let is_sent_off = self.caution(robot, &evidence);
        self.penalise(robot, if is_sent_off { PenaltyReason::SentOff } else { PenaltyReason::Pushing }, evidence);
        let rules = self.seen.rules;
        let near_m = self.offence_distance_m();
        let offences = near_m.is_some();
        let near_m = near_m.unwrap_or(PUSHING_FREE_KICK_M);
        let Some(ball_m) = self.offence_near_ball(robot, near_m).filter(|_| !mutual) else { return };
        // A robot in the mouth of the goal is in the area.
        let place = self.seen.pitch.within_lines(self.seen.robots[other].pose.position);
        if rules.penalty_kicks && self.seen.pitch.in_penalty_area(self.seen.game.own_end(id.team), place) {
            self.begin_penalty_kick(id.team.opponent());
        } else if rules.pushing_free_kick || offences {
            self.begin_free_kick(SetPlayKind::PushingFreeKick, id.team.opponent(), ball_m);
        }
    }

    /// The distance from the ball within which every offence gives the other team a free kick, m.
    fn offence_distance_m(&self) -> Option<f32> {
        let rules = self.seen.rules;
        rules.offence_free_kick_m.or(rules.offence_free_kick.then(|| rules.free_kick_radius_m(self.seen.pitch)))
    }

    /// The position of the ball if play is on and the robot is within `near_m` of it, so that its offence gives a free kick.
    fn offence_near_ball(&self, robot: usize, near_m: f32) -> Option<Vec2> {
        let ball = self.seen.ball?.position;
        let game = &self.decisions.game;
        let is_play = game.set_play.is_none()
            && game.state == GameState::Playing
            && self.decisions.ball.is_none()
            && !self.ball_leaves_play();
        (is_play && self.seen.robots[robot].pose.position.distance(ball) <= near_m).then_some(ball)
    }

    /// Gives the other team a free kick for an offence other than pushing near the ball, if the rules say so.
    pub(super) fn restart_after_offence(&mut self, robot: usize, reason: PenaltyReason) {
        let Some(near_m) = self.offence_distance_m().filter(|_| reason.is_infraction()) else { return };
        if let Some(ball_m) = self.offence_near_ball(robot, near_m) {
            let team = self.seen.robots[robot].id.team.opponent();
            self.begin_free_kick(SetPlayKind::IndirectFreeKick, team, ball_m);
        }
    }

    /// Cautions a robot that pushed, if the rules have cautions. Returns whether it is sent off.
    pub(super) fn caution(&mut self, index: usize, evidence: &Evidence) -> bool {
        let Some(most) = self.seen.rules.cautions_to_send_off else { return false };
        let record = &mut self.memory.robots[index];
        record.cautions = record.cautions.saturating_add(1);
        let (robot, cautions) = (record.id, record.cautions);
        self.decisions.events.push(MatchEvent::Caution { robot, cautions, evidence: evidence.clone() });
        cautions >= most
    }

    /// Counts the offence, and returns the duration of its penalty in cycles of play.
    pub(super) fn penalty_cycles(&mut self, reason: PenaltyReason, team: Team) -> u64 {
        let rules = self.seen.rules;
        if reason == PenaltyReason::IllegalPosition && self.decisions.game.state == GameState::Set {
            return self.illegal_place_cycles(rules.illegal_position_s.unwrap_or(rules.penalty_s), team);
        }
        let is_push = matches!(reason, PenaltyReason::Pushing | PenaltyReason::SentOff);
        self.memory.pushes[team] = self.memory.pushes[team].saturating_add(u32::from(is_push));
        let for_the_half = is_push && rules.pushing_limit.is_some_and(|limit| self.memory.pushes[team] >= limit);
        let rest_of_half = self.seen.game.cycles_left;
        if reason == PenaltyReason::SentOff {
            let later = self.seen.game.half.saturating_add(1)..=rules.halves.saturating_add(rules.extra_time_halves);
            let halves_left: u64 = later.map(|half| rules.half_cycles(half, &self.seen.clock)).sum();
            return rest_of_half.unwrap_or(0) + halves_left;
        }
        let cycles = match (reason, rules.motion_in_set_s) {
            (PenaltyReason::MotionInSet, Some(seconds)) => self.lengthened_cycles(seconds, team, false),
            _ => self.lengthened_cycles(rules.penalty_s, team, rules.counts_as_infraction(reason)),
        };
        rest_of_half.filter(|_| for_the_half).unwrap_or(cycles)
    }

    /// The duration of the penalty for an illegal position at the beginning of `set`, in cycles of play.
    pub(super) fn illegal_place_cycles(&mut self, seconds: f32, team: Team) -> u64 {
        self.lengthened_cycles(seconds, team, self.seen.rules.illegal_position_increases)
    }

    /// The duration of a penalty of `seconds` with the extension for earlier infractions of `team`, in cycles. If the penalty `counts`, it
    /// is an infraction itself.
    pub(super) fn lengthened_cycles(&mut self, seconds: f32, team: Team, counts: bool) -> u64 {
        let rules = self.seen.rules;
        let earlier = &mut self.memory.infractions[team];
        let increases = counts || rules.all_penalties_increase;
        let more_s = if increases { rules.penalty_increase_s * *earlier as f32 } else { 0.0 };
        *earlier = earlier.saturating_add(u32::from(counts));
        self.seen.cycles(seconds + more_s)
    }

    /// Removes a robot from the pitch.
    pub(super) fn penalise(&mut self, index: usize, reason: PenaltyReason, evidence: Evidence) {
        let cycles = self.penalty_cycles(reason, self.seen.robots[index].id.team);
        self.remove(index, reason, cycles, evidence);
    }

    /// Penalises a robot for `cycles` of play, off the pitch or in place, depending on `reason`.
    pub(super) fn remove(&mut self, index: usize, reason: PenaltyReason, cycles: u64, evidence: Evidence) {
        let snapshot = self.now();
        let RobotSnapshot { id, bounds, pose, .. } = snapshot.robots[index];
        let pose = if reason.is_in_place() {
            pose
        } else {
            let waiting = Occupied::by_waiting(&snapshot);
            let own_end = snapshot.game.own_end(id.team);
            let place = snapshot.rules.return_place;
            waiting_pose(snapshot.pitch, place, own_end, pose.position, &bounds, &waiting)
        };
        let until_s = (self.seen.clock.end_time_s() + cycles as f64 * self.seen.clock.period_s) as f32;
        let robot = &mut self.decisions.robots[index];
        robot.pose = pose;
        robot.penalty = Penalty(Some(ActivePenalty { reason, cycles_left: cycles.max(1) }));
        self.memory.robots[index].forgive();
        self.decisions.events.push(MatchEvent::Penalty { robot: id, reason, until_s, evidence });
    }

    /// Brings a penalised robot back.
    pub(super) fn bring_back(&mut self, index: usize) {
        let snapshot = self.now();
        let RobotSnapshot { id, bounds, pose, penalty, .. } = snapshot.robots[index];
        let pose = if penalty.is_off_pitch() {
            let occupied = Occupied::by_others(&snapshot, Some(index));
            return_pose(&snapshot, snapshot.game.own_end(id.team), pose, &bounds, &occupied)
        } else {
            pose
        };
        let robot = &mut self.decisions.robots[index];
        robot.pose = pose;
        robot.penalty = Penalty(None);
        self.memory.robots[index].returns = penalty.is_off_pitch();
        self.decisions.events.push(MatchEvent::PenaltyOver { robot: id, position_m: pose.position });
    }

    /// Brings all penalised robots back.
    pub(super) fn bring_all_back(&mut self) {
        for index in 0..self.decisions.robots.len() {
            let robot = &self.decisions.robots[index];
            if !robot.is_present() && !robot.is_out() {
                self.bring_back(index);
            }
        }
    }

    /// Ends all penalties except those for the match. The robots are about to be placed.
    pub(super) fn end_penalties(&mut self) {
        for index in 0..self.decisions.robots.len() {
            let robot = &mut self.decisions.robots[index];
            if !robot.is_present() && !robot.is_out() {
                robot.penalty = Penalty(None);
                let (robot, position_m) = (robot.id, robot.pose.position);
                self.decisions.events.push(MatchEvent::PenaltyOver { robot, position_m });
            }
        }
    }

    /// Removes the robot nearest to a stuck ball: from the pitch, or to the halfway line; a goalkeeper in its own penalty area is moved to
    /// the penalty mark.
    pub(super) fn take_from_ball(&mut self, index: usize, evidence: Evidence) {
        let id = self.seen.robots[index].id;
        self.decisions.events.push(MatchEvent::GameStuck { robot: Some(id), evidence: evidence.clone() });
        if self.seen.rules.stuck_robot_is_penalised {
            self.penalise(index, PenaltyReason::GameStuck, evidence);
            return;
        }
        let snapshot = self.now();
        let robot = &snapshot.robots[index];
        let own_end = snapshot.game.own_end(id.team);
        let occupied = Occupied::by_others(&snapshot, Some(index));
        let pose = stuck_keeper_pose(&snapshot, robot)
            .map(|pose| occupied.free_pose(pose, &robot.bounds))
            .unwrap_or_else(|| halfway_pose(&snapshot, own_end, &robot.bounds, &occupied));
        self.decisions.robots[index].pose = pose;
        self.memory.robots[index].forgive();
    }
}
