//! Lines of comma-separated values, and their cells.

use serde::Serialize;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};

/// A longer line is of no table.
const LONGEST_LINE_BYTES: u64 = 16 << 20;

/// A line of a file.
pub(super) enum Line {
    /// With its end.
    Whole(String),
    /// The last one, which was cut off; nothing at the end of the file.
    Part(String),
}

/// The lines of a file, one after the other.
pub(super) struct Lines<'a> {
    pub(super) reader: BufReader<&'a File>,
    /// Bytes of the lines that were whole.
    pub(super) read_bytes: u64,
}

impl Lines<'_> {
    /// The next line.
    pub(super) fn next_whole(&mut self) -> io::Result<Line> {
        let mut bytes = Vec::new();
        (&mut self.reader).take(LONGEST_LINE_BYTES).read_until(b'\n', &mut bytes)?;
        if bytes.len() as u64 == LONGEST_LINE_BYTES {
            return Err(io::Error::other(format!("a line has more than {} MiB", LONGEST_LINE_BYTES >> 20)));
        }
        // Cut off in the middle of a letter, it is still a table.
        let text = String::from_utf8_lossy(&bytes).into_owned();
        if bytes.last() == Some(&b'\n') {
            self.read_bytes += bytes.len() as u64;
            return Ok(Line::Whole(text));
        }
        Ok(Line::Part(text))
    }
}

/// Cells as a line, quoted where need be.
pub(super) fn line_of<'a>(cells: impl Iterator<Item = &'a str>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Into memory, nothing can fail.
    let written = writer.write_record(cells).is_ok();
    let bytes = writer.into_inner().unwrap_or_default();
    if written { String::from_utf8(bytes).unwrap_or_default() } else { String::new() }
}

/// The cells of a serialisable row, field by field.
pub(super) fn cells_of_row(row: &impl Serialize) -> Vec<String> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    // Into memory, nothing can fail.
    let _written = writer.serialize(row);
    cells_of(&String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default())
}

/// The cells of a line.
pub(super) fn cells_of(line: &str) -> Vec<String> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(line.as_bytes());
    let record = reader.records().next().and_then(Result::ok).unwrap_or_default();
    record.iter().map(str::to_owned).collect()
}

/// A cell that no spreadsheet takes for a formula.
pub(super) fn as_text(cell: String) -> String {
    let is_formula = cell.starts_with(['=', '+', '-', '@', '\t']) && cell.parse::<f64>().is_err();
    if is_formula { format!("'{cell}") } else { cell }
}
