//! The parameters that a behaviour may have: a closed list of safe ones.
//!
//! | parameter | why it is safe |
//! |---|---|
//! | `Query<D, F>`, `Single<D, F>`, `Populated<D, F>` | the [barrier](super::barrier) checks their access; they find only its own robots |
//! | `Res<T>`, `ResMut<T>` | the same: the program's own resources, [public](crate::knowledge::Knowledge::Public) ones, the engine's clocks |
//! | `Local<T>` of a `T: Default` | it begins as `T::default()`; a `FromWorld` of its own would be handed the world |
//! | `Option<P>`, `If<P>`, `ParamSet<(P, ...)>`, tuples of parameters | they are made of others of the list |
//!
//! `D` and `F` may derive `QueryData` and `QueryFilter`. Nothing else is a [`BehaviourParam`], and a system with another parameter does not
//! compile as a behaviour. This includes parameters that are harmless today: whatever the engine adds is refused until somebody has
//! examined it.
//!
//! | refused | what a behaviour uses instead |
//! |---|---|
//! | `&World`, `&mut World`, `Commands`, `Deferred<T>` | queries, and its robot's command components |
//! | `&Archetypes`, `&Components`, `&Entities`, `&Bundles`, `RemovedComponents<T>` | percepts (`naoisis_sensing::sensing::vision::Percepts`) |
//! | `MessageReader<M>`, `MessageWriter<M>`: they follow frames, not cycles | a resource, or [messages](crate::communication) between robots |
//! | `NonSend<T>`, `Gizmos` | resources, [drawings](super::drawings) |
//! | a group of parameters that derives `SystemParam`: its content is hidden | a tuple: `type Known<'w> = (Res<'w, Pitch>, Res<'w, CycleClock>);` |
//! | piped, mapped and combined systems | one function that calls the others |
//!
//! Query data need no list: a query can be [transmuted](Query::transmute_lens) to any other data of the same access anyway. So a behaviour
//! may know whatever the engine knows of its *own* robots' entities without reading another component: their ids, when something was
//! changed, and which components they have. A robot keeps the same components from the first cycle to the last, whatever happens to it.
//!
//! The compiler enforces the list:
//!
//! ```compile_fail,E0277
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//!
//! #[derive(Component, Default)]
//! struct Spy;
//!
//! fn spawns(mut commands: Commands) {
//!     commands.spawn_empty();
//! }
//!
//! App::new().add_behaviour::<Spy, _>("spy", spawns);
//! ```

use bevy::ecs::component::Mutable;
use bevy::ecs::query::{IterQueryData, QueryData, QueryFilter};
use bevy::ecs::system::{If, SystemParam};
use bevy::prelude::*;

/// A parameter that the system of a behaviour may have: see the [list](self).
#[diagnostic::on_unimplemented(
    message = "a behaviour may not have the parameter `{Self}`",
    label = "has a parameter that is not on the list of what is safe",
    note = "queries, `Res`, `ResMut`, `Local`s of a type with `Default`, and `Option`s, `ParamSet`s and tuples of them are",
    note = "see `naoisis::behaviour::parameters` for what to use instead"
)]
pub trait BehaviourParam: SystemParam + sealed::Sealed {}

mod sealed {
    /// Keeps the list closed.
    pub trait Sealed {}
}

macro_rules! safe {
    ($([$($generics:tt)*] $parameter:ty;)*) => {$(
        impl<$($generics)*> sealed::Sealed for $parameter {}
        impl<$($generics)*> BehaviourParam for $parameter {}
    )*};
}

safe! {
    [D: QueryData + 'static, F: QueryFilter + 'static] Query<'_, '_, D, F>;
    [D: IterQueryData + 'static, F: QueryFilter + 'static] Single<'_, '_, D, F>;
    [D: QueryData + 'static, F: QueryFilter + 'static] Populated<'_, '_, D, F>;
    [T: Resource] Res<'_, T>;
    [T: Resource<Mutability = Mutable>] ResMut<'_, T>;
    // `Default` suffices: a type that implements it gets its `FromWorld` from it.
    [T: Default + Send + 'static] Local<'_, T>;
    [P: BehaviourParam] Option<P>;
    [P: BehaviourParam] If<P>;
}

macro_rules! safe_tuples {
    () => {
        safe! { [] (); }
    };
    ($first:ident $($rest:ident)*) => {
        safe! { [$first: BehaviourParam, $($rest: BehaviourParam),*] ($first, $($rest,)*); }
        safe_tuples!($($rest)*);
    };
}

macro_rules! safe_sets {
    () => {};
    ($first:ident $($rest:ident)*) => {
        safe! { [$first: BehaviourParam, $($rest: BehaviourParam),*] ParamSet<'_, '_, ($first, $($rest,)*)>; }
        safe_sets!($($rest)*);
    };
}

// As many as Bevy knows.
safe_tuples!(P0 P1 P2 P3 P4 P5 P6 P7 P8 P9 P10 P11 P12 P13 P14 P15);
safe_sets!(P0 P1 P2 P3 P4 P5 P6 P7);
