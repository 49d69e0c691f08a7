//! A match in an app of a user's own: run by a schedule, started and ended by commands, heard of by observers.

use bevy::app::PluginGroupBuilder;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use naoisis::ball::BallPlugin;
use naoisis::behaviour::BehaviourPlugin;
use naoisis::behaviour::barrier::Breach;
use naoisis::belief::SimpleBeliefPlugin;
use naoisis::collision::CollisionPlugin;
use naoisis::communication::CommunicationPlugin;
use naoisis::cycle::CyclePlugin;
use naoisis::events::EventsPlugin;
use naoisis::pitch::PitchPlugin;
use naoisis::prelude::*;
use naoisis::referee::RefereePlugin;
use naoisis::robot::RobotPlugin;
use naoisis::sensing::SensingPlugin;
use naoisis::simulation::invariants::InvariantPlugin;
use naoisis::simulation::rules::CustomRulesPlugin;
use naoisis::simulation::{MatchEntity, MatchPlugin, is_over, start_match};
use naoisis::teams::BuiltInTeamsPlugin;

use crate::support::{blue, headless_app};

/// What observers have heard, in words.
#[derive(Resource, Default)]
struct Heard(Vec<String>);

impl Heard {
    fn say(&mut self, words: impl Into<String>) {
        self.0.push(words.into());
    }
}

fn observe_all(app: &mut App) {
    app.init_resource::<Heard>()
        .add_observer(|_: On<MatchStarted>, mut heard: ResMut<Heard>| heard.say("started"))
        .add_observer(|not: On<MatchNotStarted>, mut heard: ResMut<Heard>| heard.say(not.fault.to_string()))
        .add_observer(|end: On<MatchEnded>, mut heard: ResMut<Heard>| heard.say(format!("{:?}", end.reason)))
        .add_observer(|goal: On<GoalScored>, mut heard: ResMut<Heard>| heard.say(format!("goal {}", goal.team)))
        .add_observer(|kick: On<Kicked>, mut heard: ResMut<Heard>| heard.say(format!("kick {}", kick.robot)))
        .add_observer(|fall: On<Fell>, mut heard: ResMut<Heard>| heard.say(format!("fall {}", fall.robot)))
        .add_observer(|penalty: On<Penalised>, mut heard: ResMut<Heard>| {
            heard.say(format!("penalty {}", penalty.robot));
        });
}

fn heard(app: &mut App) -> Vec<String> {
    core::mem::take(&mut app.world_mut().resource_mut::<Heard>().0)
}

/// A running app in which each frame lasts as long as a step of the fixed main loop.
fn running_app(plugins: PluginGroupBuilder) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, plugins)).insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    observe_all(&mut app);
    app
}

fn update(app: &mut App, frames: usize) {
    for _ in 0..frames {
        app.update();
    }
}

fn command(app: &mut App, give: impl FnOnce(&mut Commands)) {
    give(&mut app.world_mut().commands());
    app.world_mut().flush();
}

fn short_match(duration_s: f32) -> Scenario {
    Scenario { duration_s: Some(duration_s), ..Scenario::named("match3v3").unwrap() }
}

#[test]
fn a_schedule_runs_the_match_until_its_time_is_over() {
    let mut app = running_app(NaoisisPlugins::in_schedule(FixedUpdate));
    command(&mut app, |commands| {
        commands.start_match(Scenario { cycle_s: 0.02, ..short_match(0.5) });
    });
    update(&mut app, 3);
    assert_eq!(heard(&mut app), ["started"]);
    assert_eq!(app.world().resource::<Time<Fixed>>().timestep().as_secs_f64(), 0.02);
    update(&mut app, 40);
    assert_eq!(heard(&mut app), ["TimeOver"]);
    assert!(app.cycle() == 25 && is_over(app.world()));
    // What it ended with stays, until it is taken away.
    assert!(app.ball().is_some());
    command(&mut app, |commands| {
        commands.end_match();
    });
    assert!(app.ball().is_none() && app.robot_pose(blue(1)).is_none() && heard(&mut app).is_empty());
    let mut left = app.world_mut().query_filtered::<(), With<MatchEntity>>();
    assert_eq!(left.iter(app.world()).count(), 0);
}

#[test]
fn a_match_in_a_schedule_is_that_of_an_owner_who_runs_it() {
    let mut app = running_app(NaoisisPlugins::in_schedule(Update));
    app.start_match(&short_match(10.0)).unwrap();
    update(&mut app, 300);
    let mut owned = headless_app();
    owned.start_match(&short_match(10.0)).unwrap().run_cycles(300);
    assert_eq!((app.cycle(), app.ball(), app.ball_velocity()), (300, owned.ball(), owned.ball_velocity()));
}

#[test]
fn a_scenario_with_an_error_is_heard_of_and_the_match_goes_on() {
    let mut app = running_app(NaoisisPlugins::in_schedule(FixedUpdate));
    app.start_match(&short_match(10.0)).unwrap();
    update(&mut app, 3);
    let wrong = Scenario::from_json(r#"{ "robots": [{ "behaviour": "nobody" }] }"#).unwrap();
    command(&mut app, |commands| {
        commands.start_match(wrong);
    });
    update(&mut app, 3);
    let heard = heard(&mut app);
    assert!(heard.len() == 2 && heard[1].contains("there is no behaviour `nobody`"), "{heard:?}");
    assert!(app.cycle() >= 4);
    app.end_match();
    assert_eq!(app.world().resource::<Heard>().0, ["Removed"]);
}

#[test]
fn observers_hear_what_happened_in_its_order_and_the_final_whistle_once() {
    let mut scenario = Scenario::named("match3v3").unwrap();
    (scenario.rules.half_s, scenario.duration_s) = (120.0, None);
    let mut app = headless_app();
    observe_all(&mut app);
    app.start_match(&scenario).unwrap();
    let mut expected = vec!["started".to_owned()];
    let ended = app.run_until(30_000, |app| {
        expected.extend(app.events().iter().filter_map(|event| match event {
            MatchEvent::Goal { team, .. } => Some(format!("goal {team}")),
            MatchEvent::Kick { robot, launch_speed_mps: Some(_), .. } => Some(format!("kick {robot}")),
            MatchEvent::Fall { robot, .. } => Some(format!("fall {robot}")),
            MatchEvent::Penalty { robot, .. } => Some(format!("penalty {robot}")),
            MatchEvent::FinalWhistle => Some("FinalWhistle".to_owned()),
            _ => None,
        }));
        app.is_finished()
    });
    assert!(ended);
    app.end_match();
    let heard = heard(&mut app);
    assert_eq!(heard, expected);
    for kind in ["goal", "kick", "penalty", "FinalWhistle"] {
        assert!(heard.iter().any(|words| words.starts_with(kind)), "no {kind} in {heard:?}");
    }
}

#[test]
fn an_observer_of_one_robot_hears_of_that_one_and_may_start_the_next_match() {
    #[derive(Resource, Default)]
    struct Kicks(u32);

    let scenario = Scenario::named("kick_right_straight").unwrap();
    let mut app = headless_app();
    app.init_resource::<Kicks>();
    app.start_match(&scenario).unwrap();
    let mut robots = app.world_mut().query_filtered::<Entity, With<RobotId>>();
    let kicker = robots.single(app.world()).unwrap();
    let again = scenario.clone();
    app.world_mut().entity_mut(kicker).observe(
        move |_: On<Kicked>, mut kicks: ResMut<Kicks>, mut commands: Commands| {
            kicks.0 += 1;
            commands.start_match(again.clone());
        },
    );
    // The robot of the next match is another one, which nobody observes.
    app.run_cycles(60);
    assert_eq!(app.world().resource::<Kicks>().0, 1);
    assert!((1..60).contains(&app.cycle()));
}

#[test]
fn a_plugin_that_is_left_out_makes_no_app_panic() {
    let plugins = || NaoisisPlugins.build();
    let without: [(&str, PluginGroupBuilder, Option<&str>); 15] = [
        ("CyclePlugin", plugins().disable::<CyclePlugin>(), Some("CyclePlugin")),
        ("EventsPlugin", plugins().disable::<EventsPlugin>(), Some("EventsPlugin")),
        ("MatchPlugin", plugins().disable::<MatchPlugin>(), Some("MatchPlugin")),
        ("CustomRulesPlugin", plugins().disable::<CustomRulesPlugin>(), Some("CustomRulesPlugin")),
        ("PitchPlugin", plugins().disable::<PitchPlugin>(), None),
        ("RobotPlugin", plugins().disable::<RobotPlugin>(), Some("RobotPlugin")),
        ("BallPlugin", plugins().disable::<BallPlugin>(), None),
        ("CollisionPlugin", plugins().disable::<CollisionPlugin>(), Some("CollisionPlugin")),
        ("SensingPlugin", plugins().disable::<SensingPlugin>(), Some("there is no team `roles`")),
        ("CommunicationPlugin", plugins().disable::<CommunicationPlugin>(), Some("there is no team `roles`")),
        ("BehaviourPlugin", plugins().disable::<BehaviourPlugin>(), Some("BehaviourPlugin")),
        ("RefereePlugin", plugins().disable::<RefereePlugin>(), Some("RefereePlugin")),
        ("InvariantPlugin", plugins().disable::<InvariantPlugin>(), None),
        ("SimpleBeliefPlugin", plugins().disable::<SimpleBeliefPlugin>(), Some("there is no team `roles`")),
        ("BuiltInTeamsPlugin", plugins().disable::<BuiltInTeamsPlugin>(), Some("there is no team `roles`")),
    ];
    let teams = Scenario::named("match3v3").unwrap();
    let scripted = Scenario::named("kick_right_straight").unwrap();
    for (name, plugins, expected) in without {
        let mut app = App::new();
        app.add_plugins(plugins);
        let refusal = start_match(app.world_mut(), &teams).err().map(|fault| fault.to_string());
        match (&refusal, expected) {
            (None, None) => {}
            (Some(refusal), Some(expected)) if refusal.contains(expected) => {}
            _ => panic!("without {name}: {refusal:?}"),
        }
        // Where only the teams are missing, other robots play.
        let starts = expected.is_none_or(|expected| expected.contains("team"));
        assert_eq!(app.start_match(&scripted).is_ok(), starts, "without {name}");
        if starts {
            app.run_cycles(60);
        }
    }
}

#[test]
fn an_app_without_the_simulation_is_told_what_it_lacks() {
    #[derive(Component, Default)]
    struct Walker;

    fn walk(mut robots: Query<&mut WalkCommand, With<Walker>>) {
        for mut walk in &mut robots {
            *walk = WalkCommand::new(0.1, 0.0, 0.0);
        }
    }
    let mut app = App::new();
    let refusal = app.try_add_behaviour::<Walker, _>("walker", walk).err().unwrap();
    assert_eq!(refusal.reason, Breach::NoSimulation);
    assert!(refusal.to_string().contains("add the `NaoisisPlugins` before"), "{refusal}");
    let fault = app.start_match(&Scenario::default()).err().unwrap();
    assert!(fault.to_string().contains("the app has no `NaoisisPlugins`"), "{fault}");
    // As `main` and tests that return it print it.
    assert_eq!((format!("{fault:?}"), format!("{refusal:?}")), (fault.to_string(), refusal.to_string()));
    app.add_plugins(NaoisisPlugins).add_behaviour::<Walker, _>("walker", walk);
    app.start_match(&Scenario::default()).unwrap();
}
