//! Traces: a match as lines of JSON, one a cycle, written as it goes.
//!
//! A line is the [record](naoisis_sim::interface::cycle_record::CycleRecord) of its cycle: the world after it, and what the robots perceived,
//! believed and wanted in it. Lengths are in metres, angles in degrees within (-180, 180], places in the pitch frame but for
//! percepts, which are in the robot's.

use bevy::prelude::*;
use serde::Serialize;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::output_file::OutputFile;
use super::recorder::{MatchEnd, RecordError, Recorder};
use super::shortest_float::ShortestFloats;
use naoisis_core::behaviour::reasons::{Reasons, ask_for_reasons};
use naoisis_core::events::MatchEvent;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::scenario::Scenario;

/// The format's name in the header.
pub const FORMAT: &str = "naoisis-trace";
/// The format's version in the header.
pub const VERSION: u32 = 1;
/// How hard a compressed trace is compressed. Lines that are much alike need no more: level 3 takes twice the time, and
/// the file is larger.
const COMPRESSION_LEVEL: i32 = 1;
/// From this size on, the end of a plain trace suggests compressing it.
const LARGE_BYTES: u64 = 64 << 20;

/// The end of a compressed trace's name.
const COMPRESSED: &str = "zst";

/// Whether a trace of this name is compressed.
fn is_compressed(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == COMPRESSED)
}

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
    /// The cycles from one line to the next.
    every: u64,
    fields: Fields,
    line: Vec<u8>,
    /// What happened in the cycles since the last line.
    events: Vec<MatchEvent>,
    last_cycle: Option<u64>,
    /// Whether robots' reasons are written: they may be there for another recorder.
    has_reasons: bool,
    /// Its file, if it has one of its own.
    output: Option<OutputFile>,
    error: Option<io::Error>,
}

impl TraceRecorder {
    /// A trace into a writer, as plain lines. `name` is what errors call it.
    pub fn plain(name: impl Into<PathBuf>, writer: impl Write + Send + Sync + 'static) -> Self {
        Self::new(name.into(), Sink::Plain(BufWriter::new(Box::new(writer))))
    }

    /// A trace into a file, which replaces any that is there when the match is over; compressed if its name ends in `.zst`.
    ///
    /// # Errors
    /// When the file cannot be created.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let output = OutputFile::create(path)?;
        let file: Box<dyn Write + Send + Sync> = Box::new(output.writer()?);
        let sink = if is_compressed(path) {
            let encoder = zstd::stream::write::Encoder::new(file, COMPRESSION_LEVEL);
            Sink::Compressed(encoder.map_err(RecordError::io(path))?)
        } else {
            Sink::Plain(BufWriter::new(file))
        };
        Ok(Self { output: Some(output), ..Self::new(path.to_owned(), sink) })
    }

    fn new(name: PathBuf, sink: Sink) -> Self {
        let (line, events) = (Vec::new(), Vec::new());
        let (every, fields) = (1, Fields::default());
        Self { name, sink, every, fields, line, events, last_cycle: None, has_reasons: true, output: None, error: None }
    }

    /// Writes a line only every few cycles, and of the first and the last one. Events in between are in the next line.
    #[must_use]
    pub fn every(self, cycles: u64) -> Self {
        Self { every: cycles.max(1), ..self }
    }

    /// With these fields only.
    #[must_use]
    pub fn with_fields(self, fields: Fields) -> Self {
        Self { fields, ..self }
    }

    fn write_record(&mut self, record: &CycleRecord) {
        self.last_cycle = Some(record.cycle);
        let has_reasons = record.robots.iter().any(|robot| robot.reasons.is_some());
        if self.events.is_empty() && (self.has_reasons || !has_reasons) {
            return self.write_line(record);
        }
        let mut record = record.clone();
        record.events.splice(..0, self.events.drain(..));
        if !self.has_reasons {
            record.robots.iter_mut().for_each(|robot| robot.reasons = None);
        }
        self.write_line(&record);
    }

    fn write_line(&mut self, record: &CycleRecord) {
        self.line.clear();
        let mut serializer = serde_json::Serializer::with_formatter(&mut self.line, ShortestFloats);
        let written = if self.fields.is_all() {
            record.serialize(&mut serializer)
        } else {
            self.fields.of(record).serialize(&mut serializer)
        };
        self.end_line(written);
    }

    fn write(&mut self, line: &impl Serialize) {
        self.line.clear();
        let written = serde_json::to_writer(&mut self.line, line);
        self.end_line(written);
    }

    /// Writes the line, if it could be made.
    fn end_line(&mut self, made: serde_json::Result<()>) {
        if self.error.is_some() {
            return;
        }
        let result = made.map_err(io::Error::from).and_then(|()| {
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
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, world: &mut World) {
        if self.fields.names().iter().any(|name| name.starts_with("robots.reasons")) {
            ask_for_reasons(world);
        }
        self.has_reasons = world.query::<&Reasons>().iter(world).next().is_some();
        let (every, fields) = (self.every, self.fields.clone());
        self.write(&Header {
            line_type: "header",
            format: FORMAT,
            version: VERSION,
            seed: scenario.seed,
            every,
            fields: &fields,
            scenario,
        });
        self.write_record(record);
    }

    fn record(&mut self, record: &CycleRecord, _: &mut World) {
        if record.cycle.is_multiple_of(self.every) {
            self.write_record(record);
        } else {
            self.events.extend_from_slice(&record.events);
        }
    }

    fn has_failed(&self) -> bool {
        self.error.is_some()
    }

    fn finish(mut self: Box<Self>, end: &MatchEnd, last: &CycleRecord) -> Result<Option<String>, RecordError> {
        if self.last_cycle.is_some_and(|written| written < last.cycle) {
            // What happened in it is among what happened since the last line already.
            self.write_record(&CycleRecord { events: Vec::new(), ..last.clone() });
        }
        self.write(end);
        let Self { name, sink, output, error, .. } = *self;
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

#[derive(Serialize)]
struct Header<'a> {
    #[serde(rename = "type")]
    line_type: &'static str,
    format: &'static str,
    version: u32,
    seed: u64,
    #[serde(skip_serializing_if = "is_one")]
    every: u64,
    #[serde(skip_serializing_if = "Fields::is_all")]
    fields: &'a Fields,
    scenario: &'a Scenario,
}

fn is_one(every: &u64) -> bool {
    *every == 1
}
