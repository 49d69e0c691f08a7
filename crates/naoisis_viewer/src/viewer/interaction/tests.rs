use super::*;
use crate::viewer::commands::{SelectionCommand, TimelineCommand, ViewPreset};
use crate::viewer::drive::DrivePlugin;
use crate::viewer::event_log::EventLogPlugin;
use crate::viewer::shared::DRIVEN;
use bevy::input::InputPlugin;
use bevy::time::TimeUpdateStrategy;
use core::time::Duration;
use driving::Driving;
use naoisis_core::geometry::Pose;
use naoisis_core::team::Team;
use naoisis_sim::interface::gather::CurrentRecord;
use naoisis_sim::scenario::Scenario;
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};
use std::path::Path;

const BLUE2: RobotId = RobotId::new(Team::Blue, 2);

/// A match with one cycle per frame, without a window.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, InputPlugin, NaoisisPlugins, EventLogPlugin, DrivePlugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(33_334)))
        .init_resource::<Notice>()
        .init_resource::<undo::Undo>()
        .init_resource::<saved_files::SavedFiles>()
        .insert_resource(Selection(Some(BLUE2)))
        .add_message::<HandAction>()
        .add_message::<SelectionCommand>()
        .add_message::<ViewPreset>()
        .add_systems(Update, apply);
    driving::tests::add_without_panels(&mut app);
    app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
    app.update();
    app
}

fn act(app: &mut App, action: HandAction) {
    app.world_mut().write_message(action);
    for _ in 0..4 {
        app.update();
    }
}

#[test]
fn a_robot_is_penalised_and_returns() {
    let mut app = app();
    act(&mut app, HandAction::PenaliseOrReturn);
    assert!(app.robot::<Penalty>(BLUE2).unwrap().is_active());
    act(&mut app, HandAction::PenaliseOrReturn);
    assert!(!app.robot::<Penalty>(BLUE2).unwrap().is_active());
}

fn close(one: Option<Pose>, other: Option<Pose>) -> bool {
    one.zip(other).is_some_and(|(one, other)| one.position.distance(other.position) < 0.02)
}

#[test]
fn what_was_done_by_hand_is_taken_back_and_done_again() {
    let mut app = app();
    let (start, goal) = (app.robot_pose(BLUE2), Pose::new(1.0, 1.0, 0.0));
    undo::act(app.world_mut(), Intervention::PlaceRobot { robot: BLUE2, pose: goal });
    (0..4).for_each(|_| app.update());
    assert!(close(app.robot_pose(BLUE2), Some(goal)));
    act(&mut app, HandAction::Undo);
    assert!(close(app.robot_pose(BLUE2), start), "{:?}", app.robot_pose(BLUE2));
    assert!(app.world().resource::<Notice>().text.starts_with("Undone: blue2 is put at (1.00"));
    act(&mut app, HandAction::Redo);
    assert!(close(app.robot_pose(BLUE2), Some(goal)));
    assert!(app.world().resource::<Notice>().text.starts_with("Redone: blue2"));
    act(&mut app, HandAction::Redo);
    assert!(app.world().resource::<Notice>().text.starts_with("Nothing to redo"));
    // A penalty can be undone, too: the robot is back where it stood.
    act(&mut app, HandAction::PenaliseOrReturn);
    act(&mut app, HandAction::Undo);
    (0..4).for_each(|_| app.update());
    assert!(!app.robot::<Penalty>(BLUE2).unwrap().is_active());
    // The robot has walked on since.
    let moved = app.robot_pose(BLUE2).unwrap().position.distance(goal.position);
    assert!(moved < 0.15, "{moved}");
    // A whistle that was heard cannot be undone.
    act(&mut app, HandAction::Whistle);
    act(&mut app, HandAction::Undo);
    assert!(app.world().resource::<Notice>().text.starts_with("Cannot be undone: the whistle"));
}

#[test]
fn what_the_match_has_not_carried_out_yet_is_left_out_of_it() {
    let mut app = app();
    app.world_mut().write_message(crate::viewer::ViewerCommand::TogglePause);
    app.update();
    let queue = |app: &App| app.world().resource::<Interventions>().queue.len();
    for x in [1.0, 2.0] {
        undo::act(app.world_mut(), Intervention::PlaceRobot { robot: BLUE2, pose: Pose::new(x, 1.0, 0.0) });
    }
    act(&mut app, HandAction::Undo);
    assert_eq!(queue(&app), 1);
    act(&mut app, HandAction::Undo);
    assert_eq!(queue(&app), 0);
    act(&mut app, HandAction::Redo);
    assert_eq!(queue(&app), 1);
    // In another match nothing of this one can be undone.
    app.world_mut().write_message(crate::viewer::ViewerCommand::Restart);
    app.update();
    act(&mut app, HandAction::Undo);
    assert!(app.world().resource::<Notice>().text.starts_with("Nothing to undo"));
}

#[test]
fn strokes_of_the_pen_are_taken_back_and_drawn_again() {
    use crate::viewer::pen_marks::{Pen, PenMark};
    let mut app = app();
    app.init_resource::<Pen>().add_systems(Update, undo::note_marks.before(apply));
    app.update();
    let marks = |app: &App| app.world().resource::<Pen>().marks.len();
    app.world_mut().resource_mut::<Pen>().marks.push(PenMark::Arrow(Vec2::ZERO, Vec2::X));
    app.update();
    act(&mut app, HandAction::Undo);
    assert_eq!(marks(&app), 0);
    act(&mut app, HandAction::Redo);
    assert_eq!(marks(&app), 1);
    app.world_mut().resource_mut::<Pen>().marks.pop();
    app.update();
    act(&mut app, HandAction::Undo);
    assert_eq!(marks(&app), 1, "wiped away, and back again");
}

#[test]
fn the_past_is_not_changed() {
    let mut app = app();
    act(&mut app, HandAction::Whistle);
    assert_eq!(*app.world().resource::<Notice>(), Notice::default());
    app.world_mut().write_message(crate::viewer::ViewerCommand::TogglePause);
    app.world_mut().write_message(TimelineCommand::GoTo(0));
    app.update();
    act(&mut app, HandAction::PenaliseOrReturn);
    assert!(app.world().resource::<Interventions>().queue.is_empty());
    assert!(app.world().resource::<Notice>().text.starts_with("The past cannot be changed"));
}

#[test]
fn a_driven_robot_goes_where_the_keys_say() {
    let mut app = app();
    let before = app.robot_pose(BLUE2).unwrap();
    act(&mut app, HandAction::Drive);
    app.world_mut().resource_mut::<ButtonInput<KeyCode>>().press(KeyCode::KeyQ);
    let begun = app.cycle();
    while app.cycle() < begun + 30 {
        app.update();
    }
    // One second at 90 degrees per second. The first cycles were still controlled by the behaviour.
    let turned = app.robot_pose(BLUE2).unwrap().heading - before.heading;
    assert!((turned.to_degrees() - 90.0).abs() < 15.0, "{}", turned.to_degrees());
    // It does not follow the plans of its behaviour, so they are not shown.
    let intention = |app: &App, id| {
        let record = app.world().resource::<CurrentRecord>().record.robot(id).cloned().unwrap();
        (record.intention().map(str::to_owned), record.drawings.is_empty())
    };
    assert_eq!(intention(&app, BLUE2), (Some(DRIVEN.to_owned()), true));
    // If another robot is selected, that one is driven.
    let blue3 = RobotId::new(Team::Blue, 3);
    app.world_mut().resource_mut::<Selection>().0 = Some(blue3);
    app.update();
    assert_eq!(app.world().resource::<Driving>().robot, Some(blue3));
    // A click that hits no robot changes nothing.
    app.world_mut().resource_mut::<Selection>().0 = None;
    app.update();
    assert_eq!(app.world().resource::<Driving>().robot, Some(blue3));
    assert_eq!(app.world().resource::<Selection>().0, Some(blue3));
    app.run_cycles(2);
    assert_eq!(intention(&app, blue3), (Some(DRIVEN.to_owned()), true));
    assert!(intention(&app, BLUE2).0 != Some(DRIVEN.to_owned()));
    act(&mut app, HandAction::Drive);
    assert_eq!(app.world().resource::<Driving>().robot, None);
    app.run_cycles(2);
    assert!(intention(&app, blue3).0 != Some(DRIVEN.to_owned()));
}

#[test]
fn what_was_done_in_a_branch_can_be_undone_after_a_visit_to_another() {
    use crate::viewer::keyframes::Keyframes;
    let mut app = app();
    undo::reset(app.world_mut());
    undo::act(app.world_mut(), Intervention::PlaceRobot { robot: BLUE2, pose: Pose::new(1.0, 1.0, 0.0) });
    let branch = app.world_mut().get_resource_or_init::<Keyframes>().clone();
    app.insert_resource(Keyframes::default());
    assert_eq!(undo::undo(app.world_mut()), "Nothing to undo");
    app.insert_resource(branch);
    assert!(undo::undo(app.world_mut()).starts_with("Undone: "));
    assert!(undo::redo(app.world_mut()).starts_with("Redone: "));
}

#[test]
fn a_match_is_saved_with_its_trace_and_goes_on_where_it_was() {
    use crate::viewer::match_panel::{MatchCommand, MatchPanelPlugin};
    use naoisis_record::record::read_trace::ReadTrace;
    let folder = tempfile::tempdir().unwrap();
    let mut app = app();
    app.add_plugins(MatchPanelPlugin).add_systems(Last, saved_files::tell_of_files);
    app.world_mut().resource_mut::<saved_files::SavedFiles>().folder = folder.path().to_owned();
    undo::act(app.world_mut(), Intervention::PlaceRobot { robot: BLUE2, pose: Pose::new(1.0, 1.0, 0.0) });
    (0..30).for_each(|_| app.update());
    // The past is shown: the whole match is saved nevertheless.
    app.world_mut().write_message(TimelineCommand::GoTo(10));
    app.world_mut().resource_mut::<Playback>().paused = true;
    app.update();
    let last = app.world().resource::<naoisis_record::record::history::History>().last_cycle().unwrap();
    act(&mut app, HandAction::KeepMatch);
    assert_eq!(app.world().resource::<Timeline>().cursor(), Some(10.0));
    let path = folder.path().join(format!("match3v3-{last:06}.naoisis"));
    let again = |app: &mut App| saved_files::keep(app.world_mut()).unwrap();
    assert_eq!(again(&mut app), path, "it is not written twice");
    undo::act(app.world_mut(), Intervention::SetScore { blue: 3, pink: 0 });
    let other = again(&mut app);
    assert_ne!(other, path, "it is another match");
    let words = |app: &App, path: &Path| saved_files::match_words(app.world().resource(), path);
    assert!(words(&app, &other).ends_with("its trace is being written beside it"));
    undo::undo(app.world_mut());
    let trace = path.with_extension("jsonl.zst");
    // Closing the window waits for the trace.
    app.world_mut().write_message(AppExit::Success);
    app.update();
    assert!(words(&app, &path).ends_with("its trace is beside it"));
    let mut read = ReadTrace::open(&trace).unwrap();
    assert_eq!(read.history.cycles(), Some(0..=last));
    let placed = read.history.record(last).unwrap().unwrap();
    app.world_mut().write_message(MatchCommand::Open(path));
    app.update();
    let placed = placed.robots.iter().find(|robot| robot.id == BLUE2).map(|robot| robot.pose);
    assert!(app.cycle() == last && close(app.robot_pose(BLUE2), placed));
    app.world_mut().resource_mut::<Playback>().paused = false;
    (0..5).for_each(|_| app.update());
    assert!(app.cycle() > last);
}

#[test]
fn a_page_is_saved_of_a_live_match_and_of_a_trace() {
    use crate::viewer::keyframes::Simulator;
    use crate::viewer::match_panel::{MatchCommand, MatchPanelPlugin};
    use naoisis_record::record::page::page_of_trace;
    use naoisis_record::record::read::TraceReader;
    use std::fs;
    let folder = tempfile::tempdir().unwrap();
    let mut app = app();
    app.add_plugins(MatchPanelPlugin).add_systems(Last, saved_files::tell_of_files);
    app.world_mut().resource_mut::<saved_files::SavedFiles>().folder = folder.path().to_owned();
    app.insert_resource(Simulator(&|| {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        app
    }));
    (0..60).for_each(|_| app.update());
    // Closing the window waits for the files.
    let close = |app: &mut App| {
        app.world_mut().write_message(AppExit::Success);
        app.update();
    };
    let live = saved_files::save_page(app.world_mut()).unwrap();
    let trace = saved_files::trace_of(&saved_files::keep(app.world_mut()).unwrap());
    close(&mut app);
    let text = fs::read_to_string(&live).unwrap();
    assert!(text.starts_with("<!doctype html>") && live.extension().is_some_and(|ending| ending == "html"));
    app.world_mut().write_message(MatchCommand::Open(trace.clone()));
    while !app.world().resource::<Timeline>().is_replay() {
        app.update();
        std::thread::yield_now();
    }
    let replayed = saved_files::save_page(app.world_mut()).unwrap();
    assert_ne!(replayed, live, "files are never replaced");
    close(&mut app);
    let expected = page_of_trace(&mut TraceReader::open(&trace).unwrap(), app.world().resource()).unwrap();
    assert!(fs::read_to_string(replayed).unwrap() == expected, "the page of `convert`");
}
