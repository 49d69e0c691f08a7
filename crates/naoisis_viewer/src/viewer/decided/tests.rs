use super::*;
use crate::viewer::commands::ViewerCommand;
use crate::viewer::drive::DrivePlugin;
use crate::viewer::event_log::EventLogPlugin;
use crate::viewer::rebuild::RebuildPlugin;
use crate::viewer::shared::Selection;
use crate::viewer::timeline::start_replay;
use bevy::time::TimeUpdateStrategy;
use core::time::Duration;
use naoisis_core::team::{PerTeam, Team};
use naoisis_record::record::read_trace::ReadTrace;
use naoisis_record::record::recorder::{self, EndReason};
use naoisis_record::record::trace::TraceRecorder;
use naoisis_sim::scenario::Scenario;
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

/// A robot kicks the ball at 12 s into the goal of pink, whose robot is too far from it.
const GOAL: &str = r#"{ "name": "goal", "ball": { "position_m": [1.65, -0.05] }, "robots": [
    { "number": 2, "pose": [1.5, 0, 0], "behaviour":
      { "script": [{ "from_s": 12.0, "kick": { "type": "right_straight", "speed": 1.0 } }] } },
    { "team": "pink", "number": 1, "pose": [-2.8, 0.6, 180], "behaviour": "idle" }] }"#;

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
        .init_resource::<Selection>()
        .init_resource::<Branches>()
        .init_resource::<Decided>()
        .add_message::<DecidedCommand>()
        .add_systems(Update, (begin_when_opened, apply, go_on, listen).chain().after(RebuildSystems));
    app.start_match(&Scenario::from_json(GOAL).unwrap()).unwrap();
    app.update();
    app
}

/// Runs frames until a condition holds.
fn wait(app: &mut App, what: &str, is_so: impl Fn(&App) -> bool) {
    // Threads may take any time: the test waits for them, but not for ever.
    for _ in 0..200_000 {
        if is_so(app) {
            return;
        }
        app.update();
        thread::yield_now();
    }
    panic!("never: {what}");
}

fn decided(app: &App) -> &Decided {
    app.world().resource::<Decided>()
}

fn is_complete(app: &App) -> bool {
    let progress = decided(app).progress(0);
    !decided(app).is_running() && progress.all > 0 && progress.played == progress.all
}

/// Opens the panel with few and short repetitions, and waits for the end.
fn find(app: &mut App) {
    let mut decided = app.world_mut().resource_mut::<Decided>();
    (decided.times, decided.for_s) = (4, 4.0);
    app.world_mut().resource_mut::<DisplaySettings>().decided = true;
    wait(app, "all moments", is_complete);
}

#[test]
fn the_goal_decided_a_match_with_one_and_more_repetitions_are_added() {
    let mut app = app();
    while app.cycle() < 500 {
        app.update();
    }
    app.world_mut().write_message(ViewerCommand::TogglePause);
    app.update();
    find(&mut app);
    let [swing] = decided(&app).swings() else { panic!("{:?}", decided(&app).swings()) };
    // From the moment at 10 s on, 4 s are enough for the goal in every repetition.
    assert_eq!((swing.from_s, swing.until_s, swing.team, swing.is_goal), (5.0, 10.0, Team::Blue, false));
    let firsts =
        |app: &App| decided(app).chances().map(|(_, chance)| (chance.times, chance.first.blue)).collect::<Vec<_>>();
    assert_eq!(firsts(&app), [(4, 0), (4, 4), (4, 0)]);
    app.world_mut().write_message(DecidedCommand::Again);
    app.update();
    wait(&mut app, "as many again", is_complete);
    assert_eq!(firsts(&app), [(8, 0), (8, 8), (8, 0)]);
    // Another match has its own results.
    app.world_mut().write_message(ViewerCommand::Restart);
    app.update();
    app.update();
    assert_eq!((decided(&app).chances().count(), decided(&app).swings().len()), (0, 0));
}

#[test]
fn a_trace_is_played_from_its_keyframes_as_they_are_rebuilt() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("match.jsonl.zst");
    let mut played = app();
    played.world_mut().write_message(ViewerCommand::Restart);
    recorder::start(played.world_mut(), vec![Box::new(TraceRecorder::create(&path).unwrap())]);
    while played.cycle() < 500 {
        played.update();
    }
    assert!(recorder::finish(played.world_mut(), EndReason::Duration).into_iter().all(|said| said.is_ok()));
    let mut replay = app();
    start_replay(replay.world_mut(), ReadTrace::open(&path).unwrap()).unwrap();
    find(&mut replay);
    wait(&mut replay, "three moments", |app| is_complete(app) && decided(app).chances().count() == 3);
    let [swing] = decided(&replay).swings() else { panic!("{:?}", decided(&replay).swings()) };
    assert_eq!((swing.team, swing.score), (Team::Blue, PerTeam { blue: 0, pink: 0 }));
}

#[test]
fn moments_are_played_from_coarse_to_fine() {
    let cycles: Vec<u64> = (0..=8).map(|index| 150 * index).collect();
    let (mut chances, mut order) = (BTreeMap::new(), Vec::new());
    while let Some(cycle) = next_moment(&cycles, &chances, 4) {
        order.push(cycle / 150);
        let score = PerTeam { blue: 0, pink: 0 };
        chances.insert(cycle, Chance { time_s: 0.0, score, times: 4, first: PerTeam { blue: 0, pink: 0 } });
    }
    assert_eq!(order, [0, 8, 4, 2, 6, 1, 3, 5, 7]);
    assert_eq!(next_moment(&cycles, &chances, 8), Some(0), "more repetitions");
}

#[test]
fn results_of_a_branch_begin_with_those_of_its_parent_and_come_back_with_it() {
    let [root, branch] = [(); 2].map(|()| Keyframes::default());
    let moment = |cycle: u32, times| {
        let (score, first) = (PerTeam { blue: 0, pink: 0 }, PerTeam { blue: 0, pink: 0 });
        (u64::from(cycle), Chance { time_s: f64::from(cycle) / 30.0, score, times, first })
    };
    let chances = BTreeMap::from([moment(150, 24), moment(300, 24), moment(450, 24)]);
    let shown = Results { of: root.clone(), chances, played_s: 20.0, has_begun: true, ..default() };
    let mut decided = Decided { shown, ..default() };
    decided.change_match(&branch, Some((&root, 400)));
    let cycles = |decided: &Decided| decided.chances().map(|(cycle, _)| cycle).collect::<Vec<_>>();
    assert_eq!((cycles(&decided), decided.shown.played_s, decided.shown.has_begun), (vec![150, 300], 20.0, false));
    assert!(decided.shown.of.is_same(&branch));
    decided.shown.chances.extend([moment(600, 12)]);
    decided.change_match(&root, None);
    assert_eq!((cycles(&decided), decided.shown.has_begun), (vec![150, 300, 450], true));
    decided.change_match(&branch, Some((&root, 400)));
    assert_eq!(cycles(&decided), [150, 300, 600]);
    drop(branch);
    // A match that cannot be shown again is forgotten, and one that is no branch begins without results.
    decided.change_match(&Keyframes::default(), None);
    assert_eq!((decided.others.len(), cycles(&decided)), (1, vec![]));
}

#[test]
fn moments_that_have_been_begun_are_counted_too() {
    let words = |played, begun, is_played_on| Progress { played, begun, all: 48 }.words(is_played_on);
    assert_eq!(words(0, 0, true), "0 of 48 moments");
    assert_eq!(words(0, 1, true), "0 of 48 moments, 1 begun");
    assert_eq!(words(3, 1, false), "Stopped: 3 of 48 moments, 1 begun");
    assert_eq!((words(48, 0, false), words(0, 0, false)), ("48 of 48 moments".into(), "0 of 48 moments".into()));
}
