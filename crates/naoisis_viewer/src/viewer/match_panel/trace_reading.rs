//! Reads traces on a thread, and shows them from the first records on.

use bevy::prelude::*;
use core::ops::ControlFlow;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use crate::viewer::event_log::EventLog;
use crate::viewer::shared::{Notice, Playback};
use crate::viewer::theme::minutes;
use crate::viewer::timeline::Timeline;
use naoisis_record::record::history::History;
use naoisis_record::record::read::{Ending, TraceError};
use naoisis_record::record::read_trace::{ReadTrace, TraceParts};

/// The number of records with which a trace is shown.
const FIRST_RECORDS: usize = 128;
/// The number of records that are added to it at once.
const MORE_RECORDS: usize = 1024;

/// The notice about a trace without an end.
const BROKEN_OFF: &str = "the trace is incomplete: it is shown as far as it goes";

/// The trace that is being read, if any.
#[derive(Resource, Default)]
pub struct TraceReading(Option<Reading>);

struct Reading {
    path: PathBuf,
    parts: Mutex<Receiver<Result<ReadTrace, TraceError>>>,
    /// Whether the first part is shown.
    is_shown: bool,
    progress: Arc<Progress>,
}

/// The state that the thread and the window share.
#[derive(Default)]
struct Progress {
    /// The time until which the trace has been read, s.
    until_s: AtomicU32,
    /// Whether reading was cancelled.
    is_given_up: AtomicBool,
}

impl Drop for Reading {
    fn drop(&mut self) {
        self.progress.is_given_up.store(true, Ordering::Relaxed);
    }
}

impl TraceReading {
    /// Starts reading a trace. Cancels reading of any other.
    ///
    /// # Errors
    /// When the system cannot start a thread.
    pub fn begin(&mut self, path: &Path) -> io::Result<()> {
        let (sender, receiver) = mpsc::channel();
        let progress = Arc::<Progress>::default();
        let reading = Reading {
            path: path.to_owned(),
            parts: Mutex::new(receiver),
            is_shown: false,
            progress: Arc::clone(&progress),
        };
        let path = path.to_owned();
        thread::Builder::new().name("trace".to_owned()).spawn(move || read(&path, &sender, &progress))?;
        self.0 = Some(reading);
        Ok(())
    }

    /// Returns whether a trace is being read.
    pub fn is_on(&self) -> bool {
        self.0.is_some()
    }

    /// Cancels reading.
    pub fn give_up(&mut self) {
        self.0 = None;
    }

    /// Waits for the first part, and says that it is shown.
    ///
    /// # Errors
    /// The error of the trace; `None` if no trace is being read.
    pub fn wait(&mut self) -> Result<ReadTrace, Option<TraceError>> {
        let reading = self.0.as_mut().ok_or(None)?;
        let part = reading.parts.lock().unwrap_or_else(PoisonError::into_inner).recv();
        reading.is_shown = true;
        part.map_err(|_| None)?.map_err(Some)
    }

    /// The next part, once it has been read.
    fn take(&mut self) -> Option<Result<ReadTrace, String>> {
        let reading = self.0.as_ref()?;
        let part = reading.parts.lock().unwrap_or_else(PoisonError::into_inner).try_recv();
        match part {
            Ok(part) => Some(part.map_err(|error| error.to_string())),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(format!("{}: reading failed", reading.path.display()))),
        }
    }
}

/// Reads a trace and sends its parts until it ends, cannot be read or is no longer wanted.
fn read(path: &Path, sender: &Sender<Result<ReadTrace, TraceError>>, progress: &Progress) {
    let mut parts = match TraceParts::open(path) {
        Ok(parts) => parts,
        Err(error) => {
            let _nobody_waits = sender.send(Err(error));
            return;
        }
    };
    let mut records = FIRST_RECORDS;
    loop {
        let part = parts.next_part(records, |time_s| {
            progress.until_s.store(time_s as u32, Ordering::Relaxed);
            let is_given_up = progress.is_given_up.load(Ordering::Relaxed);
            if is_given_up { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let is_last = !part.as_ref().is_ok_and(|part| part.ending == Ending::NotYet);
        if sender.send(part).is_err() || is_last {
            return;
        }
        records = MORE_RECORDS;
    }
}

/// Whether a trace is being read.
pub(super) fn is_reading(reading: Res<TraceReading>) -> bool {
    reading.0.is_some()
}

/// The first word of the progress.
const READING: &str = "Reading ";

/// Whether a notice is about the progress. Others are not replaced by it.
fn is_progress(notice: &Notice) -> bool {
    notice.text.starts_with(READING)
}

/// Shows the trace once its first part has been read, and adds the other parts.
pub(super) fn show_when_read(world: &mut World) {
    let Some(Reading { path, is_shown, progress, .. }) = &world.resource::<TraceReading>().0 else { return };
    let (path, is_shown) = (path.clone(), *is_shown);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let words = format!("{READING}{name}: {}", minutes(progress.until_s.load(Ordering::Relaxed) as f32));
    if is_shown && !world.resource::<Timeline>().is_replay() {
        // Another branch is shown. The rest is added when the trace is shown again.
        return;
    }
    let Some(part) = world.resource_mut::<TraceReading>().take() else {
        if world.get_resource::<Notice>().is_some_and(|notice| notice.left_s <= 0.0 || is_progress(notice)) {
            notify(world, &words);
        }
        return;
    };
    let is_last = !part.as_ref().is_ok_and(|part| part.ending == Ending::NotYet);
    let is_broken_off = part.as_ref().is_ok_and(|part| part.ending == Ending::BrokenOff);
    let shown = part.and_then(|part| match is_shown {
        false => super::show_trace(world, &path, part),
        true => add(world, part),
    });
    let shown = shown.map_err(|error| match is_shown {
        true => format!("{error}. The trace is shown up to there."),
        false => error,
    });
    let is_wrong = shown.is_err();
    if is_last || is_wrong {
        world.resource_mut::<TraceReading>().give_up();
        if let Some(mut notice) = world.get_resource_mut::<Notice>().filter(|notice| is_progress(notice)) {
            notice.left_s = 0.0;
        }
    } else if let Some(reading) = &mut world.resource_mut::<TraceReading>().0 {
        reading.is_shown = true;
    }
    let problem = shown.err().or_else(|| is_broken_off.then(|| format!("{name}: {BROKEN_OFF}")));
    if problem.is_some() || !is_shown {
        world.resource_mut::<Playback>().problem = problem;
    }
}

fn notify(world: &mut World, words: &str) {
    if let Some(mut notice) = world.get_resource_mut::<Notice>() {
        notice.tell(words);
    }
}

/// Adds a part to the trace that is shown.
fn add(world: &mut World, part: ReadTrace) -> Result<(), String> {
    world.resource_mut::<History>().append(part.history).map_err(|error| error.to_string())?;
    let mut log = world.resource_mut::<EventLog>();
    part.events.iter().for_each(|(time_s, event)| log.note(*time_s, [event]));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::drive::DrivePlugin;
    use crate::viewer::event_log::EventLogPlugin;
    use crate::viewer::match_panel::{MatchCommand, MatchPanelPlugin};
    use crate::viewer::timeline::Timeline;
    use naoisis_record::record::RecordPlugin;
    use naoisis_record::record::recorder::{self, EndReason};
    use naoisis_record::record::trace::TraceRecorder;
    use naoisis_sim::scenario::Scenario;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};
    use std::fs;

    fn app() -> App {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin, MatchPanelPlugin))
            .init_resource::<Notice>();
        app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
        app.update();
        app
    }

    fn write_trace(path: &Path, seed: u64) {
        let mut app = App::new();
        app.add_plugins((NaoisisPlugins, RecordPlugin));
        app.start_match(&Scenario { seed, ..Scenario::named("match3v3").unwrap() }).unwrap();
        recorder::start(app.world_mut(), vec![Box::new(TraceRecorder::create(path).unwrap())]);
        app.run_cycles(60);
        assert!(recorder::finish(app.world_mut(), EndReason::Duration).into_iter().all(|said| said.is_ok()));
    }

    const LONG: u64 = 1500;

    /// Writes a trace of several parts.
    fn write_long_trace(path: &Path) {
        let mut app = App::new();
        app.add_plugins((NaoisisPlugins, RecordPlugin));
        app.start_match(&Scenario::default()).unwrap();
        recorder::start(app.world_mut(), vec![Box::new(TraceRecorder::create(path).unwrap())]);
        app.run_cycles(LONG as usize);
        assert!(recorder::finish(app.world_mut(), EndReason::Duration).into_iter().all(|said| said.is_ok()));
    }

    /// Opens a file and waits until it or its error is shown.
    fn open(app: &mut App, path: &Path) {
        app.world_mut().write_message(MatchCommand::Open(path.to_owned()));
        app.update();
        while app.world().resource::<TraceReading>().0.is_some() {
            app.update();
            thread::yield_now();
        }
    }

    #[test]
    fn a_trace_is_shown_when_it_is_read_and_one_that_is_broken_leaves_the_match_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        write_trace(&path("one.jsonl"), 1);
        write_trace(&path("other.jsonl"), 2);
        let mut app = app();
        let shown = |app: &App| app.world().resource::<Timeline>().trace_scenario().map(|scenario| scenario.seed);
        open(&mut app, &path("one.jsonl"));
        assert_eq!(shown(&app), Some(1));
        // If another trace is opened meanwhile, that one is shown.
        app.world_mut().write_message(MatchCommand::Open(path("one.jsonl")));
        open(&mut app, &path("other.jsonl"));
        assert_eq!(shown(&app), Some(2));
        let text = fs::read_to_string(path("one.jsonl")).unwrap();
        fs::write(path("broken.jsonl"), text.replacen("\"cycle\"", "\"bicycle\"", 3)).unwrap();
        for name in ["broken.jsonl", "nowhere.jsonl"] {
            open(&mut app, &path(name));
            assert_eq!(shown(&app), Some(2));
            let problem = app.world().resource::<Playback>().problem.clone().unwrap_or_default();
            assert!(problem.contains(name), "{problem}");
        }
        // A long trace is shown completely.
        write_long_trace(&path("long.jsonl"));
        open(&mut app, &path("long.jsonl"));
        assert_eq!(app.world().resource::<History>().cycles(), Some(0..=LONG));
        let last = app.world_mut().resource_mut::<History>().record(LONG).unwrap().unwrap();
        assert_eq!(last.cycle, LONG);
        // If the end of a trace is broken, the problem is reported and the part before it is shown.
        let text = fs::read_to_string(path("long.jsonl")).unwrap();
        fs::write(path("long.jsonl"), text.replace(&format!("\"cycle\":{LONG},"), "\"bicycle\":1,")).unwrap();
        open(&mut app, &path("long.jsonl"));
        let problem = app.world().resource::<Playback>().problem.clone().unwrap_or_default();
        assert!(problem.contains("long.jsonl"), "{problem}");
        assert_eq!(app.world().resource::<History>().last_cycle(), Some(LONG - 1), "up to the broken line");
        // A match that was started meanwhile is not replaced by a trace that was opened before.
        app.world_mut().write_message(MatchCommand::Open(path("one.jsonl")));
        open(&mut app, Path::new("match3v3"));
        (0..10).for_each(|_| app.update());
        assert_eq!(shown(&app), None);
    }
}
