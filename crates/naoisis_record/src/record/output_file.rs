//! Files that recorders write to while a match is played.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use super::error::RecordError;
use naoisis_core::replace_file::UnfinishedFile;

/// A file that grows with the match. A new one has its name from the beginning, so that a program that is killed leaves what
/// it has written. One that replaces an earlier file is beside it, as `NAME.PROCESS.part`, until the match is over and all
/// is written. Devices and pipes are written to as they are.
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
    /// A file that takes the place of any that is there, when it is closed. One that is not closed takes no place.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let file = UnfinishedFile::growing(path).map_err(RecordError::io(path))?;
        Ok(Self { path: path.to_owned(), file })
    }

    /// The name that it is to have.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it is in a file, not a device or a pipe.
    pub(super) fn is_file(&self) -> bool {
        self.file.file().metadata().is_ok_and(|there| there.is_file())
    }

    /// What to write to.
    ///
    /// # Errors
    /// When the system has no more open files.
    pub fn writer(&self) -> Result<File, RecordError> {
        self.file.file().try_clone().map_err(RecordError::io(&self.path))
    }

    /// Gives the file its name, if all was written.
    ///
    /// # Errors
    /// What went wrong while it was written, or while it was closed. What there is of it stays, and an earlier file is as it
    /// was.
    pub fn close(self, written: io::Result<()>) -> Result<(), RecordError> {
        let written = written.map_err(RecordError::io(&self.path));
        self.close_after(written)
    }

    /// As [`OutputFile::close`], with any error of what was written.
    pub(super) fn close_after(mut self, written: Result<(), RecordError>) -> Result<(), RecordError> {
        let closed = written.and_then(|()| self.file.finish().map_err(RecordError::io(&self.path)));
        closed.map_err(|error| match self.file.keep() {
            Some(unfinished) => RecordError::NotReplaced { error: Box::new(error), unfinished },
            None => error,
        })
    }
}
