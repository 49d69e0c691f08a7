//! The settings of a running match, changed while it runs.

use bevy::prelude::*;

use super::names;
use super::sensors::SensorRegistry;
use crate::scenario::{FieldPath, RobotSpec, Scenario, ScenarioFault, Segment};
use naoisis_core::ball::BallPhysics;
use naoisis_core::communication::MessageLimits;
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::falls::FallModel;
use naoisis_core::robot::head::HeadLimits;
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::robot::latency::Latency;
use naoisis_core::robot::motion::MotionLimits;
use naoisis_core::team::RobotId;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::fidelity::SensorFidelity;
use naoisis_sensing::sensing::odometry::OdometrySettings;
use naoisis_sensing::sensing::sonar::SonarSettings;
use naoisis_sensing::sensing::vision::VisionSettings;

/// What of a scenario can change in the middle of its match.
pub const CHANGEABLE: [&str; 16] = [
    "messages",
    "rules",
    "motion",
    "kicks",
    "falls",
    "head",
    "sonar",
    "cameras",
    "vision",
    "odometry",
    "latency",
    "fidelity",
    "sensors",
    "ball.rolling",
    "ball.restitution",
    "duration_s",
];

/// Whether what is at a path of a scenario can change in the middle of its match: one of the [`CHANGEABLE`], of all robots, of a
/// team's or of one.
pub fn is_changeable(path: &FieldPath) -> bool {
    let is_within = |path: &[Segment], field: &str| path.starts_with(FieldPath::from(field).segments());
    let path = match path.segments() {
        [Segment::Field(list), Segment::Index(_), own @ ..] if list == "robots" => own,
        [Segment::Field(teams), Segment::Field(_), own @ ..] if teams == "teams" => own,
        whole => return CHANGEABLE.iter().any(|field| is_within(whole, field)),
    };
    let of_the_match = ["rules", "ball.rolling", "ball.restitution", "duration_s"];
    CHANGEABLE.iter().any(|field| !of_the_match.contains(field) && is_within(path, field))
}

/// The settings of one robot: its own, and the scenario's for the rest.
#[derive(Bundle, Clone, PartialEq, Debug)]
pub(super) struct RobotSettings {
    pub body: Body,
    pub motion: MotionLimits,
    pub head: HeadLimits,
    pub kicks: KickSettings,
    pub balance: FallModel,
    pub sonar: SonarSettings,
    pub cameras: CameraSettings,
    pub vision: VisionSettings,
    pub odometry: OdometrySettings,
    pub latency: Latency,
    pub messages: MessageLimits,
}

impl RobotSettings {
    pub fn of(scenario: &Scenario, robot: &RobotSpec) -> Self {
        let fidelity = scenario.fidelity_of(robot);
        Self {
            body: scenario.body_of(robot),
            motion: robot.motion.unwrap_or(scenario.motion),
            head: robot.head_limits.unwrap_or(scenario.head),
            kicks: robot.kicks.unwrap_or(scenario.kicks),
            balance: robot.falls.unwrap_or(scenario.falls),
            sonar: robot.sonar.unwrap_or(scenario.sonar).with_fidelity(fidelity.sonar),
            cameras: robot.cameras.unwrap_or(scenario.cameras),
            vision: robot.vision.as_ref().unwrap_or(&scenario.vision).clone().with_fidelity(fidelity.vision),
            odometry: robot.odometry.unwrap_or(scenario.odometry).with_fidelity(fidelity.odometry),
            latency: robot.latency.unwrap_or(scenario.latency),
            messages: robot.messages.unwrap_or(scenario.messages.robots),
        }
    }
}

/// Goes on with the settings of another scenario: noise, losses, speeds, rules. What a match begins with (pitch, cycle,
/// seed, places, behaviours) stays; so do settings that the scenarios agree on, even if a program has changed them since.
///
/// # Errors
/// [`ScenarioFault`] when the scenario contradicts itself, or is that of another match. The match is then as it was.
pub fn change_settings(world: &mut World, scenario: &Scenario) -> Result<(), ScenarioFault> {
    scenario.validate()?;
    let old = world.resource::<Scenario>().clone();
    check_same_match(&old, scenario)?;
    let ids: Vec<RobotId> = world.resource::<Roster>().iter().map(|(id, _)| id).collect();
    check_same_bodies(&old, scenario, &ids)?;
    if let Some(fault) = names::unknown(world, scenario).into_iter().next() {
        return Err(fault);
    }
    scenario.cameras.render.make_ready(world)?;
    if old.messages != scenario.messages {
        world.insert_resource(scenario.messages.clone());
    }
    if old.rules != scenario.rules {
        world.insert_resource(scenario.rules.clone());
    }
    let robots: Vec<(RobotId, Entity)> = world.resource::<Roster>().iter().collect();
    for (id, entity) in robots {
        let [old_robot, new_robot] = [&old, scenario].map(|scenario| scenario.robot(id));
        let (before, after) = (RobotSettings::of(&old, &old_robot), RobotSettings::of(scenario, &new_robot));
        world.resource_scope(|world, sensors: Mut<SensorRegistry>| {
            sensors.change(&mut world.entity_mut(entity), [(&old, &old_robot), (scenario, &new_robot)]);
        });
        let mut robot = world.entity_mut(entity);
        change(&mut robot, before.motion, after.motion);
        change(&mut robot, before.head, after.head);
        change(&mut robot, before.kicks, after.kicks);
        change(&mut robot, before.balance, after.balance);
        change(&mut robot, before.sonar, after.sonar);
        change(&mut robot, before.cameras, after.cameras);
        change(&mut robot, before.vision, after.vision);
        change(&mut robot, before.odometry, after.odometry);
        change(&mut robot, before.latency, after.latency);
        change(&mut robot, before.messages, after.messages);
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

/// That what a match begins with is the same in both.
///
/// # Errors
/// What is not.
pub(super) fn check_same_match(old: &Scenario, scenario: &Scenario) -> Result<(), ScenarioFault> {
    let fixed = [
        ("cycle_s", old.cycle_s == scenario.cycle_s),
        ("field", old.field == scenario.field),
        ("teams", team_names(old) == team_names(scenario)),
        ("robots", same_robots(old, scenario)),
        ("ball", old.ball.is_some() == scenario.ball.is_some()),
        ("posts", old.posts == scenario.posts),
        ("body", old.body == scenario.body),
    ];
    if let Some((field, _)) = fixed.iter().find(|(_, same)| !same) {
        let message = format!("`{field}` cannot change in the middle of a match");
        let expected = "the same as at the start; or a new match";
        return Err(ScenarioFault::new(FieldPath::from(*field), message, expected));
    }
    Ok(())
}

/// That these robots have the same bodies in both.
///
/// # Errors
/// Who has not.
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

fn change<C: Component + PartialEq>(robot: &mut EntityWorldMut, before: C, after: C) {
    if before != after {
        robot.insert(after);
    }
}

fn team_names(scenario: &Scenario) -> Option<[&str; 2]> {
    scenario.teams.as_ref().map(|teams| [teams.blue.as_str(), &teams.pink])
}

/// Whether two scenarios list the same robots with the same behaviours.
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
            "model",
            "realism",
            "realism.kicks",
            "league",
            "seed",
            "body.height_m",
            "ball",
            "ball.radius_m",
            "robots[1].model",
            "robots",
            "robots[0].pose",
            "teams.blue",
            "teams.blue.model",
            "teams.pink.team",
            "robots[0].rules",
            "localisation",
        ] {
            assert!(!changes(path), "{path}");
        }
    }
}
