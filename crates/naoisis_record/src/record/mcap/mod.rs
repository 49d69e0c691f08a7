//! A match as an [MCAP](https://mcap.dev) file: its trace, and channels that Foxglove and Lichtblick show.
//!
//! The channel `/trace` has the lines of the trace, one in each message. The header and the end of the trace are metadata. A
//! [`TraceReader`](super::read::TraceReader) reads such a file like any trace. The guide's page on MCAP files describes the channels.
//!
//! ```
//! use naoisis::prelude::*;
//! use naoisis::record::RecordPlugin;
//! use naoisis::record::mcap::McapRecorder;
//! use naoisis::record::read::TraceReader;
//! use naoisis::record::recorder::{self, EndReason};
//!
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("match.mcap");
//! let mut app = bevy::app::App::new();
//! app.add_plugins((NaoisisPlugins, RecordPlugin));
//! app.start_match(&Scenario::named("match3v3")?)?;
//! recorder::start(app.world_mut(), vec![Box::new(McapRecorder::create(&path)?)]);
//! app.run_cycles(30);
//! recorder::finish(app.world_mut(), EndReason::Interrupted);
//! assert_eq!(TraceReader::open(&path)?.next_cycle()?.unwrap().robots.len(), 6);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

pub(super) mod channels;
mod file;
mod pitch;
mod robots;
mod senses;
mod shapes;
pub(super) mod viewer_schema;

use bevy::prelude::*;
use std::path::Path;

use super::mcap_trace::{END, HEADER, LINE, TRACE};
use super::output_file::OutputFile;
use super::recorder::{MatchEnd, RecordError, Recorder};
use super::trace_lines::TraceLines;
use channels::Channels;
use file::McapFile;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::scenario::Scenario;

/// Writes a match to an MCAP file.
pub struct McapRecorder {
    output: OutputFile,
    file: McapFile,
    lines: TraceLines,
    text: Vec<u8>,
    channels: Option<Channels>,
}

impl McapRecorder {
    /// Creates an MCAP file. It replaces an earlier file when the match is over.
    ///
    /// # Errors
    /// If the file cannot be created.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let output = OutputFile::create(path)?;
        let file = McapFile::create(output.writer()?).map_err(RecordError::io(path))?;
        Ok(Self { output, file, lines: TraceLines::default(), text: Vec::new(), channels: None })
    }

    /// Makes the line that `add` writes, without its line end. Empty if there is no line.
    fn line(&mut self, add: impl FnOnce(&mut TraceLines, &mut Vec<u8>) -> serde_json::Result<()>) {
        self.text.clear();
        let (lines, text) = (&mut self.lines, &mut self.text);
        self.file.attempt(|_| Ok(add(lines, text)?));
        self.text.pop();
    }

    fn write_cycle(&mut self, record: &CycleRecord) {
        let time_ns = nanoseconds(record.time_s);
        if !self.text.is_empty() {
            self.file.log_text::<CycleRecord>(TRACE, time_ns, &self.text);
        }
    }

    fn write_metadata(&mut self, name: &str) {
        let line = String::from_utf8_lossy(&self.text).into_owned();
        self.file.metadata(name, [(LINE, line)]);
    }

    /// Closes the file. Returns a text about it.
    fn close(self) -> Result<Option<String>, RecordError> {
        let Self { output, file, .. } = self;
        let (path, is_file) = (output.path().to_owned(), output.is_file());
        output.close(file.finish())?;
        let size_bytes = is_file.then(|| path.metadata().map_or(0, |there| there.len()));
        Ok(size_bytes.map(|bytes| format!("  mcap   {}, {:.1} MB\n", path.display(), bytes as f64 / 1e6)))
    }
}

impl Recorder for McapRecorder {
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, world: &mut World) {
        self.line(|lines, text| lines.add_header(text, scenario, world));
        self.write_metadata(HEADER);
        self.line(|lines, text| lines.add(text, record));
        self.write_cycle(record);
        let mut channels = Channels::begin(scenario, record, &self.lines.extent.fields, &mut self.file);
        channels.write(record, world, &mut self.file);
        self.channels = Some(channels);
    }

    fn record(&mut self, record: &CycleRecord, world: &mut World) {
        self.line(|lines, text| lines.add_cycle(text, record));
        self.write_cycle(record);
        if let Some(channels) = &mut self.channels {
            channels.write(record, world, &mut self.file);
        }
    }

    fn has_failed(&self) -> bool {
        self.file.has_failed()
    }

    fn finish(mut self: Box<Self>, end: &MatchEnd, last: &CycleRecord) -> Result<Option<String>, RecordError> {
        self.line(|lines, text| lines.add_last(text, last));
        self.write_cycle(last);
        self.line(|_, text| TraceLines::add_end(text, end));
        self.write_metadata(END);
        self.close()
    }

    fn break_off(mut self: Box<Self>, last: &CycleRecord) -> Result<Option<String>, RecordError> {
        self.line(|lines, text| lines.add_last(text, last));
        self.write_cycle(last);
        self.close()
    }
}

/// Converts a time in the match, s, to nanoseconds.
pub(super) fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1e9).round() as u64
}
