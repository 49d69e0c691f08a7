//! Cheats that do not compile, shown here by the trait that they lack: a test that something does not compile would be
//! content with any other mistake.

use super::*;
use bevy::ecs::archetype::Archetypes;
use bevy::ecs::bundle::Bundles;
use bevy::ecs::component::{ComponentIdFor, Components};
use bevy::ecs::entity::{Entities, EntityAllocator};
use bevy::ecs::lifecycle::RemovedComponentMessages;
use bevy::ecs::message::{MessageMutator, PopulatedMessageReader};
use bevy::ecs::schedule::IntoScheduleConfigs;
use bevy::ecs::system::{
    BoxedSystem, DynSystemParam, NonSendMarker, ParallelCommands, StaticSystemParam, SystemBuffer, SystemChangeTick,
    SystemMeta, SystemName, SystemParam, SystemParamFunction, SystemParamItem, SystemParamValidationError, SystemState,
};
use bevy::ecs::world::{FilteredResources, FilteredResourcesMut, WorldId};
use bevy::transform::helper::TransformHelper;
use core::marker::PhantomData;
use naoisis::behaviour::BehaviourParam;

/// Whether a type is on the list of parameters: the inherent constant where it is, the trait's where it is not.
struct Parameter<P>(PhantomData<P>);

impl<P: BehaviourParam> Parameter<P> {
    const IS_SAFE: bool = true;
}

trait Unsafe {
    const IS_SAFE: bool = false;
}

impl<P> Unsafe for Parameter<P> {}

macro_rules! unsafe_parameters {
    ($($parameter:ty),* $(,)?) => {
        [$((stringify!($parameter), <Parameter<$parameter>>::IS_SAFE)),*]
            .into_iter()
            .filter_map(|(name, is_safe)| (!is_safe).then_some(name))
            .collect::<Vec<&str>>()
    };
}

/// Whether something is a behaviour, in the same manner.
struct Candidate<T>(T);

trait Accepted<M> {
    fn is_behaviour(&self) -> bool {
        true
    }
}

impl<M, T: IntoBehaviour<M>> Accepted<M> for Candidate<T> {}

trait Rejected {
    fn is_behaviour(&self) -> bool {
        false
    }
}

impl<T> Rejected for &Candidate<T> {}

macro_rules! is_behaviour {
    ($system:expr) => {
        (&Candidate($system)).is_behaviour()
    };
}

#[derive(SystemParam)]
#[expect(dead_code, reason = "only its type counts")]
struct Grouped<'w> {
    clock: Res<'w, CycleClock>,
}

/// Sees the world when it is made.
struct Spy;

impl FromWorld for Spy {
    fn from_world(world: &mut World) -> Self {
        // The hole that was: from the start of the match, every one of these robots would have brought a mole along.
        world.register_required_components::<Mine, Mole>();
        Spy
    }
}

#[derive(Default)]
struct Buffer;

impl SystemBuffer for Buffer {
    fn queue(&mut self, _: &SystemMeta, _: DeferredWorld) {}
}

#[test]
fn the_parameters_that_are_safe_are_these_and_what_is_made_of_them() {
    let refused = unsafe_parameters![
        (),
        Query<(&Percepts, &mut WalkCommand), With<Mine>>,
        Single<(&Percepts, &mut WalkCommand), With<Mine>>,
        Populated<&Percepts, With<Mine>>,
        Res<TeamTactics>,
        ResMut<TeamTactics>,
        Local<Vec<u8>>,
        Option<Res<TeamTactics>>,
        If<Res<TeamTactics>>,
        (Res<Pitch>, Res<Rules>),
        ParamSet<(Query<&mut WalkCommand, With<Mine>>, Query<&WalkCommand, With<Mine>>)>,
        (Option<Single<&Percepts, With<Mine>>>, (Local<u8>, (Local<u8>,))),
    ];
    assert_eq!(refused, [""; 0]);
}

#[test]
fn every_other_parameter_of_the_engine_is_refused() {
    type All<'w, 's> = (
        &'w World,
        DeferredWorld<'w>,
        Commands<'w, 's>,
        ParallelCommands<'w, 's>,
        Deferred<'s, Buffer>,
        &'w Archetypes,
        &'w Components,
        &'w Entities,
        &'w EntityAllocator,
        &'w Bundles,
    );
    let refused = unsafe_parameters![
        &World,
        DeferredWorld,
        Commands,
        ParallelCommands,
        Deferred<Buffer>,
        &Archetypes,
        &Components,
        &Entities,
        &EntityAllocator,
        &Bundles,
        &RemovedComponentMessages,
        RemovedComponents<Pose>,
        ComponentIdFor<Pose>,
        MessageReader<AppExit>,
        MessageWriter<AppExit>,
        MessageMutator<AppExit>,
        PopulatedMessageReader<AppExit>,
        NonSend<u8>,
        NonSendMut<u8>,
        NonSendMarker,
        FilteredResources,
        FilteredResourcesMut,
        DynSystemParam,
        SystemChangeTick,
        SystemName,
        WorldId,
        TransformHelper,
        // Of types that build themselves from the world.
        Local<Spy>,
        Local<QueryState<&'static Pose>>,
        Local<SystemState<Query<'static, 'static, &'static Pose>>>,
        // Nobody can see from outside what is in them.
        Grouped,
        StaticSystemParam<Res<'static, CycleClock>>,
        Result<Res<CycleClock>, SystemParamValidationError>,
        Vec<Res<CycleClock>>,
        ParamSet<Vec<Res<CycleClock>>>,
        PhantomData<World>,
        // What is made of what is refused.
        Option<Commands>,
        If<&World>,
        (Res<CycleClock>, &Archetypes),
        (((Grouped,),),),
        ParamSet<(Res<CycleClock>, Commands)>,
        Option<Option<Local<Spy>>>,
        All,
    ];
    assert_eq!(refused.len(), 43, "these are accepted, or new: {refused:?}");
}

#[cfg(feature = "viewer")]
#[test]
fn so_is_every_other_parameter_of_the_window() {
    use bevy::picking::mesh_picking::ray_cast::MeshRayCast;
    use bevy::render::Extract;
    let refused = unsafe_parameters![
        Gizmos,
        MeshRayCast,
        Extract<Query<'static, 'static, &'static Pose>>,
        naoisis::viewer::bevy_egui::EguiContexts,
    ];
    assert_eq!(refused.len(), 4, "these are accepted, or new: {refused:?}");
}

#[test]
fn only_functions_are_behaviours() {
    fn honest(_: Query<&Percepts, With<Mine>>) {}
    fn told(_: InMut<u8>) {}
    fn sees_all(_: &mut World) {}
    fn keeps_a_state(_: &mut World, _: &mut SystemState<Query<&Pose>>) {}
    fn watches(_: On<Insert, Pose>) {}
    fn holds() -> bool {
        true
    }
    /// A function to look at, that takes what it says.
    struct Disguised;
    impl SystemParamFunction<Disguised> for Disguised {
        type In = ();
        type Out = ();
        type Param = (Query<'static, 'static, &'static Pose>, Commands<'static, 'static>);
        fn run(&mut self, _: (), _: SystemParamItem<Self::Param>) {}
    }

    assert!(is_behaviour!(honest));
    assert!(is_behaviour!(behaviour(honest).run_if(holds)));
    assert!(is_behaviour!(|_: Query<&Percepts, With<Mine>>| -> Result { Ok(()) }));

    assert!(!is_behaviour!(sees_all));
    assert!(!is_behaviour!(keeps_a_state));
    assert!(!is_behaviour!(watches));
    assert!(!is_behaviour!(told));
    assert!(!is_behaviour!(Disguised));
    assert!(!is_behaviour!(honest.pipe(honest)));
    assert!(!is_behaviour!(honest.map(|()| ())));
    assert!(!is_behaviour!(told.with_input(3_u8)));
    assert!(!is_behaviour!((honest, honest).chain()));
    assert!(!is_behaviour!((honest, honest)));
    assert!(!is_behaviour!(honest.run_if(holds)));
    assert!(!is_behaviour!(IntoSystem::into_system(honest)));
    assert!(!is_behaviour!(Box::new(IntoSystem::into_system(honest)) as BoxedSystem));
    assert!(!is_behaviour!(|_: Commands| {}));
    assert!(!is_behaviour!(|_: Local<Spy>| {}));
}
