//! What ties a behaviour to its robots is its own, and brings nothing along that sees more.

use super::*;
use bevy::ecs::component::{ComponentId, Mutable, RequiredComponentsRegistrator, StorageType};
use bevy::ecs::world::CommandQueue;
use core::time::Duration;
use naoisis::behaviour::Idle;
use naoisis::belief::{Belief, SimpleBelief};
use naoisis::sensing::camera::CameraSettings;
use naoisis::teams::Chaser;

/// A sensor of the program's own, which all robots may have.
#[derive(Component, Default, Reflect)]
#[reflect(Component, @Knowledge::Sensor)]
struct Hearing(bool);

#[test]
fn a_marker_that_others_carry_is_no_marker() {
    fn spies(_: Query<(&mut WalkCommand, &Inbox)>) {}
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins).register_type::<Hearing>();
    let reason = |result: Result<&mut App, BarrierError>| result.err().map(|error| error.reason);
    for reason in [
        reason(app.try_add_behaviour::<Percepts, _>("spy", spies)),
        reason(app.try_add_behaviour::<WalkCommand, _>("spy", spies)),
        reason(app.try_add_behaviour::<Ball, _>("spy", spies)),
        reason(app.try_add_behaviour::<SimpleBelief, _>("spy", spies)),
        reason(app.try_add_behaviour::<CycleClock, _>("spy", spies)),
        reason(app.try_add_behaviour::<Name, _>("spy", spies)),
        reason(app.try_add_behaviour::<Transform, _>("spy", spies)),
        reason(app.try_add_behaviour::<Hearing, _>("spy", spies)),
        reason(app.try_add_behaviour::<Chaser, _>("spy", |_: Query<&Inbox, With<Chaser>>| {})),
        // A behaviour cannot steer robots that do nothing.
        reason(app.try_add_behaviour::<Idle, _>("spy", |_: Query<&mut WalkCommand, With<Idle>>| {})),
    ] {
        assert!(matches!(reason, Some(Breach::NoMarker { .. })), "{reason:?}");
    }
}

#[test]
fn hooks_of_a_marker_or_of_what_comes_with_it_are_refused() {
    #[derive(Component, Default)]
    #[component(on_insert = looks_around)]
    struct OnInsert;
    #[derive(Component, Default)]
    #[component(on_discard = looks_around)]
    struct OnDiscard;
    #[derive(Component, Default)]
    #[component(on_remove = looks_around)]
    struct OnRemove;
    #[derive(Component, Default)]
    #[component(on_despawn = looks_around)]
    struct OnDespawn;
    #[derive(Component, Default)]
    #[require(Between)]
    struct FarAway;
    #[derive(Component, Default)]
    #[require(Mole)]
    struct Between;
    #[derive(Component)]
    #[relationship(relationship_target = Followers)]
    struct Follows(Entity);
    impl Default for Follows {
        fn default() -> Self {
            Follows(Entity::PLACEHOLDER)
        }
    }
    #[derive(Component, Default)]
    #[relationship_target(relationship = Follows)]
    struct Followers(Vec<Entity>);
    /// Says nothing until it is asked, and then not in the attribute.
    #[derive(Default)]
    struct ByHand;
    impl Component for ByHand {
        const STORAGE_TYPE: StorageType = StorageType::SparseSet;
        type Mutability = Mutable;
        fn register_required_components(_: ComponentId, required: &mut RequiredComponentsRegistrator) {
            required.register_required::<Mole>(Mole::default);
        }
    }

    fn hooked<Marker: Component + Default>() -> String {
        match register_with::<Marker, _>(|_: Local<u8>| {}).unwrap_err().reason {
            Breach::Hooks { component } => component.rsplit("::").next().unwrap_or_default().to_owned(),
            other => panic!("refused for another reason: {other}"),
        }
    }
    assert_eq!(hooked::<Mole>(), "Mole");
    assert_eq!(hooked::<OnInsert>(), "OnInsert");
    assert_eq!(hooked::<OnDiscard>(), "OnDiscard");
    assert_eq!(hooked::<OnRemove>(), "OnRemove");
    assert_eq!(hooked::<OnDespawn>(), "OnDespawn");
    assert_eq!(hooked::<FarAway>(), "Mole");
    assert_eq!(hooked::<Follows>(), "Follows");
    assert_eq!(hooked::<Followers>(), "Followers");
    assert_eq!(hooked::<ByHand>(), "Mole");
}

#[test]
fn a_marker_brings_beliefs_commands_and_what_is_its_own() {
    /// The engine would hand the world to what it finds in such a queue.
    fn queue() -> DelayedCommandQueue {
        let mut queue = CommandQueue::default();
        queue.push(|world: &mut World| {
            let _ = world.query::<&Pose>().iter(world).count();
        });
        DelayedCommandQueue { submit_at: Duration::ZERO, queue }
    }
    #[derive(Component, Default)]
    #[require(DelayedCommandQueue = queue())]
    struct Delayed;
    #[derive(Component, Default)]
    #[require(Observer = Observer::new(|_: On<Insert, Pose>| {}))]
    struct Observing;
    #[derive(Component, Default)]
    #[require(Ball)]
    struct Round;
    #[derive(Component, Default)]
    #[require(Pose)]
    struct Placed;
    #[derive(Component, Default)]
    #[require(CameraSettings = CameraSettings { every_cycles: 1, ..default() })]
    struct SeesMore;
    #[derive(Component, Default)]
    #[require(Hearing)]
    struct HearsMore;
    #[derive(Component, Default)]
    #[require(Name)]
    struct Named;
    #[derive(Resource, Default)]
    struct Known;
    #[derive(Component, Default)]
    #[require(Belief, SimpleBelief, Drawings, Memory)]
    struct Honest;

    fn brought<Marker: Component + Default>() -> String {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins).register_type::<Hearing>();
        let error = app.try_add_behaviour::<Marker, _>("under test", |_: Local<u8>| {}).err().unwrap();
        match error.reason {
            Breach::RequiresForbidden { component, .. } | Breach::Hooks { component } => {
                component.rsplit("::").next().unwrap_or_default().to_owned()
            }
            other => panic!("refused for another reason: {other}"),
        }
    }
    assert_eq!(brought::<Delayed>(), "DelayedCommandQueue");
    assert_eq!(brought::<Observing>(), "Observer");
    assert_eq!(brought::<Round>(), "Ball");
    assert_eq!(brought::<Placed>(), "Pose");
    assert_eq!(brought::<SeesMore>(), "CameraSettings");
    assert_eq!(brought::<HearsMore>(), "Hearing");
    assert_eq!(brought::<Named>(), "Name");
    assert_eq!(brought::<Known>(), "IsResource");
    assert_eq!(register_with::<Honest, _>(|_: Query<&Belief, With<Honest>>| {}), Ok(()));
}
