//! Errors of recording a match.

use std::io;
use std::path::{Path, PathBuf};

/// Why a recording cannot be written.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The folder is not empty.
    #[error("{0}: the folder is not empty; expected a new or an empty one")]
    NotEmpty(PathBuf),
    /// The file exists already.
    #[error("{0}: the file exists already; expected a new name")]
    Exists(PathBuf),
    /// The path of the folder is a file.
    #[error("{0}: this is a file; expected a folder, new or empty")]
    NotAFolder(PathBuf),
    /// The extension of the file name is wrong.
    #[error("{path}: expected a file name that ends in .{extension}")]
    Extension {
        /// The file that was asked for.
        path: PathBuf,
        /// The expected extension.
        extension: &'static str,
    },
    /// The folder or file cannot be created or written to.
    #[error("{path}: {error}")]
    Io {
        /// The folder or file.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// The folder of the file does not exist.
    #[error("{path}: there is no folder {folder}; expected a file in a folder that is there")]
    NoFolder {
        /// The file that was asked for.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The new file is not complete, and the old one has not been replaced.
    #[error("{error}; the earlier file is as it was, and what there is of the new one is {unfinished}")]
    NotReplaced {
        /// Why the file could not be written.
        error: Box<RecordError>,
        /// The path of the incomplete new file.
        unfinished: PathBuf,
    },
    /// A picture cannot be encoded.
    #[error("{path}: {message}")]
    Encoding {
        /// The file that was asked for.
        path: PathBuf,
        /// The encoder's message.
        message: String,
    },
}

naoisis_core::debug_as_displayed!(RecordError);

impl RecordError {
    /// Returns whether the reader closed the pipe.
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, RecordError::Io { error, .. } if error.kind() == io::ErrorKind::BrokenPipe)
    }

    /// Returns a function that converts I/O errors of the file at `path`.
    pub fn io(path: &Path) -> impl FnOnce(io::Error) -> RecordError {
        move |error| match path.parent() {
            Some(folder)
                if error.kind() == io::ErrorKind::NotFound && !folder.as_os_str().is_empty() && !folder.exists() =>
            {
                RecordError::NoFolder { path: path.to_owned(), folder: folder.to_owned() }
            }
            _ => RecordError::Io { path: path.to_owned(), error },
        }
    }
}
