//! The commands that robots are given in an episode, for playing them back.

use base64::prelude::{BASE64_STANDARD, Engine};
use bevy::ecs::system::SystemChangeTick;
use bevy::prelude::*;
use std::collections::BTreeMap;

use crate::agents::RobotCommand;
use naoisis_core::cycle::{Cycle, CycleHalf, CycleSystems};
use naoisis_core::team::RobotId;
use naoisis_sim::interface::vocabulary::Commanded;

/// Compression level of commands in files.
const PACKING: i32 = 9;
/// The most bytes of the commands of an episode, unpacked: those of 22 robots in an hour.
const LARGEST_BYTES: usize = 256 << 20;

/// Lets `app` record the commands of all robots as [`RecordedCommands`]. It may be finished, so this is no plugin.
pub(super) fn record_commands(app: &mut App) {
    let between = record.after(CycleSystems::Decide).before(CycleSystems::Act).in_set(CycleHalf::Act);
    app.init_resource::<RecordedCommands>().add_systems(Cycle, between);
}

/// The commands of all robots in each cycle.
#[derive(Resource, Default)]
pub(super) struct RecordedCommands(Vec<BTreeMap<RobotId, RobotCommand>>);

impl RecordedCommands {
    /// Returns the commands of some robots, cycle by cycle, and forgets all commands.
    pub fn take(&mut self, robots: &[RobotId]) -> Vec<Vec<RobotCommand>> {
        let of_cycle =
            |mut cycle: BTreeMap<_, _>| robots.iter().map(|id| cycle.remove(id).unwrap_or_default()).collect();
        self.0.drain(..).map(of_cycle).collect()
    }
}

fn record(mut recorded: ResMut<RecordedCommands>, robots: Query<(&RobotId, Commanded)>, ticks: SystemChangeTick) {
    let commands = robots.iter().map(|(id, robot)| (*id, robot.command(ticks.last_run(), ticks.this_run())));
    recorded.0.push(commands.collect());
}

/// Returns commands as text for a file: JSON, compressed by zstd, in base64. Returns `None` if they cannot be written.
pub(super) fn pack(commands: &[Vec<RobotCommand>]) -> Option<String> {
    let json = serde_json::to_vec(commands).ok()?;
    Some(BASE64_STANDARD.encode(zstd::bulk::compress(&json, PACKING).ok()?))
}

/// Returns the commands of a text by [`pack`]. Returns `None` if it is damaged, or too large.
pub(super) fn unpack(text: &str) -> Option<Vec<Vec<RobotCommand>>> {
    let packed = BASE64_STANDARD.decode(text).ok()?;
    let size = zstd::bulk::Decompressor::upper_bound(&packed)?.min(LARGEST_BYTES);
    serde_json::from_slice(&zstd::bulk::decompress(&packed, size).ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::robot::head::HeadCommand;
    use naoisis_core::robot::motion::WalkCommand;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rounded_commands_are_the_same_after_a_file(numbers in prop::collection::vec(-3.0f32..3.0, 5), cycles in 0..4usize) {
            let [dx, dy, dtheta, yaw, pitch] = numbers[..] else { unreachable!() };
            let (walk, head) = (Some(WalkCommand { dx, dy, dtheta }), Some(HeadCommand { yaw, pitch }));
            let command = RobotCommand { walk, head, ..default() }.rounded();
            let commands = vec![vec![command, RobotCommand::default()]; cycles];
            prop_assert_eq!(unpack(&pack(&commands).unwrap()), Some(commands));
        }
    }

    #[test]
    fn what_is_damaged_is_no_list_of_commands() {
        let good = pack(&[vec![RobotCommand::default()]]).unwrap();
        assert!(unpack(&good).is_some());
        for damaged in ["", "?", "AAAA", &good[4..], &good[..8]] {
            assert_eq!(unpack(damaged), None, "{damaged}");
        }
    }
}
