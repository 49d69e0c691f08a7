//! Commands of a trace in place of the answers of programs, to play a match of programs again.

use bevy::prelude::*;
use serde_json::Value;
use std::collections::BTreeMap;

use super::player::AgentPlayer;
use super::remote::CommandComponents;
use naoisis_core::behaviour::Remote;
use naoisis_core::team::RobotId;
use naoisis_sim::interface::vocabulary::RobotCommand;

/// The commands of remote robots in the next cycle, as a trace has them. Programs are asked all the same, so that they learn what happens;
/// their own answers count where they are those of the trace, whose numbers are rounded. Remove the resource to let programs decide.
#[derive(Resource, Clone, PartialEq, Debug, Default)]
pub struct ReplayedCommands(pub BTreeMap<RobotId, RobotCommand>);

impl ReplayedCommands {
    /// The command of a robot whose program answers `own`.
    pub(super) fn instead_of(&self, robot: RobotId, own: RobotCommand) -> RobotCommand {
        match self.0.get(&robot) {
            Some(traced) if !is_about(&own, traced) => traced.clone(),
            _ => own,
        }
    }
}

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

/// Whether two commands are the same but for the rounding of traces.
fn is_about(one: &RobotCommand, other: &RobotCommand) -> bool {
    let value = |command: &RobotCommand| serde_json::to_value(command).unwrap_or_default();
    one == other || are_about(&value(one), &value(other))
}

fn are_about(one: &Value, other: &Value) -> bool {
    /// The share by which rounded numbers may differ.
    const ROUNDING: f64 = 1e-3;
    /// The difference that rounded numbers may have in any case.
    const LEAST: f64 = 1e-6;
    match (one, other) {
        (Value::Number(one), Value::Number(other)) => {
            let [one, other] = [one, other].map(|number| number.as_f64().unwrap_or_default());
            (one - other).abs() <= LEAST + ROUNDING * one.abs()
        }
        (Value::Array(one), Value::Array(other)) => {
            one.len() == other.len() && one.iter().zip(other).all(|(one, other)| are_about(one, other))
        }
        (Value::Object(one), Value::Object(other)) => {
            one.len() == other.len()
                && one.iter().all(|(name, one)| other.get(name).is_some_and(|other| are_about(one, other)))
        }
        _ => one == other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::Team;

    #[test]
    fn an_answer_counts_if_it_is_that_of_the_trace_but_for_rounding() {
        let command = |text: &str| RobotCommand::from_json(text.as_bytes()).unwrap();
        let robot = RobotId::new(Team::Blue, 1);
        let traced = command(r#"{ "walk": [0.00612, 0, 3], "say": { "pose": [1, 2, 30] } }"#);
        let replayed = ReplayedCommands(BTreeMap::from([(robot, traced.clone())]));
        let exact = command(r#"{ "walk": [0.006123456, 0, 3], "say": { "pose": [1.0001, 2, 30] } }"#);
        assert_eq!(replayed.instead_of(robot, exact.clone()), exact);
        for other in
            ["{}", r#"{ "walk": [0.0062, 0, 3], "say": { "pose": [1, 2, 30] } }"#, r#"{ "walk": [0.00612, 0, 3] }"#]
        {
            assert_eq!(replayed.instead_of(robot, command(other)), traced);
        }
        let other = RobotId::new(Team::Pink, 1);
        assert_eq!(replayed.instead_of(other, exact.clone()), exact);
    }
}
