use super::*;
use crate::viewer::behaviour_state::all_states;
use crate::viewer::commands::{TimelineCommand, ViewerCommand};
use crate::viewer::drive::DrivePlugin;
use crate::viewer::event_log::EventLogPlugin;
use crate::viewer::timeline::start_replay;
use bevy::time::TimeUpdateStrategy;
use core::time::Duration;
use naoisis_core::team::Team;
use naoisis_record::record::read_trace::ReadTrace;
use naoisis_record::record::recorder::{self, EndReason};
use naoisis_record::record::trace::TraceRecorder;
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

const BLUE2: RobotId = RobotId::new(Team::Blue, 2);

fn simulator() -> App {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    app
}

/// A match with ten cycles per frame.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin, RebuildPlugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(333_340)))
        .insert_resource(Simulator(&simulator))
        .init_resource::<DisplaySettings>()
        .insert_resource(Selection(Some(BLUE2)));
    app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
    app.update();
    app
}

fn send<M: Message>(app: &mut App, message: M) {
    app.world_mut().write_message(message);
    app.update();
}

/// Runs frames until the state of the moment that is shown is known, or cannot be.
fn shown_state(app: &mut App, is_enough: impl Fn(&ShownState) -> bool) -> ShownState {
    // The thread may take any time: the test waits for it, but not for ever.
    for _ in 0..20_000 {
        app.update();
        let shown = app.world().resource::<ShownState>();
        if is_enough(shown) {
            return shown.clone();
        }
        thread::yield_now();
    }
    panic!("the moment was never rebuilt: {:?}", app.world().resource::<ShownState>());
}

#[test]
fn what_a_behaviour_kept_in_mind_is_known_of_the_past() {
    let mut app = app();
    let mut earlier = None;
    while app.cycle() < 260 {
        app.update();
        if app.cycle() == 200 {
            earlier = Some(all_states(app.world())[&BLUE2].clone());
        }
    }
    send(&mut app, ViewerCommand::TogglePause);
    send(&mut app, TimelineCommand::GoTo(200));
    let shown = shown_state(&mut app, |shown| shown.0.is_ok()).0.unwrap();
    let reasons = shown.reasons.clone().expect("built-in teams say why");
    assert!(reasons.choice().is_some(), "{reasons:?}");
    assert_eq!(BehaviourState { reasons: None, ..shown }, earlier.expect("frames of ten cycles"));
    let keyframes = app.world().resource::<Keyframes>().clone();
    let moment = app.world().resource::<Rebuilt>().moment(200, &keyframes).unwrap();
    assert!(moment.is_same && moment.situation.is_ok());
    // A keyframe has no reasons, so even its moment is rebuilt by playing the cycle before it.
    let kept = keyframes.before(200).expect("kept every few seconds").0;
    assert!(kept > 0);
    send(&mut app, TimelineCommand::GoTo(kept));
    let has_reasons = |shown: &ShownState| shown.0.as_ref().is_ok_and(|state| state.reasons.is_some());
    assert!(shown_state(&mut app, has_reasons).0.unwrap().reasons.unwrap().choice().is_some());
}

/// The trace of a match of some seconds, and the behaviour state of blue2 after 90 cycles.
fn trace() -> (ReadTrace, BehaviourState) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("match.jsonl.zst");
    let mut played = app();
    // From the start of the match.
    played.world_mut().write_message(ViewerCommand::Restart);
    recorder::start(played.world_mut(), vec![Box::new(TraceRecorder::create(&path).unwrap())]);
    let mut state = None;
    while played.cycle() < 150 {
        played.update();
        if played.cycle() == 90 {
            state = Some(all_states(played.world())[&BLUE2].clone());
        }
    }
    assert!(recorder::finish(played.world_mut(), EndReason::Duration).into_iter().all(|said| said.is_ok()));
    (ReadTrace::open(&path).unwrap(), state.expect("frames of ten cycles"))
}

#[test]
fn what_a_trace_leaves_out_is_played_again() {
    let (trace, state) = trace();
    let mut replay = app();
    start_replay(replay.world_mut(), trace).unwrap();
    send(&mut replay, ViewerCommand::TogglePause);
    send(&mut replay, TimelineCommand::GoTo(90));
    let shown = shown_state(&mut replay, |shown| shown.0.is_ok()).0.unwrap();
    assert_eq!(BehaviourState { reasons: None, ..shown }, state);
}

#[test]
fn where_behaviours_are_others_than_those_of_the_trace_it_is_said() {
    let (mut trace, _) = trace();
    // As if the behaviour of pink's robots had changed since the match was recorded.
    for robot in trace.scenario.robots.iter_mut().filter(|robot| robot.team == Team::Pink) {
        robot.behaviour = naoisis_sim::scenario::BehaviourSpec::Named("striker".to_owned());
    }
    let mut replay = app();
    start_replay(replay.world_mut(), trace).unwrap();
    send(&mut replay, ViewerCommand::TogglePause);
    send(&mut replay, TimelineCommand::GoTo(150));
    let is_said = |shown: &ShownState| {
        shown.0.as_ref().is_err_and(|why| why.contains("another one from 0.") && why.contains(" s on: "))
    };
    shown_state(&mut replay, is_said);
    assert!(matches!(replay.world().resource::<Rebuilt>().progress, RebuildProgress::Differs(_)));
}

#[test]
fn a_trace_that_is_still_being_read_is_played_again_to_its_end() {
    let (mut trace, _) = trace();
    let mut whole = trace.history.clone();
    let last = whole.last_cycle().unwrap();
    trace.history = whole.until(60).unwrap();
    let mut replay = app();
    start_replay(replay.world_mut(), trace).unwrap();
    send(&mut replay, ViewerCommand::TogglePause);
    let wait_until = |replay: &mut App, cycle: u64| {
        for _ in 0..20_000 {
            replay.update();
            if replay.world().resource::<Rebuilt>().progress == RebuildProgress::Until(cycle) {
                return;
            }
            thread::yield_now();
        }
        panic!("{:?}, not until {cycle}", replay.world().resource::<Rebuilt>().progress);
    };
    wait_until(&mut replay, 60);
    for cycle in 61..=last {
        let record = whole.record(cycle).unwrap().unwrap();
        replay.world_mut().resource_mut::<History>().push(&record).unwrap();
    }
    wait_until(&mut replay, last);
    assert_eq!(replay.world().resource::<Keyframes>().last(), Some(150));
}
