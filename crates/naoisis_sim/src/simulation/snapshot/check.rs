//! Checks a saved match before any of it is put into the world. A file may be damaged or written by hand, so it is checked like a scenario.
//!
//! Settings must be in the ranges of scenarios. Numbers must be finite, and counts must have room for counting on. Everything that a match
//! needs must be there, and nothing twice. Robots and ball must be those of the scenario and must not overlap anything. The contents of a
//! user's own types are not checked.

use bevy::prelude::*;
use bevy::reflect::serde::TypedReflectSerializer;
use bevy::reflect::{TypePath, TypeRegistry};
use core::any::TypeId;

use super::{EntityState, Snapshot, SnapshotError, is_of_the_program};
use crate::scenario::{BallSpec, BehaviourSpec, Numbers, RobotSpec, Scenario, ScenarioFault};
use crate::simulation::invariants::{BallState, RobotState, broken_invariants};
use crate::simulation::spawn::MatchEntity;
use naoisis_core::ball::flight::BallFlight;
use naoisis_core::ball::{Ball, BallPath, BallPhysics, BallVelocity, ExtraBall};
use naoisis_core::behaviour::script::Script;
use naoisis_core::communication::{MessageSettings, MessageStatistics, MessagesInFlight};
use naoisis_core::cycle::CycleClock;
use naoisis_core::events::Contacts;
use naoisis_core::game::{Game, Interventions, Penalty, Rules};
use naoisis_core::geometry::Pose;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::pitch::{Pitch, Post};
use naoisis_core::random::RandomStreams;
use naoisis_core::referee::RefereeMemory;
use naoisis_core::robot::body::{Body, BodyBox};
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::kick::{KickCommand, KickPhase};
use naoisis_core::robot::motion::{ExecutedStep, MotionSettings, WalkCommand};
use naoisis_core::robot::posture::Posture;
use naoisis_core::robot::{PreviousPose, Velocity};
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::sensing::camera::CameraImages;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sensing::sensing::latency::LatencyQueues;

/// Limit of all sizes, distances and speeds of a match, m, s, or radians. Their squares can still be added up.
const LARGEST_NUMBER: f32 = 1e9;
/// Squares of what is measured can be added up, too; but a pixel of something far beside the image has no other limit.
const LARGEST_MEASURED: f32 = 1e18;
/// Limit of the distance between a part of a body and the robot's centre, m.
const LARGEST_BODY_M: f32 = 3.0;
/// Limit of the size of a post, m: half a goal on a pitch for people.
const THICKEST_POST_M: f32 = 50.0;

/// Checks a snapshot.
///
/// # Errors
/// The first fault, and its place.
pub(super) fn check(snapshot: &Snapshot, registry: &TypeRegistry) -> Result<(), SnapshotError> {
    let resources = Values { what: "the match", values: &snapshot.resources };
    resources.check_numbers(registry)?;
    let settings = settings_of_match(&resources)?;
    resources.check_settings(&settings)?;
    let mut seen = Seen::default();
    for entity in &snapshot.entities {
        check_entity(entity, &settings, registry, &mut seen)?;
    }
    let scenario = resources.need::<Scenario>()?;
    seen.everybody_is_there(scenario)?;
    seen.nobody_is_in_anything()
}

/// Returns the present settings of the match that do not depend on robots.
fn settings_of_match(resources: &Values) -> Result<Scenario, SnapshotError> {
    let scenario = resources.need::<Scenario>()?;
    let clock = resources.need::<CycleClock>()?;
    resources.need::<Game>()?;
    resources.need::<RefereeMemory>()?;
    resources.need::<Interventions>()?;
    resources.need::<Contacts>()?;
    resources.need::<MessagesInFlight>()?;
    resources.need::<MessageStatistics>()?;
    scenario.validate().map_err(|fault| resources.fault_in::<Scenario>(&fault))?;
    if clock.period_s != scenario.cycle_s {
        let message = format!("`period_s` is {}, and the scenario's `cycle_s` {}", clock.period_s, scenario.cycle_s);
        return Err(resources.wrong::<CycleClock>(&message));
    }
    Ok(Scenario {
        field: resources.need::<Pitch>()?.clone(),
        rules: resources.need::<Rules>()?.clone(),
        messages: resources.need::<MessageSettings>()?.clone(),
        robots: Vec::new(),
        teams: None,
        posts: Vec::new(),
        ball: None,
        interventions: Vec::new(),
        ..scenario.clone()
    })
}

fn check_entity(
    entity: &EntityState,
    settings: &Scenario,
    registry: &TypeRegistry,
    seen: &mut Seen,
) -> Result<(), SnapshotError> {
    let parts = Values { what: "an entity", values: &entity.components };
    parts.need::<MatchEntity>()?;
    let is_ball = parts.has::<Ball>() || parts.has::<ExtraBall>();
    match (parts.get::<RobotId>(), is_ball, parts.get::<Post>()) {
        (Some(id), false, None) => check_robot(*id, &parts, settings, registry, seen),
        (None, true, None) => check_ball(&parts, settings, registry, seen),
        (None, false, Some(post)) => check_post(*post, &parts, registry, seen),
        // Other entities belong to the program of the user.
        (None, false, None) if parts.are_of_user() => parts.check_numbers(registry),
        _ => Err(parts.impossible("it is neither a robot nor a ball nor a post")),
    }
}

fn check_robot(
    id: RobotId,
    parts: &Values,
    settings: &Scenario,
    registry: &TypeRegistry,
    seen: &mut Seen,
) -> Result<(), SnapshotError> {
    let name = id.to_string();
    let parts = &Values { what: &name, ..*parts };
    parts.check_numbers(registry)?;
    if id.number == 0 || seen.ids.contains(&id) {
        return Err(parts.impossible(if id.number == 0 { "jersey numbers begin at 1" } else { "it is there twice" }));
    }
    seen.ids.push(id);
    parts.need::<Body>()?;
    parts.need::<MotionSettings>()?;
    let own = Scenario {
        settings: settings.settings.with_components(parts.values),
        robots: vec![RobotSpec {
            team: id.team,
            number: id.number,
            behaviour: parts
                .get::<Script>()
                .map_or_else(BehaviourSpec::default, |Script(entries)| BehaviourSpec::Script(entries.clone())),
            ..RobotSpec::default()
        }],
        ..settings.clone()
    };
    parts.check_settings(&own)?;
    let bounds = *parts.need::<Body>()?;
    let is_sound = |part: BodyBox| {
        let [lengths, heights] =
            [part.x_m, part.z_m].map(|[least, most]| least < most && least.abs().max(most.abs()) <= LARGEST_BODY_M);
        lengths && heights && part.half_width_m > 0.0 && part.half_width_m <= LARGEST_BODY_M
    };
    if !(is_sound(bounds.torso) && is_sound(bounds.base)) {
        return Err(parts.wrong::<Body>("this is no body of a robot"));
    }
    let are_whole = |images: &CameraImages| images.iter().all(|(_, image)| is_whole(image));
    const NOT_WHOLE: &str = "an image has more or fewer pixels than its width and height say";
    if !parts.get::<CameraImages>().is_none_or(are_whole) {
        return Err(parts.wrong::<CameraImages>(NOT_WHOLE));
    }
    if !parts.get::<LatencyQueues>().is_none_or(|late| late.images().all(are_whole)) {
        return Err(parts.wrong::<LatencyQueues>(NOT_WHOLE));
    }
    parts.need::<PreviousPose>()?;
    parts.need::<HeadAngles>()?;
    parts.need::<WalkCommand>()?;
    parts.need::<ExecutedStep>()?;
    parts.need::<KickCommand>()?;
    parts.need::<KickPhase>()?;
    parts.need::<Posture>()?;
    parts.need::<RandomStreams>()?;
    let (pose, velocity) = (*parts.need::<Pose>()?, *parts.need::<Velocity>()?);
    if !parts.need::<Penalty>()?.is_off_pitch() {
        seen.robots.push(RobotState { id, pose, previous: pose, velocity, torso: bounds.torso, base: bounds.base });
    }
    Ok(())
}

fn is_whole(image: &Image) -> bool {
    let pixels = image.width as usize * image.height as usize;
    let of_layer = |length: usize| length == 0 || length == pixels;
    image.rgb.len() == 3 * pixels && of_layer(image.labels.len()) && of_layer(image.depth_m.len())
}

fn check_ball(
    parts: &Values,
    settings: &Scenario,
    registry: &TypeRegistry,
    seen: &mut Seen,
) -> Result<(), SnapshotError> {
    let parts = &Values { what: "the ball", ..*parts };
    parts.check_numbers(registry)?;
    let number = parts.get::<ExtraBall>().map_or(0, |ExtraBall(number)| *number);
    if seen.ball_numbers.contains(&number) {
        return Err(parts.impossible("it is there twice"));
    }
    seen.ball_numbers.push(number);
    let physics = *parts.need::<BallPhysics>()?;
    let ball = Some(BallSpec::default().with_physics(physics));
    parts.check_settings(&Scenario { ball, ..settings.clone() })?;
    parts.need::<PreviousPose>()?;
    parts.need::<BallPath>()?;
    let flight = *parts.need::<BallFlight>()?;
    if flight.height_m < 0.0 {
        return Err(parts.wrong::<BallFlight>("it is below the ground"));
    }
    let (position, velocity) = (parts.need::<Pose>()?.position, parts.need::<BallVelocity>()?.0);
    seen.balls.push(BallState {
        position,
        previous: position,
        velocity,
        radius: physics.radius_m,
        is_on_ground: !flight.is_airborne(),
    });
    Ok(())
}

fn check_post(post: Post, parts: &Values, registry: &TypeRegistry, seen: &mut Seen) -> Result<(), SnapshotError> {
    let parts = &Values { what: "a post", ..*parts };
    parts.check_numbers(registry)?;
    if !(post.radius > 0.0 && post.radius <= THICKEST_POST_M && post.height > 0.0) {
        return Err(parts.wrong::<Post>("this is no post"));
    }
    seen.posts.push((parts.need::<Pose>()?.position, post.radius));
    Ok(())
}

/// The robots, ball and posts that were checked so far.
#[derive(Default)]
struct Seen {
    ids: Vec<RobotId>,
    robots: Vec<RobotState>,
    posts: Vec<(Vec2, f32)>,
    ball_numbers: Vec<u8>,
    balls: Vec<BallState>,
}

impl Seen {
    /// Checks that robots and ball are those of the scenario.
    fn everybody_is_there(&self, scenario: &Scenario) -> Result<(), SnapshotError> {
        let wrong = |message: String| Err(impossible("the match", message));
        let expected: Vec<RobotId> = match scenario.teams {
            // The size of the teams at the line-up is not known any more, since rules may change in a match. Both had the same size.
            Some(_) => {
                let largest = self.ids.iter().map(|id| id.number).max().unwrap_or(1);
                let of_team = |team| (1..=largest).map(move |number| RobotId::new(team, number));
                Team::BOTH.into_iter().flat_map(of_team).collect()
            }
            None => scenario.robots.iter().map(RobotSpec::id).collect(),
        };
        if let Some(id) = expected.iter().find(|id| !self.ids.contains(id)) {
            return wrong(format!("it has no {id}, and its scenario has one"));
        }
        if let Some(id) = self.ids.iter().find(|id| !expected.contains(id)) {
            return wrong(format!("it has a {id}, and its scenario has none"));
        }
        let mut numbers = self.ball_numbers.clone();
        numbers.sort_unstable();
        match (numbers.len(), scenario.balls().count()) {
            (0, 1) => wrong("it has no ball, and its scenario has one".to_owned()),
            (1, 0) => wrong("it has a ball, and its scenario has none".to_owned()),
            (there, expected) if there != expected || !numbers.into_iter().eq((0..).take(expected)) => {
                wrong(format!("it has {there} balls, and its scenario has {expected}"))
            }
            _ => Ok(()),
        }
    }

    fn nobody_is_in_anything(&self) -> Result<(), SnapshotError> {
        let mut first = None;
        broken_invariants(&self.robots, &self.posts, &self.balls, |message| {
            first.get_or_insert(message);
        });
        first.map_or(Ok(()), |message| Err(impossible("the match", message)))
    }
}

fn impossible(what: &str, message: String) -> SnapshotError {
    SnapshotError::Impossible { what: what.to_owned(), message }
}

/// The components of an entity, or the resources of the match.
struct Values<'a> {
    /// The owner of the values, in words.
    what: &'a str,
    values: &'a [Box<dyn Reflect>],
}

impl<'a> Values<'a> {
    fn get<T: Reflect>(&self) -> Option<&'a T> {
        self.values.iter().find_map(|value| value.as_any().downcast_ref())
    }

    fn has<T: Reflect>(&self) -> bool {
        self.get::<T>().is_some()
    }

    fn need<T: Reflect + TypePath>(&self) -> Result<&'a T, SnapshotError> {
        self.get().ok_or_else(|| self.impossible(&format!("it has no `{}`", T::short_type_path())))
    }

    fn impossible(&self, message: &str) -> SnapshotError {
        impossible(self.what, message.to_owned())
    }

    /// Returns the error for a fault of one of the values.
    fn wrong<T: TypePath>(&self, message: &str) -> SnapshotError {
        impossible(&format!("the {} of {}", T::short_type_path(), self.what), message.to_owned())
    }

    fn fault_in<T: TypePath>(&self, fault: &ScenarioFault) -> SnapshotError {
        self.wrong::<T>(&fault.to_string())
    }

    /// Returns whether any of the values has a user's own type.
    fn are_of_user(&self) -> bool {
        self.values.iter().any(|value| !is_of_the_program(value.reflect_type_path()))
    }

    /// Checks that settings are in the ranges of scenarios.
    fn check_settings(&self, settings: &Scenario) -> Result<(), SnapshotError> {
        let fault = settings.faults_of_settings().into_iter().next();
        fault.map_or(Ok(()), |fault| Err(impossible(&format!("the settings of {}", self.what), fault.to_string())))
    }

    /// Checks that the numbers of the simulation's own types are finite, and counts not near their limit. Beliefs may be arbitrarily wrong.
    fn check_numbers(&self, registry: &TypeRegistry) -> Result<(), SnapshotError> {
        for value in self.values.iter().filter(|value| is_of_the_program(value.reflect_type_path())) {
            let type_info = value.reflect_type_info();
            // A scenario's numbers are those of its fields, and a script's may be any: what is too much is refused when
            // it is commanded. A seed is all bits.
            let unchecked = [TypeId::of::<Scenario>(), TypeId::of::<Script>(), TypeId::of::<RandomStreams>()];
            if unchecked.contains(&type_info.type_id()) {
                continue;
            }
            let limits = match Knowledge::of_type_info(type_info) {
                _ if type_info.type_id() == TypeId::of::<CycleClock>() => {
                    Numbers { counts_go_on: true, ..Numbers::FINITE }
                }
                Some(Knowledge::Truth) => Numbers { largest: LARGEST_NUMBER, counts_go_on: true },
                Some(Knowledge::Sensor) => Numbers { largest: LARGEST_MEASURED, counts_go_on: true },
                Some(Knowledge::Command | Knowledge::Belief) => Numbers { counts_go_on: true, ..Numbers::FINITE },
                Some(Knowledge::Public) | None => Numbers::FINITE,
            };
            let serializer = TypedReflectSerializer::new(value.as_partial_reflect(), registry);
            limits.check(&serializer).map_err(|fault| {
                let name = type_info.type_path_table().short_path();
                let place =
                    if fault.path.to_string().is_empty() { String::new() } else { format!("`{}`: ", fault.path) };
                impossible(&format!("the {name} of {}", self.what), format!("{place}{}", fault.message))
            })?;
        }
        Ok(())
    }
}
