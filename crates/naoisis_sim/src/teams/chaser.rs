//! Chasers: all go for the ball, but a player that is further away than a team-mate keeps out of the way.

use bevy::math::Vec2;

use super::attack::attack;
use super::player::{Decision, Player, PlayerMemory};
use super::roles::{FRESH_TEAM_MATE_S, has_turn, reasons_of_turn, soonest_mate_s, support, time_to_ball_s};
use super::rule_limits::is_for_the_keeper_only;
use super::searching::search;
use naoisis_core::behaviour::reasons::{Choice, Reasons};

/// The distance that a chaser keeps from the ball while a team-mate is nearer, m.
const CROWDING_DISTANCE_M: f32 = 1.2;

/// Decides for a chaser.
pub fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
    let Some(ball) = player.ball().map(|ball| ball.position_m) else { return search(player, memory) };
    memory.attacks = has_turn(player, memory, ball, |_| true);
    if memory.attacks || !(is_crowding(player, ball) || is_for_the_keeper_only(player, ball)) {
        attack(player, memory)
    } else {
        support(player, ball)
    }
}

/// Returns whether the player is close to the ball. It then keeps away from the ball if a team-mate is closer.
fn is_crowding(player: &Player, ball: Vec2) -> bool {
    player.position().distance_squared(ball) < CROWDING_DISTANCE_M * CROWDING_DISTANCE_M
}

/// Returns the reasons for going for the ball, or for leaving it to a team-mate: the times to the ball, s.
pub fn reasons(player: &Player, before: PlayerMemory, decision: &Decision) -> Reasons {
    let Some(ball) = player.ball().map(|ball| ball.position_m) else { return Reasons::default() };
    if !is_crowding(player, ball) && !is_for_the_keeper_only(player, ball) {
        let why = format!("{:.1} m from the ball, so in nobody's way", player.position().distance(ball));
        return Reasons::of(vec![Choice::new("attack", 0.0, why)], "attack");
    }
    let time_s = |place| time_to_ball_s(player, place, ball);
    let mate_s = soonest_mate_s(player, &before, FRESH_TEAM_MATE_S, |_| true, time_s);
    reasons_of_turn(player, &before, decision, [time_s(player.position()), mate_s])
}
