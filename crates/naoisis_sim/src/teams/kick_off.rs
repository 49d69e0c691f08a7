//! What the rules require of every player at a kick-off: its place, its half, and the centre circle.

use bevy::prelude::*;

use super::penalty_kicks;
use super::player::{Decision, Player, PlayerMemory};
use super::walk_limits::{after, braked, kept_out};
use naoisis_core::game::GameState;
use naoisis_core::geometry::{Pose, angle_of, unrotate};
use naoisis_core::pitch::End;
use naoisis_core::referee::formation;
use naoisis_core::robot::motion::WalkCommand;
use naoisis_sensing::belief::BallBelief;

/// The distance that a player keeps from the centre circle at the opponents' kick-off, m.
const CIRCLE_MARGIN_M: f32 = 0.2;
/// A player walks away from the circle if it is nearer than this, m.
const CIRCLE_SWAY_M: f32 = 0.05;
/// The distance that a player keeps from the halfway line before the ball is in play, m.
const HALF_MARGIN_M: f32 = 0.15;
/// A player stands still within this distance of its place and this angle of its facing: m, radians.
const IN_PLACE: (f32, f32) = (0.05, 0.15);
/// The greatest age of the place of a team-mate that may take the kick-off, s.
const FRESH_S: f32 = 1.5;

/// Limits a decision to what the rules allow until the ball is in play.
pub(super) fn apply(player: &Player, memory: &PlayerMemory, decision: Decision) -> Decision {
    match player.kick_off_team(memory) {
        Some(team) if team != player.id.team => {
            let decision = stay_off_the_circle(player, decision);
            if player.rules.kick_off_free_s.is_some() { stay_in_the_own_half(player, decision) } else { decision }
        }
        Some(_) if player.rules.kick_off_free_s.is_some() => {
            leave_the_kick_off_to_a_mate(player, stay_in_the_own_half(player, decision))
        }
        _ => decision,
    }
}

/// Walks to the player's place for the kick-off or the penalty kick, and stands there.
pub fn take_place(player: &Player) -> Decision {
    let place = penalty_kicks::place(player).unwrap_or_else(|| kick_off_place(player));
    let (near_m, turned) = IN_PLACE;
    let off = angle_of(unrotate(player.forward, place.forward())).abs();
    let stands = place.position.distance_squared(player.position()) < near_m * near_m && off < turned;
    let walk = if stands {
        WalkCommand::default()
    } else {
        player.travel_to(place.position, place.forward(), &player.obstacles())
    };
    Decision { walk, target: Some(place.position), intention: "ready", ..default() }
}

/// The player's place for the kick-off, team frame.
fn kick_off_place(player: &Player) -> Pose {
    let kicking_off = player.status.kick_off_team == player.id.team && !player.status.drop_ball;
    formation(player.pitch, player.rules.team_size, player.role_number(player.id), End::NegativeX, kicking_off)
}

/// Records in `memory` when a kick-off begins and ends: it ends when the ball has left the mark, or after a time.
pub fn note_kick_off(player: &Player, memory: &mut PlayerMemory) {
    /// After this time the ball is free for everybody, s (2025 rule book).
    const KICK_OFF_S: f32 = 10.0;
    /// A ball this far from the centre mark is in play, m.
    const IN_PLAY_M: f32 = 0.2;
    /// The greatest mean speed of a ball from the mark, m/s.
    const FASTEST_MPS: f32 = 4.0;
    /// The error of the believed place of a ball, as a share of its distance, for a robot whose cameras sway: of the team that kicks off, and
    /// of the other one, which is penalised if it is wrong.
    const SWAY_SHARES: [f32; 2] = [0.12, 0.2];
    /// How long the ball has to be seen in play, s: something else may be taken for a ball in single images.
    const SURE_AFTER_S: f32 = 0.2;
    let now = player.status.time_s;
    let placed = match memory.restarts {
        // At the start of the match, a player at its kick-off place has been placed there.
        None => kick_off_place(player).position.distance(player.position()) < 0.1,
        Some(restarts) => restarts != player.status.restarts,
    };
    memory.restarts = Some(player.status.restarts);
    let waits = matches!(player.status.state, GameState::Ready | GameState::Set);
    let begins = memory.waited_for_kick_off && player.status.state == GameState::Playing;
    memory.waited_for_kick_off = waits;
    if placed || begins {
        *memory = PlayerMemory {
            restarts: memory.restarts,
            whistles: memory.whistles,
            spoke_at_s: memory.spoke_at_s,
            waited_for_kick_off: waits,
            kick_off_since_s: (!player.status.drop_ball).then_some(now),
            last_glance_s: now,
            ..default()
        };
    }
    let share = SWAY_SHARES[usize::from(player.status.kick_off_team != player.id.team)];
    let (sway, sure_after_s) = if player.walks_in_steps() { (share, SURE_AFTER_S) } else { (0.0, 0.0) };
    let is_in_play = |ball: &BallBelief, for_s: f32| {
        let least_m = IN_PLAY_M + sway * ball.position_m.distance(player.position());
        let from_mark_m2 = ball.position_m.length_squared();
        // A ball that was seen before, or that no kick has brought there since, is not the one on the mark. Robots without a gait do not
        // need this: they see the ball on the mark at once.
        let most_m = IN_PLAY_M + FASTEST_MPS * for_s;
        let may_be_it = player.motion.gait.is_none() || ball.age_s < for_s && from_mark_m2 < most_m * most_m;
        may_be_it && from_mark_m2 > least_m * least_m
    };
    let is_over = |for_s: f32| for_s > KICK_OFF_S || player.ball().is_some_and(|ball| is_in_play(ball, for_s));
    match memory.kick_off_since_s {
        Some(since) if is_over(now - since) => {
            let seen_since_s = *memory.kick_off_over_since_s.get_or_insert(now);
            if now - seen_since_s >= sure_after_s {
                (memory.kick_off_since_s, memory.kick_off_over_since_s) = (None, None);
            }
        }
        _ => memory.kick_off_over_since_s = None,
    }
}

/// Keeps the player in its own half, or in the centre circle at the own kick-off, before the ball is in play: it brakes before the halfway
/// line.
fn stay_in_the_own_half(player: &Player, decision: Decision) -> Decision {
    let then = after(player, &decision.walk);
    if then.length() < player.pitch.centre_circle_diameter_m / 2.0 {
        return decision;
    }
    Decision { walk: kept_out(player, decision.walk, |place| place.x + HALF_MARGIN_M), ..decision }
}

/// Keeps the player outside the centre circle at the own kick-off if a team-mate takes it: only one player may be in the circle.
fn leave_the_kick_off_to_a_mate(player: &Player, decision: Decision) -> Decision {
    let radius = player.pitch.centre_circle_diameter_m / 2.0;
    if !is_kick_off_of_a_mate(player) {
        return decision;
    }
    Decision { walk: braked(player, decision.walk, Vec2::ZERO, radius + CIRCLE_SWAY_M), kick: None, ..decision }
}

/// Whether a team-mate takes the own kick-off: it is nearer to the ball, or about as near and has the lower number.
fn is_kick_off_of_a_mate(player: &Player) -> bool {
    /// A player with a lower number takes the kick-off if it is at most this much further away, m.
    const ABOUT_AS_NEAR_M: f32 = 0.4;
    let own_m = player.position().length();
    player.belief.team_mates.iter().filter(|mate| mate.age_s < FRESH_S).any(|mate| {
        let Some(id) = mate.id.filter(|id| !player.is_goalkeeper(*id)) else { return false };
        let margin_m = if id.number < player.id.number { ABOUT_AS_NEAR_M } else { -ABOUT_AS_NEAR_M };
        mate.position_m.length() < own_m + margin_m
    })
}

/// Keeps the player outside the centre circle: it brakes before the circle, and walks out if it is inside.
fn stay_off_the_circle(player: &Player, decision: Decision) -> Decision {
    let radius = player.pitch.centre_circle_diameter_m / 2.0;
    let decision = Decision { kick: None, ..decision };
    let away = player.position();
    if player.motion.gait.is_some() && away.length() < radius + CIRCLE_SWAY_M {
        let outwards = Vec2::new(away.x.min(0.0), away.y).normalize_or(-Vec2::X);
        let place = outwards * (radius + CIRCLE_MARGIN_M);
        // Backwards, with the ball in view.
        let walk = player.walk_to(place, -outwards, &player.obstacles());
        return Decision { walk, target: Some(place), ..decision };
    }
    Decision { walk: braked(player, decision.walk, Vec2::ZERO, radius + CIRCLE_MARGIN_M), ..decision }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use naoisis_core::robot::gait::Gait;
    use naoisis_core::robot::motion::MotionSettings;
    use naoisis_core::team::Team;
    use naoisis_sensing::belief::Belief;

    fn walking(dx: f32, dy: f32) -> Decision {
        Decision { walk: WalkCommand { dx, dy, dtheta: 0.01 }, ..default() }
    }

    #[test]
    fn a_kick_off_is_over_when_the_ball_is_seen_away_from_the_mark() {
        let mut situation = PlayerFixture::new(Pose::new(-1.5, 0.9, 0.0), Vec2::ZERO);
        situation.motion.gait = Some(Gait::default());
        let is_over = |situation: &mut PlayerFixture, time_s: f32, ball: (f32, f32)| {
            let ball = BallBelief { position_m: Vec2::new(ball.0, 0.0), age_s: ball.1, ..default() };
            situation.belief = Belief { ball: Some(ball), ..situation.belief.clone() };
            let restarts = Some(situation.status.restarts);
            let mut memory = PlayerMemory { restarts, kick_off_since_s: Some(10.0), ..default() };
            for time_s in [time_s, time_s + 0.25] {
                situation.status.time_s = time_s;
                note_kick_off(&situation.player(), &mut memory);
            }
            memory.kick_off_since_s.is_none()
        };
        assert!(is_over(&mut situation, 11.0, (1.0, 0.1)));
        assert!(!is_over(&mut situation, 11.0, (0.1, 0.1)));
        // It was seen before the whistle, where the goal was scored.
        assert!(!is_over(&mut situation, 11.0, (2.5, 3.0)));
        // No kick brings a ball 2.5 m away in 0.1 s.
        assert!(!is_over(&mut situation, 10.1, (2.5, 0.0)));
        assert!(is_over(&mut situation, 20.1, (0.1, 0.1)));
    }

    #[test]
    fn a_ball_that_is_seen_elsewhere_in_a_single_image_is_not_in_play() {
        let mut situation = PlayerFixture::new(Pose::new(-1.5, 0.9, 0.0), Vec2::ZERO);
        situation.motion.gait = Some(Gait::default());
        let restarts = Some(situation.status.restarts);
        let mut memory = PlayerMemory { restarts, kick_off_since_s: Some(10.0), ..default() };
        for cycle in 0..200 {
            situation.status.time_s = 11.0 + cycle as f32 / 30.0;
            let x = if cycle % 5 == 0 { 1.0 } else { 0.05 };
            let ball = BallBelief { position_m: Vec2::new(x, 0.0), ..default() };
            situation.belief = Belief { ball: Some(ball), ..situation.belief.clone() };
            note_kick_off(&situation.player(), &mut memory);
        }
        assert_eq!(memory.kick_off_since_s, Some(10.0));
    }

    #[test]
    fn of_two_players_as_near_to_the_ball_the_one_with_the_lower_number_takes_the_kick_off() {
        let mut situation = PlayerFixture::new(Pose::new(-1.5, 0.9, 0.0), Vec2::ZERO);
        let leaves_it = |situation: &mut PlayerFixture, number: u8, mate: (u8, f32)| {
            situation.id.number = number;
            let id = Some(naoisis_core::team::RobotId::new(Team::Blue, mate.0));
            let position_m = Vec2::new(-1.5, mate.1);
            situation.belief.team_mates =
                vec![naoisis_sensing::belief::RobotBelief { id, position_m, covariance: [0.0; 3], age_s: 0.1 }];
            is_kick_off_of_a_mate(&situation.player())
        };
        assert!(leaves_it(&mut situation, 4, (3, -0.9)));
        assert!(!leaves_it(&mut situation, 3, (4, -0.9)));
        assert!(!leaves_it(&mut situation, 3, (4, 0.0)), "number 4 is 1.5 m away, number 3 1.75 m");
        assert!(!leaves_it(&mut situation, 4, (3, -2.0)), "number 3 is 2.5 m away");
    }

    /// Where a player with a gait stops that wants to walk ahead from `place`, m: it follows the braked command and brakes with its
    /// acceleration.
    fn stops_at(situation: &mut PlayerFixture, memory: &PlayerMemory, mut place: f32) -> f32 {
        let mut speed_mps = 0.6_f32;
        for _ in 0..400 {
            situation.belief.pose.position.x = place;
            let walk = apply(&situation.player(), memory, walking(0.6 / 30.0, 0.0)).walk;
            let wanted_mps = walk.dx * 30.0;
            speed_mps = wanted_mps.clamp(speed_mps - 0.55 / 30.0, speed_mps + 0.55 / 30.0);
            place += speed_mps / 30.0;
        }
        place
    }

    #[test]
    fn players_with_a_gait_brake_before_the_halfway_line() {
        let gait = Gait { acceleration_mps2: 0.55, step_s: 0.25, ..Gait::default() };
        let mut situation = PlayerFixture::new(Pose::new(-1.9, 1.2, 0.0), Vec2::ZERO);
        situation.motion = MotionSettings { max_linear_mps: 0.6, gait: Some(gait), ..MotionSettings::default() };
        situation.rules.kick_off_free_s = Some(10.0);
        let memory = PlayerMemory { kick_off_since_s: Some(0.0), ..default() };
        for team in [Team::Blue, Team::Pink] {
            situation.status.kick_off_team = team;
            let place = stops_at(&mut situation, &memory, -1.9);
            assert!((-0.4..0.0).contains(&place), "{team}: {place}");
        }
    }

    #[test]
    fn players_with_a_gait_brake_before_the_circle_and_walk_out_of_it() {
        let mut situation = PlayerFixture::new(Pose::new(-1.9, 0.0, 0.0), Vec2::ZERO);
        let gait = Gait { acceleration_mps2: 0.55, step_s: 0.25, ..Gait::default() };
        situation.motion = MotionSettings { max_linear_mps: 0.6, gait: Some(gait), ..MotionSettings::default() };
        let memory = PlayerMemory { kick_off_since_s: Some(0.0), ..default() };
        situation.status.kick_off_team = Team::Pink;
        let radius = situation.pitch.centre_circle_diameter_m / 2.0;
        let place = stops_at(&mut situation, &memory, -radius - 2.0);
        assert!(-place > radius + 0.1 && -place < radius + 0.4, "{place}");
        // Inside, it leaves.
        situation.belief.pose.position.x = -radius + 0.1;
        assert!(apply(&situation.player(), &memory, walking(0.0, 0.0)).walk.dx < 0.0);
    }

    #[test]
    fn a_player_in_its_place_for_the_kick_off_stands_still() {
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::ZERO);
        situation.status.state = GameState::Ready;
        let place = kick_off_place(&situation.player());
        assert!(!take_place(&situation.player()).walk.is_null());
        situation.belief.pose = Pose { position: place.position + Vec2::new(0.03, 0.03), ..place };
        assert!(take_place(&situation.player()).walk.is_null());
        situation.belief.pose.heading += 0.3;
        assert!(!take_place(&situation.player()).walk.is_null());
    }
}
