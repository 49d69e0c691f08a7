//! Writes traces: a match as lines of JSON, one for each cycle, written during the match.
//!
//! A line is the [record](naoisis_sim::interface::cycle_record::CycleRecord) of its cycle: the state of the world after it, and the
//! percepts, beliefs and commands of the robots. Lengths are in metres, angles in degrees within (-180, 180]. Positions are in the pitch
//! frame, except for percepts, which are in the robot's frame.

use bevy::prelude::*;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::output_file::OutputFile;
use super::recorder::{MatchEnd, RecordError, Recorder};
use super::trace_lines::TraceLines;
pub use super::trace_lines::{FORMAT, VERSION};
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::scenario::Scenario;

/// Compression level of a trace. Lines are so similar that level 1 is enough: level 3 takes twice the time, and the file is larger.
const COMPRESSION_LEVEL: i32 = 1;
/// Size of a plain trace from which on compression is suggested at its end.
const LARGE_BYTES: u64 = 64 << 20;

/// File name extension of a compressed trace.
const COMPRESSED: &str = "zst";

/// Returns whether a trace with this name is compressed.
fn is_compressed(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == COMPRESSED)
}

/// The destination of a trace.
enum Sink {
    Plain(BufWriter<Box<dyn Write + Send + Sync>>),
    Compressed(zstd::stream::write::Encoder<'static, Box<dyn Write + Send + Sync>>),
}

/// Writes a match as a trace.
pub struct TraceRecorder {
    /// Name of the trace in error messages.
    name: PathBuf,
    sink: Sink,
    lines: TraceLines,
    text: Vec<u8>,
    /// The trace's own file, if it has one.
    output: Option<OutputFile>,
    error: Option<io::Error>,
}

impl TraceRecorder {
    /// Creates a trace that is written to a writer, as plain lines. `name` is its name in error messages.
    pub fn plain(name: impl Into<PathBuf>, writer: impl Write + Send + Sync + 'static) -> Self {
        Self::new(name.into(), Sink::Plain(BufWriter::new(Box::new(writer))))
    }

    /// Creates a trace in a file, which replaces an earlier file when the match is over. The trace is compressed if the name ends in
    /// `.zst`.
    ///
    /// # Errors
    /// If the file cannot be created.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let output = OutputFile::create(path)?;
        let file: Box<dyn Write + Send + Sync> = Box::new(output.writer()?);
        let sink = if is_compressed(path) {
            let encoder = zstd::stream::write::Encoder::new(file, COMPRESSION_LEVEL).and_then(|mut encoder| {
                encoder.include_checksum(true)?;
                Ok(encoder)
            });
            Sink::Compressed(encoder.map_err(RecordError::io(path))?)
        } else {
            Sink::Plain(BufWriter::new(file))
        };
        Ok(Self { output: Some(output), ..Self::new(path.to_owned(), sink) })
    }

    fn new(name: PathBuf, sink: Sink) -> Self {
        Self { name, sink, lines: TraceLines::default(), text: Vec::new(), output: None, error: None }
    }

    /// Writes only one line in every `cycles`, and the first and the last one. Events in between are in the next line.
    #[must_use]
    pub fn every(mut self, cycles: u64) -> Self {
        self.lines.extent.every = cycles.max(1);
        self
    }

    /// Writes only these fields.
    #[must_use]
    pub fn with_fields(mut self, fields: Fields) -> Self {
        self.lines.extent.fields = fields;
        self
    }

    /// Writes the lines that `add` makes, if it succeeds.
    fn write(&mut self, add: impl FnOnce(&mut TraceLines, &mut Vec<u8>) -> serde_json::Result<()>) {
        self.text.clear();
        let made = add(&mut self.lines, &mut self.text);
        // Not every cycle has a line.
        if self.error.is_some() || (made.is_ok() && self.text.is_empty()) {
            return;
        }
        let result = made.map_err(io::Error::from).and_then(|()| {
            // Flush, so that every line can be read however the program ends. Compression still uses the earlier data, so that a compressed
            // trace becomes only 2 % larger.
            let writer: &mut dyn Write = match &mut self.sink {
                Sink::Plain(writer) => writer,
                Sink::Compressed(encoder) => encoder,
            };
            writer.write_all(&self.text)?;
            writer.flush()
        });
        self.error = result.err();
    }

    /// Closes the file. Returns a text about it, if it is the trace's own.
    fn close(self) -> Result<Option<String>, RecordError> {
        let Self { name, sink, output, error, .. } = self;
        let is_plain = matches!(sink, Sink::Plain(_));
        let closed = match (error, sink) {
            (Some(error), _) => Err(error),
            (None, Sink::Plain(mut writer)) => writer.flush(),
            (None, Sink::Compressed(encoder)) => encoder.finish().and_then(|mut file| file.flush()),
        };
        let is_file = output.as_ref().is_some_and(OutputFile::is_file);
        match output {
            Some(output) => output.close(closed)?,
            None => closed.map_err(RecordError::io(&name))?,
        }
        let size_bytes = is_file.then(|| name.metadata().map_or(0, |there| there.len()));
        Ok(size_bytes.map(|bytes| {
            let hint = if is_plain && bytes > LARGE_BYTES {
                "; a name that ends in .jsonl.zst makes it a sixth of that"
            } else {
                ""
            };
            format!("  trace  {}, {:.1} MB{hint}\n", name.display(), bytes as f64 / 1e6)
        }))
    }
}

impl Recorder for TraceRecorder {
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, world: &mut World) {
        self.write(|lines, text| lines.add_header(text, scenario, world));
        self.write(|lines, text| lines.add(text, record));
    }

    fn record(&mut self, record: &CycleRecord, _: &mut World) {
        self.write(|lines, text| lines.add_cycle(text, record));
    }

    fn has_failed(&self) -> bool {
        self.error.is_some()
    }

    fn finish(mut self: Box<Self>, end: &MatchEnd, last: &CycleRecord) -> Result<Option<String>, RecordError> {
        self.write(|lines, text| lines.add_last(text, last));
        self.write(|_, text| TraceLines::add_end(text, end));
        self.close()
    }

    fn break_off(mut self: Box<Self>, last: &CycleRecord) -> Result<Option<String>, RecordError> {
        self.write(|lines, text| lines.add_last(text, last));
        self.close()
    }
}
