//! Files that take the place of earlier ones: whole, or not at all.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// Writes a file, in place of any that is there: beside it and under another name until it is whole. When that fails, as
/// on a full disk, the earlier one is as it was.
///
/// A link is followed, so that the file that it leads to is replaced; a device or a pipe is written to as it is.
///
/// # Errors
/// Those of the file system, and of `write`.
pub(crate) fn replace_file(path: &Path, write: impl FnOnce(&File) -> io::Result<()>) -> io::Result<()> {
    let earlier = fs::metadata(path).ok();
    if earlier.as_ref().is_some_and(|earlier| !earlier.is_file()) {
        return write(&File::options().write(true).open(path)?);
    }
    let place = if earlier.is_some() { fs::canonicalize(path)? } else { path.to_owned() };
    let unfinished = unfinished_name(&place);
    let written = File::create(&unfinished).and_then(|file| {
        write(&file)?;
        if let Some(earlier) = earlier {
            file.set_permissions(earlier.permissions())?;
            // Some file systems find out that they are full only here; the earlier file is given up for nothing less.
            file.sync_all()?;
        }
        fs::rename(&unfinished, &place)
    });
    written.inspect_err(|_| {
        // What is left of it is of use to nobody. If that cannot be removed either, the first error says enough.
        let _ = fs::remove_file(&unfinished);
    })
}

/// The name of a file until it is whole: of each process its own, as two may write the same file.
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
