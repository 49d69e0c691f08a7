//! Falls, getting up, and the goalkeeper's dives, which the paper leaves to future versions (section 4). They happen if the
//! rules switch them on ([`Rules::falls`], [`Rules::dives`]), and to robots with a [`FallModel`].
//!
//! - When two robots collide, each may fall, with a probability that grows with the speed of the collision.
//! - A robot may lose its balance in walking, more often the faster it walks, and in a kick.
//! - A fallen robot lies where it stood, with the same footprint. It is low: cameras see over it and sonars do not detect it.
//!   It neither walks nor kicks, and its cameras and sonars measure nothing.
//! - It gets up on command, which takes time and may fail.
//! - A dive blocks a strip beside the robot against the ball for a time. Then the robot lies, as after a fall.

use bevy::ecs::query::QueryData;
use bevy::math::ops;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::Roster;
use super::kick::KickPhase;
use super::motion::{ExecutedStep, MotionLimits};
use super::posture::{Posture, PostureCommand, PostureRequest, dive_strip};
use crate::ball::{Ball, BallPhysics};
use crate::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use crate::events::{CollisionPartner, CommandKind, CycleEvents, FallCause, MatchEvent, Refusal};
use crate::game::{Game, GameState, Penalty, Rules};
use crate::geometry::Pose;
use crate::knowledge::Knowledge;
use crate::random::RandomStreams;
use crate::robot::body::Body;
use crate::team::RobotId;

/// Executes posture commands in [`ActSystems::Body`]. Robots fall after the collisions and before the referee.
pub struct FallsPlugin;

impl Plugin for FallsPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Posture>()
            .register_type::<PostureCommand>()
            .register_type::<FallModel>()
            .register_required_components::<RobotId, FallModel>()
            .register_required_components::<RobotId, Posture>()
            .register_required_components::<RobotId, PostureCommand>()
            .add_systems(
                Cycle,
                (
                    take_posture_commands.in_set(ActSystems::Body),
                    fall.in_set(FallSystems).in_set(CycleSystems::Officiate),
                ),
            );
    }
}

/// How often a robot falls. By default only as the rules say.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct FallModel {
    /// Falls per minute of walking at full speed; proportional to the square of the speed.
    pub falls_per_min: f32,
    /// Probability of a fall in a kick at full speed; proportional to the speed of the kick.
    pub kick_probability: f32,
    /// Falls in collisions with robots, instead of those of the rules.
    pub collisions: Option<CollisionFalls>,
    /// Duration of getting up, s, instead of that of the rules.
    pub get_up_s: Option<f32>,
    /// Probability that getting up fails.
    pub get_up_failure: f32,
}

/// The probability of a fall in a collision, by its speed.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CollisionFalls {
    /// Greatest speed at which the robot never falls, m/s.
    pub from_mps: f32,
    /// Least speed at which it always falls, m/s. In between the probability grows linearly.
    pub certain_mps: f32,
}

/// The system in which robots fall, before the referee.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FallSystems;

/// The probability that a robot falls in a collision at `speed` m/s: 0 up to `least`, 1 from `certain` on, and linear in
/// between.
pub fn fall_probability(speed: f32, least: f32, certain: f32) -> f32 {
    if speed <= least {
        0.0
    } else if speed >= certain {
        1.0
    } else {
        (speed - least) / (certain - least)
    }
}

/// The probability that a robot falls within `period` seconds of walking at `speed_share` of its full speed: falls are a Poisson
/// process with the rate of `balance`.
fn walking_probability(balance: &FallModel, speed_share: f32, period: f32) -> f32 {
    let per_s = balance.falls_per_min / 60.0 * speed_share * speed_share;
    1.0 - ops::exp(-per_s * period)
}

fn take_posture_commands(
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    rules: Res<Rules>,
    game: Res<Game>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<PosturedRobot, Without<Ball>>,
    balls: Query<(&Pose, &BallPhysics), (With<Ball>, Without<RobotId>)>,
) {
    let cycles = |seconds: f32| u64::from(clock.cycles_in(seconds));
    for entity in roster.entities() {
        let Ok(robot) = robots.get_mut(entity) else { continue };
        let PosturedRobotItem { id, pose, body, penalty, kick, balance, mut command, mut posture, mut streams } = robot;
        // Nothing changes for a standing robot without a request, the usual case.
        if command.0.is_none() && posture.is_upright() {
            continue;
        }
        let wanted = command.0.take();
        let may_dive =
            rules.dives && game.state == GameState::Playing && *kick == KickPhase::Ready && !penalty.is_active();
        let request = wanted.filter(|request| matches!(request, PostureRequest::GetUp) || may_dive);
        if wanted != request {
            let (robot, command) = (*id, CommandKind::Posture);
            events.push(MatchEvent::CommandRefused { robot, command, reason: Refusal::NotAllowed });
        }
        let get_up_s = balance.get_up_s.unwrap_or(rules.get_up_s);
        let mut next = posture.advance(request, cycles(get_up_s), cycles(rules.dive_s));
        if let (Posture::Upright, Posture::Diving { side, blocks, .. }) = (*posture, &mut next) {
            events.push(MatchEvent::Dive { robot: *id, side: *side });
            let (middle, strip) = dive_strip(*side, body, rules.dive_reach_m);
            let strip = strip.footprint(pose.compose(middle));
            *blocks = balls.iter().all(|(ball, physics)| strip.overlap_disc(ball.position, physics.radius_m).is_none());
        }
        if let (Posture::GettingUp { cycles, .. }, Posture::Upright) = (*posture, next) {
            let probability = balance.get_up_failure;
            if streams.balance.chance(probability) {
                next = Posture::Fallen { cycles: cycles + 1 };
                let cause = FallCause::GettingUp;
                events.push(MatchEvent::Fall { robot: *id, cause, speed_mps: 0.0, probability });
            } else {
                events.push(MatchEvent::GotUp { robot: *id });
            }
        }
        *posture = next;
    }
}

/// A robot that can get up and dive.
#[derive(QueryData)]
#[query_data(mutable)]
struct PosturedRobot {
    body: &'static Body,
    id: &'static RobotId,
    pose: &'static Pose,
    penalty: &'static Penalty,
    kick: &'static KickPhase,
    balance: &'static FallModel,
    command: &'static mut PostureCommand,
    posture: &'static mut Posture,
    streams: &'static mut RandomStreams,
}

/// A robot that may fall.
#[derive(QueryData)]
#[query_data(mutable)]
struct FallingRobot {
    balance: &'static FallModel,
    limits: &'static MotionLimits,
    step: &'static ExecutedStep,
    penalty: &'static Penalty,
    posture: &'static mut Posture,
    kick: &'static mut KickPhase,
    streams: &'static mut RandomStreams,
}

/// A possible cause of a fall, with the speed in m/s, or for a kick as a share of the full speed.
type Danger = (RobotId, FallCause, f32);

/// Lets robots fall that walked, kicked or collided.
fn fall(
    mut dangers: Local<Vec<Danger>>,
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    rules: Res<Rules>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<FallingRobot>,
) {
    dangers.clear();
    for (id, entity) in roster.iter() {
        let Ok(robot) = robots.get(entity) else { continue };
        if robot.balance.falls_per_min > 0.0 && !robot.step.0.is_null() {
            dangers.push((id, FallCause::Walking, robot.step.0.translation().length() / clock.period()));
        }
    }
    for event in events.iter() {
        match event {
            MatchEvent::Collision { robot: Some(robot), with: CollisionPartner::Robot(other), speed_mps, .. } => {
                dangers.extend([*robot, *other].map(|robot| (robot, FallCause::Collision, *speed_mps)));
            }
            MatchEvent::Kick { robot, speed: Some(speed), result, reason, .. } if result.swings(*reason) => {
                dangers.push((*robot, FallCause::Kick, *speed));
            }
            _ => {}
        }
    }
    for (id, cause, danger) in dangers.drain(..) {
        let Some(mut robot) = roster.get(id).and_then(|entity| robots.get_mut(entity).ok()) else { continue };
        let probability = match cause {
            FallCause::Walking => {
                walking_probability(robot.balance, danger / robot.limits.max_linear_mps, clock.period())
            }
            FallCause::Kick => robot.balance.kick_probability * danger,
            FallCause::Collision | FallCause::GettingUp => match (robot.balance.collisions, rules.falls) {
                (Some(falls), _) => fall_probability(danger, falls.from_mps, falls.certain_mps),
                (None, true) => fall_probability(danger, rules.fall_from_mps, rules.fall_certain_mps),
                (None, false) => 0.0,
            },
        };
        if !robot.posture.is_upright() || robot.penalty.is_active() || !robot.streams.balance.chance(probability) {
            continue;
        }
        *robot.posture = Posture::Fallen { cycles: 0 };
        *robot.kick = KickPhase::Ready;
        let speed_mps = if cause == FallCause::Kick { 0.0 } else { danger };
        events.push(MatchEvent::Fall { robot: id, cause, speed_mps, probability });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_probability_of_a_fall_grows_with_the_speed() {
        assert_eq!(fall_probability(0.1, 0.1, 0.5), 0.0);
        assert_abs_diff_eq!(fall_probability(0.3, 0.1, 0.5), 0.5, epsilon = 1e-6);
        assert_eq!(fall_probability(0.5, 0.1, 0.5), 1.0);
        // Half the speed, a quarter of the falls: in a minute of cycles 1 - exp(-0.5) of the robots fall.
        let balance = FallModel { falls_per_min: 2.0, ..FallModel::default() };
        let stays = (0..1800).fold(1.0, |stays, _| stays * (1.0 - walking_probability(&balance, 0.5, 1.0 / 30.0)));
        assert_abs_diff_eq!(stays, ops::exp(-0.5), epsilon = 1e-3);
        // The same speed for both: a step.
        assert_eq!([fall_probability(0.2, 0.2, 0.2), fall_probability(0.21, 0.2, 0.2)], [0.0, 1.0]);
    }
}
