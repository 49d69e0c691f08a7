//! The formats of scenario files.

use core::fmt;
use std::path::Path;

/// The format of a scenario file.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum Format {
    /// Rusty Object Notation, `.ron`.
    Ron,
    /// JSON, `.json`.
    Json,
}

impl Format {
    /// Returns the format for the extension of a file name.
    pub fn of_path(path: &Path) -> Option<Format> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "ron" => Some(Format::Ron),
            "json" => Some(Format::Json),
            _ => None,
        }
    }

    pub(super) fn smallest_scenario(self) -> &'static str {
        match self {
            Format::Ron => "`(robots: [(team: blue, number: 1)])`",
            Format::Json => "`{ \"robots\": [{ \"team\": \"blue\", \"number\": 1 }] }`",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Format::Ron => "RON",
            Format::Json => "JSON",
        })
    }
}
