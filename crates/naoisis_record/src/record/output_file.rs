//! The files that recorders write to during a match.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use super::error::RecordError;
use naoisis_core::replace_file::UnfinishedFile;

/// A file that grows during the match. A new file has its name from the beginning, so that a killed program leaves what was written. A file
/// that replaces an earlier one has the name `NAME.PROCESS.part` beside it until the match is over and everything is written. Devices and
/// pipes are written to directly.
///
/// ```
/// use naoisis::record::output_file::OutputFile;
/// use std::io::Write;
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("ball.csv");
/// std::fs::write(&path, "of an earlier match")?;
/// let output = OutputFile::create(&path)?;
/// let written = output.writer()?.write_all(b"of this match");
/// assert_eq!(std::fs::read_to_string(&path)?, "of an earlier match");
/// output.close(written)?;
/// assert_eq!(std::fs::read_to_string(&path)?, "of this match");
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct OutputFile {
    path: PathBuf,
    file: UnfinishedFile,
}

impl OutputFile {
    /// Creates a file that replaces an earlier file when it is closed. If it is not closed, the earlier file stays.
    ///
    /// # Errors
    /// If the file cannot be created.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let file = UnfinishedFile::growing(path).map_err(RecordError::io(path))?;
        Ok(Self { path: path.to_owned(), file })
    }

    /// Returns the final path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns whether this is a regular file, not a device or a pipe.
    pub(super) fn is_file(&self) -> bool {
        self.file.file().metadata().is_ok_and(|there| there.is_file())
    }

    /// Returns a handle for writing to the file.
    ///
    /// # Errors
    /// If the system has no more open files.
    pub fn writer(&self) -> Result<File, RecordError> {
        self.file.file().try_clone().map_err(RecordError::io(&self.path))
    }

    /// Finishes the file and gives it its final name. `written` is the result of writing.
    ///
    /// # Errors
    /// The error of writing or closing the file. The incomplete file stays, and an earlier file is unchanged.
    pub fn close(self, written: io::Result<()>) -> Result<(), RecordError> {
        let written = written.map_err(RecordError::io(&self.path));
        self.close_after(written)
    }

    /// Closes the file like [`OutputFile::close`], or returns the error of `written`.
    pub(super) fn close_after(mut self, written: Result<(), RecordError>) -> Result<(), RecordError> {
        let closed = written.and_then(|()| self.file.finish().map_err(RecordError::io(&self.path)));
        closed.map_err(|error| match self.file.keep() {
            Some(unfinished) => RecordError::NotReplaced { error: Box::new(error), unfinished },
            None => error,
        })
    }
}
