//! How often a player sends messages if they are limited, so that those of its team last for the match.

use super::player::{Decision, Player, PlayerMemory};
use super::roles::goes_for_the_ball;
use naoisis_core::game::{GameState, SetPlayKind};

/// Messages kept in reserve for each robot: those that several robots send at once are counted afterwards.
const RESERVE: u32 = 3;
/// The longest time between two messages of a player that announces a pass, s.
const URGENT_S: f32 = 1.0;

/// The longest time between two messages of a player that goes for the ball, s: its team-mates leave the ball to it.
const ATTACKING_S: f32 = 2.5;

/// Returns the longest time between two messages of a player that decides so, s, as long as the team has any left.
pub fn longest_pause_s(decision: &Decision) -> f32 {
    if decision.pass.is_some() {
        URGENT_S
    } else if goes_for_the_ball(decision.intention) {
        ATTACKING_S
    } else {
        f32::INFINITY
    }
}

/// Returns whether it is time for the player to send a message, after `longest_pause_s` at the latest; if so, records it in `memory`.
pub fn may_send(player: &Player, memory: &mut PlayerMemory, longest_pause_s: f32) -> bool {
    let status = player.status;
    if status.messages_left.is_none() {
        return true;
    }
    let pause_s = pause_between_messages_s(player);
    // Before a penalty kick the players agree on the kicker by their places.
    let prepares_penalty_kick = status.state == GameState::Ready
        && status.set_play.is_some_and(|set_play| set_play.kind == SetPlayKind::PenaltyKick);
    if !(status.state == GameState::Playing || prepares_penalty_kick) || pause_s.is_infinite() {
        return false;
    }
    let pause_s = pause_s.min(longest_pause_s);
    let sends = memory.spoke_at_s.is_none_or(|at| status.time_s - at >= pause_s);
    if sends {
        memory.spoke_at_s = Some(status.time_s);
    }
    sends
}

/// Returns the time between two messages of a player with which those of its team last for the rest of the match, s: 0 where messages are
/// not limited, infinite when none is left.
pub fn pause_between_messages_s(player: &Player) -> f32 {
    let status = player.status;
    let Some(left) = status.messages_left else { return 0.0 };
    let size = u32::from(player.rules.team_size);
    let to_spend = left.saturating_sub(RESERVE * size);
    if to_spend == 0 {
        return f32::INFINITY;
    }
    let later_halves = player.rules.halves.saturating_sub(status.half) as f32;
    let to_go_s = status.time_left_s.unwrap_or(player.rules.half_s) + later_halves * player.rules.half_s;
    to_go_s * size as f32 / to_spend as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use bevy::prelude::*;
    use naoisis_core::game::Rules;
    use naoisis_core::geometry::Pose;

    /// How often a player of a team of five talks in a match of two halves of 600 s.
    fn times_spoken(longest_pause_s: f32) -> u32 {
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::ZERO);
        situation.rules = Rules { team_size: 5, ..Rules::default() };
        let (mut memory, mut left, mut spoken) = (PlayerMemory::default(), 1200, 0);
        for second in 0..1200_u16 {
            let half = u32::from(second / 600) + 1;
            let (time_s, time_left_s) = (f32::from(second), Some(600.0 - f32::from(second % 600)));
            situation.status = naoisis_core::referee::GameStatus { half, time_s, time_left_s, ..situation.status };
            situation.status.messages_left = Some(left);
            if may_send(&situation.player(), &mut memory, longest_pause_s) {
                spoken += 1;
                // All five players send equally often.
                left -= 5;
            }
        }
        spoken
    }

    #[test]
    fn the_messages_last_for_the_match_and_are_used() {
        let [seldom, often] = [f32::INFINITY, URGENT_S].map(times_spoken);
        assert!((200..=240).contains(&seldom) && (230..=240).contains(&often), "{seldom} {often}");
    }

    #[test]
    fn where_nothing_is_limited_everybody_talks_all_the_time() {
        let situation = PlayerFixture::new(Pose::default(), Vec2::ZERO);
        let mut memory = PlayerMemory::default();
        assert!((0..3).all(|_| may_send(&situation.player(), &mut memory, f32::INFINITY)));
    }

    #[test]
    fn limited_messages_are_sent_in_play_and_before_a_penalty_kick() {
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::ZERO);
        situation.rules = Rules { team_size: 7, halves: 2, half_s: 600.0, ..Rules::default() };
        (situation.status.messages_left, situation.status.time_left_s) = (Some(1200), Some(600.0));
        let talks =
            |situation: &PlayerFixture| may_send(&situation.player(), &mut PlayerMemory::default(), f32::INFINITY);
        assert!(talks(&situation));
        situation.status.state = GameState::Ready;
        assert!(!talks(&situation));
        let kind = SetPlayKind::PenaltyKick;
        situation.status.set_play = Some(naoisis_core::referee::SetPlayStatus { kind, team: None });
        assert!(talks(&situation));
    }

    #[test]
    fn the_pause_is_what_the_messages_that_are_left_allow() {
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::ZERO);
        situation.rules = Rules { team_size: 7, halves: 2, half_s: 600.0, ..Rules::default() };
        assert_eq!(pause_between_messages_s(&situation.player()), 0.0);
        situation.status = naoisis_core::referee::GameStatus {
            half: 1,
            time_left_s: Some(600.0),
            messages_left: Some(1200),
            ..situation.status
        };
        // 1200 s for 1200 - 3 * 7 messages of seven robots.
        let pause_s = pause_between_messages_s(&situation.player());
        assert!((pause_s - 1200.0 * 7.0 / 1179.0).abs() < 1e-3, "{pause_s}");
        situation.status.messages_left = Some(21);
        assert_eq!(pause_between_messages_s(&situation.player()), f32::INFINITY);
    }
}
