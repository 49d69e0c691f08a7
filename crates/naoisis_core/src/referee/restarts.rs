//! Restarts: kick-offs with `ready` and `set`, free kicks, halves, and the end of the match.

use bevy::prelude::*;

use super::decide::Referee;
use super::indirect_goal::Plays;
use super::kick_off_shot::KickOffPlay;
use super::penalty_kick;
use super::placing::{LineUp, Occupied};
use super::positions::{self, IllegalPosition, illegal_positions};
use super::set_play::{self, Course};
use super::snapshot::Disc;
use crate::events::MatchEvent;
use crate::game::{Evidence, GameState, KickOffProcedure, PenaltyReason, Score, SetPlay, SetPlayKind};
use crate::referee::formation;
use crate::team::Team;

/// Time for which all robots must stand at legal positions before `ready` may end early, s.
const LINED_UP_S: f32 = 1.0;
/// Overlap of the ball and a robot's base that only touch, m.
const TOUCHING_M: f32 = 5e-4;

impl Referee<'_, '_> {
    /// Whistles.
    pub(super) fn whistle(&mut self) {
        self.decisions.game.whistles = self.decisions.game.whistles.saturating_add(1);
    }

    pub(super) fn enter(&mut self, state: GameState) {
        self.decisions.game.state = state;
        self.decisions.game.state_cycles = 0;
        self.decisions.events.push(MatchEvent::StateChanged { state });
    }

    /// Places the ball, and forgets its last touch. Robots in its way are moved aside; only a post displaces the ball.
    pub(super) fn put_ball(&mut self, place: Vec2) -> Vec2 {
        let radius = self.seen.ball.map_or(0.0, |ball| ball.radius);
        let place = Occupied::by_posts(self.seen.pitch, self.seen.posts, None).free_ball_place(place, radius);
        self.decisions.ball = Some(place);
        self.decisions.ball_velocity = Vec2::ZERO;
        if let Some(stop) = &mut self.decisions.game.stop {
            stop.ball_m = Some(place);
        }
        self.memory.last_touch = None;
        for index in 0..self.decisions.robots.len() {
            self.move_aside(index, place, radius);
        }
        place
    }

    /// Moves a robot that stands where the ball of `radius` is put to the nearest free position, in its posture.
    fn move_aside(&mut self, index: usize, ball: Vec2, radius: f32) {
        let snapshot = self.now();
        let robot = &snapshot.robots[index];
        let base = robot.bounds.base.footprint(robot.pose);
        if robot.penalty.is_off_pitch() || base.overlap_disc(ball, radius - TOUCHING_M).is_none() {
            return;
        }
        let pose = Occupied::by_others(&snapshot, Some(index)).free_pose(robot.pose, &robot.bounds);
        let robot = &mut self.decisions.robots[index];
        robot.pose = pose;
        self.decisions.moved_aside.push(robot.id);
        self.decisions.events.push(MatchEvent::MovedAside { robot: robot.id, position_m: pose.position });
    }

    /// Counts the cycle, if the clock runs. Returns whether the half is over.
    pub(super) fn run_clock(&mut self) -> bool {
        if !self.seen.game.clock_runs(self.seen.rules, &self.seen.clock) {
            return false;
        }
        let game = &mut self.decisions.game;
        let Some(cycles_left) = &mut game.cycles_left else { return false };
        game.overtime_cycles = if *cycles_left == 0 { game.overtime_cycles + 1 } else { 0 };
        *cycles_left = cycles_left.saturating_sub(1);
        *cycles_left == 0
    }

    /// Whether a penalty kick that is not over extends the half beyond its time.
    pub(super) fn penalty_kick_goes_on(&self) -> bool {
        self.seen.rules.penalty_kick_extends_half && self.decisions.game.penalty_kick().is_some()
    }

    /// Changes sides for the next half, or ends the match.
    pub(super) fn end_half(&mut self) {
        let (rules, game) = (self.seen.rules, &mut self.decisions.game);
        let is_drawn = game.score.blue == game.score.pink;
        // Extra time is played after a draw, and is then played to its end.
        let plays_on = is_drawn || rules.is_extra_time(game.half);
        let halves = rules.halves + if plays_on { rules.extra_time_halves } else { 0 };
        if game.half >= halves {
            self.end_match();
            return;
        }
        game.half = game.half.saturating_add(1);
        game.blue_end = game.blue_end.opposite();
        (game.cycles_left, game.overtime_cycles) = (Some(rules.half_cycles(game.half, &self.seen.clock)), 0);
        (game.stop, game.set_play) = (None, None);
        let half = game.half;
        self.memory.pushes = default();
        self.decisions.events.push(MatchEvent::HalfBegins { half });
        self.end_penalties();
        let team = self.seen.rules.first_kick_off_of_half(half);
        if self.seen.rules.kick_off == KickOffProcedure::ReadyAndSet {
            // In the break the robots are carried to their new half.
            self.place_for_kick_off(Some(team));
            if self.seen.rules.initial_s > 0.0 {
                let game = &mut self.decisions.game;
                (game.kick_off_team, game.drop_ball) = (team, false);
                self.enter(GameState::Initial);
                return;
            }
        }
        self.begin_half();
    }

    /// A cycle of `initial` before a half.
    pub(super) fn follow_initial(&mut self) {
        let waits = self.seen.rules.kick_off == KickOffProcedure::ReadyAndSet && self.seen.rules.initial_s > 0.0;
        if waits && self.decisions.game.state_cycles >= self.seen.cycles(self.seen.rules.initial_s) {
            self.begin_half();
        }
    }

    /// Begins `standby`, or the first kick-off of the half.
    fn begin_half(&mut self) {
        let team = Some(self.seen.rules.first_kick_off_of_half(self.decisions.game.half));
        if self.seen.rules.kick_off == KickOffProcedure::ReadyAndSet && self.seen.rules.standby_s > 0.0 {
            self.announce_kick_off(team);
            self.begin_standby();
        } else {
            self.begin_kick_off(team);
        }
    }

    /// Ends the match, or begins a shoot-out if it is drawn.
    pub(super) fn end_match(&mut self) {
        let Score { blue, pink } = self.decisions.game.score;
        if blue == pink && self.seen.rules.shoot_out && self.seen.ball.is_some() {
            if !self.begin_timeout_before_shoot_out() {
                self.begin_shoot_out();
            }
        } else {
            self.finish();
        }
    }

    /// The final whistle.
    pub(super) fn finish(&mut self) {
        self.whistle();
        self.decisions.game.state = GameState::Finished;
        self.decisions.game.state_cycles = 0;
        (self.decisions.game.stop, self.decisions.game.set_play) = (None, None);
        self.decisions.events.push(MatchEvent::FinalWhistle);
    }

    /// Begins a kick-off, or without a team a drop ball. Robots are placed or walk to their positions, depending on the rules.
    pub(super) fn begin_kick_off(&mut self, team: Option<Team>) {
        if self.seen.rules.penalties_end_at_kick_off {
            match self.seen.rules.kick_off {
                KickOffProcedure::Placed => self.end_penalties(),
                KickOffProcedure::ReadyAndSet => self.bring_all_back(),
            }
        }
        self.announce_kick_off(team);
        match self.seen.rules.kick_off {
            KickOffProcedure::Placed => {
                self.place_for_kick_off(team);
                self.bring_ball_into_play();
                if self.decisions.game.state != GameState::Playing {
                    self.enter(GameState::Playing);
                }
            }
            KickOffProcedure::ReadyAndSet => self.begin_ready(),
        }
    }

    /// Begins a kick-off with `ready`, independently of the rules: robots walk to their positions.
    pub(super) fn prepare_kick_off(&mut self, team: Option<Team>) {
        self.announce_kick_off(team);
        self.begin_ready();
    }

    pub(super) fn announce_kick_off(&mut self, team: Option<Team>) {
        let game = &mut self.decisions.game;
        game.kick_off_team = team.unwrap_or(game.kick_off_team);
        game.drop_ball = team.is_none();
        (game.stop, game.set_play) = (None, None);
        self.memory.clock_at_stoppage = game.cycles_left;
        self.memory.kick_off = None;
        self.memory.stuck = default();
        self.memory.cycles_lined_up = 0;
        for record in &mut self.memory.robots {
            record.forgive();
        }
        self.decisions
            .events
            .push(team.map_or(MatchEvent::DropBall { position_m: Vec2::ZERO }, |team| MatchEvent::KickOff { team }));
    }

    fn begin_ready(&mut self) {
        self.whistle();
        self.put_ball(Vec2::ZERO);
        self.enter(GameState::Ready);
    }

    /// Places ball and robots for a kick-off.
    pub(super) fn place_for_kick_off(&mut self, team: Option<Team>) {
        self.decisions.game.restarts = self.decisions.game.restarts.saturating_add(1);
        let Self { seen, decisions, memory, .. } = self;
        let ball = seen.ball.map(|ball| Disc { centre: Vec2::ZERO, radius: ball.radius });
        let mut line_up = LineUp::new(seen.pitch, seen.posts, ball, &decisions.game, seen.rules, team);
        for robot in decisions.robots.iter().filter(|robot| !robot.is_present()) {
            line_up.keep_free(robot.pose, &robot.bounds);
        }
        for (robot, record) in decisions.robots.iter_mut().zip(&mut memory.robots) {
            if robot.is_present() {
                robot.pose = line_up.put_down(robot.id, &robot.bounds);
                record.restarts = record.restarts.saturating_add(1);
            }
        }
        self.put_ball(Vec2::ZERO);
    }

    fn bring_ball_into_play(&mut self) {
        let team = self.decisions.game.kick_off();
        self.memory.clock_at_stoppage = None;
        self.whistle();
        self.memory.kick_off = team.map(KickOffPlay::new);
        self.memory.plays = team.map_or_else(Plays::default, |team| Plays::after(SetPlayKind::KickOff, team));
        self.memory.stuck = default();
        let must_kick = team.filter(|_| self.seen.rules.kick_off_player);
        self.memory.kick_off_player = must_kick.and_then(|team| positions::kick_off_player(&self.now(), team));
        let own_time = team.zip(self.seen.rules.kick_off_free_s);
        self.decisions.game.set_play = own_time
            .map(|(team, free_s)| SetPlay::new(SetPlayKind::KickOff, team, Vec2::ZERO, self.seen.cycles(free_s)));
    }

    /// A cycle of `ready`.
    pub(super) fn judge_ready(&mut self) {
        if self.seen.rules.penalties_run_in_ready {
            self.count_penalties();
        }
        if self.run_clock() && !self.penalty_kick_goes_on() {
            self.end_half();
            return;
        }
        self.count_set_play();
        if self.seen.rules.fouls_in_ready {
            self.judge_collisions();
            self.judge_robots();
        }
        let legal = self.illegal_positions().iter().all(Option::is_none);
        let standing = self.seen.robots.iter().all(|robot| !robot.is_present() || robot.pose == robot.previous);
        self.memory.cycles_lined_up = if legal && standing { self.memory.cycles_lined_up + 1 } else { 0 };
        let early = self.seen.rules.end_ready_early && self.memory.cycles_lined_up >= self.seen.cycles(LINED_UP_S);
        if early || self.decisions.game.state_cycles >= self.seen.cycles(self.seen.game.ready_s(self.seen.rules)) {
            self.begin_set();
        }
    }

    /// The illegal position of each robot, if any. A robot that is returning to the pitch after a penalty may be beside it (2025 rule book,
    /// section 3.7).
    fn illegal_positions(&self) -> Vec<Option<IllegalPosition>> {
        let mut illegal: Vec<_> = match self.seen.game.penalty_kick() {
            Some(penalty_kick) => penalty_kick::illegal_positions(self.seen, penalty_kick.team).collect(),
            None => illegal_positions(self.seen, self.seen.game.kick_off()).collect(),
        };
        let robots = self.seen.robots.iter().zip(&self.memory.robots);
        for (illegal, (robot, record)) in illegal.iter_mut().zip(robots) {
            let returns = record.returns && robot.wanted_velocity != Vec2::ZERO;
            illegal.take_if(|illegal| *illegal == IllegalPosition::OffPitch && returns);
        }
        illegal
    }

    /// Advances a set play that is being prepared.
    fn count_set_play(&mut self) {
        let set_play = &mut self.decisions.game.set_play;
        *set_play = set_play.map(|set_play| set_play.later(false));
    }

    /// Begins `set`: robots at illegal positions are placed by hand or removed, and the ball is placed on its mark.
    pub(super) fn begin_set(&mut self) {
        self.forgive_standby();
        for (index, illegal) in self.illegal_positions().into_iter().enumerate() {
            let Some(illegal) = illegal else { continue };
            let evidence = positions::evidence(self.seen, &self.seen.robots[index], illegal);
            match self.seen.rules.illegal_position_s {
                Some(seconds) => {
                    let cycles = self.illegal_place_cycles(seconds, self.seen.robots[index].id.team);
                    self.remove(index, PenaltyReason::IllegalPosition, cycles, evidence);
                }
                None => self.place_by_hand(index, evidence),
            }
        }
        for record in &mut self.memory.robots {
            record.forgive();
        }
        if let Some(penalty_kick) = self.decisions.game.penalty_kick() {
            self.put_keeper_on_its_line(penalty_kick.team);
            let ball_m = self.put_ball(penalty_kick.ball_m);
            self.decisions.game.set_play = Some(SetPlay { ball_m, ..penalty_kick });
        } else {
            self.put_ball(Vec2::ZERO);
        }
        self.enter(GameState::Set);
    }

    /// Places a robot at its position in the formation for the other team's kick-off, which is legal but less favourable.
    fn place_by_hand(&mut self, index: usize, evidence: Evidence) {
        let snapshot = self.now();
        let robot = &snapshot.robots[index];
        let own_end = snapshot.game.own_end(robot.id.team);
        let wanted =
            formation(snapshot.pitch, snapshot.rules.team_size, snapshot.game.role_number(robot.id), own_end, false);
        let pose = Occupied::by_others(&snapshot, Some(index)).free_pose(wanted, &robot.bounds);
        let robot = robot.id;
        self.decisions.robots[index].pose = pose;
        self.memory.robots[index].hand_placements = self.memory.robots[index].hand_placements.saturating_add(1);
        self.decisions.events.push(MatchEvent::PlacedByHand { robot, position_m: pose.position, evidence });
    }

    /// A cycle of `set`.
    pub(super) fn judge_set(&mut self) {
        if self.run_clock() && !self.penalty_kick_goes_on() {
            self.end_half();
            return;
        }
        self.judge_motion();
        self.count_set_play();
        if self.decisions.game.state_cycles >= self.seen.cycles(self.seen.rules.set_s) {
            self.begin_play();
        }
    }

    /// Begins play with the whistle after `set`.
    pub(super) fn begin_play(&mut self) {
        if self.decisions.game.shoot_out.is_some() {
            self.whistle();
        } else if let Some(penalty_kick) = self.decisions.game.penalty_kick() {
            self.begin_penalty_shot(penalty_kick);
        } else {
            self.bring_ball_into_play();
        }
        self.enter(GameState::Playing);
    }

    /// Begins play with a drop ball that has been placed.
    pub(super) fn drop_ball(&mut self) {
        self.decisions.game.drop_ball = true;
        self.bring_ball_into_play();
        if self.decisions.game.state != GameState::Playing {
            self.enter(GameState::Playing);
        }
    }

    /// Takes back the restart that began in this cycle, as the half is over.
    pub(super) fn call_off_restart(&mut self) {
        let is_restart = |event: &MatchEvent| matches!(event, MatchEvent::FreeKick { .. } | MatchEvent::ThrowIn { .. });
        if self.decisions.events.iter().any(is_restart) {
            self.decisions.events.retain(|event| !is_restart(event));
            (self.decisions.game.stop, self.decisions.game.set_play, self.decisions.ball) = (None, None, None);
        }
    }

    /// Begins a free kick; play continues. A `place` beyond the lines is moved onto them.
    pub(super) fn begin_free_kick(&mut self, kind: SetPlayKind, team: Team, place: Vec2) {
        let place = self.seen.pitch.within_lines(place);
        let place = match kind {
            SetPlayKind::IndirectFreeKick => set_play::indirect_free_kick_place(self.seen, team, place),
            _ => place,
        };
        let place = self.put_ball(place);
        self.memory.kick_off = None;
        self.memory.plays = Plays::after(kind, team);
        self.memory.stuck.cycles = 0;
        for record in &mut self.memory.robots {
            (record.cycles_encroaching, record.has_kept_away) = (0, false);
        }
        let cycles = self.seen.cycles(self.seen.rules.free_kick_s);
        self.decisions.game.set_play = Some(SetPlay::new(kind, team, place, cycles));
        self.decisions.events.push(MatchEvent::FreeKick { set_play: kind, team, position_m: place });
        let stop_cycles = self.seen.cycles(self.seen.rules.free_kick_stop_s);
        if stop_cycles > 0 {
            self.stop(Some(stop_cycles));
        }
    }

    /// Penalises a robot that takes the kick-off in place of the one that must take it; the ball is put back. Returns whether this
    /// happened.
    fn judge_kick_off_player(&mut self, set_play: &SetPlay) -> bool {
        let Some(player) = self.memory.kick_off_player.filter(|_| !set_play.touched) else { return false };
        let mut touches = self.seen.touches.iter().map(|(robot, _)| *robot);
        let Some(toucher) = touches.find(|robot| robot.team == set_play.team) else { return false };
        let is_there = |id| self.seen.robot_index(id).filter(|index| self.decisions.robots[*index].is_present());
        let (Some(index), Some(_)) = (is_there(toucher), is_there(player)) else { return false };
        if toucher == player {
            return false;
        }
        let rule = "A robot that begins a kick-off outside its own half must take it itself.";
        let evidence = self.seen.evidence_against(rule, &self.seen.robots[index]);
        self.penalise(index, PenaltyReason::IllegalPosition, evidence.otherwise(format!("{player} had to take it.")));
        self.put_ball(set_play.ball_m);
        self.decisions.game.set_play = Some(set_play.later(true));
        true
    }

    /// Advances the free kick under way.
    pub(super) fn follow_set_play(&mut self) {
        let Some(set_play) = self.seen.game.set_play else { return };
        if set_play.kind == SetPlayKind::KickOff && self.judge_kick_off_player(&set_play) {
            return;
        }
        let course = set_play::advance(set_play, self.seen);
        self.decisions.game.set_play = match course {
            Course::Waiting(next) | Course::BallBack(next) => Some(next),
            Course::Taken | Course::TimeOver => None,
        };
        match course {
            Course::Waiting(_) => {}
            Course::BallBack(next) => {
                self.put_ball(next.ball_m);
            }
            Course::Taken => self.decisions.events.push(MatchEvent::FreeKickOver { team: set_play.team, taken: true }),
            Course::TimeOver => {
                match set_play.kind {
                    SetPlayKind::KickOff => {}
                    SetPlayKind::PenaltyKick => self.memory.plays = Plays::default(),
                    _ => self.memory.plays = Plays::direct_for(set_play.team.opponent()),
                }
                self.decisions.events.push(MatchEvent::FreeKickOver { team: set_play.team, taken: false });
            }
        }
    }
}
