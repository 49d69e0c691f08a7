//! The files of a batch's tables, and what can be wrong with them.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Why a table cannot be written or gone on with.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// It cannot be read or written.
    #[error("{path}: the table cannot be read or written: {error}")]
    Io {
        /// The table's file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// It was opened, and a line of it cannot be written, as on a full disk.
    #[error("{path}: the table cannot be written: {error}")]
    NotWritten {
        /// The table's file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// It is a folder or a device.
    #[error("{path}: this is no ordinary file; expected one, or a name that there is no file of yet")]
    NotAFile {
        /// The path that was given for the table.
        path: PathBuf,
    },
    /// Another program is writing it.
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
    /// It holds something else than a beginning of this batch.
    #[error("{path}:{line}: {message}; expected {expected}, or a file that does not exist yet")]
    Foreign {
        /// The table's file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        message: String,
        /// What would be right.
        expected: String,
    },
}

naoisis_core::debug_as_displayed!(TableError);

impl TableError {
    /// That a line is of another table.
    pub(super) fn foreign(path: &Path, line: usize, message: String) -> TableError {
        let expected = "the table of an earlier batch with the same scenario, settings and first seed".to_owned();
        TableError::Foreign { path: path.to_owned(), line, message, expected }
    }
}

/// The file of a table, to be read and written: no other batch has it.
pub(super) struct TableFile {
    pub(super) file: File,
    path: PathBuf,
    /// Whether there was none before.
    is_new: bool,
}

impl TableFile {
    /// Opens it, or makes a new one.
    pub(super) fn open(path: &Path) -> Result<Self, TableError> {
        let is_new = !path.exists();
        // Some devices can be read for ever.
        if path.metadata().is_ok_and(|metadata| !metadata.is_file()) {
            return Err(TableError::NotAFile { path: path.to_owned() });
        }
        let opened = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        let file = opened.map_err(|error| TableError::Io { path: path.to_owned(), error })?;
        // Where files cannot be locked, it goes without.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(TableError::InUse { path: path.to_owned() });
        }
        Ok(Self { file, path: path.to_owned(), is_new })
    }

    /// Writes the first line of an empty one.
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
