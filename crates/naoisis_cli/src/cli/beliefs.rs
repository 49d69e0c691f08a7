//! The table of `naoisis run --beliefs`, which compares beliefs with the truth.

use bevy::prelude::*;
use clap::Args;
use std::path::PathBuf;

use super::outputs::{Output, STANDARD_OUTPUT};
use super::recording::Recording;
use naoisis_record::record::beliefs::BeliefRecorder;
use naoisis_record::record::recorder::Recorder;

/// The arguments for a table of beliefs.
#[derive(Args, Debug, Clone, Default)]
pub struct BeliefArguments {
    /// Write the errors of the robots' beliefs to a .csv file, and print a summary at the end
    #[arg(long, value_name = "FILE")]
    pub beliefs: Option<PathBuf>,
}

impl Recording for BeliefArguments {
    fn check(&self) -> Result<(), String> {
        match &self.beliefs {
            Some(path) if path.as_os_str() == STANDARD_OUTPUT => {
                Err("--beliefs: only --trace goes to standard output; expected a file".to_owned())
            }
            _ => Ok(()),
        }
    }

    fn outputs(&self) -> Vec<Output> {
        self.beliefs.clone().into_iter().map(|path| Output { option: "--beliefs", path }).collect()
    }

    fn open(&self, _: &World, _: bool) -> Result<Vec<Box<dyn Recorder>>, String> {
        let Some(path) = &self.beliefs else { return Ok(Vec::new()) };
        let recorder = BeliefRecorder::create(path).map_err(|error| format!("--beliefs: {error}"))?;
        Ok(vec![Box::new(recorder)])
    }
}
