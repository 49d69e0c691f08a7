//! Changes the settings of a match while it runs.

use bevy::prelude::*;

use super::names;
use super::sensors::SensorRegistry;
use crate::scenario::{FieldPath, RobotSettings, Scenario, ScenarioFault, Segment};
use naoisis_core::ball::BallPhysics;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;

/// Settings of robots that cannot change during a match.
const FIXED: [&str; 2] = ["body", "localisation"];

/// Fields of a scenario that can change during its match, besides the settings of robots.
const OF_THE_MATCH: [&str; 4] = ["rules", "ball.rolling", "ball.restitution", "duration_s"];

/// The deprecated field for the settings of sensors.
const FIDELITY: &str = "fidelity";

/// Returns the fields of a scenario that can change during its match.
pub fn changeable() -> impl Iterator<Item = &'static str> {
    of_robots().chain(OF_THE_MATCH)
}

fn of_robots() -> impl Iterator<Item = &'static str> {
    let settings = RobotSettings::OF_MODEL.iter().chain(RobotSettings::OF_PROGRAM).copied();
    settings.filter(|setting| !FIXED.contains(setting)).chain([FIDELITY])
}

/// Returns whether the value at a path of a scenario can change during its match: a value in one of the [`changeable`] fields, or in the
/// settings of a team's robots or of a single robot.
pub fn is_changeable(path: &FieldPath) -> bool {
    let is_within = |path: &[Segment], field: &str| path.starts_with(FieldPath::from(field).segments());
    let path = match path.segments() {
        [Segment::Field(list), Segment::Index(_), own @ ..] if list == "robots" => own,
        [Segment::Field(teams), Segment::Field(_), own @ ..] if teams == "teams" => own,
        whole => return changeable().any(|field| is_within(whole, field)),
    };
    of_robots().any(|field| is_within(path, field))
}

/// Continues the match with the settings of another scenario: noise, losses, speeds, rules. What a match begins with (pitch, cycle, seed,
/// places, behaviours) stays. Settings that are the same in both scenarios also stay, even if a program has changed them since.
///
/// # Errors
/// [`ScenarioFault`] if the scenario contradicts itself, or is that of another match. The match is unchanged then.
pub fn change_settings(world: &mut World, scenario: &Scenario) -> Result<(), ScenarioFault> {
    scenario.validate()?;
    let old = world.resource::<Scenario>().clone();
    check_same_match(&old, scenario)?;
    let ids: Vec<RobotId> = world.resource::<Roster>().iter().map(|(id, _)| id).collect();
    check_same_bodies(&old, scenario, &ids)?;
    if let Some(fault) = names::unknown(world, scenario).into_iter().next() {
        return Err(fault);
    }
    scenario.settings.cameras.render.make_ready(world)?;
    if old.messages != scenario.messages {
        world.insert_resource(scenario.messages.clone());
    }
    if old.rules != scenario.rules {
        world.insert_resource(scenario.rules.clone());
    }
    let robots: Vec<(RobotId, Entity)> = world.resource::<Roster>().iter().collect();
    for (id, entity) in robots {
        let [old_robot, new_robot] = [&old, scenario].map(|scenario| scenario.robot(id));
        world.resource_scope(|world, sensors: Mut<SensorRegistry>| {
            sensors.change(&mut world.entity_mut(entity), [(&old, &old_robot), (scenario, &new_robot)]);
        });
        let after = scenario.settings_of(&new_robot);
        after.change(&old.settings_of(&old_robot), &mut world.entity_mut(entity));
    }
    if let (Some(before), Some(after)) = (&old.ball, &scenario.ball)
        && (before.rolling, before.restitution) != (after.rolling, after.restitution)
    {
        for mut ball in world.query::<&mut BallPhysics>().iter_mut(world) {
            (ball.rolling, ball.restitution) = (after.rolling, after.restitution);
        }
    }
    world.insert_resource(scenario.clone());
    Ok(())
}

/// Checks that both scenarios have the same fields that cannot change during a match.
///
/// # Errors
/// The first field that differs.
pub(super) fn check_same_match(old: &Scenario, scenario: &Scenario) -> Result<(), ScenarioFault> {
    let fixed = [
        ("cycle_s", old.cycle_s == scenario.cycle_s),
        ("field", old.field == scenario.field),
        ("teams", team_names(old) == team_names(scenario)),
        ("robots", same_robots(old, scenario)),
        ("ball", old.ball.is_some() == scenario.ball.is_some()),
        ("balls", old.more_balls.len() == scenario.more_balls.len()),
        ("posts", old.posts == scenario.posts),
        ("body", old.settings.body == scenario.settings.body),
    ];
    if let Some((field, _)) = fixed.iter().find(|(_, same)| !same) {
        let message = format!("`{field}` cannot change in the middle of a match");
        let expected = "the same as at the start; or a new match";
        return Err(ScenarioFault::new(FieldPath::from(*field), message, expected));
    }
    Ok(())
}

/// Checks that these robots have the same bodies in both scenarios.
///
/// # Errors
/// The first robot with another body.
pub(super) fn check_same_bodies(old: &Scenario, scenario: &Scenario, robots: &[RobotId]) -> Result<(), ScenarioFault> {
    for &id in robots {
        if [old, scenario].map(|scenario| scenario.body_of(&scenario.robot(id))).windows(2).any(|two| two[0] != two[1])
        {
            let message = format!("the body of {id} cannot change in the middle of a match");
            return Err(ScenarioFault::new(
                FieldPath::from("body"),
                message,
                "the same as at the start; or a new match",
            ));
        }
    }
    Ok(())
}

fn team_names(scenario: &Scenario) -> Option<[&str; 2]> {
    scenario.teams.as_ref().map(|teams| [teams.blue.as_str(), &teams.pink])
}

/// Returns whether two scenarios list the same robots with the same behaviours.
fn same_robots(one: &Scenario, other: &Scenario) -> bool {
    one.robots.len() == other.robots.len()
        && one
            .robots
            .iter()
            .all(|robot| other.robots.iter().any(|same| same.id() == robot.id() && same.behaviour == robot.behaviour))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_match_begins_with_does_not_change_and_how_it_goes_on_does() {
        let changes = |path: &str| is_changeable(&FieldPath::from(path));
        for path in [
            "messages.loss",
            "rules",
            "ball.rolling.exponential_per_s",
            "robots[1].motion",
            "teams.blue.kicks.speed_sd",
        ] {
            assert!(changes(path), "{path}");
        }
        for path in [
            "model", "realism", "realism.kicks", "league", "seed", "body.height_m", "ball", "ball.radius_m",
            "robots[1].model", "robots", "robots[0].pose", "teams.blue", "teams.blue.model", "teams.pink.team",
            "robots[0].rules", "localisation",
        ] {
            assert!(!changes(path), "{path}");
        }
    }
}
