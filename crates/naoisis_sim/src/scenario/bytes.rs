//! Reads files up to a size limit.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// Length limit of a scenario file, bytes: scripts for 22 robots, with an entry every second for twenty minutes, are shorter. A script of
/// the shortest possible entries takes a hundred times its size in memory.
pub(super) const LARGEST_FILE_BYTES: u64 = 2 << 20;

/// Reads a regular file. Of a file that is too large, reads one byte more than the limit.
pub(super) fn read_bytes(path: &Path) -> io::Result<Vec<u8>> {
    // Opening a pipe would wait for a writer.
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
