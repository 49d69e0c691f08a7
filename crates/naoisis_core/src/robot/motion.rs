//! Walking: execution of walk commands with the robot's limits and errors.
//!
//! The paper's motion engine (section 3.2, equation 1) accepts a desired displacement (dx, dy, dθ) in the robot's
//! current frame, for the coming cycle. What exceeds the robot's maximum linear or angular velocity is scaled down;
//! then a random error with its own spread in each dimension is added. Where a robot has a [gait](super::gait), it walks step by
//! step instead.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::Roster;
use super::condition::{Breakdowns, Condition};
use super::gait::{GaitState, GroundStep};
use super::kick::KickPhase;
pub use super::motion_settings::{MotionError, MotionSettings};
use super::posture::Posture;
pub use super::walk_command::WalkCommand;
use crate::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use crate::events::{CommandKind, CycleEvents, MatchEvent, Refusal};
use crate::game::{Game, GameState, Penalty, Rules};
use crate::geometry::{Pose, wrap_angle};
use crate::knowledge::Knowledge;
use crate::random::{RandomStream, RandomStreams};
use crate::team::RobotId;

/// Executes walk commands in [`ActSystems::Walk`] and moves the robots in [`CycleSystems::Move`].
pub struct MotionPlugin;

impl Plugin for MotionPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<WalkCommand>()
            .register_type::<ExecutedStep>()
            .register_type::<MotionSettings>()
            .register_type::<GaitState>()
            .register_type::<GroundStep>()
            .add_systems(Cycle, take_walk_commands.in_set(ActSystems::Walk))
            .add_systems(Cycle, walk.in_set(CycleSystems::Move));
    }
}

/// The displacement of the robot's legs in the last cycle, m and radians, in the robot frame before the turn: the command after
/// limits and error. Slip ([`GroundStep`]) or a collision may have shortened it.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[require(GaitState, GroundStep)]
#[reflect(Component, @Knowledge::Truth)]
pub struct ExecutedStep(pub WalkCommand);

/// A robot that can walk.
#[derive(QueryData)]
#[query_data(mutable)]
struct WalkingRobot {
    id: &'static RobotId,
    motion: &'static MotionSettings,
    breakdowns: &'static Breakdowns,
    condition: &'static Condition,
    kick_phase: &'static KickPhase,
    penalty: &'static Penalty,
    posture: &'static Posture,
    command: &'static mut WalkCommand,
    step: &'static mut ExecutedStep,
    ground: &'static mut GroundStep,
    gait: &'static mut GaitState,
    streams: &'static mut RandomStreams,
}

/// Refuses commands with numbers that are not finite or too large; applies limits and error to the others.
fn take_walk_commands(
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    game: Res<Game>,
    rules: Res<Rules>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<WalkingRobot>,
) {
    let may_walk = match game.state {
        _ if game.stop.is_some() => rules.motion_in_stop,
        GameState::Ready | GameState::Playing => true,
        // Robots can walk in these states if the rules penalise it.
        GameState::Standby | GameState::Set => rules.motion_in_set_s.is_some() && game.shoot_out.is_none(),
        GameState::Initial | GameState::Timeout | GameState::Finished => false,
    };
    for entity in roster.entities() {
        let Ok(mut robot) = robots.get_mut(entity) else { continue };
        let wanted = core::mem::take(&mut *robot.command);
        let wanted = match Refusal::of_numbers([wanted.dx, wanted.dy, wanted.dtheta]) {
            None => wanted,
            Some(reason) => {
                events.push(MatchEvent::CommandRefused { robot: *robot.id, command: CommandKind::Walk, reason });
                WalkCommand::default()
            }
        };
        let is_free = robot.kick_phase.lets_walk() && robot.posture.is_upright() && !robot.penalty.is_active();
        let may_step = may_walk && is_free;
        let motion = robot.condition.motion(robot.motion, robot.breakdowns);
        [robot.step.0, robot.ground.0] = match &motion.gait {
            None if may_step => [executed_step(wanted, &motion, clock.period(), &mut robot.streams.motion); 2],
            Some(gait) if may_step => robot.gait.walk(wanted, gait, &motion, clock.period(), &mut robot.streams.slip),
            _ => {
                robot.gait.stand();
                [WalkCommand::default(); 2]
            }
        };
    }
}

fn walk(mut robots: Query<(&GroundStep, &mut Pose)>) {
    for (step, mut pose) in &mut robots {
        if !step.0.is_null() {
            *pose = after_step(*pose, step.0);
        }
    }
}

/// The displacement that the robot executes in a cycle of `period` seconds with `command`: the translation is scaled as a vector
/// to the linear limit, which keeps its direction, the turn separately; then the error is added. A zero command is executed
/// exactly.
fn executed_step(command: WalkCommand, motion: &MotionSettings, period: f32, stream: &mut RandomStream) -> WalkCommand {
    if command.is_null() {
        return command;
    }
    let translation = command.translation().clamp_length_max(motion.max_linear_mps * period);
    let most_turn = motion.max_angular * period;
    WalkCommand {
        dx: translation.x + stream.gaussian(motion.error_sd.dx_m),
        dy: translation.y + stream.gaussian(motion.error_sd.dy_m),
        dtheta: command.dtheta.clamp(-most_turn, most_turn) + stream.gaussian(motion.error_sd.dtheta),
    }
}

/// The pose after a step: the translation is in the frame before the turn.
pub fn after_step(pose: Pose, step: WalkCommand) -> Pose {
    Pose { position: pose.transform_point(step.translation()), heading: wrap_angle(pose.heading + step.dtheta) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    const PERIOD: f32 = 1.0 / 30.0;

    fn exact_step(command: WalkCommand) -> WalkCommand {
        let mut stream = RandomStream::for_match(1, "test");
        executed_step(command, &MotionSettings::default(), PERIOD, &mut stream)
    }

    #[test]
    fn a_command_within_the_limits_is_carried_out_exactly() {
        let command = WalkCommand::new(0.004, -0.003, 0.05);
        assert_eq!(exact_step(command), command);
    }

    #[test]
    fn a_velocity_is_the_same_walk_however_long_the_cycles_are() {
        for cycles_per_second in [10, 30, 83] {
            let clock = CycleClock { period_s: 1.0 / f64::from(cycles_per_second), ..CycleClock::default() };
            let motion = MotionSettings { max_linear_mps: 1.0, max_angular: 2.0, ..MotionSettings::default() };
            let mut stream = RandomStream::for_match(1, "test");
            let command = WalkCommand::at_velocity(0.5, 0.0, 0.5, &clock);
            let mut pose = Pose::default();
            for _ in 0..cycles_per_second {
                pose = after_step(pose, executed_step(command, &motion, clock.period(), &mut stream));
            }
            // An arc of 0.5 rad with a radius of 1 m, except for the corners between its steps: at most half of a turn of 0.05 rad.
            assert_abs_diff_eq!(pose.position, Vec2::new(0.5_f32.sin(), 1.0 - 0.5_f32.cos()), epsilon = 0.0125);
            assert_abs_diff_eq!(pose.heading, 0.5, epsilon = 1e-5);
        }
    }

    #[test]
    fn a_longer_translation_keeps_its_direction_and_the_turn_is_limited_on_its_own() {
        let step = exact_step(WalkCommand::new(3.0, 4.0, -0.01));
        // 0.2 m/s for 1/30 s is 6.67 mm; the direction (3, 4) / 5 stays.
        assert_abs_diff_eq!(step.dx, 0.6 * 0.2 / 30.0, epsilon = 1e-7);
        assert_abs_diff_eq!(step.dy, 0.8 * 0.2 / 30.0, epsilon = 1e-7);
        assert_eq!(step.dtheta, -0.01);
        let turn = exact_step(WalkCommand::new(0.0, 0.0, -7.0)).dtheta;
        // 90 degrees per second for 1/30 s are 3 degrees.
        assert_abs_diff_eq!(turn, -3.0_f32.to_radians(), epsilon = 1e-6);
    }

    #[test]
    fn a_robot_walks_along_its_heading() {
        let mut pose = Pose::new(1.0, 2.0, 2.0);
        for _ in 0..30 {
            pose = after_step(pose, WalkCommand::new(0.005, 0.0, 0.0));
        }
        // 30 steps of 5 mm at heading 2 rad: (1, 2) + 0.15 (cos 2, sin 2).
        assert_abs_diff_eq!(
            pose.position,
            Vec2::new(1.0 + 0.15 * 2.0_f32.cos(), 2.0 + 0.15 * 2.0_f32.sin()),
            epsilon = 1e-5
        );
    }

    #[test]
    fn the_error_has_the_spread_asked_for_in_each_dimension_and_null_commands_have_none() {
        let motion = MotionSettings {
            error_sd: MotionError { dx_m: 0.001, dy_m: 0.002, dtheta: 0.01 },
            ..MotionSettings::default()
        };
        let mut stream = RandomStream::for_match(5, "test");
        assert!(executed_step(WalkCommand::default(), &motion, PERIOD, &mut stream).is_null());
        let count = 20_000;
        let command = WalkCommand::new(0.005, 0.0, 0.0);
        let mut sums = [0.0f64; 6];
        for _ in 0..count {
            let step = executed_step(command, &motion, PERIOD, &mut stream);
            for (index, error) in [step.dx - 0.005, step.dy, step.dtheta].into_iter().enumerate() {
                sums[index] += f64::from(error);
                sums[index + 3] += f64::from(error).powi(2);
            }
        }
        for (index, sd) in [0.001, 0.002, 0.01].into_iter().enumerate() {
            let mean = sums[index] / f64::from(count);
            let spread = (sums[index + 3] / f64::from(count)).sqrt();
            // Standard errors: sd / sqrt(n) = 0.7 % of sd for the mean, sd / sqrt(2 n) = 0.5 % for the spread. Four
            // of them hold with 99.99 % confidence.
            assert!(mean.abs() < 4.0 * sd / f64::from(count).sqrt());
            assert!((spread / sd - 1.0).abs() < 4.0 * 0.005);
        }
    }
}
