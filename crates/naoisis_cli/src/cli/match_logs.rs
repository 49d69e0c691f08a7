//! Counts real matches in the logs of `naoisis realism --logs`.

use core::fmt::{self, Write as _};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::match_realism_table::measured;
use super::report;
use naoisis_core::replace_file::replace_file;
use naoisis_lab::match_realism::{Comparison, MatchMeasures, RealFigures};
use naoisis_record::record::game_controller_log::GameControllerLog;

/// Real matches, counted in the logs of a GameController.
pub(super) struct CountedLogs {
    folder: PathBuf,
    logs: Vec<GameControllerLog>,
    pub(super) comparison: Comparison,
}

impl CountedLogs {
    /// Reads a log as far as it goes, or of all `.yaml` files of a folder those of whole matches, in the order of their names. What
    /// is not counted is noted.
    ///
    /// # Errors
    /// When a single log cannot be read, or the folder has no log of a whole match.
    pub fn read(path: &Path, quiet: bool) -> Result<Self, String> {
        let note = |message: &str| {
            if !quiet {
                report::note(message);
            }
        };
        let logs = if path.is_dir() {
            whole_matches(path, note)?
        } else {
            let log = GameControllerLog::read(path).map_err(|error| error.to_string())?;
            if !log.is_whole_match {
                note(&format!("{}: the log ends before the match: it is counted as far as it goes", path.display()));
            }
            vec![log]
        };
        let competitions = competitions(&logs);
        if competitions.len() > 1 {
            let names = competitions.join(", ");
            note(&format!("{}: logs of several competitions are counted together: {names}", path.display()));
        }
        let measures: Vec<MatchMeasures> =
            logs.iter().map(|log| MatchMeasures::of_counts(&log.counts, Some(log.messages))).collect();
        let comparison = Comparison::of(&measures, &[], "");
        Ok(Self { folder: path.to_owned(), logs, comparison })
    }

    /// Returns the number of matches.
    pub fn len(&self) -> usize {
        self.logs.len()
    }

    /// Returns the values as figures of real matches, to compare with `scenario`; with all scenarios if it is `None`.
    pub fn figures(&self, scenario: Option<&str>) -> RealFigures {
        let count = self.logs.len();
        let name = self.folder.file_name().unwrap_or_default().to_string_lossy();
        let source = format!("{count} log{} of a GameController, {name}", if count == 1 { "" } else { "s" });
        let matches = u32::try_from(count).unwrap_or(u32::MAX);
        let name = competitions(&self.logs).join(", ");
        let figures = self.comparison.to_real_figures(&name, &self.years(), &source, matches);
        RealFigures { scenarios: scenario.map(str::to_owned).into_iter().collect(), ..figures }
    }

    /// Writes the figures as a file for `--real`, to compare with `scenario`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_figures(&self, path: &Path, scenario: Option<&str>) -> io::Result<()> {
        let text = self.figures(scenario).to_ron().map_err(io::Error::other)?;
        replace_file(path, |mut file| io::Write::write_all(&mut file, text.as_bytes()))
    }

    /// Returns the years of the matches, such as `2023-2024`.
    fn years(&self) -> String {
        let years = || self.logs.iter().filter_map(|log| log.date.get(..4));
        match (years().min(), years().max()) {
            (Some(first), Some(last)) if first != last => format!("{first}-{last}"),
            (first, _) => first.unwrap_or("no date").to_owned(),
        }
    }
}

impl fmt::Display for CountedLogs {
    fn fmt(&self, text: &mut fmt::Formatter<'_>) -> fmt::Result {
        for log in &self.logs {
            let (goals, teams) = (log.counts.goals, log.team_numbers);
            let date = log.date.get(..10).map(|date| format!("{date} ")).unwrap_or_default();
            writeln!(
                text,
                "{date}{}: team {} against team {}, {}:{}",
                log.competition, teams.blue, teams.pink, goals.blue, goals.pink
            )?;
        }
        text.write_char('\n')?;
        text.write_str(&measured(&self.comparison))
    }
}

/// Returns the names of the competitions, sorted.
fn competitions(logs: &[GameControllerLog]) -> Vec<&str> {
    let mut names: Vec<&str> = logs.iter().map(|log| log.competition.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// Reads the logs of whole matches in a folder. Calls `note` for each other log with the reason.
fn whole_matches(folder: &Path, note: impl Fn(&str)) -> Result<Vec<GameControllerLog>, String> {
    let files = files(folder)?;
    let mut logs = Vec::new();
    for file in &files {
        match GameControllerLog::read(file) {
            Ok(log) if log.is_whole_match => logs.push(log),
            Ok(_) => note(&format!("{}: left out: the log ends before the match", file.display())),
            Err(error) => note(&format!("left out: {error}")),
        }
    }
    if logs.is_empty() {
        let (folder, count) = (folder.display(), files.len());
        return Err(format!(
            "{folder}: none of {count} .yaml files is the log of a whole match; the name of one file counts it as far as it goes"
        ));
    }
    Ok(logs)
}

fn files(path: &Path) -> Result<Vec<PathBuf>, String> {
    let wrong = |error: io::Error| format!("{}: {error}", path.display());
    let entries = fs::read_dir(path).map_err(wrong)?.collect::<io::Result<Vec<_>>>().map_err(wrong)?;
    let mut files: Vec<PathBuf> = entries.iter().map(fs::DirEntry::path).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "yaml"));
    files.sort();
    if files.is_empty() {
        return Err(format!("{}: the folder has no .yaml file; expected logs of a GameController", path.display()));
    }
    Ok(files)
}
