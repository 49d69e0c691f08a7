//! The state of a match, for those who do not know its types: snapshots, and whoever shows what a robot thinks.
//!
//! `#[reflect(State)]` makes a component or resource part of it. That is the little of Bevy's [`ReflectComponent`] that is
//! needed: what else that can do would be a tenth of the program. A program's own components may say
//! `#[reflect(Component)]` as well, as is usual.

use bevy::ecs::component::ComponentId;
use bevy::prelude::*;
use bevy::reflect::{FromReflect, FromType, TypeRegistration, TypeRegistry};

/// How a component or resource is read and put back without knowing its type.
#[derive(Clone)]
pub struct ReflectState {
    reflect: for<'w> fn(EntityRef<'w>) -> Option<&'w dyn Reflect>,
    insert: fn(&mut EntityWorldMut, &dyn Reflect),
    register: fn(&mut World) -> ComponentId,
}

impl<C: Component + FromReflect> FromType<C> for ReflectState {
    fn from_type() -> Self {
        ReflectState {
            reflect: |entity| entity.get::<C>().map(|component| component as &dyn Reflect),
            insert: |entity, value| {
                if let Some(component) = C::from_reflect(value.as_partial_reflect()) {
                    entity.insert(component);
                }
            },
            register: |world| world.register_component::<C>(),
        }
    }
}

/// How the values of a type are read and put back, in either of the two ways that a type can offer it.
#[derive(Clone, Copy)]
pub(crate) enum StateAccess<'a> {
    /// Part of the simulation.
    State(&'a ReflectState),
    /// Of a program's own.
    Component(&'a ReflectComponent),
}

impl<'a> StateAccess<'a> {
    /// That of a registered type, if it offers one.
    pub fn of(registration: &'a TypeRegistration) -> Option<Self> {
        match registration.data::<ReflectState>() {
            Some(state) => Some(StateAccess::State(state)),
            None => registration.data::<ReflectComponent>().map(StateAccess::Component),
        }
    }

    /// The value that an entity has.
    pub fn reflect<'w>(self, entity: EntityRef<'w>) -> Option<&'w dyn Reflect> {
        match self {
            StateAccess::State(state) => (state.reflect)(entity),
            StateAccess::Component(component) => component.reflect(entity),
        }
    }

    /// Gives an entity a value of the type.
    pub fn insert(self, entity: &mut EntityWorldMut, value: &dyn Reflect, registry: &TypeRegistry) {
        match self {
            StateAccess::State(state) => (state.insert)(entity, value),
            StateAccess::Component(component) => component.insert(entity, value.as_partial_reflect(), registry),
        }
    }

    /// Makes the type known to the world.
    pub fn register(self, world: &mut World) -> ComponentId {
        match self {
            StateAccess::State(state) => (state.register)(world),
            StateAccess::Component(component) => component.register_component(world),
        }
    }
}
