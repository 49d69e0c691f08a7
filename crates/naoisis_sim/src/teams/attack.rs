//! Going for the ball, lining up and kicking it. Shared by all built-in players.

use bevy::prelude::*;

use super::aiming::{Aim, Sizes};
use super::dribbling::walk_into;
use super::kick_plan::KickPlan;
use super::kicking::{BallAtFeet, any_kick, kick_now};
use super::player::{Decision, Player, PlayerMemory};
use super::searching::{search, step_back};
use super::walking::approach;
use naoisis_core::geometry::unrotate;
use naoisis_core::robot::kick::KickRequest;
use naoisis_core::robot::motion::WalkCommand;
use naoisis_sensing::belief::BallBelief;
use naoisis_sensing::sensing::status::BodyStatus;

/// An opponent nearer to the ball than this puts the attacker under pressure, m.
const PRESSURE_DISTANCE_M: f32 = 0.5;
/// The factor on the tolerance of a kick under pressure.
const PRESSURE_PATIENCE: f32 = 2.5;
/// An attacker further away from the ball than this faces it, m.
pub(super) const FACE_BALL_M: f32 = 0.7;
/// An attacker nearer to the ball than this is at the ball, m.
const AT_BALL_M: f32 = 0.5;
/// After this time at the ball, an attacker accepts less exact kicks, s.
const PREPARATION_S: f32 = 4.0;
/// The ball must have been seen within this time for a kick, s.
const FRESH_BALL_S: f32 = 0.4;
/// The same where the cameras cannot show the ball, s.
const BLIND_BALL_S: f32 = 5.0;
/// A ball out of sight is kicked only from within this distance of the planned place, m.
const BLIND_EXACTNESS_M: f32 = 0.05;
/// A ball faster than this is met ahead of its place, m/s.
const ROLLING_BALL_MPS: f32 = 0.15;
/// A rolling ball is met where it will be after this time, s.
const LEAD_S: f32 = 1.0;
/// Shots are tried from this share of the reach of kicks.
const SHOT_RANGE_SHARE: f32 = 0.95;

/// Goes for the ball and kicks it.
pub fn attack(player: &Player, memory: &mut PlayerMemory) -> Decision {
    let Some(ball) = player.ball() else { return search(player, memory) };
    memory.lost_since_s = None;
    let aim = choose_aim(player, memory, ball.position_m);
    let meeting_place = if rolls(ball) { ball.position_m + ball.velocity_mps * LEAD_S } else { ball.position_m };
    go_for(player, memory, ball, &aim, meeting_place, |at_feet, hurried| kick_towards(player, at_feet, &aim, hurried))
}

/// Whether the ball rolls, rather than seeming to by errors of the estimate.
fn rolls(ball: &BallBelief) -> bool {
    ball.velocity_mps.length_squared() > ROLLING_BALL_MPS * ROLLING_BALL_MPS
}

/// The standard deviation of the ball's place along an axis, m, as believed.
fn place_sd_m(ball: &BallBelief) -> f32 {
    let [xx, _, yy] = ball.position_covariance;
    (0.5 * (xx + yy)).sqrt()
}

/// Kicks the ball towards `aim`, or goes to the place from which it can, with the ball at `meeting_place`, m, team frame. `pick` chooses
/// the kick of a ball at the feet, if it should be kicked now; its second argument says whether the player is in a hurry.
pub fn go_for(
    player: &Player,
    memory: &mut PlayerMemory,
    ball: &BallBelief,
    aim: &Aim,
    meeting_place: Vec2,
    pick: impl FnOnce(BallAtFeet, bool) -> Option<KickRequest>,
) -> Decision {
    let kicks_in_walking = player.kicks.types().any(|kick| player.kicks.is_in_walk(kick));
    let kicks_now = kicks_in_walking && player.body == BodyStatus::Kicking;
    if kicks_now || player.is_kick_pending(memory) {
        // A player that has not stopped makes a kick in walking, and goes straight on until the foot meets the ball.
        let walks = kicks_now || player.body == BodyStatus::Walking;
        let walk = if walks { straight_on(player) } else { WalkCommand::default() };
        return Decision { walk, intention: "kick", ..default() };
    }
    if has_kicked_blindly(player, memory, ball) {
        memory.ready_since_s = None;
        return step_back(player);
    }
    let ready = kick_if_ready(player, memory, ball, aim, pick);
    let in_walk = ready.is_some_and(|kick| player.kicks.is_in_walk(kick.kick_type));
    if ready.is_some() && !in_walk && !has_looked(player, memory) {
        return Decision { intention: "attack", ..default() };
    }
    memory.ready_since_s = None;
    if let Some(kick) = ready {
        memory.kicked_at_s = Some(player.status.time_s);
        memory.kick = None;
        memory.at_ball_since_s = None;
        let walk =
            if in_walk && player.body == BodyStatus::Walking { straight_on(player) } else { WalkCommand::default() };
        return Decision { walk, kick: Some(kick), intention: "kick", ..default() };
    }
    let (walk, target) = line_up(player, memory, ball, aim, meeting_place);
    Decision { walk, target: Some(target), intention: "attack", ..default() }
}

/// The first and the last velocity of the legs (m/s, m/s, rad/s) until the player strikes in a kick in walking.
fn walks_until_struck(player: &Player, memory: &PlayerMemory) -> [Vec3; 2] {
    let fastest = Vec3::X * speed_in_kick_mps(player);
    match &player.motion.gait {
        _ if player.body != BodyStatus::Walking => [Vec3::ZERO; 2],
        Some(gait) => [memory.walks, gait.velocity_after(memory.walks, fastest, gait.step_s)],
        None => [Vec3::ZERO, fastest],
    }
}

/// The speed of a player in a kick in walking, m/s.
fn speed_in_kick_mps(player: &Player) -> f32 {
    /// Faster robots slow down: they would run into opponents behind the ball.
    const FASTEST_MPS: f32 = 0.4;
    player.motion.max_linear_mps.min(FASTEST_MPS)
}

/// A step straight on.
fn straight_on(player: &Player) -> WalkCommand {
    WalkCommand { dx: speed_in_kick_mps(player) * player.period, ..default() }
}

/// Whether the player has stood and looked at a ball that lies right for long enough to kick it. The cameras of a robot with a gait sway
/// with its steps, which displaces the ball.
fn has_looked(player: &Player, memory: &mut PlayerMemory) -> bool {
    /// The duration of a sway, s.
    const LOOK_S: f32 = 0.4;
    if player.motion.gait.is_none() {
        return true;
    }
    let since_s = *memory.ready_since_s.get_or_insert(player.status.time_s);
    player.body == BodyStatus::Standing && player.status.time_s - since_s >= LOOK_S
}

/// Chooses where to kick the ball: to the side at the own kick-off, otherwise at the goal or towards it.
pub fn choose_aim(player: &Player, memory: &mut PlayerMemory, ball: Vec2) -> Aim {
    let aim = if player.kick_off_team(memory) == Some(player.id.team) {
        Aim::kick_off(ball, player.status.restarts.is_multiple_of(2))
    } else {
        let ahead = player.kicks.types().filter(|kick| !kick.is_side_kick());
        let range_m = SHOT_RANGE_SHARE * ahead.map(|kick| player.kicks.max_distance_m(kick)).fold(0.0, f32::max);
        let sizes = Sizes { blocked_half_width_m: player.blocked_half_width_m(), ball_radius_m: player.ball_radius_m };
        Aim::choose(ball, &player.belief.opponents, player.pitch, range_m, sizes, memory.aim)
    };
    memory.aim = Some(aim.direction);
    aim
}

/// Whether the ball lies so near ahead that no camera shows it at any head angles.
fn is_out_of_sight(player: &Player, ball: &BallBelief) -> bool {
    let place = player.in_robot(ball.position_m);
    let at_ball_m = AT_BALL_M + player.longer_than_nao_m();
    place.x > 0.0 && place.length_squared() < at_ball_m * at_ball_m && !player.head.can_see(place)
}

/// Whether the player has kicked a ball out of sight since it last saw the ball. It may have missed it, and must look again.
fn has_kicked_blindly(player: &Player, memory: &PlayerMemory, ball: &BallBelief) -> bool {
    let since_kick_s = memory.kicked_at_s.map(|then| player.status.time_s - then);
    ball.age_s > FRESH_BALL_S
        && since_kick_s.is_some_and(|since_s| (0.0..ball.age_s).contains(&since_s))
        && is_out_of_sight(player, ball)
}

/// Whether the player stands exactly at its planned place for the kick.
fn is_at_kick_place(player: &Player, memory: &PlayerMemory, ball: &BallBelief, aim: &Aim) -> bool {
    let (abilities, obstacles) = ((player.kicks, player.motion), player.obstacles());
    let plan = KickPlan::choose(ball.position_m, aim, player.pose(), &obstacles, abilities, memory.kick);
    plan.is_some_and(|plan| plan.position.distance_squared(player.position()) < BLIND_EXACTNESS_M * BLIND_EXACTNESS_M)
}

/// The kick that `pick` chooses, if the ball certainly lies at the feet. The player hurries after a long time at the ball, or with an
/// opponent at the ball.
fn kick_if_ready(
    player: &Player,
    memory: &PlayerMemory,
    ball: &BallBelief,
    aim: &Aim,
    pick: impl FnOnce(BallAtFeet, bool) -> Option<KickRequest>,
) -> Option<KickRequest> {
    if !player.body.is_free() || ball.heard_from.is_some() {
        return None;
    }
    if ball.age_s > FRESH_BALL_S {
        let may_be_there = ball.age_s <= BLIND_BALL_S && is_out_of_sight(player, ball);
        if !may_be_there || !is_at_kick_place(player, memory, ball, aim) {
            return None;
        }
    }
    let waited_s = memory.at_ball_since_s.map_or(0.0, |since| player.status.time_s - since);
    let hurried = waited_s > PREPARATION_S || player.nearest_opponent(ball.position_m) < PRESSURE_DISTANCE_M;
    let at_feet = BallAtFeet {
        place: ball.position_m,
        in_robot: player.in_robot(ball.position_m),
        rolls_mps: if rolls(ball) { unrotate(player.forward, ball.velocity_mps) } else { Vec2::ZERO },
        place_sd_m: if hurried { 0.0 } else { place_sd_m(ball) },
        forward: player.forward,
        walks: walks_until_struck(player, memory),
        delay_s: player.latency.kick_s,
    };
    pick(at_feet, hurried)
}

/// The kick that sends a ball at the feet towards `aim`, or, in a hurry, any acceptable kick.
pub(super) fn kick_towards(player: &Player, at_feet: BallAtFeet, aim: &Aim, hurried: bool) -> Option<KickRequest> {
    let patience = if hurried { PRESSURE_PATIENCE } else { 1.0 };
    let kick = kick_now(at_feet, aim, (player.kicks, player.rolling), player.pitch, patience);
    if kick.is_none() && hurried {
        any_kick(
            at_feet,
            &player.belief.opponents,
            player.blocked_half_width_m(),
            (player.kicks, player.rolling),
            player.pitch,
        )
    } else {
        kick
    }
}

/// The step towards the place for the kick, and that place, m, team frame.
fn line_up(
    player: &Player,
    memory: &mut PlayerMemory,
    ball: &BallBelief,
    aim: &Aim,
    meeting_place: Vec2,
) -> (WalkCommand, Vec2) {
    let distance_squared = player.position().distance_squared(ball.position_m);
    let at_ball_m = AT_BALL_M + player.longer_than_nao_m();
    if distance_squared > at_ball_m * at_ball_m {
        memory.at_ball_since_s = None;
    } else if memory.at_ball_since_s.is_none() {
        memory.at_ball_since_s = Some(player.status.time_s);
    }
    let mut obstacles = player.obstacles();
    let abilities = (player.kicks, player.motion);
    let plan = (!aim.dribbles)
        .then(|| KickPlan::choose(meeting_place, aim, player.pose(), &obstacles, abilities, memory.kick))
        .flatten();
    memory.kick = plan.map(|plan| plan.kick_type);
    // A player that dribbles, or has no kicks, stands with its toes at the ball, and walks on.
    let toes_m = player.own_body.base.x_m[1] + player.ball_radius_m;
    let (position, facing) =
        plan.map_or((meeting_place - toes_m * aim.direction, aim.direction), |plan| (plan.position, plan.facing));
    if let Some(walk) = aim.dribbles.then(|| walk_into(player, meeting_place, aim.direction)).flatten() {
        return (walk, position);
    }
    let geometry = plan.and_then(|plan| player.kicks.geometry(plan.kick_type));
    let can_be_aimed = player.walks_in_steps() && geometry.is_some_and(|kick| kick.aims_within() > 0.0);
    let (place, last_stretch) = approach(player.position(), player.forward, position, facing, can_be_aimed);
    if last_stretch {
        let place = if plan.is_some() { place } else { meeting_place + aim.direction };
        return (player.walk_to(place, facing, &obstacles), position);
    }
    obstacles.add(ball.position_m, player.ball_clearance_m());
    // Far away, face the ball; near it, the direction of the kick.
    let face_ball_m = FACE_BALL_M + player.longer_than_nao_m();
    let facing = if distance_squared > face_ball_m * face_ball_m {
        (ball.position_m - player.position()).normalize_or(facing)
    } else {
        facing
    };
    (player.walk_to(place, facing, &obstacles), position)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::{PlayerFixture, after_decision};
    use naoisis_core::geometry::Pose;
    use naoisis_core::geometry::unit;
    use naoisis_core::robot::body::Body;
    use naoisis_sensing::sensing::status::BodyStatus;

    const BALL_RADIUS_M: f32 = 0.03;

    #[test]
    fn from_all_around_the_ball_is_reached_without_a_touch_and_kicked_at_the_goal() {
        for index in 0..24 {
            let angle = index as f32 * 0.26;
            let ball = Vec2::new(0.8, -0.4);
            let start = ball + unit(angle) * (0.35 + 0.05 * index as f32);
            let mut situation = PlayerFixture::new(Pose { position: start, heading: 2.0 * angle }, ball);
            let mut memory = PlayerMemory::default();
            let mut kick = None;
            for _ in 0..30 * 20 {
                let decision = attack(&situation.player(), &mut memory);
                kick = decision.kick;
                if kick.is_some() {
                    break;
                }
                situation.belief.pose = after_decision(situation.belief.pose, &decision);
                let base = Body::default().base.footprint(situation.belief.pose);
                let gap = base.signed_distance(ball).0 - BALL_RADIUS_M;
                assert!(gap > 0.0, "start {index}: touches the ball at {:?}", situation.belief.pose);
                situation.status.time_s += situation.period;
            }
            let kick = kick.unwrap_or_else(|| panic!("start {index}: no kick within 20 s"));
            let in_robot = situation.belief.ball_in_robot().unwrap();
            let strike = naoisis_core::kick_geometry::strike(kick.kick_type, in_robot).unwrap();
            let direction = situation.belief.pose.forward().rotate(strike.direction);
            let y = ball.y + direction.y / direction.x * (3.0 - ball.x);
            assert!(direction.x > 0.0 && y.abs() < 0.62, "start {index}: crosses the goal line at {y}");
        }
    }

    #[test]
    fn an_unseen_or_heard_ball_is_not_kicked_and_neither_is_one_while_recovering() {
        let kicks = |change: fn(&mut PlayerFixture)| {
            let mut situation = PlayerFixture::new(Pose::new(-0.17, -0.05, 0.0), Vec2::ZERO);
            change(&mut situation);
            attack(&situation.player(), &mut PlayerMemory::default()).kick.is_some()
        };
        assert!(kicks(|_| {}));
        assert!(!kicks(|situation| situation.belief.ball.as_mut().unwrap().age_s = 1.0));
        assert!(!kicks(|situation| {
            situation.belief.ball.as_mut().unwrap().heard_from =
                Some(naoisis_core::team::RobotId::new(naoisis_core::team::Team::Blue, 3));
        }));
        assert!(!kicks(|situation| situation.body = BodyStatus::Recovering));
    }

    #[test]
    fn a_robot_with_a_gait_stands_and_looks_before_it_kicks_and_does_not_kick_twice() {
        let mut situation = PlayerFixture::new(Pose::new(-0.17, -0.05, 0.0), Vec2::ZERO);
        situation.motion.gait = Some(naoisis_core::robot::gait::Gait::default());
        situation.latency.kick_s = 0.033;
        situation.body = BodyStatus::Walking;
        let mut memory = PlayerMemory::default();
        let mut kicks = Vec::new();
        for cycle in 0..30 {
            situation.status.time_s = cycle as f32 / 30.0;
            if cycle == 6 {
                situation.body = BodyStatus::Standing;
            }
            let decision = attack(&situation.player(), &mut memory);
            assert!(decision.walk.is_null(), "{cycle}: {decision:?}");
            if decision.kick.is_some() {
                kicks.push(cycle);
                if kicks.len() == 2 {
                    break;
                }
            }
        }
        // 0.4 s are 12 cycles. The kick is commanded once, and again if the legs should have begun and have not.
        assert_eq!(kicks[0], 12);
        assert!(kicks.get(1).is_none_or(|again| *again > 13), "{kicks:?}");
    }

    #[test]
    fn the_own_kick_off_is_no_shot() {
        let mut situation = PlayerFixture::new(Pose::new(-0.3, 0.0, 0.0), Vec2::ZERO);
        let mut memory = PlayerMemory { kick_off_since_s: Some(0.0), ..default() };
        for _ in 0..300 {
            let decision = attack(&situation.player(), &mut memory);
            if let Some(kick) = decision.kick {
                // 1.06 m: not nearly to the goal, 3 m away.
                assert!(kick.speed < 0.6, "{kick:?}");
                return;
            }
            situation.belief.pose = after_decision(situation.belief.pose, &decision);
        }
        panic!("no kick within 10 s");
    }
}
