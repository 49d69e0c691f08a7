//! Commands of a trace in place of the answers of programs, to play a match of programs again.

use bevy::prelude::*;
use std::collections::BTreeMap;

use super::player::AgentPlayer;
use super::remote::CommandComponents;
use naoisis_core::behaviour::Remote;
use naoisis_core::team::RobotId;
use naoisis_sim::interface::vocabulary::RobotCommand;

/// The commands of remote robots in the next cycle, as a trace has them. Programs are asked all the same, so that they learn what happens.
/// Remove the resource to let programs decide.
#[derive(Resource, Clone, PartialEq, Debug, Default)]
pub struct ReplayedCommands(pub BTreeMap<RobotId, RobotCommand>);

/// Commands the robots of programs that are not there, such as those that connected to the match.
pub(super) fn command_robots_without_program(
    replayed: Res<ReplayedCommands>,
    mut robots: Query<(&RobotId, CommandComponents), (With<Remote>, Without<AgentPlayer>)>,
) {
    for (id, mut robot) in &mut robots {
        if let Some(command) = replayed.0.get(id) {
            // The trace is of a robot with this kick.
            let _ = robot.apply(command.clone());
        }
    }
}
