//! The message budget of a team: the goals of a team that exceeds it do not count (2025 rule book, section 2.4.2). Messages in
//! `standby`, `ready`, `set` and play count, but not those in a shoot-out.

use super::decide::Referee;
use super::snapshot::MatchSnapshot;
use crate::events::MatchEvent;
use crate::game::{Evidence, GameState};
use crate::team::{PerTeam, Team};

/// Whether messages of this cycle count.
fn counts(snapshot: &MatchSnapshot) -> bool {
    matches!(snapshot.game.state, GameState::Standby | GameState::Ready | GameState::Set | GameState::Playing)
        && snapshot.game.shoot_out.is_none()
}

/// The evidence against a team that has exceeded its `budget` by `too_many` messages.
fn evidence(snapshot: &MatchSnapshot, budget: u32, too_many: u32) -> Evidence {
    snapshot
        .evidence("The goals of a team that sends more messages than it may do not count.", bevy::math::Vec2::ZERO)
        .with_measurement("messages", (budget + too_many) as f32, budget as f32)
        .otherwise("The team had to make do with its messages.")
}

impl Referee<'_, '_> {
    /// Counts the messages of this cycle.
    pub(super) fn count_messages(&mut self) {
        let sent = self.seen.messages_sent;
        let before = core::mem::replace(&mut self.memory.messages_sent, sent);
        let (Some(budget), Some(left)) = (self.seen.rules.message_budget, self.decisions.game.messages_left) else {
            return;
        };
        if !counts(self.seen) {
            return;
        }
        let remaining = |team: Team| i64::from(left[team]) - i64::from(sent[team].saturating_sub(before[team]));
        let still = |team: Team| remaining(team).max(0) as u32;
        self.decisions.game.messages_left = Some(PerTeam { blue: still(Team::Blue), pink: still(Team::Pink) });
        for team in Team::BOTH {
            if remaining(team) < 0 && !self.decisions.game.goals_void[team] {
                self.decisions.game.goals_void[team] = true;
                self.decisions.game.score[team] = 0;
                let evidence = evidence(self.seen, budget, remaining(team).unsigned_abs() as u32);
                self.decisions.events.push(MatchEvent::TooManyMessages { team, evidence });
            }
        }
    }
}
