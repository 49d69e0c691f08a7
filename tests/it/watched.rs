//! A match that is watched is the match that is run headless.

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use core::time::Duration;
use naoisis::prelude::*;
use naoisis::viewer::camera_images::{CameraImagesPlugin, Watched};
use naoisis::viewer::cycle_samples::CycleSamplesPlugin;
use naoisis::viewer::drive::DrivePlugin;
use naoisis::viewer::event_log::EventLogPlugin;
use naoisis::viewer::{Speed, TimelineCommand, ViewerCommand};

use crate::determinism::trace_of;
use crate::support::begin_trace;
use naoisis::camera_model::CameraName;
use naoisis::viewer::shared::Playback;

#[test]
fn the_trace_of_a_match_watched_at_changing_speeds_is_the_headless_one_byte_for_byte() {
    let scenario = Scenario { seed: 5, ..Scenario::named("match3v3").unwrap() };
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin));
    app.add_plugins((CycleSamplesPlugin, CameraImagesPlugin));
    // Somebody looks through a robot's eyes, too.
    let looked_through = (RobotId::new(Team::Blue, 2), CameraName::TOP);
    app.world_mut().resource_mut::<Watched>().cameras.insert(looked_through);
    app.start_match(&scenario).unwrap();
    let bytes = begin_trace(&mut app);
    // Frames of uneven length, whatever is watched.
    let frames = |app: &mut App, count: u64| {
        for frame in 0..count {
            let length = Duration::from_millis(5 + 7 * (frame % 5));
            app.insert_resource(TimeUpdateStrategy::ManualDuration(length));
            app.update();
        }
    };
    let past = |app: &mut App, command| {
        app.world_mut().write_message(command);
        frames(app, 3);
    };
    for speed in [1.0, 0.25, 16.0, 0.5, 2.0, 8.0, 0.1, 4.0] {
        app.world_mut().write_message(ViewerCommand::SetSpeed(Speed::Times(speed)));
        frames(&mut app, 25);
        let back = app.cycle() / 2;
        past(&mut app, TimelineCommand::GoTo(back));
        past(&mut app, TimelineCommand::Step(-1));
        past(&mut app, TimelineCommand::Present);
        past(&mut app, TimelineCommand::Skip(-0.4));
        app.world_mut().write_message(ViewerCommand::TogglePause);
        // Through the past into the present.
        frames(&mut app, 25);
        past(&mut app, TimelineCommand::Present);
        app.world_mut().write_message(ViewerCommand::Step);
        app.world_mut().write_message(ViewerCommand::TogglePause);
    }
    app.world_mut().write_message(ViewerCommand::SetSpeed(Speed::Unlimited));
    frames(&mut app, 3);
    let cycles = app.cycle() as usize;
    assert!(cycles > 600, "{cycles}");
    assert!(bytes.written() == trace_of(&scenario, cycles), "the watched match is another one");
}

#[derive(Component, Default)]
struct Clumsy;

fn stumble(robots: Query<&Odometry, With<Clumsy>>, clock: Res<CycleClock>) {
    assert!(robots.is_empty() || clock.cycle < 5, "stumbled");
}

#[test]
fn a_behaviour_that_panics_is_said_and_the_program_goes_on() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(20)));
    app.add_behaviour::<Clumsy, _>("clumsy", stumble);
    let scenario = r#"{ "rules": "free", "robots": [{ "number": 1, "behaviour": "clumsy" }] }"#;
    app.start_match(&Scenario::from_json(scenario).unwrap()).unwrap();
    let frames = |app: &mut App| (0..40).for_each(|_| app.update());
    frames(&mut app);
    assert_eq!(app.cycle(), 5);
    let problem = app.world().resource::<Playback>().problem.clone().unwrap();
    assert!(problem.starts_with("a system of the match panicked: stumbled"), "{problem}");
    // Another match can be played; the same stumbles again.
    app.world_mut().write_message(ViewerCommand::Load("match3v3"));
    frames(&mut app);
    assert!(app.cycle() > 10);
    assert_eq!(app.world().resource::<Playback>().problem, None);
}
