//! Saves a match: its state, to continue it later, the trace of its past, and a web page.

use bevy::prelude::*;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::thread::{self, JoinHandle};

use crate::viewer::branches::Place;
use crate::viewer::keyframes::Simulator;
use crate::viewer::new_file::{new_path, stem, write_new};
use crate::viewer::shared::{Notice, OpenedTrace, TraceSaved};
use crate::viewer::timeline::Timeline;
use naoisis_core::communication::MessageStatistics;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, GameState, Rules};
use naoisis_core::replace_file::replace_file;
use naoisis_core::team::PerTeam;
use naoisis_record::record::history::History;
use naoisis_record::record::page::{PageRecorder, page_of_trace};
use naoisis_record::record::read::TraceReader;
use naoisis_record::record::recorder::{EndReason, MatchEnd, Recorder};
use naoisis_record::record::team_names::team_names;
use naoisis_record::record::trace::TraceRecorder;
use naoisis_sim::scenario::saved_match::EXTENSION;
use naoisis_sim::scenario::{Scenario, TeamsSpec};
use naoisis_sim::simulation::resolved;

/// The folder for saved matches, and the traces and pages that are being written in the background.
#[derive(Resource, Debug, Default)]
pub struct SavedFiles {
    /// The folder.
    pub folder: PathBuf,
    /// The match that was saved last.
    last: Option<PathBuf>,
    files: Vec<(PathBuf, JoinHandle<Result<(), String>>)>,
}

/// Saves the match that is shown, and begins to write its trace.
pub(super) fn saved_files(world: &mut World) {
    let text = match keep(world) {
        Ok(path) => match_words(world.resource(), &path),
        Err(message) => format!("The match was not saved: {message}"),
    };
    world.resource_mut::<Notice>().tell(text);
}

/// Returns the notice about a match that is saved in the file `path`.
pub(super) fn match_words(saved: &SavedFiles, path: &Path) -> String {
    let trace = trace_of(path);
    // The file has its name from its first line on, so only the list tells whether it is complete.
    let is_being_written = saved.files.iter().any(|(file, _)| *file == trace);
    let (path, trace) = (path.display(), if is_being_written { "is being written" } else { "is" });
    format!("Saved as {path}: `naoisis play {path}` continues it; its trace {trace} beside it")
}

/// Saves the state of the match, and begins to write its trace: the same name with another ending. Returns the file of the state,
/// which is that of the last call if the match is still as it was.
///
/// # Errors
/// Why the match cannot be saved, such as that a trace is shown.
pub fn keep(world: &mut World) -> Result<PathBuf, String> {
    if world.resource::<Timeline>().is_replay() {
        return Err("it is a trace already; F branches from it, and a branch can be saved".to_owned());
    }
    let place = Place::of(world)?;
    let end = end_now(world);
    place.show(world);
    let scenario = world.get_resource::<Scenario>().cloned().unwrap_or_default();
    let saved = world.resource::<SavedFiles>();
    let is_now = |path: &&PathBuf| fs::read(path).is_ok_and(|bytes| bytes == place.present_bytes());
    let has_trace = |path: &&PathBuf| {
        let trace = trace_of(path);
        trace.exists() || saved.files.iter().any(|(other, _)| *other == trace)
    };
    if let Some(last) = saved.last.as_ref().filter(has_trace).filter(is_now) {
        return Ok(last.clone());
    }
    let folder = saved.folder.clone();
    let path = write_new(&folder, &name(&scenario, end.cycles), EXTENSION, place.present_bytes())
        .map_err(|error| error.to_string())?;
    let trace = trace_of(&path);
    if trace.exists() {
        return Err(format!("{} exists; the state of the match is in {}", trace.display(), path.display()));
    }
    let (of_thread, scenario) = (trace.clone(), resolved(world, &scenario));
    let mut history = world.resource::<History>().clone();
    write_behind(world, trace, move || {
        let recorder = TraceRecorder::create(&of_thread).map_err(|error| error.to_string())?;
        write(Box::new(recorder.every(history.every())), &scenario, &mut history, &end)
    })?;
    world.resource_mut::<SavedFiles>().last = Some(path.clone());
    if let Some(mut saved) = world.get_resource_mut::<Messages<TraceSaved>>() {
        saved.write(TraceSaved(trace_of(&path)));
    }
    Ok(path)
}

/// Returns the trace that is written beside the saved match in the file `path`.
pub fn trace_of(path: &Path) -> PathBuf {
    path.with_extension("jsonl.zst")
}

/// Begins to write the match that is shown as a web page.
///
/// # Errors
/// Why it cannot be written.
pub fn save_page(world: &mut World) -> Result<PathBuf, String> {
    let scenario = world.get_resource::<Scenario>().cloned().unwrap_or_default();
    let shown = world.get_resource::<OpenedTrace>().and_then(|trace| trace.0.clone());
    let shown = shown.filter(|_| world.resource::<Timeline>().is_replay());
    let (place, mut history) = (Place::of(world)?, world.resource::<History>().clone());
    let end = end_now(world);
    place.show(world);
    let folder = world.resource::<SavedFiles>().folder.clone();
    let cycles = history.last_cycle().unwrap_or(end.cycles);
    let files = &world.resource::<SavedFiles>().files;
    let is_taken = |path: &Path| files.iter().any(|(other, _)| other == path);
    let path = new_path(&folder, &name(&scenario, cycles), "html", is_taken).map_err(|error| error.to_string())?;
    let of_thread = path.clone();
    match (shown, world.get_resource::<Simulator>().copied()) {
        (Some(trace), Some(Simulator(simulator))) => write_behind(world, path.clone(), move || {
            let mut reader = TraceReader::open(&trace).map_err(|error| error.to_string())?;
            let page = page_of_trace(&mut reader, simulator().world().resource());
            replace_file(&of_thread, |mut file| file.write_all(page.map_err(io::Error::other)?.as_bytes()))
                .map_err(|error| error.to_string())
        })?,
        _ => {
            let PerTeam { blue, pink } = team_names(&scenario, world.resource());
            let teams = Some(TeamsSpec::new(blue, pink));
            let scenario = Scenario { teams, ..resolved(world, &scenario) };
            write_behind(world, path.clone(), move || {
                let recorder = PageRecorder::create(&of_thread).map_err(|error| error.to_string())?;
                write(Box::new(recorder), &scenario, &mut history, &end)
            })?;
        }
    }
    Ok(path)
}

/// The name of the files of a match of so many cycles.
fn name(scenario: &Scenario, cycles: u64) -> String {
    let name = if scenario.name.is_empty() { "match".to_owned() } else { stem(&scenario.name) };
    format!("{name}-{cycles:06}")
}

/// The end of the match in `world`, if it ends now.
fn end_now(world: &World) -> MatchEnd {
    let game = world.resource::<Game>();
    MatchEnd {
        reason: if game.state == GameState::Finished { EndReason::FinalWhistle } else { EndReason::Interrupted },
        score: game.score,
        result: Some(game.result(world.resource::<Rules>())),
        cycles: world.resource::<CycleClock>().cycle,
        messages: *world.resource::<MessageStatistics>(),
    }
}

/// Writes a file in the background.
fn write_behind(
    world: &mut World,
    path: PathBuf,
    write: impl FnOnce() -> Result<(), String> + Send + 'static,
) -> Result<(), String> {
    let thread =
        thread::Builder::new().name("saved match".to_owned()).spawn(write).map_err(|error| error.to_string())?;
    world.resource_mut::<SavedFiles>().files.push((path, thread));
    Ok(())
}

/// Gives the records of a match to a recorder.
fn write(
    mut recorder: Box<dyn Recorder>,
    scenario: &Scenario,
    history: &mut History,
    end: &MatchEnd,
) -> Result<(), String> {
    let Some(cycles) = history.cycles() else { return Ok(()) };
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
    recorder.finish(end, &last).map(drop).map_err(|error| error.to_string())
}

/// The words about the saved match beside a trace, if there is one.
fn and_match(trace: &Path) -> String {
    let saved = trace.with_extension("").with_extension(EXTENSION);
    let is_there = trace_of(&saved) == trace && saved.exists();
    if is_there { format!("; `naoisis play {}` continues the match", saved.display()) } else { String::new() }
}

/// Says when files have been written. When the window closes, they are completed first.
pub(super) fn tell_of_files(
    mut exits: MessageReader<AppExit>,
    mut saved: ResMut<SavedFiles>,
    mut notice: ResMut<Notice>,
) {
    let is_end = exits.read().count() > 0;
    let written = |(_, thread): &mut (PathBuf, JoinHandle<_>)| is_end || thread.is_finished();
    if !saved.files.iter().any(|(_, thread)| is_end || thread.is_finished()) {
        return;
    }
    for (path, thread) in saved.files.extract_if(.., written) {
        let is_page = path.extension().is_some_and(|ending| ending == "html");
        let (file, path) = (path.clone(), path.display());
        let text = match thread.join() {
            Ok(Ok(())) if is_page => format!("Saved {path}: a browser plays it"),
            // A copied command has its name, and stays to be read.
            Ok(Ok(())) if notice.left_s > 0.0 && notice.text.contains(&path.to_string()) => continue,
            Ok(Ok(())) => format!("Saved {path}: `naoisis replay {path}` shows it{}", and_match(&file)),
            Ok(Err(message)) => format!("{path} was not saved: {message}"),
            Err(_) => format!("{path} was not saved"),
        };
        notice.tell(text);
    }
}
