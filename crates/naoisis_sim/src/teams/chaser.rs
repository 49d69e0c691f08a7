//! Chasers: all go for the ball, but a player that is further away than a team-mate keeps out of the way.

use super::attack::{attack, search};
use super::player::{Decision, Player, PlayerMemory};
use super::roles::{has_turn, support};
use super::rule_limits::is_for_the_keeper_only;

/// The distance that a chaser keeps from the ball while a team-mate is nearer, m.
const CROWDING_DISTANCE_M: f32 = 1.2;

/// Decides for a chaser.
pub fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
    let Some(ball) = player.ball().map(|ball| ball.position_m) else { return search(player, memory) };
    memory.attacks = has_turn(player, memory, ball, |_| true);
    let crowding = player.position().distance_squared(ball) < CROWDING_DISTANCE_M * CROWDING_DISTANCE_M;
    if memory.attacks || !(crowding || is_for_the_keeper_only(player, ball)) {
        attack(player, memory)
    } else {
        support(player, ball)
    }
}
