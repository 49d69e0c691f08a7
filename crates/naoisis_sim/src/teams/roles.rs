//! Who goes for the ball, and where the others go meanwhile.

use bevy::prelude::*;

use super::obeying::is_for_the_keeper_only;
use super::player::{Decision, Player, PlayerMemory};
use naoisis_core::behaviour::reasons::{Choice, Reasons};
use naoisis_core::game::DefenderLimit;
use naoisis_core::team::RobotId;

/// A player keeps its turn at the ball until a team-mate is nearer by this, s.
pub(super) const TURN_PREFERENCE_S: f32 = 0.8;
/// What was heard or seen of a team-mate longer ago does not count, s.
pub(super) const FRESH_TEAM_MATE_S: f32 = 1.0;
/// Players whose turn it is not keep so far from the ball, m.
pub const SUPPORT_DISTANCE_M: f32 = 0.9;

/// So far before the own goal line it is the keeper's, m.
const KEEPERS_DEPTH_M: f32 = 0.6;
/// Supporters stay so far from that, or from the penalty area, m.
const OFF_THE_AREA_M: f32 = 0.3;
/// Who comes from before the ball walks so much further than who comes from beside it, m: around it.
const AROUND_BALL_M: f32 = 0.4;

/// About how long somebody at `position` who walks as the player does needs to stand behind the ball, s: the way, and around the
/// ball if it is on the wrong side.
pub fn time_to_ball_s(player: &Player, position: Vec2, ball: Vec2) -> f32 {
    position.distance(ball) / player.limits.max_linear_mps.max(0.01) + time_around_ball_s(player, position, ball)
}

/// How much longer than straight ahead who comes from `position` walks around the ball to stand behind it, s.
pub fn time_around_ball_s(player: &Player, position: Vec2, ball: Vec2) -> f32 {
    let forwards = (ball - position).normalize_or(Vec2::X).dot((player.opponent_goal() - ball).normalize_or(Vec2::X));
    let around_m = (1.0 - forwards) * (AROUND_BALL_M + player.longer_than_nao_m());
    around_m / player.limits.max_linear_mps.max(0.01)
}

/// Whether it is this player's turn to go for the ball: nobody of the team-mates that count is there sooner.
pub fn has_turn(player: &Player, memory: &PlayerMemory, ball: Vec2, counts: impl Fn(Option<RobotId>) -> bool) -> bool {
    if is_for_the_keeper_only(player, ball) {
        return false;
    }
    let preference = if memory.attacks { TURN_PREFERENCE_S } else { 0.0 };
    let own_s = time_to_ball_s(player, player.position(), ball) - preference;
    player.belief.team_mates.iter().filter(|mate| mate.age_s < FRESH_TEAM_MATE_S && counts(mate.id)).all(|mate| {
        let time_s = time_to_ball_s(player, mate.position_m, ball);
        // Of two that need the same time, the one with the lower number goes.
        own_s < time_s || (own_s == time_s && mate.id.is_none_or(|id| player.id < id))
    })
}

/// What speaks for going for the ball, and what for leaving it to others: how long it takes, s.
pub fn reasons(player: &Player, decision: &Decision) -> Reasons {
    let Some(ball) = player.ball().map(|ball| ball.position_m) else { return Reasons::default() };
    let time_s = |place: Vec2| time_to_ball_s(player, place, ball);
    let own_s = time_s(player.position());
    let others = player.belief.team_mates.iter().filter(|mate| mate.age_s < FRESH_TEAM_MATE_S);
    let others_s = others.map(|mate| time_s(mate.position_m)).fold(f32::INFINITY, f32::min);
    let mut options = vec![Choice::new("attack", -own_s, format!("{own_s:.1} s to the ball"))];
    if others_s.is_finite() {
        options.push(Choice::new("support", -others_s, format!("{others_s:.1} s for the nearest team-mate")));
    }
    let chosen = if decision.intention == "kick" { "attack" } else { decision.intention };
    Reasons::of(options, chosen)
}

/// Where supporters stand: ahead of and to the left of the ball, m; the first for the player with number 2.
const SUPPORT_PLACES_M: [Vec2; 7] = [
    Vec2::new(-0.8, -0.7),
    Vec2::new(-0.8, 0.7),
    Vec2::new(-1.6, 0.0),
    Vec2::new(-1.6, 1.3),
    Vec2::new(-1.6, -1.3),
    Vec2::new(-2.5, 0.6),
    Vec2::new(-2.5, -0.6),
];

/// Walks to a place from where the attacker can be supported: behind the ball and beside it, each number its own, and outside the own
/// penalty area.
pub fn support(player: &Player, ball: Vec2) -> Decision {
    support_from(player, ball, player.pitch.penalty_area.depth_m)
}

/// The same where it helps to defend, too: in the own penalty area, if the rules let field players in.
pub fn support_and_defend(player: &Player, ball: Vec2) -> Decision {
    let for_keeper_only = player.rules.illegal_defender && player.rules.defender_limit == DefenderLimit::KeeperOnly;
    let depth_m = if for_keeper_only { player.pitch.penalty_area.depth_m } else { KEEPERS_DEPTH_M };
    support_from(player, ball, depth_m)
}

/// Supports, off the area of this depth before the own goal line, m.
fn support_from(player: &Player, ball: Vec2, depth_m: f32) -> Decision {
    let place = support_place(player, ball, depth_m);
    let facing = (ball - player.position()).normalize_or(Vec2::X);
    let mut obstacles = player.obstacles();
    obstacles.add(ball, 0.7 * SUPPORT_DISTANCE_M);
    let walk = player.go_and_stay(place, facing, &obstacles);
    Decision { walk, target: Some(place), intention: "support", ..default() }
}

fn support_place(player: &Player, ball: Vec2, depth_m: f32) -> Vec2 {
    let index = (usize::from(player.id.number) + SUPPORT_PLACES_M.len() - 2) % SUPPORT_PLACES_M.len();
    let offset = SUPPORT_PLACES_M[index];
    let wanted = Vec2::new(ball.x + offset.x, 0.6 * ball.y + offset.y);
    let (length, width) = (player.pitch.half_length(), player.pitch.half_width());
    // Not among the keeper's feet, and not over the lines.
    let least = Vec2::new(-length + depth_m + OFF_THE_AREA_M, -width + 0.4);
    wanted.clamp(least, Vec2::new(length - 0.8, width - 0.4))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use naoisis_core::geometry::Pose;

    #[test]
    fn supporters_help_in_the_own_penalty_area_where_the_rules_let_them_in() {
        // On the pitch of 2025 the area is 1.65 m deep; the ball is 1.2 m from the goal line.
        let mut situation = PlayerFixture::new(Pose::new(-1.0, 0.0, 0.0), Vec2::new(-1.8, 0.0));
        situation.pitch.penalty_area.depth_m = 1.65;
        let place = |situation: &PlayerFixture, supports: fn(&Player, Vec2) -> Decision| {
            let player = situation.player();
            supports(&player, player.ball().unwrap().position_m).target.unwrap()
        };
        let near = |place: Vec2, x: f32| assert!(place.distance(Vec2::new(x, -0.7)) < 1e-5, "{place}");
        near(place(&situation, support), -1.05);
        // Number 2: 0.8 m behind the ball, but 0.9 m from the goal line at least.
        near(place(&situation, support_and_defend), -2.1);
        situation.rules.illegal_defender = true;
        situation.rules.defender_limit = DefenderLimit::KeeperOnly;
        near(place(&situation, support_and_defend), -1.05);
    }
}
