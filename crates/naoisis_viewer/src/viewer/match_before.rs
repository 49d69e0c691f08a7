//! The match before: when another match or a trace takes the place of the one that is shown, that one is kept with its
//! past, its branches and its bookmarks, and can be shown again.

use bevy::prelude::*;
use std::collections::BTreeMap;

use super::branches::{self, Branches, Place};
use super::commands::ViewerCommand;
use super::drive::{self, PlayedFile};
use super::interaction::undo::Undo;
use super::match_panel::WatchedScenarioFile;
use super::match_panel::trace_reading::TraceReading;
use super::pen_marks::Pen;
use super::shared::{KeepLeft, KeepMatch, MatchBefore, Notice, OpenedTrace};
use super::teach::bookmarks::Bookmarks;
use super::theme::minutes;
use super::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::pitch::Pitch;
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::team::RobotId;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::scenario::Scenario;

/// The shortest match that is kept although nobody has worked on it, s.
const SHORTEST_S: f64 = 5.0;
/// The greatest number of matches that are kept.
const MOST_KEPT: usize = 5;

/// Keeps the match before.
pub struct MatchBeforePlugin;

impl Plugin for MatchBeforePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<MatchBefore>()
            .init_resource::<Kept>()
            .insert_resource(KeepMatch(prepare))
            .add_systems(First, show.run_if(is_wanted).before(drive::handle_commands));
    }
}

fn is_wanted(mut commands: MessageReader<ViewerCommand>) -> bool {
    commands.read().any(|command| *command == ViewerCommand::MatchBefore)
}

/// The matches before the one that is shown, the last one at the end. [`MatchBefore`] has its name.
#[derive(Resource, Debug, Default)]
pub(super) struct Kept(Vec<Before>);

impl Kept {
    /// Returns the name and the stage of the last match.
    pub fn stage(&self) -> Option<(&str, &Stage)> {
        self.0.last().map(|before| (before.name.as_str(), &before.stage))
    }

    /// Returns the last cycle of the branch of it that was shown.
    pub fn last_cycle(&self) -> Option<u64> {
        let branches = &self.0.last()?.branches;
        branches.list().get(branches.shown()).map(|branch| branch.last_cycle)
    }

    /// Returns the record of a cycle of the branch of it that was shown, if it has this cycle.
    pub fn record(&mut self, cycle: u64) -> Option<CycleRecord> {
        let before = self.0.last_mut()?;
        before.branches.record(before.branches.shown(), cycle)
    }
}

/// What records of a match leave out, and what is needed to draw them.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Stage {
    /// The pitch.
    pub pitch: Pitch,
    /// The duration of a cycle, s.
    pub period_s: f64,
    /// The bodies of the robots.
    pub bodies: BTreeMap<RobotId, Body>,
}

impl Stage {
    /// Returns whether a match on this pitch, with cycles of this duration, s, can be compared with it, cycle by cycle.
    pub fn fits(&self, pitch: &Pitch, period_s: f64) -> bool {
        self.pitch == *pitch && (self.period_s - period_s).abs() < 1e-9
    }

    fn of(world: &mut World) -> Stage {
        let pitch = world.get_resource::<Pitch>().cloned().unwrap_or_default();
        let period_s = world.resource::<CycleClock>().period_s;
        let robots: Vec<(RobotId, Entity)> = world.resource::<Roster>().iter().collect();
        let body = |(id, entity)| world.get::<Body>(entity).map(|body| (id, *body));
        Stage { pitch, period_s, bodies: robots.into_iter().filter_map(body).collect() }
    }
}

/// A match that was left, with everything that belongs to it.
#[derive(Debug)]
struct Before {
    name: String,
    /// Whether it has more than the same match would have if it were played again.
    is_worked_on: bool,
    stage: Stage,
    branches: Branches,
    bookmarks: Bookmarks,
    undo: Undo,
    pen: Pen,
    played: PlayedFile,
    watched: WatchedScenarioFile,
    trace: OpenedTrace,
}

/// A match that is about to be left.
#[derive(Debug)]
struct Leaving {
    name: String,
    is_worked_on: bool,
    stage: Stage,
    place: Place,
}

/// Prepares for leaving the match that is shown, if it is to be kept: one that was worked on, or else a longer one
/// unless one that was worked on would be lost for it.
fn prepare(world: &mut World) -> Option<KeepLeft> {
    if world.get_resource::<Branches>()?.list().is_empty() {
        return None;
    }
    let is_better_kept = world.resource::<Kept>().0.iter().any(|before| before.is_worked_on);
    let is_short = world.resource::<CycleClock>().end_time_s() < SHORTEST_S;
    if !is_worked_on(world) && (is_short || is_better_kept) {
        return None;
    }
    let leaving = leaving(world).ok()?;
    leaving.place.show(world);
    Some(Box::new(|world| keep(world, leaving)))
}

/// Whether the match has more than the same match would have if it were played again.
fn is_worked_on(world: &World) -> bool {
    world.resource::<Timeline>().is_replay()
        || world.resource::<Branches>().list().len() > 1
        || world.get_resource::<Bookmarks>().is_some_and(|bookmarks| !bookmarks.list().is_empty())
        || world.get_resource::<Undo>().is_some_and(|undo| undo.counts()[0] > 0)
}

fn leaving(world: &mut World) -> Result<Leaving, String> {
    let name = name(world);
    Ok(Leaving { name, is_worked_on: is_worked_on(world), stage: Stage::of(world), place: Place::of(world)? })
}

/// Returns the name of the match: the file of a trace, or the scenario and its seed, and the moment that is shown.
fn name(world: &World) -> String {
    let trace = world.get_resource::<OpenedTrace>().and_then(|trace| trace.0.as_deref()?.file_name());
    let trace = trace.filter(|_| world.resource::<Timeline>().is_replay());
    let scenario = world.get_resource::<Scenario>();
    let named = scenario.map(|scenario| scenario.name.clone()).unwrap_or_default();
    let file = world.get_resource::<PlayedFile>().map(PlayedFile::name).unwrap_or_default();
    let played = [named, file, "a match".to_owned()].into_iter().find(|name| !name.is_empty()).unwrap_or_default();
    let seed = scenario.map_or_else(String::new, |scenario| format!(", seed {},", scenario.seed));
    let at = minutes(world.resource::<CycleClock>().end_time_s() as f32);
    trace.map_or_else(|| format!("{played}{seed} at {at}"), |trace| format!("{} at {at}", trace.to_string_lossy()))
}

/// Keeps the match that was left. Another one is in the world already, but not yet its past.
fn keep(world: &mut World, leaving: Leaving) {
    let (name, is_worked_on) = (leaving.name.clone(), leaving.is_worked_on);
    let before = take(world, leaving);
    let mut kept = world.resource_mut::<Kept>();
    // The same match can be played again.
    kept.0.retain(|other| other.is_worked_on);
    kept.0.push(before);
    let dropped = (kept.0.len() > MOST_KEPT).then(|| kept.0.remove(0));
    tell_name(world);
    if is_worked_on {
        let dropped = dropped.map_or_else(String::new, |dropped| format!("; {} is kept no longer", dropped.name));
        world.resource_mut::<Notice>().tell(format!("{name} is kept: Backspace shows it again{dropped}"));
    }
}

/// Passes the name of the last match that is kept to the panels.
fn tell_name(world: &mut World) {
    let name = world.resource::<Kept>().0.last().map(|before| before.name.clone());
    world.resource_mut::<MatchBefore>().0 = name;
}

/// Takes everything of the match that was left out of the world.
fn take(world: &mut World, leaving: Leaving) -> Before {
    let Leaving { name, is_worked_on, stage, place } = leaving;
    branches::put_aside(world, place);
    fn of<R: Resource + Clone + Default>(world: &World) -> R {
        world.get_resource::<R>().cloned().unwrap_or_default()
    }
    Before {
        name,
        is_worked_on,
        stage,
        branches: core::mem::take(&mut *world.resource_mut::<Branches>()),
        bookmarks: of(world),
        undo: of(world),
        pen: of(world),
        played: of(world),
        watched: of::<WatchedScenarioFile>(world).without_failed(),
        trace: of(world),
    }
}

/// Puts a match that was left into the world, paused.
fn put_back(world: &mut World, before: Before) -> Result<(), String> {
    let Before { branches, bookmarks, undo, pen, played, watched, trace, .. } = before;
    let shown = branches.shown();
    world.insert_resource(branches);
    branches::bring_back(world, shown)?;
    world.insert_resource(bookmarks);
    world.insert_resource(undo);
    world.insert_resource(pen);
    world.insert_resource(played);
    world.insert_resource(watched.up_to_date());
    world.insert_resource(trace);
    Ok(())
}

/// Shows the match before, as it was left, and keeps the current one: as the first of several, so that all of them are shown in turn.
fn show(world: &mut World) {
    let text = swap(world).unwrap_or_else(|message| message);
    world.resource_mut::<Notice>().tell(text);
}

fn swap(world: &mut World) -> Result<String, String> {
    let is_there = !world.resource::<Kept>().0.is_empty() && world.contains_resource::<Branches>();
    if !is_there || world.resource::<Branches>().list().is_empty() {
        return Err("There is no match before this one".to_owned());
    }
    let leaving = leaving(world)?;
    if let Some(mut reading) = world.get_resource_mut::<TraceReading>() {
        reading.give_up();
    }
    let current = take(world, leaving);
    let mut kept = world.resource_mut::<Kept>();
    let Some(before) = kept.0.pop() else { return Ok(String::new()) };
    let next = kept.0.last().unwrap_or(&current).name.clone();
    let text = format!("{}, as it was left; Backspace: {next}", before.name);
    let shown = match put_back(world, before) {
        Ok(()) => {
            world.resource_mut::<Kept>().0.insert(0, current);
            Ok(text)
        }
        Err(message) => put_back(world, current).and(Err(message)),
    };
    tell_name(world);
    shown
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::branches::{BranchCommand, BranchesPlugin};
    use crate::viewer::commands::TimelineCommand;
    use crate::viewer::display_settings::DisplaySettings;
    use crate::viewer::drive::DrivePlugin;
    use crate::viewer::event_log::EventLogPlugin;
    use crate::viewer::match_panel::{MatchCommand, MatchPanelPlugin};
    use crate::viewer::rebuild::RebuildPlugin;
    use crate::viewer::shared::Selection;
    use bevy::time::TimeUpdateStrategy;
    use core::time::Duration;
    use naoisis_record::record::RecordPlugin;
    use naoisis_record::record::history::History;
    use naoisis_record::record::recorder::{self, EndReason};
    use naoisis_record::record::trace::TraceRecorder;
    use naoisis_record::whatif::Moment;
    use naoisis_sim::interface::gather::CurrentRecord;
    use naoisis_sim::scenario::TeamsSpec;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};
    use std::fs::{self, File};
    use std::path::Path;
    use std::time::SystemTime;

    /// A match with ten cycles per frame.
    fn app() -> App {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin, RebuildPlugin, BranchesPlugin));
        app.add_plugins((MatchPanelPlugin, MatchBeforePlugin))
            .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(333_340)))
            .init_resource::<DisplaySettings>()
            .init_resource::<Selection>();
        app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
        app.update();
        app
    }

    fn send(app: &mut App, message: impl Message) {
        app.world_mut().write_message(message);
        app.update();
    }

    fn branches(app: &App) -> [usize; 2] {
        let branches = app.world().resource::<Branches>();
        [branches.list().len(), branches.shown()]
    }

    fn past(app: &App) -> u64 {
        app.world().resource::<History>().last_cycle().unwrap_or_default()
    }

    #[test]
    fn a_match_with_branches_is_kept_when_another_takes_its_place() {
        let mut app = app();
        (0..20).for_each(|_| app.update());
        let moment = Box::new(Moment::of(app.world_mut()).unwrap());
        let cycle = app.cycle();
        send(&mut app, BranchCommand::PlayOn { moment, cycle, seed: 5, outcome: "nobody scores" });
        let root = app.world().resource::<Branches>().list()[0].last_cycle;
        (0..5).for_each(|_| app.update());
        let (branch, ball) = (past(&app), app.ball());
        assert_eq!(branches(&app), [2, 1]);
        // One key, another team, or another scenario ends it.
        let others = MatchCommand::Teams(Box::new(TeamsSpec::new("chasers", "chasers")));
        send(&mut app, others);
        assert_eq!(branches(&app), [1, 0]);
        // It can be compared with the one that is shown, cycle by cycle.
        let mut kept = app.world_mut().resource_mut::<Kept>();
        assert_eq!(
            kept.stage().map(|(_, stage)| (stage.pitch == Pitch::default(), stage.bodies.len())),
            Some((true, 6))
        );
        let last = kept.record(branch).unwrap();
        assert_eq!(kept.last_cycle(), Some(branch));
        assert_eq!((last.cycle, last.robots.len(), kept.record(branch + 1)), (branch, 6, None));
        send(&mut app, ViewerCommand::Restart);
        send(&mut app, ViewerCommand::Load("match7v7"));
        send(&mut app, ViewerCommand::MatchBefore);
        assert_eq!((branches(&app), past(&app), app.ball()), ([2, 1], branch, ball));
        // Panels read the record of this match, and not that of the other one.
        let current = &app.world().resource::<CurrentRecord>().record;
        assert_eq!((current.cycle, current.robots.len()), (branch, 6));
        send(&mut app, BranchCommand::Show(0));
        assert_eq!((branches(&app), past(&app)), ([2, 0], root));
        // The other match was kept meanwhile.
        send(&mut app, ViewerCommand::MatchBefore);
        assert_eq!(app.world().resource::<Scenario>().name, "match7v7");
        // A match that cannot begin changes nothing.
        let wrong = MatchCommand::Teams(Box::new(TeamsSpec::new("nobody", "chasers")));
        send(&mut app, wrong);
        assert_eq!(app.world().resource::<Scenario>().name, "match7v7");
        send(&mut app, ViewerCommand::MatchBefore);
        assert_eq!(branches(&app), [2, 0]);
    }

    fn write_trace(path: &Path) {
        let mut app = App::new();
        app.add_plugins((NaoisisPlugins, RecordPlugin));
        app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
        recorder::start(app.world_mut(), vec![Box::new(TraceRecorder::create(path).unwrap())]);
        app.run_cycles(60);
        assert!(recorder::finish(app.world_mut(), EndReason::Duration).into_iter().all(|said| said.is_ok()));
    }

    #[test]
    fn a_trace_is_shown_again_at_the_moment_at_which_it_was_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.jsonl");
        write_trace(&path);
        let mut app = app();
        send(&mut app, MatchCommand::Open(path));
        // The thread may take any time: the test waits for it, but not for ever.
        for _ in 0..200_000 {
            if app.world().resource::<Timeline>().is_replay() && past(&app) == 60 {
                break;
            }
            app.update();
            std::thread::yield_now();
        }
        app.world_mut().resource_mut::<crate::viewer::shared::Playback>().paused = true;
        send(&mut app, TimelineCommand::GoTo(42));
        send(&mut app, ViewerCommand::Load("match7v7"));
        assert!(!app.world().resource::<Timeline>().is_replay());
        send(&mut app, ViewerCommand::MatchBefore);
        let timeline = app.world().resource::<Timeline>();
        assert_eq!((timeline.is_replay(), timeline.cursor(), past(&app)), (true, Some(42.0), 60));
    }

    #[test]
    fn several_matches_that_were_worked_on_are_kept_and_shown_in_turn() {
        let mut app = app();
        let branch = |app: &mut App| {
            (0..20).for_each(|_| app.update());
            let moment = Box::new(Moment::of(app.world_mut()).unwrap());
            let cycle = app.cycle();
            send(app, BranchCommand::PlayOn { moment, cycle, seed: 5, outcome: "nobody scores" });
        };
        for _ in 0..MOST_KEPT + 1 {
            branch(&mut app);
            send(&mut app, ViewerCommand::RestartWithNextSeed);
        }
        let notice = app.world().resource::<Notice>().text.clone();
        assert!(notice.contains("is kept: Backspace") && notice.contains("is kept no longer"), "{notice}");
        for _ in 0..2 {
            for _ in 0..MOST_KEPT {
                send(&mut app, ViewerCommand::MatchBefore);
                assert_eq!(branches(&app), [2, 1]);
            }
            // The match that was left last, without branches.
            send(&mut app, ViewerCommand::MatchBefore);
            assert_eq!(branches(&app), [1, 0]);
        }
    }

    #[test]
    fn a_match_that_is_brought_back_does_not_begin_again_because_its_file_has_changed_since() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("my.json");
        let write = |seed: u64, age_s: u64| {
            fs::write(&path, format!(r#"{{ "seed": {seed}, "robots": [{{ "number": 1 }}] }}"#)).unwrap();
            let time = SystemTime::now() - Duration::from_secs(age_s);
            File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
        };
        let seed = |app: &App| app.world().resource::<Scenario>().seed;
        let mut app = app();
        write(1, 300);
        send(&mut app, MatchCommand::Open(path.clone()));
        (0..30).for_each(|_| app.update());
        assert!(app.cycle() as f64 > SHORTEST_S * 30.0);
        for (next, age_s) in [(2, 200), (3, 100)] {
            write(next, age_s);
            (0..5).for_each(|_| app.update());
            assert_eq!(seed(&app), next);
        }
        send(&mut app, ViewerCommand::MatchBefore);
        (0..5).for_each(|_| app.update());
        assert_eq!(seed(&app), 1);
        // The next change counts.
        write(4, 50);
        (0..5).for_each(|_| app.update());
        assert_eq!(seed(&app), 4);
    }
}
