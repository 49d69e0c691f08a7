//! Applies the decisions of a [referee outside the match](OutsideReferee): goals, outs, fouls and restarts. The ball is placed at the
//! position from which a free kick of that kind is taken.

use bevy::prelude::*;

use super::areas::penalty_mark;
use super::decide::Referee;
use super::goal;
use super::penalty_kick;
use super::set_play;
use crate::events::MatchEvent;
use crate::game::{GameState, OutsideReferee, SetPlay, SetPlayKind, Timeout};
use crate::team::Team;

/// The rule in the evidence of decisions from outside.
const RULE: &str = "A referee outside the match decides.";

impl Referee<'_, '_> {
    /// Applies the decisions of a cycle.
    pub(super) fn apply_outside(&mut self, outside: &OutsideReferee) {
        self.memory.plays.advance(self.seen);
        self.apply_half(outside);
        self.apply_score(outside);
        self.apply_penalties(outside);
        self.apply_state(outside);
        let cycles_left = self.seen.cycles(outside.secondary_time_left_s.max(0.0));
        let timeout = Timeout { team: None, cycles_left, before_shoot_out: false };
        self.decisions.game.timeout = (outside.state == GameState::Timeout).then_some(timeout);
        match (outside.is_stopped, self.decisions.game.stop) {
            (true, None) => self.stop(None),
            (false, Some(stop)) => {
                self.decisions.game.stop = None;
                self.resume(stop);
            }
            _ => {}
        }
        if self.decisions.game.state == GameState::Playing {
            self.apply_set_play(outside);
        }
        self.decisions.game.cycles_left = Some(self.seen.cycles(outside.time_left_s.max(0.0)));
    }

    fn apply_half(&mut self, outside: &OutsideReferee) {
        let game = &mut self.decisions.game;
        if game.half != outside.half {
            game.half = outside.half;
            self.decisions.events.push(MatchEvent::HalfBegins { half: outside.half });
        }
        let game = &mut self.decisions.game;
        if game.blue_end != outside.blue_end {
            // In the break the robots are carried to their new half.
            game.blue_end = outside.blue_end;
            self.place_for_kick_off(outside.kicking_team);
        }
    }

    fn apply_score(&mut self, outside: &OutsideReferee) {
        let before = core::mem::replace(&mut self.decisions.game.score, outside.score);
        for team in Team::BOTH {
            for _ in before[team]..outside.score[team] {
                let last_touch = self.seen.last_touch.map(|touch| touch.robot);
                let scorer = goal::scorer(team, last_touch, self.memory.plays.shot);
                let own_goal = scorer.is_some_and(|robot| robot.team != team);
                let place = self.seen.ball.map_or(Vec2::ZERO, |ball| ball.position);
                let evidence = self.seen.evidence(RULE, place);
                self.decisions.events.push(MatchEvent::Goal { team, scorer, own_goal, evidence });
            }
        }
    }

    fn apply_penalties(&mut self, outside: &OutsideReferee) {
        for index in 0..self.decisions.robots.len() {
            let id = self.decisions.robots[index].id;
            let wanted = outside.penalties.iter().find(|(robot, ..)| *robot == id);
            let serves = self.decisions.robots[index].penalty.0.is_some();
            match wanted {
                Some((_, reason, seconds)) if !serves => {
                    let evidence = self.seen.evidence_against(RULE, &self.seen.robots[index]);
                    self.remove(index, *reason, self.seen.cycles(seconds.max(0.0)), evidence);
                }
                Some((_, _, seconds)) => {
                    if let Some(penalty) = &mut self.decisions.robots[index].penalty.0 {
                        // The penalty ends by decision, not by time.
                        penalty.cycles_left = self.seen.cycles(seconds.max(0.0)).max(1);
                    }
                }
                None if serves => self.bring_back(index),
                None => {}
            }
        }
    }

    fn apply_state(&mut self, outside: &OutsideReferee) {
        if self.decisions.game.state == outside.state {
            return;
        }
        let penalty_kick = outside.kicking_team.filter(|_| outside.set_play == Some(SetPlayKind::PenaltyKick));
        match outside.state {
            GameState::Ready => match penalty_kick {
                Some(team) => self.begin_penalty_kick(team),
                None => {
                    let is_signal = self.decisions.game.state == GameState::Standby;
                    self.decisions.game.ready_signals =
                        self.decisions.game.ready_signals.saturating_add(u32::from(is_signal));
                    self.prepare_kick_off(outside.kicking_team);
                }
            },
            GameState::Set => {
                let mark = |team| penalty_mark(self.seen.pitch, penalty_kick::end(self.seen, team));
                self.put_ball(penalty_kick.map_or(Vec2::ZERO, mark));
                self.enter(GameState::Set);
            }
            GameState::Playing => self.begin_play(),
            GameState::Finished => self.finish(),
            GameState::Initial | GameState::Standby | GameState::Timeout => {
                self.decisions.game.set_play = None;
                self.enter(outside.state);
            }
        }
    }

    fn apply_set_play(&mut self, outside: &OutsideReferee) {
        let left = self.seen.cycles(outside.secondary_time_left_s.max(0.0));
        match (self.decisions.game.set_play, outside.set_play.zip(outside.kicking_team)) {
            (Some(under_way), Some((kind, team))) if (under_way.kind, under_way.team) == (kind, team) => {
                self.decisions.game.set_play = Some(SetPlay { cycles_left: left, ..under_way.later(true) });
            }
            (_, Some((kind, team))) => self.begin_free_kick(kind, team, self.place_of(kind, team)),
            // A kick-off is not announced as a set play.
            (Some(under_way), None) if under_way.kind == SetPlayKind::KickOff => self.follow_set_play(),
            (Some(under_way), None) if outside.set_play.is_none() => {
                self.decisions.game.set_play = None;
                self.decisions.events.push(MatchEvent::FreeKickOver { team: under_way.team, taken: true });
            }
            // The kicking team is not known yet.
            (_, None) => {}
        }
    }

    /// The position of a free kick of `team`, given the position of the ball.
    fn place_of(&self, kind: SetPlayKind, team: Team) -> Vec2 {
        let pitch = self.seen.pitch;
        let corner = Vec2::new(pitch.half_length(), pitch.half_width());
        let ball = self.seen.ball.map_or(Vec2::ZERO, |ball| ball.position).clamp(-corner, corner);
        let side = if ball.y < 0.0 { -1.0 } else { 1.0 };
        match kind {
            SetPlayKind::KickOff => Vec2::ZERO,
            SetPlayKind::KickIn => Vec2::new(ball.x, side * corner.y),
            SetPlayKind::GoalKick => set_play::goal_kick_place(self.seen, team, ball.y),
            SetPlayKind::CornerKick => {
                set_play::corner(self.seen, self.decisions.game.own_end(team.opponent()), ball.y)
            }
            SetPlayKind::PushingFreeKick | SetPlayKind::IndirectFreeKick => ball,
            SetPlayKind::PenaltyKick => penalty_mark(pitch, penalty_kick::end(self.seen, team)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::game::{PenaltyReason, Score};
    use crate::pitch::End;
    use crate::team::RobotId;

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);

    /// A match in play, with a referee outside the match whose decisions agree with its state.
    fn with_outside_referee() -> (MatchFixture, OutsideReferee) {
        let outside = OutsideReferee { state: GameState::Playing, half: 1, time_left_s: 300.0, ..default() };
        let fixture = MatchFixture { outside: Some(outside.clone()), ..MatchFixture::three_a_side() };
        (fixture, outside)
    }

    #[test]
    fn nothing_is_judged_but_by_the_referee_outside() {
        let (fixture, outside) = with_outside_referee();
        let mut fixture = fixture.touched_by(BLUE2).ball_rolled([2.9, 0.0], [3.2, 0.0]);
        let decided = fixture.decide();
        assert_eq!((decided.events.len(), decided.game.score.blue), (0, 0));
        assert_eq!(decided.game.cycles_left, Some(9000));
        fixture.outside = Some(OutsideReferee { score: Score { blue: 1, pink: 0 }, ..outside });
        let decided = fixture.decide();
        assert_eq!(decided.game.score.blue, 1);
        assert!(matches!(decided.events[..], [MatchEvent::Goal { team: Team::Blue, scorer: Some(BLUE2), .. }]));
    }

    #[test]
    fn a_robot_is_off_the_pitch_for_as_long_as_the_referee_outside_says() {
        let (mut fixture, outside) = with_outside_referee();
        fixture.outside =
            Some(OutsideReferee { penalties: vec![(BLUE2, PenaltyReason::Pushing, 0.0)], ..outside.clone() });
        for _ in 0..100 {
            fixture.pass();
            assert!(!fixture.robots[1].is_present());
        }
        fixture.outside = Some(outside);
        assert!(fixture.pass().robots[1].is_present());
    }

    #[test]
    fn a_kick_off_is_whistled_from_outside() {
        let (mut fixture, outside) = with_outside_referee();
        let kicking_team = Some(Team::Pink);
        for (state, whistles) in [(GameState::Ready, 1), (GameState::Set, 1), (GameState::Playing, 2)] {
            fixture.outside = Some(OutsideReferee { state, kicking_team, ..outside.clone() });
            fixture.pass();
            assert_eq!((fixture.game.state, fixture.game.whistles), (state, whistles));
            for _ in 0..50 {
                assert_eq!(fixture.pass().game.state, state);
            }
        }
        assert_eq!((fixture.game.kick_off(), fixture.path[0]), (kicking_team, Vec2::ZERO));
    }

    #[test]
    fn the_ball_of_a_free_kick_is_put_where_it_is_taken() {
        let place = |kind, team| {
            let (fixture, outside) = with_outside_referee();
            let (set_play, kicking_team) = (Some(kind), Some(team));
            let outside = Some(OutsideReferee { set_play, kicking_team, secondary_time_left_s: 30.0, ..outside });
            let fixture = MatchFixture { outside, ..fixture }.ball_rolled([3.3, 1.0], [3.4, 1.0]);
            let decided = fixture.decide();
            assert_eq!(decided.game.set_play.map(|set_play| (set_play.kind, set_play.team)), Some((kind, team)));
            decided.ball.unwrap().to_array()
        };
        assert_eq!(place(SetPlayKind::CornerKick, Team::Blue), [3.0, 2.0]);
        assert_eq!(place(SetPlayKind::KickIn, Team::Blue), [3.0, 2.0]);
        let [x, y] = place(SetPlayKind::GoalKick, Team::Pink);
        assert!(x > 2.0 && x < 3.0 && y > 0.0, "{x}, {y}");
        let over = MatchFixture { outside: Some(with_outside_referee().1), ..with_outside_referee().0 };
        assert_eq!(over.decide().game.set_play, None);
    }

    #[test]
    fn a_time_out_from_outside_stands_until_it_is_over() {
        let (mut fixture, outside) = with_outside_referee();
        let (state, secondary_time_left_s) = (GameState::Timeout, 10.0);
        fixture.outside = Some(OutsideReferee { state, secondary_time_left_s, ..outside.clone() });
        fixture.pass();
        let left = fixture.game.timeout.map(|timeout| timeout.cycles_left);
        assert_eq!((fixture.game.state, left), (GameState::Timeout, Some(300)));
        fixture.outside = Some(OutsideReferee { state: GameState::Ready, ..outside });
        fixture.pass();
        assert_eq!((fixture.game.state, fixture.game.timeout), (GameState::Ready, None));
    }

    #[test]
    fn in_the_second_half_the_robots_are_carried_over() {
        let (mut fixture, outside) = with_outside_referee();
        let (state, half, blue_end) = (GameState::Initial, 2, End::PositiveX);
        fixture.outside = Some(OutsideReferee { state, half, blue_end, ..outside });
        let decided = fixture.pass();
        assert!(decided.robots[0].pose.position.x > 2.0);
        assert!(decided.events.contains(&MatchEvent::HalfBegins { half: 2 }));
    }
}
