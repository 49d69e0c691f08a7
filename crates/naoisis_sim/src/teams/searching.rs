//! Searching for a lost ball. Shared by all built-in players.

use bevy::prelude::*;

use super::player::{Decision, Player, PlayerMemory};
use naoisis_core::robot::motion::WalkCommand;

/// Searches for the ball: turns around towards the side on which it was lost, then walks from place to place.
pub fn search(player: &Player, memory: &mut PlayerMemory) -> Decision {
    /// The speed at which the body turns while the head searches, as a share of the greatest speed.
    const TURN_SHARE: f32 = 0.4;
    /// How long the player turns before it walks, s.
    const TURN_S: f32 = 8.0;
    /// How long the player walks to a place before it goes to the next one, s.
    const PATROL_S: f32 = 12.0;
    let now = player.status.time_s;
    let since = *memory.lost_since_s.get_or_insert(now);
    memory.kick = None;
    memory.at_ball_since_s = None;
    let head = Some(player.head.search(now - since));
    let turn = if memory.lost_left { 1.0 } else { -1.0 };
    let searched_s = now - since;
    if may_have_missed(player, memory) {
        return Decision { head, intention: "search", ..step_back(player) };
    }
    if searched_s < TURN_S {
        let walk = WalkCommand::new(0.0, 0.0, turn * TURN_SHARE * player.motion.max_angular * player.period);
        return Decision { walk, head, intention: "search", ..default() };
    }
    let (x, y) = (0.45 * player.pitch.half_length(), 0.5 * player.pitch.half_width());
    let places = [Vec2::ZERO, Vec2::new(x, y), Vec2::new(-x, -y), Vec2::new(x, -y), Vec2::new(-x, y)];
    let index = ((searched_s - TURN_S) / PATROL_S) as usize + usize::from(player.id.number);
    let place = places[index % places.len()];
    let facing = (place - player.position()).normalize_or(player.forward);
    let walk = player.walk_to(place, facing, &player.obstacles());
    Decision { walk, target: Some(place), head, intention: "search", ..default() }
}

/// Whether a lost ball may lie at the feet, where no camera shows it, because the player has recently kicked and may have missed it.
fn may_have_missed(player: &Player, memory: &PlayerMemory) -> bool {
    /// The time after a kick for which this is possible, s: as long as it takes to lose the ball, and to walk away from it.
    const LATE_S: f32 = 10.0;
    /// The distance of such a ball from the feet, m.
    const AT_FEET_M: f32 = 0.1;
    let since_kick_s = memory.kicked_at_s.map(|then| player.status.time_s - then);
    let at_feet = Vec2::new(player.own_body.base.x_m[1] + player.ball_radius_m + AT_FEET_M, 0.0);
    since_kick_s.is_some_and(|since_s| (0.0..LATE_S).contains(&since_s)) && !player.head.can_see(at_feet)
}

/// A step back, so that a ball at the feet comes into view.
pub(super) fn step_back(player: &Player) -> Decision {
    let place = player.position() - player.forward;
    let walk = player.walk_to(place, player.forward, &player.obstacles());
    Decision { walk, target: Some(place), intention: "attack", ..default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::{PlayerFixture, after_decision};
    use naoisis_core::geometry::Pose;

    #[test]
    fn a_lost_ball_is_searched_all_around() {
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::ZERO);
        situation.belief.ball = None;
        let mut memory = PlayerMemory::default();
        let mut turned = 0.0;
        for _ in 0..30 * 8 {
            let decision = search(&situation.player(), &mut memory);
            turned += decision.walk.dtheta.abs();
            assert!(decision.head.is_some());
            situation.belief.pose = after_decision(situation.belief.pose, &decision);
            situation.status.time_s += situation.period;
        }
        // 40 % of 90 degrees per second for 8 s are 288 degrees; the head adds 100 to either side.
        assert!(turned > 4.5, "{turned}");
    }
}
