//! Lines of comma-separated values, and their cells.

use serde::Serialize;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};

/// Length limit of a line, bytes: no line of a table is longer.
const LONGEST_LINE_BYTES: u64 = 16 << 20;

/// A line of a file.
pub(super) enum Line {
    /// A complete line, with its line end.
    Whole(String),
    /// The last line, cut off; empty at the end of the file.
    Part(String),
}

/// Reads a file line by line.
pub(super) struct Lines<'a> {
    pub(super) reader: BufReader<&'a File>,
    /// Length of the complete lines read so far, bytes.
    pub(super) read_bytes: u64,
}

impl Lines<'_> {
    /// Reads the next line.
    pub(super) fn next_whole(&mut self) -> io::Result<Line> {
        let mut bytes = Vec::new();
        (&mut self.reader).take(LONGEST_LINE_BYTES).read_until(b'\n', &mut bytes)?;
        if bytes.len() as u64 == LONGEST_LINE_BYTES {
            return Err(io::Error::other(format!("a line has more than {} MiB", LONGEST_LINE_BYTES >> 20)));
        }
        // A line that was cut off in the middle of a character is text all the same.
        let text = String::from_utf8_lossy(&bytes).into_owned();
        if bytes.last() == Some(&b'\n') {
            self.read_bytes += bytes.len() as u64;
            return Ok(Line::Whole(text));
        }
        Ok(Line::Part(text))
    }
}

/// Joins cells to a line, with quotes where necessary.
pub(super) fn line_of<'a>(cells: impl Iterator<Item = &'a str>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Writing to memory cannot fail.
    let written = writer.write_record(cells).is_ok();
    let bytes = writer.into_inner().unwrap_or_default();
    if written { String::from_utf8(bytes).unwrap_or_default() } else { String::new() }
}

/// Returns the cells of a serialisable row, one for each field.
pub(super) fn cells_of_row(row: &impl Serialize) -> Vec<String> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    // Writing to memory cannot fail.
    let _written = writer.serialize(row);
    cells_of(&String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default())
}

/// Splits a line into its cells.
pub(super) fn cells_of(line: &str) -> Vec<String> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(line.as_bytes());
    let record = reader.records().next().and_then(Result::ok).unwrap_or_default();
    record.iter().map(str::to_owned).collect()
}

/// Returns the cell, with an apostrophe in front if a spreadsheet would take it for a formula.
pub(super) fn as_text(cell: String) -> String {
    let is_formula = cell.starts_with(['=', '+', '-', '@', '\t']) && cell.parse::<f64>().is_err();
    if is_formula { format!("'{cell}") } else { cell }
}
