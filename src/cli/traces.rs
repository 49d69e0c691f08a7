//! The trace that `naoisis run` writes.

use bevy::prelude::*;
use clap::Args;
use std::io;
use std::path::PathBuf;

use super::outputs::{Output, STANDARD_OUTPUT};
use super::recording::Recording;
use crate::record::recorder::Recorder;
use crate::record::trace::TraceRecorder;

/// The arguments for a trace.
#[derive(Args, Debug, Clone, Default)]
pub struct TraceArguments {
    /// Write a trace: a .jsonl file, .jsonl.zst for a compressed one, - for standard output
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
}

impl Recording for TraceArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        let file = self.trace.as_deref().filter(|_| !self.takes_standard_output());
        file.into_iter().map(|path| Output { option: "--trace", path }).collect()
    }

    fn takes_standard_output(&self) -> bool {
        self.trace.as_ref().is_some_and(|path| path.as_os_str() == STANDARD_OUTPUT)
    }

    fn open(&self, _: &World, _: bool) -> Result<Vec<Box<dyn Recorder>>, String> {
        let Some(path) = &self.trace else { return Ok(Vec::new()) };
        let recorder = if self.takes_standard_output() {
            Ok(TraceRecorder::plain("standard output", io::stdout()))
        } else {
            TraceRecorder::create(path)
        };
        Ok(vec![Box::new(recorder.map_err(|error| format!("--trace: {error}"))?)])
    }
}
