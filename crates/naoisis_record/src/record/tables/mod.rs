//! Writes a match as tables: one row for each cycle, robot, percept, belief, event or message, with documented columns.
//!
//! The tables are CSV or Parquet files in a folder, such as `robots.parquet`. [`TABLES`] defines their columns.
//!
//! ```
//! use naoisis::record::tables::{TABLES, Tables};
//! use naoisis::interface::fields::Fields;
//!
//! let tables = Tables::new(Fields::default());
//! assert_eq!(tables.of("robots").map(|table| table.rows()), Some(0));
//! assert_eq!(TABLES[1].columns[2].name, "robot");
//! ```

mod column;
mod csv_table;
mod parquet_table;
mod recorder;
mod rows;
mod rows_of_record;
#[cfg(test)]
mod tests;

pub use column::{Cells, Column, ColumnKind, ColumnValues};
pub use recorder::{TableFormat, TablesRecorder};

use column::TableRow;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::interface::fields::Fields;
use rows::{BeliefRow, CycleRow, EventRow, MessageRow, PerceptRow, RobotRow};

/// The definition of a table.
#[derive(Debug)]
pub struct TableDefinition {
    /// Name of the table, and of its file without the ending.
    pub name: &'static str,
    /// Meaning of a row.
    pub description: &'static str,
    /// The columns of the table.
    pub columns: &'static [Column],
}

const fn definition<R: TableRow>(name: &'static str) -> TableDefinition {
    TableDefinition { name, description: R::DESCRIPTION, columns: R::COLUMNS }
}

/// The definitions of all tables.
pub const TABLES: [TableDefinition; 6] = [
    definition::<CycleRow>("cycles"),
    definition::<RobotRow>("robots"),
    definition::<PerceptRow>("percepts"),
    definition::<BeliefRow>("beliefs"),
    definition::<EventRow>("events"),
    definition::<MessageRow>("messages"),
];

/// A table with the rows that were collected.
#[derive(Debug)]
pub struct Table {
    definition: &'static TableDefinition,
    columns: Vec<ColumnValues>,
}

impl Table {
    fn new(definition: &'static TableDefinition) -> Self {
        Self { definition, columns: definition.columns.iter().map(ColumnValues::new).collect() }
    }

    /// Returns the definition of the table.
    pub fn definition(&self) -> &'static TableDefinition {
        self.definition
    }

    /// Returns the values of the columns, in the order of the definition.
    pub fn columns(&self) -> &[ColumnValues] {
        &self.columns
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, ColumnValues::len)
    }

    fn extend<R: TableRow>(&mut self, rows: impl IntoIterator<Item = R>) {
        rows.into_iter().for_each(|row| row.push_to(&mut self.columns));
    }

    fn clear(&mut self) {
        self.columns.iter_mut().for_each(ColumnValues::clear);
    }
}

/// All tables, with the rows that were collected.
#[derive(Debug)]
pub struct Tables {
    fields: Fields,
    tables: [Table; TABLES.len()],
}

impl Tables {
    /// Creates empty tables for records that have these fields. Values of other fields are missing.
    pub fn new(fields: Fields) -> Self {
        static DEFINITIONS: [TableDefinition; TABLES.len()] = TABLES;
        Self { fields, tables: core::array::from_fn(|index| Table::new(&DEFINITIONS[index])) }
    }

    /// Returns the table with this name.
    pub fn of(&self, name: &str) -> Option<&Table> {
        self.tables.iter().find(|table| table.definition.name == name)
    }

    /// Adds the rows of a cycle.
    pub fn push(&mut self, record: &CycleRecord) {
        let Self { fields, tables: [cycles, robots, percepts, beliefs, events, messages] } = self;
        cycles.extend([CycleRow::new(record, fields)]);
        robots.extend(record.robots.iter().map(|robot| RobotRow::new(record, robot, fields)));
        for robot in &record.robots {
            percepts.extend(PerceptRow::all(record, robot));
            beliefs.extend(BeliefRow::all(record, robot, fields));
            messages.extend(MessageRow::all(record, robot));
        }
        events.extend(record.events.iter().map(|event| EventRow::new(record, event)));
    }
}
