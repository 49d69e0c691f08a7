//! Reads traces on a thread, because a long one takes many seconds.

use bevy::prelude::*;
use core::ops::ControlFlow;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use crate::viewer::shared::{Notice, Playback};
use naoisis_record::record::read_trace::ReadTrace;

/// The trace that is being read, if any.
#[derive(Resource, Default)]
pub struct TraceReading(Option<Reading>);

struct Reading {
    path: PathBuf,
    trace: Mutex<Receiver<Result<ReadTrace, String>>>,
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
        let reading = Reading { path: path.to_owned(), trace: Mutex::new(receiver), progress: progress.clone() };
        let path = path.to_owned();
        thread::Builder::new().name("trace".to_owned()).spawn(move || {
            let told = |time_s: f64| {
                progress.until_s.store(time_s as u32, Ordering::Relaxed);
                if progress.is_given_up.load(Ordering::Relaxed) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            };
            let _nobody_waits = sender.send(ReadTrace::open_told(&path, told).map_err(|error| error.to_string()));
        })?;
        self.0 = Some(reading);
        Ok(())
    }

    /// Cancels reading.
    pub fn give_up(&mut self) {
        self.0 = None;
    }

    /// The trace, once it has been read.
    fn take(&mut self) -> Option<(PathBuf, Result<ReadTrace, String>)> {
        let reading = self.0.as_ref()?;
        let trace = reading.trace.lock().unwrap_or_else(PoisonError::into_inner).try_recv();
        let result = match trace {
            Ok(result) => result,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err(format!("{}: reading failed", reading.path.display())),
        };
        let path = reading.path.clone();
        self.0 = None;
        Some((path, result))
    }
}

/// Whether a trace is being read.
pub(super) fn is_reading(reading: Res<TraceReading>) -> bool {
    reading.0.is_some()
}

/// Shows the trace once it has been read, and the progress before.
pub(super) fn show_when_read(world: &mut World) {
    let mut reading = world.resource_mut::<TraceReading>();
    match reading.take() {
        Some((path, trace)) => {
            let shown = trace.and_then(|trace| super::show_trace(world, &path, trace));
            if shown.is_ok()
                && let Some(mut notice) = world.get_resource_mut::<Notice>()
            {
                notice.left_s = 0.0;
            }
            world.resource_mut::<Playback>().problem = shown.err();
        }
        None => {
            let Some(Reading { path, progress, .. }) = &reading.0 else { return };
            let words = format!("Reading {}: {} s", path.display(), progress.until_s.load(Ordering::Relaxed));
            if let Some(mut notice) = world.get_resource_mut::<Notice>() {
                notice.tell(words);
            }
        }
    }
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
        // Who opens another one meanwhile wants that.
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
        // A match in its place is not replaced by what was asked for before.
        app.world_mut().write_message(MatchCommand::Open(path("one.jsonl")));
        open(&mut app, Path::new("match3v3"));
        (0..10).for_each(|_| app.update());
        assert_eq!(shown(&app), None);
    }
}
