//! A match as a page for a browser: one file that loads nothing and plays the match.
//!
//! The [template](TEMPLATE) is the page without a match; its sources are in `web`, which builds it. After it come blocks, each a
//! script element of data with base64: a deflated stream of the length of a JSON object (four bytes, little-endian), the
//! object, and the columns that it names. Names of robots and teams, words of events and everything else that a file or a
//! program may choose are in these objects, so that none of it is ever read as markup; the page shows it as text.
//!
//! | block | when | what it has |
//! |---|---|---|
//! | `match` | at the start | name, seed, pitch, robots with bodies and cameras |
//! | `part` | after 7.5 s of the match, then after twice as long each time, at last every two minutes | columns, events with reasons, kicks, reasons of decisions, new words |
//! | `end` | at the end | score, tables and heat maps |
//!
//! A page whose program is killed has all parts that were written; the page says that it breaks off. A column has whole numbers, as
//! many as there are samples, or rows of lists. The truth is sampled 30 times a second and the rest 10 times. Steps: poses 5 mm and
//! 0.5°, head 2°, ball and targets 2 cm, believed robots 5 cm, what was seen 8 cm, half axes of ellipses 15 %.
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
use naoisis_core::behaviour::reasons::ask_for_reasons;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::scenario::Scenario;

/// The page without a match, as `web/build.js` makes it.
pub const TEMPLATE: &str = include_str!("page.html");

/// A page that is being made: what is complete, and what makes the rest.
#[derive(Default)]
struct Page {
    text: String,
    writer: Option<PageWriter>,
}

/// The page of a match that goes on, while a [`PageRecorder`] writes it, and afterwards.
#[derive(Clone, Default)]
pub struct PageSoFar(Arc<Mutex<Page>>);

impl PageSoFar {
    /// The page up to now. It breaks off if the match is not over.
    pub fn html(&self) -> String {
        let page = self.page();
        let rest = page.writer.clone().map(PageWriter::break_off);
        page.text.clone() + &rest.unwrap_or_default()
    }

    fn page(&self) -> MutexGuard<'_, Page> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A page that is being written.
pub struct PageRecorder {
    output: OutputFile,
    file: File,
    page: PageSoFar,
    error: Option<io::Error>,
}

impl PageRecorder {
    /// A page in a file, which replaces any that is there when the match is over.
    ///
    /// # Errors
    /// When the file cannot be made.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let output = OutputFile::create(path)?;
        let file = output.writer()?;
        Ok(Self { output, file, page: PageSoFar::default(), error: None })
    }

    /// The page while it is being written.
    pub fn so_far(&self) -> PageSoFar {
        self.page.clone()
    }

    fn write(&mut self, text: &str) {
        self.page.page().text += text;
        if self.error.is_none() {
            self.error = self.file.write_all(text.as_bytes()).err();
        }
    }
}

impl Recorder for PageRecorder {
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, world: &mut World) {
        ask_for_reasons(world);
        // A scenario that is resolved lists the robots, and has no names of teams any more.
        let teams = world.get_resource::<Scenario>().and_then(|played| played.teams.clone());
        let named = Scenario { teams: scenario.teams.clone().or(teams), ..scenario.clone() };
        let (writer, text) = PageWriter::begin(&named, record);
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

    fn finish(mut self: Box<Self>, end: &MatchEnd, last: &CycleRecord) -> Result<Option<String>, RecordError> {
        let writer = self.page.page().writer.take();
        let text = writer.map(|writer| writer.finish(end, last)).unwrap_or_default();
        self.write(&text);
        let Self { output, error, .. } = *self;
        let (path, is_file) = (output.path().to_owned(), output.is_file());
        output.close(error.map_or(Ok(()), Err))?;
        let size_bytes = is_file.then(|| path.metadata().map_or(0, |there| there.len()));
        Ok(size_bytes.map(|bytes| format!("  page   {}, {:.1} MB\n", path.display(), bytes as f64 / 1e6)))
    }
}

/// The page of the trace that `reader` has begun to read, as far as it goes.
///
/// # Errors
/// What is wrong with the trace, and where.
pub fn page_of_trace(reader: &mut TraceReader) -> Result<String, TraceError> {
    let scenario = reader.scenario().clone();
    let Some(mut last) = reader.next_cycle()? else { return Ok(TEMPLATE.to_owned()) };
    let (mut writer, mut page) = PageWriter::begin(&scenario, &last);
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
