//! Snapshots: the whole state of a match, for continuing exactly the same match later, or for branching off.
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//! use naoisis::simulation::Snapshot;
//!
//! let mut app = App::new();
//! app.add_plugins(NaoisisPlugins);
//! app.start_match(&Scenario::named("match3v3")?)?.run_cycles(100);
//! let snapshot = Snapshot::take(app.world_mut())?;
//! let expected = app.run_cycles(100).ball();
//!
//! snapshot.restore(app.world_mut())?;
//! assert_eq!(app.cycle(), 100);
//! assert_eq!(app.run_cycles(100).ball(), expected);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! A snapshot has all components and resources of the simulation, including random streams, and those of the user that are registered for
//! reflection (`#[derive(Reflect)]`, `#[reflect(Component)]`, `app.register_type`). State that a behaviour keeps in a `Local` is not
//! accessible and stays as it is.
//!
//! The file format is MessagePack with the names of types: exact, small, and readable by other programs. The simulation's own types have
//! names such as `naoisis::RobotId` without their module; those of users have their whole paths.

use bevy::prelude::*;
use bevy::reflect::{ReflectFromReflect, TypeRegistration, TypeRegistry};
use core::any::TypeId;
use std::io;
use std::path::PathBuf;

mod check;
mod file;

use super::spawn::{MatchEntity, despawn_match};
pub use crate::scenario::saved_match::EXTENSION;
use crate::scenario::{SavedMatchError, Scenario, ScenarioFault};
use naoisis_core::behaviour::script::Script;
use naoisis_core::behaviour::{BehaviourRegistry, Policy, Program};
use naoisis_core::events::StampedEvent;
use naoisis_core::geometry::Pose;
use naoisis_core::knowledge::{Knowledge, is_of_naoisis};
use naoisis_core::random::{BehaviourRandom, RandomStreams};
use naoisis_core::referee;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;

/// The state of a match at the end of a cycle.
pub struct Snapshot {
    resources: Vec<Box<dyn Reflect>>,
    entities: Vec<EntityState>,
}

/// The state of a robot, the ball or a post.
struct EntityState {
    /// The behaviours that control the robot.
    behaviours: Vec<String>,
    components: Vec<Box<dyn Reflect>>,
}

/// Why a snapshot cannot be taken, written, read or restored.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// A user's component cannot be saved.
    #[error(
        "the component `{component}` cannot be saved: derive `Reflect` with `#[reflect(Component)]` for it, and \
         register it with `app.register_type`"
    )]
    NotRegistered {
        /// The component's type.
        component: String,
    },
    /// A value cannot be copied.
    #[error("a `{0}` cannot be copied: its reflection does not know all of its fields")]
    NotCopied(&'static str),
    /// The state belongs to a behaviour that is not registered here.
    #[error("there is no behaviour `{0}`; register it before the snapshot is restored")]
    NoBehaviour(String),
    /// The state cannot be that of a match.
    #[error("{what}: {message}; expected a match as it was saved")]
    Impossible {
        /// The robot, ball or resource whose state it is.
        what: String,
        /// What is wrong with it.
        message: String,
    },
    /// The match has camera images that cannot be rendered here.
    #[error(transparent)]
    Cameras(#[from] ScenarioFault),
    /// The file cannot be read or written.
    #[error("{path}: {error}")]
    Io {
        /// The file that was to be read or written.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// The file is no snapshot, or has types that are not registered here.
    #[error("{path}: {error}; expected a snapshot, as `naoisis run --save` writes it")]
    NotASnapshot {
        /// The file that was to be read.
        path: PathBuf,
        /// What is wrong with it.
        error: SavedMatchError,
    },
    /// The bytes are no snapshot, or have types that are not registered here.
    #[error(transparent)]
    Bytes(#[from] SavedMatchError),
    /// A value cannot be encoded.
    #[error("{0}")]
    NotEncoded(String),
}

naoisis_core::debug_as_displayed!(SnapshotError);

impl Snapshot {
    /// Takes a snapshot of the match in `world`, between two cycles.
    ///
    /// # Errors
    /// If a user's component cannot be saved.
    pub fn take(world: &mut World) -> Result<Snapshot, SnapshotError> {
        let mut match_entities = world.query_filtered::<Entity, With<MatchEntity>>();
        let mut match_entities: Vec<Entity> = match_entities.iter(world).collect();
        // Sort them, so that the order does not depend on the world's storage.
        match_entities.sort_by_cached_key(|&entity| {
            let place = world.get::<Pose>(entity).copied().unwrap_or_default().position.to_array();
            (world.get::<RobotId>(entity).copied(), place.map(f32::to_bits))
        });
        let registry = world.resource::<AppTypeRegistry>().clone();
        let registry = registry.read();
        let mut resources = Vec::new();
        for (id, entity) in world.resource_entities().iter() {
            let registration = registration_of(id, world, &registry);
            let Some(registration) = registration.filter(|registration| belongs_to_match(registration)) else {
                continue;
            };
            let Some(component) = registration.data::<ReflectComponent>() else { continue };
            if let Some(value) = component.reflect(world.entity(entity)) {
                resources.push(copy(value, registration)?);
            }
        }
        resources.sort_by_key(|resource| resource.reflect_type_path().to_owned());
        let entities = match_entities.into_iter().map(|entity| entity_state(entity, world, &registry));
        Ok(Snapshot { resources, entities: entities.collect::<Result<_, _>>()? })
    }

    /// Puts the match into `world`, and removes an earlier one.
    ///
    /// # Errors
    /// If the state cannot be that of a match, or one of its behaviours is not registered. The world is unchanged then.
    pub fn restore(&self, world: &mut World) -> Result<(), SnapshotError> {
        let behaviours = world.resource::<BehaviourRegistry>();
        for name in self.entities.iter().flat_map(|entity| &entity.behaviours) {
            if behaviours.marker_of(name).is_none() {
                return Err(SnapshotError::NoBehaviour(name.clone()));
            }
        }
        let registry = world.resource::<AppTypeRegistry>().clone();
        let registry = registry.read();
        check::check(self, &registry)?;
        let scenario = self.resources.iter().find_map(|resource| resource.as_any().downcast_ref::<Scenario>());
        if let Some(scenario) = scenario {
            scenario.settings.cameras.render.make_ready(world).map_err(ScenarioFault::from)?;
        }
        despawn_match(world);
        // Events of the earlier match do not belong to this one.
        if let Some(mut messages) = world.get_resource_mut::<Messages<StampedEvent>>() {
            messages.clear();
        }
        for resource in &self.resources {
            let Some(component) = reflected(&**resource, &registry) else { continue };
            let id = component.register_component(world);
            let entity = world.resource_entities().get(id);
            let mut entity = match entity {
                Some(entity) => world.entity_mut(entity),
                None => world.spawn_empty(),
            };
            component.insert(&mut entity, resource.as_partial_reflect(), &registry);
        }
        for state in &self.entities {
            let mut entity = world.spawn_empty();
            for name in &state.behaviours {
                if let Some(insert) = entity.world().resource::<BehaviourRegistry>().marker_of(name) {
                    insert(&mut entity);
                }
            }
            for value in &state.components {
                if let Some(component) = reflected(&**value, &registry) {
                    component.insert(&mut entity, value.as_partial_reflect(), &registry);
                }
            }
        }
        Ok(())
    }

    /// Does the same as [`restore`](Self::restore), but with the random numbers of `seed` from now on. Earlier random values, such as the
    /// mounting errors of a robot's cameras, stay the same.
    ///
    /// # Errors
    /// The same as for [`restore`](Self::restore).
    pub fn restore_with_chance(&self, world: &mut World, seed: u64) -> Result<(), SnapshotError> {
        self.restore(world)?;
        reseed(world, seed);
        Ok(())
    }
}

/// Gives the match in `world` the random numbers of `seed` from now on. Earlier random values, such as the mounting errors of a robot's
/// cameras, stay the same.
pub fn reseed(world: &mut World, seed: u64) {
    let mut robots = world.query::<(&RobotId, &mut RandomStreams)>();
    for (id, mut streams) in robots.iter_mut(world) {
        *streams = RandomStreams::new(seed, *id);
    }
    let mut behaviours = world.query::<(&RobotId, &mut BehaviourRandom)>();
    for (id, mut random) in behaviours.iter_mut(world) {
        *random = BehaviourRandom::new(seed, *id);
    }
    referee::reseed(world, seed);
}

impl Snapshot {
    /// Removes the beliefs and behaviours of these robots. Their true state, their sensor readings and public information stay.
    pub(super) fn forget_thoughts(&mut self, robots: &[RobotId]) {
        for entity in &mut self.entities {
            let id = entity.components.iter().find_map(|component| component.as_any().downcast_ref::<RobotId>());
            if !id.is_some_and(|id| robots.contains(id)) {
                continue;
            }
            entity.behaviours.clear();
            entity.components.retain(|component| {
                let mark = Knowledge::of_type_info(component.reflect_type_info());
                let is_thought = mark.is_none_or(|mark| mark == Knowledge::Belief);
                let component_is = component.as_any();
                let is_behaviour =
                    component_is.is::<Script>() || component_is.is::<Program>() || component_is.is::<Policy>();
                component.as_any().is::<MatchEntity>() || !(is_thought || is_behaviour)
            });
        }
    }
}

fn entity_state(entity: Entity, world: &World, registry: &TypeRegistry) -> Result<EntityState, SnapshotError> {
    let entity = world.entity(entity);
    let mut state = EntityState { behaviours: Vec::new(), components: Vec::new() };
    for &id in entity.archetype().components() {
        let Some(info) = world.components().get_info(id) else { continue };
        let registration = registration_of(id, world, registry);
        if let Some(registration) = registration
            && let Some(component) = registration.data::<ReflectComponent>()
        {
            if belongs_to_match(registration)
                && let Some(value) = component.reflect(entity)
            {
                state.components.push(copy(value, registration)?);
            }
            continue;
        }
        let behaviours = world.resource::<BehaviourRegistry>();
        if let Some(name) = info.type_id().and_then(|type_id| behaviours.name_of_marker(type_id)) {
            state.behaviours.push(name.to_owned());
            continue;
        }
        let name = info.name().to_string();
        if !is_of_the_program(&name) {
            return Err(SnapshotError::NotRegistered { component: name });
        }
    }
    state.components.sort_by_key(|component| component.reflect_type_path().to_owned());
    Ok(state)
}

/// Copies the value of a component with `FromReflect`, since not all such values can be cloned.
fn copy(value: &dyn Reflect, registration: &TypeRegistration) -> Result<Box<dyn Reflect>, SnapshotError> {
    registration
        .data::<ReflectFromReflect>()
        .and_then(|from_reflect| from_reflect.from_reflect(value.as_partial_reflect()))
        .ok_or_else(|| SnapshotError::NotCopied(registration.type_info().type_path()))
}

fn registration_of<'a>(
    id: bevy::ecs::component::ComponentId,
    world: &World,
    registry: &'a TypeRegistry,
) -> Option<&'a TypeRegistration> {
    registry.get(world.components().get_info(id)?.type_id()?)
}

fn reflected<'a>(value: &dyn Reflect, registry: &'a TypeRegistry) -> Option<&'a ReflectComponent> {
    registry.get(value.reflect_type_info().type_id())?.data::<ReflectComponent>()
}

/// Returns whether a type is part of a match's state: a marked type of the simulation, or a user's own type.
fn belongs_to_match(registration: &TypeRegistration) -> bool {
    // The roster contains entities, and is updated automatically.
    if registration.type_id() == TypeId::of::<Roster>() {
        return false;
    }
    let type_info = registration.type_info();
    Knowledge::of_type_info(type_info).is_some() || !is_of_the_program(type_info.type_path())
}

/// Returns whether a type belongs to the engine or to naoisis. Without a mark, such a type is for display only.
fn is_of_the_program(name: &str) -> bool {
    name.starts_with("bevy_") || is_of_naoisis(name)
}
