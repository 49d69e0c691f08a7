//! Merges the tables of the parts of a batch that were played on several machines.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use super::columns::Columns;
use super::csv_lines::{Line, Lines, cells_of};
use super::observer::MatchRow;
use super::table::TableError;
use super::{Batch, Variants};

/// Number of gaps that an error lists at most.
const MOST_GAPS: usize = 5;

/// Why tables do not make up a batch.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// A table cannot be read, or belongs to another batch.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A match is in two tables.
    #[error("match {number} is in {first} and in {second}; expected it in one of them")]
    Twice {
        /// Number of the match, from 1.
        number: usize,
        /// Table that has the match first.
        first: PathBuf,
        /// The other table that has the match.
        second: PathBuf,
    },
    /// Some matches are in none of the tables.
    #[error("of {all} matches {missing} are in none of the tables: {gaps}; expected all of them")]
    Missing {
        /// Number of matches of the batch.
        all: usize,
        /// Number of missing matches.
        missing: usize,
        /// The missing matches, in words.
        gaps: String,
    },
}

naoisis_core::debug_as_displayed!(MergeError);

/// Returns the rows of a batch, in the order of its matches, from the tables of its parts in any order. A last line that is cut off
/// is ignored.
///
/// # Errors
/// If a table belongs to another batch, or if a match is in two tables or in none.
pub fn merge<V: Variants>(batch: &Batch<V>, paths: &[PathBuf]) -> Result<Vec<MatchRow>, MergeError> {
    let mut rows: BTreeMap<usize, (MatchRow, &Path)> = BTreeMap::new();
    for path in paths {
        for row in rows_of(batch, path)? {
            let number = row.index + 1;
            if let Some((_, first)) = rows.insert(row.index, (row, path)) {
                return Err(MergeError::Twice { number, first: first.to_owned(), second: path.clone() });
            }
        }
    }
    if rows.len() == batch.len() {
        return Ok(rows.into_values().map(|(row, _)| row).collect());
    }
    let gaps = gaps(rows.keys().copied(), batch.len());
    let mut words: Vec<String> = gaps
        .iter()
        .take(MOST_GAPS)
        .map(|&(first, last)| if first == last { format!("{first}") } else { format!("{first} to {last}") })
        .collect();
    if gaps.len() > MOST_GAPS {
        words.push("and others".to_owned());
    }
    let missing = batch.len() - rows.len();
    Err(MergeError::Missing { all: batch.len(), missing, gaps: words.join(", ") })
}

/// Returns the rows of one table, whichever part of the batch it has.
fn rows_of<V: Variants>(batch: &Batch<V>, path: &Path) -> Result<Vec<MatchRow>, TableError> {
    let io_error = |error| TableError::Io { path: path.to_owned(), error };
    let file = File::open(path).map_err(io_error)?;
    if !file.metadata().map_err(io_error)?.is_file() {
        return Err(TableError::NotAFile { path: path.to_owned() });
    }
    let columns = Columns::of(batch);
    let mut lines = Lines { reader: BufReader::new(&file), read_bytes: 0 };
    match lines.next_whole().map_err(io_error)? {
        Line::Whole(first) if first == columns.header() => {}
        Line::Whole(first) | Line::Part(first) => {
            return Err(TableError::foreign(path, 1, columns.difference(&first)));
        }
    }
    let mut rows = Vec::new();
    while let Line::Whole(line) = lines.next_whole().map_err(io_error)? {
        let number: Option<usize> = cells_of(&line).first().and_then(|cell| cell.parse().ok());
        let row = match number.and_then(|number| number.checked_sub(1)) {
            Some(index) => columns.read_row(batch, index, &line),
            None => Err("this is no row of the table".to_owned()),
        };
        rows.push(row.map_err(|difference| TableError::foreign(path, rows.len() + 2, difference))?);
    }
    Ok(rows)
}

/// Returns the first and the last number, from 1 to `count`, of each gap between the sorted indices (from 0) in `there`.
fn gaps(there: impl Iterator<Item = usize>, count: usize) -> Vec<(usize, usize)> {
    let mut gaps = Vec::new();
    let mut expected = 0;
    for index in there.chain([count]) {
        if index > expected {
            gaps.push((expected + 1, index));
        }
        expected = index + 1;
    }
    gaps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::observer::MatchOutcome;
    use crate::batch::table::table_text;
    use naoisis_sim::scenario::Scenario;
    use std::fs;

    fn batch() -> Batch {
        Batch { variants: vec![Scenario::default()], matches: 7, first_seed: 3, threads: 1 }
    }

    fn row(index: usize) -> MatchRow {
        let (variant, seed) = batch().job(index);
        MatchRow { index, variant, ..MatchRow::failed(seed, MatchOutcome::Duration, String::new()) }
    }

    /// Writes a table with the matches of these indices, from 0.
    fn part(folder: &Path, name: &str, indices: &[usize]) -> PathBuf {
        let rows: Vec<MatchRow> = indices.iter().map(|index| row(*index)).collect();
        let path = folder.join(name);
        fs::write(&path, table_text(&batch(), &rows)).unwrap();
        path
    }

    #[test]
    fn parts_in_any_order_are_the_table_of_one_machine() {
        let folder = tempfile::tempdir().unwrap();
        let parts = [("a", &[4, 5, 6][..]), ("b", &[0, 1]), ("c", &[]), ("d", &[2, 3])]
            .map(|(name, indices)| part(folder.path(), name, indices));
        let whole: Vec<MatchRow> = (0..7).map(row).collect();
        assert_eq!(merge(&batch(), &parts).unwrap(), whole);
    }

    #[test]
    fn what_is_missing_is_named_and_what_does_not_belong_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let [low, high] = [("low", &[0, 1][..]), ("high", &[4, 6])].map(|(name, rows)| part(path, name, rows));
        let error = |parts: &[&PathBuf]| {
            let parts: Vec<PathBuf> = parts.iter().map(|part| (*part).clone()).collect();
            merge(&batch(), &parts).unwrap_err().to_string()
        };
        assert_eq!(error(&[&high, &low]), "of 7 matches 3 are in none of the tables: 3 to 4, 6; expected all of them");
        let again = part(path, "again", &[2, 1]);
        assert!(error(&[&low, &again]).starts_with("match 2 is in "));
        let foreign = path.join("foreign");
        fs::write(&foreign, fs::read_to_string(&low).unwrap().replace(",4,", ",5,")).unwrap();
        assert!(error(&[&foreign]).contains("foreign:3: `seed` is 5, and 4 in this batch"));
        fs::write(&foreign, "my diary\n").unwrap();
        assert!(error(&[&foreign]).contains("this is no table of matches"));
        let beyond = path.join("beyond");
        fs::write(&beyond, fs::read_to_string(&low).unwrap().replace("\n1,3,", "\n8,10,")).unwrap();
        assert!(error(&[&beyond]).contains("more matches than the 7"));
        assert!(error(&[&path.join("nowhere")]).contains("nowhere"));
        // The program was killed while it wrote the last line.
        let text = fs::read_to_string(&high).unwrap();
        fs::write(&high, &text[..text.len() - 5]).unwrap();
        assert!(error(&[&low, &high]).contains("4 are in none of the tables: 3 to 4, 6 to 7"));
    }
}
