//! A gallery of behaviours that cheat, each refused for its reason, and of honest ones.
//!
//! What [parameters] a behaviour may have, the compiler decides. What those parameters access is looked at when it is
//! registered, and so is what its [marker](markers) brings along.

mod markers;
mod parameters;

use bevy::app::AppExit;
use bevy::ecs::archetype::Archetype;
use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::query::{NestedQuery, QueryData, QueryFilter, SpawnDetails, Spawned};
use bevy::ecs::resource::IsResource;
use bevy::ecs::world::{DeferredWorld, EntityMutExcept, EntityRefExcept};
use bevy::prelude::*;
use bevy::time::{DelayedCommandQueue, TimeUpdateStrategy};
use naoisis::behaviour::IntoBehaviour;
use naoisis::behaviour::barrier::{BarrierError, Breach};
use naoisis::communication::Inbox;
use naoisis::game::{Game, Rules};
use naoisis::knowledge::{Knowledge, is_of_naoisis};
use naoisis::pitch::Pitch;
use naoisis::prelude::*;
use naoisis::robot::kick::KickPhase;
use naoisis::robot::{Roster, Velocity};

#[derive(Component, Default)]
struct Mine;

#[derive(Component, Default)]
struct Memory(u32);

#[derive(Resource, Default)]
struct TeamTactics;

fn register<M>(system: impl IntoBehaviour<M>) -> Result<(), BarrierError> {
    register_with::<Mine, M>(system)
}

fn register_with<Marker: Component + Default, M>(system: impl IntoBehaviour<M>) -> Result<(), BarrierError> {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins).init_resource::<TeamTactics>();
    app.try_add_behaviour::<Marker, M>("under test", system).map(|_| ())
}

fn refusal<M>(system: impl IntoBehaviour<M>) -> Breach {
    register(system).expect_err("the behaviour should have been refused").reason
}

fn forbidden_component<M>(system: impl IntoBehaviour<M>) -> String {
    match refusal(system) {
        Breach::Forbidden { component, .. } => component,
        other => panic!("refused for another reason: {other}"),
    }
}

/// Sees the world when it comes to a robot.
#[derive(Component, Default)]
#[component(on_add = looks_around)]
struct Mole;

fn looks_around(world: DeferredWorld, context: HookContext) {
    let _ = world.get::<Pose>(context.entity);
}

#[test]
fn sensors_commands_own_components_and_own_resources_are_allowed() {
    #[derive(QueryData)]
    #[query_data(mutable)]
    struct Robot {
        percepts: &'static Percepts,
        inbox: &'static Inbox,
        walk: &'static mut WalkCommand,
        memory: Option<&'static mut Memory>,
    }
    #[derive(QueryFilter)]
    struct Ours {
        _mine: With<Mine>,
        _heard: Changed<Inbox>,
    }
    fn honest(
        (pitch, clock): (Res<Pitch>, Res<CycleClock>),
        mut tactics: ResMut<TeamTactics>,
        mut memory: Local<u64>,
        mut robots: Query<(&Percepts, &Inbox, &mut WalkCommand, &mut KickCommand, Option<&mut Memory>), With<Mine>>,
    ) {
        *memory += clock.cycle;
        let _ = (&mut *tactics, pitch.length_m);
        for (percepts, inbox, mut walk, mut kick, own) in &mut robots {
            walk.dx = percepts.goal_posts.len() as f32 + inbox.0.len() as f32;
            kick.0 = None;
            if let Some(mut own) = own {
                own.0 += 1;
            }
        }
    }
    fn with_names(mut robots: Query<Robot, Ours>) {
        for mut robot in &mut robots {
            robot.walk.dx = (robot.percepts.goal_posts.len() + robot.inbox.0.len()) as f32;
            if let Some(memory) = &mut robot.memory {
                memory.0 += 1;
            }
        }
    }
    fn of_any<T: Component>(_: Query<&T, With<Mine>>) {}
    assert_eq!(register(honest), Ok(()));
    assert_eq!(register(with_names), Ok(()));
    assert_eq!(register(of_any::<Percepts>), Ok(()));
    // Reading the marker is as good as filtering by it.
    assert_eq!(register(|_: Query<(&Mine, &Percepts)>| {}), Ok(()));
    assert_eq!(register(|_: Query<(&mut Mine, Entity, Ref<Percepts>, Has<Memory>)>| {}), Ok(()));
    assert_eq!(register(|_: Query<AnyOf<(&Percepts, &Inbox)>, (With<Mine>, Without<Memory>)>| {}), Ok(()));
    assert_eq!(register(|_: Query<NestedQuery<&Percepts, With<Mine>>, With<Mine>>| {}), Ok(()));
    assert_eq!(register(|_: Single<(&Percepts, &mut WalkCommand), With<Mine>>| {}), Ok(()));
    assert_eq!(register(|_: Option<Res<TeamTactics>>, _: If<Res<Rules>>| {}), Ok(()));
    assert_eq!(register(|_: Query<&TeamTactics, With<IsResource>>| {}), Ok(()));
    assert_eq!(
        register(|_: ParamSet<(Query<&mut WalkCommand, With<Mine>>, Query<&mut WalkCommand, With<Mine>>)>| {}),
        Ok(())
    );
    assert_eq!(register(|_: Query<&Percepts, With<Mine>>| -> Result { Ok(()) }), Ok(()));
    assert_eq!(register(|_: Res<Time>, _: Res<Time<Virtual>>, _: Res<Time<Fixed>>| {}), Ok(()));
}

#[test]
fn ground_truth_is_refused_and_named() {
    assert!(forbidden_component(|_: Query<&Pose, With<Mine>>| {}).ends_with("Pose"));
    assert!(forbidden_component(|_: Query<&mut Velocity, With<Mine>>| {}).ends_with("Velocity"));
    assert!(forbidden_component(|_: Query<(&Percepts, Option<&KickPhase>), With<Mine>>| {}).ends_with("KickPhase"));
    assert!(forbidden_component(|_: Query<(&Mine, Has<KickPhase>)>| {}).ends_with("KickPhase"));
    assert!(forbidden_component(|_: Query<(&Mine, Ref<Pose>)>| {}).ends_with("Pose"));
    assert!(forbidden_component(|_: Query<(&Mine, Mut<Pose>)>| {}).ends_with("Pose"));
    assert!(forbidden_component(|_: Query<(&Mine, AnyOf<(&Percepts, &Pose)>)>| {}).ends_with("Pose"));
    assert!(forbidden_component(|_: Query<&BallVelocity>| {}).ends_with("BallVelocity"));
    assert!(forbidden_component(|_: Single<&Pose, With<Mine>>| {}).ends_with("Pose"));
    assert!(forbidden_component(|_: Option<Single<&Pose, With<Ball>>>| {}).ends_with("Pose"));
    assert!(forbidden_component(|_: Populated<&Percepts, (With<Mine>, Changed<Pose>)>| {}).ends_with("Pose"));
    assert!(forbidden_component(|_: Res<Game>| {}).ends_with("Game"));
    assert!(forbidden_component(|_: If<Res<Game>>| {}).ends_with("Game"));
    assert!(forbidden_component(|_: (Res<Pitch>, (Res<Game>,))| {}).ends_with("Game"));
    assert!(forbidden_component(|_: Query<&Game, With<IsResource>>| {}).ends_with("Game"));
    assert!(forbidden_component(|_: Option<Res<CycleEvents>>| {}).ends_with("CycleEvents"));
    assert!(forbidden_component(|_: Res<Roster>| {}).ends_with("Roster"));
    assert!(forbidden_component(|_: Res<Scenario>| {}).ends_with("Scenario"));
    assert!(forbidden_component(|_: Query<&mut Percepts, With<Mine>>| {}).ends_with("Percepts"));
    assert!(forbidden_component(|_: ResMut<CycleClock>| {}).ends_with("CycleClock"));
}

#[test]
fn truth_through_filters_change_detection_or_display_components_is_refused() {
    assert!(forbidden_component(|_: Query<Entity, With<Ball>>| {}).ends_with("Ball"));
    assert!(forbidden_component(|_: Query<&Percepts, (With<Mine>, Changed<Pose>)>| {}).ends_with("Pose"));
    assert!(forbidden_component(|_: Query<&Percepts, (With<Mine>, Added<Pose>)>| {}).ends_with("Pose"));
    assert!(forbidden_component(|_: Query<&Percepts, (With<Mine>, Without<Ball>)>| {}).ends_with("Ball"));
    assert!(forbidden_component(|_: Query<&Mine, Or<(With<Ball>, With<Memory>)>>| {}).ends_with("Ball"));
    assert!(forbidden_component(|_: Query<&Transform>| {}).ends_with("Transform"));
    assert!(forbidden_component(|_: Query<&GlobalTransform, With<Mine>>| {}).ends_with("GlobalTransform"));
}

#[test]
fn truth_inside_parameter_sets_nested_queries_and_derived_data_is_refused() {
    #[derive(QueryData)]
    struct Sneaky {
        percepts: &'static Percepts,
        inner: Deeper,
    }
    #[derive(QueryData)]
    struct Deeper {
        pose: &'static Pose,
    }
    #[derive(QueryFilter)]
    struct Moved {
        _mine: With<Mine>,
        _pose: Changed<Pose>,
    }
    fn sneaks(robots: Query<Sneaky, With<Mine>>) {
        let _: Vec<_> = robots.iter().map(|robot| (robot.percepts.goal_posts.len(), *robot.inner.pose)).collect();
    }
    assert!(forbidden_component(sneaks).ends_with("Pose"));
    assert!(forbidden_component(|_: Query<&Percepts, Moved>| {}).ends_with("Pose"));
    assert!(
        forbidden_component(|_: ParamSet<(Query<&mut WalkCommand, With<Mine>>, Query<&Pose>)>| {}).ends_with("Pose")
    );
    assert!(forbidden_component(|_: Query<NestedQuery<&Pose, With<Mine>>, With<Mine>>| {}).ends_with("Pose"));
}

#[test]
fn whole_entities_are_refused() {
    assert_eq!(refusal(|_: Query<EntityRef, With<Mine>>| {}), Breach::Unbounded);
    assert_eq!(refusal(|_: Query<EntityMut, With<Mine>>| {}), Breach::Unbounded);
    assert_eq!(refusal(|_: Query<EntityRefExcept<Game>, With<Mine>>| {}), Breach::Unbounded);
    assert_eq!(refusal(|_: Query<EntityMutExcept<Mine>, With<Mine>>| {}), Breach::Unbounded);
    assert_eq!(refusal(|_: Query<Option<EntityRef>, With<Mine>>| {}), Breach::Unbounded);
}

#[test]
fn other_robots_can_neither_be_read_nor_steered_nor_counted() {
    let foreign = [
        refusal(|_: Query<&mut WalkCommand>| {}),
        refusal(|_: Query<(&RobotId, &Percepts), Without<Mine>>| {}),
        // Nor can they be told anything by what is drawn for people.
        refusal(|_: Query<&Drawings>| {}),
        refusal(|_: Query<&mut Drawings, Without<Mine>>| {}),
        // A marker behind an `Or` or an `Option` is no marker.
        refusal(|_: Query<&Percepts, Or<(With<Mine>, With<Memory>)>>| {}),
        refusal(|_: Query<(&Percepts, Option<&Mine>)>| {}),
        refusal(|_: Query<AnyOf<(&Percepts, &Mine)>>| {}),
        // Who is there at all, and where the engine keeps them.
        refusal(|_: Query<()>| {}),
        refusal(|_: Query<Entity>| {}),
        refusal(|_: Query<&Archetype>| {}),
        refusal(|_: Query<SpawnDetails>| {}),
        refusal(|_: Query<Entity, Without<Mine>>| {}),
        refusal(|_: Query<Has<Mine>>| {}),
        refusal(|_: Query<Entity, Spawned>| {}),
        refusal(|_: Query<(), Without<Memory>>| {}),
        // A component of one's own may be anybody's.
        refusal(|_: Query<&Memory>| {}),
        // A query in a query is one more.
        refusal(|_: Query<NestedQuery<&Percepts>, With<Mine>>| {}),
        refusal(|_: Query<NestedQuery<Entity>, With<Mine>>| {}),
        refusal(|_: Single<&Percepts>| {}),
        // Resources are entities, too.
        refusal(|_: Query<Entity, With<IsResource>>| {}),
        refusal(|_: Query<Option<&TeamTactics>, With<IsResource>>| {}),
        refusal(|_: Query<&Percepts, With<IsResource>>| {}),
        refusal(|_: Query<(&TeamTactics, &CycleClock), With<IsResource>>| {}),
        // And a condition is no better.
        refusal(behaviour(|| {}).run_if(|robots: Query<Entity>| robots.iter().count() > 12)),
    ];
    for breach in foreign {
        assert!(matches!(breach, Breach::ForeignRobots { .. }), "{breach}");
    }
}

#[test]
fn a_lens_shows_no_more_than_the_query_does() {
    /// What a behaviour finds out about its robots without naming a component: from them, and from the engine.
    #[derive(Resource, Default)]
    struct Found(Vec<(usize, usize, bool)>);
    fn looks(mut found: ResMut<Found>, mut robots: Query<&Percepts, With<Mine>>) {
        let number = robots.iter().count();
        let mut archetypes = robots.transmute_lens::<(&Archetype, Has<KickPhase>)>();
        for (archetype, kicks) in &archetypes.query() {
            found.0.push((number, archetype.entities().len(), kicks));
        }
    }
    fn looks_through(mut robots: Query<&Percepts, With<Mine>>) {
        let _ = robots.transmute_lens::<&Pose>();
    }
    fn play<M>(system: impl IntoBehaviour<M>) -> Result<App, naoisis::cycle::CyclePanic> {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins).init_resource::<Found>().add_behaviour::<Mine, _>("under test", system);
        let robots = r#"{ "robots": [
            { "number": 1, "behaviour": "under test" }, { "number": 2, "pose": [1, 0, 0], "behaviour": "under test" },
            { "number": 3, "pose": [2, 0, 0] } ] }"#;
        app.start_match(&Scenario::from_json(robots).unwrap()).unwrap();
        naoisis::cycle::try_run_cycle(app.world_mut()).map(|()| app)
    }
    let app = play(looks).unwrap();
    assert_eq!(app.world().resource::<Found>().0, [(2, 2, true); 2], "its own two robots, and that robots can kick");
    let panic = play(looks_through).err().unwrap();
    assert!(panic.message.contains("not allowed"), "{panic}");
}

#[test]
fn robots_have_the_same_components_from_the_first_cycle_to_the_last() {
    // As a lens can tell which ones its own robots have.
    let mut app = crate::support::headless_app();
    app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
    let components = |app: &mut App| {
        let mut robots = app.world_mut().query_filtered::<(&RobotId, &Archetype), With<RobotId>>();
        let robots = robots.iter(app.world()).map(|(id, archetype)| (*id, archetype.components().to_vec()));
        robots.collect::<std::collections::BTreeMap<_, _>>()
    };
    let before = components(&mut app);
    app.run_cycles(300);
    app.world_mut().commands().queue(Intervention::Penalise {
        robot: crate::support::blue(2),
        reason: default(),
        duration_s: Some(5.0),
    });
    app.world_mut().flush();
    app.run_cycles(600);
    assert_eq!(components(&mut app), before);
}

#[test]
fn the_engines_own_components_and_resources_lead_nowhere() {
    assert!(forbidden_component(|_: ResMut<Schedules>| {}).ends_with("Schedules"));
    assert!(forbidden_component(|_: Option<ResMut<Schedules>>| {}).ends_with("Schedules"));
    assert!(forbidden_component(|_: Res<AppTypeRegistry>| {}).ends_with("AppTypeRegistry"));
    assert!(forbidden_component(|_: Res<Messages<AppExit>>| {}).ends_with("AppExit>"));
    assert!(forbidden_component(|_: ResMut<Time<Virtual>>| {}).contains("Virtual"));
    assert!(forbidden_component(|_: Res<TimeUpdateStrategy>| {}).ends_with("TimeUpdateStrategy"));
    assert!(forbidden_component(|_: Query<(&Mine, &mut DelayedCommandQueue)>| {}).ends_with("DelayedCommandQueue"));
    assert!(forbidden_component(|_: Query<(&Mine, &Name)>| {}).ends_with("Name"));
    assert!(forbidden_component(|_: Query<(&Mine, &Observer)>| {}).ends_with("Observer"));
    assert!(forbidden_component(|_: Query<&Mine, Allow<Disabled>>| {}).ends_with("Disabled"));
    // Who is whose child, and where.
    assert!(forbidden_component(|_: Query<&Children, With<Mine>>| {}).ends_with("Children"));
    assert!(forbidden_component(|_: Query<&ChildOf, With<Mine>>| {}).ends_with("ChildOf"));
}

#[test]
fn a_condition_is_under_the_same_barrier() {
    fn peeks(balls: Query<&Pose, With<Ball>>) -> bool {
        balls.iter().any(|pose| pose.position.x > 0.0)
    }
    let error = register(behaviour(|_: Query<&Percepts, With<Mine>>| {}).run_if(peeks)).unwrap_err();
    assert!(error.system.ends_with("peeks"), "{error}");
    assert!(matches!(error.reason, Breach::Forbidden { .. }), "{error}");
    let secret = behaviour(|| {}).run_if(|| true).run_if(|game: Res<Game>| game.half == 2);
    assert!(forbidden_component(secret).ends_with("Game"));
    assert!(forbidden_component(behaviour(|| {}).run_if(resource_exists::<Game>)).ends_with("Game"));

    let sees_ball = |robots: Query<&Percepts, With<Mine>>| robots.iter().any(|percepts| percepts.ball.is_some());
    assert_eq!(register(behaviour(|| {}).run_if(sees_ball).run_if(resource_exists::<TeamTactics>)), Ok(()));
}

#[test]
fn the_error_reads_well() {
    fn peeks(_: Query<&Pose, With<Mine>>) {}
    let message = register(peeks).unwrap_err().to_string();
    assert!(message.starts_with("behaviour `under test` is refused: its system `"), "{message}");
    assert!(
        message.contains("peeks") && message.contains("reads `naoisis_core::geometry::Pose`, which is ground truth")
    );
    assert!(message.contains("a behaviour reads from `Percepts` and `Belief`"), "{message}");
    let message = register(|_: Query<&mut WalkCommand>| {}).unwrap_err().to_string();
    assert!(
        message.contains("finds `naoisis_core::robot::walk_command::WalkCommand` of entities that need not be"),
        "{message}"
    );
    assert!(message.contains("add `With<it::barrier::Mine>` to the query's filter"), "{message}");
    let message = register(|_: Query<Entity>| {}).unwrap_err().to_string();
    assert!(message.contains("finds something of entities that need not be its own robots"), "{message}");
}

#[test]
fn every_component_and_resource_of_the_simulation_says_what_it_is() {
    let mut app = crate::support::headless_app();
    app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
    app.run_cycles(3);
    let world = app.world();
    let registry = world.resource::<AppTypeRegistry>().read();
    let mut unmarked: Vec<String> = world
        .components()
        .iter_registered()
        .filter(|info| is_of_naoisis(&info.name().to_string()))
        .filter(|info| {
            let mark = info.type_id().and_then(|type_id| Knowledge::of_type(&registry, type_id));
            mark.is_none()
        })
        .map(|info| info.name().to_string())
        .collect();
    // These are no part of a match's state. The registries hold functions, which cannot be reflected; the graphics card
    // and the number of threads are the machine's; who records, and what people look at, is the program's choice, as is which
    // robots need no senses and no behaviour.
    unmarked.sort();
    let expected = [
        "naoisis_core::behaviour::BehaviourRegistry",
        "naoisis_core::behaviour::WithoutBehaviour",
        "naoisis_core::referee::custom_rules::CustomRules",
        "naoisis_sensing::sensing::camera::GpuCameras",
        "naoisis_sensing::sensing::jobs::SensingThreads",
        "naoisis_sensing::sensing::scene::SensesNothing",
        "naoisis_sensing::sensing::vision::missed::Unrecognised",
        "naoisis_sim::simulation::rules::RuleRegistry",
        "naoisis_sim::simulation::sensors::ReadingsAreRecorded",
        "naoisis_sim::simulation::sensors::SensorRegistry",
    ];
    assert_eq!(unmarked, expected);
}
