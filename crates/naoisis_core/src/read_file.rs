//! Reading of whole files up to a limit.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// The size of the largest files that are read as a whole, bytes. Saved matches, networks and meshes are smaller.
pub const LARGEST_FILE_BYTES: u64 = 512 << 20;

/// Reads a regular file of at most [`LARGEST_FILE_BYTES`] bytes.
///
/// # Errors
/// If the file cannot be read, is not a regular file, or is larger.
pub fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    read_up_to(path, LARGEST_FILE_BYTES)
}

fn read_up_to(path: &Path, most_bytes: u64) -> io::Result<Vec<u8>> {
    // Opening a pipe would block, so the kind of the file is checked first.
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::other("this is no ordinary file"));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(most_bytes + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most_bytes {
        let message = format!("the file has more than {} MiB", most_bytes >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_and_endless_files_are_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, vec![7; 1 << 20]).unwrap();
        assert_eq!(read_up_to(&path, 1 << 20).unwrap().len(), 1 << 20);
        fs::write(&path, vec![7; (1 << 20) + 1]).unwrap();
        assert_eq!(read_up_to(&path, 1 << 20).unwrap_err().to_string(), "the file has more than 1 MiB");
        for other in [
            folder.path(),
            #[cfg(unix)]
            Path::new("/dev/zero"),
        ] {
            assert_eq!(read_up_to(other, 1 << 20).unwrap_err().to_string(), "this is no ordinary file");
        }
        assert_eq!(read_file(&folder.path().join("nowhere")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
