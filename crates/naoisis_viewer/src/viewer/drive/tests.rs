//! The match in the window: pause, single cycles, speeds, restarts.

use super::*;
use crate::viewer::event_log::EventLogPlugin;
use bevy::time::TimeUpdateStrategy;
use naoisis_core::team::{RobotId, Team};
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

/// A match with a rolling ball and a robot that watches it, with 1/30 s per cycle and 60 frames/s.
fn app() -> App {
    let scenario = Scenario::from_json(
        r#"{ "rules": "free", "seed": 7, "duration_s": 4.0, "ball": { "velocity_mps": [1.0, 0.0] },
             "robots": [{ "number": 1, "pose": [-2.0, 0.0, 0.0] }] }"#,
    );
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(16_667)));
    app.start_match(&scenario.expect("a scenario")).expect("a match");
    // The first frame only starts the clock.
    app.update();
    app
}

fn frames(app: &mut App, count: usize) -> u64 {
    let before = app.cycle();
    for _ in 0..count {
        app.update();
    }
    app.cycle() - before
}

#[test]
fn the_match_keeps_the_time_of_the_clock() {
    // 30 frames of 1/60 s and a bit are half a second: 15 cycles of 1/30 s.
    assert_eq!(frames(&mut app(), 30), 15);
}

#[test]
fn slow_frames_do_not_slow_the_match_down() {
    let mut app = app();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(900)));
    // Three frames are 2.7 s: 81 cycles.
    assert_eq!(frames(&mut app, 3), 81);
    // Where a picture takes 200 ms, cycles get the larger part of the time, and with fast frames they leave room for 60 of them a second.
    assert!(budget(Duration::from_millis(200)) > Duration::from_millis(300));
    assert!(budget(Duration::from_millis(4)) < Duration::from_millis(13));
    assert!(budget(Duration::from_secs(9)) < Duration::from_secs(1));
}

#[test]
fn no_speed_gives_cycles_more_time_than_the_unlimited_one() {
    let limit = Duration::from_millis(30);
    let longest = |speed| longest_cycles(speed, limit);
    assert_eq!([longest(Speed::Times(16.0)), longest(Speed::Unlimited)], [limit; 2]);
    assert_eq!(longest(Speed::Times(1.0)), LONGEST_CYCLES, "real time is kept even if pictures become rare");
    // Slow cycles are not stopped after the first one, but before they take too long.
    let after = |cycles, taken_ms| FrameTime { cycles, taken: Duration::from_millis(taken_ms), ..default() };
    let has_time = [after(9, 29), after(9, 30), after(3, 300), after(3, 501)].map(|frame| frame.has_time(limit));
    assert_eq!(has_time, [true, false, true, false]);
    let milliseconds = Duration::from_millis;
    assert_eq!(whole_steps(milliseconds(105), milliseconds(33)), milliseconds(99));
    assert_eq!(whole_steps(milliseconds(105), Duration::ZERO), Duration::ZERO);
}

#[test]
fn speeds_scale_the_number_of_cycles() {
    for (speed, expected) in [(0.1, 1), (0.5, 7), (2.0, 30), (4.0, 60)] {
        let mut app = app();
        app.world_mut().write_message(ViewerCommand::SetSpeed(Speed::Times(speed)));
        assert_eq!(frames(&mut app, 30), expected, "at {speed} times");
    }
}

#[test]
fn a_pause_stops_and_a_step_is_one_cycle() {
    let mut app = app();
    app.world_mut().write_message(ViewerCommand::TogglePause);
    assert_eq!(frames(&mut app, 30), 0);
    app.world_mut().write_message(ViewerCommand::Step);
    assert_eq!(frames(&mut app, 30), 1);
    assert_eq!(*app.world().resource::<DisplayFraction>(), DisplayFraction(1.0));
    app.world_mut().write_message(ViewerCommand::TogglePause);
    assert_eq!(frames(&mut app, 30), 15);
}

#[test]
fn the_match_ends_where_the_scenario_ends() {
    let mut app = app();
    app.world_mut().write_message(ViewerCommand::SetSpeed(Speed::Unlimited));
    for _ in 0..10_000 {
        app.update();
    }
    assert_eq!(app.cycle(), 120);
}

#[test]
fn a_restart_plays_the_same_match_again_and_the_next_seed_another() {
    let mut app = app();
    frames(&mut app, 40);
    let ball = app.ball();
    app.world_mut().write_message(ViewerCommand::Restart);
    app.update();
    assert!(app.cycle() <= 1);
    app.run_until(60, |app| app.cycle() == 20);
    assert_eq!(app.ball(), ball);
    app.world_mut().write_message(ViewerCommand::RestartWithNextSeed);
    app.update();
    assert_eq!(app.world().resource::<Scenario>().seed, 8);
    assert!(app.robot_pose(RobotId::new(Team::Blue, 1)).is_some());
}

#[test]
fn another_scenario_can_be_loaded() {
    let mut app = app();
    frames(&mut app, 10);
    app.world_mut().write_message(ViewerCommand::Load("match3v3"));
    app.update();
    assert_eq!(app.world().resource::<Scenario>().name, "match3v3");
    assert!(app.robot_pose(RobotId::new(Team::Pink, 3)).is_some());
    // A scenario that cannot be loaded changes nothing, and the problem is shown.
    app.world_mut().write_message(ViewerCommand::Load("nothing"));
    app.update();
    assert_eq!(app.world().resource::<Scenario>().name, "match3v3");
    assert!(app.world().resource::<Playback>().problem.is_some());
}

#[test]
fn changing_speeds_do_not_change_the_match() {
    let mut watched = app();
    for (speed, count) in [(0.25, 20), (16.0, 3), (1.0, 10), (0.5, 7)] {
        watched.world_mut().write_message(ViewerCommand::SetSpeed(Speed::Times(speed)));
        frames(&mut watched, count);
    }
    let cycle = watched.cycle();
    assert!(cycle > 20);
    let mut headless = app();
    headless.run_until(1000, |app| app.cycle() == cycle);
    assert_eq!(watched.ball(), headless.ball());
    assert_eq!(watched.ball_velocity(), headless.ball_velocity());
}

#[test]
fn speeds_are_in_order_and_stop_at_the_ends() {
    assert_eq!(Speed::Times(1.0).neighbour(1), Speed::Times(2.0));
    assert_eq!(Speed::Times(1.0).neighbour(-1), Speed::Times(0.5));
    assert_eq!(Speed::Unlimited.neighbour(1), Speed::Unlimited);
    assert_eq!(Speed::ALL[0].neighbour(-1), Speed::ALL[0]);
}

#[test]
fn frames_go_on_while_a_program_thinks() {
    #[derive(Resource)]
    struct Thinks(bool);
    let blue1 = RobotId::new(Team::Blue, 1);
    let mut app = app();
    app.insert_resource(Thinks(true))
        .insert_resource(AskAhead(|world| Ok(world.resource::<Thinks>().0.then_some(RobotId::new(Team::Blue, 1)))));
    assert_eq!(frames(&mut app, 10), 0);
    let since = app.world().resource::<Playback>().awaited.expect("a program is waited for");
    frames(&mut app, 10);
    assert_eq!((app.world().resource::<Playback>().awaited, since.0), (Some(since), blue1));
    app.insert_resource(Thinks(false));
    assert_eq!(frames(&mut app, 10), 5);
    assert_eq!(app.world().resource::<Playback>().awaited, None);
}
