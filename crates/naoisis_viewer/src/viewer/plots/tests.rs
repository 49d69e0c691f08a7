use super::*;
use crate::viewer::commands::{TimelineCommand, ViewerCommand};
use crate::viewer::cycle_samples::CycleSamplesPlugin;
use crate::viewer::drive::DrivePlugin;
use crate::viewer::event_log::EventLogPlugin;
use crate::viewer::rebuild::RebuildPlugin;
use crate::viewer::shared::Playback;
use crate::viewer::timeline::start_replay;
use bevy::time::TimeUpdateStrategy;
use core::time::Duration;
use naoisis_core::team::Team;
use naoisis_record::record::read_trace::ReadTrace;
use naoisis_record::record::recorder::{self, EndReason};
use naoisis_record::record::trace::TraceRecorder;
use naoisis_sim::scenario::Scenario;
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

const BLUE2: RobotId = RobotId::new(Team::Blue, 2);

fn simulator() -> App {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    app
}

/// The window without rendering, with ten cycles per frame.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin, RebuildPlugin, CycleSamplesPlugin));
    app.init_resource::<Plots>().init_resource::<FieldList>().add_message::<PlotCommand>();
    app.add_systems(Update, (list_fields, apply, reset, listen, ask).chain())
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(333_340)))
        .insert_resource(Simulator(&simulator))
        .init_resource::<DisplaySettings>()
        .init_resource::<Selection>();
    app
}

fn started() -> App {
    let mut app = app();
    app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
    app.update();
    app
}

/// The field with this name.
fn field(app: &App, name: &str) -> Field {
    let list = app.world().resource::<FieldList>();
    let names: Vec<String> = list.all().iter().map(KnownField::full_name).collect();
    let known = list.all().iter().find(|known| known.full_name() == name);
    known.unwrap_or_else(|| panic!("no field `{name}` in {names:#?}")).field.clone()
}

fn pin(app: &mut App, name: &str) -> Field {
    let field = field(app, name);
    app.world_mut().write_message(PlotCommand::Toggle(field.clone(), Some(BLUE2)));
    app.update();
    field
}

/// Runs frames until all values of a field are known from the start to a cycle.
fn wait(app: &mut App, field: &Field, cycle: u64) {
    for _ in 0..200_000 {
        app.update();
        let plots = app.world().resource::<Plots>();
        let known = &plots.data[field];
        assert_eq!(known.fault, None);
        if known.until > cycle || known.since.is_some_and(|since| known.until >= since) {
            return;
        }
        std::thread::yield_now();
    }
    panic!("it was never found out: {:?}", app.world().resource::<Plots>().data[field]);
}

fn values(app: &App, field: &Field, cycles: core::ops::Range<u64>) -> Vec<Option<f32>> {
    let plots = app.world().resource::<Plots>();
    let series = plots.series(field, Subject::Robot(BLUE2));
    cycles.map(|cycle| series.and_then(|series| series.value(cycle))).collect()
}

const NAMES: [&str; 4] =
    ["belief: pose, position x", "player memory: attacks", "error of its own position", "pose: heading"];

/// A match in which fields were plotted from the start.
fn plotted_from_the_start() -> (App, Vec<Field>) {
    let mut app = started();
    app.world_mut().resource_mut::<DisplaySettings>().plots = true;
    app.world_mut().resource_mut::<Playback>().paused = true;
    app.update();
    let fields: Vec<Field> = NAMES.iter().map(|name| pin(&mut app, name)).collect();
    app.world_mut().resource_mut::<Playback>().paused = false;
    while app.cycle() < 320 {
        app.update();
    }
    (app, fields)
}

#[test]
fn what_was_before_somebody_looked_is_as_if_they_had_looked_all_the_time() {
    let (looked, fields) = plotted_from_the_start();
    let mut later = started();
    while later.cycle() < 320 {
        later.update();
    }
    later.world_mut().resource_mut::<Playback>().paused = true;
    later.update();
    for (name, field) in NAMES.iter().zip(&fields) {
        let pinned = pin(&mut later, name);
        assert_eq!(pinned, *field);
        wait(&mut later, field, 319);
        let expected = values(&looked, field, 20..320);
        assert!(expected.iter().any(Option::is_some), "{name}");
        assert_eq!(values(&later, field, 20..320), expected, "{name}");
    }
}

#[test]
fn a_trace_has_the_curves_of_its_match_even_of_what_it_leaves_out() {
    let (looked, fields) = plotted_from_the_start();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("match.jsonl.zst");
    let mut played = started();
    played.world_mut().write_message(ViewerCommand::Restart);
    recorder::start(played.world_mut(), vec![Box::new(TraceRecorder::create(&path).unwrap())]);
    while played.cycle() < 300 {
        played.update();
    }
    assert!(recorder::finish(played.world_mut(), EndReason::Duration).into_iter().all(|said| said.is_ok()));

    let mut replay = app();
    start_replay(replay.world_mut(), ReadTrace::open(&path).unwrap()).unwrap();
    replay.world_mut().resource_mut::<DisplaySettings>().plots = true;
    replay.update();
    replay.world_mut().write_message(TimelineCommand::GoTo(200));
    // The components of behaviours are known once a moment has been rebuilt.
    for _ in 0..200_000 {
        replay.update();
        if replay.world().resource::<Rebuilt>().latest_states().next().is_some() {
            break;
        }
        std::thread::yield_now();
    }
    // The components are only searched every few frames.
    (0..5).for_each(|_| replay.update());
    for (name, field) in NAMES.iter().zip(&fields).take(2) {
        let pinned = pin(&mut replay, name);
        wait(&mut replay, &pinned, 299);
        let (shown, expected) = (values(&replay, field, 20..300), values(&looked, field, 20..300));
        assert_eq!(shown, expected, "{name}");
    }
}

#[test]
fn robots_get_curves_and_lose_them() {
    let (mut pins, field) = (Vec::new(), Field("speed".to_owned()));
    let [one, two] = [RobotId::new(Team::Blue, 1), RobotId::new(Team::Pink, 1)];
    toggle(&mut pins, &field, [one].into());
    toggle(&mut pins, &field, [two].into());
    assert_eq!(pins[0].robots, [one, two].into());
    toggle(&mut pins, &field, [one].into());
    assert_eq!(pins[0].robots, [two].into());
    toggle(&mut pins, &field, [two].into());
    assert!(pins.is_empty(), "a plot without curves goes");
    for index in 0..100 {
        toggle(&mut pins, &Field(index.to_string()), [one].into());
    }
    assert_eq!(pins.len(), MOST_PINS);
}

#[test]
fn no_name_is_that_of_a_type_and_each_field_has_its_own() {
    let mut app = started();
    app.world_mut().resource_mut::<DisplaySettings>().plots = true;
    app.update();
    let list = app.world().resource::<FieldList>();
    assert!(list.all().len() > 60, "{}", list.all().len());
    let mut keys = BTreeSet::new();
    for known in list.all() {
        let name = known.full_name();
        assert!(!name.contains("::") && !name.contains('_') && !name.contains('<'), "{name}");
        assert!(!name.chars().any(char::is_uppercase), "{name}");
        assert!(keys.insert(known.field.clone()), "{:?}", known.field);
    }
}
