//! Saves a match: its state, to continue it later, and the trace of its past.

use bevy::prelude::*;
use std::path::{Path, PathBuf};
use std::thread::{self, JoinHandle};

use crate::viewer::branches::Place;
use crate::viewer::new_file::{stem, write_new};
use crate::viewer::shared::Notice;
use crate::viewer::timeline::Timeline;
use naoisis_core::communication::MessageStatistics;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, GameState, Rules};
use naoisis_record::record::history::History;
use naoisis_record::record::recorder::{EndReason, MatchEnd, Recorder};
use naoisis_record::record::trace::TraceRecorder;
use naoisis_sim::scenario::Scenario;
use naoisis_sim::scenario::saved_match::EXTENSION;
use naoisis_sim::simulation::resolved;

/// The folder for saved matches, and the traces that are being written in the background.
#[derive(Resource, Debug, Default)]
pub struct SavedMatches {
    /// The folder.
    pub folder: PathBuf,
    traces: Vec<(PathBuf, JoinHandle<Result<(), String>>)>,
}

/// Saves the match that is shown, and begins to write its trace.
pub(super) fn keep_match(world: &mut World) {
    let text = match keep(world) {
        Ok(path) => {
            let path = path.display();
            format!("Saved as {path}: `naoisis play {path}` continues it; its trace is being written beside it")
        }
        Err(message) => format!("The match was not saved: {message}"),
    };
    world.resource_mut::<Notice>().tell(text);
}

fn keep(world: &mut World) -> Result<PathBuf, String> {
    if world.resource::<Timeline>().is_replay() {
        return Err("it is a trace already; F branches from it, and a branch can be saved".to_owned());
    }
    let place = Place::of(world)?;
    let clock = *world.resource::<CycleClock>();
    let scenario = world.get_resource::<Scenario>().cloned().unwrap_or_default();
    let is_finished = world.resource::<Game>().state == GameState::Finished;
    let end = MatchEnd {
        reason: if is_finished { EndReason::FinalWhistle } else { EndReason::Interrupted },
        score: world.resource::<Game>().score,
        result: Some(world.resource::<Game>().result(world.resource::<Rules>())),
        cycles: clock.cycle,
        messages: *world.resource::<MessageStatistics>(),
    };
    place.show(world);
    let name = if scenario.name.is_empty() { "match".to_owned() } else { stem(&scenario.name) };
    let folder = world.resource::<SavedMatches>().folder.clone();
    let path = write_new(&folder, &format!("{name}-{:06}", clock.cycle), EXTENSION, place.present_bytes())
        .map_err(|error| error.to_string())?;
    let trace = path.with_extension("jsonl.zst");
    if trace.exists() {
        return Err(format!("{} exists; the state of the match is in {}", trace.display(), path.display()));
    }
    let (of_thread, scenario) = (trace.clone(), resolved(world, &scenario));
    let mut history = world.resource::<History>().clone();
    let write = move || write_trace(&of_thread, &scenario, &mut history, &end);
    let thread = thread::Builder::new().name("trace".to_owned()).spawn(write).map_err(|error| error.to_string())?;
    world.resource_mut::<SavedMatches>().traces.push((trace, thread));
    Ok(path)
}

/// Writes the records of a match as a trace.
fn write_trace(path: &Path, scenario: &Scenario, history: &mut History, end: &MatchEnd) -> Result<(), String> {
    let Some(cycles) = history.cycles() else { return Ok(()) };
    let recorder = TraceRecorder::create(path).map_err(|error| error.to_string())?;
    let mut recorder = recorder.every(history.every());
    let mut world = World::new();
    let mut last = None;
    let mut cycle = *cycles.start();
    while let Some(record) = history.record(cycle).map_err(|error| error.to_string())? {
        match last {
            None => recorder.start(scenario, &record, &mut world),
            Some(_) => recorder.record(&record, &mut world),
        }
        cycle = record.cycle + 1;
        last = Some(record);
    }
    let Some(last) = last else { return Ok(()) };
    Box::new(recorder).finish(end, &last).map(drop).map_err(|error| error.to_string())
}

/// Says when traces have been written. When the window closes, they are completed first.
pub(super) fn tell_of_traces(
    mut exits: MessageReader<AppExit>,
    mut saved: ResMut<SavedMatches>,
    mut notice: ResMut<Notice>,
) {
    let is_end = exits.read().count() > 0;
    let written = |(_, thread): &mut (PathBuf, JoinHandle<_>)| is_end || thread.is_finished();
    if !saved.traces.iter().any(|(_, thread)| is_end || thread.is_finished()) {
        return;
    }
    for (path, thread) in saved.traces.extract_if(.., written) {
        let path = path.display();
        let text = match thread.join() {
            Ok(Ok(())) => format!("Saved {path}: `naoisis replay {path}` shows it"),
            Ok(Err(message)) => format!("The trace was not saved: {message}"),
            Err(_) => format!("The trace was not saved: {path}"),
        };
        notice.tell(text);
    }
}
