//! The places of passers that do not go for the ball: where a pass was announced or could reach them, beside the ball, or between the
//! ball and the own goal.

use bevy::prelude::*;

use super::passing::{meet, rolled};
use super::player::{Decision, Player, PlayerMemory};
use super::roles::{passing_distance_m, time_around_ball_s};
use super::worth::{Company, is_slow, pass_worth, reach_m, walking_s};
use naoisis_core::geometry::unit;
use naoisis_sensing::belief::BallBelief;

/// Factor by which a new place to wait at must be better than the one chosen before.
const PLACE_PREFERENCE: f32 = 1.25;
/// The team falls back when opponents are sooner at the ball by this, s.
const FALL_BACK_S: f32 = 1.0;
/// A guard stands between the ball and a point this far beside the middle of the goal, as a share of its width: there the keeper does
/// not cover it.
const BESIDE_KEEPER: f32 = 0.29;
/// The greatest distance of a guard from the goal, as a share of the pitch's length. It stays outside the penalty area in any case.
const MOST_GUARD: f32 = 0.3;
/// The least distance of a guard from the goal, m, where it would otherwise be in the way of the player at the ball.
const NEAREST_GUARD_M: f32 = 0.8;
/// The whole team defends when the ball is further back than this share of the own half.
const OWN_THIRD: f32 = 0.33;
/// The distance that waiting players keep from team-mates, as a share of the kick's reach.
const APART_SHARE: f32 = 0.25;
/// Places to wait for a pass: their angles at the ball, from the direction of the goal, radians.
const WAITING_ANGLES: [f32; 6] = [0.2, -0.2, 0.6, -0.6, 1.1, -1.1];
/// The distances of these places from the ball, as shares of the kick's reach.
const WAITING_SHARES: [f32; 3] = [0.35, 0.55, 0.75];
/// The place of a covering NAO beside the ball, m: ahead towards the goal, and to the side. A side kick reaches it, and the ball is
/// near if it is lost. Measured: with a place further back, more balls are lost and fewer matches are won.
const COVER_M: Vec2 = Vec2::new(0.3, 1.3);
/// The place of a slow robot that waits for a pass, m: to a longer pass, opponents would be as soon as it.
const OFFER_M: Vec2 = Vec2::new(0.4, 1.4);
/// The distance of places beside the ball from the lines, m.
const INSIDE_M: f32 = 0.3;

/// Waits where a pass was announced or could arrive, or falls back when opponents are sooner at the ball.
pub(super) fn wait_for_the_ball(
    player: &Player,
    memory: &mut PlayerMemory,
    company: Company,
    ball: &BallBelief,
) -> Decision {
    let facing = (ball.position_m - player.position()).normalize_or(Vec2::X);
    let mut obstacles = player.obstacles();
    obstacles.add(ball.position_m, passing_distance_m(player));
    if let Some((pass, _)) = memory.expected_pass {
        let behind = (player.opponent_goal() - pass.place).normalize_or(Vec2::X) * -0.25;
        let place = pass.place + behind;
        let walk = player.go_and_stay(place, facing, &obstacles);
        return Decision { walk, target: Some(place), intention: "receive", ..default() };
    }
    let place = match job(player, company, ball) {
        Job::Cover => place_beside(player, company, ball.position_m, COVER_M),
        Job::Guard => guard_place(player, ball),
        Job::Offer if is_slow(player) => place_beside(player, company, ball.position_m, OFFER_M),
        Job::Offer => free_place(player, memory, company, ball.position_m),
    };
    let walk = player.go_and_stay(place, facing, &obstacles);
    Decision { walk, target: Some(place), intention: "support", ..default() }
}

/// The time that a player at `place` takes until it stands behind the ball where it meets it, s.
pub(super) fn time_to_ball_s(player: &Player, ball: &BallBelief, place: Vec2) -> f32 {
    let (meeting_place, time_s) =
        meet(ball.position_m, ball.velocity_mps, player.rolling, place, player.motion.max_linear_mps);
    time_s + time_around_ball_s(player, place, meeting_place)
}

/// The task of a player that does not go for the ball.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Job {
    /// Stands beside the attacker, for a side kick and for balls that come back.
    Cover,
    /// Stands between the ball and the own goal.
    Guard,
    /// Waits for a pass.
    Offer,
}

/// The jobs of this many waiting players, from the one furthest back to the one furthest ahead.
fn jobs(waiting: usize) -> &'static [Job] {
    use Job::{Cover, Guard, Offer};
    match waiting {
        0 | 1 => &[Offer],
        2 => &[Cover, Offer],
        3 => &[Guard, Cover, Offer],
        4 => &[Guard, Cover, Offer, Offer],
        5 => &[Guard, Cover, Cover, Offer, Offer],
        _ => &[Guard, Guard, Cover, Cover, Offer, Offer],
    }
}

/// The player's job among the waiting players.
fn job(player: &Player, company: Company, ball: &BallBelief) -> Job {
    let to_ball_s = |place: Vec2| time_to_ball_s(player, ball, place);
    let sooner = |best: f32, next: f32| best.min(next);
    let theirs_s = company.opponents.iter().map(|other| to_ball_s(other.position_m)).fold(f32::MAX, sooner);
    let ours_s = company.mates.iter().map(|(_, mate)| to_ball_s(*mate)).fold(to_ball_s(player.position()), sooner);
    // The player that is soonest at the ball goes for it.
    let waits = |place: Vec2| to_ball_s(place) > ours_s;
    let own = (player.position().x, player.id.number);
    let waiting = company.mates.iter().filter(|(_, mate)| waits(*mate));
    let (behind, others) = waiting
        .fold((0, 0), |(behind, others), (number, mate)| (behind + usize::from((mate.x, *number) < own), others + 1));
    let job = *jobs(others + 1).get(behind).unwrap_or(&Job::Cover);
    let falls_back = theirs_s + FALL_BACK_S < ours_s || ball.position_m.x < -OWN_THIRD * player.pitch.half_length();
    match (job, falls_back) {
        (Job::Offer, true) if others == 0 => Job::Guard,
        (Job::Offer, true) => Job::Cover,
        _ => job,
    }
}

/// The place of a guard: between the ball and the side of the own goal on which the player is, outside the penalty area. A guard that walks
/// in steps goes back into it, if the rules let it, rather than stand in the way of the player at the ball.
fn guard_place(player: &Player, ball: &BallBelief) -> Vec2 {
    let ball = rolled(ball.position_m, ball.velocity_mps, player.rolling, 1.0);
    let to_goal = player.own_goal() - ball;
    let side = if to_goal.perp_dot(player.position() - ball) * to_goal.x > 0.0 { 1.0 } else { -1.0 };
    let goal = player.own_goal() + Vec2::new(0.0, side * BESIDE_KEEPER * player.pitch.goal.width_m);
    // On a large pitch, the penalty area is deeper than that.
    let least = player.pitch.penalty_area.depth_m + 0.35;
    let distance = ball.distance(goal);
    let mut away = (0.5 * distance).min(MOST_GUARD * player.pitch.length_m).max(least);
    if player.walks_in_steps() && !player.is_own_area_for_keeper_only() {
        away = away.min((distance - passing_distance_m(player)).max(NEAREST_GUARD_M));
    }
    goal + (ball - goal).normalize_or(Vec2::X) * away
}

/// The place `offset_m` ahead of and beside the ball, for a NAO: on the player's side, or on the other one if a team-mate is nearer to
/// that place or it is outside the pitch.
fn place_beside(player: &Player, company: Company, ball: Vec2, offset_m: Vec2) -> Vec2 {
    let ahead = (player.opponent_goal() - ball).normalize_or(Vec2::X);
    let beside_m = offset_m.y + player.longer_than_nao_m() + player.wider_than_nao_m();
    let half = Vec2::new(player.pitch.half_length(), player.pitch.half_width()) - INSIDE_M;
    // Clear of the keeper.
    let least = Vec2::new(player.pitch.penalty_area.depth_m - half.x, -half.y);
    let place = |side: f32| ball + ahead * offset_m.x + ahead.perp() * side * beside_m;
    let at_ball = company.mates.iter().map(|(_, mate)| mate.distance_squared(ball)).fold(f32::MAX, f32::min);
    let own_side = if ahead.perp_dot(player.position() - ball) < 0.0 { -1.0 } else { 1.0 };
    let own_m = player.position().distance(place(own_side));
    let is_taken = company
        .mates
        .iter()
        .any(|(_, mate)| mate.distance_squared(ball) > at_ball && mate.distance(place(own_side)) < own_m);
    let is_outside = place(own_side).y.abs() > half.y;
    let side = if is_taken || is_outside { -own_side } else { own_side };
    place(side).clamp(least, half)
}

/// The place where a pass would be worth most, less for a longer way.
fn free_place(player: &Player, memory: &mut PlayerMemory, company: Company, ball: Vec2) -> Vec2 {
    let reach = reach_m(player);
    let half = Vec2::new(player.pitch.half_length() - 0.8, player.pitch.half_width() - 0.5);
    let value = |place: Vec2| {
        let way_s = walking_s(player, [player.position()], place);
        let mate_m = company.mates.iter().map(|(_, mate)| mate.distance(place)).fold(f32::MAX, f32::min);
        let apart = (mate_m / (APART_SHARE * reach)).min(1.0);
        let distance = ball.distance(place);
        let in_range = distance > 0.2 * reach && distance < 0.9 * reach;
        if in_range { apart * pass_worth(player, company, ball, place).max(0.01) / (1.0 + 0.1 * way_s) } else { 0.0 }
    };
    let towards_goal = (player.opponent_goal() - ball).normalize_or(Vec2::X);
    let mut best = memory.free_place.map_or((0.0, player.position()), |place| (PLACE_PREFERENCE * value(place), place));
    for angle in WAITING_ANGLES {
        let direction = unit(angle).rotate(towards_goal);
        for share in WAITING_SHARES {
            let place = (ball + direction * share * reach).clamp(-half, half);
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
    use crate::teams::player::tests::PlayerFixture;
    use naoisis_core::geometry::Pose;

    #[test]
    fn of_waiting_players_the_last_guards_and_the_foremost_offers_itself() {
        let mut situation = PlayerFixture::new(Pose::new(-1.0, 0.0, 0.0), Vec2::ZERO);
        let jobs = |situation: &PlayerFixture| {
            let player = situation.player();
            // Number 3 is at the ball.
            let mates = [(3, Vec2::new(-0.2, 0.0)), (4, Vec2::new(0.5, 0.8)), (5, Vec2::new(1.2, -0.8))];
            job(&player, Company { mates: &mates, opponents: &[] }, player.ball().unwrap())
        };
        // Of 2, 4 and 5, number 2 is the rearmost, then the one in the middle, then the foremost.
        assert_eq!(jobs(&situation), Job::Guard);
        situation.belief.pose.position = Vec2::new(0.8, 1.5);
        assert_eq!(jobs(&situation), Job::Cover);
        situation.belief.pose.position = Vec2::new(1.8, 1.5);
        assert_eq!(jobs(&situation), Job::Offer);
    }

    #[test]
    fn a_guard_covers_the_side_of_the_goal_on_which_it_is() {
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
        // The penalty area of the pitch of 2025: 1.65 m deep.
        situation.pitch.penalty_area.depth_m = 1.65;
        let place = guard_place(&situation.player(), &ball);
        assert!((place.distance(Vec2::new(-3.0, BESIDE_KEEPER * 1.4)) - 2.0).abs() < 1e-4, "{place}");
    }

    #[test]
    fn it_leaves_room_for_the_player_at_a_ball_before_the_own_area_where_the_rules_let_it_in() {
        // 0.3 m before the area of 1.65 m.
        let ball = BallBelief { position_m: Vec2::new(-1.05, 0.0), ..default() };
        let mut situation = PlayerFixture::new(Pose::new(-1.5, 0.3, 0.0), ball.position_m);
        situation.pitch.penalty_area.depth_m = 1.65;
        situation.motion.gait = Some(naoisis_core::robot::gait::Gait::default());
        let from_ball = |situation: &PlayerFixture| guard_place(&situation.player(), &ball).distance(ball.position_m);
        assert!(from_ball(&situation) > 0.6, "{}", from_ball(&situation));
        situation.rules.illegal_defender = true;
        situation.rules.defender_limit = naoisis_core::game::DefenderLimit::KeeperOnly;
        assert!(from_ball(&situation) < 0.1, "{}", from_ball(&situation));
    }

    #[test]
    fn a_covering_player_stands_on_its_own_side_of_the_ball_unless_a_team_mate_or_the_line_is_there() {
        let at = |own: Vec2, ball: Vec2, mates: &[(u8, Vec2)]| {
            let situation = PlayerFixture::new(Pose { position: own, heading: 0.0 }, ball);
            place_beside(&situation.player(), Company { mates, opponents: &[] }, ball, COVER_M)
        };
        let place = |side: f32| Vec2::new(0.3, side * 1.3);
        let left = Vec2::new(-1.0, 1.0);
        assert!(at(left, Vec2::ZERO, &[]).distance(place(1.0)) < 1e-4);
        assert!(at(left * Vec2::new(1.0, -1.0), Vec2::ZERO, &[]).distance(place(-1.0)) < 1e-4);
        // Number 3 goes for the ball, and does not compete for the place beside it.
        let at_ball = (3, Vec2::new(-0.1, 0.05));
        assert!(at(left, Vec2::ZERO, &[at_ball]).distance(place(1.0)) < 1e-4);
        assert!(at(left, Vec2::ZERO, &[at_ball, (4, Vec2::new(0.5, 1.0))]).distance(place(-1.0)) < 1e-4);
        // 0.5 m from the left line there is no room for 1.3 m.
        let beside_line = at(Vec2::new(-1.0, 1.8), Vec2::new(0.0, 1.5), &[]);
        assert!(beside_line.y < 0.7, "{beside_line}");
    }

    #[test]
    fn a_covering_player_stays_out_of_the_own_penalty_area() {
        let ball = Vec2::new(-2.9, 0.0);
        let situation = PlayerFixture::new(Pose::new(-2.0, 0.5, 0.0), ball);
        let company = Company { mates: &[], opponents: &[] };
        let place = place_beside(&situation.player(), company, ball, COVER_M);
        let area_m = situation.pitch.penalty_area.depth_m - situation.pitch.half_length();
        assert!(place.x >= area_m + INSIDE_M - 1e-4, "{place}");
    }
}
