//! The errors of beliefs, the mistakes and the summary of `naoisis run`.

use bevy::prelude::*;
use clap::Args;
use std::path::PathBuf;

use super::outputs::{Output, STANDARD_OUTPUT};
use super::recording::Recording;
use naoisis_record::record::beliefs::BeliefRecorder;
use naoisis_record::record::mistake_recorder::MistakeRecorder;
use naoisis_record::record::recorder::Recorder;
use naoisis_record::record::summary_recorder::SummaryRecorder;

/// The arguments about errors of beliefs, mistakes and the summary.
#[derive(Args, Debug, Clone, Default)]
pub struct ReviewArguments {
    /// Write the errors of the robots' beliefs to a .csv file, and print a summary at the end
    #[arg(long, value_name = "FILE")]
    pub beliefs: Option<PathBuf>,
    /// Find mistakes of robots (lost balls and poses, missed kicks, balls given away, ...): a .json file, and a table
    /// at the end
    #[arg(long, value_name = "FILE")]
    pub mistakes: Option<PathBuf>,
    /// Write the statistics of the match (possession, shots, passes, distances, heat maps, penalties, mistakes): an .html
    /// file, or a .png file with a picture
    #[arg(long, value_name = "FILE.html|FILE.png")]
    pub summary: Option<PathBuf>,
}

impl ReviewArguments {
    fn files(&self) -> impl Iterator<Item = (&'static str, &PathBuf)> {
        let files = [("--beliefs", &self.beliefs), ("--mistakes", &self.mistakes), ("--summary", &self.summary)];
        files.into_iter().filter_map(|(option, path)| Some((option, path.as_ref()?)))
    }
}

impl Recording for ReviewArguments {
    fn check(&self) -> Result<(), String> {
        if let Some((option, _)) = self.files().find(|(_, path)| path.as_os_str() == STANDARD_OUTPUT) {
            return Err(format!("{option}: only --trace can write to standard output; expected a file"));
        }
        match &self.summary {
            Some(path) if path.extension().is_some_and(|extension| extension != "html" && extension != "png") => {
                Err(format!("--summary: {}: expected a name that ends in .html or .png", path.display()))
            }
            _ => Ok(()),
        }
    }

    fn outputs(&self) -> Vec<Output> {
        self.files().map(|(option, path)| Output { option, path: path.clone() }).collect()
    }

    fn open(&self, _: &World, _: bool) -> Result<Vec<Box<dyn Recorder>>, String> {
        let mut recorders: Vec<Box<dyn Recorder>> = Vec::new();
        if let Some(path) = &self.beliefs {
            recorders.push(Box::new(BeliefRecorder::create(path).map_err(|error| format!("--beliefs: {error}"))?));
        }
        if let Some(path) = &self.mistakes {
            recorders.push(Box::new(MistakeRecorder::create(path).map_err(|error| format!("--mistakes: {error}"))?));
        }
        if let Some(path) = &self.summary {
            recorders.push(Box::new(SummaryRecorder::create(path).map_err(|error| format!("--summary: {error}"))?));
        }
        Ok(recorders)
    }
}
