//! The logs of `naoisis run --log`, in formats that are registered by name.

use bevy::prelude::*;
use clap::Args;
use core::str::FromStr;
use std::path::PathBuf;

use super::outputs::{Output, STANDARD_OUTPUT};
use super::recording::Recording;
use naoisis_record::record::formats::LogFormats;
use naoisis_record::record::recorder::Recorder;

/// The arguments for logs.
#[derive(Args, Debug, Clone, Default)]
pub struct LogArguments {
    /// Write a log in this format (see `naoisis list logs`)
    #[arg(long, value_name = "FORMAT=FILE")]
    pub log: Vec<Log>,
}

/// A format and a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Log {
    format: String,
    path: PathBuf,
}

impl FromStr for Log {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.split_once('=') {
            Some((format, path)) if !format.is_empty() && !path.is_empty() => {
                Ok(Self { format: format.to_owned(), path: path.into() })
            }
            _ => Err("expected the name of a format and a file, such as trace=match.jsonl"),
        }
    }
}

impl Recording for LogArguments {
    fn check(&self) -> Result<(), String> {
        match self.log.iter().find(|log| log.path.as_os_str() == STANDARD_OUTPUT) {
            Some(_) => Err("--log: only --trace goes to standard output; expected a file".to_owned()),
            None => Ok(()),
        }
    }

    fn outputs(&self) -> Vec<Output> {
        self.log.iter().map(|log| Output { option: "--log", path: log.path.clone() }).collect()
    }

    fn open(&self, world: &World, _: bool) -> Result<Vec<Box<dyn Recorder>>, String> {
        let formats = world.resource::<LogFormats>();
        let known = |log: &Log| formats.get(&log.format).map(|format| (format, log.path.clone()));
        // Before a file is made, all formats are known.
        let mut logs = Vec::new();
        for log in &self.log {
            logs.push(known(log).ok_or_else(|| {
                let names: Vec<String> = formats.iter().map(|(name, _)| format!("`{name}`")).collect();
                format!("--log: there is no log format `{}`; expected one of {}", log.format, names.join(", "))
            })?);
        }
        let open = |(format, path): (_, PathBuf)| {
            let format: &naoisis_record::record::formats::LogFormat = format;
            format.create(&path).map_err(|error| format!("--log: {error}"))
        };
        logs.into_iter().map(open).collect()
    }
}
