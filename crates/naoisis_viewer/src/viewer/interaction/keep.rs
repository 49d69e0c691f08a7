//! Saves a situation as a scenario file.

use bevy::prelude::*;
use std::path::{Path, PathBuf};

use crate::viewer::keyframes::Keyframes;
use crate::viewer::new_file::{stem, write_new};
use crate::viewer::rebuild::Rebuilt;
use crate::viewer::shared::Notice;
use naoisis_core::cycle::CycleClock;
use naoisis_sim::scenario::Scenario;
use naoisis_sim::simulation::situation;

/// Saves the current situation in the current folder, and reports the path.
pub(super) fn keep_situation(world: &mut World) {
    let text = match keep(world) {
        Ok(path) => saved_words(&path),
        Err(message) => format!("The situation was not saved: {message}"),
    };
    world.resource_mut::<Notice>().tell(text);
}

/// Saves the moment of the past that is shown, as soon as it has been rebuilt.
pub(super) fn keep_past_situation(world: &mut World) {
    let cycle = world.resource::<CycleClock>().cycle;
    let Some(rebuilt) = world.get_resource::<Rebuilt>() else { return };
    let text = match rebuilt.moment(cycle, world.resource::<Keyframes>()) {
        Some(moment) if moment.is_same => {
            match moment.situation.as_ref().map_err(Clone::clone).and_then(|scenario| write_scenario(scenario, cycle)) {
                Ok(path) => saved_words(&path),
                Err(message) => format!("The situation was not saved: {message}"),
            }
        }
        Some(_) => "The situation was not saved: the replayed match differs here".to_owned(),
        None => rebuilt
            .why_not(world.resource::<CycleClock>(), world.resource::<Keyframes>())
            .unwrap_or_else(|| "This moment is still being rebuilt: please try again".to_owned()),
    };
    world.resource_mut::<Notice>().tell(text);
}

fn saved_words(path: &Path) -> String {
    format!("Saved as {}: a new match with these positions and this score; its clock starts at zero", path.display())
}

fn keep(world: &mut World) -> Result<PathBuf, String> {
    let scenario = situation(world).map_err(|fault| fault.to_string())?;
    write_scenario(&scenario, world.resource::<CycleClock>().cycle)
}

/// Writes a scenario of the moment after a cycle into a new file in the current folder. Returns its path.
///
/// # Errors
/// A message when the file cannot be written.
pub fn write_scenario(scenario: &Scenario, cycle: u64) -> Result<PathBuf, String> {
    let text = scenario.resolved_json().map_err(|error| error.to_string())?;
    let name = if scenario.name.is_empty() { "situation".to_owned() } else { stem(&scenario.name) };
    write_new(Path::new(""), &format!("{name}-{cycle:06}"), "json", text.as_bytes()).map_err(|error| error.to_string())
}
