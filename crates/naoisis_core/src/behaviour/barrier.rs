//! The information barrier: a behaviour knows what its robot's sensors tell it, and nothing else.
//!
//! It is closed from two sides. What parameters a behaviour may have is a [list](super::parameters) of what is known to be
//! safe, which the compiler holds: whatever hands out the world, now or later, is not on it. And of those that are on it,
//! [`inspect`] reads from the engine which components they access. Every component of the simulation says by its
//! [`Knowledge`] mark what it is, so that behaviours
//!
//! - neither read nor write ground truth, nor filter by it;
//! - write only commands, beliefs and what is their own;
//! - find only robots that carry the behaviour's own marker: each query names it;
//! - of the engine's own components and resources read the clocks, and no others.
//!
//! The marker and the components that it requires come to robots when the match starts. So it must be nobody else's,
//! nothing of it may have hooks, and it brings no part of the simulation but beliefs and commands: what a robot is, and
//! which sensors it has, the scenario says.
//!
//! # What the barrier cannot see
//!
//! - What a program does beside its behaviours: a system of its own may read what it likes, and put it where a behaviour
//!   finds it, in a resource or behind an `Arc` that a closure shares; and a type that it registers for reflection with a
//!   `FromWorld` is handed the world when a saved match is restored. What is truth of its own it marks, and registers
//!   before the behaviours.
//! - What two behaviours of a program share. A resource that one of them can name, it can read, whosever it is: a team
//!   keeps its own private.
//! - What goes past the engine: files (the trace that is being written, for one), threads, another match played with
//!   the seed of this one, and `unsafe` code.
//! - Which robot of a behaviour knows what: its system is one mind for all that carry its marker, and what it keeps in
//!   resources, `Local`s or in one robot's components it may use for another. A behaviour that should share by
//!   [messages](crate::communication) only keeps its memory in components, and looks at one robot at a time, as the
//!   built-in ones do.

use bevy::ecs::component::{ComponentId, ComponentInfo};
use bevy::ecs::query::{ComponentAccessKind, FilteredAccess};
use bevy::ecs::resource::IsResource;
use bevy::prelude::*;
use bevy::time::{Fixed, Real, Virtual};
use core::any::TypeId;

use super::function::Behaviour;
use crate::knowledge::{Knowledge, is_of_naoisis};

/// Why a behaviour was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("behaviour `{behaviour}` is refused: its system `{system}` {reason}")]
pub struct BarrierError {
    /// The name under which it should have been registered.
    pub behaviour: String,
    /// The name of the behaviour's system.
    pub system: String,
    /// What it does wrong.
    pub reason: Breach,
}

/// What a dishonest behaviour does.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Breach {
    /// It reads all components of an entity, as `EntityRef` or `EntityMut` do.
    #[error(
        "reads whole entities (`EntityRef` and the like), ground truth included; name the sensor components that it needs"
    )]
    Unbounded,
    /// It accesses something that is not for behaviours.
    #[error("{verb} `{component}`, which is {knowledge}; a behaviour reads sensors, and writes commands and beliefs")]
    Forbidden {
        /// What it does.
        verb: &'static str,
        /// The component's or resource's type.
        component: String,
        /// What that is.
        knowledge: String,
    },
    /// Its marker is no marker: robots that are not its own carry it too.
    #[error(
        "is registered for robots with `{component}`, which other robots carry too; \
         give the behaviour a marker component of its own"
    )]
    NoMarker {
        /// The component's type.
        component: String,
    },
    /// Another behaviour has its name.
    #[error("has the name of another behaviour; give it a name of its own")]
    NameTaken,
    /// Its marker, or a component that comes with it, runs code with the world at hand.
    #[error("comes with `{component}`, whose hooks would see the whole world; leave the hooks away")]
    Hooks {
        /// The component's type.
        component: String,
    },
    /// Its marker brings what a behaviour cannot give a robot.
    #[error(
        "comes with `{component}`, which is {knowledge}; a marker may require beliefs, commands and memories of your own"
    )]
    Brings {
        /// The component's type.
        component: String,
        /// What that is.
        knowledge: String,
    },
    /// It queries robots, or other entities, that may not be its own.
    #[error("finds {what} of entities that need not be its own robots; add `With<{marker}>` to the query's filter")]
    ForeignRobots {
        /// What it finds there.
        what: String,
        /// The behaviour's marker.
        marker: String,
    },
    /// It decides before or after a behaviour that there is not.
    #[error("has its turn before or after `{name}`, which is not registered; register that one first")]
    NoSuchBehaviour {
        /// The name that was to be registered.
        name: String,
    },
    /// It decides before one behaviour and after another that comes later.
    #[error("decides after `{after}` and before `{before}`, which come the other way round")]
    Order {
        /// The behaviour that it should come after.
        after: String,
        /// The behaviour that it should come before.
        before: String,
    },
}

/// Checks what a behaviour's system and its conditions access, on behalf of the behaviour `name` of robots with `Marker`.
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

/// Checks that a component can tie a behaviour to its robots: it is the user's own, or one of the simulation's markers
/// of behaviours, which are beliefs without content; neither it nor what comes with it has hooks; and what comes with it
/// is a belief, a command, or the user's own and nothing else.
///
/// # Errors
/// [`Breach::NoMarker`], [`Breach::Hooks`] and [`Breach::Brings`].
pub(super) fn inspect_marker<Marker: Component>(world: &mut World) -> Result<(), Breach> {
    let marker = world.register_component::<Marker>();
    let is_marker = match Origin::of(marker, world) {
        Origin::Engine => false,
        Origin::Simulation(knowledge) => knowledge == Knowledge::Belief && size_of::<Marker>() == 0,
        // A sensor or a setting, say, is what all robots may have.
        Origin::Own(knowledge) => knowledge.is_none_or(|knowledge| knowledge == Knowledge::Belief),
    };
    if !is_marker {
        return Err(Breach::NoMarker { component: component_name(marker, world) });
    }
    let Some(info) = world.components().get_info(marker) else { return Ok(()) };
    // What is required comes before what requires it; an error names what the user wrote.
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
        return Err(Breach::Brings { component: component(), knowledge });
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

/// Checks a query of robots, or the access to a resource, which is a query to the engine, too.
fn inspect_query(
    query: &FilteredAccess,
    marker: ComponentId,
    resource: ComponentId,
    world: &World,
) -> Result<(), Breach> {
    // A filter is a choice between sets of conditions: what must hold of every match must be in each of them.
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
    // A resource is one component of one entity. Whoever asks for none in particular would see how many there are.
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

/// What a component or resource of Bevy's is to a behaviour.
const THE_ENGINES: &str = "the engine's own";

/// Whose a component or resource is, and what it says that it is.
#[derive(Clone, Copy)]
enum Origin {
    /// Bevy's, or one of a crate that names itself after it: `Schedules`, through which systems could be added that see
    /// everything, or `Transform`, which shows where things are.
    Engine,
    /// The simulation's. What is not marked is not for behaviours.
    Simulation(Knowledge),
    /// The program's own, marked or not.
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
