//! The trace of `naoisis run --trace`.

use bevy::prelude::*;
use clap::Args;
use std::io;
use std::path::PathBuf;

use super::outputs::{Output, STANDARD_OUTPUT};
use super::recording::Recording;
use naoisis_record::record::recorder::Recorder;
use naoisis_record::record::trace::TraceRecorder;
use naoisis_sim::interface::fields::Fields;

/// Ending that is added to file names without one: traces are long, so they are compressed.
const ENDING: &str = "jsonl.zst";

/// The arguments for a trace.
#[derive(Args, Debug, Clone, Default)]
pub struct TraceArguments {
    /// Write a trace: a .jsonl file, a compressed .jsonl.zst file (also without an ending), or - for standard output
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Write only every N-th cycle, with the events in between
    #[arg(long, value_name = "N", requires = "trace", value_parser = clap::value_parser!(u64).range(1..))]
    trace_every: Option<u64>,
    /// Write only these fields: ball,robots.pose,events
    #[arg(long, value_name = "LIST", requires = "trace")]
    trace_fields: Option<Fields>,
}

impl TraceArguments {
    /// Returns the file. A name without an ending gets the ending of a compressed trace, except if it is an existing pipe or device.
    fn file(&self) -> Option<PathBuf> {
        let path = self.trace.as_deref().filter(|_| !self.takes_standard_output())?;
        let is_complete = path.extension().is_some() || path.metadata().is_ok_and(|there| !there.is_file());
        Some(if is_complete { path.to_owned() } else { path.with_extension(ENDING) })
    }
}

impl Recording for TraceArguments {
    fn outputs(&self) -> Vec<Output> {
        self.file().into_iter().map(|path| Output { option: "--trace", path }).collect()
    }

    fn takes_standard_output(&self) -> bool {
        self.trace.as_ref().is_some_and(|path| path.as_os_str() == STANDARD_OUTPUT)
    }

    fn open(&self, _: &World, _: bool) -> Result<Vec<Box<dyn Recorder>>, String> {
        let recorder = match self.file() {
            Some(path) => TraceRecorder::create(&path).map_err(|error| format!("--trace: {error}"))?,
            None if self.takes_standard_output() => TraceRecorder::plain("standard output", io::stdout()),
            None => return Ok(Vec::new()),
        };
        let recorder = recorder.every(self.trace_every.unwrap_or(1));
        Ok(vec![Box::new(recorder.with_fields(self.trace_fields.clone().unwrap_or_default()))])
    }
}
