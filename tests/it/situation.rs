//! The present situation, saved as a scenario.

use naoisis::prelude::*;
use naoisis::simulation::{change_settings, situation};

use crate::support::{blue, headless_app, pink};
use naoisis::game::{GameState, Intervention, Penalty, PenaltyReason, Score};
use naoisis::robot::Roster;
use naoisis::robot::posture::{LyingOn, Posture};

/// The situation, by way of a file.
fn saved(app: &mut bevy::prelude::App) -> Scenario {
    let text = situation(app.world_mut()).unwrap().resolved_json().unwrap();
    Scenario::from_json(&text).unwrap()
}

#[test]
fn a_match_begins_where_another_one_was() {
    let mut app = headless_app();
    app.start_match(&Scenario { seed: 3, ..Scenario::named("match3v3").unwrap() }).unwrap();
    app.run_cycles(600);
    let penalise = Intervention::Penalise { robot: pink(3), reason: PenaltyReason::Manual, duration_s: Some(20.0) };
    app.world_mut().commands().queue(penalise);
    app.world_mut().commands().queue(Intervention::SetScore { blue: 2, pink: 1 });
    app.world_mut().flush();
    app.run_cycles(10);
    let scenario = saved(&mut app);
    let mut again = headless_app();
    again.start_match(&scenario).unwrap();
    for robot in [blue(1), blue(2), blue(3), pink(1), pink(2)] {
        let [one, other] = [&app, &again].map(|app| app.robot_pose(robot).unwrap());
        assert!(one.position.abs_diff_eq(other.position, 1e-5) && (one.heading - other.heading).abs() < 1e-5);
    }
    assert_eq!((again.ball(), again.ball_velocity()), (app.ball(), app.ball_velocity()));
    again.run_cycles(1);
    assert_eq!(again.game().score, Score { blue: 2, pink: 1 });
    // 20 s of 1/30 s, of which ten cycles had passed but the one in which it was given.
    let left = again.robot::<Penalty>(pink(3)).unwrap().0.unwrap().cycles_left;
    assert!((589..=591).contains(&left), "{left}");
    // And it is a match: somebody does something.
    let before = again.robot_pose(blue(2));
    assert_ne!(again.run_cycles(90).robot_pose(blue(2)), before);
}

#[test]
fn a_match_that_was_in_play_goes_on_where_it_was_under_rules_with_a_walk_to_the_kick_off() {
    let mut app = headless_app();
    app.start_match(&Scenario { seed: 4, ..Scenario::named("hsl2026_middle").unwrap() }).unwrap();
    // A quiet moment of play, without a set play.
    app.run_cycles(2000);
    while app.game().state != GameState::Playing || app.game().set_play.is_some() {
        app.run_cycles(1);
    }
    let mut again = headless_app();
    again.start_match(&saved(&mut app)).unwrap();
    app.run_cycles(15);
    again.run_cycles(15);
    assert_eq!(again.game().state, GameState::Playing);
    // Half a second later, nobody is farther away than robots walk, and the ball rolls as it did.
    for robot in [blue(1), blue(2), pink(1), pink(2)] {
        let [one, other] = [&app, &again].map(|app| app.robot_pose(robot).unwrap().position);
        assert!(one.distance(other) < 0.6, "{robot}: {one} and {other}");
    }
    let [one, other] = [&app, &again].map(|app| app.ball().unwrap().position);
    assert!(one.distance(other) < 0.5, "{one} and {other}");
}

#[test]
fn every_moment_of_a_match_can_be_saved() {
    let mut app = headless_app();
    let mut scenario = Scenario::named("match3v3").unwrap();
    scenario.rules.half_s = 30.0;
    app.start_match(&scenario).unwrap();
    for _ in 0..60 {
        app.run_cycles(29);
        let scenario = saved(&mut app);
        headless_app().start_match(&scenario).unwrap();
    }
    // In the second half the teams have changed sides; in the scenario they stand as in the first.
    let keeper = app.robot_pose(blue(1)).unwrap().position;
    assert!(app.game().half == 2 && keeper.x > 1.0, "{keeper}");
    let scenario = saved(&mut app);
    assert!(scenario.robots[0].pose.position.abs_diff_eq(-keeper, 1e-5));
    // What is changed while it runs is in it.
    let mut changed = app.world().resource::<Scenario>().clone();
    changed.messages.loss = 0.25;
    change_settings(app.world_mut(), &changed).unwrap();
    assert_eq!(saved(&mut app).messages.loss, 0.25);
}

#[test]
fn a_robot_that_lies_lies_in_the_new_match() {
    let mut app = headless_app();
    app.start_match(&Scenario { seed: 3, ..Scenario::named("match3v3").unwrap() }).unwrap();
    app.run_cycles(300);
    let robot = app.world().resource::<Roster>().get(blue(2)).unwrap();
    let fallen = Posture::Fallen { cycles: 3, on: LyingOn::Back };
    *app.world_mut().get_mut::<Posture>(robot).unwrap() = fallen;
    let mut again = headless_app();
    again.start_match(&saved(&mut app)).unwrap();
    let postures = [blue(2), blue(3)].map(|id| *again.robot::<Posture>(id).unwrap());
    assert!(matches!(postures, [Posture::Fallen { on: LyingOn::Back, .. }, Posture::Upright]), "{postures:?}");
}
