use super::*;
use crate::viewer::commands::ViewerCommand;
use crate::viewer::drive::DrivePlugin;
use crate::viewer::event_log::EventLogPlugin;
use bevy::time::TimeUpdateStrategy;
use core::time::Duration;
use naoisis_core::cycle::perceive;
use naoisis_core::team::{RobotId, Team};
use naoisis_record::record::recorder::{self, EndReason};
use naoisis_record::record::trace::TraceRecorder;
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};
use serde::Deserialize;

const BLUE2: RobotId = RobotId::new(Team::Blue, 2);

/// A match with 1/30 s per cycle and 60 frames/s.
fn app(scenario: &Scenario) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(16_667)));
    app.start_match(scenario).unwrap();
    // The first frame only starts the clock.
    app.update();
    app
}

fn match3v3() -> App {
    app(&Scenario::named("match3v3").unwrap())
}

fn frames(app: &mut App, count: usize) {
    for _ in 0..count {
        app.update();
    }
}

fn send<M: Message>(app: &mut App, message: M) {
    app.world_mut().write_message(message);
    app.update();
}

fn cursor(app: &App) -> Option<f64> {
    app.world().resource::<Timeline>().cursor()
}

#[test]
fn the_past_is_shown_as_it_was_and_the_present_comes_back() {
    let mut app = match3v3();
    let seen = |app: &App| {
        let percepts = app.robot::<Percepts>(BLUE2).cloned();
        (app.robot_pose(BLUE2).unwrap(), app.ball().unwrap(), percepts, app.cycle())
    };
    let mut earlier = None;
    while app.cycle() < 200 {
        app.update();
        if app.cycle() == 100 {
            earlier = Some(seen(&app));
        }
    }
    let now = (seen(&app), app.game().clone());
    send(&mut app, TimelineCommand::GoTo(100));
    send(&mut app, ViewerCommand::TogglePause);
    send(&mut app, TimelineCommand::GoTo(100));
    let (shown, earlier) = (seen(&app), earlier.unwrap());
    // A record has degrees and a limited number of decimal places.
    assert!(shown.0.position.abs_diff_eq(earlier.0.position, 1e-5));
    assert!((shown.0.heading - earlier.0.heading).abs() < 1e-5);
    assert_eq!((shown.1.position, shown.3), (earlier.1.position, 100));
    let count = |percepts: &Option<Percepts>| percepts.as_ref().map(|percepts| percepts.landmarks.len());
    assert_eq!(count(&shown.2), count(&earlier.2));
    frames(&mut app, 20);
    assert_eq!(cursor(&app), Some(100.0));
    send(&mut app, TimelineCommand::Present);
    assert_eq!((seen(&app), app.game().clone()), now);
    assert_eq!(cursor(&app), None);
}

#[test]
fn the_past_goes_on_into_the_present_and_the_match_with_it() {
    let mut app = match3v3();
    while app.cycle() < 60 {
        app.update();
    }
    send(&mut app, TimelineCommand::Skip(-1.0));
    // 30 frames are 15 of the 30 cycles. The match itself is paused.
    frames(&mut app, 29);
    assert!((44.0..46.5).contains(&cursor(&app).unwrap()), "{:?}", cursor(&app));
    assert_eq!(app.world().resource::<History>().last_cycle(), Some(60));
    frames(&mut app, 60);
    assert_eq!(cursor(&app), None);
    assert!((70..80).contains(&app.cycle()), "{}", app.cycle());
}

#[test]
fn steps_lead_back_and_forth_and_out_of_the_past() {
    let mut app = match3v3();
    while app.cycle() < 10 {
        app.update();
    }
    for expected in [9, 8, 7] {
        send(&mut app, TimelineCommand::Step(-1));
        assert_eq!((app.cycle(), app.world().resource::<Playback>().paused), (expected, true));
    }
    for expected in [8, 9, 10, 11, 12] {
        send(&mut app, ViewerCommand::Step);
        assert_eq!(app.cycle(), expected);
    }
    assert_eq!(cursor(&app), None);
    for _ in 0..20 {
        send(&mut app, TimelineCommand::Step(-1));
    }
    assert_eq!(app.cycle(), 0, "there is nothing before the start");
}

#[test]
fn robots_without_a_belief_have_none_afterwards() {
    let scenario = Scenario::from_json(r#"{ "rules": "free", "robots": [{ "number": 2 }] }"#).unwrap();
    let mut app = app(&scenario);
    frames(&mut app, 40);
    send(&mut app, TimelineCommand::GoTo(3));
    send(&mut app, TimelineCommand::Present);
    assert!(app.robot::<Belief>(BLUE2).is_none());
}

#[test]
fn a_trace_is_shown_as_the_match_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("match.jsonl.zst");
    let mut played = match3v3();
    let trace = TraceRecorder::create(&path).unwrap();
    recorder::start(played.world_mut(), vec![Box::new(trace)]);
    while played.cycle() < 150 {
        played.update();
    }
    assert!(recorder::finish(played.world_mut(), EndReason::Duration).into_iter().all(|said| said.is_ok()));
    let wanted = played.world().resource::<CurrentRecord>().record.robot(BLUE2).unwrap().command.clone();

    let mut replay = app(&Scenario::default());
    start_replay(replay.world_mut(), ReadTrace::open(&path).unwrap()).unwrap();
    send(&mut replay, TimelineCommand::GoTo(150));
    let place = replay.robot_pose(BLUE2).unwrap().position;
    assert!(place.abs_diff_eq(played.robot_pose(BLUE2).unwrap().position, 1e-5));
    assert!(replay.robot::<Belief>(BLUE2).is_some());
    let shown = replay.world().resource::<CurrentRecord>().record.robot(BLUE2).unwrap().command.clone();
    // A trace contains only significant digits.
    let [shown, wanted] = [shown, wanted].map(|command| serde_json::to_value(command).unwrap());
    let walks = [&shown, &wanted].map(|command| Vec::<f32>::deserialize(&command["walk"]).unwrap());
    assert!(walks[0].iter().zip(&walks[1]).all(|(shown, wanted)| (shown - wanted).abs() < 1e-4), "{shown} {wanted}");
    assert_eq!(shown["say"]["intention"], wanted["say"]["intention"]);
    // The replay pauses at its end, and starts again from there.
    frames(&mut replay, 10);
    assert_eq!((replay.cycle(), replay.world().resource::<Playback>().paused), (150, true));
    send(&mut replay, ViewerCommand::TogglePause);
    frames(&mut replay, 30);
    assert!((14..18).contains(&replay.cycle()), "{}", replay.cycle());
    send(&mut replay, ViewerCommand::SetSpeed(Speed::Times(4.0)));
    frames(&mut replay, 30);
    assert!((74..80).contains(&replay.cycle()), "{}", replay.cycle());
    // A match can be started instead of the replay.
    send(&mut replay, ViewerCommand::Load("match3v3"));
    frames(&mut replay, 30);
    assert!(!replay.world().resource::<Timeline>().is_replay());
    assert!(replay.robot_pose(RobotId::new(Team::Pink, 3)).is_some());
}

#[test]
fn a_cycle_that_waits_for_a_program_leaves_the_past_as_it_is() {
    let mut app = match3v3();
    frames(&mut app, 60);
    let before = app.cycle();
    app.world_mut().resource_mut::<Playback>().paused = true;
    perceive(app.world_mut());
    frames(&mut app, 3);
    assert_eq!((app.cycle(), app.world().resource::<History>().last_cycle()), (before + 1, Some(before)));
    app.world_mut().resource_mut::<Playback>().paused = false;
    frames(&mut app, 30);
    let cycles = app.world().resource::<History>().cycles().unwrap();
    assert_eq!((*cycles.start(), *cycles.end()), (0, app.cycle()));
}
