//! Falls, getting up, and the goalkeeper's dives, which the paper leaves to future versions (section 4). They happen if the
//! rules switch them on ([`Rules::falls`], [`Rules::dives`]), and to robots with a [`FallModel`].
//!
//! - When two robots collide, each may fall, with a probability that grows with the speed of the collision. While they stay in
//!   contact, each may fall at a constant rate.
//! - A robot may lose its balance in walking, more often the faster it walks, in a kick, and when it walks into or onto a robot that lies.
//! - A fallen robot lies where it stood: its torso stops others as before, and its whole length stops the ball. It is low: cameras see over
//!   it and sonars do not detect it. It neither walks nor kicks, and its cameras and sonars measure nothing.
//! - It gets up on command, which takes longer from its back, and may fail, more often if another robot touches it.
//! - A robot that dives comes down after a time, and then blocks a strip beside it against the ball. At the end it lies, as after a fall.

use bevy::ecs::query::QueryData;
use bevy::math::ops;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

mod settings;

pub use settings::{CollisionFalls, FallModel};

use super::kick::KickPhase;
use super::motion::{ExecutedStep, MotionSettings};
use super::posture::{LyingOn, Posture, PostureCommand, PostureRequest, dive_strip};
use super::{PreviousPose, Roster};
use crate::ball::{Ball, BallPhysics};
use crate::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use crate::events::{CollisionPartner, CommandKind, Contacts, CycleEvents, FallCause, MatchEvent, Refusal};
use crate::game::{Game, GameState, Penalty, Rules};
use crate::geometry::Pose;
use crate::knowledge::Knowledge;
use crate::random::{RandomStream, RandomStreams};
use crate::robot::body::{Body, Footprint};
use crate::team::RobotId;

/// Executes posture commands in [`ActSystems::Body`]. Robots fall after the collisions and before the referee.
pub struct FallsPlugin;

impl Plugin for FallsPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Posture>()
            .register_type::<PostureCommand>()
            .register_type::<FallModel>()
            .register_type::<FallTendency>()
            .register_required_components::<RobotId, FallModel>()
            .register_required_components::<RobotId, FallTendency>()
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

/// The tendency of a robot to fall, compared with others of its model. It is constant for the whole match.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct FallTendency {
    /// Deviation of the logarithm of the robot's rate of falls from the mean, in standard deviations; `None` until it is first needed.
    deviation: Option<f32>,
}

impl FallTendency {
    /// The factor of the robot's rates of falls, whose logarithm has the standard deviation `spread`. Its mean over robots is 1.
    fn factor(&mut self, spread: f32, stream: &mut RandomStream) -> f32 {
        if spread == 0.0 {
            return 1.0;
        }
        let deviation = *self.deviation.get_or_insert_with(|| stream.gaussian(1.0));
        ops::exp(spread * deviation - spread * spread / 2.0)
    }
}

/// The system in which robots fall, before the referee.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FallSystems;

/// The probability that an event with `rate_per_min` happens within `period` seconds (a Poisson process).
fn probability_within(rate_per_min: f32, period: f32) -> f32 {
    1.0 - ops::exp(-rate_per_min / 60.0 * period)
}

/// The probability of a fall in a collision at `speed_mps`, by the robot's own model or else by the rules.
fn in_collision(balance: &FallModel, rules: &Rules, speed_mps: f32) -> f32 {
    let of_rules = CollisionFalls { from_mps: rules.fall_from_mps, certain_mps: rules.fall_certain_mps };
    let falls = balance.collisions.or(rules.falls.then_some(of_rules));
    falls.map_or(0.0, |falls| falls.probability(speed_mps))
}

/// The probability that at least one of two independent events happens.
fn either(first: f32, second: f32) -> f32 {
    first + second - first * second
}

fn take_posture_commands(
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    rules: Res<Rules>,
    game: Res<Game>,
    contacts: Res<Contacts>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<PosturedRobot, Without<Ball>>,
    balls: Query<(&Pose, &BallPhysics), Without<RobotId>>,
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
        let is_held = game.stop.is_some();
        let may_get_up = !is_held || rules.motion_in_stop;
        let allowed = |request: &PostureRequest| match request {
            PostureRequest::GetUp => may_get_up,
            PostureRequest::Dive(_) => may_dive && !is_held,
        };
        let request = wanted.filter(allowed);
        if wanted != request {
            let (robot, command) = (*id, CommandKind::Posture);
            events.push(MatchEvent::CommandRefused { robot, command, reason: Refusal::NotAllowed });
        }
        let get_up_s = balance.get_up_time_s(posture.lying_on().unwrap_or_default()).unwrap_or(rules.get_up_s);
        let dive_cycles = cycles(rules.dive_s);
        let mut next = posture.advance(request, cycles(get_up_s), dive_cycles);
        if let Posture::Diving { side, cycles_left, blocks } = &mut next {
            if posture.is_upright() {
                events.push(MatchEvent::Dive { robot: *id, side: *side });
            }
            if dive_cycles.saturating_sub(*cycles_left) == cycles(rules.dive_down_s) {
                let (middle, strip) = dive_strip(*side, body, rules.dive_reach_m);
                let strip = strip.footprint(pose.compose(middle));
                let is_under = |(ball, physics): (&Pose, &BallPhysics)| {
                    strip.overlap_disc(ball.position, physics.radius_m).is_some()
                };
                *blocks = !balls.iter().any(is_under);
            }
        }
        if let (Posture::GettingUp { on, cycles, .. }, Posture::Upright) = (*posture, next) {
            let disturbed = if contacts.touches_a_robot(*id) { balance.get_up_failure_in_contact } else { 0.0 };
            let probability = either(balance.get_up_failure, disturbed);
            if streams.balance.chance(probability) {
                next = Posture::Fallen { cycles: cycles + 1, on };
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
pub(super) struct FallingRobot {
    body: &'static Body,
    pose: &'static Pose,
    previous: &'static PreviousPose,
    balance: &'static FallModel,
    motion: &'static MotionSettings,
    step: &'static ExecutedStep,
    penalty: &'static Penalty,
    posture: &'static mut Posture,
    kick: &'static mut KickPhase,
    tendency: &'static mut FallTendency,
    streams: &'static mut RandomStreams,
}

/// A possible cause of a fall, with the speed in m/s, or for a kick as a share of the full speed.
type Danger = (RobotId, FallCause, f32);

/// Lets robots fall that walked, kicked, collided or are in contact.
pub(super) fn fall(
    mut dangers: Local<Vec<Danger>>,
    mut lying: Local<Vec<Footprint>>,
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    rules: Res<Rules>,
    contacts: Res<Contacts>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<FallingRobot>,
) {
    dangers.clear();
    lying.clear();
    let lies_on_pitch = |robot: &FallingRobotReadOnlyItem| robot.posture.is_fallen() && !robot.penalty.is_off_pitch();
    lying.extend(robots.iter().filter(lies_on_pitch).map(|robot| lying_footprint(&robot)));
    for (id, entity) in roster.iter() {
        let Ok(robot) = robots.get(entity) else { continue };
        let speed_mps = robot.step.0.translation().length() / clock.period();
        if robot.balance.falls_per_min > 0.0 && !robot.step.0.is_null() {
            dangers.push((id, FallCause::Walking, speed_mps));
        }
        if robot.balance.trip_probability.is_some() && lying.iter().any(|lying| steps_onto(&robot, lying)) {
            dangers.push((id, FallCause::Tripping, speed_mps));
        }
    }
    let find = |id| roster.get(id).and_then(|entity| robots.get(entity).ok());
    for event in events.iter() {
        match event {
            MatchEvent::Collision { robot: Some(robot), with: CollisionPartner::Robot(other), speed_mps, .. } => {
                for (id, touched) in [(*robot, *other), (*other, *robot)] {
                    let (Some(own), Some(other)) = (find(id), find(touched)) else { continue };
                    let lies = other.posture.is_fallen();
                    // A robot trips once: on stepping onto the other one, or else on touching it.
                    if !(lies && own.balance.trip_probability.is_some() && stands_on(&own, &lying_footprint(&other))) {
                        let cause = if lies { FallCause::Tripping } else { FallCause::Collision };
                        dangers.push((id, cause, *speed_mps));
                    }
                }
            }
            MatchEvent::Kick { robot, speed: Some(speed), result, reason, .. } if result.swings(*reason) => {
                dangers.push((*robot, FallCause::Kick, *speed));
            }
            _ => {}
        }
    }
    for (one, other) in contacts.robots_in_contact() {
        dangers.extend([one, other].map(|id| (id, FallCause::Contact, 0.0)));
    }
    for (id, cause, danger) in dangers.drain(..) {
        let Some(mut robot) = roster.get(id).and_then(|entity| robots.get_mut(entity).ok()) else { continue };
        if !robot.posture.is_upright() || robot.penalty.is_active() {
            continue;
        }
        let balance = robot.balance;
        let streams = &mut *robot.streams;
        let factor = robot.tendency.factor(balance.spread, &mut streams.balance);
        let probability = match cause {
            FallCause::Walking => {
                let speed_share = danger / robot.motion.max_linear_mps;
                probability_within(balance.falls_per_min * factor * speed_share * speed_share, clock.period())
            }
            FallCause::Contact => probability_within(balance.contact_falls_per_min * factor, clock.period()),
            FallCause::Kick => balance.kick_probability * danger,
            FallCause::Tripping => balance.trip_probability.unwrap_or_else(|| in_collision(balance, &rules, danger)),
            FallCause::Collision | FallCause::GettingUp => in_collision(balance, &rules, danger),
        };
        if !streams.balance.chance(probability) {
            continue;
        }
        let on = if streams.balance.chance(balance.on_back_share) { LyingOn::Back } else { LyingOn::Front };
        *robot.posture = Posture::fallen(on);
        *robot.kick = KickPhase::Ready;
        let speed_mps = if cause == FallCause::Kick { 0.0 } else { danger };
        events.push(MatchEvent::Fall { robot: id, cause, speed_mps, probability });
    }
}

/// Returns the ground that a robot covers if it lies.
fn lying_footprint(robot: &FallingRobotReadOnlyItem) -> Footprint {
    robot.body.lying_box().footprint(*robot.pose)
}

/// Whether a robot has walked onto the ground that another one covers, `lying`, in this cycle.
fn steps_onto(robot: &FallingRobotReadOnlyItem, lying: &Footprint) -> bool {
    let is_on = |pose: Pose| robot.body.base.footprint(pose).overlap(lying).is_some();
    robot.posture.is_upright() && !robot.step.0.is_null() && is_on(*robot.pose) && !is_on(robot.previous.0)
}

/// Whether a robot stands on the ground that another one covers, `lying`, or has walked onto it in this cycle.
fn stands_on(robot: &FallingRobotReadOnlyItem, lying: &Footprint) -> bool {
    robot.body.base.footprint(*robot.pose).overlap(lying).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn rates_are_those_of_a_poisson_process() {
        // With half a fall a minute, 1 - exp(-0.5) of the robots fall within the 1800 cycles of a minute.
        let stays = (0..1800).fold(1.0, |stays, _| stays * (1.0 - probability_within(0.5, 1.0 / 30.0)));
        assert_abs_diff_eq!(stays, ops::exp(-0.5), epsilon = 1e-3);
        assert_abs_diff_eq!(either(0.5, 0.2), 0.6, epsilon = 1e-6);
    }

    #[test]
    fn robots_of_a_model_differ_in_how_often_they_fall_and_keep_to_it() {
        let factors: Vec<f32> = (0..4000)
            .map(|seed| {
                let mut stream = RandomStream::for_match(seed, "test");
                let mut tendency = FallTendency::default();
                let factor = tendency.factor(0.7, &mut stream);
                assert_eq!(factor, tendency.factor(0.7, &mut stream), "it is drawn once");
                factor
            })
            .collect();
        let mean = factors.iter().sum::<f32>() / factors.len() as f32;
        // The standard error of this mean is 1.3 %.
        assert_abs_diff_eq!(mean, 1.0, epsilon = 0.05);
        // Of a log-normal distribution with this spread, 8.9 % are above twice the mean.
        let often = factors.iter().filter(|factor| **factor > 2.0).count() as f32 / factors.len() as f32;
        assert_abs_diff_eq!(often, 0.089, epsilon = 0.02);
        let mut stream = RandomStream::for_match(1, "test");
        let untouched = stream.clone();
        assert_eq!(FallTendency::default().factor(0.0, &mut stream), 1.0);
        assert_eq!(stream, untouched, "without a spread nothing is drawn");
    }
}
