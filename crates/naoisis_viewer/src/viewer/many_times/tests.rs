use super::*;
use crate::viewer::branches::BranchesPlugin;
use crate::viewer::commands::{TimelineCommand, ViewerCommand};
use crate::viewer::drive::DrivePlugin;
use crate::viewer::event_log::EventLogPlugin;
use crate::viewer::rebuild::RebuildPlugin;
use crate::viewer::shared::Selection;
use bevy::time::TimeUpdateStrategy;
use core::time::Duration;
use naoisis_core::team::PerTeam;
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

pub(super) fn row(first: Option<Team>, ball: Vec2) -> Continuation {
    Continuation {
        index: 0,
        seed: 1,
        goals: PerTeam { blue: 0, pink: 0 },
        first_goal: first.map(|team| (team, 1.0)),
        ball_m: Some(ball),
        end_s: 1.0,
        programs_lost: Vec::new(),
    }
}

fn simulator() -> App {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    app
}

/// A match with ten cycles per frame.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin, RebuildPlugin, BranchesPlugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(333_340)))
        .insert_resource(Simulator(&simulator))
        .init_resource::<DisplaySettings>()
        .init_resource::<Selection>()
        .init_resource::<ManyTimes>()
        .add_message::<ManyTimesCommand>()
        .add_systems(Update, (apply, begin_when_known, listen).chain().after(RebuildSystems));
    app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
    app.update();
    app
}

fn send<M: Message>(app: &mut App, message: M) {
    app.world_mut().write_message(message);
    app.update();
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

fn shown(app: &App) -> usize {
    app.world().resource::<super::super::branches::Branches>().shown()
}

#[test]
fn a_moment_of_the_past_is_played_on_and_the_match_stays() {
    let mut app = app();
    while app.cycle() < 200 {
        app.update();
    }
    send(&mut app, ViewerCommand::TogglePause);
    let present = (app.cycle(), app.ball());
    send(&mut app, TimelineCommand::GoTo(120));
    send(&mut app, BranchCommand::PlayFromHere);
    wait(&mut app, "a branch", |app| shown(app) == 1);
    // The match was paused, so this branch is paused, too, until it is resumed.
    app.update();
    assert_eq!((app.cycle(), app.world().resource::<Playback>().paused), (120, true));
    send(&mut app, ViewerCommand::TogglePause);
    wait(&mut app, "it goes on", |app| app.cycle() > 150);
    // Without a change the match goes on as it did before.
    while app.cycle() < present.0 {
        app.update();
    }
    assert_eq!((app.cycle(), app.ball()), present);
    send(&mut app, BranchCommand::Show(0));
    assert_eq!(shown(&app), 0);
    send(&mut app, TimelineCommand::Present);
    assert_eq!((app.cycle(), app.ball()), present);
    // Another match has a single branch again.
    send(&mut app, ViewerCommand::Restart);
    app.update();
    assert_eq!(app.world().resource::<super::super::branches::Branches>().list().len(), 1);
}

#[test]
fn many_times_come_out_differently_and_one_can_be_watched() {
    let mut app = app();
    while app.cycle() < 60 {
        app.update();
    }
    let mut many = app.world_mut().resource_mut::<ManyTimes>();
    (many.times, many.for_s) = (6, 2.0);
    send(&mut app, ManyTimesCommand::Begin);
    let is_over = |app: &App| app.world().resource::<ManyTimes>().run.as_ref().is_some_and(|run| !run.is_running);
    wait(&mut app, "all times", is_over);
    let rows = app.world().resource::<ManyTimes>().run.as_ref().unwrap().rows.clone();
    assert_eq!(rows.len(), 6);
    assert!(rows.windows(2).any(|pair| pair[0].ball_m != pair[1].ball_m));
    let outcome = Outcome::ALL.into_iter().find(|outcome| outcome.is_of(&rows[0])).unwrap();
    send(&mut app, ManyTimesCommand::Watch(outcome));
    wait(&mut app, "the branch", |app| shown(app) == 1);
    wait(&mut app, "its end", |app| app.cycle() >= 120);
    // Any moment of this branch can be rebuilt, too.
    send(&mut app, ViewerCommand::TogglePause);
    send(&mut app, TimelineCommand::GoTo(100));
    let is_known = |app: &App| {
        let (rebuilt, keyframes) = (app.world().resource::<Rebuilt>(), app.world().resource::<Keyframes>());
        rebuilt.moment(100, keyframes).is_some_and(|moment| moment.is_same)
    };
    wait(&mut app, "the moment", is_known);
}

#[test]
fn a_saved_test_plays_what_was_played_here_with_what_was_done_by_hand() {
    let mut app = app();
    while app.cycle() < 200 {
        app.update();
    }
    send(&mut app, ViewerCommand::TogglePause);
    // The ball is placed in front of pink's goal. What happens next is decided in the window only.
    let place = Intervention::PlaceBall { position_m: Vec2::new(2.6, 0.0), velocity_mps: Vec2::new(0.6, 0.2) };
    app.world_mut().resource_mut::<Interventions>().queue.push(place);
    let folder = tempfile::tempdir().unwrap();
    let mut many = app.world_mut().resource_mut::<ManyTimes>();
    (many.times, many.for_s, many.folder) = (12, 3.0, folder.path().to_owned());
    send(&mut app, ManyTimesCommand::Begin);
    let is_over = |app: &App| app.world().resource::<ManyTimes>().run.as_ref().is_some_and(|run| !run.is_running);
    wait(&mut app, "all times", is_over);
    let run = app.world().resource::<ManyTimes>().run.as_ref().unwrap();
    let scored = run.rows.iter().filter(|row| row.goals.blue > 0).count();
    assert!(scored > 0, "the test would say nothing");
    let (at_least, share) = saved_test::measured_percent(run, Team::Blue).unwrap();
    assert!(at_least <= share && share == 100.0 * scored as f64 / 12.0);
    send(&mut app, ManyTimesCommand::Save { team: Team::Blue, percent: at_least });
    let test = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
    let test = test.into_iter().find(|path| path.extension().is_some_and(|ending| ending == "json")).unwrap();
    let test = Scenario::load(&test).unwrap();
    let never = AtomicBool::new(false);
    let verdicts = naoisis_record::expectations::play_all(simulator, &test, &test.expectations, 2, &never).unwrap();
    assert!(verdicts[0].holds);
    assert!(verdicts[0].found.contains(&format!("({scored} of 12)")), "{}: {scored}", verdicts[0]);
}
