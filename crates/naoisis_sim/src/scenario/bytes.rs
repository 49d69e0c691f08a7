//! Reading files that are no larger than they should be.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// Larger files are no scenarios: a script for each of 22 robots, with an entry a second for twenty minutes, has less. A file
/// takes a hundred times its size in memory where it is a script of the shortest entries, from its text to the match.
pub(super) const LARGEST_FILE_BYTES: u64 = 2 << 20;

/// The bytes of an ordinary file, of one that is too large a few more than there may be.
pub(super) fn read_bytes(path: &Path) -> io::Result<Vec<u8>> {
    // A pipe would be waited for as soon as it is opened.
    let kind = fs::metadata(path)?;
    if kind.is_dir() {
        return Err(io::Error::other("it is a directory"));
    }
    if !kind.is_file() {
        return Err(io::Error::other("it is no ordinary file"));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(LARGEST_FILE_BYTES + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}
