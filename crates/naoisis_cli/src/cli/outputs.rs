//! Checks of the files that commands write, before the match starts. Files that the command reads are never replaced,
//! other existing files only with `--force`.

use std::fs::Metadata;
use std::path::{Path, PathBuf};

use naoisis_core::cycle::CycleClock;
use naoisis_record::record::recorder::RecordError;

/// Path that stands for standard output.
pub const STANDARD_OUTPUT: &str = "-";

/// A file that a command writes, with the option that names it.
pub struct Output {
    /// The option, such as `--trace`.
    pub option: &'static str,
    /// The file to write.
    pub path: PathBuf,
}

/// Checks that no output is a file that the command reads or another output, and without `force` that none exists.
/// Devices and pipes are allowed.
pub fn check_files(input: &Path, outputs: &[Output], force: bool) -> Result<(), String> {
    for (index, Output { option, path }) in outputs.iter().enumerate() {
        if input.exists() && is_same_file(path, input) {
            return Err(format!(
                "{option}: {}: this would replace {}, which the command reads; expected another file",
                path.display(),
                input.display(),
            ));
        }
        if let Some(other) = outputs[..index].iter().find(|other| is_same_file(path, &other.path)) {
            return Err(format!(
                "{option}: {}: {} writes this file already; expected another one",
                path.display(),
                other.option
            ));
        }
        if !force && path.metadata().is_ok_and(|there| there.is_file()) {
            return Err(format!("{option}: {}: {EXISTS}", path.display()));
        }
    }
    Ok(())
}

/// Checks the same of the files of a learned policy: its network `policy`, and the layout beside it.
pub fn check_files_of_policy(policy: &Path, outputs: &[Output], force: bool) -> Result<(), String> {
    [policy, &policy.with_extension("json")].into_iter().try_for_each(|file| check_files(file, outputs, force))
}

/// Checks that the folder of `path` is there.
pub fn check_folder_of(path: &Path) -> Result<(), String> {
    match path.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.is_dir()) {
        Some(folder) => {
            Err(format!("{}: there is no folder {}; expected a folder that is there", path.display(), folder.display()))
        }
        None => Ok(()),
    }
}

/// The error about an existing file.
pub const EXISTS: &str = "the file exists already; expected another name, or --force to replace it";

/// Returns whether two paths lead to the same file, by any names and links. Always false for devices, whose content cannot be lost.
fn is_same_file(one: &Path, other: &Path) -> bool {
    match (one.metadata(), other.metadata()) {
        (Ok(there), Ok(other_there)) => there.is_file() && is_same_inode(one, &there, other, &other_there),
        (Err(_), Err(_)) => real(one) == real(other),
        _ => false,
    }
}

#[cfg(unix)]
fn is_same_inode(_: &Path, there: &Metadata, _: &Path, other_there: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;

    (there.dev(), there.ino()) == (other_there.dev(), other_there.ino())
}

#[cfg(not(unix))]
fn is_same_inode(one: &Path, _: &Metadata, other: &Path, _: &Metadata) -> bool {
    real(one) == real(other)
}

/// As many links in a row as Linux follows.
const MOST_LINKS: usize = 40;

/// The path with its links resolved, those to missing files too.
fn real(path: &Path) -> PathBuf {
    let mut absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    for _ in 0..MOST_LINKS {
        let Ok(target) = absolute.read_link() else { break };
        absolute = absolute.parent().unwrap_or(Path::new("/")).join(target);
    }
    match (path.canonicalize(), absolute.parent().map(Path::canonicalize), absolute.file_name()) {
        (Ok(real), _, _) => real,
        (Err(_), Some(Ok(folder)), Some(name)) => folder.join(name),
        _ => absolute,
    }
}

/// Returns the cycle at whose end the match has lasted `time_s`.
pub fn cycle_at(time_s: f32, clock: &CycleClock) -> u64 {
    (f64::from(time_s) / clock.period_s).round() as u64
}

/// What can be done with a file that was not written to its end, as the rest of an error's sentence: the rows and lines of some formats are of use.
pub(super) fn use_of_a_part(error: &RecordError) -> &'static str {
    let RecordError::Io { path, .. } = error else { return "" };
    let is_of_use =
        ["jsonl", "zst", "mcap", "csv"].iter().any(|of_use| path.extension().is_some_and(|has| has == *of_use));
    if is_of_use && path.exists() { "; what was written before it can still be used" } else { "" }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn check(input: &Path, outputs: &[(&'static str, &Path)], force: bool) -> Result<(), String> {
        let outputs: Vec<Output> =
            outputs.iter().map(|&(option, path)| Output { option, path: path.to_owned() }).collect();
        check_files(input, &outputs, force)
    }

    #[test]
    fn neither_inputs_nor_what_is_there_nor_each_other_are_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let [input, link, old, new] =
            ["input.json", "link.jsonl", "old.jsonl", "new.jsonl"].map(|name| folder.path().join(name));
        fs::write(&input, "{}").unwrap();
        fs::write(&old, "old").unwrap();
        fs::hard_link(&input, &link).unwrap();
        assert_eq!(check(&input, &[("--trace", &new)], false), Ok(()));
        assert!(check(&input, &[("--trace", &old)], false).unwrap_err().contains("--force"));
        assert_eq!(check(&input, &[("--trace", &old)], true), Ok(()));
        for force in [false, true] {
            for path in [&input, &link] {
                let message = check(&input, &[("--trace", path)], force).unwrap_err();
                assert!(message.contains("which the command reads"), "{message}");
            }
            let detour = folder.path().join("./new.jsonl");
            let message = check(&input, &[("--trace", &new), ("--beliefs", &detour)], force).unwrap_err();
            assert!(message.contains("--trace writes this file already"), "{message}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_to_a_missing_file_are_that_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("inside")).unwrap();
        for (link, target) in
            [("one", "inside/new"), ("inside/two", "../one"), ("three", "inside/two"), ("four", "other")]
        {
            std::os::unix::fs::symlink(target, path(link)).unwrap();
        }
        let input = path("input");
        for other in ["one", "inside/two", "three"] {
            for (first, second) in [(other, "inside/new"), ("inside/new", other), ("four", "other")] {
                let message =
                    check(&input, &[("--trace", &path(first)), ("--beliefs", &path(second))], true).unwrap_err();
                assert!(message.contains("--trace writes this file already"), "{message}");
            }
            assert_eq!(check(&input, &[("--trace", &path(other)), ("--beliefs", &path("four"))], true), Ok(()));
        }
        std::os::unix::fs::symlink("loop", path("loop")).unwrap();
        assert_eq!(check(&input, &[("--trace", &path("loop")), ("--beliefs", &path("four"))], true), Ok(()));
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_no_file_that_could_be_lost() {
        let null = Path::new("/dev/null");
        assert_eq!(check(null, &[("--trace", null), ("--beliefs", null)], false), Ok(()));
    }
}
