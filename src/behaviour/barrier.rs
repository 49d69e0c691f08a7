//! The information barrier: a behaviour knows what its robot's sensors tell it, and nothing else.
//!
//! [`inspect`] initialises a system and reads from the ECS which components it accesses. Every component of the
//! simulation says by its [`Knowledge`] mark what it is, so the engine itself enforces for everybody's behaviours
//! that they
//!
//! - neither read nor write ground truth, nor filter by it;
//! - write only commands and beliefs;
//! - touch only robots that carry the behaviour's own marker;
//! - do not take the whole world, all components of an entity, or commands that change the world later;
//! - find no match when they are registered, so that parameters which build themselves from the world
//!   (`Local<T: FromWorld>`) see nothing, and leave nobody behind in it: no system, observer or hook.
//!
//! What the barrier cannot see is what a program does beside its behaviours: a system of its own may read what it likes,
//! and put it where a behaviour finds it. Nor does it part the robots of one behaviour: its system is one mind for all
//! that carry its marker, and what it keeps in resources, `Local`s or in one robot's components it may use for another.
//! A behaviour that should share by [messages](crate::communication) only keeps its memory in components, and looks at
//! one robot at a time, as the built-in ones do.

use bevy::ecs::component::{ComponentId, ComponentInfo};
use bevy::ecs::query::{ComponentAccessKind, FilteredAccess, FilteredAccessSet};
use bevy::ecs::resource::IsResource;
use bevy::prelude::*;
use core::any::TypeId;

use crate::knowledge::Knowledge;
use crate::team::RobotId;

/// Why a behaviour was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("behaviour `{behaviour}` is refused: its system `{system}` {reason}")]
pub struct BarrierError {
    /// The name under which it should have been registered.
    pub behaviour: String,
    /// The system.
    pub system: String,
    /// What it does wrong.
    pub reason: Breach,
}

/// What a dishonest behaviour does.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Breach {
    /// It takes `&mut World`.
    #[error("takes the whole world; a behaviour reads its robot's sensors through queries")]
    Exclusive,
    /// It has `Commands` or other deferred effects.
    #[error(
        "changes the world through deferred commands; a behaviour acts through its robot's command components only"
    )]
    Deferred,
    /// It reads all components, as `&World`, `EntityRef` or `EntityMut` do.
    #[error(
        "reads whole entities or the whole world (`&World`, `EntityRef` and the like), ground truth included; \
         name the sensor components that it needs"
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
    /// There are robots already.
    #[error("is registered while a match is on; register behaviours before the match starts")]
    MatchIsOn,
    /// One of its parameters installed something in the world that would see everything.
    #[error("leaves systems, observers or hooks in the world when its parameters are built")]
    Accomplice,
    /// It queries robots that may not be its own.
    #[error("accesses `{component}` of robots that need not be its own; add `With<{marker}>` to the query's filter")]
    ForeignRobots {
        /// The component's type.
        component: String,
        /// The behaviour's marker.
        marker: String,
    },
}

/// Checks which components a system accesses, on behalf of the behaviour `name` of robots with `Marker`.
///
/// # Errors
/// The first breach of the barrier.
pub fn inspect<Marker: Component>(
    name: &str,
    system: &mut impl System<In = (), Out = ()>,
    world: &mut World,
) -> Result<(), BarrierError> {
    let system_name = system.name().to_string();
    let refuse = |reason| BarrierError { behaviour: name.to_owned(), system: system_name.clone(), reason };
    if system.is_exclusive() {
        return Err(refuse(Breach::Exclusive));
    }
    let marker = world.register_component::<Marker>();
    let access = initialise(system, world).map_err(refuse)?;
    if system.has_deferred() {
        return Err(refuse(Breach::Deferred));
    }
    let resource = world.register_component::<IsResource>();
    for query in access.filtered_accesses() {
        inspect_query(query, marker, resource, world).map_err(&refuse)?;
    }
    Ok(())
}

/// Initialises a system, whose parameters may get hold of the world meanwhile, where there is nothing to be seen, and
/// sees to it that they leave nothing behind that would see more later.
fn initialise(system: &mut impl System<In = (), Out = ()>, world: &mut World) -> Result<FilteredAccessSet, Breach> {
    let robots = world.try_query_filtered::<(), With<RobotId>>();
    if robots.is_some_and(|mut robots| robots.iter(world).next().is_some()) {
        return Err(Breach::MatchIsOn);
    }
    let watchers = |world: &mut World| {
        let observers = world.query_filtered::<(), With<Observer>>().iter(world).count();
        let hooked = world
            .components()
            .iter_registered()
            .filter(|info| has_hooks(info))
            .filter(|info| info.type_id().is_some_and(mirrors_truth) || names_simulation(&info.name().to_string()));
        (observers, hooked.count())
    };
    let before = watchers(world);
    let schedules = world.remove_resource::<Schedules>();
    let access = system.initialize(world);
    let accomplices = world.contains_resource::<Schedules>();
    if let Some(schedules) = schedules {
        world.insert_resource(schedules);
    }
    if accomplices || watchers(world) != before {
        return Err(Breach::Accomplice);
    }
    Ok(access)
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

/// Checks that a component can tie a behaviour to its robots: it is none of the simulation's own, which all robots
/// carry, markers without content apart; and neither it nor what comes with it has hooks.
///
/// # Errors
/// [`Breach::NoMarker`] and [`Breach::Hooks`].
pub(super) fn inspect_marker<Marker: Component>(world: &mut World) -> Result<(), Breach> {
    let marker = world.register_component::<Marker>();
    let knowledge = knowledge_of(marker, world)?;
    if knowledge.is_some() && size_of::<Marker>() > 0 || knowledge == Some(Knowledge::Truth) {
        return Err(Breach::NoMarker { component: component_name(marker, world) });
    }
    let Some(info) = world.components().get_info(marker) else { return Ok(()) };
    for id in core::iter::once(marker).chain(info.required_components().iter_ids()) {
        if world.components().get_info(id).is_some_and(has_hooks) {
            return Err(Breach::Hooks { component: component_name(id, world) });
        }
    }
    Ok(())
}

fn inspect_query(
    query: &FilteredAccess,
    marker: ComponentId,
    resource: ComponentId,
    world: &World,
) -> Result<(), Breach> {
    // A filter is a choice between sets of conditions: what must hold of every match must be in each of them.
    let requires = |id| {
        query.required().contains(id)
            || (!query.filter_sets().is_empty() && query.filter_sets().iter().all(|set| set.with().contains(id)))
    };
    let (is_resource, own_robots_only) = (requires(resource), requires(marker));
    let accesses = query.access().try_iter_access().map_err(|_| Breach::Unbounded)?;
    for access in accesses {
        let (id, writes, verb) = match access {
            ComponentAccessKind::Exclusive(id) => (id, true, "writes"),
            ComponentAccessKind::Shared(id) => (id, false, "reads"),
            ComponentAccessKind::Archetypal(id) => (id, false, "asks about"),
        };
        if id == marker || id == resource {
            continue;
        }
        if is_resource && is_of_the_engine(&component_name(id, world)) {
            return Err(Breach::Forbidden {
                verb,
                component: component_name(id, world),
                knowledge: "the engine's own".to_owned(),
            });
        }
        let Some(knowledge) = knowledge_of(id, world)? else { continue };
        let allowed = if writes { knowledge.is_writable() } else { knowledge.is_readable() };
        if !allowed {
            return Err(Breach::Forbidden {
                verb,
                component: component_name(id, world),
                knowledge: knowledge.to_string(),
            });
        }
        if !own_robots_only && !is_resource {
            return Err(Breach::ForeignRobots {
                component: component_name(id, world),
                marker: component_name(marker, world),
            });
        }
    }
    for id in query.with_filters().chain(query.without_filters()) {
        if knowledge_of(id, world)? == Some(Knowledge::Truth) {
            return Err(Breach::Forbidden {
                verb: "filters by",
                component: component_name(id, world),
                knowledge: Knowledge::Truth.to_string(),
            });
        }
    }
    Ok(())
}

/// What a component is to behaviours; none for components of the user's own.
fn knowledge_of(id: ComponentId, world: &World) -> Result<Option<Knowledge>, Breach> {
    let Some(info) = world.components().get_info(id) else { return Ok(None) };
    let marked = info.type_id().and_then(|type_id| {
        let registry = world.get_resource::<AppTypeRegistry>()?.read();
        Knowledge::of_type(&registry, type_id)
    });
    if marked.is_some() {
        return Ok(marked);
    }
    if info.type_id().is_some_and(mirrors_truth) || names_simulation(&component_name(id, world)) {
        return Ok(Some(Knowledge::Truth));
    }
    Ok(None)
}

/// Whether a resource belongs to Bevy, such as `Schedules`, through which systems could be added that see everything.
/// The clocks may be read.
fn is_of_the_engine(name: &str) -> bool {
    name.starts_with("bevy_") && !name.starts_with("bevy_time::") && !names_simulation(name)
}

/// Bevy's own components that show where things are.
fn mirrors_truth(type_id: TypeId) -> bool {
    [TypeId::of::<Transform>(), TypeId::of::<GlobalTransform>()].contains(&type_id)
}

/// Whether a type is of this crate, or made of one: what is ours and not marked is not for behaviours.
fn names_simulation(name: &str) -> bool {
    name.match_indices("naoisis::")
        .any(|(start, _)| !name[..start].ends_with(|character: char| character.is_alphanumeric() || character == '_'))
}

fn component_name(id: ComponentId, world: &World) -> String {
    world.components().get_name(id).map_or_else(|| format!("{id:?}"), |name| name.to_string())
}
