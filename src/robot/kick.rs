//! Kicks: the four types of the paper's section 3.2, the place of the ball that each needs, and their course in time.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Roster;
use super::posture::Posture;
use crate::ball::{Ball, BallPhysics, BallVelocity, Rolling};
use crate::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use crate::events::{CommandKind, CycleEvents, KickMiss, KickResult, MatchEvent, Refusal};
use crate::game::{Game, GameState, Penalty};
use crate::geometry::{Pose, angle_of, file_units, unit, wrap_angle};
use crate::kick_geometry::{KickGeometry, KickType, Strike, strike_by};
use crate::knowledge::Knowledge;
use crate::random::{RandomStream, RandomStreams};
use crate::team::RobotId;

/// Takes over kick commands in [`ActSystems::Kick`] and strikes the ball in [`CycleSystems::Kick`].
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

/// A kick that a behaviour wants.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KickRequest {
    /// The kind of kick, and with which foot.
    #[serde(rename = "type")]
    pub kick_type: KickType,
    /// 0 to 1: the share of the type's greatest launch speed. Clamped outside; a kick of NaN is refused.
    #[serde(default = "full_speed")]
    pub speed: f32,
}

fn full_speed() -> f32 {
    1.0
}

/// The kick wanted in this cycle, if any. None again after every cycle.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct KickCommand(pub Option<KickRequest>);

/// Where a robot is in the course of a kick: it neither walks nor kicks again before it has recovered.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
#[non_exhaustive]
pub enum KickPhase {
    /// Does not kick, and may begin to.
    #[default]
    Ready,
    /// The leg swings; the ball is struck when the time is over.
    WindUp {
        /// The kick under way.
        request: KickRequest,
        /// Cycles until the foot meets the ball.
        cycles_left: u32,
    },
    /// Regaining balance.
    Recovering {
        /// Cycles until the robot may walk again.
        cycles_left: u32,
    },
}

/// How far one type of kick sends the ball.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct KickRange {
    /// Distance that the ball rolls at speed 1 with nothing in its way, m; nought of a kick that the robot does not have.
    pub max_distance_m: f32,
    /// Where the ball must lie, and where it goes: where nothing is said, as in the paper's Table 2.
    pub region: Option<KickGeometry>,
}

impl KickRange {
    /// A kick with the paper's geometry.
    pub const fn of(max_distance_m: f32) -> Self {
        Self { max_distance_m, region: None }
    }
}

impl Default for KickRange {
    fn default() -> Self {
        Self::of(4.0)
    }
}

/// Settings of the kicks.
///
/// Distances: rUNSWift's forward kick of 2010 reached 4.0 to 5.8 m at full power, its side kick 2 to 3 m.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct KickSettings {
    /// The left straight kick; 4 m by default.
    pub left_straight: KickRange,
    /// The right straight kick; 4 m by default.
    pub right_straight: KickRange,
    /// The left side kick; 2 m by default.
    pub left_side: KickRange,
    /// The right side kick; 2 m by default.
    pub right_side: KickRange,
    /// A side kick from the wrong side is a straight kick at this share of the speed (paper, section 3.2).
    pub wrong_side_speed_factor: f32,
    /// From the command until the foot meets the ball, s.
    pub wind_up_s: f32,
    /// From then until the robot can walk or kick again, s.
    pub recovery_s: f32,
    /// Standard deviation of the direction, radians (degrees in files).
    #[serde(rename = "direction_sd_deg", with = "file_units::degrees")]
    pub direction_sd: f32,
    /// Standard deviation of the launch speed, as a share of it.
    pub speed_sd: f32,
}

impl Default for KickSettings {
    fn default() -> Self {
        Self {
            left_straight: KickRange::of(4.0),
            right_straight: KickRange::of(4.0),
            left_side: KickRange::of(2.0),
            right_side: KickRange::of(2.0),
            wrong_side_speed_factor: 0.5,
            wind_up_s: 0.0,
            recovery_s: 1.0,
            direction_sd: 0.0,
            speed_sd: 0.0,
        }
    }
}

impl KickSettings {
    /// The range of a type of kick.
    pub fn range(&self, kick_type: KickType) -> KickRange {
        match kick_type {
            KickType::LeftStraight => self.left_straight,
            KickType::RightStraight => self.right_straight,
            KickType::LeftSide => self.left_side,
            KickType::RightSide => self.right_side,
        }
    }

    /// Where the ball must lie for a type of kick, and where it goes; none if the robot does not have it.
    pub fn geometry(&self, kick_type: KickType) -> Option<KickGeometry> {
        let range = self.range(kick_type);
        (range.max_distance_m > 0.0).then(|| range.region.unwrap_or_else(|| KickGeometry::of_paper(kick_type)))
    }

    /// What this robot's kick does to a ball at this place in its frame, if anything.
    pub fn strike(&self, kick_type: KickType, ball_in_robot: Vec2) -> Option<Strike> {
        strike_by(kick_type, ball_in_robot, |kick| self.geometry(kick))
    }
}

/// The speed at which the ball leaves, m/s: so that it rolls the kick's greatest distance at speed 1.
pub fn launch_speed(
    strike: Strike,
    speed: f32,
    settings: &KickSettings,
    rolling: Rolling,
    stream: &mut RandomStream,
) -> f32 {
    let greatest = rolling.speed_for_distance(settings.range(strike.range_of).max_distance_m);
    let factor = if strike.reduced { settings.wrong_side_speed_factor } else { 1.0 };
    let error = 1.0 + stream.gaussian(settings.speed_sd);
    (greatest * speed * factor * error).max(0.0)
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
        } else if penalty.is_active() {
            Some(KickMiss::Penalised)
        } else if !posture.is_upright() {
            Some(KickMiss::Down)
        } else if *phase != KickPhase::Ready {
            Some(KickMiss::Busy)
        } else if game.state != GameState::Playing {
            Some(KickMiss::PlayStopped)
        } else {
            None
        };
        if let Some(reason) = reason {
            events.push(missed(*id, request, reason));
            continue;
        }
        let request = KickRequest { speed: request.speed.clamp(0.0, 1.0), ..request };
        *phase = KickPhase::WindUp { request, cycles_left: clock.cycles_in(settings.wind_up_s) };
    }
}

fn swing_legs(
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<(&RobotId, &Pose, &KickSettings, &mut KickPhase, &mut RandomStreams)>,
    mut ball: Query<(&Pose, &BallPhysics, &mut BallVelocity), (With<Ball>, Without<RobotId>)>,
) {
    // Several robots may strike the ball in the same cycle: it then gets the sum of what each would have given it.
    let mut struck: Option<Vec2> = None;
    for entity in roster.entities() {
        let Ok((id, pose, settings, mut phase, mut streams)) = robots.get_mut(entity) else { continue };
        let (request, next) = advance_phase(*phase, clock.cycles_in(settings.recovery_s));
        *phase = next;
        let Some(request) = request else { continue };
        let Ok((ball_pose, physics, _)) = ball.single() else {
            events.push(missed(*id, request, KickMiss::NoBall));
            continue;
        };
        let Some(strike) = settings.strike(request.kick_type, pose.inverse_transform_point(ball_pose.position)) else {
            events.push(missed(*id, request, KickMiss::OutOfReach));
            continue;
        };
        let speed = launch_speed(strike, request.speed, settings, physics.rolling, &mut streams.kick);
        let direction =
            wrap_angle(pose.heading + angle_of(strike.direction) + streams.kick.gaussian(settings.direction_sd));
        *struck.get_or_insert_default() += unit(direction) * speed;
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
    if let (Some(velocity), Ok((_, _, mut ball_velocity))) = (struck, ball.single_mut()) {
        ball_velocity.0 = velocity;
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

/// One cycle of a kick: the request if the foot meets the ball now, and the next phase. The cycle of the strike is
/// the first of the recovery.
pub fn advance_phase(phase: KickPhase, recovery_cycles: u32) -> (Option<KickRequest>, KickPhase) {
    let recovering = |cycles_left: u32| match cycles_left {
        0 => KickPhase::Ready,
        cycles_left => KickPhase::Recovering { cycles_left },
    };
    match phase {
        KickPhase::Ready => (None, KickPhase::Ready),
        KickPhase::WindUp { request, cycles_left: 0 } => (Some(request), recovering(recovery_cycles.saturating_sub(1))),
        KickPhase::WindUp { request, cycles_left } => {
            (None, KickPhase::WindUp { request, cycles_left: cycles_left - 1 })
        }
        KickPhase::Recovering { cycles_left } => (None, recovering(cycles_left.saturating_sub(1))),
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
        let request = KickRequest { kick_type: KickType::LeftStraight, speed: 1.0 };
        let mut phase = KickPhase::WindUp { request, cycles_left: 2 };
        let mut strikes = Vec::new();
        let mut cycles = 0;
        while phase != KickPhase::Ready {
            let (strike, next) = advance_phase(phase, 5);
            strikes.push(strike.is_some());
            phase = next;
            cycles += 1;
        }
        // Two cycles of wind-up, then five of recovery, the first of which is that of the strike.
        assert_eq!((cycles, strikes.iter().position(|strike| *strike)), (7, Some(2)));
    }
}
