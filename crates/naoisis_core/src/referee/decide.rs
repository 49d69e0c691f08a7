//! The judgement of a cycle, as a plain function from a [`MatchSnapshot`] to [`Decisions`].

use bevy::prelude::*;

use super::ball_stop::attack_goes_on;
use super::custom_rules::CustomRules;
use super::game_stuck::{Progress, Remedy, Stuck};
use super::indirect_goal::judge_double_touch;
use super::memory::RefereeMemory;
use super::positions::is_off_pitch;
use super::robot_rules::{self, RobotCase};
use super::set_play;
use super::snapshot::{BallSnapshot, MatchSnapshot, RobotSnapshot};
use super::{ball_holding, collision, game_stuck, illegal_defender, inactive, leaving_field, obstruction, stalling};
use crate::events::MatchEvent;
use crate::game::{Game, GameState, PenaltyReason, SetPlayKind};
use crate::team::{RobotId, Team};

/// The decisions of the referee in a cycle.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Decisions {
    /// The state of the match from now on.
    pub game: Game,
    /// The events to announce.
    pub events: Vec<MatchEvent>,
    /// Position at which the ball is placed, m; `None` if it is not placed.
    pub ball: Option<Vec2>,
    /// Velocity of the ball if it is placed, m/s: zero except for interventions.
    pub ball_velocity: Vec2,
    /// The robots that were moved aside for the ball, and keep their posture.
    pub moved_aside: Vec<RobotId>,
    /// All robots as in the snapshot, with the new poses of those that are placed, and new penalties.
    pub robots: Vec<RobotSnapshot>,
}

/// Judges a cycle. `memory` is kept from cycle to cycle; `decisions` is overwritten.
pub fn decide(
    snapshot: &MatchSnapshot,
    custom_rules: &CustomRules,
    memory: &mut RefereeMemory,
    decisions: &mut Decisions,
) {
    memory.match_robots(snapshot.robots);
    memory.note_touches(snapshot);
    decisions.game.clone_from(snapshot.game);
    decisions.robots.clear();
    decisions.robots.extend_from_slice(snapshot.robots);
    decisions.events.clear();
    decisions.moved_aside.clear();
    decisions.ball = None;
    decisions.ball_velocity = Vec2::ZERO;
    decisions.game.state_cycles += u64::from(snapshot.game.stop.is_none());
    let seen = MatchSnapshot { last_touch: memory.last_touch, ..*snapshot };
    let mut referee = Referee { seen: &seen, custom_rules, memory, decisions };
    referee.count_messages();
    match snapshot.outside {
        Some(outside) => referee.apply_outside(outside),
        None => referee.judge(),
    }
    referee.intervene();
    referee.grant_requests();
    referee.note_robots();
    memory.announcement.advance(snapshot, &decisions.game, &decisions.events);
}

/// The referee at work in one cycle.
pub(super) struct Referee<'a, 'b> {
    /// The match at the end of the cycle.
    pub(super) seen: &'a MatchSnapshot<'a>,
    custom_rules: &'a CustomRules,
    pub(super) memory: &'b mut RefereeMemory,
    pub(super) decisions: &'b mut Decisions,
}

/// The reason for stopping play.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Stoppage {
    /// For a kick-off of this team, or a drop ball.
    KickOff(Option<Team>),
    /// The match ends because of a team's lead.
    Mercy,
}

impl Referee<'_, '_> {
    /// The snapshot with the decisions of this cycle so far.
    pub(super) fn now(&self) -> MatchSnapshot<'_> {
        let placed = |ball: BallSnapshot<'_>| self.decisions.ball.unwrap_or(ball.position);
        let ball = self.seen.ball.map(|ball| BallSnapshot { position: placed(ball), ..ball });
        MatchSnapshot { game: &self.decisions.game, robots: &self.decisions.robots, ball, ..*self.seen }
    }

    fn judge(&mut self) {
        if let Some(stop) = &mut self.decisions.game.stop {
            stop.cycles += 1;
            let is_over = stop.duration_cycles.is_some_and(|duration| stop.cycles >= duration);
            self.judge_motion();
            if let Some(stop) = self.decisions.game.stop.take_if(|_| is_over) {
                self.resume(stop);
            }
            return;
        }
        match self.seen.game.state {
            GameState::Finished => {}
            GameState::Initial => self.follow_initial(),
            GameState::Standby => self.judge_standby(),
            GameState::Ready => self.judge_ready(),
            GameState::Set => self.judge_set(),
            GameState::Timeout => self.follow_timeout(),
            GameState::Playing => match self.seen.game.shoot_out {
                Some(shoot_out) => self.follow_shot(shoot_out),
                None => self.judge_play(),
            },
        }
    }

    fn judge_play(&mut self) {
        self.count_penalties();
        if let Some(kick_off) = &mut self.memory.kick_off {
            kick_off.advance(self.seen);
        }
        let double_touch = judge_double_touch(self.seen, &self.memory.plays).filter(|_| !self.ball_leaves_play());
        self.memory.plays.advance(self.seen);
        self.follow_set_play();
        if let (Some((robot, evidence)), Some(ball)) = (double_touch, self.seen.ball) {
            self.decisions.events.push(MatchEvent::DoubleTouch { robot, evidence });
            self.begin_free_kick(SetPlayKind::IndirectFreeKick, robot.team.opponent(), ball.position);
        }
        self.judge_collisions();
        self.judge_robots();
        let stoppage = self.judge_keepers_line().or_else(|| self.judge_ball()).or_else(|| self.judge_stuck());
        let stopped = stoppage.is_some() || self.decisions.ball.is_some();
        let goes_on = self.penalty_kick_goes_on() || !stopped && attack_goes_on(self.seen);
        let half_is_over = self.run_clock() && !goes_on;
        if half_is_over {
            self.call_off_restart();
        }
        match stoppage {
            Some(Stoppage::Mercy) => self.end_match(),
            _ if half_is_over => self.end_half(),
            Some(Stoppage::KickOff(team)) => self.begin_kick_off(team),
            None => {}
        }
    }

    pub(super) fn judge_collisions(&mut self) {
        if !self.seen.rules.collisions {
            return;
        }
        for (index, record) in self.memory.robots.iter_mut().enumerate() {
            record.note_contact(self.seen, index);
        }
        for &[a, b] in self.seen.contacts {
            let ids = [a, b].map(|index| self.seen.robots[index].id);
            let lasted = |one: usize, other: RobotId| {
                self.memory.robots[one].contact.filter(|(with, _)| *with == other).map_or(0, |(_, cycles)| cycles)
            };
            let [first, second] = collision::responsible(self.seen, [a, b], lasted(a, ids[1]).max(lasted(b, ids[0])));
            let pair = [a, b];
            if first {
                self.penalise_push(pair[0], pair[1], second);
            }
            if second {
                self.penalise_push(pair[1], pair[0], first);
            }
        }
    }

    /// The rules about single robots: all in play, and in `ready` those that apply then.
    pub(super) fn judge_robots(&mut self) {
        for (index, (record, robot)) in self.memory.robots.iter_mut().zip(self.seen.robots).enumerate() {
            if !robot.is_present() {
                continue;
            }
            record.stall = stalling::advance(record.stall, self.seen, robot);
            record.cycles_holding = ball_holding::advance(record.cycles_holding, self.seen, robot);
            record.cycles_in_goal = leaving_field::advance(record.cycles_in_goal, self.seen, robot);
            record.cycles_in_area = illegal_defender::advance(record.cycles_in_area, self.seen, robot);
            record.cycles_obstructing = obstruction::advance(record.cycles_obstructing, self.seen, robot);
            record.cycles_inactive = inactive::advance(record.cycles_inactive, record.head, self.seen, robot);
            record.get_up = record.get_up.advance(self.seen, index, robot);
            match &self.seen.game.set_play {
                Some(set_play) => set_play::note_encroachment(record, set_play, self.seen, robot),
                None => (record.cycles_encroaching, record.has_kept_away) = (0, false),
            }
            self.custom_rules.advance(&mut record.own_cycles, self.seen, robot);
        }
        for index in 0..self.decisions.robots.len() {
            let case = RobotCase { seen: self.seen, records: &self.memory.robots, index };
            let custom_rules =
                || self.custom_rules.judge(&self.memory.robots[index].own_cycles, self.seen, case.robot());
            if self.decisions.robots[index].is_present()
                && case.robot().is_present()
                && let Some((reason, evidence)) = robot_rules::judge(&case).or_else(custom_rules)
            {
                self.penalise(index, reason, evidence);
                self.restart_after_offence(index, reason);
                if let (PenaltyReason::BallHolding, Some(ball), None) = (reason, self.seen.ball, self.decisions.ball)
                    && !self.ball_leaves_play()
                {
                    self.put_ball(ball.position);
                }
            }
        }
    }

    fn judge_stuck(&mut self) -> Option<Stoppage> {
        if !self.seen.rules.game_stuck {
            return None;
        }
        self.memory.stuck = game_stuck::advance(self.memory.stuck, self.seen);
        if self.seen.rules.walking_is_progress {
            self.note_progress();
        }
        // A ball that has just been placed, or that belongs to one team, is not stuck.
        if self.decisions.ball.is_some() || self.decisions.game.set_play.is_some() {
            (self.memory.stuck.cycles, self.memory.stuck.alone) = (0, 0);
            return None;
        }
        match game_stuck::judge(&self.memory.stuck, self.seen)? {
            Remedy::Local(index, evidence) => {
                self.memory.stuck.cycles = 0;
                // A robot that was just penalised has already been removed.
                if self.decisions.robots[index].is_present() {
                    self.take_from_ball(index, evidence);
                }
                None
            }
            Remedy::Global(evidence) => {
                let half = self.memory.stuck.ball.x;
                let end = if half > 0.0 { crate::pitch::End::PositiveX } else { crate::pitch::End::NegativeX };
                self.decisions.events.push(MatchEvent::GameStuck { robot: None, evidence });
                let drop_ball = self.seen.rules.stuck_robot_is_penalised;
                Some(Stoppage::KickOff((!drop_ball).then(|| self.seen.game.defender_of(end))))
            }
        }
    }

    /// Restarts the time of a stuck ball if a robot makes progress.
    fn note_progress(&mut self) {
        for (record, robot) in self.memory.robots.iter_mut().zip(self.seen.robots) {
            let before = record.progress.filter(|_| self.memory.stuck.cycles > 1);
            let (progress, gets_on) = Progress::advance(before, self.seen, robot);
            record.progress = progress;
            if gets_on {
                let Stuck { cycles, at_ball, .. } = &mut self.memory.stuck;
                (*cycles, *at_ball) = (1, (*at_ball).min(1));
            }
        }
    }

    /// Remembers the head angles, and which robots are returning to the pitch.
    fn note_robots(&mut self) {
        for (record, robot) in self.memory.robots.iter_mut().zip(self.seen.robots) {
            record.head = robot.head;
            record.returns &= is_off_pitch(self.seen, robot) || !robot.is_present();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::game::Rules;

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
    const PINK2: RobotId = RobotId::new(Team::Pink, 2);

    #[test]
    fn sides_change_at_half_time_and_the_match_ends_after_the_last_half() {
        let mut situation = MatchFixture::three_a_side();
        situation.game.cycles_left = Some(1);
        let decided = situation.decide();
        assert_eq!(decided.events, [MatchEvent::HalfBegins { half: 2 }, MatchEvent::KickOff { team: Team::Pink }]);
        // 600 s of 1/30 s.
        assert_eq!(decided.game.cycles_left, Some(18_000));
        assert_eq!(decided.game.own_end(Team::Blue), crate::pitch::End::PositiveX);
        // Blue's keeper is now at +x.
        assert!(decided.robots[0].pose.position.x > 2.0);
        situation.game = decided.game;
        situation.game.cycles_left = Some(1);
        let decided = situation.decide();
        assert_eq!(
            (decided.events.as_slice(), decided.game.state),
            (&[MatchEvent::FinalWhistle][..], GameState::Finished)
        );
        situation.game = decided.game;
        assert_eq!(situation.touched_by(BLUE2).ball_rolled([2.9, 0.0], [3.2, 0.0]).decide().events, []);
    }

    #[test]
    fn a_goal_in_the_last_cycle_counts() {
        let mut situation = MatchFixture::three_a_side().touched_by(PINK2).ball_rolled([-2.9, 0.0], [-3.2, 0.0]);
        situation.game.half = 2;
        situation.game.cycles_left = Some(1);
        let decided = situation.decide();
        assert_eq!((decided.game.score.pink, decided.game.state), (1, GameState::Finished));
        assert_eq!(decided.ball, None);
    }

    #[test]
    fn without_a_referee_nothing_is_repositioned() {
        let mut situation = MatchFixture::three_a_side().ball_rolled([2.9, 0.0], [3.2, 0.0]);
        situation.rules = Rules { goals: false, ball_out: false, clock: false, ..Rules::default() };
        situation.game = Game::at_start(&situation.rules, &situation.clock);
        assert_eq!((situation.game.state, situation.game.cycles_left), (GameState::Playing, None));
        let decided = situation.decide();
        assert_eq!((decided.events.len(), decided.ball, &decided.robots), (0, None, &situation.robots));
    }
}
