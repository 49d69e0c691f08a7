//! Whistles and signals of the referee, if the GameController reports goals and the start of play with a delay.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use naoisis_core::communication::ReceivedMessage;
use naoisis_core::game::{GameState, Rules};
use naoisis_core::referee::GameStatus;

/// A whistle is ignored if no report has followed for this much longer than the reports' delay, s.
const PATIENCE_S: f32 = 2.0;
/// Play has begun for a player that missed the whistle if this many team-mates play: a single one may have heard a whistle of another pitch.
const MATES_THAT_PLAY: u32 = 2;

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
    /// The team-mates that have said since the report of `set` that they play: a bit for each number.
    pub playing_mates: u32,
}

impl Whistles {
    /// Notes the team-mates that play, from the messages `heard` in this cycle: in `set` nobody else has an intention but to wait.
    pub fn note_mates(&mut self, heard: &[ReceivedMessage]) {
        if self.told != GameState::Set {
            self.playing_mates = 0;
            return;
        }
        let plays = |message: &&ReceivedMessage| {
            message.say.intention.as_deref().is_some_and(|intention| !matches!(intention, "wait" | "ready"))
        };
        for message in heard.iter().filter(plays) {
            self.playing_mates |= 1_u32.checked_shl(u32::from(message.from.number)).unwrap_or_default();
        }
    }
}

/// Corrects the reported status by a whistle whose meaning has not been reported yet: in `set` it begins play, in play it means a goal.
/// In `set`, team-mates that play mean the same as a whistle; in `standby`, the referee's signal means `ready`.
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
        GameState::Set if whistles.playing_mates.count_ones() >= MATES_THAT_PLAY => GameState::Playing,
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
    use naoisis_core::communication::TeamMessage;
    use naoisis_core::team::{RobotId, Team};

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
    fn a_player_that_misses_the_whistle_plays_when_two_mates_say_that_they_do() {
        let rules = Rules { status_delay_s: 3.0, ..Rules::default() };
        let set = GameStatus { state: GameState::Set, ..GameStatus::default() };
        let says = |number, intention: &'static str| ReceivedMessage {
            from: RobotId::new(Team::Blue, number),
            sent_cycle: 1,
            say: TeamMessage { intention: Some(intention.into()), ..TeamMessage::default() },
        };
        let mut whistles = Whistles::default();
        let mut hear = |told: &GameStatus, heard: &[ReceivedMessage]| {
            whistles.note_mates(heard);
            as_heard(told, &rules, &mut whistles).state
        };
        // A message from before `set` is old.
        assert_eq!(hear(&set, &[says(2, "attack")]), GameState::Set);
        assert_eq!(hear(&set, &[says(2, "support"), says(3, "wait"), says(4, "ready")]), GameState::Set);
        assert_eq!(hear(&set, &[says(2, "support")]), GameState::Set, "the same mate once more");
        assert_eq!(hear(&set, &[says(5, "attack")]), GameState::Playing);
        assert_eq!(hear(&set, &[]), GameState::Playing);
        assert_eq!(hear(&GameStatus { state: GameState::Playing, ..set }, &[]), GameState::Playing);
        assert_eq!(hear(&set, &[]), GameState::Set, "at the next kick-off it waits again");
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
