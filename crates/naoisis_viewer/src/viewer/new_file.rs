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
    for path in paths(folder, name, ending) {
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(mut file) => return file.write_all(bytes).map(|()| path),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(none_free(name))
}

/// Returns the path of a new file, named as by [`write_new`], that neither exists nor `is_taken`.
///
/// # Errors
/// When there are too many files of this name.
pub fn new_path(folder: &Path, name: &str, ending: &str, is_taken: impl Fn(&Path) -> bool) -> io::Result<PathBuf> {
    paths(folder, name, ending).find(|path| !path.exists() && !is_taken(path)).ok_or_else(|| none_free(name))
}

fn paths(folder: &Path, name: &str, ending: &str) -> impl Iterator<Item = PathBuf> {
    (1..=MOST_OF_ONE_NAME).map(move |attempt| {
        let suffix = if attempt == 1 { String::new() } else { format!("-{attempt}") };
        folder.join(format!("{name}{suffix}.{ending}"))
    })
}

fn none_free(name: &str) -> io::Error {
    io::Error::new(io::ErrorKind::AlreadyExists, format!("there are {MOST_OF_ONE_NAME} files `{name}` already"))
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
        let third = new_path(folder.path(), "match3v3-000012", "json", |path| path.ends_with("match3v3-000012-3.json"));
        assert_eq!(third.unwrap(), folder.path().join("match3v3-000012-4.json"));
        assert_eq!([first, second].map(|path| std::fs::read_to_string(path).unwrap()), ["one", "two"]);
    }

    #[test]
    fn names_become_names_of_files() {
        assert_eq!(stem("right foot/2"), "right_foot_2");
        assert_eq!(stem("ball, place x"), "ball_place_x");
        assert_eq!(stem(&"a".repeat(500)).len(), LONGEST_NAME);
    }
}
