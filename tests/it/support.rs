//! What the tests share.

use bevy::prelude::*;
use naoisis::prelude::*;
use naoisis::record::trace::TraceRecorder;
use naoisis::record::{RecordPlugin, recorder};
use std::io::{self, Write};
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Arc, Mutex};

/// A headless app, ready for a match.
pub fn headless_app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, NaoisisPlugins));
    app
}

/// A match from a scenario in JSON.
pub fn match_of(json: &str) -> App {
    let scenario = Scenario::from_json(json).unwrap_or_else(|error| panic!("{error}"));
    let mut app = headless_app();
    app.start_match(&scenario).unwrap_or_else(|error| panic!("{error}"));
    app
}

/// What a program has written, as text.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Blue's robot with this number.
pub const fn blue(number: u8) -> RobotId {
    RobotId::new(Team::Blue, number)
}

/// Pink's robot with this number.
pub const fn pink(number: u8) -> RobotId {
    RobotId::new(Team::Pink, number)
}

/// Runs so many cycles and collects what happened in them, with the cycle's number.
pub fn collect_events(app: &mut App, cycles: usize) -> Vec<(u64, MatchEvent)> {
    let mut events = Vec::new();
    for _ in 0..cycles {
        app.run_cycles(1);
        let cycle = app.cycle();
        events.extend(app.events().iter().map(|event| (cycle, event.clone())));
    }
    events
}

/// Begins a trace of the match in an app: what is written of it.
pub fn begin_trace(app: &mut App) -> SharedBytes {
    let bytes = SharedBytes::default();
    if !app.is_plugin_added::<RecordPlugin>() {
        app.add_plugins(RecordPlugin);
    }
    recorder::start(app.world_mut(), vec![Box::new(TraceRecorder::plain("trace", bytes.clone()))]);
    bytes
}

/// A writer whose bytes can be looked at afterwards.
#[derive(Clone, Default)]
pub struct SharedBytes(Arc<Mutex<Vec<u8>>>);

impl SharedBytes {
    /// What was written.
    pub fn written(&self) -> Vec<u8> {
        self.0.lock().unwrap().clone()
    }
}

impl Write for SharedBytes {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// What the command prints and how it ends, run as its user runs it: in a folder of its own, without a display.
pub fn naoisis(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_naoisis"));
    command.current_dir(folder).env_remove("DISPLAY").args(arguments).output().unwrap()
}
