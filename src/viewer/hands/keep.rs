//! Saves the present situation as a scenario file.

use bevy::prelude::*;
use std::fs::OpenOptions;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use crate::cycle::CycleClock;
use crate::scenario::Scenario;
use crate::simulation::situation;
use crate::viewer::keyframes::Keyframes;
use crate::viewer::rebuild::Rebuilt;
use crate::viewer::shared::Notice;

/// So many files of one name are kept beside each other.
const MOST_OF_ONE_NAME: u32 = 1000;

/// Saves the situation in the current folder, and says where.
pub(super) fn keep_situation(world: &mut World) {
    let text = match keep(world) {
        Ok(path) => format!("Saved as {}: where everybody is, at the start of a match", path.display()),
        Err(message) => format!("The situation is not saved: {message}"),
    };
    world.resource_mut::<Notice>().tell(text);
}

/// Saves the moment of the past that is shown, as soon as it has been played again.
pub(super) fn keep_past_situation(world: &mut World) {
    let cycle = world.resource::<CycleClock>().cycle;
    let Some(rebuilt) = world.get_resource::<Rebuilt>() else { return };
    let text = match rebuilt.moment(cycle, world.resource::<Keyframes>()) {
        Some(moment) if moment.is_same => {
            match moment.situation.as_ref().map_err(Clone::clone).and_then(|scenario| write_scenario(scenario, cycle)) {
                Ok(path) => format!("Saved as {}: where everybody is, at the start of a match", path.display()),
                Err(message) => format!("The situation is not saved: {message}"),
            }
        }
        Some(_) => "The situation is not saved: played again, the match is another one here".to_owned(),
        None => rebuilt
            .why_not(cycle, world.resource::<Keyframes>())
            .unwrap_or_else(|| "The match is played again to here: once more, please".to_owned()),
    };
    world.resource_mut::<Notice>().tell(text);
}

fn keep(world: &mut World) -> Result<PathBuf, String> {
    let scenario = situation(world).map_err(|fault| fault.to_string())?;
    write_scenario(&scenario, world.resource::<CycleClock>().cycle)
}

/// Writes a scenario of the moment after a cycle into a new file in the current folder.
///
/// # Errors
/// Why it cannot be written.
pub fn write_scenario(scenario: &Scenario, cycle: u64) -> Result<PathBuf, String> {
    let text = scenario.resolved_json().map_err(|error| error.to_string())?;
    let name = format!("{}-{cycle:06}", stem(&scenario.name));
    write_new(Path::new(""), &name, "json", &text).map_err(|error| error.to_string())
}

/// The name without what file systems object to.
fn stem(name: &str) -> String {
    let stem: String =
        name.chars().map(|letter| if letter.is_alphanumeric() || letter == '-' { letter } else { '_' }).collect();
    if stem.is_empty() { "situation".to_owned() } else { stem }
}

/// Writes a file that was not there before.
fn write_new(folder: &Path, name: &str, ending: &str, text: &str) -> io::Result<PathBuf> {
    for attempt in 1..=MOST_OF_ONE_NAME {
        let suffix = if attempt == 1 { String::new() } else { format!("-{attempt}") };
        let path = folder.join(format!("{name}{suffix}.{ending}"));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(mut file) => return file.write_all(text.as_bytes()).map(|()| path),
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
        let first = write_new(folder.path(), "match3v3-000012", "json", "one").unwrap();
        let second = write_new(folder.path(), "match3v3-000012", "json", "two").unwrap();
        assert_eq!(second, folder.path().join("match3v3-000012-2.json"));
        assert_eq!([first, second].map(|path| std::fs::read_to_string(path).unwrap()), ["one", "two"]);
    }

    #[test]
    fn names_of_scenarios_become_names_of_files() {
        assert_eq!(stem("right foot/2"), "right_foot_2");
        assert_eq!(stem(""), "situation");
    }
}
