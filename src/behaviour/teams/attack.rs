//! Going for the ball: behind it, around it, lining up, kicking. Shared by all built-in players.

use bevy::prelude::*;

use super::kicking::{Aim, KickPlan, kick_now, stays_inside};
use super::looking;
use super::player::{Decision, Player, PlayerMemory};
use super::walking::{BALL_CLEARANCE_M, approach};
use crate::belief::BallBelief;
use crate::geometry::unit;
use crate::robot::head::HeadCommand;
use crate::robot::kick::{KickRequest, KickType, strike};
use crate::robot::motion::WalkCommand;
use crate::sensing::status::BodyStatus;

/// An opponent nearer to the ball than this puts the attacker under pressure, m.
const PRESSURE_DISTANCE_M: f32 = 0.5;
/// How much less exact a kick may be under pressure.
const PRESSURE_PATIENCE: f32 = 2.5;
/// Further away from the ball than this, an attacker faces it, m.
const FACE_BALL_M: f32 = 0.7;
/// Nearer to the ball than this, an attacker is at it, m.
const AT_BALL_M: f32 = 0.5;
/// After so long at the ball, less exact kicks will do, s.
const PREPARATION_S: f32 = 4.0;
/// The ball must have been seen within this time for a kick, s.
const FRESH_BALL_S: f32 = 0.4;
/// A ball faster than this is not lined up for but met, m/s.
const ROLLING_BALL_MPS: f32 = 0.15;
/// Of a rolling ball it is reckoned where it will be after this time, s.
const LEAD_S: f32 = 1.0;
/// A shot is tried from this share of the greatest kick's distance.
const SHOT_RANGE_SHARE: f32 = 0.95;

/// Goes for the ball and kicks it.
pub fn attack(player: &Player, memory: &mut PlayerMemory) -> Decision {
    let Some(ball) = player.ball() else { return search(player, memory) };
    memory.lost_since_s = None;
    let aim = choose_aim(player, memory, ball.position_m);
    if let Some(kick) = kick_if_ready(player, memory, ball, &aim) {
        memory.kick = None;
        memory.at_ball_since_s = None;
        return Decision { kick: Some(kick), intention: "kick", ..default() };
    }
    Decision { walk: line_up(player, memory, ball, &aim), intention: "attack", ..default() }
}

fn choose_aim(player: &Player, memory: &mut PlayerMemory, ball: Vec2) -> Aim {
    let aim = if memory.kick_off_since_s.is_some() && player.status.kick_off_team == player.id.team {
        Aim::kick_off(ball, player.status.restarts.is_multiple_of(2))
    } else {
        let range_m = SHOT_RANGE_SHARE * player.kicks.range(KickType::LeftStraight).max_distance_m;
        Aim::choose(ball, &player.belief.opponents, player.pitch, range_m, memory.aim)
    };
    memory.aim = Some(aim.direction);
    aim
}

/// The kick to make now, if the ball lies right for one. An opponent at the ball, or a long time there, makes do with
/// less.
fn kick_if_ready(player: &Player, memory: &PlayerMemory, ball: &BallBelief, aim: &Aim) -> Option<KickRequest> {
    let is_free = matches!(player.body, BodyStatus::Standing | BodyStatus::Walking);
    if !is_free || ball.age_s > FRESH_BALL_S || ball.heard_from.is_some() {
        return None;
    }
    let in_robot = player.in_robot(ball.position_m);
    let waited_s = memory.at_ball_since_s.map_or(0.0, |since| player.status.time_s - since);
    let hurried = waited_s > PREPARATION_S || player.nearest_opponent(ball.position_m) < PRESSURE_DISTANCE_M;
    let patience = if hurried { PRESSURE_PATIENCE } else { 1.0 };
    let kick = kick_now(in_robot, player.forward, aim, player.kicks, patience);
    if kick.is_none() && hurried { emergency_kick(player, in_robot) } else { kick }
}

/// The step that brings the player to where it can kick the ball.
fn line_up(player: &Player, memory: &mut PlayerMemory, ball: &BallBelief, aim: &Aim) -> WalkCommand {
    let distance_squared = player.position().distance_squared(ball.position_m);
    if distance_squared > AT_BALL_M * AT_BALL_M {
        memory.at_ball_since_s = None;
    } else if memory.at_ball_since_s.is_none() {
        memory.at_ball_since_s = Some(player.status.time_s);
    }
    let rolls = ball.velocity_mps.length_squared() > ROLLING_BALL_MPS * ROLLING_BALL_MPS;
    let meeting_place = if rolls { ball.position_m + ball.velocity_mps * LEAD_S } else { ball.position_m };
    let mut obstacles = player.obstacles();
    let plan = KickPlan::choose(meeting_place, aim, player.pose(), &obstacles, player.kicks, memory.kick);
    memory.kick = Some(plan.kick_type);
    let (place, last_stretch) = approach(player.position(), player.forward, plan.position, plan.facing);
    if last_stretch {
        return player.walk_to(place, plan.facing, &obstacles);
    }
    obstacles.add(ball.position_m, BALL_CLEARANCE_M);
    // Far away it is enough to face where the ball is; near it, where it shall go.
    let facing = if distance_squared > FACE_BALL_M * FACE_BALL_M {
        (ball.position_m - player.position()).normalize_or(plan.facing)
    } else {
        plan.facing
    };
    player.walk_to(place, facing, &obstacles)
}

/// A kick for want of a better one: to wherever the ball goes from where it lies before a foot, so that is forwards.
fn emergency_kick(player: &Player, ball_in_robot: Vec2) -> Option<KickRequest> {
    let ball = player.position() + player.forward.rotate(ball_in_robot);
    KickType::ALL
        .into_iter()
        .filter(|kick_type| kick_type.admissible_rectangle().inflate(-0.004).contains(ball_in_robot))
        .filter_map(|kick_type| {
            let strike = strike(kick_type, ball_in_robot)?;
            let direction = player.forward.rotate(strike.direction);
            // Past the opponents, forwards, and not over a line.
            let free = player.belief.opponents.iter().all(|opponent| {
                let offset = opponent.position_m - ball;
                offset.length_squared() > 0.8 * 0.8
                    || direction.dot(offset) < 0.0
                    || direction.perp_dot(offset).abs() > 0.2
            });
            let worth = direction.x;
            (free && worth > -0.2 && stays_inside(ball, direction, 0.8, player.pitch)).then_some((worth, kick_type))
        })
        .max_by(|(first, _), (second, _)| first.total_cmp(second))
        .map(|(_, kick_type)| KickRequest { kick_type, speed: 0.8 })
}

/// Looks for the ball: turns around towards where it was lost, then walks from place to place.
pub fn search(player: &Player, memory: &mut PlayerMemory) -> Decision {
    /// How fast the body turns while the head searches: a share of the greatest speed.
    const TURN_SHARE: f32 = 0.4;
    /// How long it turns before it walks, s.
    const TURN_S: f32 = 8.0;
    /// How long it walks to a place before it goes to the next, s.
    const PATROL_S: f32 = 12.0;
    let now = player.status.time_s;
    let since = *memory.lost_since_s.get_or_insert(now);
    memory.kick = None;
    memory.at_ball_since_s = None;
    let head = Some(looking::search(now - since));
    let turn = if memory.lost_left { 1.0 } else { -1.0 };
    let searched_s = now - since;
    if searched_s < TURN_S {
        let facing = player.forward.rotate(unit(turn * TURN_SHARE * player.limits.max_angular * player.period));
        let walk = player.walk_to(player.position(), facing, &default());
        return Decision { walk, head, intention: "search", ..default() };
    }
    let (x, y) = (0.45 * player.pitch.half_length(), 0.5 * player.pitch.half_width());
    let places = [Vec2::ZERO, Vec2::new(x, y), Vec2::new(-x, -y), Vec2::new(x, -y), Vec2::new(-x, y)];
    let index = ((searched_s - TURN_S) / PATROL_S) as usize + usize::from(player.id.number);
    let place = places[index % places.len()];
    let facing = (place - player.position()).normalize_or(player.forward);
    let walk = player.walk_to(place, facing, &player.obstacles());
    Decision { walk, head, intention: "search", ..default() }
}

/// Where to look when nothing else is decided: at the ball, now and then around for landmarks.
pub fn watch(player: &Player, memory: &mut PlayerMemory) -> HeadCommand {
    /// A pose that was not confirmed for so long needs a look around, s.
    const OLD_POSE_S: f32 = 1.0;
    /// How long a look around takes, s.
    const GLANCE_S: f32 = 0.5;
    /// Between two looks around the ball is watched for so long, s.
    const WATCH_S: f32 = 1.5;
    /// After so long, the robot looks around even if it thinks that it knows where it is, s.
    const CHECK_S: f32 = 6.0;
    let now = player.status.time_s;
    let Some(ball) = player.belief.ball_in_robot() else { return looking::search(now) };
    memory.lost_left = ball.y > 0.0;
    let is_at_ball = ball.length_squared() < FACE_BALL_M * FACE_BALL_M;
    let watched_s = now - memory.last_glance_s;
    let is_lost = player.belief.pose_age_s > OLD_POSE_S && watched_s > WATCH_S;
    if now > memory.glance_until_s && (is_lost || (!is_at_ball && watched_s > CHECK_S)) {
        memory.glance_until_s = now + GLANCE_S;
        memory.last_glance_s = now + GLANCE_S;
    }
    if now < memory.glance_until_s
        && let Some(post) = post_to_look_at(player)
    {
        return looking::look_at(post);
    }
    looking::look_at(ball)
}

/// The goal post (m, robot frame) for which the head turns least, of those that can be seen well.
fn post_to_look_at(player: &Player) -> Option<Vec2> {
    /// Further away, a post tells little, m.
    const FAR_M: f32 = 6.0;
    /// Nearer, its foot is hard to see, m.
    const NEAR_M: f32 = 0.5;
    /// The cosine of the greatest angle from the front, 115°: what the head reaches, less half of the image.
    const REACH: f32 = -0.42;
    let (x, y) = (player.pitch.goal_post_x(), player.pitch.goal.width_m / 2.0);
    [Vec2::new(x, y), Vec2::new(x, -y), Vec2::new(-x, y), Vec2::new(-x, -y)]
        .into_iter()
        .filter_map(|post| {
            let place = player.in_robot(post);
            let distance = place.length();
            let ahead = place.x / distance.max(NEAR_M);
            (ahead > REACH && distance > NEAR_M && distance < FAR_M).then_some((ahead, place))
        })
        .max_by(|(first, _), (second, _)| first.total_cmp(second))
        .map(|(_, place)| place)
}
