//! A gallery of behaviours that cheat, each refused for its reason, and of honest ones.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use naoisis::behaviour::barrier::{BarrierError, Breach};
use naoisis::communication::Inbox;
use naoisis::prelude::*;
use naoisis::robot::kick::KickPhase;
use naoisis::robot::{Roster, Velocity};
use naoisis::teams::Chaser;

#[derive(Component, Default)]
struct Mine;

#[derive(Component, Default)]
struct Memory(u32);

#[derive(Resource, Default)]
struct TeamTactics;

fn register<M>(system: impl IntoSystem<(), (), M>) -> Result<(), BarrierError> {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins).init_resource::<TeamTactics>();
    app.try_add_behaviour::<Mine, M>("under test", system).map(|_| ())
}

fn refusal<M>(system: impl IntoSystem<(), (), M>) -> Breach {
    register(system).expect_err("the behaviour should have been refused").reason
}

fn forbidden_component<M>(system: impl IntoSystem<(), (), M>) -> String {
    match refusal(system) {
        Breach::Forbidden { component, .. } => component,
        other => panic!("refused for another reason: {other}"),
    }
}

#[test]
fn sensors_commands_own_components_and_own_resources_are_allowed() {
    fn honest(
        pitch: Res<Pitch>,
        clock: Res<CycleClock>,
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
    assert_eq!(register(honest), Ok(()));
    // Reading the marker is as good as filtering by it.
    assert_eq!(register(|_: Query<(&Mine, &Percepts)>| {}), Ok(()));
}

#[test]
fn ground_truth_is_refused_and_named() {
    assert!(forbidden_component(|_: Query<&Pose, With<Mine>>| {}).ends_with("Pose"));
    assert!(forbidden_component(|_: Query<&mut Velocity, With<Mine>>| {}).ends_with("Velocity"));
    assert!(forbidden_component(|_: Query<(&Percepts, Option<&KickPhase>), With<Mine>>| {}).ends_with("KickPhase"));
    assert!(forbidden_component(|_: Query<(&Mine, Has<KickPhase>)>| {}).ends_with("KickPhase"));
    assert!(forbidden_component(|_: Query<&BallVelocity>| {}).ends_with("BallVelocity"));
    assert!(forbidden_component(|_: Res<Game>| {}).ends_with("Game"));
    assert!(forbidden_component(|_: Option<Res<CycleEvents>>| {}).ends_with("CycleEvents"));
    assert!(forbidden_component(|_: Res<Roster>| {}).ends_with("Roster"));
    assert!(forbidden_component(|_: Query<&mut Percepts, With<Mine>>| {}).ends_with("Percepts"));
    assert!(forbidden_component(|_: ResMut<CycleClock>| {}).ends_with("CycleClock"));
}

#[test]
fn truth_through_filters_change_detection_or_display_components_is_refused() {
    assert!(forbidden_component(|_: Query<Entity, With<Ball>>| {}).ends_with("Ball"));
    assert!(forbidden_component(|_: Query<&Percepts, (With<Mine>, Changed<Pose>)>| {}).ends_with("Pose"));
    assert!(forbidden_component(|_: Query<&Percepts, (With<Mine>, Without<Ball>)>| {}).ends_with("Ball"));
    assert!(forbidden_component(|_: Query<&Transform>| {}).ends_with("Transform"));
    assert!(forbidden_component(|_: Query<&GlobalTransform, With<Mine>>| {}).ends_with("GlobalTransform"));
}

#[test]
fn truth_inside_parameter_sets_and_custom_parameters_is_refused() {
    #[derive(SystemParam)]
    struct Sneaky<'w, 's> {
        balls: Query<'w, 's, &'static Pose, With<Mine>>,
    }
    fn sneaks(sneaky: Sneaky) {
        let _ = sneaky.balls.iter().count();
    }
    assert!(forbidden_component(sneaks).ends_with("Pose"));
    assert!(
        forbidden_component(|_: ParamSet<(Query<&mut WalkCommand, With<Mine>>, Query<&Pose>)>| {}).ends_with("Pose")
    );
}

#[test]
fn the_whole_world_whole_entities_and_deferred_commands_are_refused() {
    assert_eq!(refusal(|_: &mut World| {}), Breach::Exclusive);
    assert_eq!(refusal(|_: &World| {}), Breach::Unbounded);
    assert_eq!(refusal(|_: Query<EntityRef, With<Mine>>| {}), Breach::Unbounded);
    assert_eq!(refusal(|_: Query<EntityMut, With<Mine>>| {}), Breach::Unbounded);
    assert_eq!(refusal(|_: Commands| {}), Breach::Deferred);
}

#[test]
fn other_robots_can_neither_be_read_nor_steered() {
    let foreign = refusal(|_: Query<&mut WalkCommand>| {});
    assert!(matches!(foreign, Breach::ForeignRobots { .. }), "{foreign}");
    let foreign = refusal(|_: Query<(&RobotId, &Percepts), Without<Mine>>| {});
    assert!(matches!(foreign, Breach::ForeignRobots { .. }), "{foreign}");
    // Nor can they be told anything by what is drawn for people.
    let foreign = refusal(|_: Query<&Drawings>| {});
    assert!(matches!(foreign, Breach::ForeignRobots { .. }), "{foreign}");
    let foreign = refusal(|_: Query<&mut Drawings, Without<Mine>>| {});
    assert!(matches!(foreign, Breach::ForeignRobots { .. }), "{foreign}");
    // A marker behind an `Or` is no marker.
    let foreign = refusal(|_: Query<&Percepts, Or<(With<Mine>, With<Memory>)>>| {});
    assert!(matches!(foreign, Breach::ForeignRobots { .. }), "{foreign}");
}

#[test]
fn a_marker_that_others_carry_is_no_marker() {
    fn spies(_: Query<(&mut WalkCommand, &Inbox)>) {}
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    let reason = |result: Result<&mut App, BarrierError>| result.err().map(|error| error.reason);
    for reason in [
        reason(app.try_add_behaviour::<Percepts, _>("spy", spies)),
        reason(app.try_add_behaviour::<WalkCommand, _>("spy", spies)),
        reason(app.try_add_behaviour::<Ball, _>("spy", spies)),
        reason(app.try_add_behaviour::<Chaser, _>("spy", |_: Query<&Inbox, With<Chaser>>| {})),
    ] {
        assert!(matches!(reason, Some(Breach::NoMarker { .. })), "{reason:?}");
    }
}

#[test]
fn a_name_is_given_once() {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    // Of a built-in behaviour, which the teams go on to use.
    let error = app.try_add_behaviour::<Mine, _>("keeper", |_: Query<&Percepts, With<Mine>>| {}).err().unwrap();
    assert_eq!(error.reason, Breach::NameTaken);
    // The marker is free for another name.
    assert!(app.try_add_behaviour::<Mine, _>("mine", |_: Query<&Percepts, With<Mine>>| {}).is_ok());
    let again = app.try_add_behaviour::<Mine, _>("mine", |_: Query<&Percepts, With<Mine>>| {});
    assert_eq!(again.err().unwrap().reason, Breach::NameTaken);
}

#[test]
fn parameters_that_build_themselves_from_the_world_find_nothing_and_leave_nothing() {
    struct Spy<const KIND: u8>;
    impl<const KIND: u8> FromWorld for Spy<KIND> {
        fn from_world(world: &mut World) -> Self {
            fn copies(poses: Query<&Pose>) {
                let _ = poses.iter().count();
            }
            match KIND {
                0 => {
                    world.get_resource_or_init::<Schedules>().add_systems(Cycle, copies);
                }
                1 => {
                    world.add_observer(|_: On<Insert, Pose>| {});
                }
                2 => {
                    world.register_component_hooks::<Pose>().on_insert(|_, _| {});
                }
                _ => {}
            }
            Spy
        }
    }
    fn with_local<const KIND: u8>(_: Local<Spy<KIND>>) {}
    assert_eq!(refusal(with_local::<0>), Breach::Accomplice);
    assert_eq!(refusal(with_local::<1>), Breach::Accomplice);
    assert_eq!(refusal(with_local::<2>), Breach::Accomplice);
    assert_eq!(register(with_local::<3>), Ok(()), "a memory that builds itself is fine");

    let mut app = crate::support::headless_app();
    app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
    let late = app.try_add_behaviour::<Mine, _>("late", |_: Local<u8>| {}).err().map(|error| error.reason);
    assert_eq!(late, Some(Breach::MatchIsOn));
}

#[test]
fn hooks_of_a_marker_or_of_what_comes_with_it_are_refused() {
    use bevy::ecs::lifecycle::HookContext;
    use bevy::ecs::world::DeferredWorld;

    fn looks_around(world: DeferredWorld, context: HookContext) {
        let _ = world.get::<Pose>(context.entity);
    }
    #[derive(Component, Default)]
    #[component(on_add = looks_around)]
    struct Hooked;
    #[derive(Component, Default)]
    #[require(Hooked)]
    struct WithHooked;

    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    for refused in [
        app.try_add_behaviour::<Hooked, _>("hooked", |_: Local<u8>| {}).err(),
        app.try_add_behaviour::<WithHooked, _>("with hooked", |_: Local<u8>| {}).err(),
    ] {
        match refused.map(|error| error.reason) {
            Some(Breach::Hooks { component }) => assert!(component.ends_with("::Hooked"), "{component}"),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn the_engines_own_resources_and_relationships_lead_nowhere() {
    assert!(forbidden_component(|_: ResMut<Schedules>| {}).ends_with("Schedules"));
    assert!(forbidden_component(|_: Res<AppTypeRegistry>| {}).ends_with("AppTypeRegistry"));
    assert_eq!(register(|_: Res<Time>| {}), Ok(()));
    // A child's or parent's truth is as forbidden as the robot's own.
    fn climbs(children: Query<&Children, With<Mine>>, poses: Query<&Pose>) {
        let _ = children.iter().flatten().filter_map(|child| poses.get(*child).ok()).count();
    }
    assert!(forbidden_component(climbs).ends_with("Pose"));
}

#[test]
fn the_error_reads_well() {
    fn peeks(_: Query<&Pose, With<Mine>>) {}
    let message = register(peeks).unwrap_err().to_string();
    assert!(message.starts_with("behaviour `under test` is refused: its system `"), "{message}");
    assert!(message.contains("peeks") && message.contains("reads `naoisis::geometry::Pose`, which is ground truth"));
    let message = register(|_: Query<&mut WalkCommand>| {}).unwrap_err().to_string();
    assert!(message.contains("add `With<it::barrier::Mine>` to the query's filter"), "{message}");
}

#[test]
fn every_component_and_resource_of_the_simulation_says_what_it_is() {
    let mut app = crate::support::headless_app();
    app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
    app.run_cycles(3);
    let world = app.world();
    let registry = world.resource::<AppTypeRegistry>().read();
    let unmarked: Vec<String> = world
        .components()
        .iter_registered()
        .filter(|info| info.name().to_string().starts_with("naoisis::"))
        .filter(|info| {
            let mark = info.type_id().and_then(|type_id| Knowledge::of_type(&registry, type_id));
            mark.is_none()
        })
        .map(|info| info.name().to_string())
        // The graphics card, where the program can use one.
        .filter(|name| name != "naoisis::sensing::camera::gpu::GpuCameras")
        .collect();
    // These are no part of a match's state. The registry of behaviours holds functions, which cannot be reflected; the
    // number of threads is the machine's.
    let expected = ["naoisis::sensing::jobs::SensingThreads", "naoisis::behaviour::BehaviourRegistry"];
    assert_eq!(unmarked, expected);
}
