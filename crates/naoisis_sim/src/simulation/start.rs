//! Starts a match: a new one, or one that continues a saved match, depending on its scenario. A continued match keeps its state, including
//! beliefs and actions under way, but has the random numbers of the scenario's seed.
//!
//! A robot with a new behaviour continues where it is and as it moves, but without its old beliefs and memory.

use bevy::prelude::*;
use core::any::TypeId;
use core::error::Error;

use super::names;
use super::rules::RuleRegistry;
use super::sensors::SensorRegistry;
use super::settings::{change_settings, check_same_bodies, check_same_match};
use super::snapshot::{Snapshot, SnapshotError};
use super::spawn::{self, give_behaviour, robots_of};
use super::triggers::MatchStarted;
use crate::scenario::{FieldPath, RobotSpec, SavedMatch, Scenario, ScenarioFault};
use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::behaviour::drawings::Drawings;
use naoisis_core::communication::Outbox;
use naoisis_core::cycle::CycleClock;
use naoisis_core::events::Contacts;
use naoisis_core::events::StampedEvent;
use naoisis_core::geometry::{Pose, wrap_angle};
use naoisis_core::referee::RefereeMemory;
use naoisis_core::robot::head::{HeadAngles, HeadCommand};
use naoisis_core::robot::kick::KickCommand;
use naoisis_core::robot::motion::WalkCommand;
use naoisis_core::robot::posture::PostureCommand;
use naoisis_core::robot::request::RequestCommand;
use naoisis_core::robot::{Roster, Velocity};
use naoisis_core::team::{RobotId, Team};

/// Differences up to this count as equal, m or radians, because values may have been written to a file.
const SAME: f32 = 1e-4;

/// Replaces the match in the world by that of the scenario: a new one, or the saved one that it continues ([`from`](Scenario::from)).
///
/// # Errors
/// [`ScenarioFault`] if the scenario contradicts itself, names a behaviour or team that is not registered, needs camera images that cannot
/// be rendered here, or continues something that is no saved match, or if a plugin of the [`NaoisisPlugins`](super::NaoisisPlugins) is
/// missing. The world is unchanged then.
pub fn start(world: &mut World, scenario: &Scenario) -> Result<(), ScenarioFault> {
    check_plugins(world)?;
    match &scenario.from {
        Some(saved) => go_on(world, scenario, saved),
        None => spawn::start(world, scenario),
    }?;
    world.trigger(MatchStarted);
    Ok(())
}

/// Checks that the app has the plugins that every match needs.
///
/// # Errors
/// [`ScenarioFault`] that names the first missing plugin.
fn check_plugins(world: &World) -> Result<(), ScenarioFault> {
    // Plugins without a resource of their own are recognised by a type that they register.
    let types = world.get_resource::<AppTypeRegistry>();
    let has_type = |id: TypeId| types.is_some_and(|types| types.read().contains(id));
    let needed = [
        ("CyclePlugin", world.contains_resource::<CycleClock>()),
        ("EventsPlugin", world.contains_resource::<Messages<StampedEvent>>()),
        ("MatchPlugin", world.contains_resource::<SensorRegistry>()),
        ("CustomRulesPlugin", world.contains_resource::<RuleRegistry>()),
        ("RobotPlugin", has_type(TypeId::of::<Velocity>())),
        ("CollisionPlugin", world.contains_resource::<Contacts>()),
        ("BehaviourPlugin", world.contains_resource::<BehaviourRegistry>()),
        ("RefereePlugin", world.contains_resource::<RefereeMemory>()),
    ];
    let is_missing = |(_, is_there): &&(&str, bool)| !is_there;
    let missing: Vec<&str> = needed.iter().filter(is_missing).map(|(plugin, _)| *plugin).collect();
    let Some(first) = missing.first() else { return Ok(()) };
    let what = if missing.len() == needed.len() { "`NaoisisPlugins`".to_owned() } else { format!("`{first}`") };
    Err(ScenarioFault::new(
        FieldPath::default(),
        format!("the app has no {what}"),
        "`app.add_plugins(NaoisisPlugins)` before the match starts",
    ))
}

/// Replaces the match in the world by the saved one.
///
/// # Errors
/// [`ScenarioFault`] if it is no saved match, or if the scenario changes something that cannot change during a match. The world is
/// unchanged then.
fn go_on(world: &mut World, scenario: &Scenario, saved: &SavedMatch) -> Result<(), ScenarioFault> {
    let of_saved = |error: &dyn Error| {
        ScenarioFault::new(FieldPath::from("from"), format!("the saved match: {error}"), "a match as it was saved")
    };
    scenario.validate()?;
    if let Some(fault) = names::unknown(world, scenario).into_iter().next() {
        return Err(fault);
    }
    let mut before = saved.scenario().map_err(|error| of_saved(&error))?;
    if before.teams.is_some() && scenario.teams.is_none() {
        // The scenario in the header of a trace lists the robots of teams.
        before = Scenario { robots: robots_of(world, &before)?, teams: None, ..before };
    }
    check_beginning(&before, scenario)?;
    let begin_afresh = changed_behaviours(&before, scenario);
    take_over_behaviours(&mut before, scenario);
    check_same_match(&before, scenario)?;
    let robots = robots_of(world, scenario)?;
    check_same_bodies(&before, scenario, &robots.iter().map(RobotSpec::id).collect::<Vec<_>>())?;
    let snapshot = saved.bytes().and_then(|bytes| Snapshot::from_bytes(&bytes, world));
    let mut snapshot = snapshot.map_err(|error| of_saved(&error))?;
    scenario.settings.cameras.render.make_ready(world)?;
    snapshot.forget_thoughts(&begin_afresh);
    snapshot.restore_with_chance(world, scenario.seed).map_err(|error| match error {
        SnapshotError::Cameras(fault) => fault,
        error => of_saved(&error),
    })?;
    for robot in robots.iter().filter(|robot| begin_afresh.contains(&robot.id())) {
        begin_behaviour(world, scenario, robot);
    }
    world.insert_resource(before);
    change_settings(world, scenario)
}

/// Checks that the scenario does not change the beginning of the match.
fn check_beginning(before: &Scenario, scenario: &Scenario) -> Result<(), ScenarioFault> {
    let stands_where_it_did = |robot: &RobotSpec| {
        scenario.robots.iter().any(|now| {
            let is_near = |one: f32, other: f32| (one - other).abs() < SAME;
            let (pose, other) = (robot.pose, now.pose);
            now.id() == robot.id()
                && now.model == robot.model
                && is_near(pose.position.x, other.position.x)
                && is_near(pose.position.y, other.position.y)
                && is_near(wrap_angle(pose.heading - other.heading), 0.0)
        })
    };
    let ball = |scenario: &Scenario| scenario.ball.map(|ball| (ball.position_m, ball.velocity_mps, ball.radius_m));
    let same = [
        ("league", before.league == scenario.league),
        ("model", before.model == scenario.model),
        ("realism", before.realism == scenario.realism),
        ("localisation", before.settings.localisation == scenario.settings.localisation),
        ("interventions", before.interventions == scenario.interventions),
        ("robots", before.robots.iter().all(stands_where_it_did)),
        ("ball", ball(before) == ball(scenario)),
        ("balls", before.more_balls == scenario.more_balls),
    ];
    match same.iter().find(|(_, same)| !same) {
        Some((field, _)) => {
            let message = format!("`{field}` is that of the saved match, which goes on as it stands");
            let expected = "it left out, or as it was; settings and behaviours may change";
            Err(ScenarioFault::new(FieldPath::from(*field), message, expected))
        }
        None => Ok(()),
    }
}

/// Returns the robots with a new behaviour or team.
fn changed_behaviours(before: &Scenario, scenario: &Scenario) -> Vec<RobotId> {
    let mut otherwise = Vec::new();
    if let (Some(before), Some(now)) = (&before.teams, &scenario.teams) {
        for team in Team::BOTH.into_iter().filter(|team| before.name(*team) != now.name(*team)) {
            otherwise.extend((1..=u8::MAX).map(|number| RobotId::new(team, number)));
        }
    }
    for robot in &before.robots {
        let now = scenario.robots.iter().find(|now| now.id() == robot.id());
        if now.is_some_and(|now| now.behaviour != robot.behaviour) {
            otherwise.push(robot.id());
        }
    }
    otherwise
}

/// Changes the behaviours and teams of `before` to those of `scenario`.
fn take_over_behaviours(before: &mut Scenario, scenario: &Scenario) {
    if let (Some(before), Some(now)) = (&mut before.teams, &scenario.teams) {
        (before.blue, before.pink) = (now.blue.clone(), now.pink.clone());
    }
    for robot in &mut before.robots {
        if let Some(now) = scenario.robots.iter().find(|now| now.id() == robot.id()) {
            robot.behaviour = now.behaviour.clone();
        }
    }
}

/// Starts the scenario's behaviour of a robot, at the robot's present pose.
fn begin_behaviour(world: &mut World, scenario: &Scenario, robot: &RobotSpec) {
    let Some(entity) = world.resource::<Roster>().get(robot.id()) else { return };
    let mut entity = world.entity_mut(entity);
    let pose = entity.get::<Pose>().copied().unwrap_or(robot.pose);
    let HeadAngles { yaw, pitch } = entity.get::<HeadAngles>().copied().unwrap_or_default();
    entity.insert((
        WalkCommand::default(),
        HeadCommand { yaw, pitch },
        KickCommand::default(),
        PostureCommand::default(),
        RequestCommand::default(),
        Outbox::default(),
        Drawings::default(),
    ));
    give_behaviour(&mut entity, scenario, &RobotSpec { pose, ..robot.clone() });
}
