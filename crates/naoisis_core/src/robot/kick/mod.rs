//! Kicks: the four types of the paper's section 3.2 and the custom kicks of a robot, and their phases in time.

mod settings;

pub use settings::{CustomKicks, KickModel, KickSettings, UnknownKick};

use bevy::ecs::query::QueryData;
use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ball::flight::{BallFlight, launch};
use crate::ball::{BallPhysics, BallVelocity, ExtraBall, Rolling};
use crate::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use crate::events::{CommandKind, CycleEvents, KickMiss, KickResult, MatchEvent, Refusal};
use crate::game::{Game, GameState, Penalty};
use crate::geometry::{Pose, angle_of, file_units, unit, wrap_angle};
use crate::kick_geometry::{KickType, Strike};
use crate::knowledge::Knowledge;
use crate::random::{RandomStream, RandomStreams};
use crate::robot::Roster;
use crate::robot::posture::Posture;
use crate::team::RobotId;

/// Executes kick commands in [`ActSystems::Kick`] and strikes the ball in [`CycleSystems::Kick`].
pub struct KickPlugin;

impl Plugin for KickPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<KickCommand>()
            .register_type::<KickPhase>()
            .register_type::<KickSettings>()
            .add_systems(Cycle, take_kick_commands.in_set(ActSystems::Kick))
            .add_systems(Cycle, swing_legs.in_set(CycleSystems::Kick));
    }
}

/// A requested kick.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KickRequest {
    /// The type of the kick: `left_straight`, `right_straight`, `left_side` or `right_side`, or the name of a kick of the robot's model.
    #[serde(rename = "type")]
    pub kick_type: KickType,
    /// Share of the type's greatest launch speed, clamped to 0..1. NaN is refused.
    #[serde(default = "full_speed")]
    pub speed: f32,
    /// Direction for the ball, radians (degrees in files) to the left of straight ahead. Kicks that can be aimed follow it within
    /// their limits; others ignore it. A direction that is not finite is straight ahead.
    #[serde(default, rename = "direction_deg", with = "file_units::degrees", skip_serializing_if = "is_ahead")]
    #[schemars(with = "f32")]
    pub direction: f32,
}

impl KickRequest {
    /// A kick with direction 0.
    pub fn new(kick_type: KickType, speed: f32) -> Self {
        Self { kick_type, speed, direction: 0.0 }
    }
}

fn is_ahead(direction: &f32) -> bool {
    *direction == 0.0
}

/// Greatest height of the ball's lowest point at which a foot strikes it, m.
const HIGHEST_BALL_M: f32 = 0.1;

fn full_speed() -> f32 {
    1.0
}

/// The request of this cycle, if any. Reset to `None` after every cycle.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct KickCommand(pub Option<KickRequest>);

/// The phase of a robot's kick. The robot does not kick again before it has recovered, and does not walk unless it is a
/// [kick in walking](KickModel::in_walk).
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub enum KickPhase {
    /// No kick under way.
    #[default]
    Ready,
    /// The leg swings, for a side kick first to the front; the ball is struck at the end.
    WindUp {
        /// The kick under way.
        request: KickRequest,
        /// Whether the robot continues to walk.
        in_walk: bool,
        /// Cycles until the foot meets the ball.
        cycles_left: u32,
    },
    /// Regaining balance.
    Recovering {
        /// Whether the robot continues to walk.
        in_walk: bool,
        /// Cycles until the robot may kick again.
        cycles_left: u32,
    },
}

impl KickPhase {
    /// Whether the robot can walk in this phase.
    pub fn lets_walk(self) -> bool {
        match self {
            KickPhase::Ready => true,
            KickPhase::WindUp { in_walk, .. } | KickPhase::Recovering { in_walk, .. } => in_walk,
        }
    }
}

/// The launch speed of the ball, m/s. At speed 1 the ball rolls the kick's greatest distance.
pub(crate) fn launch_speed(
    strike: Strike,
    speed: f32,
    settings: &KickSettings,
    rolling: Rolling,
    stream: &mut RandomStream,
) -> f32 {
    let kick = strike.range_of;
    let greatest = rolling.speed_for_distance(settings.max_distance_m(kick));
    let least_m = settings.min_distance_m(kick);
    let least = if least_m > 0.0 { rolling.speed_for_distance(least_m) } else { 0.0 };
    let wanted = (greatest * speed).max(least);
    let factor = if strike.reduced { settings.wrong_side_speed_factor } else { 1.0 };
    let error = 1.0 + stream.gaussian(settings.speed_sd_of(kick));
    (wanted * factor * error).max(0.0)
}

fn take_kick_commands(
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    game: Res<Game>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<(&RobotId, &KickSettings, &Penalty, &Posture, &mut KickCommand, &mut KickPhase)>,
) {
    for entity in roster.entities() {
        let Ok((id, settings, penalty, posture, mut command, mut phase)) = robots.get_mut(entity) else { continue };
        let Some(request) = command.0 else { continue };
        command.0 = None;
        let reason = if request.speed.is_nan() {
            events.push(MatchEvent::CommandRefused {
                robot: *id,
                command: CommandKind::Kick,
                reason: Refusal::NotFinite,
            });
            Some(KickMiss::NotANumber)
        } else if settings.get(request.kick_type).is_none() {
            Some(KickMiss::NoSuchKick)
        } else if penalty.is_active() {
            Some(KickMiss::Penalised)
        } else if !posture.is_upright() {
            Some(KickMiss::Down)
        } else if *phase != KickPhase::Ready {
            Some(KickMiss::Busy)
        } else if game.state != GameState::Playing || game.stop.is_some() {
            Some(KickMiss::PlayStopped)
        } else {
            None
        };
        if let Some(reason) = reason {
            events.push(missed(*id, request, reason));
            continue;
        }
        let direction = if request.direction.is_finite() { request.direction } else { 0.0 };
        let request = KickRequest { speed: request.speed.clamp(0.0, 1.0), direction, ..request };
        let wind_up_s = settings.wind_up_of_s(request.kick_type);
        let in_walk = settings.is_in_walk(request.kick_type);
        *phase = KickPhase::WindUp { request, in_walk, cycles_left: clock.cycles_in(wind_up_s) };
    }
}

/// A ball that may be kicked.
#[derive(QueryData)]
#[query_data(mutable)]
struct KickedBall {
    entity: Entity,
    which: Option<&'static ExtraBall>,
    pose: &'static Pose,
    physics: &'static BallPhysics,
    velocity: &'static mut BallVelocity,
    flight: &'static mut BallFlight,
}

fn swing_legs(
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<(&RobotId, &Pose, &KickSettings, &mut KickPhase, &mut RandomStreams)>,
    mut balls: Query<KickedBall, Without<RobotId>>,
) {
    // Several robots may strike a ball in the same cycle: it then gets the sum of what each would have given it.
    let mut struck: Vec<(Entity, Vec3)> = Vec::new();
    for entity in roster.entities() {
        let Ok((id, pose, settings, mut phase, mut streams)) = robots.get_mut(entity) else { continue };
        let KickPhase::WindUp { request, cycles_left, in_walk } = *phase else {
            *phase = advance_phase(*phase, 0);
            continue;
        };
        let recovery_cycles = clock.cycles_in(settings.recovery_of_s(request.kick_type));
        *phase = advance_phase(*phase, recovery_cycles);
        let is_extended = request.kick_type.is_side_kick()
            && cycles_left == cycles_after_extension(request.kick_type, settings, &clock);
        if cycles_left > 0 && !is_extended {
            continue;
        }
        let strike = |ball: &KickedBallReadOnlyItem| {
            let place = pose.inverse_transform_point(ball.pose.position);
            let strike = settings.strike(request.kick_type, place, request.direction)?;
            // On the wrong side it is the extending foot that strikes, and not the one that moves aside.
            let meets = if strike.reduced { is_extended } else { cycles_left == 0 };
            meets.then_some((place.length_squared(), ball.which.copied(), ball.entity, strike, ball.physics.rolling))
        };
        let low = balls.iter().filter(|ball| ball.flight.height_m <= HIGHEST_BALL_M);
        // Of several balls, the nearest.
        let nearest = low.filter_map(|ball| strike(&ball)).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let Some((.., ball, strike, rolling)) = nearest else {
            if cycles_left == 0 {
                let reason = if balls.is_empty() { KickMiss::NoBall } else { KickMiss::OutOfReach };
                events.push(missed(*id, request, reason));
            }
            continue;
        };
        if cycles_left > 0 {
            // The foot met the ball on its way to the front: the side motion goes on without striking anything.
            *phase = recovering((cycles_left + recovery_cycles).saturating_sub(1), in_walk);
        }
        let speed = launch_speed(strike, request.speed, settings, rolling, &mut streams.kick);
        let direction = wrap_angle(
            pose.heading
                + angle_of(strike.direction)
                + streams.kick.gaussian(settings.direction_sd_of(strike.range_of)),
        );
        let (along, up) = launch(speed, settings.elevation_of(strike.range_of));
        let given = (unit(direction) * along).extend(up);
        match struck.iter_mut().find(|(other, _)| *other == ball) {
            Some((_, sum)) => *sum += given,
            // The sum of zero has no negative zeros, which traces would show.
            None => struck.push((ball, Vec3::ZERO + given)),
        }
        events.push(MatchEvent::Kick {
            robot: *id,
            kick_type: request.kick_type,
            speed: Some(request.speed),
            result: if strike.reduced { KickResult::Reduced } else { KickResult::Kicked },
            reason: None,
            direction: Some(direction),
            launch_speed_mps: Some(speed),
        });
    }
    for (ball, velocity) in struck {
        if let Ok(mut ball) = balls.get_mut(ball) {
            ball.velocity.0 = velocity.truncate();
            ball.flight.climb_mps = velocity.z;
        }
    }
}

fn missed(robot: RobotId, request: KickRequest, reason: KickMiss) -> MatchEvent {
    MatchEvent::Kick {
        robot,
        kick_type: request.kick_type,
        speed: (!request.speed.is_nan()).then(|| request.speed.clamp(0.0, 1.0)),
        result: KickResult::Missed,
        reason: Some(reason),
        direction: None,
        launch_speed_mps: None,
    }
}

/// Remaining cycles of the wind-up when the foot of a side kick is extended to the front.
fn cycles_after_extension(kick_type: KickType, settings: &KickSettings, clock: &CycleClock) -> u32 {
    let [wind_up, extension] =
        [settings.wind_up_of_s(kick_type), settings.extension_of_s(kick_type)].map(|time_s| clock.cycles_in(time_s));
    wind_up.saturating_sub(extension)
}

/// The phase one cycle later. The foot strikes the ball in the last cycle of the wind-up, which is the first of the recovery.
fn advance_phase(phase: KickPhase, recovery_cycles: u32) -> KickPhase {
    match phase {
        KickPhase::Ready => KickPhase::Ready,
        KickPhase::WindUp { cycles_left: 0, in_walk, .. } => recovering(recovery_cycles.saturating_sub(1), in_walk),
        KickPhase::WindUp { request, in_walk, cycles_left } => {
            KickPhase::WindUp { request, in_walk, cycles_left: cycles_left - 1 }
        }
        KickPhase::Recovering { in_walk, cycles_left } => recovering(cycles_left.saturating_sub(1), in_walk),
    }
}

/// The recovery with `cycles_left`, or ready if there are none.
fn recovering(cycles_left: u32, in_walk: bool) -> KickPhase {
    match cycles_left {
        0 => KickPhase::Ready,
        cycles_left => KickPhase::Recovering { in_walk, cycles_left },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kick_geometry::strike;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_launch_speed_scales_with_the_speed_and_reaches_the_greatest_distance() {
        let mut stream = RandomStream::for_match(1, "test");
        let (settings, rolling) = (KickSettings::default(), Rolling::default());
        let straight = strike(KickType::RightStraight, Vec2::new(0.15, -0.05)).unwrap();
        let full = launch_speed(straight, 1.0, &settings, rolling, &mut stream);
        assert_abs_diff_eq!(rolling.distance(full), 4.0, epsilon = 1e-5);
        assert_eq!(launch_speed(straight, 0.25, &settings, rolling, &mut stream), 0.25 * full);
        assert_eq!(launch_speed(straight, 0.0, &settings, rolling, &mut stream), 0.0);
        let wrong = strike(KickType::RightSide, Vec2::new(0.15, -0.05)).unwrap();
        assert_eq!(launch_speed(wrong, 1.0, &settings, rolling, &mut stream), 0.5 * full);
    }

    #[test]
    fn a_kick_takes_its_wind_up_and_recovery() {
        let request = KickRequest::new(KickType::LeftStraight, 1.0);
        let mut phase = KickPhase::WindUp { request, in_walk: false, cycles_left: 2 };
        let mut strikes = Vec::new();
        let mut cycles = 0;
        while phase != KickPhase::Ready {
            strikes.push(matches!(phase, KickPhase::WindUp { cycles_left: 0, .. }));
            phase = advance_phase(phase, 5);
            cycles += 1;
        }
        // Two cycles of wind-up, then five of recovery, beginning with the cycle of the strike.
        assert_eq!((cycles, strikes.iter().position(|strike| *strike)), (7, Some(2)));
    }
}
