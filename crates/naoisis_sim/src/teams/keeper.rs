//! The keeper stays between the ball and the goal, steps or dives into shots, and clears a ball that comes near.

use bevy::prelude::*;

use super::attack::attack;
use super::player::{Decision, Player, PlayerMemory};
use super::roles::{FRESH_TEAM_MATE_S, TURN_PREFERENCE_S, time_to_ball_s};
use super::worth::reach_m;
use naoisis_core::behaviour::reasons::{Choice, Reasons};
use naoisis_core::kick_geometry::Side;
use naoisis_core::pitch::End;
use naoisis_core::robot::posture::PostureRequest;
use naoisis_sensing::belief::{BallBelief, RobotBelief};
use std::borrow::Cow;

/// Distance of the keeper's place from the middle of the goal line, m.
const GUARD_DISTANCE_M: f32 = 0.45;
/// The same if kicks are exact, m: they are aimed past the keeper, which covers more of the goal from further out.
const GUARD_AGAINST_EXACT_KICKS_M: f32 = 0.8;
/// The least distance of the keeper's place from the goal line, m.
const LEAST_DEPTH_M: f32 = 0.2;
/// A ball nearer to the goal than this is cleared, m.
const CLEAR_DISTANCE_M: f32 = 1.1;
/// A keeper that clears the ball gives up when the ball is further away than [`CLEAR_DISTANCE_M`] by this, m.
const GIVE_UP_M: f32 = 0.3;
/// The keeper also goes for a ball that is this far from the goal, as the time to walk there, s, if it is the first at the ball.
const SWEEP_S: f32 = 5.5;
/// The least advantage over opponents at such a ball, s.
const SWEEP_LEAD_S: f32 = 0.5;
/// A keeper that walks in steps also goes for a ball that is this far from the goal, as the time to walk there, s, if nobody else is near.
const FAR_SWEEP_S: f32 = 12.0;
/// The least advantage over opponents at such a ball, s: enough to kick it.
const FAR_SWEEP_LEAD_S: f32 = 5.0;
/// The least advantage over team-mates at such a ball, s.
const FAR_SWEEP_LEAD_OVER_MATES_S: f32 = 2.0;
/// The least speed of a shot, m/s.
const SHOT_SPEED_MPS: f32 = 0.2;

/// Decides for a keeper.
pub fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
    keep(player, memory, guard_distance_m(player), CLEAR_DISTANCE_M, attack)
}

/// The distance of the keeper from the middle of the goal line while the ball is far away, m.
fn guard_distance_m(player: &Player) -> f32 {
    let is_exact = player.kicks.types().all(|kick| player.kicks.direction_sd_of(kick) == 0.0);
    if is_exact { GUARD_AGAINST_EXACT_KICKS_M } else { GUARD_DISTANCE_M }
}

/// Keeps the goal at the distance `guard_m`, and clears the ball with `clear` when it is nearer to the goal than `clear_m`.
pub fn keep(
    player: &Player,
    memory: &mut PlayerMemory,
    guard_m: f32,
    clear_m: f32,
    clear: impl FnOnce(&Player, &mut PlayerMemory) -> Decision,
) -> Decision {
    let goal = player.own_goal();
    let Some(ball) = player.ball() else {
        memory.attacks = false;
        let place = goal + Vec2::new(guard_m, 0.0);
        let walk = player.go_and_stay(place, Vec2::X, &player.obstacles());
        let head = Some(player.head.search(player.status.time_s));
        return Decision { walk, target: Some(place), head, intention: "keep", ..default() };
    };
    let (position, velocity) = (ball.position_m, ball.velocity_mps);
    if let Some(y) = crossing(position, velocity, player.position().x, half_goal_m(player)) {
        memory.attacks = false;
        let posture = dive(player, position, velocity, y);
        let place = Vec2::new(player.position().x, y);
        let walk = player.walk_to(place, Vec2::X, &default());
        return Decision { walk, target: Some(place), posture, intention: "save", ..default() };
    }
    memory.attacks = clearing(player, memory, ball, clear_m).0 > 0.0;
    if memory.attacks {
        return clear(player, memory);
    }
    memory.kick = None;
    let out_m = guard_m.max(coming_out_m(player, position.distance(goal)));
    let place = guard_place(position, goal, player.pitch.goal.width_m / 2.0, out_m);
    let facing = (position - player.position()).normalize_or(Vec2::X);
    let walk = player.go_and_stay(place, facing, &player.obstacles());
    Decision { walk, target: Some(place), intention: "keep", ..default() }
}

/// Returns how far the ball is within the keeper's reach, m, and why if it is not by the distance from the goal. The keeper clears the ball
/// if this is positive.
fn clearing(player: &Player, memory: &PlayerMemory, ball: &BallBelief, clear_m: f32) -> (f32, Option<&'static str>) {
    /// The reach to a ball that the keeper clears or leaves whatever its distance, m.
    const BY_RULE_M: f32 = 0.1;
    let position = ball.position_m;
    let clear_distance = if memory.attacks { clear_m + GIVE_UP_M } else { clear_m };
    let distance = position.distance(player.own_goal());
    let is_nearer = |mate: &RobotBelief| {
        mate.age_s < 1.0 && mate.position_m.distance(position) < 0.6 * player.position().distance(position)
    };
    let is_within_s = |time_s: f32| (clear_distance..time_s * player.motion.max_linear_mps).contains(&distance);
    let sweeps = (is_within_s(SWEEP_S) && is_first_at(player, memory, position, SWEEP_LEAD_S, 0.0))
        || (player.walks_in_steps()
            && is_within_s(FAR_SWEEP_S)
            && is_first_at(player, memory, position, FAR_SWEEP_LEAD_S, FAR_SWEEP_LEAD_OVER_MATES_S));
    if ball.velocity_mps.length() >= SHOT_SPEED_MPS {
        (-BY_RULE_M, Some("the ball is too fast"))
    } else if player.is_own_area_for_keeper_only() && player.pitch.in_penalty_area(End::NegativeX, position) {
        (BY_RULE_M, Some("only the keeper may play the ball in its area"))
    } else if sweeps {
        (BY_RULE_M, Some("it is the first at the ball"))
    } else if distance < clear_distance && player.belief.team_mates.iter().any(is_nearer) {
        (-BY_RULE_M, Some("a team-mate is nearer"))
    } else {
        (clear_distance - distance, None)
    }
}

/// Returns the reasons for the keeper's decision.
pub fn reasons(player: &Player, before: PlayerMemory, decision: &Decision) -> Reasons {
    reasons_at(player, &before, decision, CLEAR_DISTANCE_M)
}

/// Returns the reasons for the decision of a keeper that clears the ball when it is nearer to the goal than `clear_m`. An option with a
/// positive value is due; staying in the goal has zero. `before` is the player's memory before the decision.
pub(super) fn reasons_at(player: &Player, before: &PlayerMemory, decision: &Decision, clear_m: f32) -> Reasons {
    let Some(ball) = player.ball() else { return Reasons::default() };
    let (position, speed) = (ball.position_m, -ball.velocity_mps.x);
    let chosen = match decision.intention {
        "attack" | "kick" => "clear",
        taken @ ("save" | "keep") => taken,
        // Something that the rules demand.
        _ => return Reasons::default(),
    };
    let (reach_m, why) = clearing(player, before, ball, clear_m);
    let distance = position.distance(player.own_goal());
    let why = why.map_or_else(|| format!("the ball is {distance:.1} m from the goal").into(), Cow::Borrowed);
    // A save comes before everything else.
    let save = match crossing(position, ball.velocity_mps, player.position().x, half_goal_m(player)) {
        Some(_) => (reach_m.max(0.0) + speed, "the ball comes towards the goal"),
        None if speed > SHOT_SPEED_MPS => (-speed, "the ball passes beside the goal"),
        None => (speed - SHOT_SPEED_MPS, "the ball comes"),
    };
    let save_words = match speed {
        0.05.. => format!("{} at {speed:.1} m/s", save.1),
        _ => "the ball does not come".to_owned(),
    };
    let options = vec![
        Choice::new("save", save.0, save_words),
        Choice::new("clear", reach_m, why),
        Choice::new("keep", 0.0, "otherwise"),
    ];
    Reasons::of(options, chosen)
}

/// Half of the width in which the keeper saves balls, m.
fn half_goal_m(player: &Player) -> f32 {
    0.5 * player.pitch.goal.width_m + 0.15
}

/// Whether the keeper is sooner behind the ball than the opponents by `lead_s`, and than its team-mates by `lead_over_mates_s`.
fn is_first_at(player: &Player, memory: &PlayerMemory, ball: Vec2, lead_s: f32, lead_over_mates_s: f32) -> bool {
    let preference = if memory.attacks { TURN_PREFERENCE_S } else { 0.0 };
    let own_s = time_to_ball_s(player, player.position(), ball) - preference;
    let belief = player.belief;
    // Opponents play the other way: their time is computed on the pitch turned by a half turn.
    belief.opponents.iter().all(|other| own_s + lead_s < time_to_ball_s(player, -other.position_m, -ball))
        && belief
            .team_mates
            .iter()
            .filter(|mate| mate.age_s < FRESH_TEAM_MATE_S)
            .all(|mate| own_s + lead_over_mates_s < time_to_ball_s(player, mate.position_m, ball))
}

/// A dive, if the keeper reaches a shot that crosses its line at `y` only by a dive.
fn dive(player: &Player, ball: Vec2, velocity: Vec2, y: f32) -> Option<PostureRequest> {
    /// A standing NAO stops a ball that passes within this distance, m; other robots in proportion.
    const BODY_M: f32 = 0.12;
    /// The keeper does not dive so early that it would be down longer than this before the ball arrives, s.
    const EARLY_S: f32 = 0.7;
    /// It does not dive so late that the ball would arrive longer than this before it is down, s: the ball slows down on its way.
    const LATE_S: f32 = 0.15;
    let way = y - player.position().y;
    let time_s = (ball.x - player.position().x) / -velocity.x;
    let body_m = BODY_M * player.own_body.width_in_naos();
    let sideways_mps = player.motion.gait.map_or(player.motion.max_linear_mps, |gait| gait.sideways_mps);
    let walks = sideways_mps * time_s + body_m;
    let reaches = player.rules.dive_reach_m + body_m;
    let faces_ball = player.forward.x > 0.8 && player.body.is_free();
    let in_time = (-LATE_S..EARLY_S).contains(&(time_s - player.rules.dive_down_s));
    let pays = player.rules.dives && faces_ball && in_time && way.abs() > walks && way.abs() < reaches;
    pays.then_some(PostureRequest::Dive(if way > 0.0 { Side::Left } else { Side::Right }))
}

/// How far the keeper comes out towards a ball at `distance` from the middle of the goal, m: nearer to the ball, it covers more of the
/// goal. Zero for a ball that is too far away for a shot.
fn coming_out_m(player: &Player, distance: f32) -> f32 {
    /// Shots are expected from this share of the reach of kicks.
    const SHOT_RANGE_SHARE: f32 = 0.75;
    /// The keeper comes out over this share of the way to the ball.
    const SHARE_OF_WAY: f32 = 0.5;
    /// It stays near enough to walk back within this time, s.
    const BACK_S: f32 = 5.0;
    if distance > SHOT_RANGE_SHARE * reach_m(player) {
        return 0.0;
    }
    let back_mps = player.motion.gait.map_or(player.motion.max_linear_mps, |gait| gait.backward_mps);
    (SHARE_OF_WAY * distance).min(BACK_S * back_mps)
}

/// The keeper's place between the ball and the middle of the goal, `guard_m` away from the latter.
fn guard_place(ball: Vec2, goal: Vec2, half_width: f32, guard_m: f32) -> Vec2 {
    let towards_ball = (ball - goal).normalize_or(Vec2::X);
    let place = goal + towards_ball * guard_m;
    let most = (half_width - 0.15).max(0.0);
    Vec2::new(place.x.max(goal.x + LEAST_DEPTH_M), place.y.clamp(-most, most))
}

/// The y at which a shot crosses the line x = `line_x`, if it is within `half_width` of the middle.
fn crossing(ball: Vec2, velocity: Vec2, line_x: f32, half_width: f32) -> Option<f32> {
    if velocity.x > -SHOT_SPEED_MPS || ball.x < line_x {
        return None;
    }
    let y = ball.y + velocity.y / velocity.x * (line_x - ball.x);
    (y.abs() < half_width).then_some(y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use approx::assert_abs_diff_eq;
    use naoisis_core::geometry::Pose;

    #[test]
    fn the_guard_stands_on_the_line_from_the_ball_to_the_goal() {
        let goal = Vec2::new(-3.0, 0.0);
        let place = guard_place(Vec2::new(-1.0, 1.0), goal, 0.7, GUARD_DISTANCE_M);
        // Along (2, 1) / √5, 0.45 m from the goal.
        assert_abs_diff_eq!(place, goal + Vec2::new(0.4025, 0.2012), epsilon = 1e-3);
        assert!(guard_place(Vec2::new(-2.9, 2.0), goal, 0.7, GUARD_DISTANCE_M).x >= -2.8);
    }

    #[test]
    fn the_guard_stands_further_out_against_kicks_that_go_where_they_are_meant_to() {
        let mut situation = PlayerFixture::new(Pose::new(-2.7, 0.0, 0.0), Vec2::new(2.0, 0.0));
        let place =
            |situation: &PlayerFixture| decide(&situation.player(), &mut PlayerMemory::default()).target.unwrap();
        let own_goal_x = situation.player().own_goal().x;
        assert_abs_diff_eq!(place(&situation).x, own_goal_x + 0.8, epsilon = 1e-3);
        situation.kicks.direction_sd = 0.1;
        assert_abs_diff_eq!(place(&situation).x, own_goal_x + 0.45, epsilon = 1e-3);
    }

    #[test]
    fn the_keeper_comes_out_to_a_ball_that_can_be_shot_no_further_than_it_gets_back_in_time() {
        let mut situation = PlayerFixture::new(Pose::new(-2.7, 0.0, 0.0), Vec2::ZERO);
        let out = |situation: &PlayerFixture, distance: f32| coming_out_m(&situation.player(), distance);
        // 5 s at 0.2 m/s are 1 m; kicks reach 4 m.
        assert_eq!([out(&situation, 1.5), out(&situation, 2.5), out(&situation, 3.5)], [0.75, 1.0, 0.0]);
        situation.motion.gait = Some(naoisis_core::robot::gait::Gait { backward_mps: 0.1, ..default() });
        assert_eq!(out(&situation, 2.5), 0.5);
    }

    #[test]
    fn a_shot_that_cannot_be_walked_to_is_dived_for_where_the_rules_let_it() {
        let mut situation = PlayerFixture::new(Pose::new(-2.7, 0.0, 0.0), Vec2::ZERO);
        let dives = |situation: &PlayerFixture, y: f32| {
            // 1 m away at 2 m/s: half a second, in which it walks 10 cm.
            dive(&situation.player(), Vec2::new(-1.7, y), Vec2::new(-2.0, 0.0), y)
        };
        assert_eq!(dives(&situation, 0.4), None);
        situation.rules.dives = true;
        assert_eq!(dives(&situation, 0.4), Some(PostureRequest::Dive(Side::Left)));
        assert_eq!(dives(&situation, -0.4), Some(PostureRequest::Dive(Side::Right)));
        assert_eq!([dives(&situation, 0.2), dives(&situation, 0.7)], [None, None], "within a step; out of reach");
        situation.rules.dive_down_s = 0.6;
        assert!(dives(&situation, 0.4).is_some());
        situation.rules.dive_down_s = 0.7;
        assert_eq!(dives(&situation, 0.4), None, "too late");
        situation.body = naoisis_sensing::sensing::status::BodyStatus::Fallen;
        assert_eq!(dives(&situation, 0.4), None);
    }

    #[test]
    fn a_fast_keeper_leaves_for_a_ball_at_which_it_is_first_and_a_slow_one_stays() {
        let mut situation = PlayerFixture::new(Pose::new(-2.7, 0.0, 0.0), Vec2::new(-1.0, 0.0));
        let clears = |situation: &PlayerFixture| {
            let mut memory = PlayerMemory::default();
            decide(&situation.player(), &mut memory);
            memory.attacks
        };
        // 2 m from the goal: within 5.5 s of 0.5 m/s, and not of 0.2 m/s.
        assert!(!clears(&situation));
        situation.motion.max_linear_mps = 0.5;
        assert!(clears(&situation));
        let robot = |x: f32| RobotBelief { id: None, position_m: Vec2::new(x, 0.0), covariance: [0.0; 3], age_s: 0.0 };
        // The ball is 1.7 m from the keeper, 3.4 s.
        situation.belief.opponents = vec![robot(1.2)];
        assert!(clears(&situation), "4.4 s away");
        situation.belief.opponents = vec![robot(0.8)];
        assert!(!clears(&situation), "3.6 s away");
        situation.belief.opponents.clear();
        situation.belief.team_mates = vec![robot(-1.8)];
        assert!(!clears(&situation), "a team-mate is nearer");
    }

    #[test]
    fn a_keeper_that_walks_in_steps_takes_a_free_ball_that_nobody_else_is_near() {
        // 2 m from the goal at 0.2 m/s.
        let mut situation = PlayerFixture::new(Pose::new(-2.7, 0.0, 0.0), Vec2::new(-1.0, 0.0));
        let clears = |situation: &PlayerFixture, memory: &mut PlayerMemory| {
            decide(&situation.player(), memory);
            memory.attacks
        };
        assert!(!clears(&situation, &mut PlayerMemory::default()));
        situation.motion.gait = Some(naoisis_core::robot::gait::Gait::default());
        let mut memory = PlayerMemory::default();
        assert!(clears(&situation, &mut memory));
        let robot = |x: f32| RobotBelief { id: None, position_m: Vec2::new(x, 0.0), covariance: [0.0; 3], age_s: 0.0 };
        // The ball is 1.7 m from the keeper, 8.5 s: an opponent at 2.4 m is 17 s away, one at 1 m 10 s.
        situation.belief.opponents = vec![robot(2.4)];
        assert!(clears(&situation, &mut memory));
        situation.belief.opponents = vec![robot(1.0)];
        assert!(!clears(&situation, &mut PlayerMemory::default()));
    }

    #[test]
    fn a_shot_is_met_where_it_crosses() {
        // From (0, 1) along (-2, -0.5): at x = -2.5 it is at y = 1 - 0.25 * 2.5 = 0.375.
        let y = crossing(Vec2::new(0.0, 1.0), Vec2::new(-1.0, -0.25), -2.5, 0.85);
        assert_abs_diff_eq!(y.unwrap(), 0.375, epsilon = 1e-6);
        assert_eq!(crossing(Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.0), -2.5, 0.85), None);
        assert_eq!(crossing(Vec2::new(0.0, 1.0), Vec2::new(-1.0, 0.5), -2.5, 0.85), None);
        assert_eq!(crossing(Vec2::new(0.0, 1.0), Vec2::new(-0.01, 0.0), -2.5, 0.85), None);
    }
}
