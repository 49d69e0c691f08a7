//! The files of a batch's tables, and their errors.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Why a table cannot be written or continued.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// The file cannot be read or written.
    #[error("{path}: the table cannot be read or written: {error}")]
    Io {
        /// The table's file.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// A line cannot be written to the open file, for example because the disk is full.
    #[error("{path}: the table cannot be written: {error}")]
    NotWritten {
        /// The table's file.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// The path is a folder or a device.
    #[error("{path}: this is no ordinary file; expected one, or a name that there is no file of yet")]
    NotAFile {
        /// The path that was given for the table.
        path: PathBuf,
    },
    /// Another program is writing the file.
    #[error("{path}: another batch is writing this table; expected another file, or some patience")]
    InUse {
        /// The table's file.
        path: PathBuf,
    },
    /// Matches were played earlier, and the table of their mistakes is missing.
    #[error(
        "{path}: there is no such file, and {matches} of the matches were played earlier; expected the table of mistakes that was \
             written along with them, or a new table of matches"
    )]
    NoMistakes {
        /// The file of mistakes.
        path: PathBuf,
        /// Matches that were played earlier.
        matches: usize,
    },
    /// The contents of the file are not the beginning of this batch.
    #[error("{path}:{line}: {message}; expected {expected}, or a file that does not exist yet")]
    Foreign {
        /// The table's file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        message: String,
        /// What was expected.
        expected: String,
    },
}

naoisis_core::debug_as_displayed!(TableError);

impl TableError {
    /// Returns the error for a line of another table.
    pub(super) fn foreign(path: &Path, line: usize, message: String) -> TableError {
        let expected = "the table of an earlier batch with the same scenario, settings and first seed".to_owned();
        TableError::Foreign { path: path.to_owned(), line, message, expected }
    }
}

/// The open file of a table, locked against other batches.
pub(super) struct TableFile {
    pub(super) file: File,
    path: PathBuf,
    /// Whether the file did not exist before.
    is_new: bool,
}

impl TableFile {
    /// Opens the file, or creates it.
    pub(super) fn open(path: &Path) -> Result<Self, TableError> {
        let is_new = !path.exists();
        // Some devices never reach an end of file.
        if path.metadata().is_ok_and(|metadata| !metadata.is_file()) {
            return Err(TableError::NotAFile { path: path.to_owned() });
        }
        let opened = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        let file = opened.map_err(|error| TableError::Io { path: path.to_owned(), error })?;
        // On file systems without locks, the file is used without one.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(TableError::InUse { path: path.to_owned() });
        }
        Ok(Self { file, path: path.to_owned(), is_new })
    }

    /// Writes the first line of an empty table.
    pub(super) fn write_header(&mut self, header: &str) -> Result<(), TableError> {
        self.file.write_all(header.as_bytes()).map_err(|error| {
            if self.is_new {
                // If it cannot be removed, the first error says enough.
                let _ = fs::remove_file(&self.path);
            }
            TableError::NotWritten { path: self.path.clone(), error }
        })
    }
}
