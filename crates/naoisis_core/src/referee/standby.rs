//! `standby` before the first `ready` of a half (2025 rule book, section 3.2): robots stand and wait for the referee to raise its arms at a
//! random time.

use bevy::prelude::*;

use super::decide::Referee;
use super::memory::RefereeMemory;
use crate::cycle::CycleClock;
use crate::game::{GameState, Rules};

impl RefereeMemory {
    /// Draws the duration of the next `standby`.
    pub(super) fn draw_standby(&mut self, rules: &Rules, clock: &CycleClock) {
        let random_s = match &mut self.coin {
            Some(coin) if rules.standby_random_s > 0.0 => coin.uniform() * rules.standby_random_s,
            _ => 0.0,
        };
        self.standby_cycles = u64::from(clock.cycles_in(rules.standby_s + random_s));
    }
}

impl Referee<'_, '_> {
    /// Begins `standby`.
    pub(super) fn begin_standby(&mut self) {
        self.memory.draw_standby(self.seen.rules, &self.seen.clock);
        self.put_ball(Vec2::ZERO);
        self.enter(GameState::Standby);
    }

    /// A cycle of `standby`.
    pub(super) fn judge_standby(&mut self) {
        self.judge_motion();
        if self.decisions.game.state_cycles >= self.memory.standby_cycles {
            self.signal_ready();
        }
    }

    /// Ends `standby`: the referee raises its arms, and robots may walk to their positions.
    pub(super) fn signal_ready(&mut self) {
        self.decisions.game.ready_signals = self.decisions.game.ready_signals.saturating_add(1);
        self.enter(GameState::Ready);
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::game::{Intervention, KickOffProcedure, PenaltyReason};
    use crate::random::RandomStream;
    use crate::team::{RobotId, Team};

    /// A match whose second half begins in the next cycle, with half a second of `standby`. Robots are informed of its end a second late.
    fn half_time() -> MatchFixture {
        let mut situation = MatchFixture::three_a_side();
        situation.rules.kick_off = KickOffProcedure::ReadyAndSet;
        (situation.rules.standby_s, situation.rules.ready_delay_s) = (0.5, 1.0);
        situation.rules.end_ready_early = false;
        situation.game.cycles_left = Some(1);
        situation
    }

    fn told(situation: &MatchFixture) -> GameState {
        situation.memory.announcement.announced(&situation.game).state
    }

    /// The number of cycles from now on until `is_so` holds.
    fn cycles_until(situation: &mut MatchFixture, is_so: impl Fn(&MatchFixture) -> bool) -> usize {
        (1..200)
            .find(|_| {
                situation.pass();
                is_so(situation)
            })
            .unwrap()
    }

    #[test]
    fn robots_see_the_signal_at_once_and_are_told_of_it_late() {
        let mut situation = half_time();
        situation.pass();
        assert_eq!((situation.game.state, told(&situation)), (GameState::Standby, GameState::Standby));
        assert_eq!(situation.game.kick_off(), Some(Team::Pink));
        assert_eq!(cycles_until(&mut situation, |now| now.game.ready_signals == 1), 15);
        assert_eq!((situation.game.state, told(&situation)), (GameState::Ready, GameState::Standby));
        assert_eq!(cycles_until(&mut situation, |now| told(now) == GameState::Ready), 30);
        // The half is counted from its first kick-off.
        assert_eq!(situation.game.cycles_left, Some(18_000));
    }

    #[test]
    fn a_penalty_that_cannot_be_in_standby_tells_of_ready() {
        let mut situation = half_time();
        situation.pass();
        situation.interventions = vec![Intervention::Whistle];
        situation.pass();
        assert_eq!((situation.game.state, told(&situation)), (GameState::Ready, GameState::Standby));
        let robot = RobotId::new(Team::Blue, 2);
        let reason = PenaltyReason::Pushing;
        situation.interventions = vec![Intervention::Penalise { robot, reason, duration_s: None }];
        situation.pass();
        assert_eq!(told(&situation), GameState::Ready);
    }

    #[test]
    fn how_long_it_lasts_is_drawn_within_limits() {
        let (rules, clock) = (Rules { standby_s: 10.0, standby_random_s: 110.0, ..Rules::default() }, default());
        let drawn: Vec<u64> = (0..50)
            .map(|seed| {
                let coin = Some(RandomStream::for_match(seed, "coin"));
                let mut memory = RefereeMemory { coin, ..default() };
                memory.draw_standby(&rules, &clock);
                memory.standby_cycles
            })
            .collect();
        assert!(drawn.iter().all(|cycles| (300..=3600).contains(cycles)), "{drawn:?}");
        assert!(drawn.iter().any(|cycles| *cycles < 1000) && drawn.iter().any(|cycles| *cycles > 2900), "{drawn:?}");
    }
}
