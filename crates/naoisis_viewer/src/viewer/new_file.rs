//! New files that the window writes: with a descriptive name, never replacing others.

use std::fs::OpenOptions;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// The most files of one name.
const MOST_OF_ONE_NAME: u32 = 1000;
/// The greatest length of a name, letters.
const LONGEST_NAME: usize = 60;

/// Returns `name` without characters that file systems forbid.
pub fn stem(name: &str) -> String {
    let letters = name.chars().map(|letter| if letter.is_alphanumeric() || letter == '-' { letter } else { '_' });
    let mut stem: String = letters.take(LONGEST_NAME).collect();
    while stem.contains("__") {
        stem = stem.replace("__", "_");
    }
    stem
}

/// Writes a new file: `NAME.ENDING`, or `NAME-2.ENDING` and so on.
///
/// # Errors
/// When the file cannot be written.
pub fn write_new(folder: &Path, name: &str, ending: &str, bytes: &[u8]) -> io::Result<PathBuf> {
    for attempt in 1..=MOST_OF_ONE_NAME {
        let suffix = if attempt == 1 { String::new() } else { format!("-{attempt}") };
        let path = folder.join(format!("{name}{suffix}.{ending}"));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(mut file) => return file.write_all(bytes).map(|()| path),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::new(io::ErrorKind::AlreadyExists, format!("there are {MOST_OF_ONE_NAME} files `{name}` already")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let first = write_new(folder.path(), "match3v3-000012", "json", b"one").unwrap();
        let second = write_new(folder.path(), "match3v3-000012", "json", b"two").unwrap();
        assert_eq!(second, folder.path().join("match3v3-000012-2.json"));
        assert_eq!([first, second].map(|path| std::fs::read_to_string(path).unwrap()), ["one", "two"]);
    }

    #[test]
    fn names_become_names_of_files() {
        assert_eq!(stem("right foot/2"), "right_foot_2");
        assert_eq!(stem("ball, place x"), "ball_place_x");
        assert_eq!(stem(&"a".repeat(500)).len(), LONGEST_NAME);
    }
}
