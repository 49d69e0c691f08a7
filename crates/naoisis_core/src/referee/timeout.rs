//! Time-outs (2010 rule book, section 3.12; 2025: 3.13 and 3.14; HSL 2026, time-out). A team requests one at any time and takes it in the
//! next stoppage of play; the referee takes one at once. The clock is set back to the start of the stoppage, penalties are over, and robots
//! are placed for the kick-off and stand until the time-out ends. A team's time-out is followed by a kick-off of the other team; a
//! referee's by the kick-off that was due, or a drop ball.

use super::decide::Referee;
use crate::events::MatchEvent;
use crate::game::{GameState, KickOffProcedure, SetPlayKind, Timeout};
use crate::team::Team;

impl Referee<'_, '_> {
    /// Records that a team requests a time-out, or begins one of the referee.
    ///
    /// # Errors
    /// The reason why there is no time-out.
    pub(super) fn call_timeout(&mut self, team: Option<Team>, duration_s: Option<f32>) -> Result<(), String> {
        self.require_own_referee()?;
        self.require_no_shoot_out()?;
        let rules = self.seen.rules;
        let longest_s = if team.is_some() { rules.timeout_s } else { rules.referee_timeout_s };
        let duration_s = duration_s.unwrap_or(longest_s);
        // NaN is not a valid duration either.
        if !(0.0..=longest_s).contains(&duration_s) {
            return Err(format!("a time-out lasts {longest_s} s at most"));
        }
        let game = &self.decisions.game;
        match (game.state, team) {
            (GameState::Finished, _) | (GameState::Initial, None) => Err("there is no match to interrupt".to_owned()),
            (_, Some(team)) if game.timeouts_left[team] == 0 => Err(format!("{team} has no time-outs left")),
            (_, Some(team)) => {
                self.memory.timeout_requests[team] = Some(self.seen.cycles(duration_s));
                Ok(())
            }
            (_, None) => {
                self.begin_timeout(None, self.seen.cycles(duration_s), false);
                Ok(())
            }
        }
    }

    /// Checks that no referee outside the match decides.
    pub(super) fn require_own_referee(&self) -> Result<(), String> {
        match self.seen.outside {
            Some(_) => Err("a referee outside the match decides".to_owned()),
            None => Ok(()),
        }
    }

    /// Begins the requested time-outs and makes the requested substitutions, if the rules allow them now.
    pub(super) fn grant_requests(&mut self) {
        if self.is_stoppage() && self.decisions.game.penalty_kick().is_none() {
            for team in Team::BOTH {
                if let Some(cycles) = self.memory.timeout_requests[team].take() {
                    self.begin_timeout(Some(team), cycles, false);
                }
            }
        }
        self.make_substitutions();
    }

    /// Whether play is stopped for more than a free kick.
    pub(super) fn is_stoppage(&self) -> bool {
        let game = &self.decisions.game;
        let is_restarted = game.restarts != self.seen.game.restarts;
        let waits = matches!(game.state, GameState::Standby | GameState::Ready | GameState::Set | GameState::Timeout);
        (waits || is_restarted) && game.stop.is_none() && game.shoot_out.is_none() && game.state != GameState::Finished
    }

    /// Begins the time-out that a team has requested, before a shoot-out. Returns whether there is one.
    pub(super) fn begin_timeout_before_shoot_out(&mut self) -> bool {
        let requests = &mut self.memory.timeout_requests;
        let request = Team::BOTH.into_iter().find_map(|team| requests[team].take().map(|cycles| (team, cycles)));
        if let Some((team, cycles)) = request {
            self.begin_timeout(Some(team), cycles, true);
        }
        request.is_some()
    }

    fn begin_timeout(&mut self, team: Option<Team>, cycles: u64, before_shoot_out: bool) {
        let duration_s = self.seen.seconds(cycles);
        self.decisions.events.push(MatchEvent::Timeout { team, duration_s });
        let game = &mut self.decisions.game;
        if let Some(team) = team {
            game.timeouts_left[team] = game.timeouts_left[team].saturating_sub(1);
        }
        let under_way = game.timeout;
        let cycles_left = cycles + under_way.map_or(0, |timeout| timeout.cycles_left);
        let before_shoot_out = before_shoot_out || under_way.is_some_and(|timeout| timeout.before_shoot_out);
        game.timeout = Some(Timeout { team, cycles_left, before_shoot_out });
        let set_play = game.set_play.take().map(|set_play| set_play.kind);
        let is_due = set_play == Some(SetPlayKind::KickOff) || game.state != GameState::Playing && set_play.is_none();
        match team {
            Some(team) => (game.kick_off_team, game.drop_ball) = (team.opponent(), false),
            None => game.drop_ball |= !is_due,
        }
        game.stop = None;
        if let Some(cycles_left) = self.memory.clock_at_stoppage.take() {
            game.cycles_left = Some(cycles_left);
        }
        if under_way.is_none() {
            self.end_penalties();
            self.place_for_kick_off(self.decisions.game.kick_off());
            self.enter(GameState::Timeout);
        }
    }

    /// A cycle of a time-out.
    pub(super) fn follow_timeout(&mut self) {
        let Some(timeout) = &mut self.decisions.game.timeout else { return };
        timeout.cycles_left = timeout.cycles_left.saturating_sub(1);
        let timeout = *timeout;
        if timeout.cycles_left == 0 {
            self.end_timeout(timeout);
        }
    }

    /// Ends a time-out.
    pub(super) fn end_timeout(&mut self, timeout: Timeout) {
        self.decisions.game.timeout = None;
        let (rules, team) = (self.seen.rules, self.decisions.game.kick_off());
        if timeout.before_shoot_out {
            self.begin_shoot_out();
        } else if rules.kick_off == KickOffProcedure::ReadyAndSet && rules.standby_s > 0.0 {
            self.announce_kick_off(team);
            self.begin_standby();
        } else {
            self.begin_kick_off(team);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::game::Intervention;

    /// A match in play with `ready` and `set`, and one time-out for each team.
    fn with_timeouts() -> MatchFixture {
        let mut situation = MatchFixture::three_a_side();
        (situation.rules.timeouts, situation.rules.timeout_s) = (1, 10.0);
        situation.rules.kick_off = KickOffProcedure::ReadyAndSet;
        situation.rules.clock_runs_in_stoppages = true;
        situation.rules.end_ready_early = false;
        situation.game.timeouts_left = crate::team::PerTeam { blue: 1, pink: 1 };
        situation.game.cycles_left = Some(1000);
        situation
    }

    fn ask(situation: &mut MatchFixture, intervention: Intervention) {
        situation.interventions = vec![intervention];
        situation.pass();
    }

    fn pass(situation: &mut MatchFixture, cycles: usize) {
        (0..cycles).for_each(|_| _ = situation.pass());
    }

    const BLUES: Intervention = Intervention::Timeout { team: Some(Team::Blue), duration_s: None };
    const REFEREES: Intervention = Intervention::Timeout { team: None, duration_s: Some(1.0) };

    #[test]
    fn a_team_waits_for_a_stoppage_and_the_clock_goes_back_to_where_it_began() {
        let mut situation = with_timeouts();
        ask(&mut situation, BLUES);
        assert_eq!((situation.game.state, situation.game.cycles_left), (GameState::Playing, Some(999)));
        // If it is requested in `ready`, it begins at once; the clock has run on.
        let mut asked_late = with_timeouts();
        ask(&mut asked_late, Intervention::KickOff { team: Team::Blue });
        pass(&mut asked_late, 20);
        assert_eq!(asked_late.game.cycles_left, Some(979));
        ask(&mut asked_late, BLUES);
        ask(&mut situation, Intervention::KickOff { team: Team::Blue });
        for (situation, left) in [(situation, 998), (asked_late, 999)] {
            let mut situation = situation;
            assert_eq!((situation.game.state, situation.game.cycles_left), (GameState::Timeout, Some(left)));
            assert_eq!((situation.game.timeouts_left.blue, situation.game.timeouts_left.pink), (0, 1));
            // 10 s of 1/30 s.
            pass(&mut situation, 299);
            assert_eq!((situation.game.state, situation.game.cycles_left), (GameState::Timeout, Some(left)));
            situation.pass();
            assert_eq!((situation.game.state, situation.game.kick_off()), (GameState::Ready, Some(Team::Pink)));
        }
    }

    #[test]
    fn a_team_has_as_many_as_the_rules_say_and_may_end_it_early() {
        let mut situation = with_timeouts();
        situation.game.state = GameState::Set;
        ask(&mut situation, BLUES);
        assert_eq!(situation.game.state, GameState::Timeout);
        ask(&mut situation, Intervention::Resume);
        assert_eq!((situation.game.state, situation.game.timeout), (GameState::Ready, None));
        situation.interventions = vec![BLUES];
        let message = "blue has no time-outs left".to_owned();
        assert!(situation.pass().events.contains(&MatchEvent::InterventionRefused { intervention: BLUES, message }));
        assert_eq!(situation.game.state, GameState::Ready);
    }

    #[test]
    fn a_team_may_request_one_before_the_match_begins() {
        let mut situation = with_timeouts();
        (situation.rules.initial_s, situation.game.state) = (1.0, GameState::Initial);
        ask(&mut situation, BLUES);
        assert_eq!(situation.game.state, GameState::Initial);
        pass(&mut situation, 31);
        assert_eq!((situation.game.state, situation.game.timeouts_left.blue), (GameState::Timeout, 0));
    }

    #[test]
    fn the_referee_stops_play_and_it_goes_on_with_a_drop_ball_or_the_kick_off_that_was_due() {
        for (state, kick_off) in [(GameState::Playing, None), (GameState::Ready, Some(Team::Blue))] {
            let mut situation = with_timeouts();
            situation.game.state = state;
            ask(&mut situation, REFEREES);
            assert_eq!(situation.game.state, GameState::Timeout);
            pass(&mut situation, 30);
            assert_eq!((situation.game.state, situation.game.kick_off()), (GameState::Ready, kick_off));
            assert_eq!(situation.game.timeouts_left.blue, 1);
        }
    }

    #[test]
    fn a_drawn_match_may_have_one_before_its_shoot_out() {
        let mut situation = with_timeouts();
        situation.rules.shoot_out = true;
        (situation.game.half, situation.game.cycles_left) = (2, Some(3));
        ask(&mut situation, BLUES);
        pass(&mut situation, 2);
        assert_eq!((situation.game.state, situation.game.shoot_out), (GameState::Timeout, None));
        pass(&mut situation, 300);
        assert!(situation.game.shoot_out.is_some());
    }

    #[test]
    fn penalties_are_over_in_a_time_out() {
        let mut situation = with_timeouts();
        let robot = situation.robots[1].id;
        let reason = crate::game::PenaltyReason::Pushing;
        ask(&mut situation, Intervention::Penalise { robot, reason, duration_s: None });
        assert!(!situation.robots[1].is_present());
        ask(&mut situation, REFEREES);
        assert!(situation.robots[1].is_present());
    }
}
