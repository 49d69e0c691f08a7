//! Whistles and signals of the referee, if the GameController reports goals and the start of play with a delay.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use naoisis_core::game::{GameState, Rules};
use naoisis_core::referee::GameStatus;

/// A whistle is ignored if no report has followed for this much longer than the reports' delay, s.
const PATIENCE_S: f32 = 2.0;

/// The whistles that a player remembers.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct Whistles {
    /// The state that was reported last.
    pub told: GameState,
    /// The number of whistles whose meaning is known.
    pub understood: u32,
    /// When a whistle was heard whose meaning has not been reported yet, s.
    pub heard_at_s: Option<f32>,
    /// The number of signals for `ready` seen before `standby` was last reported.
    pub ready_signals: u32,
}

/// Corrects the reported status by a whistle whose meaning has not been reported yet: in `set` it begins play, in play it means a goal.
/// In `standby`, the referee's signal means `ready`.
pub fn as_heard(told: &GameStatus, rules: &Rules, whistles: &mut Whistles) -> GameStatus {
    let longest_s = rules.status_delay_s.max(rules.goal_delay_s);
    if longest_s == 0.0 && rules.ready_delay_s == 0.0 {
        return *told;
    }
    if told.state != whistles.told {
        // The whistle that began play may have been followed by another one, or missed.
        let begins = (whistles.told, told.state) == (GameState::Set, GameState::Playing);
        let understood = if begins { whistles.understood.saturating_add(1).min(told.whistles) } else { told.whistles };
        *whistles = Whistles { told: told.state, understood, heard_at_s: None, ..*whistles };
    }
    if told.state != GameState::Standby {
        whistles.ready_signals = told.ready_signals;
    }
    if told.whistles > whistles.understood {
        let since_s = *whistles.heard_at_s.get_or_insert(told.time_s);
        if told.time_s - since_s > longest_s + PATIENCE_S {
            *whistles = Whistles { understood: told.whistles, heard_at_s: None, ..*whistles };
        }
    }
    let state = match told.state {
        GameState::Standby if told.ready_signals > whistles.ready_signals => GameState::Ready,
        _ if told.whistles <= whistles.understood => told.state,
        GameState::Set => GameState::Playing,
        GameState::Playing => GameState::Ready,
        state => state,
    };
    GameStatus { state, ..*told }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The states that a player assumes for these reports of state and number of whistles, one a second.
    fn heard(told: &[(GameState, u32)]) -> Vec<GameState> {
        let rules = Rules { status_delay_s: 3.0, ..Rules::default() };
        let mut whistles = Whistles::default();
        let mut time_s = 0.0;
        let mut hear = |(state, count): &(GameState, u32)| {
            time_s += 1.0;
            let status = GameStatus { state: *state, whistles: *count, time_s, ..GameStatus::default() };
            as_heard(&status, &rules, &mut whistles).state
        };
        told.iter().map(&mut hear).collect()
    }

    #[test]
    fn the_whistle_begins_play_and_another_one_in_play_is_for_a_goal() {
        use GameState::{Playing, Ready, Set};
        assert_eq!(heard(&[(Set, 1), (Set, 2), (Set, 2), (Playing, 2)]), [Set, Playing, Playing, Playing]);
        assert_eq!(
            heard(&[(Set, 1), (Set, 2), (Playing, 3), (Playing, 3), (Ready, 3)]),
            [Set, Playing, Ready, Ready, Ready]
        );
    }

    #[test]
    fn after_a_missed_whistle_the_next_one_counts() {
        use GameState::{Playing, Ready, Set};
        assert_eq!(heard(&[(Set, 1), (Set, 1), (Playing, 1), (Playing, 2)]), [Set, Set, Playing, Ready]);
    }

    #[test]
    fn a_whistle_that_means_nothing_is_forgotten() {
        use GameState::{Playing, Ready, Set};
        let mut told = vec![(Set, 1), (Playing, 2)];
        told.extend([(Playing, 3); 8]);
        let heard = heard(&told);
        assert_eq!((heard[1], heard[2], heard[7], heard[9]), (Playing, Ready, Ready, Playing));
    }
}
