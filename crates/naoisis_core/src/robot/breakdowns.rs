//! Breakdowns of robots other than falls: robots are picked up, their programs restart, their motors get hot.
//!
//! - At a constant rate during play, a team asks for its robot to be picked up. The referee removes it for the penalty of the rules.
//! - At another rate, the program of a robot stops and restarts. In the meantime the robot stands still, says nothing and does not react.
//! - A robot that walks gets hot, and one that stands cools down. A hot robot walks more slowly.

use bevy::ecs::query::QueryData;
use bevy::math::ops;
use bevy::prelude::*;

use super::Roster;
use super::condition::{Breakdowns, Condition};
use super::falls::{FallSystems, fall};
use super::head::{HeadAngles, HeadCommand};
use super::kick::KickCommand;
use super::latency::delay_commands;
use super::motion::{ExecutedStep, MotionSettings};
use super::posture::PostureCommand;
use super::walk_command::WalkCommand;
use crate::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use crate::events::{CycleEvents, MatchEvent};
use crate::game::{Game, GameState, Intervention, Interventions, Penalty};
use crate::random::RandomStreams;
use crate::team::RobotId;

/// Lets robots break down after their falls and before the referee. Robots whose programs restart do nothing from [`CycleSystems::Act`] on.
pub struct BreakdownsPlugin;

impl Plugin for BreakdownsPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Breakdowns>()
            .register_type::<Condition>()
            .register_required_components::<RobotId, Breakdowns>()
            .register_required_components::<RobotId, Condition>()
            .add_systems(
                Cycle,
                (
                    hold_restarting.in_set(CycleSystems::Act).before(ActSystems::Say).before(delay_commands),
                    break_down.after(fall).in_set(FallSystems).in_set(CycleSystems::Officiate),
                ),
            );
    }
}

/// The commands of a robot.
#[derive(QueryData)]
#[query_data(mutable)]
struct Commanded {
    condition: &'static Condition,
    walk: &'static mut WalkCommand,
    angles: &'static HeadAngles,
    head: &'static mut HeadCommand,
    kick: &'static mut KickCommand,
    posture: &'static mut PostureCommand,
}

/// Drops the commands of robots whose programs restart.
fn hold_restarting(mut robots: Query<Commanded>) {
    for mut robot in &mut robots {
        if robot.condition.is_running() {
            continue;
        }
        *robot.walk = WalkCommand::default();
        *robot.kick = KickCommand::default();
        *robot.posture = PostureCommand::default();
        *robot.head = HeadCommand { yaw: robot.angles.yaw, pitch: robot.angles.pitch };
    }
}

/// A robot that may break down.
#[derive(QueryData)]
#[query_data(mutable)]
struct BreakingRobot {
    breakdowns: &'static Breakdowns,
    motion: &'static MotionSettings,
    step: &'static ExecutedStep,
    penalty: &'static Penalty,
    condition: &'static mut Condition,
    streams: &'static mut RandomStreams,
}

fn break_down(
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    game: Res<Game>,
    mut interventions: ResMut<Interventions>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<BreakingRobot>,
) {
    let period = clock.period();
    for (id, entity) in roster.iter() {
        let Ok(mut robot) = robots.get_mut(entity) else { continue };
        if !robot.condition.is_running() {
            robot.condition.restart_cycles_left -= 1;
        }
        let breakdowns = *robot.breakdowns;
        if breakdowns == Breakdowns::default() {
            continue;
        }
        if let Some(hot_after_s) = breakdowns.hot_after_s {
            let speed_mps = robot.step.0.translation().length() / period;
            let speed_share = speed_mps / robot.motion.max_linear_mps.max(1e-3);
            robot.condition.warm_up(speed_share, hot_after_s, period);
        }
        if game.state != GameState::Playing || robot.penalty.is_active() || !robot.condition.is_running() {
            continue;
        }
        let mut happens =
            |per_hour: f32| per_hour > 0.0 && robot.streams.breakdowns.chance(probability_within(per_hour, period));
        if happens(breakdowns.pick_ups_per_hour) {
            interventions.queue.push(Intervention::PickUp { robot: id });
        } else if happens(breakdowns.restarts_per_hour) {
            robot.condition.restart_cycles_left = clock.cycles_in(breakdowns.restart_s);
            events.push(MatchEvent::ProgramRestarts { robot: id, duration_s: breakdowns.restart_s });
        }
    }
}

/// The probability that an event with this rate happens within `period` seconds (a Poisson process).
fn probability_within(per_hour: f32, period: f32) -> f32 {
    -ops::exp_m1(-per_hour / 3600.0 * period)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn probabilities_are_those_of_their_rates() {
        assert_abs_diff_eq!(probability_within(3600.0, 1.0), 1.0 - (-1.0_f32).exp(), epsilon = 1e-6);
        assert_abs_diff_eq!(probability_within(1.0, 1.0 / 30.0), 1.0 / 108_000.0, epsilon = 1e-9);
    }
}
