//! The table of a batch: comma-separated values, a row a match, in the order of the matches.
//!
//! Behind the match's number and seed come the settings of its variant, then what came of it, and at last a
//! fingerprint of the scenario, by which a later batch knows whether the table is its own and goes on where it ends.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::Batch;
use super::observer::{MatchOutcome, MatchRow};
use crate::scenario::Scenario;
use crate::team::PerTeam;

/// The columns before those of the settings.
const LEADING_COLUMNS: [&str; 2] = ["match", "seed"];

/// The columns after those of the settings.
const COLUMNS: [&str; 18] = [
    "outcome",
    "duration_s",
    "blue_goals",
    "pink_goals",
    "blue_own_goals",
    "pink_own_goals",
    "blue_kicks",
    "pink_kicks",
    "blue_penalties",
    "pink_penalties",
    "outs",
    "blue_possession",
    "ball_in_blue_half",
    "messages_lost",
    "blue_belief_error_m",
    "pink_belief_error_m",
    "note",
    "scenario",
];

/// Why a table cannot be written or gone on with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// It cannot be read or written.
    #[error("{path}: the table cannot be read or written: {error}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// It is a folder or a device.
    #[error("{path}: this is no ordinary file; expected one, or a name that there is no file of yet")]
    NotAFile {
        /// What it is.
        path: PathBuf,
    },
    /// Another program is writing it.
    #[error("{path}: another batch is writing this table; expected another file, or some patience")]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// It holds something else than a beginning of this batch.
    #[error("{path}:{line}: {message}; expected {expected}, or a file that does not exist yet")]
    Foreign {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        message: String,
        /// What would be right.
        expected: String,
    },
}

/// What distinguishes the variants of a batch: the settings' names, and for each variant their values.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct VariantColumns {
    /// The names of the settings, such as `messages.loss`.
    pub names: Vec<String>,
    /// For each variant the values, in the order of the names.
    pub values: Vec<Vec<String>>,
}

/// The table of a batch, as a file or in memory only.
pub struct Table {
    columns: VariantColumns,
    fingerprints: Vec<String>,
    file: Option<(PathBuf, File)>,
}

impl Table {
    /// A table that is written nowhere.
    pub fn unwritten() -> Self {
        Self { columns: VariantColumns::default(), fingerprints: Vec::new(), file: None }
    }

    /// The table of this batch in a file: new, or with the rows that are there already, which are returned. A last
    /// line that is not complete is cut off.
    ///
    /// # Errors
    /// When the file cannot be written, or holds another table.
    pub fn open(path: &Path, batch: &Batch, columns: VariantColumns) -> Result<(Table, Vec<MatchRow>), TableError> {
        let io_error = |error| TableError::Io { path: path.to_owned(), error };
        // Some devices can be read for ever.
        if path.metadata().is_ok_and(|metadata| !metadata.is_file()) {
            return Err(TableError::NotAFile { path: path.to_owned() });
        }
        let mut file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(io_error)?;
        // Where files cannot be locked, it goes without.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(TableError::InUse { path: path.to_owned() });
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(io_error)?;
        // Cut off in the middle of a letter, it is still a table.
        let text = String::from_utf8_lossy(&bytes);
        let whole_lines = text.rfind('\n').map_or(0, |end| end + 1);
        let whole_bytes = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end as u64 + 1);
        let fingerprints = batch.variants.iter().map(fingerprint).collect();
        let mut table = Table { columns, fingerprints, file: None };
        let header = table.header();
        if whole_lines == 0 {
            if !header.starts_with(text.as_ref()) {
                return Err(table.foreign(path, 1, "this is no table of matches"));
            }
            file.set_len(0).and_then(|()| file.seek(SeekFrom::Start(0))).map_err(io_error)?;
            file.write_all(header.as_bytes()).map_err(io_error)?;
            table.file = Some((path.to_owned(), file));
            return Ok((table, Vec::new()));
        }
        let rows = table.read_rows(path, batch, &text[..whole_lines])?;
        file.set_len(whole_bytes).and_then(|()| file.seek(SeekFrom::End(0))).map_err(io_error)?;
        table.file = Some((path.to_owned(), file));
        Ok((table, rows))
    }

    /// Writes a row.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&mut self, row: &MatchRow) -> Result<(), TableError> {
        let line = self.file.is_some().then(|| self.line(row));
        if let (Some((path, file)), Some(line)) = (&mut self.file, line) {
            file.write_all(line.as_bytes()).map_err(|error| TableError::Io { path: path.clone(), error })?;
        }
        Ok(())
    }

    fn header(&self) -> String {
        let names = self.columns.names.iter().map(String::as_str);
        line_of(LEADING_COLUMNS.into_iter().chain(names).chain(COLUMNS))
    }

    fn line(&self, row: &MatchRow) -> String {
        let settings = self.columns.values.get(row.variant).cloned().unwrap_or_default();
        let fingerprint = self.fingerprints.get(row.variant).cloned().unwrap_or_default();
        let outcome = serde_json::to_value(row.outcome).ok();
        let outcome = outcome.as_ref().and_then(|outcome| outcome.as_str()).unwrap_or_default().to_owned();
        let share = |value: Option<f64>| value.map(|value| format!("{value:.4}")).unwrap_or_default();
        let mut cells = vec![(row.index + 1).to_string(), row.seed.to_string()];
        cells.extend(settings);
        cells.extend([outcome, format!("{:.3}", row.duration_s)]);
        for counts in [row.goals, row.own_goals, row.kicks, row.penalties] {
            cells.extend([counts.blue.to_string(), counts.pink.to_string()]);
        }
        cells.push(row.outs.to_string());
        let PerTeam { blue, pink } = row.belief_error_m;
        cells.extend([row.blue_possession, row.ball_in_blue_half, row.messages_lost, blue, pink].map(share));
        // A row is a line.
        cells.extend([row.note.replace(['\n', '\r'], " "), fingerprint]);
        line_of(cells.iter().map(String::as_str))
    }

    fn read_rows(&self, path: &Path, batch: &Batch, text: &str) -> Result<Vec<MatchRow>, TableError> {
        let mut lines = text.split_inclusive('\n');
        if lines.next() != Some(self.header().as_str()) {
            return Err(self.foreign(path, 1, "these are not the columns of this batch"));
        }
        let mut rows = Vec::new();
        for (index, line) in lines.enumerate() {
            let foreign = |message: &str| self.foreign(path, index + 2, message);
            if index >= batch.len() {
                return Err(foreign("the table has more matches than this batch"));
            }
            let (variant, seed) = batch.job(index);
            let row = self.read_row(line, index, variant).ok_or_else(|| foreign("this is no row of the table"))?;
            // Whatever a row says of its scenario, settings and seed must be what this batch would write.
            if row.seed != seed || self.line(&row) != line {
                return Err(foreign("this is another match than that of this batch"));
            }
            rows.push(row);
        }
        Ok(rows)
    }

    fn read_row(&self, line: &str, index: usize, variant: usize) -> Option<MatchRow> {
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(line.as_bytes());
        let record = reader.records().next()?.ok()?;
        let first = LEADING_COLUMNS.len() + self.columns.names.len();
        let cell = |column: usize| record.get(first + column);
        let count = |column: usize| cell(column)?.parse::<u32>().ok();
        let counts = |column: usize| Some(PerTeam { blue: count(column)?, pink: count(column + 1)? });
        let share = |column: usize| match cell(column)? {
            "" => Some(None),
            number => number.parse::<f64>().ok().map(Some),
        };
        let outcome: MatchOutcome = serde_json::from_value(cell(0)?.into()).ok()?;
        Some(MatchRow {
            index,
            variant,
            seed: record.get(1)?.parse().ok()?,
            outcome,
            duration_s: cell(1)?.parse().ok()?,
            goals: counts(2)?,
            own_goals: counts(4)?,
            kicks: counts(6)?,
            penalties: counts(8)?,
            outs: count(10)?,
            blue_possession: share(11)?,
            ball_in_blue_half: share(12)?,
            messages_lost: share(13)?,
            belief_error_m: PerTeam { blue: share(14)?, pink: share(15)? },
            note: cell(16)?.to_owned(),
        })
    }

    fn foreign(&self, path: &Path, line: usize, message: &str) -> TableError {
        let expected = "the table of an earlier batch with the same scenario, settings and first seed".to_owned();
        TableError::Foreign { path: path.to_owned(), line, message: message.to_owned(), expected }
    }
}

/// Cells as a line, quoted where need be.
fn line_of<'a>(cells: impl Iterator<Item = &'a str>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Into memory, nothing can fail.
    let written = writer.write_record(cells).is_ok();
    let bytes = writer.into_inner().unwrap_or_default();
    if written { String::from_utf8(bytes).unwrap_or_default() } else { String::new() }
}

/// What tells one scenario from another, whatever the seed: the FNV-1a hash of its fields.
fn fingerprint(scenario: &Scenario) -> String {
    let scenario = Scenario { seed: 0, ..scenario.clone() };
    let text = scenario.resolved_json().unwrap_or_default();
    let hash = text
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    format!("{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn batch() -> Batch {
        Batch { variants: vec![Scenario::default(), Scenario::default()], matches: 3, first_seed: 7, threads: 1 }
    }

    fn columns() -> VariantColumns {
        let values = [["0", "a"], ["0.5", "b, c"]].map(|values| values.map(str::to_owned).to_vec()).to_vec();
        VariantColumns { names: vec!["messages.loss".to_owned(), "name".to_owned()], values }
    }

    fn row(index: usize) -> MatchRow {
        let (variant, seed) = batch().job(index);
        MatchRow {
            index,
            variant,
            goals: PerTeam { blue: index as u32, pink: 2 },
            blue_possession: Some(0.25),
            ..MatchRow::failed(seed, MatchOutcome::Panicked, "said \"no\",\nand left".to_owned())
        }
    }

    #[test]
    fn a_table_goes_on_where_it_was_cut_off() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let (mut table, rows) = Table::open(&path, &batch(), columns()).unwrap();
        assert!(rows.is_empty());
        for index in 0..3 {
            table.write(&row(index)).unwrap();
        }
        drop(table);
        let whole = std::fs::read_to_string(&path).unwrap();
        assert_eq!(whole.lines().count(), 4, "{whole}");
        // Killed in the middle of the third row.
        std::fs::write(&path, &whole[..whole.len() - 20]).unwrap();
        let (mut table, rows) = Table::open(&path, &batch(), columns()).unwrap();
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[1].goals, row(1).goals);
        assert_eq!(rows[1].blue_possession, Some(0.25));
        table.write(&row(2)).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), whole);
    }

    #[test]
    fn a_table_that_was_cut_off_in_the_middle_of_a_letter_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let accented = |index| MatchRow { note: "tombé".to_owned(), ..row(index) };
        let mut table = Table::open(&path, &batch(), columns()).unwrap().0;
        table.write(&accented(0)).unwrap();
        table.write(&accented(1)).unwrap();
        drop(table);
        let whole = std::fs::read(&path).unwrap();
        let cut = whole.iter().rposition(|byte| *byte == "é".as_bytes()[1]).unwrap();
        std::fs::write(&path, &whole[..cut]).unwrap();
        let (mut table, rows) = Table::open(&path, &batch(), columns()).unwrap();
        assert_eq!(rows, [accented(0)]);
        table.write(&accented(1)).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), whole);
    }

    #[test]
    fn two_batches_do_not_write_one_table_and_none_writes_to_a_device() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let first = Table::open(&path, &batch(), columns()).unwrap();
        assert!(matches!(Table::open(&path, &batch(), columns()), Err(TableError::InUse { .. })));
        drop(first);
        assert!(Table::open(&path, &batch(), columns()).is_ok());
        assert!(matches!(Table::open(folder.path(), &batch(), columns()), Err(TableError::NotAFile { .. })));
    }

    #[test]
    fn another_batchs_table_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let (mut table, _) = Table::open(&path, &batch(), columns()).unwrap();
        table.write(&row(0)).unwrap();
        drop(table);
        let whole = std::fs::read_to_string(&path).unwrap();
        let renamed = |name: &str| Scenario { name: name.to_owned(), ..Scenario::default() };
        let fewer_columns = VariantColumns { names: columns().names[..1].to_vec(), ..columns() };
        for (other, columns, line) in [
            (Batch { first_seed: 8, ..batch() }, columns(), 2),
            (Batch { variants: vec![renamed("another"), Scenario::default()], ..batch() }, columns(), 2),
            (batch(), fewer_columns, 1),
        ] {
            let error = Table::open(&path, &other, columns).err().unwrap().to_string();
            assert!(error.contains(&format!("table.csv:{line}: ")), "{error}");
        }
        std::fs::write(&path, "my diary").unwrap();
        assert!(Table::open(&path, &batch(), columns()).is_err());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "my diary");
        std::fs::write(&path, whole).unwrap();
        assert!(Table::open(&path, &Batch { matches: 5, threads: 2, ..batch() }, columns()).is_ok());
    }
}
