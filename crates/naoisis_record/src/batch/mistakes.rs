//! The mistakes in the matches of a batch: found during the matches, counted, and written to a table of their own.

use bevy::prelude::*;
use core::fmt::{self, Write as _};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Seek, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use super::columns::setting_columns;
use super::csv_lines::{Line, Lines, as_text, cells_of, line_of};
use super::observer::MatchRow;
use super::table_file::{TableError, TableFile};
use super::{Batch, Variants};
use crate::record::RecordPlugin;
use crate::record::mistakes::{Mistake, MistakeKind};
use naoisis_core::team::RobotId;
use naoisis_sim::interface::trace_numbers::{shortest_double, shortest_single};

/// Finds the [mistakes](crate::record::mistakes) in the matches of a batch, for [`MatchRow::mistakes`]. The matches are the same with
/// it and take a little longer.
pub struct FindMistakes;

impl Plugin for FindMistakes {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<RecordPlugin>() {
            app.add_plugins(RecordPlugin);
        }
        app.init_resource::<MistakesAreFound>();
    }
}

/// Marks a world in which mistakes are found during the match.
#[derive(Resource, Default)]
pub(super) struct MistakesAreFound;

/// Columns before the settings.
const LEADING_COLUMNS: [&str; 2] = ["match", "seed"];

/// Columns after the settings.
const COLUMNS: [&str; 10] = ["kind", "robot", "other", "from_s", "until_s", "x_m", "y_m", "worst", "unit", "realism"];

/// The number of mistakes of each kind, and the number of matches, by the name of a robot or team.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct MistakeCounts {
    counts: BTreeMap<String, ([u32; MistakeKind::ALL.len()], usize)>,
}

impl MistakeCounts {
    /// Counts mistakes by name. `matches` returns the number of matches of a name.
    pub fn of(mistakes: impl IntoIterator<Item = (String, MistakeKind, u32)>, matches: impl Fn(&str) -> usize) -> Self {
        let mut counts = BTreeMap::<String, ([u32; MistakeKind::ALL.len()], usize)>::new();
        for (who, kind, count) in mistakes {
            let matches = matches(&who);
            let (counts, of_matches) = counts.entry(who).or_default();
            counts[kind as usize] += count;
            *of_matches = matches;
        }
        Self { counts }
    }
}

/// Shows the mistakes per match: a line for each name, a column for each kind that occurred.
impl fmt::Display for MistakeCounts {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_there = |kind: &MistakeKind| self.counts.values().any(|(counts, _)| counts[*kind as usize] > 0);
        let kinds: Vec<MistakeKind> = MistakeKind::ALL.into_iter().filter(is_there).collect();
        if kinds.is_empty() {
            return writeln!(formatter, "no mistakes were found");
        }
        const TITLE: &str = "mistakes a match";
        let width = self.counts.keys().map(|who| who.chars().count()).max().unwrap_or(0).max(TITLE.len());
        write!(formatter, "{TITLE:<width$}")?;
        kinds.iter().try_for_each(|kind| write!(formatter, "  {kind}"))?;
        for (who, (counts, matches)) in &self.counts {
            write!(formatter, "\n{who:<width$}")?;
            for &kind in &kinds {
                let mean = f64::from(counts[kind as usize]) / (*matches).max(1) as f64;
                write!(formatter, "  {mean:>width$.2}", width = kind.words().len())?;
            }
        }
        formatter.write_char('\n')
    }
}

/// The table of a batch's mistakes, in a file, and their counts.
pub struct MistakeTable {
    path: PathBuf,
    file: File,
    counts: BTreeMap<(usize, RobotId, MistakeKind), u32>,
    next: usize,
}

impl MistakeTable {
    /// Opens the table of a batch whose matches from index `first` on were played earlier, with the results `played`: a new file if there are
    /// none, or the one that was written with them. Rows of later matches are removed. Where rows of a match that was played are missing, as
    /// after a power cut, those of the matches from that one on are removed, too, and these must be played again: see [`Self::next`].
    ///
    /// # Errors
    /// If the file cannot be written or has other contents.
    pub fn open<V: Variants>(
        path: &Path,
        batch: &Batch<V>,
        first: usize,
        played: &[MatchRow],
    ) -> Result<Self, TableError> {
        let next = first + played.len();
        let io_error = |error| TableError::Io { path: path.to_owned(), error };
        if !path.exists() && next > first {
            return Err(TableError::NoMistakes { path: path.to_owned(), matches: next - first });
        }
        let mut opened = TableFile::open(path)?;
        let header = header(batch);
        let mut lines = Lines { reader: BufReader::new(&opened.file), read_bytes: 0 };
        let mut there = Rows { next, whole_bytes: 0, counts: BTreeMap::new() };
        match lines.next_whole().map_err(io_error)? {
            Line::Whole(line) if line == header => there = Rows::read(lines, path, batch, first, played)?,
            Line::Part(part) if header.starts_with(&part) => there.next = first,
            _ => return Err(TableError::foreign(path, 1, "this is no table of this batch's mistakes".to_owned())),
        }
        let cut = opened.file.set_len(there.whole_bytes).and_then(|()| opened.file.seek(SeekFrom::End(0)));
        cut.map_err(io_error)?;
        if there.whole_bytes == 0 {
            opened.write_header(&header)?;
        }
        Ok(Self { path: path.to_owned(), file: opened.file, counts: there.counts, next: there.next })
    }

    /// The index of the first match whose mistakes are not in the table that was opened.
    pub fn next(&self) -> usize {
        self.next
    }

    /// Writes the mistakes of a match. Call it before the match's own row is written.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write<V: Variants>(&mut self, batch: &Batch<V>, row: &MatchRow) -> Result<(), TableError> {
        let lines: String = row.mistakes.iter().map(|mistake| line(batch, row, mistake)).collect();
        for mistake in &row.mistakes {
            *self.counts.entry((row.variant, mistake.robot, mistake.kind)).or_default() += 1;
        }
        let written: io::Result<()> = self.file.write_all(lines.as_bytes());
        written.map_err(|error| TableError::NotWritten { path: self.path.clone(), error })
    }

    /// Returns the counts as variant, robot, kind and number of mistakes.
    pub fn counts(&self) -> impl Iterator<Item = (usize, RobotId, MistakeKind, u32)> {
        self.counts.iter().map(|((variant, robot, kind), count)| (*variant, *robot, *kind, *count))
    }
}

/// The rows of a table, as far as they are whole.
struct Rows {
    /// The index of the first match without them.
    next: usize,
    whole_bytes: u64,
    counts: BTreeMap<(usize, RobotId, MistakeKind), u32>,
}

impl Rows {
    /// Reads the rows after the header, of the matches from index `first` on with the results `played`.
    fn read<V: Variants>(
        mut lines: Lines,
        path: &Path,
        batch: &Batch<V>,
        first: usize,
        played: &[MatchRow],
    ) -> Result<Self, TableError> {
        // The index of the match, where its line begins, and what the line says.
        let mut rows: Vec<(usize, u64, RobotId, MistakeKind)> = Vec::new();
        let (mut number, mut latest, mut next) = (1, first, first + played.len());
        let torn = loop {
            number += 1;
            let begin = lines.read_bytes;
            let line = match lines.next_whole().map_err(|error| TableError::Io { path: path.to_owned(), error })? {
                Line::Whole(line) => line,
                Line::Part(part) => break part,
            };
            let (index, who, kind) = read_row(batch, &line)
                .filter(|(index, ..)| *index >= latest)
                .ok_or_else(|| TableError::foreign(path, number, "this is no mistake of this batch".to_owned()))?;
            // Beside a table without matches only one can be under way: the other table is missing.
            if played.is_empty() && index > first {
                let message =
                    format!("mistakes of match {} are here, and the table of matches has no match", index + 1);
                return Err(TableError::foreign(path, number, message));
            }
            latest = index;
            rows.push((index, begin, who, kind));
        };
        if !torn.is_empty() {
            let match_number = torn.split_once(',').and_then(|(number, _)| number.parse::<usize>().ok());
            let cut_off =
                match_number.and_then(|number| number.checked_sub(1)).map_or(latest, |index| index.max(latest));
            next = next.min(cut_off);
        }
        let mut found: BTreeMap<usize, u32> = BTreeMap::new();
        for (index, ..) in &rows {
            *found.entry(*index).or_default() += 1;
        }
        let count = |index| found.get(&index).copied().unwrap_or(0);
        let is_whole = |(index, row): &(usize, &MatchRow)| row.mistakes_found.is_none_or(|all| all == count(*index));
        next = first + (first..next).zip(played).take_while(is_whole).count();
        let end = rows.iter().find(|(index, ..)| *index >= next).map_or(lines.read_bytes, |(_, begin, ..)| *begin);
        let mut counts = BTreeMap::new();
        for (index, _, who, kind) in rows.into_iter().take_while(|(index, ..)| *index < next) {
            *counts.entry((batch.job(index).0, who, kind)).or_default() += 1;
        }
        Ok(Self { next, whole_bytes: end, counts })
    }
}

fn header<V: Variants>(batch: &Batch<V>) -> String {
    let columns = setting_columns(batch);
    line_of(LEADING_COLUMNS.into_iter().chain(columns.iter().map(String::as_str)).chain(COLUMNS))
}

/// Returns the cells that identify match `index`.
fn match_cells<V: Variants>(batch: &Batch<V>, index: usize) -> Vec<String> {
    let (variant, seed) = batch.job(index);
    let mut cells = vec![(index + 1).to_string(), seed.to_string()];
    cells.extend(batch.variants.values(variant).into_iter().map(as_text));
    cells
}

fn line<V: Variants>(batch: &Batch<V>, row: &MatchRow, mistake: &Mistake) -> String {
    let mut cells = match_cells(batch, row.index);
    let seconds = |time_s: f64| shortest_double(time_s).to_string();
    let metres = |length_m: f32| shortest_single(length_m).to_string();
    cells.extend([
        mistake.kind.key().to_owned(),
        mistake.robot.to_string(),
        mistake.other.map(|other| other.to_string()).unwrap_or_default(),
        seconds(mistake.from_s),
        seconds(mistake.until_s),
        metres(mistake.position_m.x),
        metres(mistake.position_m.y),
        mistake.worst.map(metres).unwrap_or_default(),
        mistake.unit().to_owned(),
        batch.variants.realism(row.variant),
    ]);
    line_of(cells.iter().map(String::as_str))
}

/// Returns the match, the robot and the kind of mistake of a line. Returns `None` if the line is not of this batch.
fn read_row<V: Variants>(batch: &Batch<V>, line: &str) -> Option<(usize, RobotId, MistakeKind)> {
    let cells = cells_of(line);
    let index = cells.first()?.parse::<usize>().ok()?.checked_sub(1).filter(|index| *index < batch.len())?;
    let ours = match_cells(batch, index);
    if cells.len() != ours.len() + COLUMNS.len() || !cells.starts_with(&ours) {
        return None;
    }
    let kind = MistakeKind::ALL.into_iter().find(|kind| kind.key() == cells[ours.len()])?;
    Some((index, cells[ours.len() + 1].parse().ok()?, kind))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::{MatchOutcome, run_batch};
    use core::sync::atomic::AtomicBool;
    use naoisis_sim::scenario::Scenario;
    use naoisis_sim::simulation::NaoisisPlugins;
    use std::fs;

    fn simulator() -> App {
        let mut app = App::new();
        app.add_plugins((NaoisisPlugins, FindMistakes));
        app
    }

    fn batch() -> Batch {
        let mut scenario = Scenario::named("match3v3").unwrap();
        scenario.duration_s = Some(20.0);
        Batch { variants: vec![scenario], matches: 3, first_seed: 1, threads: 2 }
    }

    fn rows(batch: &Batch) -> Vec<MatchRow> {
        let mut rows = Vec::new();
        run_batch(batch, 0, simulator, &AtomicBool::new(false), |row| rows.push(row));
        rows
    }

    #[test]
    fn names_of_kinds_are_those_of_the_report_of_a_match() {
        for kind in MistakeKind::ALL {
            assert_eq!(serde_json::to_value(kind).unwrap(), kind.key());
        }
    }

    #[test]
    fn counts_are_means_of_the_matches_of_each() {
        let (missed, lost) = (MistakeKind::KickMissed, MistakeKind::OwnPoseLost);
        let made = [("roles", missed, 3), ("chasers", lost, 1), ("roles", missed, 2)];
        let made = made.map(|(who, kind, count)| (who.to_owned(), kind, count));
        let counts = MistakeCounts::of(made, |who| if who == "roles" { 2 } else { 4 });
        let expected = "mistakes a match  own pose lost  kick missed\n\
                        chasers                    0.25         0.00\n\
                        roles                      0.00         2.50\n";
        assert_eq!(counts.to_string(), expected);
        assert_eq!(MistakeCounts::default().to_string(), "no mistakes were found\n");
    }

    #[test]
    fn a_table_that_goes_on_is_the_one_that_was_written_at_once_and_so_are_its_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mistakes.csv");
        let (batch, text) = (batch(), || fs::read_to_string(&path).unwrap());
        let rows = rows(&batch);
        assert!(rows.iter().all(|row| !row.mistakes.is_empty()), "matches without mistakes show nothing");
        let mut table = MistakeTable::open(&path, &batch, 0, &[]).unwrap();
        rows.iter().for_each(|row| table.write(&batch, row).unwrap());
        let (whole, counts) = (text(), table.counts.clone());
        assert_eq!(counts.values().sum::<u32>() as usize, whole.lines().count() - 1);
        drop(table);
        for played in 0..=rows.len() {
            // Rows of the match under way are cut off, even in the middle of a line.
            let number = |line: &str| line.split(',').next().and_then(|cell| cell.parse::<usize>().ok()).unwrap_or(0);
            let mut there: String = whole.split_inclusive('\n').filter(|line| number(line) <= played + 1).collect();
            if played < rows.len() {
                there.truncate(there.len() - 3);
            }
            fs::write(&path, &there).unwrap();
            let mut table = MistakeTable::open(&path, &batch, 0, &rows[..played]).unwrap();
            rows[played..].iter().for_each(|row| table.write(&batch, row).unwrap());
            assert!(text() == whole && table.counts == counts, "{played}");
        }
    }

    #[test]
    fn a_table_that_lost_its_end_goes_on_wherever_it_was_cut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mistakes.csv");
        let batch = batch();
        let rows = rows(&batch);
        let mut table = MistakeTable::open(&path, &batch, 0, &[]).unwrap();
        rows.iter().for_each(|row| table.write(&batch, row).unwrap());
        let (whole, counts) = (fs::read(&path).unwrap(), table.counts.clone());
        drop(table);
        let ends_of_lines = (1..whole.len()).filter(|cut| whole[cut - 1] == b'\n');
        for cut in (0..whole.len()).step_by(7).chain(ends_of_lines).chain([whole.len() - 1]) {
            fs::write(&path, &whole[..cut]).unwrap();
            let mut table = MistakeTable::open(&path, &batch, 0, &rows).unwrap();
            assert!(table.next() < rows.len(), "{cut}");
            rows[table.next()..].iter().for_each(|row| table.write(&batch, row).unwrap());
            assert!(fs::read(&path).unwrap() == whole && table.counts == counts, "{cut}");
        }
    }

    #[test]
    fn mistakes_of_matches_whose_rows_were_lost_are_found_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mistakes.csv");
        let batch = batch();
        let rows = rows(&batch);
        let mut table = MistakeTable::open(&path, &batch, 0, &[]).unwrap();
        rows.iter().for_each(|row| table.write(&batch, row).unwrap());
        let whole = fs::read(&path).unwrap();
        drop(table);
        for played in 1..=rows.len() {
            fs::write(&path, &whole).unwrap();
            let mut table = MistakeTable::open(&path, &batch, 0, &rows[..played]).unwrap();
            assert_eq!(table.next(), played);
            rows[played..].iter().for_each(|row| table.write(&batch, row).unwrap());
            assert!(fs::read(&path).unwrap() == whole, "{played}");
        }
    }

    #[test]
    fn tables_of_something_else_are_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mistakes.csv");
        let batch = batch();
        let played = [1, 2].map(|seed| MatchRow::failed(seed, MatchOutcome::Duration, String::new()));
        assert!(matches!(
            MistakeTable::open(&path, &batch, 0, &played),
            Err(TableError::NoMistakes { matches: 2, .. })
        ));
        drop(MistakeTable::open(&path, &batch, 0, &[]).unwrap());
        let header = fs::read_to_string(&path).unwrap();
        let wrong_seed = format!("{header}1,7,kick_missed,blue1,,1,1,0,0,,,\n");
        let wrong_kind = format!("{header}1,1,yawned,blue1,,1,1,0,0,,,\n");
        // Whose matches are in no order.
        let unordered = format!("{header}2,2,kick_missed,blue1,,1,1,0,0,,,\n1,1,kick_missed,blue1,,1,1,0,0,,,\n");
        for text in ["a story", "match,seed\n1,1\n", &wrong_seed, &wrong_kind, &unordered] {
            fs::write(&path, text).unwrap();
            assert!(
                matches!(MistakeTable::open(&path, &batch, 0, &played[..1]), Err(TableError::Foreign { .. })),
                "{text}"
            );
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        // A new table of matches beside an old one of mistakes.
        let of_later = format!("{header}3,3,kick_missed,blue1,,1,1,0,0,,,\n");
        fs::write(&path, &of_later).unwrap();
        let error = MistakeTable::open(&path, &batch, 0, &[]).err().unwrap().to_string();
        assert!(error.contains("mistakes of match 3 are here, and the table of matches has no match"), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), of_later);
    }
}
