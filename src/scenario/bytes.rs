//! Reading files that are no larger than they should be.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Larger files are no scenarios: a script for each of 22 robots, with an entry a second for twenty minutes, has less. A file
/// takes a hundred times its size in memory where it is a script of the shortest entries, from its text to the match.
pub(super) const LARGEST_FILE_BYTES: u64 = 2 << 20;

/// The bytes of a file, of one that is too large a few more than there may be.
pub(super) fn read_bytes(path: &Path) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    if file.metadata()?.is_dir() {
        return Err(io::Error::other("it is a directory"));
    }
    let mut bytes = Vec::new();
    file.take(LARGEST_FILE_BYTES + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}
