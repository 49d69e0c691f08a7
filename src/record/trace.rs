//! Traces: a match as lines of JSON, one a cycle, written as it goes.
//!
//! A line is the [record](super::cycle_record::CycleRecord) of its cycle: the world after it, and what the robots perceived,
//! believed and wanted in it. Lengths are in metres, angles in degrees within (-180, 180], places in the pitch frame but for
//! percepts, which are in the robot's.

use bevy::prelude::*;
use serde::Serialize;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::cycle_record::CycleRecord;
use super::recorder::{MatchEnd, RecordError, Recorder};
use crate::scenario::Scenario;

/// The format's name in the header.
pub const FORMAT: &str = "naoisis-trace";
/// The format's version in the header.
pub const VERSION: u32 = 1;
/// How hard a compressed trace is compressed. Lines that are much alike need no more: level 3 takes twice the time, and
/// the file is larger.
const COMPRESSION_LEVEL: i32 = 1;

/// Where a trace goes.
enum Sink {
    Plain(BufWriter<Box<dyn Write + Send + Sync>>),
    Compressed(zstd::stream::write::Encoder<'static, Box<dyn Write + Send + Sync>>),
}

/// A trace that is being written.
pub struct TraceRecorder {
    /// What errors call it.
    name: PathBuf,
    sink: Sink,
    line: Vec<u8>,
    error: Option<io::Error>,
}

impl TraceRecorder {
    /// A trace into a writer, as plain lines. `name` is what errors call it.
    pub fn plain(name: impl Into<PathBuf>, writer: impl Write + Send + Sync + 'static) -> Self {
        Self::new(name.into(), Sink::Plain(BufWriter::new(Box::new(writer))))
    }

    /// A trace into a new file; compressed if its name ends in `.zst`.
    ///
    /// # Errors
    /// When the file cannot be created.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let file: Box<dyn Write + Send + Sync> = Box::new(File::create(path).map_err(RecordError::io(path))?);
        let sink = if path.extension().is_some_and(|extension| extension == "zst") {
            let encoder = zstd::stream::write::Encoder::new(file, COMPRESSION_LEVEL);
            Sink::Compressed(encoder.map_err(RecordError::io(path))?)
        } else {
            Sink::Plain(BufWriter::new(file))
        };
        Ok(Self::new(path.to_owned(), sink))
    }

    fn new(name: PathBuf, sink: Sink) -> Self {
        Self { name, sink, line: Vec::new(), error: None }
    }

    fn write(&mut self, line: &impl Serialize) {
        if self.error.is_some() {
            return;
        }
        self.line.clear();
        let result = serde_json::to_writer(&mut self.line, line).map_err(io::Error::from).and_then(|()| {
            self.line.push(b'\n');
            // Whatever ends the program leaves every line readable. What was compressed before helps to compress what
            // follows, so that this makes a compressed trace 2 % larger.
            let writer: &mut dyn Write = match &mut self.sink {
                Sink::Plain(writer) => writer,
                Sink::Compressed(encoder) => encoder,
            };
            writer.write_all(&self.line)?;
            writer.flush()
        });
        self.error = result.err();
    }
}

impl Recorder for TraceRecorder {
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, _: &mut World) {
        self.write(&Header { line_type: "header", format: FORMAT, version: VERSION, seed: scenario.seed, scenario });
        self.write(record);
    }

    fn record(&mut self, record: &CycleRecord, _: &mut World) {
        self.write(record);
    }

    fn has_failed(&self) -> bool {
        self.error.is_some()
    }

    fn finish(mut self: Box<Self>, end: &MatchEnd) -> Result<Option<String>, RecordError> {
        self.write(end);
        let Self { name, sink, error, .. } = *self;
        let closed = match (error, sink) {
            (Some(error), _) => Err(error),
            (None, Sink::Plain(mut writer)) => writer.flush(),
            (None, Sink::Compressed(encoder)) => encoder.finish().and_then(|mut file| file.flush()),
        };
        closed.map(|()| None).map_err(RecordError::io(&name))
    }
}

#[derive(Serialize)]
struct Header<'a> {
    #[serde(rename = "type")]
    line_type: &'static str,
    format: &'static str,
    version: u32,
    seed: u64,
    scenario: &'a Scenario,
}
