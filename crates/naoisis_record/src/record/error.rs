//! What can go wrong when a match is written down.

use std::io;
use std::path::{Path, PathBuf};

/// Why something is not written.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The folder is not empty.
    #[error("{0}: the folder is not empty; expected a new or an empty one")]
    NotEmpty(PathBuf),
    /// The file exists.
    #[error("{0}: the file exists already; expected a new name")]
    Exists(PathBuf),
    /// A file is there.
    #[error("{0}: this is a file; expected a folder, new or empty")]
    NotAFolder(PathBuf),
    /// Its name does not say what it is.
    #[error("{path}: expected a file name that ends in .{extension}")]
    Extension {
        /// The file that was asked for.
        path: PathBuf,
        /// How it should end.
        extension: &'static str,
    },
    /// It cannot be made, or written to.
    #[error("{path}: {error}")]
    Io {
        /// The folder or file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// It is not written, and what it was to replace is still there.
    #[error("{error}; the earlier file is as it was, and what there is of the new one is {unfinished}")]
    NotReplaced {
        /// What kept it from being written.
        error: Box<RecordError>,
        /// Where that is which could be written.
        unfinished: PathBuf,
    },
    /// It cannot be encoded.
    #[error("{path}: {message}")]
    Encoding {
        /// The file that was asked for.
        path: PathBuf,
        /// What the encoder says.
        message: String,
    },
}

naoisis_core::debug_as_displayed!(RecordError);

impl RecordError {
    /// Returns whether the reader closed the pipe.
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, RecordError::Io { error, .. } if error.kind() == io::ErrorKind::BrokenPipe)
    }

    /// Converts errors of creating or writing the file at `path`.
    pub fn io(path: &Path) -> impl FnOnce(io::Error) -> RecordError {
        move |error| RecordError::Io { path: path.to_owned(), error }
    }
}
