//! The passer: whoever is soonest at the ball shoots or passes, the others wait where a pass can reach them, or stand
//! between the ball and the own goal when the opponents have it.
//!
//! All of that is by messages: everybody tells where it is and which opponents it sees, so that each knows more of them
//! than it sees itself; and who is about to pass says to whom and where to, so that the other goes there. The keeper
//! stands further out than that of other teams, as whoever falls back covers what it leaves, and nobody of them walks
//! into an opponent.

use bevy::prelude::*;

use super::aiming::Aim;
use super::attack::{choose_aim, go_for, search};
use super::giving_way::give_way;
use super::obeying::is_for_the_keeper_only;
use super::passing::{Pass, freedom, lane, meet, rolled, shot_value};
use super::player::{Decision, Player, PlayerMemory};
use crate::belief::{BallBelief, RobotBelief};

/// The jersey number of the keeper, who has other things to do.
const KEEPER: u8 = 1;
/// What was heard or seen of a team-mate longer ago does not count, s.
const FRESH_TEAM_MATE_S: f32 = 1.0;
/// What team-mates told of opponents longer ago does not count, s.
const FRESH_REPORT_S: f32 = 1.0;
/// An opponent that is told of and one that is seen nearer to each other than this are one, m.
const SAME_OPPONENT_M: f32 = 0.5;
/// A player keeps its turn at the ball until a team-mate is nearer by this, s.
const TURN_PREFERENCE_S: f32 = 0.8;
/// A pass must lead to a chance that is better by this factor than the own one.
const PASS_GAIN: f32 = 1.6;
/// Passes over less, or more, are not tried, m.
const PASS_RANGE_M: [f32; 2] = [0.7, 3.0];
/// An announced pass is waited for so long, s.
const PASS_PATIENCE_S: f32 = 4.0;
/// And by so much: a chance of a goal.
const LEAST_GAIN: f32 = 0.05;
/// How much better a new place to wait at must be than the one chosen before.
const PLACE_PREFERENCE: f32 = 1.25;
/// Opponents must be nearer to the ball by this for the team to fall back, s.
const FALL_BACK_S: f32 = 1.0;

/// Whoever falls back stands between the ball and a place beside the middle of the goal by this, m: what the keeper does
/// not cover.
const BESIDE_KEEPER_M: f32 = 0.4;
/// And so far from the goal at most, or just outside the penalty area, m.
const MOST_GUARD_M: f32 = 1.8;
/// A ball further back than this share of the own half is defended by all.
const OWN_THIRD: f32 = 0.33;
/// Distance of the keeper's place from the middle of the goal, m: further out it covers more of the goal, as the others
/// cover what it leaves.
const KEEPER_GUARD_M: f32 = 0.9;
/// The keeper clears a ball nearer to the goal than this, m.
const KEEPER_CLEAR_M: f32 = 1.5;

/// Decides for a passer.
pub fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
    listen(player, memory);
    let Some(ball) = player.ball() else { return Decision { reports_opponents: true, ..search(player, memory) } };
    let opponents = opponents(player, memory);
    memory.attacks = has_turn(player, memory, ball);
    let mut decision = if memory.attacks && !is_for_the_keeper_only(player, ball.position_m) {
        memory.free_place = None;
        attack(player, memory, ball, &opponents)
    } else {
        memory.lost_since_s = None;
        memory.kick = None;
        memory.at_ball_since_s = None;
        wait_for_the_ball(player, memory, ball, &opponents)
    };
    decision.walk = give_way(player, decision.walk, &opponents);
    Decision { reports_opponents: true, ..decision }
}

/// Decides for the keeper.
pub fn keep(player: &Player, memory: &mut PlayerMemory) -> Decision {
    listen(player, memory);
    let opponents = opponents(player, memory);
    let clear = |player: &Player, memory: &mut PlayerMemory| match player.ball() {
        Some(ball) => attack(player, memory, ball, &opponents),
        None => search(player, memory),
    };
    let mut decision = super::keeper::keep(player, memory, KEEPER_GUARD_M, KEEPER_CLEAR_M, clear);
    decision.walk = give_way(player, decision.walk, &opponents);
    Decision { reports_opponents: true, ..decision }
}

/// Takes note of announced passes, and of opponents that team-mates see.
fn listen(player: &Player, memory: &mut PlayerMemory) {
    let now = player.status.time_s;
    for message in player.heard {
        memory.told_opponents.retain(|(from, ..)| *from != message.from);
        memory.told_opponents.extend(message.say.robots_m.iter().map(|place| (message.from, *place, now)));
        let pass = message.say.payload.as_ref().and_then(|text| text.parse::<Pass>().ok());
        if let Some(pass) = pass.filter(|pass| pass.to == player.id.number) {
            memory.expected_pass = Some((pass, now));
        }
    }
    memory.told_opponents.retain(|(.., when)| now - when < FRESH_REPORT_S);
    if memory.expected_pass.is_some_and(|(_, when)| now - when > PASS_PATIENCE_S) {
        memory.expected_pass = None;
    }
}

/// The opponents that the player knows of, from its own eyes and from its team-mates'.
fn opponents(player: &Player, memory: &PlayerMemory) -> Vec<RobotBelief> {
    let mut known = player.belief.opponents.clone();
    for (_, place, when) in &memory.told_opponents {
        if known.iter().all(|other| other.position_m.distance(*place) > SAME_OPPONENT_M) {
            let age_s = player.status.time_s - when;
            known.push(RobotBelief { id: None, position_m: *place, covariance: [0.04, 0.0, 0.04], age_s });
        }
    }
    known
}

/// When somebody at `place` is behind the ball, or where it will be, s.
fn time_to_ball_s(player: &Player, ball: &BallBelief, place: Vec2) -> f32 {
    let (meeting_place, time_s) =
        meet(ball.position_m, ball.velocity_mps, player.rolling, place, player.limits.max_linear_mps);
    let forwards = (meeting_place - place)
        .normalize_or(Vec2::X)
        .dot((player.opponent_goal() - meeting_place).normalize_or(Vec2::X));
    time_s + 2.0 * (1.0 - forwards)
}

/// Whether it is this player's turn: no field player of its team is at the ball sooner.
fn has_turn(player: &Player, memory: &PlayerMemory, ball: &BallBelief) -> bool {
    let preference = if memory.attacks { TURN_PREFERENCE_S } else { 0.0 };
    let own_s = time_to_ball_s(player, ball, player.position()) - preference;
    let mates = player.belief.team_mates.iter().filter(|mate| mate.age_s < FRESH_TEAM_MATE_S);
    mates.filter(|mate| mate.id.is_none_or(|id| id.number != KEEPER)).all(|mate| {
        let time_s = time_to_ball_s(player, ball, mate.position_m);
        own_s < time_s || (own_s == time_s && mate.id.is_none_or(|id| player.id < id))
    })
}

/// Shoots, passes, or takes the ball forward.
fn attack(player: &Player, memory: &mut PlayerMemory, ball: &BallBelief, opponents: &[RobotBelief]) -> Decision {
    memory.lost_since_s = None;
    let (meeting_place, _) =
        meet(ball.position_m, ball.velocity_mps, player.rolling, player.position(), player.limits.max_linear_mps);
    let kick_off = memory.kick_off_since_s.is_some() && player.status.kick_off_team == player.id.team;
    let mut aim = choose_aim(player, memory, meeting_place);
    let own = if aim.is_shot { shot_value(meeting_place, opponents, player.pitch) } else { 0.0 };
    let pass = best_pass(player, meeting_place, opponents)
        .filter(|(value, _)| !kick_off && *value > PASS_GAIN * own + LEAST_GAIN);
    if let Some((_, pass)) = &pass {
        aim = Aim::at(meeting_place, pass.place);
        memory.aim = Some(aim.direction);
    }
    Decision { pass: pass.map(|(_, pass)| pass), ..go_for(player, memory, ball, &aim, meeting_place) }
}

/// The pass that leads to the best chance, and how good that is.
fn best_pass(player: &Player, ball: Vec2, opponents: &[RobotBelief]) -> Option<(f32, Pass)> {
    let mates = player.belief.team_mates.iter().filter(|mate| mate.age_s < FRESH_TEAM_MATE_S);
    mates
        .filter_map(|mate| {
            let to = mate.id.filter(|id| id.number != KEEPER)?.number;
            // A little ahead of the team-mate, where it will play on from.
            let place = mate.position_m + (player.opponent_goal() - mate.position_m).normalize_or(Vec2::X) * 0.25;
            let distance = place.distance(ball);
            let value = shot_value(place, opponents, player.pitch)
                * freedom(place, opponents)
                * lane(ball, place, opponents, player.kicks.direction_sd);
            ((PASS_RANGE_M[0]..PASS_RANGE_M[1]).contains(&distance) && value > 0.05)
                .then_some((value, Pass { to, place }))
        })
        .max_by(|(first, _), (second, _)| first.total_cmp(second))
}

/// Goes where a pass was announced to, or could come to; back, if the opponents are sooner at the ball.
fn wait_for_the_ball(
    player: &Player,
    memory: &mut PlayerMemory,
    ball: &BallBelief,
    opponents: &[RobotBelief],
) -> Decision {
    let facing = (ball.position_m - player.position()).normalize_or(Vec2::X);
    let mut obstacles = player.obstacles();
    obstacles.add(ball.position_m, 0.5);
    if let Some((pass, _)) = memory.expected_pass {
        let behind = (player.opponent_goal() - pass.place).normalize_or(Vec2::X) * -0.25;
        let place = pass.place + behind;
        let walk = player.go_and_stay(place, facing, &obstacles);
        return Decision { walk, target: Some(place), intention: "receive", ..default() };
    }
    let times = opponents.iter().map(|opponent| time_to_ball_s(player, ball, opponent.position_m));
    let theirs_s = times.fold(f32::MAX, f32::min);
    let mates = player.belief.team_mates.iter().filter(|mate| mate.age_s < FRESH_TEAM_MATE_S);
    let ours_s = mates.map(|mate| time_to_ball_s(player, ball, mate.position_m)).fold(f32::MAX, f32::min);
    let place = if theirs_s + FALL_BACK_S < ours_s || ball.position_m.x < -OWN_THIRD * player.pitch.half_length() {
        memory.free_place = None;
        guard_place(player, ball)
    } else {
        free_place(player, memory, ball, opponents)
    };
    let walk = player.go_and_stay(place, facing, &obstacles);
    Decision { walk, target: Some(place), intention: "support", ..default() }
}

/// Between the ball and that side of the own goal on which the player is, outside the penalty area.
fn guard_place(player: &Player, ball: &BallBelief) -> Vec2 {
    let ball = rolled(ball.position_m, ball.velocity_mps, player.rolling, 1.0);
    let to_goal = player.own_goal() - ball;
    let side = if to_goal.perp_dot(player.position() - ball) * to_goal.x > 0.0 { 1.0 } else { -1.0 };
    let goal = player.own_goal() + Vec2::new(0.0, side * BESIDE_KEEPER_M);
    // On a large pitch, the penalty area alone is deeper than that.
    let least = player.pitch.penalty_area.depth_m + 0.35;
    let away = (0.5 * ball.distance(goal)).min(MOST_GUARD_M).max(least);
    goal + (ball - goal).normalize_or(Vec2::X) * away
}

/// The place from which a pass would lead to the best chance.
fn free_place(player: &Player, memory: &mut PlayerMemory, ball: &BallBelief, opponents: &[RobotBelief]) -> Vec2 {
    let ball = ball.position_m;
    let (length, width) = (player.pitch.half_length(), player.pitch.half_width());
    let value = |place: Vec2| {
        let distance = place.distance(ball);
        let in_range = (PASS_RANGE_M[0]..PASS_RANGE_M[1]).contains(&distance);
        let way_s = place.distance(player.position()) / player.limits.max_linear_mps.max(1e-3);
        let chance = 0.1 + shot_value(place, opponents, player.pitch);
        let free = 0.2 + freedom(place, opponents);
        let open = 0.2 + lane(ball, place, opponents, player.kicks.direction_sd);
        if in_range { chance * free * open / (1.0 + 0.1 * way_s) } else { 0.0 }
    };
    let mut best = memory.free_place.map_or((0.0, player.position()), |place| (PLACE_PREFERENCE * value(place), place));
    for x in [0.2, 0.35, 0.5, 0.65] {
        for y in [-0.55, -0.3, 0.0, 0.3, 0.55] {
            let place = Vec2::new(x * length, y * width);
            let worth = value(place);
            if worth > best.0 {
                best = (worth, place);
            }
        }
    }
    memory.free_place = Some(best.1);
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::communication::{ReceivedMessage, TeamMessage};
    use crate::geometry::Pose;
    use crate::team::{RobotId, Team};
    use crate::teams::player::tests::PlayerFixture;

    fn mate(number: u8, x: f32, y: f32) -> RobotBelief {
        let id = Some(RobotId::new(Team::Blue, number));
        RobotBelief { id, position_m: Vec2::new(x, y), covariance: [0.01, 0.0, 0.01], age_s: 0.0 }
    }

    fn opponent(x: f32, y: f32) -> RobotBelief {
        RobotBelief { id: None, ..mate(1, x, y) }
    }

    fn said(number: u8, say: TeamMessage) -> ReceivedMessage {
        ReceivedMessage { from: RobotId::new(Team::Blue, number), sent_cycle: 0, say }
    }

    #[test]
    fn who_stands_free_before_the_goal_gets_the_ball_and_is_told_so() {
        let mut situation = PlayerFixture::new(Pose::new(-0.2, 0.0, 0.0), Vec2::ZERO);
        situation.belief.team_mates = vec![mate(3, 1.6, 0.8)];
        // The direct way is blocked.
        situation.belief.opponents = vec![opponent(0.8, -0.1), opponent(2.7, 0.0)];
        let decision = decide(&situation.player(), &mut PlayerMemory::default());
        let pass = decision.pass.expect("a pass");
        assert!(pass.to == 3 && pass.place.distance(Vec2::new(1.6, 0.8)) < 0.3, "{pass:?}");
        // An opponent on the way of the pass, whom only a team-mate sees.
        let robots_m = vec![Vec2::new(0.9, 0.45)];
        situation.heard = vec![said(3, TeamMessage { robots_m, ..default() })];
        assert_eq!(decide(&situation.player(), &mut PlayerMemory::default()).pass, None);
    }

    #[test]
    fn whoever_is_told_of_a_pass_goes_where_it_will_come() {
        let mut situation = PlayerFixture::new(Pose::new(0.5, 1.2, 0.0), Vec2::new(-1.0, -0.5));
        situation.belief.team_mates = vec![mate(3, -1.2, -0.5)];
        let announced = TeamMessage { payload: Some("pass 2 1.50 0.20".into()), ..default() };
        situation.heard = vec![said(3, announced)];
        let mut memory = PlayerMemory::default();
        let decision = decide(&situation.player(), &mut memory);
        assert_eq!(decision.intention, "receive");
        let step = situation.player().forward.rotate(decision.walk.translation());
        assert!(step.dot(Vec2::new(1.0, -1.0)) > 0.0, "{step}");
        // A pass for somebody else is not its business.
        situation.heard = vec![said(3, TeamMessage { payload: Some("pass 4 1.50 0.20".into()), ..default() })];
        assert_ne!(decide(&situation.player(), &mut PlayerMemory::default()).intention, "receive");
    }

    #[test]
    fn who_falls_back_covers_the_side_of_the_goal_on_which_it_is() {
        let ball = BallBelief { position_m: Vec2::new(-1.0, 0.0), ..default() };
        for side in [1.0, -1.0] {
            let situation = PlayerFixture::new(Pose::new(-1.5, 0.3 * side, 0.0), ball.position_m);
            let place = guard_place(&situation.player(), &ball);
            // On the line from (-1, 0) to (-3, 0.4), half-way.
            assert!(place.distance(Vec2::new(-2.0, 0.2 * side)) < 0.05, "{place}");
        }
    }

    #[test]
    fn on_a_large_pitch_it_stands_just_outside_the_penalty_area() {
        let ball = BallBelief { position_m: Vec2::new(-1.0, 0.0), ..default() };
        let mut situation = PlayerFixture::new(Pose::new(-1.5, 0.3, 0.0), ball.position_m);
        // That of the pitch of 2025: 1.65 m deep.
        situation.pitch.penalty_area.depth_m = 1.65;
        let place = guard_place(&situation.player(), &ball);
        assert!((place.distance(Vec2::new(-3.0, BESIDE_KEEPER_M)) - 2.0).abs() < 1e-4, "{place}");
    }

    #[test]
    fn when_the_opponents_have_the_ball_it_stands_before_the_own_goal() {
        let mut situation = PlayerFixture::new(Pose::new(0.5, 1.2, 0.0), Vec2::new(0.0, -1.0));
        situation.belief.team_mates = vec![mate(3, 0.6, -0.8)];
        situation.belief.opponents = vec![opponent(0.3, -1.0)];
        let mut memory = PlayerMemory::default();
        let decision = decide(&situation.player(), &mut memory);
        let step = situation.player().forward.rotate(decision.walk.translation());
        assert!(decision.intention == "support" && step.x < 0.0, "{decision:?}");
    }
}
