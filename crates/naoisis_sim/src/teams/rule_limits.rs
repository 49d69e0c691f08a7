//! What the rules require of every player, whatever its role: kick-off places, distances to the ball, areas to stay out of, and
//! getting up after a fall.

use bevy::prelude::*;

use super::penalty_kicks;
use super::player::{Decision, Player, PlayerMemory};
use naoisis_core::game::{GameState, SetPlayKind};
use naoisis_core::geometry::{Pose, angle_of, unrotate};
use naoisis_core::pitch::End;
use naoisis_core::referee::formation;
use naoisis_core::robot::motion::WalkCommand;
use naoisis_core::robot::posture::PostureRequest;
use naoisis_sensing::sensing::status::BodyStatus;

/// The margin to the distance that the rules require at the opponents' free kick, m: the believed places of the player and of the ball
/// are not exact.
const DISTANCE_MARGIN_M: f32 = 0.35;
/// The distance that a player keeps from the centre circle at the opponents' kick-off, m.
const CIRCLE_MARGIN_M: f32 = 0.2;
/// A player walks away from the circle if it is nearer than this, m.
const CIRCLE_SWAY_M: f32 = 0.05;
/// The distance that a player keeps from the halfway line at the own kick-off, m.
const HALF_MARGIN_M: f32 = 0.15;
/// The distance that a field player keeps from its own penalty area, m.
const AREA_MARGIN_M: f32 = 0.05;
/// A field player leaves when it is nearer than [`AREA_MARGIN_M`] by this, m: as much as a standing player sways.
const AREA_SWAY_M: f32 = 0.03;
/// The distance that a player keeps from the opponents' penalty area when it has to be clear, m: its body and the error of its place.
const CLEARED_MARGIN_M: f32 = 0.5;
/// A player stands still within this distance of its place and this angle of its facing: m, radians.
const IN_PLACE: (f32, f32) = (0.05, 0.15);

/// Limits a decision to what the rules allow.
pub fn apply(player: &Player, memory: &PlayerMemory, decision: Decision) -> Decision {
    let decision = match player.kick_off_team(memory) {
        Some(team) if team != player.id.team => stay_off_the_circle(player, decision),
        Some(_) if player.rules.kick_off_free_s.is_some() => {
            leave_the_kick_off_to_a_mate(player, stay_in_the_own_half(player, decision))
        }
        _ => decision,
    };
    let decision = stay_out_of_the_cleared_area(player, keep_off_the_free_kick(player, decision));
    let decision = penalty_kicks::apply(player, decision);
    stay_out_of_the_own_area(player, decision)
}

/// Gets up when the player has fallen.
pub fn posture(player: &Player) -> Option<PostureRequest> {
    (player.body == BodyStatus::Fallen && !player.status.stopped).then_some(PostureRequest::GetUp)
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
    /// The error of the believed place of a ball, as a share of its distance, for a robot whose cameras sway: of the team that kicks off, and
    /// of the other one, which is penalised if it is wrong.
    const SWAY_SHARES: [f32; 2] = [0.12, 0.2];
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
    let sway = if player.limits.gait.is_some() { share } else { 0.0 };
    let in_play = player.ball().is_some_and(|ball| {
        let least_m = IN_PLAY_M + sway * ball.position_m.distance(player.position());
        ball.position_m.length_squared() > least_m * least_m
    });
    if memory.kick_off_since_s.is_some_and(|since| in_play || now - since > KICK_OFF_S) {
        memory.kick_off_since_s = None;
    }
}

/// Returns whether only the keeper may go for a ball at `place`, m, team frame.
pub fn is_for_the_keeper_only(player: &Player, place: Vec2) -> bool {
    may_not_enter_the_own_area(player) && own_area_depth_m(player, place, 0.0) > 0.0
}

/// Stops a step out of the own half that does not lead into the centre circle, before the ball is in play at the own kick-off.
fn stay_in_the_own_half(player: &Player, decision: Decision) -> Decision {
    let then = after(player, &decision.walk);
    let stays = then.x < -HALF_MARGIN_M || then.x < player.position().x;
    if stays || then.length() < player.pitch.centre_circle_diameter_m / 2.0 {
        return decision;
    }
    Decision { walk: WalkCommand { dtheta: decision.walk.dtheta, ..default() }, ..decision }
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
    /// The greatest age of the place of such a team-mate, s.
    const FRESH_S: f32 = 1.5;
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
    if player.limits.gait.is_some() && away.length() < radius + CIRCLE_SWAY_M {
        let outwards = Vec2::new(away.x.min(0.0), away.y).normalize_or(-Vec2::X);
        let place = outwards * (radius + CIRCLE_MARGIN_M);
        // Backwards, with the ball in view.
        let walk = player.walk_to(place, -outwards, &player.obstacles());
        return Decision { walk, target: Some(place), ..decision };
    }
    Decision { walk: braked(player, decision.walk, Vec2::ZERO, radius + CIRCLE_MARGIN_M), ..decision }
}

/// Keeps the required distance from the opponents' free kick: the player walks away if it is too near.
fn keep_off_the_free_kick(player: &Player, decision: Decision) -> Decision {
    let not_ours = player.status.set_play.filter(|set_play| set_play.team != Some(player.id.team));
    let (Some(set_play), Some(ball)) = (not_ours, player.ball()) else { return decision };
    let (away, distance) =
        (player.position() - ball.position_m, player.rules.free_kick_radius_m(player.pitch) + DISTANCE_MARGIN_M);
    let decision = Decision { kick: None, ..decision };
    // While it is not known whose it is, it is enough not to come nearer.
    if set_play.team.is_some() && away.length_squared() < (distance - 0.1) * (distance - 0.1) {
        // Towards the own goal, past the ball if necessary: that way is free more often than at the side line.
        let home = player.own_goal() - ball.position_m;
        let outwards = (away.normalize_or(-Vec2::X) + 0.5 * home.normalize_or(-Vec2::X)).normalize_or(-Vec2::X);
        let place = ball.position_m + outwards * distance;
        let walk = player.walk_to(place, -outwards, &player.obstacles());
        return Decision { walk, target: Some(place), ..decision };
    }
    if leads_into(player, &decision.walk, ball.position_m, distance) {
        let facing = (ball.position_m - player.position()).normalize_or(Vec2::X);
        return Decision { walk: player.walk_to(player.position(), facing, &default()), ..decision };
    }
    Decision { walk: braked(player, decision.walk, ball.position_m, distance), ..decision }
}

/// Keeps the player out of the opponents' penalty area at their goal kick, and at their free kick inside this area, where the rules say so.
fn stay_out_of_the_cleared_area(player: &Player, decision: Decision) -> Decision {
    let theirs = player.status.set_play.filter(|set_play| set_play.team == Some(player.id.team.opponent()));
    let Some(set_play) = theirs.filter(|_| player.rules.goal_kick_clears_area) else { return decision };
    let area = player.pitch.penalty_area;
    let edge = player.pitch.half_length() - area.depth_m;
    let depth_m = |place: Vec2, margin: f32| (place.x - edge + margin).min(area.width_m / 2.0 + margin - place.y.abs());
    let is_inside = |place: Vec2, margin: f32| depth_m(place, margin) > 0.0;
    let is_cleared = match set_play.kind {
        SetPlayKind::KickOff | SetPlayKind::PenaltyKick => false,
        SetPlayKind::GoalKick => true,
        _ => player.ball().is_some_and(|ball| is_inside(ball.position_m, 0.0)),
    };
    if !is_cleared {
        return decision;
    }
    let decision = Decision { kick: None, ..decision };
    if is_inside(player.position(), CLEARED_MARGIN_M - AREA_SWAY_M) {
        let out = Vec2::new(edge - CLEARED_MARGIN_M, player.position().y);
        // Backwards, with the ball in view.
        let walk = player.walk_to(out, Vec2::X, &player.obstacles());
        return Decision { walk, target: Some(out), ..decision };
    }
    Decision { walk: kept_out(player, decision.walk, |place| depth_m(place, CLEARED_MARGIN_M)), ..decision }
}

/// Keeps a field player out of its own penalty area where only the keeper may be in it, and makes it leave.
fn stay_out_of_the_own_area(player: &Player, decision: Decision) -> Decision {
    if !may_not_enter_the_own_area(player) {
        return decision;
    }
    if own_area_depth_m(player, player.position(), AREA_MARGIN_M - AREA_SWAY_M) > 0.0 {
        let x = -player.pitch.half_length() + player.pitch.penalty_area.depth_m + 0.4;
        let out = Vec2::new(x, player.position().y);
        let walk = player.walk_to(out, player.forward, &player.obstacles());
        return Decision { walk, target: Some(out), ..decision };
    }
    Decision {
        walk: kept_out(player, decision.walk, |place| own_area_depth_m(player, place, AREA_MARGIN_M)),
        ..decision
    }
}

/// Whether the rules forbid the player its own penalty area.
fn may_not_enter_the_own_area(player: &Player) -> bool {
    player.is_own_area_for_keeper_only() && !player.is_goalkeeper(player.id)
}

/// Returns how deep `place` (team frame) is in the player's own penalty area with `margin` m around it, m. Negative: it is outside.
fn own_area_depth_m(player: &Player, place: Vec2, margin: f32) -> f32 {
    let area = player.pitch.penalty_area;
    let edge = -player.pitch.half_length() + area.depth_m;
    (edge + margin - place.x).min(area.width_m / 2.0 + margin - place.y.abs())
}

/// Returns `walk` without the part that leads deeper into an area: a player at the edge walks along it. `depth_m` returns how deep a place
/// (team frame) is in the area, m; it is negative outside.
fn kept_out(player: &Player, walk: WalkCommand, depth_m: impl Fn(Vec2) -> f32) -> WalkCommand {
    let here = player.position();
    let is_allowed = |step: Vec2| {
        let then = depth_m(here + step);
        then <= 0.0 || then <= depth_m(here)
    };
    let step = player.forward.rotate(walk.translation());
    if is_allowed(step) {
        return walk;
    }
    let along = [step * Vec2::Y, step * Vec2::X].into_iter().find(|step| is_allowed(*step)).unwrap_or_default();
    let Vec2 { x: dx, y: dy } = Vec2::new(player.forward.x, -player.forward.y).rotate(along);
    WalkCommand { dx, dy, dtheta: walk.dtheta }
}

/// The place after a step, m, team frame.
fn after(player: &Player, walk: &WalkCommand) -> Vec2 {
    player.position() + player.forward.rotate(walk.translation())
}

/// The step `walk`, slower so that the player can stop before it is nearer to `centre` than `radius`, m.
fn braked(player: &Player, walk: WalkCommand, centre: Vec2, radius: f32) -> WalkCommand {
    if leads_into(player, &walk, centre, radius) {
        return WalkCommand { dtheta: walk.dtheta, ..default() };
    }
    let away = player.position() - centre;
    let towards_mps = -player.forward.rotate(walk.translation()).dot(away.normalize_or_zero()) / player.period;
    let most_mps = player.speed_to_stop_within_mps(away.length() - radius);
    if towards_mps <= most_mps {
        return walk;
    }
    let slower = walk.translation() * (most_mps / towards_mps);
    WalkCommand { dx: slower.x, dy: slower.y, dtheta: walk.dtheta }
}

/// Whether a step leads nearer to `centre`, to a place within `radius` of it, m.
fn leads_into(player: &Player, walk: &WalkCommand, centre: Vec2, radius: f32) -> bool {
    let (now, then) = (player.position().distance_squared(centre), after(player, walk).distance_squared(centre));
    then < radius * radius && then < now
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use naoisis_core::game::Rules;
    use naoisis_core::referee::SetPlayStatus;
    use naoisis_core::robot::gait::Gait;
    use naoisis_core::robot::motion::MotionLimits;
    use naoisis_core::team::Team;
    use naoisis_sensing::belief::Belief;

    fn walking(dx: f32, dy: f32) -> Decision {
        Decision { walk: WalkCommand { dx, dy, dtheta: 0.01 }, ..default() }
    }

    fn moved(situation: &PlayerFixture, decision: Decision) -> Vec2 {
        after(&situation.player(), &apply(&situation.player(), &PlayerMemory::default(), decision).walk)
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

    #[test]
    fn players_keep_away_from_the_opponents_free_kick_and_leave_if_they_are_near() {
        let mut situation = PlayerFixture::new(Pose::new(-1.2, 0.0, 0.0), Vec2::ZERO);
        situation.status.set_play = Some(SetPlayStatus { kind: SetPlayKind::KickIn, team: Some(Team::Pink) });
        // 0.75 m and the margin of 0.35 m: at 1.2 m a step may still lead nearer, at 1.1 m none may.
        assert!(moved(&situation, walking(0.006, 0.0)).x > -1.2);
        situation.belief.pose.position.x = -1.1;
        assert_eq!(moved(&situation, walking(0.006, 0.0)).x, -1.1);
        assert!(moved(&situation, walking(-0.006, 0.0)).x < -1.1);
        situation.belief.pose.position.x = -0.5;
        assert!(moved(&situation, walking(0.006, 0.0)).x < -0.5);
        // The own free kick is there to be taken.
        situation.status.set_play = Some(SetPlayStatus { kind: SetPlayKind::KickIn, team: Some(Team::Blue) });
        assert!(moved(&situation, walking(0.006, 0.0)).x > -0.5);
    }

    #[test]
    fn players_leave_the_opponents_area_at_their_goal_kick_where_the_rules_say_so() {
        // The area of the pitch of 2010 begins at x = 2.4; the ball is put 2 m away from the player.
        let mut situation = PlayerFixture::new(Pose::new(2.5, -0.9, 0.0), Vec2::new(2.4, 1.1));
        situation.status.set_play = Some(SetPlayStatus { kind: SetPlayKind::GoalKick, team: Some(Team::Pink) });
        assert!(moved(&situation, walking(0.006, 0.0)).x > 2.5);
        situation.rules.goal_kick_clears_area = true;
        assert!(moved(&situation, walking(0.006, 0.0)).x < 2.5);
        situation.belief.pose.position.x = 1.89;
        assert!(moved(&situation, walking(0.006, 0.0)).x > 1.89);
        situation.belief.pose.position.x = 1.896;
        assert_eq!(moved(&situation, walking(0.006, 0.0)).x, 1.896);
        // A free kick before the area clears nothing.
        situation.status.set_play = Some(SetPlayStatus { kind: SetPlayKind::PushingFreeKick, team: Some(Team::Pink) });
        situation.belief = Belief { ball: None, ..situation.belief };
        assert!(moved(&situation, walking(0.006, 0.0)).x > 1.896);
    }

    #[test]
    fn players_with_a_gait_brake_before_the_circle_and_walk_out_of_it() {
        let mut situation = PlayerFixture::new(Pose::new(-1.9, 0.0, 0.0), Vec2::ZERO);
        let gait = Gait { acceleration_mps2: 0.55, step_s: 0.25, ..Gait::default() };
        situation.limits = MotionLimits { max_linear_mps: 0.6, gait: Some(gait), ..MotionLimits::default() };
        let memory = PlayerMemory { kick_off_since_s: Some(0.0), ..default() };
        situation.status.kick_off_team = Team::Pink;
        let radius = situation.pitch.centre_circle_diameter_m / 2.0;
        // It follows the braked command a step and a delay late, and brakes with its acceleration: it stops outside.
        let (mut place, mut speed_mps) = (-radius - 2.0, 0.6_f32);
        for _ in 0..400 {
            situation.belief.pose.position.x = place;
            let walk = apply(&situation.player(), &memory, walking(0.6 / 30.0, 0.0)).walk;
            let wanted_mps = walk.dx * 30.0;
            speed_mps = wanted_mps.clamp(speed_mps - 0.55 / 30.0, speed_mps + 0.55 / 30.0);
            place += speed_mps / 30.0;
        }
        assert!(-place > radius + 0.1 && -place < radius + 0.4, "{place}");
        // Inside, it leaves.
        situation.belief.pose.position.x = -radius + 0.1;
        assert!(apply(&situation.player(), &memory, walking(0.0, 0.0)).walk.dx < 0.0);
    }

    #[test]
    fn only_the_keeper_goes_into_the_own_penalty_area_where_the_rules_say_so() {
        let rules = Rules { illegal_defender: true, ..Rules::default() };
        // The area of the pitch of 2010 is 0.6 m deep: to x = -2.4.
        let mut situation = PlayerFixture::new(Pose::new(-2.347, 0.5, core::f32::consts::PI), Vec2::new(-2.7, 0.5));
        let forward = walking(0.006, 0.0);
        assert!(moved(&situation, forward).x < -2.35);
        situation.rules = rules;
        assert_eq!(moved(&situation, forward).x, -2.347);
        // It walks along the edge, and away from it.
        let aside = moved(&situation, walking(0.006, 0.004));
        assert!(aside.x == -2.347 && (aside.y - 0.496).abs() < 1e-5, "{aside}");
        assert!(moved(&situation, walking(-0.001, 0.0)).x > -2.347);
        situation.belief.pose.position.x = -2.6;
        assert!(moved(&situation, forward).x > -2.6);
        situation.id.number = 1;
        assert!(moved(&situation, forward).x < -2.6);
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

    #[test]
    fn a_fallen_player_gets_up() {
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::ZERO);
        assert_eq!(posture(&situation.player()), None);
        situation.body = BodyStatus::Fallen;
        assert_eq!(posture(&situation.player()), Some(PostureRequest::GetUp));
    }
}
