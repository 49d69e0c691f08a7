//! Atomic replacement of files.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::thread;

/// Writes a file atomically: it has a temporary name beside `path` until it is complete. If writing fails, for example on a full disk, an
/// earlier file is unchanged.
///
/// A symbolic link is followed, and the file that it points to is replaced; a device or a pipe is written to directly.
///
/// # Errors
/// Errors of the file system and of `write`.
pub fn replace_file(path: &Path, write: impl FnOnce(&File) -> io::Result<()>) -> io::Result<()> {
    let mut unfinished = UnfinishedFile::whole(path)?;
    write(unfinished.file())?;
    unfinished.finish()
}

/// A file that is being written. Until it is [finished](UnfinishedFile::finish), the file that it replaces is unchanged.
///
/// Dropping an unfinished file removes it; if the program is killed, `NAME.PROCESS.part` is left behind. Hard links to an earlier file keep
/// the earlier content.
#[derive(Debug)]
pub struct UnfinishedFile {
    file: File,
    /// Current and final path; `None` if the file has its final name already.
    places: Option<Places>,
}

#[derive(Debug)]
struct Places {
    /// The current, temporary path.
    now: PathBuf,
    /// The final path.
    then: PathBuf,
    /// Whether there is an earlier file at the final path.
    is_taken: bool,
}

impl UnfinishedFile {
    /// Creates a file that gets its name when it is finished.
    ///
    /// # Errors
    /// If the file cannot be created, or an existing file at `path` is not writable.
    pub fn whole(path: &Path) -> io::Result<Self> {
        Self::create(path, UnfinishedFile::beside)
    }

    /// Creates a file that is useful before it is complete: if no file is replaced, it has its name from the beginning.
    ///
    /// # Errors
    /// If the file cannot be created, or an existing file at `path` is not writable.
    pub fn growing(path: &Path) -> io::Result<Self> {
        Self::create(path, |path| Ok(Self { file: File::create(path)?, places: None }))
    }

    fn create(path: &Path, create_new: impl FnOnce(&Path) -> io::Result<Self>) -> io::Result<Self> {
        let Ok(earlier) = fs::metadata(path) else { return create_new(path) };
        // Opening the file for writing tests the permission without changing the file.
        let file = File::options().write(true).open(path)?;
        if !earlier.is_file() {
            return Ok(Self { file, places: None });
        }
        let mut unfinished = Self::beside(&fs::canonicalize(path)?)?;
        unfinished.file.set_permissions(earlier.permissions())?;
        unfinished.places.iter_mut().for_each(|places| places.is_taken = true);
        Ok(unfinished)
    }

    fn beside(path: &Path) -> io::Result<Self> {
        let now = unfinished_name(path);
        let file = File::create(&now)?;
        Ok(Self { file, places: Some(Places { now, then: path.to_owned(), is_taken: false }) })
    }

    /// The file to write to.
    pub fn file(&self) -> &File {
        &self.file
    }

    /// Finishes the file, which gets its name.
    ///
    /// # Errors
    /// If the file cannot be written to the disk completely; the earlier file is unchanged then.
    pub fn finish(&mut self) -> io::Result<()> {
        if let Some(Places { now, then, is_taken }) = &self.places {
            if *is_taken {
                // Some file systems report only here that they are full; the earlier file must not be given up before.
                self.file.sync_all()?;
            }
            fs::rename(now, then)?;
            self.places = None;
        }
        Ok(())
    }

    /// Keeps what has been written. Returns the temporary path of the file, if it has one.
    pub fn keep(mut self) -> Option<PathBuf> {
        self.places.take().map(|places| places.now)
    }
}

impl Drop for UnfinishedFile {
    fn drop(&mut self) {
        // After a panic the partial file is kept, as it may show the cause.
        if let Some(places) = &self.places
            && !thread::panicking()
        {
            // A failure to remove the file follows an earlier error, which says more.
            let _ = fs::remove_file(&places.now);
        }
    }
}

/// Returns the temporary name of a file. It contains the process number, as two processes may write the same file.
fn unfinished_name(path: &Path) -> PathBuf {
    let mut name = path.file_name().map(OsString::from).unwrap_or_default();
    name.push(format!(".{}.part", std::process::id()));
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn text(path: &Path) -> String {
        fs::read_to_string(path).unwrap()
    }

    #[test]
    fn a_file_is_replaced_as_a_whole_or_stays_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("match.naoisis");
        replace_file(&path, |mut file| file.write_all(b"first")).unwrap();
        replace_file(&path, |mut file| file.write_all(b"second")).unwrap();
        assert_eq!(text(&path), "second");
        let full = replace_file(&path, |mut file| {
            file.write_all(b"th")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert_eq!(full.unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(text(&path), "second");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing unfinished is left");
    }

    #[test]
    fn a_growing_file_replaces_another_at_its_end_and_a_new_one_has_its_name_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.jsonl");
        let write = |text: &str| {
            let growing = UnfinishedFile::growing(&path).unwrap();
            growing.file().write_all(text.as_bytes()).unwrap();
            growing
        };
        let mut first = write("first");
        assert_eq!(text(&path), "first");
        first.finish().unwrap();
        let mut second = write("second");
        assert_eq!(text(&path), "first");
        second.finish().unwrap();
        drop(second);
        assert_eq!(text(&path), "second");
        drop(write("given up"));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing unfinished is left");
        let kept = write("kept").keep().unwrap();
        assert_eq!([text(&path), text(&kept)], ["second", "kept"]);
        let name = kept.file_name().unwrap().to_str().unwrap();
        assert_eq!(name, format!("trace.jsonl.{}.part", std::process::id()));
    }

    #[cfg(unix)]
    #[test]
    fn links_lead_on_devices_stay_and_permissions_are_kept() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let [path, link] = ["file", "link"].map(|name| folder.path().join(name));
        fs::write(&path, "first").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
        symlink(&path, &link).unwrap();
        replace_file(&link, |mut file| file.write_all(b"second")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(text(&path), "second");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        let null = Path::new("/dev/null");
        replace_file(null, |mut file| file.write_all(b"nothing")).unwrap();
        assert!(!fs::metadata(null).unwrap().is_file());
    }
}
