//! Log formats by name, which `naoisis run --log NAME=FILE` can write. Programs can add their own.
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//! use naoisis::interface::cycle_record::CycleRecord;
//! use naoisis::record::output_file::OutputFile;
//! use naoisis::record::recorder::{MatchEnd, RecordError, Recorder};
//! use std::io::Write;
//! use std::path::{Path, PathBuf};
//!
//! /// The ball's places, a line a cycle.
//! struct BallLog {
//!     path: PathBuf,
//!     lines: String,
//! }
//!
//! impl BallLog {
//!     fn create(path: &Path) -> Result<Self, RecordError> {
//!         Ok(Self { path: path.to_owned(), lines: String::new() })
//!     }
//! }
//!
//! impl Recorder for BallLog {
//!     fn record(&mut self, record: &CycleRecord, _: &mut World) {
//!         if let Some(ball) = &record.ball {
//!             self.lines += &format!("{},{},{}\n", record.time_s, ball.position_m.x, ball.position_m.y);
//!         }
//!     }
//!
//!     fn finish(self: Box<Self>, _: &MatchEnd, _: &CycleRecord) -> Result<Option<String>, RecordError> {
//!         let output = OutputFile::create(&self.path)?;
//!         let written = output.writer()?.write_all(self.lines.as_bytes());
//!         output.close(written).map(|()| None)
//!     }
//! }
//!
//! let mut app = App::new();
//! app.add_plugins(NaoisisPlugins).add_log_format("ball", "where the ball was, as CSV", BallLog::create);
//! ```
//!
//! With a program of your own (`naoisis_cli::cli::run`), `my_team run match3v3 --log ball=ball.csv` then writes this format.

use bevy::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;

use super::recorder::{RecordError, Recorder};

/// Makes a recorder that writes to a file.
type Create = Box<dyn Fn(&Path) -> Result<Box<dyn Recorder>, RecordError> + Send + Sync>;

/// A log format.
pub struct LogFormat {
    /// A short description.
    pub description: String,
    /// The file name endings for which `naoisis convert` writes this format from a trace.
    pub endings: &'static [&'static str],
    create: Create,
}

impl LogFormat {
    /// Creates a recorder that writes to the file at `path`, which it replaces.
    ///
    /// # Errors
    /// If the file cannot be created.
    pub fn create(&self, path: &Path) -> Result<Box<dyn Recorder>, RecordError> {
        (self.create)(path)
    }
}

/// The log formats by name.
#[derive(Resource, Default)]
pub struct LogFormats(BTreeMap<String, LogFormat>);

impl LogFormats {
    /// Returns all formats with their names, sorted by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &LogFormat)> {
        self.0.iter().map(|(name, format)| (name.as_str(), format))
    }

    /// Returns the format for the name of the file at `path`. If several endings match, the longest wins.
    pub fn of_file(&self, path: &Path) -> Option<&LogFormat> {
        let name = path.file_name()?.to_str()?;
        let ending = |format: &&LogFormat| {
            format.endings.iter().filter(|ending| name.ends_with(**ending)).map(|ending| ending.len()).max()
        };
        self.0.values().filter(|format| ending(format).is_some()).max_by_key(ending)
    }

    /// Returns the format with this name.
    pub fn get(&self, name: &str) -> Option<&LogFormat> {
        self.0.get(name)
    }
}

/// Methods of [`App`] that register log formats.
pub trait LogFormatApp {
    /// Registers a log format: `create` makes the recorder that writes to a file. A later format replaces one with the same name.
    fn add_log_format<R: Recorder>(
        &mut self,
        name: &str,
        description: &str,
        create: impl Fn(&Path) -> Result<R, RecordError> + Send + Sync + 'static,
    ) -> &mut Self;

    /// Sets the file name endings of a log format. `naoisis convert` can then write it from a trace, so its recorder must need only the
    /// records: its world has no match.
    ///
    /// # Panics
    /// If there is no log format with this name, or another format has one of the endings.
    #[track_caller]
    fn name_endings(&mut self, name: &str, endings: &'static [&'static str]) -> &mut Self;
}

impl LogFormatApp for App {
    fn add_log_format<R: Recorder>(
        &mut self,
        name: &str,
        description: &str,
        create: impl Fn(&Path) -> Result<R, RecordError> + Send + Sync + 'static,
    ) -> &mut Self {
        let create: Create = Box::new(move |path| Ok(Box::new(create(path)?)));
        let format = LogFormat { description: description.to_owned(), endings: &[], create };
        self.world_mut().get_resource_or_init::<LogFormats>().0.insert(name.to_owned(), format);
        self
    }

    fn name_endings(&mut self, name: &str, endings: &'static [&'static str]) -> &mut Self {
        let mut formats = self.world_mut().get_resource_or_init::<LogFormats>();
        let other = formats
            .iter()
            .find(|(other, format)| *other != name && format.endings.iter().any(|ending| endings.contains(ending)));
        if let Some((other, _)) = other {
            panic!("the log format `{name}` cannot have the name endings {endings:?}: `{other}` has one of them");
        }
        match formats.0.get_mut(name) {
            Some(format) => format.endings = endings,
            None => panic!("there is no log format `{name}`; register it before its name endings"),
        }
        self
    }
}
