//! Runs the cycles of a match in a schedule of the app, such as `FixedUpdate`.

use bevy::app::{FixedFirst, FixedLast, FixedMain, FixedPostUpdate, FixedPreUpdate};
use bevy::ecs::schedule::{InternedScheduleLabel, ScheduleLabel};
use bevy::prelude::*;
use core::time::Duration;

use super::match_commands::{is_over, is_time_over};
use super::triggers::{MatchEnd, MatchEnded};
use crate::scenario::Scenario;
use naoisis_core::cycle::{CycleClock, run_cycle};
use naoisis_core::game::{Game, GameState};

/// Runs a cycle of the match each time a schedule runs, as long as there is a match that is not over.
///
/// In the schedules of the fixed main loop, such as `FixedUpdate`, the timestep of [`Time<Fixed>`] is set to the scenario's `cycle_s` while
/// there is a match, so that the match follows the app's virtual time. In any other schedule, one cycle is run each time.
pub struct CycleRunnerPlugin {
    schedule: InternedScheduleLabel,
}

impl CycleRunnerPlugin {
    /// Creates the plugin for `schedule`.
    pub fn new(schedule: impl ScheduleLabel) -> Self {
        Self { schedule: schedule.intern() }
    }
}

impl Plugin for CycleRunnerPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(self.schedule, play_cycle.in_set(RunCycle));
        let fixed = [
            FixedMain.intern(),
            FixedFirst.intern(),
            FixedPreUpdate.intern(),
            FixedUpdate.intern(),
            FixedPostUpdate.intern(),
            FixedLast.intern(),
        ];
        if fixed.contains(&self.schedule) {
            let set_timestep = set_timestep.run_if(resource_exists::<Scenario>);
            app.add_systems(RunFixedMainLoop, set_timestep.in_set(RunFixedMainLoopSystems::BeforeFixedMainLoop));
        }
    }
}

/// The system set that runs the cycle. Systems of the same schedule can run before or after it.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RunCycle;

fn set_timestep(clock: Res<CycleClock>, time: Option<ResMut<Time<Fixed>>>) {
    let Some(mut time) = time else { return };
    let Ok(timestep) = Duration::try_from_secs_f64(clock.period_s) else { return };
    if timestep != time.timestep() && !timestep.is_zero() {
        time.set_timestep(timestep);
    }
}

fn play_cycle(world: &mut World) {
    if !world.contains_resource::<Scenario>() || is_over(world) {
        return;
    }
    run_cycle(world);
    let game = world.resource::<Game>();
    let (state, score) = (game.state, game.score);
    // The final whistle has its own event.
    if state != GameState::Finished && is_time_over(world) {
        world.trigger(MatchEnded { reason: MatchEnd::TimeOver, score });
    }
}
