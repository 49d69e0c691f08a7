//! The commands that robots are given in an episode, for playing them back.

use bevy::ecs::system::SystemChangeTick;
use bevy::prelude::*;
use std::collections::BTreeMap;

use crate::agents::RobotCommand;
use naoisis_core::cycle::{Cycle, CycleHalf, CycleSystems};
use naoisis_core::team::RobotId;
use naoisis_sim::interface::vocabulary::Commanded;

/// Lets `app` record the commands of all robots as [`RecordedCommands`]. It may be finished, so this is no plugin.
pub(super) fn record_commands(app: &mut App) {
    let between = record.after(CycleSystems::Decide).before(CycleSystems::Act).in_set(CycleHalf::Act);
    app.init_resource::<RecordedCommands>().add_systems(Cycle, between);
}

/// The commands of all robots in each cycle.
#[derive(Resource, Default)]
pub(super) struct RecordedCommands(pub Vec<BTreeMap<RobotId, RobotCommand>>);

fn record(mut recorded: ResMut<RecordedCommands>, robots: Query<(&RobotId, Commanded)>, ticks: SystemChangeTick) {
    let motion = |command: RobotCommand| RobotCommand { say: None, request: None, ..command };
    let commands = robots.iter().map(|(id, robot)| (*id, motion(robot.command(ticks.last_run(), ticks.this_run()))));
    recorded.0.push(commands.collect());
}
