//! What `naoisis run` writes: checked before the match, not after it.

use bevy::prelude::*;
use std::path::{Path, PathBuf};

use super::run_arguments::RunArguments;
use crate::cycle::CycleClock;
use crate::scenario::Scenario;
use crate::simulation::snapshot::EXTENSION;

/// That no output would be written over what the match begins with, or over another output.
pub fn check(arguments: &RunArguments) -> Result<(), String> {
    arguments.pictures.check()?;
    let input = PathBuf::from(&arguments.scenario);
    let outputs = [("--trace", &arguments.trace), ("--beliefs", &arguments.beliefs), ("--save", &arguments.save)];
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| absolute(path));
    let mut taken = vec![("the scenario", real(&input))];
    for (option, path) in outputs {
        let Some(path) = path.as_deref().filter(|path| path.as_os_str() != "-") else { continue };
        let path = real(path);
        if let Some((what, _)) = taken.iter().find(|(_, other)| *other == path) {
            return Err(format!("{option}: this would write over {what}; expected another file"));
        }
        taken.push((option, path));
    }
    if arguments.beliefs.as_ref().is_some_and(|path| path.as_os_str() == "-") {
        return Err("--beliefs: only --trace goes to standard output; expected a file".to_owned());
    }
    let Some(path) = &arguments.save else { return Ok(()) };
    if path.extension().is_none_or(|extension| extension != EXTENSION) {
        return Err(format!("--save: {}: expected a file name that ends in .{EXTENSION}", path.display()));
    }
    // Said now rather than after the match.
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() || path.is_dir() {
        return Err(format!("--save: {}: expected a file in a folder that exists", path.display()));
    }
    Ok(())
}

/// That the match comes to the time at which it shall be saved.
pub fn check_time_of_saving(world: &World, scenario: &Scenario, arguments: &RunArguments) -> Result<(), String> {
    let Some(save_at_s) = arguments.save_at else { return Ok(()) };
    let clock = world.resource::<CycleClock>();
    let cycle = cycle_at(save_at_s, clock);
    if cycle < clock.cycle {
        let now_s = clock.end_time_s();
        return Err(format!(
            "--save-at: {save_at_s} s are over, the match goes on at {now_s:.1} s; expected a later time"
        ));
    }
    match scenario.last_cycle() {
        Some(last) if cycle > last => {
            let end_s = last as f64 * clock.period_s;
            Err(format!("--save-at: the match ends at {end_s:.1} s; expected an earlier time than {save_at_s} s"))
        }
        _ => Ok(()),
    }
}

/// The cycle at whose end a match is this old, s.
pub fn cycle_at(time_s: f32, clock: &CycleClock) -> u64 {
    (f64::from(time_s) / clock.period_s).round() as u64
}
