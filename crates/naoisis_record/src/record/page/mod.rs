//! Writes a match as a page for a browser: a single file that plays the match without loading anything else.
//!
//! The [template](TEMPLATE) is the page without a match, built from the sources in `web`. Blocks follow it, each in a script element with
//! base64 data and a full stop. A block is a zlib stream with the length of a JSON object (four bytes, little-endian), the object, and the columns that
//! it names. Names of robots and teams, words of events and all other texts that a file or a program may choose are in these objects, so
//! that they are never read as markup. The page shows them as text.
//!
//! | block | when | contents |
//! |---|---|---|
//! | `match` | at the start | name, seed, pitch, robots with bodies and cameras |
//! | `part` | after 7.5 s of the match, then at doubling intervals up to 2 min | its number from 1, columns, events with their reasons, kicks, decisions, new texts |
//! | `end` | at the end | the number of parts, score, tables and heat maps |
//!
//! If the program is killed, the page has all parts that were written, and says that it breaks off. A column has whole numbers, one for
//! each sample, or rows of lists. The truth is sampled 30 times a second and everything else 10 times. Resolution: poses 5 mm and 0.5°,
//! head 2°, ball and targets 2 cm, believed robots 5 cm, percepts 8 cm, half axes of ellipses 15 %.
//!
//! ```
//! use naoisis::prelude::*;
//! use naoisis::record::page::PageRecorder;
//! use naoisis::record::recorder::{self, EndReason};
//! use naoisis::record::RecordPlugin;
//!
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("match.html");
//! let mut app = bevy::app::App::new();
//! app.add_plugins((NaoisisPlugins, RecordPlugin));
//! app.start_match(&Scenario::named("match3v3")?)?;
//! recorder::start(app.world_mut(), vec![Box::new(PageRecorder::create(&path)?)]);
//! app.run_cycles(90);
//! recorder::finish(app.world_mut(), EndReason::Interrupted);
//! assert!(std::fs::read_to_string(&path)?.starts_with("<!doctype html>"));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

mod block;
mod columns;
mod described;
mod robot_columns;
mod strings;
#[cfg(test)]
mod tests;
mod writer;

use bevy::prelude::*;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

pub use writer::PageWriter;

use super::output_file::OutputFile;
use super::read::{TraceError, TraceReader};
use super::recorder::{MatchEnd, RecordError, Recorder};
use super::team_names::team_names;
use super::trace_lines::TraceExtent;
use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::behaviour::reasons::ask_for_reasons;
use naoisis_core::team::PerTeam;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::scenario::{Scenario, TeamsSpec};

/// The page without a match, built by `web/build.js`.
pub const TEMPLATE: &str = include_str!("page.html");

/// A page that is being made: the complete part, and the writer of the rest.
#[derive(Default)]
struct Page {
    text: String,
    writer: Option<PageWriter>,
}

/// The page of a match, during and after its recording by a [`PageRecorder`].
#[derive(Clone, Default)]
pub struct PageSoFar(Arc<Mutex<Page>>);

impl PageSoFar {
    /// Returns the page up to now. It breaks off if the match is not over.
    pub fn html(&self) -> String {
        let page = self.page();
        let rest = page.writer.clone().map(PageWriter::break_off);
        page.text.clone() + &rest.unwrap_or_default()
    }

    fn page(&self) -> MutexGuard<'_, Page> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Writes a match as a page.
pub struct PageRecorder {
    output: OutputFile,
    file: File,
    page: PageSoFar,
    error: Option<io::Error>,
}

impl PageRecorder {
    /// Creates a page in a file. It replaces an earlier file when the match is over.
    ///
    /// # Errors
    /// If the file cannot be created.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let output = OutputFile::create(path)?;
        let file = output.writer()?;
        Ok(Self { output, file, page: PageSoFar::default(), error: None })
    }

    /// Returns a handle to the page that is being written.
    pub fn so_far(&self) -> PageSoFar {
        self.page.clone()
    }

    fn write(&mut self, text: &str) {
        self.page.page().text += text;
        if self.error.is_none() {
            self.error = self.file.write_all(text.as_bytes()).err();
        }
    }

    /// Writes the rest of the page, and closes its file. Returns a text about it.
    fn close(mut self, rest: impl FnOnce(PageWriter) -> String) -> Result<Option<String>, RecordError> {
        let writer = self.page.page().writer.take();
        let text = writer.map(rest).unwrap_or_default();
        self.write(&text);
        let Self { output, error, .. } = self;
        let (path, is_file) = (output.path().to_owned(), output.is_file());
        output.close(error.map_or(Ok(()), Err))?;
        let size_bytes = is_file.then(|| path.metadata().map_or(0, |there| there.len()));
        Ok(size_bytes.map(|bytes| format!("  page   {}, {:.1} MB\n", path.display(), bytes as f64 / 1e6)))
    }
}

impl Recorder for PageRecorder {
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, world: &mut World) {
        ask_for_reasons(world);
        // A resolved scenario lists the robots, and has no team names any more.
        let teams = world.get_resource::<Scenario>().and_then(|played| played.teams.clone());
        let named = Scenario { teams: scenario.teams.clone().or(teams), ..scenario.clone() };
        let fields = world.get_resource::<TraceExtent>().map(|extent| extent.fields.clone()).unwrap_or_default();
        let (writer, text) = PageWriter::begin(&named, record, fields);
        self.page.page().writer = Some(writer);
        self.write(&text);
    }

    fn record(&mut self, record: &CycleRecord, _: &mut World) {
        let part = self.page.page().writer.as_mut().and_then(|writer| writer.record(record));
        if let Some(part) = part {
            self.write(&part);
        }
    }

    fn has_failed(&self) -> bool {
        self.error.is_some()
    }

    fn finish(self: Box<Self>, end: &MatchEnd, last: &CycleRecord) -> Result<Option<String>, RecordError> {
        self.close(|writer| writer.finish(end, last))
    }

    fn break_off(self: Box<Self>, _: &CycleRecord) -> Result<Option<String>, RecordError> {
        self.close(PageWriter::break_off)
    }
}

/// Returns the page of a trace, up to where the trace breaks off. `reader` has read only the header. `registry` names the teams.
///
/// # Errors
/// The first fault of the trace, and where it is.
pub fn page_of_trace(reader: &mut TraceReader, registry: &BehaviourRegistry) -> Result<String, TraceError> {
    let PerTeam { blue, pink } = team_names(reader.scenario(), registry);
    let scenario = Scenario { teams: Some(TeamsSpec::new(blue, pink)), ..reader.scenario().clone() };
    let Some(mut last) = reader.next_cycle()? else { return Ok(TEMPLATE.to_owned()) };
    let (mut writer, mut page) = PageWriter::begin(&scenario, &last, reader.fields().clone());
    while let Some(record) = reader.next_cycle()? {
        page.extend(writer.record(&record));
        last = record;
    }
    match reader.end() {
        Some(end) => page += &writer.finish(&end, &last),
        None => page += &writer.break_off(),
    }
    Ok(page)
}
