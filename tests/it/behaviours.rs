//! Behaviours among each other: their names, their turns, their conditions; and teams of them.

use bevy::prelude::*;
use naoisis::behaviour::barrier::Breach;
use naoisis::prelude::*;
use naoisis::teams::Chaser;
use std::sync::{Arc, Mutex};

use crate::support::{blue, headless_app};

#[derive(Component, Default)]
struct Mine;

#[derive(Resource, Default)]
struct Decided(Vec<&'static str>);

/// A marker for each behaviour of a test.
#[derive(Component, Default)]
struct Number<const N: u8>;

fn decides(name: &'static str) -> impl FnMut(ResMut<Decided>) {
    move |mut decided: ResMut<Decided>| decided.0.push(name)
}

#[test]
fn behaviours_decide_in_the_order_of_their_registration_or_as_they_say() {
    let mut app = headless_app();
    app.init_resource::<Decided>()
        .add_behaviour::<Number<0>, _>("a", decides("a"))
        .add_behaviour::<Number<1>, _>("b", decides("b"))
        .add_behaviour::<Number<2>, _>("c", behaviour(decides("c")).before("b"))
        .add_behaviour::<Number<3>, _>("d", behaviour(decides("d")).after("c").before("b"))
        .add_behaviour::<Number<4>, _>("e", behaviour(decides("e")).after("a"))
        .add_behaviour::<Number<5>, _>("f", behaviour(decides("f")).after("keeper").before("a"));
    app.start_match(&Scenario::default()).unwrap().run_cycles(1);
    assert_eq!(app.world().resource::<Decided>().0.join(""), "facdbe");
}

#[test]
fn an_order_that_cannot_be_is_refused() {
    let mut app = headless_app();
    app.init_resource::<Decided>()
        .add_behaviour::<Number<0>, _>("a", decides("a"))
        .add_behaviour::<Number<1>, _>("b", decides("b"));
    let mut refusal = |behaviour| app.try_add_behaviour::<Number<2>, _>("c", behaviour).err().unwrap().to_string();
    let unknown = refusal(behaviour(decides("c")).after("ab"));
    assert!(unknown.contains("its turn before or after `ab`, which is not registered"), "{unknown}");
    let around = refusal(behaviour(decides("c")).after("b").before("a"));
    assert!(around.contains("after `b` and before `a`, which come the other way round"), "{around}");
    let itself = refusal(behaviour(decides("c")).after("a").before("a"));
    assert!(itself.contains("after `a` and before `a`"), "{itself}");
    // Nothing is left behind: the name and the marker are free.
    app.add_behaviour::<Number<2>, _>("c", behaviour(decides("c")).before("a"));
    app.start_match(&Scenario::default()).unwrap().run_cycles(1);
    assert_eq!(app.world().resource::<Decided>().0.join(""), "cab");
}

#[test]
fn a_behaviour_runs_only_in_the_cycles_in_which_all_its_conditions_hold() {
    #[derive(Resource, Default)]
    struct Ran(Vec<u64>);
    let mut app = headless_app();
    let count = behaviour(|clock: Res<CycleClock>, mut ran: ResMut<Ran>| ran.0.push(clock.cycle))
        .run_if(|clock: Res<CycleClock>| clock.cycle.is_multiple_of(2))
        .run_if(|clock: Res<CycleClock>| clock.cycle.is_multiple_of(3));
    app.init_resource::<Ran>().add_behaviour::<Mine, _>("counter", count);
    app.start_match(&Scenario::default()).unwrap().run_cycles(20);
    assert_eq!(app.world().resource::<Ran>().0, [6, 12, 18]);
}

#[test]
fn a_behaviour_may_be_of_remote_robots() {
    #[derive(Component, Default)]
    #[require(naoisis::behaviour::Remote)]
    struct Puppet;
    let mut app = headless_app();
    app.add_behaviour::<Puppet, _>("puppet", |mut robots: Query<&mut WalkCommand, With<Puppet>>| {
        robots.iter_mut().for_each(|mut walk| walk.dx = 0.01);
    });
    let scenario = r#"{ "rules": "free", "robots": [{ "number": 1, "pose": [0, 0, 0], "behaviour": "puppet" }] }"#;
    app.start_match(&Scenario::from_json(scenario).unwrap()).unwrap().run_cycles(20);
    assert!(app.robot_pose(blue(1)).unwrap().position.x > 0.05);
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
fn a_team_may_be_made_by_a_closure() {
    let line_up = Arc::new(Mutex::new(vec!["keeper".to_owned(), "striker".to_owned()]));
    let mut app = headless_app();
    let names = Arc::clone(&line_up);
    app.add_team("of the day", "As somebody wished.", move |number, _| {
        names.lock().unwrap().get(usize::from(number) - 1).cloned().unwrap_or("supporter".to_owned())
    });
    app.add_team("numbered", "By their numbers.", |number, size| format!("player {number} of {size}"));
    let registry = app.world().resource::<BehaviourRegistry>();
    assert_eq!(registry.team("of the day").unwrap().behaviour_of(2, 3), "striker");
    assert_eq!(registry.team_of(&[(1, "keeper"), (2, "striker"), (3, "supporter")]), Some("of the day"));
    line_up.lock().unwrap()[1] = "chaser".to_owned();
    assert_eq!(registry.team("of the day").unwrap().behaviour_of(2, 3), "chaser");

    let teams = |blue: &str| Scenario::from_json(&format!(r#"{{ "teams": {{ "blue": "{blue}", "pink": "roles" }} }}"#));
    app.start_match(&teams("of the day").unwrap()).unwrap();
    assert!(app.robot::<Chaser>(blue(2)).is_some());
    // One that lines up whom nobody knows does not play.
    let fault = app.start_match(&teams("numbered").unwrap()).err().unwrap().to_string();
    assert!(fault.contains("player 1 of the team `numbered` has the behaviour `player 1 of 3`"), "{fault}");
}
