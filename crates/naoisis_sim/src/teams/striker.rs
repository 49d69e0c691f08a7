//! Strikers and supporters: each goes for the ball unless a team-mate other than the keeper is there sooner.

use super::attack::attack;
use super::player::{Decision, Player, PlayerMemory};
use super::roles::{has_turn, support_and_defend};
use super::searching::search;

/// Decides for a striker or a supporter.
pub fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
    let Some(ball) = player.ball().map(|ball| ball.position_m) else { return search(player, memory) };
    memory.attacks = has_turn(player, memory, ball, |id| !id.is_some_and(|id| player.is_goalkeeper(id)));
    if memory.attacks { attack(player, memory) } else { support_and_defend(player, ball) }
}
