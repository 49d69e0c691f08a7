//! What can be wrong with the tables of a batch.

use std::io;
use std::path::{Path, PathBuf};

/// Why a table cannot be written or gone on with.
#[derive(Debug, thiserror::Error)]
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
    /// Matches were played earlier whose mistakes are nowhere.
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

impl TableError {
    /// That a line is of another table.
    pub(super) fn foreign(path: &Path, line: usize, message: String) -> TableError {
        let expected = "the table of an earlier batch with the same scenario, settings and first seed".to_owned();
        TableError::Foreign { path: path.to_owned(), line, message, expected }
    }
}
