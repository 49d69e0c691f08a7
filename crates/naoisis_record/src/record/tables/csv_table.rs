//! Tables as CSV.

use std::fs::File;
use std::io;

use super::Table;
use super::column::{Cells, ColumnValues};

/// A CSV file that is being written.
pub(super) struct CsvTable(csv::Writer<File>);

impl CsvTable {
    pub(super) fn create(file: File, table: &Table) -> io::Result<Self> {
        let mut writer = csv::Writer::from_writer(file);
        writer.write_record(table.definition().columns.iter().map(|column| column.name))?;
        Ok(Self(writer))
    }

    pub(super) fn write(&mut self, table: &Table) -> io::Result<()> {
        let mut columns: Vec<Texts<'_>> = table.columns().iter().map(Texts::new).collect();
        for row in 0..table.rows() {
            for column in &mut columns {
                self.0.write_field(column.next(row))?;
            }
            self.0.write_record(None::<&[u8]>)?;
        }
        self.0.flush()
    }
}

/// Iterates over the values of a column as texts, row by row. Missing values are empty.
struct Texts<'a> {
    column: &'a ColumnValues,
    /// The index of the next present value.
    next: usize,
}

impl<'a> Texts<'a> {
    fn new(column: &'a ColumnValues) -> Self {
        Self { column, next: 0 }
    }

    fn next(&mut self, row: usize) -> String {
        if self.column.presence.get(row) != Some(&1) {
            return String::new();
        }
        let index = self.next;
        self.next += 1;
        match &self.column.cells {
            Cells::Whole(cells) => cells[index].to_string(),
            Cells::Single(cells) => cells[index].to_string(),
            Cells::Double(cells) => cells[index].to_string(),
            Cells::Text(cells) => cells[index].clone(),
        }
    }
}
