//! Saves a moment as a test: the saved match, and a scenario that continues from it with an expectation.
//!
//! The scenario plays the same repetitions: the same moment, number and seeds.

use serde_json::json;
use std::path::{Path, PathBuf};

use super::Run;
use crate::viewer::new_file::{new_path, stem, write_new};
use naoisis_core::statistics;
use naoisis_core::team::Team;
use naoisis_sim::scenario::Expectation;
use naoisis_sim::scenario::saved_match::EXTENSION;

/// The seed of the first repetition, here and in the test.
pub(super) const FIRST_SEED: u64 = 1;

/// The lower bound of the share of repetitions in which a team scored, with 95 % confidence, in percent with one digit;
/// and the share itself. `None` before the first repetition.
pub(super) fn measured_percent(run: &Run, team: Team) -> Option<(f64, f64)> {
    let scored = run.rows.iter().filter(|row| row.goals[team] > 0).count();
    let share = statistics::share(scored, run.rows.len())?;
    Some(((1000.0 * share.low).floor() / 10.0, 100.0 * share.value))
}

/// The expectation that a team scores within the duration in at least `percent` of as many repetitions.
///
/// # Errors
/// A message when the numbers make no valid expectation.
pub(super) fn expectation(team: Team, percent: f64, run: &Run) -> Result<Expectation, String> {
    let text = format!("{team}.goals >= 1 within {} s in {percent} % of {}", run.for_s, run.rows.len());
    text.parse().map_err(|error| format!("{error}"))
}

/// Saves the moment and the test into a folder. Returns the path of the test.
///
/// # Errors
/// A message when the files cannot be written.
pub(super) fn save(folder: &Path, team: Team, percent: f64, run: &Run) -> Result<PathBuf, String> {
    let (name, cycle_s) = &run.of;
    let name = if name.is_empty() { "moment" } else { name.as_str() };
    let expectation = expectation(team, percent, run)?;
    let file_name = format!("{}-{:06}", stem(name), run.cycle);
    // Both files have the same name.
    let has_moment = |path: &Path| path.with_extension(EXTENSION).exists();
    let test = new_path(folder, &file_name, "json", has_moment).map_err(|error| error.to_string())?;
    let file_name = test.file_stem().map_or(file_name, |stem| stem.to_string_lossy().into_owned());
    let moment = write_new(folder, &file_name, EXTENSION, run.moment.bytes()).map_err(|error| error.to_string())?;
    // The duration covers as many cycles as were played.
    let duration_s = (run.for_s / cycle_s - 1e-6).ceil() * cycle_s;
    let test = json!({
        // Tests of several moments of a match can be told apart in a list.
        "name": format!("{name} from {:.2} s", run.moment.time_s),
        "description": format!("{name} from {:.2} s on: {expectation}", run.moment.time_s),
        "from": moment.file_name().map(|name| name.to_string_lossy()),
        "seed": FIRST_SEED,
        "duration_s": duration_s,
        "expect": [expectation],
    });
    write_new(folder, &file_name, "json", format!("{test:#}\n").as_bytes()).map_err(|error| error.to_string())
}
