//! The choice of the player that goes for the ball, and the places of the supporters.

use bevy::prelude::*;

use super::player::{Decision, Player, PlayerMemory};
use super::rule_limits::is_for_the_keeper_only;
use naoisis_core::behaviour::reasons::{Choice, Reasons};
use naoisis_core::team::RobotId;

/// A player keeps its turn at the ball until a team-mate is nearer by this, s.
pub(super) const TURN_PREFERENCE_S: f32 = 0.8;
/// The greatest age of information about a team-mate, s.
pub(super) const FRESH_TEAM_MATE_S: f32 = 1.0;
/// The distance from the ball at which supporters walk past it on a pitch of [`PLACES_FOR_LENGTH_M`], m.
const PASSING_DISTANCE_M: f32 = 0.63;

/// The length of the pitch for the distances below, m.
const PLACES_FOR_LENGTH_M: f32 = 6.0;
/// The depth of the keeper's own place before the goal line, m.
const KEEPERS_DEPTH_M: f32 = 0.6;
/// The distance of supporters from the keeper's place or from the penalty area, m.
const OFF_THE_AREA_M: f32 = 0.3;
/// How much longer the way around the ball is from the front than from the side, m.
const AROUND_BALL_M: f32 = 0.4;

/// Returns the approximate time that a robot at `position` with the player's speed takes to stand behind the ball, s, including the way
/// around it.
pub fn time_to_ball_s(player: &Player, position: Vec2, ball: Vec2) -> f32 {
    position.distance(ball) / player.motion.max_linear_mps.max(0.01) + time_around_ball_s(player, position, ball)
}

/// Returns the time that a robot at `position` takes for the way around the ball, s.
pub fn time_around_ball_s(player: &Player, position: Vec2, ball: Vec2) -> f32 {
    let forwards = (ball - position).normalize_or(Vec2::X).dot((player.opponent_goal() - ball).normalize_or(Vec2::X));
    let around_m = (1.0 - forwards) * (AROUND_BALL_M + player.longer_than_nao_m());
    around_m / player.motion.max_linear_mps.max(0.01)
}

/// Returns whether the player goes for the ball: none of the team-mates that `counts` accepts is there sooner.
pub fn has_turn(player: &Player, memory: &PlayerMemory, ball: Vec2, counts: impl Fn(Option<RobotId>) -> bool) -> bool {
    if is_for_the_keeper_only(player, ball) {
        return false;
    }
    is_soonest(player, memory, FRESH_TEAM_MATE_S, counts, |place| time_to_ball_s(player, place, ball))
}

/// The time for which a player that said that it goes for the ball is expected to do so, s.
const FRESH_ATTACKER_S: f32 = 4.0;

/// Notes team-mates that say that they go for the ball, where messages are limited and so the places of team-mates are old.
pub(super) fn note_attackers(player: &Player, memory: &mut PlayerMemory) {
    if player.status.messages_left.is_none() {
        return;
    }
    let now = player.status.time_s;
    for message in player.heard {
        memory.attackers.retain(|(id, ..)| *id != message.from);
        let goes = message.say.intention.as_deref().is_some_and(goes_for_the_ball);
        if let Some(pose) = message.say.pose.filter(|_| goes) {
            memory.attackers.push((message.from, pose.position, now));
        }
    }
    memory.attackers.retain(|(.., at_s)| now - at_s < FRESH_ATTACKER_S);
}

/// Returns whether a player with this intention goes for the ball.
pub(super) fn goes_for_the_ball(intention: &str) -> bool {
    matches!(intention, "attack" | "kick")
}

/// Returns the times that team-mates take to the ball, s, with their identities: those that `counts` accepts and that were seen or heard
/// within `fresh_s`, and those that said that they go for the ball. These have come nearer since. Of two that both go for it, the one
/// with the lower number goes on unless the other is clearly sooner. `time_s`: the time from a place to the ball, s.
fn rivals(
    player: &Player,
    memory: &PlayerMemory,
    fresh_s: f32,
    counts: impl Fn(Option<RobotId>) -> bool,
    time_s: impl Fn(Vec2) -> f32,
) -> impl Iterator<Item = (f32, Option<RobotId>)> {
    let fresh = player.belief.team_mates.iter().filter(move |mate| mate.age_s < fresh_s);
    let attackers = memory.attackers.iter().map(|(id, place, at_s)| {
        let goes_on_s = if memory.attacks && *id < player.id { 2.0 * TURN_PREFERENCE_S } else { 0.0 };
        (*place, player.status.time_s - at_s + goes_on_s, Some(*id))
    });
    let places = fresh.map(|mate| (mate.position_m, 0.0, mate.id)).chain(attackers);
    places.filter(move |(.., id)| counts(*id)).map(move |(place, less_s, id)| (time_s(place) - less_s, id))
}

/// Whether the player is sooner at the ball than the team-mates that `counts` accepts and that were seen or heard within `fresh_s`.
/// `time_s`: the time from a place to the ball, s.
pub(super) fn is_soonest(
    player: &Player,
    memory: &PlayerMemory,
    fresh_s: f32,
    counts: impl Fn(Option<RobotId>) -> bool,
    time_s: impl Fn(Vec2) -> f32,
) -> bool {
    let preference = if memory.attacks { TURN_PREFERENCE_S } else { 0.0 };
    let own_s = time_s(player.position()) - preference;
    // If two need the same time, the one with the lower number goes.
    let is_sooner = |(time_s, id): (f32, Option<RobotId>)| {
        own_s < time_s || (own_s == time_s && id.is_none_or(|id| player.id < id))
    };
    rivals(player, memory, fresh_s, counts, time_s).all(is_sooner)
}

/// Returns the time of the soonest of the team-mates that `counts` accepts and that were seen or heard within `fresh_s`, s. Infinite if
/// there is none. `time_s`: the time from a place to the ball, s.
pub(super) fn soonest_mate_s(
    player: &Player,
    memory: &PlayerMemory,
    fresh_s: f32,
    counts: impl Fn(Option<RobotId>) -> bool,
    time_s: impl Fn(Vec2) -> f32,
) -> f32 {
    rivals(player, memory, fresh_s, counts, time_s).map(|(time_s, _)| time_s).fold(f32::INFINITY, f32::min)
}

/// Returns the reasons for going for the ball, or for leaving it to another field player: the times to the ball, s.
pub fn reasons(player: &Player, before: PlayerMemory, decision: &Decision) -> Reasons {
    let Some(ball) = player.ball().map(|ball| ball.position_m) else { return Reasons::default() };
    let time_s = |place| time_to_ball_s(player, place, ball);
    let is_field_player = |id: Option<RobotId>| !id.is_some_and(|id| player.is_goalkeeper(id));
    let mate_s = soonest_mate_s(player, &before, FRESH_TEAM_MATE_S, is_field_player, time_s);
    reasons_of_turn(player, &before, decision, [time_s(player.position()), mate_s])
}

/// Returns the reasons for having the turn at the ball or not, by the times to the ball, s, of the player and of the soonest team-mate.
/// `before` is the player's memory before the decision.
pub(super) fn reasons_of_turn(
    player: &Player,
    before: &PlayerMemory,
    decision: &Decision,
    [own_s, mate_s]: [f32; 2],
) -> Reasons {
    let (attacks, waits) = match decision.intention {
        taken if goes_for_the_ball(taken) => (true, "support"),
        waits @ ("support" | "receive") => (false, waits),
        // Something that the rules demand.
        _ => return Reasons::default(),
    };
    let mut options = Vec::new();
    if player.ball().is_some_and(|ball| is_for_the_keeper_only(player, ball.position_m)) {
        options.push(Choice::new(waits, 0.0, "only the keeper may play the ball there"));
    } else {
        let preference_s = if before.attacks { TURN_PREFERENCE_S } else { 0.0 };
        let turn =
            if before.attacks { format!(", {TURN_PREFERENCE_S} s less for having the turn") } else { String::new() };
        options.push(Choice::new("attack", preference_s - own_s, format!("{own_s:.1} s to the ball{turn}")));
        if mate_s.is_finite() {
            options.push(Choice::new(waits, -mate_s, format!("{mate_s:.1} s for the nearest team-mate")));
        }
    }
    Reasons::of(options, if attacks { "attack" } else { waits })
}

/// The places of supporters relative to the ball on a pitch of [`PLACES_FOR_LENGTH_M`], ahead and to the left, m; the first is for
/// number 2. On longer pitches they are further apart.
const SUPPORT_PLACES_M: [Vec2; 7] = [
    Vec2::new(-0.8, -0.7),
    Vec2::new(-0.8, 0.7),
    Vec2::new(-1.6, 0.0),
    Vec2::new(-1.6, 1.3),
    Vec2::new(-1.6, -1.3),
    Vec2::new(-2.5, 0.6),
    Vec2::new(-2.5, -0.6),
];

/// Walks to a place behind and beside the ball, a different one for each number, outside the own penalty area.
pub fn support(player: &Player, ball: Vec2) -> Decision {
    support_from(player, ball, player.pitch.penalty_area.depth_m)
}

/// Like [`support`], but also in the own penalty area if the rules let field players in.
pub fn support_and_defend(player: &Player, ball: Vec2) -> Decision {
    let depth_m =
        if player.is_own_area_for_keeper_only() { player.pitch.penalty_area.depth_m } else { KEEPERS_DEPTH_M };
    support_from(player, ball, depth_m)
}

/// Like [`support`], but outside the area of depth `depth_m` in front of the own goal line.
fn support_from(player: &Player, ball: Vec2, depth_m: f32) -> Decision {
    let place = support_place(player, ball, depth_m);
    let facing = (ball - player.position()).normalize_or(Vec2::X);
    let mut obstacles = player.obstacles();
    obstacles.add(ball, passing_distance_m(player));
    let walk = player.go_and_stay(place, facing, &obstacles);
    Decision { walk, target: Some(place), intention: "support", ..default() }
}

/// Returns the distance from the ball at which supporters walk past it, m.
pub(super) fn passing_distance_m(player: &Player) -> f32 {
    PASSING_DISTANCE_M * spread(player)
}

/// The factor of the distances of supporters from the ball, by the length of the pitch.
fn spread(player: &Player) -> f32 {
    (player.pitch.length_m / PLACES_FOR_LENGTH_M).max(1.0)
}

fn support_place(player: &Player, ball: Vec2, depth_m: f32) -> Vec2 {
    let index = (usize::from(player.id.number) + SUPPORT_PLACES_M.len() - 2) % SUPPORT_PLACES_M.len();
    let offset = SUPPORT_PLACES_M[index] * spread(player);
    let wanted = Vec2::new(ball.x + offset.x, 0.6 * ball.y + offset.y);
    let (length, width) = (player.pitch.half_length(), player.pitch.half_width());
    // Clear of the keeper, and inside the lines.
    let least = Vec2::new(-length + depth_m + OFF_THE_AREA_M, -width + 0.4);
    wanted.clamp(least, Vec2::new(length - 0.8, width - 0.4))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use naoisis_core::communication::{ReceivedMessage, TeamMessage};
    use naoisis_core::game::DefenderLimit;
    use naoisis_core::geometry::Pose;
    use naoisis_core::team::Team;

    #[test]
    fn of_two_that_go_for_the_ball_one_leaves_it_to_the_other_where_messages_are_few() {
        // Number 2 is 1 m from the ball; number 3 said 2 s ago that it goes for it, from 1.4 m: 0.4 m on its way at 0.2 m/s.
        let mut situation = PlayerFixture::new(Pose::new(-1.0, 0.0, 0.0), Vec2::ZERO);
        let say = |intention: &'static str| TeamMessage {
            pose: Some(Pose::new(-1.4, 0.0, 0.0)),
            intention: Some(intention.into()),
            ..Default::default()
        };
        let goes = |situation: &mut PlayerFixture, number: u8, intention: &'static str, attacks: bool| {
            let mut memory = PlayerMemory { attacks, ..Default::default() };
            let from = RobotId::new(Team::Blue, number);
            situation.heard = vec![ReceivedMessage { from, sent_cycle: 0, say: say(intention) }];
            note_attackers(&situation.player(), &mut memory);
            situation.heard.clear();
            situation.status.time_s += 2.5;
            note_attackers(&situation.player(), &mut memory);
            has_turn(&situation.player(), &memory, Vec2::ZERO, |_| true)
        };
        assert!(goes(&mut situation, 3, "attack", false), "messages are not limited");
        situation.status.messages_left = Some(1000);
        assert!(goes(&mut situation, 3, "support", false));
        assert!(!goes(&mut situation, 3, "attack", false), "number 3 is 0.9 m away by now");
        // Of two that go for it, the lower number goes on.
        assert!(goes(&mut situation, 3, "attack", true));
        assert!(!goes(&mut situation, 1, "attack", true));
    }

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
