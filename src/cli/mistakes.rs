//! The mistakes that `naoisis run` looks for.

use bevy::prelude::*;
use clap::Args;
use std::path::PathBuf;

use super::outputs::{Output, STANDARD_OUTPUT};
use super::recording::Recording;
use crate::record::mistake_recorder::MistakeRecorder;
use crate::record::recorder::Recorder;

/// The arguments for mistakes.
#[derive(Args, Debug, Clone, Default)]
pub struct MistakeArguments {
    /// Find what robots did wrong (lost balls and poses, missed kicks, balls given away, ...): a .json file, and a table at the end
    #[arg(long, value_name = "FILE")]
    pub mistakes: Option<PathBuf>,
}

impl Recording for MistakeArguments {
    fn check(&self) -> Result<(), String> {
        match &self.mistakes {
            Some(path) if path.as_os_str() == STANDARD_OUTPUT => {
                Err("--mistakes: only --trace goes to standard output; expected a file".to_owned())
            }
            _ => Ok(()),
        }
    }

    fn outputs(&self) -> Vec<Output> {
        self.mistakes.clone().into_iter().map(|path| Output { option: "--mistakes", path }).collect()
    }

    fn open(&self, _: &World, _: bool) -> Result<Vec<Box<dyn Recorder>>, String> {
        let Some(path) = &self.mistakes else { return Ok(Vec::new()) };
        let recorder = MistakeRecorder::create(path).map_err(|error| format!("--mistakes: {error}"))?;
        Ok(vec![Box::new(recorder)])
    }
}
