//! The logs of `naoisis run --log`, in formats that are registered by name.

use bevy::prelude::*;
use clap::Args;
use core::str::FromStr;
use std::path::PathBuf;

use super::outputs::{Output, STANDARD_OUTPUT, check_folder_of};
use super::recording::Recording;
use naoisis_record::record::formats::{LogFormat, LogFormats};
use naoisis_record::record::recorder::Recorder;

/// The arguments for logs.
#[derive(Args, Debug, Clone, Default)]
pub struct LogArguments {
    /// Write a log in this format (see `naoisis list logs`)
    #[arg(long, value_name = "FORMAT=FILE")]
    pub log: Vec<Log>,
    /// Write a page that plays the match in a browser: one file, without a network
    #[arg(long, value_name = "FILE.html")]
    pub html: Option<PathBuf>,
    /// Write an MCAP file for Foxglove, Lichtblick and Rerun, with the trace in it
    #[arg(long, value_name = "FILE.mcap")]
    pub mcap: Option<PathBuf>,
}

impl LogArguments {
    /// Returns all logs, each with its option.
    fn all(&self) -> impl Iterator<Item = (&'static str, Log)> + '_ {
        let named = self.named().into_iter().filter_map(|(option, format, path)| {
            Some((option, Log { format: format.to_owned(), path: path.clone()? }))
        });
        self.log.iter().map(|log| ("--log", log.clone())).chain(named)
    }

    /// Returns the options of single formats: each with the format, which is also the ending, and the file.
    fn named(&self) -> [(&'static str, &'static str, &Option<PathBuf>); 2] {
        [("--mcap", "mcap", &self.mcap), ("--html", "html", &self.html)]
    }
}

/// A log format and its file.
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
        if let Some((option, _)) = self.all().find(|(_, log)| log.path.as_os_str() == STANDARD_OUTPUT) {
            return Err(format!("{option}: only --trace can write to standard output; expected a file"));
        }
        for (option, ending, path) in self.named() {
            if let Some(path) = path.as_ref().filter(|path| path.extension().is_none_or(|there| there != ending)) {
                return Err(format!("{option}: {}: expected a name that ends in .{ending}", path.display()));
            }
        }
        Ok(())
    }

    fn outputs(&self) -> Vec<Output> {
        self.all().map(|(option, log)| Output { option, path: log.path }).collect()
    }

    fn open(&self, world: &World, _: bool) -> Result<Vec<Box<dyn Recorder>>, String> {
        let formats = world.resource::<LogFormats>();
        // All formats are checked before a file is created.
        let mut logs = Vec::new();
        for (option, log) in self.all() {
            let format = formats.get(&log.format).ok_or_else(|| {
                let names: Vec<String> = formats.iter().map(|(name, _)| format!("`{name}`")).collect();
                format!("--log: there is no log format `{}`; expected one of {}", log.format, names.join(", "))
            })?;
            // Some recorders create their file at the end.
            check_folder_of(&log.path).map_err(|error| format!("{option}: {error}"))?;
            logs.push((option, format, log.path));
        }
        let open = |(option, format, path): (_, &LogFormat, PathBuf)| {
            format.create(&path).map_err(|error| format!("{option}: {error}"))
        };
        logs.into_iter().map(open).collect()
    }
}
