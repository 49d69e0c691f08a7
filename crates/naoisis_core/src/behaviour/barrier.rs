//! The information barrier: a behaviour has access to the sensors of its robots, but not to ground truth.
//!
//! It has two parts. The compiler restricts the parameters of a behaviour to a [list](super::parameters) of safe ones. For
//! these, [`inspect`] reads from the engine which components they access. Every component of the simulation has a
//! [`Knowledge`] mark, so that behaviours
//!
//! - neither read nor write ground truth, nor filter by it;
//! - write only commands, beliefs and components of their own;
//! - find only robots with the behaviour's own marker, which each query must name;
//! - read the engine's clocks, and no other components and resources of the engine.
//!
//! The marker and its required components are inserted into robots when the match starts. Therefore the marker must belong to
//! one behaviour alone, have no hooks, and require nothing of the simulation but beliefs and commands: the scenario decides what
//! a robot is, and which sensors it has.
//!
//! # What the barrier cannot see
//!
//! - Other systems of the program: they may read ground truth and pass it to a behaviour, in a resource or behind an `Arc` that a closure
//!   shares. A type with `FromWorld` that is registered for reflection receives the world when a saved match is restored. A program marks
//!   its own ground truth, and registers it before the behaviours.
//! - Data shared by behaviours of a program. A behaviour can read every unmarked resource whose type it can name: a team keeps its
//!   resources private.
//! - Everything outside the engine: files (such as the trace that is being written), threads, another match with the same seed, and
//!   `unsafe` code.
//! - Sharing between robots of one behaviour: its system decides for all robots with its marker, and may use what it keeps in resources,
//!   `Local`s or one robot's components for another robot. A behaviour that shares only by [messages](crate::communication) keeps its
//!   memory in components, and handles one robot at a time, as the built-in behaviours do.

use bevy::ecs::component::{ComponentId, ComponentInfo};
use bevy::ecs::query::{ComponentAccessKind, FilteredAccess};
use bevy::ecs::resource::IsResource;
use bevy::prelude::*;
use bevy::time::{Fixed, Real, Virtual};
use core::any::TypeId;

use super::function::Behaviour;
use crate::knowledge::{Knowledge, is_of_naoisis};

/// Error of the registration of a behaviour. Its `Debug` form is the same sentence as its `Display` form, as `main` and tests print the
/// former.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("behaviour `{behaviour}` is refused: its system `{system}` {reason}")]
pub struct BarrierError {
    /// The name of the behaviour.
    pub behaviour: String,
    /// The name of the behaviour's system.
    pub system: String,
    /// The reason for the refusal.
    pub reason: Breach,
}

debug_as_displayed!(BarrierError);

/// Why a behaviour is refused.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Breach {
    /// The system reads all components of an entity, as `EntityRef` or `EntityMut` do.
    #[error(
        "reads whole entities (`EntityRef` and the like), ground truth included; name the sensor components that it needs"
    )]
    Unbounded,
    /// The app has no simulation yet, so that the marks of what the behaviour accesses are unknown.
    #[error("is registered in an app without the simulation; add the `NaoisisPlugins` before the behaviours")]
    NoSimulation,
    /// The system accesses a component or resource that behaviours may not access.
    #[error(
        "{verb} `{component}`, which is {knowledge}; {}",
        instead_of(component).unwrap_or("a behaviour reads sensors, and writes commands and beliefs")
    )]
    Forbidden {
        /// The kind of access.
        verb: &'static str,
        /// The component's or resource's type.
        component: String,
        /// Its knowledge mark in words.
        knowledge: String,
    },
    /// The marker is also carried by other robots.
    #[error(
        "is registered for robots with `{component}`, which other robots carry too; \
         give the behaviour a marker component of its own"
    )]
    NoMarker {
        /// The component's type.
        component: String,
    },
    /// The name is in use.
    #[error("has the name of another behaviour; give it a name of its own")]
    NameTaken,
    /// The marker, or a component required by it, has hooks, which have access to the world.
    #[error("comes with `{component}`, whose hooks would see the whole world; leave the hooks away")]
    Hooks {
        /// The component's type.
        component: String,
    },
    /// The marker requires a component that a behaviour may not insert.
    #[error(
        "comes with `{component}`, which is {knowledge}; a marker may require beliefs, commands and memories of your own"
    )]
    RequiresForbidden {
        /// The component's type.
        component: String,
        /// Its knowledge mark in words.
        knowledge: String,
    },
    /// The system queries entities that may not be the behaviour's own robots.
    #[error("finds {what} of entities that need not be its own robots; add `With<{marker}>` to the query's filter")]
    ForeignRobots {
        /// The components that it queries, in words.
        what: String,
        /// The behaviour's marker.
        marker: String,
    },
    /// The behaviour is ordered before or after one that does not exist.
    #[error("has its turn before or after `{name}`, which is not registered; register that one first")]
    NoSuchBehaviour {
        /// The name of the missing behaviour.
        name: String,
    },
    /// The behaviour is ordered before one behaviour and after another that comes later.
    #[error("decides after `{after}` and before `{before}`, which come the other way round")]
    Order {
        /// The behaviour that it should come after.
        after: String,
        /// The behaviour that it should come before.
        before: String,
    },
}

debug_as_displayed!(Breach);

/// Checks what the system and the conditions of the behaviour `name` of robots with `Marker` access.
///
/// # Errors
/// The first breach of the barrier.
pub fn inspect<Marker: Component>(
    name: &str,
    behaviour: &mut Behaviour,
    world: &mut World,
) -> Result<(), BarrierError> {
    let marker = world.register_component::<Marker>();
    let resource = world.register_component::<IsResource>();
    let system = (behaviour.system.name(), behaviour.system.initialize(world));
    let conditions = behaviour.conditions.iter_mut().map(|condition| (condition.name(), condition.initialize(world)));
    let systems: Vec<_> = core::iter::once(system).chain(conditions).collect();
    for (system, access) in systems {
        for query in access.filtered_accesses() {
            inspect_query(query, marker, resource, world).map_err(|reason| BarrierError {
                behaviour: name.to_owned(),
                system: system.to_string(),
                reason,
            })?;
        }
    }
    Ok(())
}

/// Checks that `Marker` can be the marker of a behaviour: it is the user's own, or a marker of the simulation, which is a belief
/// of size zero; neither it nor its required components have hooks; and these are beliefs, commands, or the user's own.
///
/// # Errors
/// [`Breach::NoMarker`], [`Breach::Hooks`] and [`Breach::RequiresForbidden`].
pub(super) fn inspect_marker<Marker: Component>(world: &mut World) -> Result<(), Breach> {
    let marker = world.register_component::<Marker>();
    let is_marker = match Origin::of(marker, world) {
        Origin::Engine => false,
        Origin::Simulation(knowledge) => knowledge == Knowledge::Belief && size_of::<Marker>() == 0,
        // Any robot may have a sensor or a setting.
        Origin::Own(knowledge) => knowledge.is_none_or(|knowledge| knowledge == Knowledge::Belief),
    };
    if !is_marker {
        return Err(Breach::NoMarker { component: component_name(marker, world) });
    }
    let Some(info) = world.components().get_info(marker) else { return Ok(()) };
    // Required components come before those that require them; an error names what the user wrote.
    let mut brought: Vec<ComponentId> = info.required_components().iter_ids().chain([marker]).collect();
    brought.reverse();
    for id in brought {
        let component = || component_name(id, world);
        if world.components().get_info(id).is_some_and(has_hooks) {
            return Err(Breach::Hooks { component: component() });
        }
        let knowledge = match Origin::of(id, world) {
            Origin::Engine => THE_ENGINES.to_owned(),
            Origin::Simulation(knowledge) | Origin::Own(Some(knowledge)) if !knowledge.is_writable() => {
                knowledge.to_string()
            }
            _ => continue,
        };
        return Err(Breach::RequiresForbidden { component: component(), knowledge });
    }
    Ok(())
}

fn has_hooks(info: &ComponentInfo) -> bool {
    let mut hooks = info.hooks().clone();
    let free = hooks.try_on_add(|_, _| {}).is_some()
        && hooks.try_on_insert(|_, _| {}).is_some()
        && hooks.try_on_discard(|_, _| {}).is_some()
        && hooks.try_on_remove(|_, _| {}).is_some()
        && hooks.try_on_despawn(|_, _| {}).is_some();
    !free
}

/// Checks a query of robots, or the access to a resource, which to the engine is a query, too.
fn inspect_query(
    query: &FilteredAccess,
    marker: ComponentId,
    resource: ComponentId,
    world: &World,
) -> Result<(), Breach> {
    // A filter is a disjunction: what must hold for every match must be in each of its sets.
    let finds_only = |id| {
        !query.filter_sets().is_empty() && query.filter_sets().iter().all(|conditions| conditions.with().contains(id))
    };
    let accesses: Vec<_> = query.access().try_iter_access().map_err(|_| Breach::Unbounded)?.collect();
    for &access in &accesses {
        inspect_access(access, marker, world)?;
    }
    for id in query.with_filters().chain(query.without_filters()) {
        if Origin::of(id, world).is_truth() {
            return Err(forbidden("filters by", id, &Knowledge::Truth.to_string(), world));
        }
    }
    // A resource is one component of one entity. A query without a particular component would count all resources.
    let is_resource = |id| {
        let info = world.components().get_info(id);
        finds_only(id) && info.is_some_and(|info| info.required_components().iter_ids().any(|id| id == resource))
    };
    let finds_one_resource = finds_only(resource) && accesses.len() == 1 && is_resource(*accesses[0].index());
    if finds_only(marker) || finds_one_resource {
        return Ok(());
    }
    let what = accesses
        .first()
        .map_or("something".to_owned(), |access| format!("`{}`", component_name(*access.index(), world)));
    Err(Breach::ForeignRobots { what, marker: component_name(marker, world) })
}

/// Checks the access to one component or resource.
fn inspect_access(access: ComponentAccessKind, marker: ComponentId, world: &World) -> Result<(), Breach> {
    let (id, writes, verb) = match access {
        ComponentAccessKind::Exclusive(id) => (id, true, "writes"),
        ComponentAccessKind::Shared(id) => (id, false, "reads"),
        ComponentAccessKind::Archetypal(id) => (id, false, "asks about"),
    };
    match Origin::of(id, world) {
        _ if id == marker => Ok(()),
        Origin::Engine if !writes && is_clock(id, world) => Ok(()),
        Origin::Engine => Err(forbidden(verb, id, THE_ENGINES, world)),
        Origin::Own(None) => Ok(()),
        Origin::Own(Some(knowledge)) | Origin::Simulation(knowledge) => {
            let allowed = if writes { knowledge.is_writable() } else { knowledge.is_readable() };
            if allowed { Ok(()) } else { Err(forbidden(verb, id, &knowledge.to_string(), world)) }
        }
    }
}

fn forbidden(verb: &'static str, id: ComponentId, knowledge: &str, world: &World) -> Breach {
    Breach::Forbidden { verb, component: component_name(id, world), knowledge: knowledge.to_owned() }
}

/// What a behaviour can read instead of a component or resource that it may not access, if there is something.
fn instead_of(component: &str) -> Option<&'static str> {
    match component.rsplit("::").next()? {
        "Game" | "RefereeMemory" | "Penalty" => Some("what a robot is told of the game is its `GameStatus`"),
        "RandomStreams" => Some("a behaviour draws from the `BehaviourRandom` that its marker requires"),
        "Pose" | "BallVelocity" => Some("where things are, a behaviour reads from `Percepts` and `Belief`"),
        _ => None,
    }
}

/// The knowledge of a component or resource of Bevy, in words.
const THE_ENGINES: &str = "the engine's own";

/// The origin of a component or resource, and its knowledge mark.
#[derive(Clone, Copy)]
enum Origin {
    /// Bevy, or a crate with its prefix. Examples are `Schedules`, through which systems with access to everything could be added, and
    /// `Transform`, which shows true poses.
    Engine,
    /// The simulation. Without a mark it counts as ground truth.
    Simulation(Knowledge),
    /// The program, with or without a mark.
    Own(Option<Knowledge>),
}

impl Origin {
    fn of(id: ComponentId, world: &World) -> Origin {
        let marked = world.components().get_info(id).and_then(ComponentInfo::type_id).and_then(|type_id| {
            let registry = world.get_resource::<AppTypeRegistry>()?.read();
            Knowledge::of_type(&registry, type_id)
        });
        let name = component_name(id, world);
        if name.starts_with("bevy_") {
            Origin::Engine
        } else if is_of_naoisis(&name) {
            Origin::Simulation(marked.unwrap_or(Knowledge::Truth))
        } else {
            Origin::Own(marked)
        }
    }

    fn is_truth(self) -> bool {
        matches!(self, Origin::Simulation(Knowledge::Truth) | Origin::Own(Some(Knowledge::Truth)))
    }
}

fn is_clock(id: ComponentId, world: &World) -> bool {
    let clocks =
        [TypeId::of::<Time>(), TypeId::of::<Time<Fixed>>(), TypeId::of::<Time<Virtual>>(), TypeId::of::<Time<Real>>()];
    world.components().get_info(id).and_then(ComponentInfo::type_id).is_some_and(|type_id| clocks.contains(&type_id))
}

fn component_name(id: ComponentId, world: &World) -> String {
    world.components().get_name(id).map_or_else(|| format!("{id:?}"), |name| name.to_string())
}
