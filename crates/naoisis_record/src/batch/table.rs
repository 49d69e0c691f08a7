//! The table of a batch: comma-separated values, one row for each match, in the order of the matches.
//!
//! The columns are the number of the match, its seed, the settings of its variant, its [`MatchRow`], its realism, and a fingerprint of
//! the scenario, by which a later batch knows its own table and continues it. A setting with the name of another column, such as
//! `realism` and `duration_s`, has `set.` before its name.
//!
//! A text that a spreadsheet would take for a formula has a leading apostrophe.

use core::ops::Range;
use std::fs::File;
use std::io::{BufReader, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::columns::{Columns, NO_TABLE, cells};
use super::csv_lines::{Line, Lines, line_of};
use super::observer::MatchRow;
pub use super::table_file::TableError;
use super::table_file::TableFile;
use super::{Batch, Variants};

/// The table of a batch, as a file or in memory only.
pub struct Table(Option<(PathBuf, File)>);

impl Table {
    /// Creates a table that is not written to a file.
    pub fn unwritten() -> Self {
        Self(None)
    }

    /// Opens the table of this batch in a file. Returns it with the rows that the file has already, none if it is new. An incomplete last
    /// line is cut off.
    ///
    /// # Errors
    /// If the file cannot be written or has another table.
    pub fn open<V: Variants>(path: &Path, batch: &Batch<V>) -> Result<(Table, Vec<MatchRow>), TableError> {
        Self::open_part(path, batch, 0..batch.len())
    }

    /// Does the same as [`Table::open`] for the matches of a batch with these indices.
    ///
    /// # Errors
    /// If the file cannot be written or has another table.
    pub fn open_part<V: Variants>(
        path: &Path,
        batch: &Batch<V>,
        indices: Range<usize>,
    ) -> Result<(Table, Vec<MatchRow>), TableError> {
        let io_error = |error| TableError::Io { path: path.to_owned(), error };
        let mut opened = TableFile::open(path)?;
        let columns = Columns::of(batch);
        let header = columns.header();
        let mut lines = Lines { reader: BufReader::new(&opened.file), read_bytes: 0 };
        let mut rows = Vec::new();
        match lines.next_whole().map_err(io_error)? {
            Line::Whole(first) if first == header => {
                while let Line::Whole(line) = lines.next_whole().map_err(io_error)? {
                    let number = rows.len() + 2;
                    let index = indices.start + rows.len();
                    if index >= indices.end {
                        let message = format!("the table has more matches than the {} of this batch", indices.len());
                        return Err(TableError::foreign(path, number, message));
                    }
                    let row = columns.read_row(batch, index, &line);
                    rows.push(row.map_err(|difference| TableError::foreign(path, number, difference))?);
                }
                let whole_bytes = lines.read_bytes;
                let cut = opened.file.set_len(whole_bytes).and_then(|()| opened.file.seek(SeekFrom::End(0)));
                cut.map_err(io_error)?;
            }
            Line::Whole(first) => return Err(TableError::foreign(path, 1, columns.difference(&first))),
            Line::Part(part) if header.starts_with(&part) => {
                let cut = opened.file.set_len(0).and_then(|()| opened.file.seek(SeekFrom::Start(0)));
                cut.map_err(io_error)?;
                opened.write_header(&header)?;
            }
            Line::Part(_) => return Err(TableError::foreign(path, 1, NO_TABLE.to_owned())),
        }
        Ok((Table(Some((path.to_owned(), opened.file))), rows))
    }

    /// Removes all rows after the first `rows`.
    ///
    /// # Errors
    /// When the file cannot be read or written.
    pub fn cut(&mut self, rows: usize) -> Result<(), TableError> {
        let Some((path, file)) = &mut self.0 else { return Ok(()) };
        let mut cut = || {
            file.seek(SeekFrom::Start(0))?;
            let mut lines = Lines { reader: BufReader::new(&*file), read_bytes: 0 };
            for _ in 0..=rows {
                lines.next_whole()?;
            }
            let whole_bytes = lines.read_bytes;
            file.set_len(whole_bytes)?;
            file.seek(SeekFrom::End(0))
        };
        cut().map(drop).map_err(|error| TableError::Io { path: path.clone(), error })
    }

    /// Writes a row of this batch.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write<V: Variants>(&mut self, batch: &Batch<V>, row: &MatchRow) -> Result<(), TableError> {
        if let Some((path, file)) = &mut self.0 {
            let line = line_of(cells(batch, row).iter().map(String::as_str));
            file.write_all(line.as_bytes()).map_err(|error| TableError::NotWritten { path: path.clone(), error })?;
        }
        Ok(())
    }
}

/// Returns the rows of a batch as the text of a table file.
pub fn table_text<'a, V: Variants>(batch: &Batch<V>, rows: impl IntoIterator<Item = &'a MatchRow>) -> String {
    let header = Columns::of(batch).header();
    let lines = rows.into_iter().map(|row| line_of(cells(batch, row).iter().map(String::as_str)));
    core::iter::once(header).chain(lines).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::MatchOutcome;
    use crate::batch::csv_lines::{as_text, cells_of};
    use naoisis_core::team::PerTeam;
    use naoisis_sim::scenario::{Scenario, ScenarioError};
    use std::fs;

    /// Two variants. Spreadsheets would take the values of the second for formulas.
    #[derive(Clone, Debug)]
    struct TwoVariants {
        columns: Vec<&'static str>,
        scenarios: Vec<Scenario>,
    }

    impl Variants for TwoVariants {
        fn count(&self) -> usize {
            2
        }

        fn scenario(&self, index: usize) -> Result<Scenario, ScenarioError> {
            self.scenarios.scenario(index)
        }

        fn columns(&self) -> Vec<String> {
            self.columns.iter().map(|column| (*column).to_owned()).collect()
        }

        fn values(&self, index: usize) -> Vec<String> {
            let values = [["0", "a"], ["-0.5", "=b, c"]][index];
            values.map(str::to_owned)[..self.columns.len()].to_vec()
        }
    }

    fn batch() -> Batch<TwoVariants> {
        let scenarios = vec![Scenario::default(), Scenario::default()];
        let variants = TwoVariants { columns: vec!["messages.loss", "name"], scenarios };
        Batch { variants, matches: 3, first_seed: 7, threads: 1 }
    }

    #[test]
    fn settings_that_are_called_like_other_columns_are_told_apart() {
        let mut batch = batch();
        batch.variants.columns = vec!["realism", "duration_s"];
        let header = cells_of(&table_text(&batch, []));
        assert_eq!(header[2..4], ["set.realism", "set.duration_s"]);
        let different: std::collections::BTreeSet<_> = header.iter().collect();
        assert_eq!(different.len(), header.len());
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
    fn texts_are_no_formulas_and_numbers_stay_numbers() {
        for (cell, written) in [
            ("=1+1", "'=1+1"),
            ("-x", "'-x"),
            ("@x", "'@x"),
            ("+x", "'+x"),
            ("-0.5", "-0.5"),
            ("+2", "+2"),
            ("a=b", "a=b"),
        ] {
            assert_eq!(as_text(cell.to_owned()), written);
        }
        let line = line_of(
            cells(&batch(), &MatchRow { note: "=HYPERLINK(1)".to_owned(), ..row(1) }).iter().map(String::as_str),
        );
        assert!(line.contains(",-0.5,\"'=b, c\",") && line.contains(",'=HYPERLINK(1),"), "{line}");
    }

    #[test]
    fn a_table_goes_on_where_it_was_cut_off() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let (mut table, rows) = Table::open(&path, &batch()).unwrap();
        assert!(rows.is_empty());
        for index in 0..3 {
            table.write(&batch(), &row(index)).unwrap();
        }
        drop(table);
        let whole = fs::read_to_string(&path).unwrap();
        assert_eq!(whole.lines().count(), 4, "{whole}");
        // The program was killed in the middle of the third row.
        fs::write(&path, &whole[..whole.len() - 20]).unwrap();
        let (mut table, rows) = Table::open(&path, &batch()).unwrap();
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[1].goals, row(1).goals);
        assert_eq!(rows[1].blue_possession, Some(0.25));
        table.write(&batch(), &row(2)).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), whole);
        for rows in [2, 1, 0] {
            table.cut(rows).unwrap();
            (rows..3).for_each(|index| table.write(&batch(), &row(index)).unwrap());
            assert_eq!(fs::read_to_string(&path).unwrap(), whole);
        }
    }

    #[test]
    fn a_table_that_was_cut_off_in_the_middle_of_a_letter_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let accented = |index| MatchRow { note: "tombé".to_owned(), ..row(index) };
        let mut table = Table::open(&path, &batch()).unwrap().0;
        table.write(&batch(), &accented(0)).unwrap();
        table.write(&batch(), &accented(1)).unwrap();
        drop(table);
        let whole = fs::read(&path).unwrap();
        let cut = whole.iter().rposition(|byte| *byte == "é".as_bytes()[1]).unwrap();
        fs::write(&path, &whole[..cut]).unwrap();
        let (mut table, rows) = Table::open(&path, &batch()).unwrap();
        assert_eq!(rows, [accented(0)]);
        table.write(&batch(), &accented(1)).unwrap();
        assert_eq!(fs::read(&path).unwrap(), whole);
    }

    #[test]
    fn two_batches_do_not_write_one_table_and_none_writes_to_a_device() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let first = Table::open(&path, &batch()).unwrap();
        assert!(matches!(Table::open(&path, &batch()), Err(TableError::InUse { .. })));
        drop(first);
        assert!(Table::open(&path, &batch()).is_ok());
        assert!(matches!(Table::open(folder.path(), &batch()), Err(TableError::NotAFile { .. })));
    }

    #[test]
    fn another_batchs_table_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let (mut table, _) = Table::open(&path, &batch()).unwrap();
        table.write(&batch(), &row(0)).unwrap();
        drop(table);
        let whole = fs::read_to_string(&path).unwrap();
        let with = |change: fn(&mut TwoVariants)| {
            let mut other = batch();
            change(&mut other.variants);
            other
        };
        for (other, words) in [
            (Batch { first_seed: 8, ..batch() }, "2: `seed` is 7, and 8 in this batch"),
            (Batch { matches: 0, ..batch() }, "2: the table has more matches than the 0 of this batch"),
            (
                with(|other| other.scenarios[0].name = "another".to_owned()),
                "2: the scenario, `--duration` or a `--set`",
            ),
            (
                with(|other| other.scenarios[0].duration_s = Some(20.0)),
                "2: the duration is not given, and 20 s in this batch",
            ),
            (with(|other| other.columns.truncate(1)), "1: the table has `name`, which this batch has not"),
            (with(|other| other.columns[0] = "rules"), "1: the table has `messages.loss` where this batch has `rules`"),
            (with(|other| other.columns[1] = "rules"), "1: the table has `name` where this batch has `rules`"),
            (with(|other| other.columns.swap(0, 1)), "1: the columns are in another order"),
        ] {
            let error = Table::open(&path, &other).err().unwrap().to_string();
            assert!(error.contains(&format!("table.csv:{words}")), "{error}");
        }
        fs::write(&path, whole.replace(",0,a,", ",0.5,a,")).unwrap();
        let error = Table::open(&path, &batch()).err().unwrap().to_string();
        assert!(
            error.contains("table.csv:2: `messages.loss` is 0.5, and 0 in this batch; expected the table"),
            "{error}"
        );
        for text in [format!("\u{feff}{whole}"), whole.replace('\n', "\r\n")] {
            fs::write(&path, text).unwrap();
            let error = Table::open(&path, &batch()).err().unwrap().to_string();
            assert!(error.contains("table.csv:1: another program saved the table"), "{error}");
        }
        fs::write(&path, "my diary").unwrap();
        assert!(Table::open(&path, &batch()).is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "my diary");
        fs::write(&path, whole).unwrap();
        assert!(Table::open(&path, &Batch { matches: 5, threads: 2, ..batch() }).is_ok());
    }
}
