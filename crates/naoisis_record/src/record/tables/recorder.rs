//! Writes the tables of a match as files in a folder.

use bevy::prelude::World;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use super::csv_table::CsvTable;
use super::parquet_table::ParquetTable;
use super::{TABLES, Table, Tables};
use crate::record::error::RecordError;
use crate::record::recorder::{MatchEnd, Recorder};
use naoisis_core::replace_file::UnfinishedFile;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::scenario::Scenario;

/// Number of rows of a table that are kept in memory at most.
const ROWS: usize = 50_000;

/// A format of tables.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TableFormat {
    /// Comma-separated values with a header line.
    Csv,
    /// Parquet, compressed with Zstandard.
    Parquet,
}

impl TableFormat {
    /// Returns the ending of the format's files.
    pub fn extension(self) -> &'static str {
        match self {
            TableFormat::Csv => "csv",
            TableFormat::Parquet => "parquet",
        }
    }

    /// Returns the files of all tables in `folder`.
    pub fn files(self, folder: &Path) -> impl Iterator<Item = PathBuf> {
        TABLES.iter().map(move |table| folder.join(table.name).with_extension(self.extension()))
    }
}

/// Writes the tables of a match into a folder. The files get their final names when all of them are complete.
pub struct TablesRecorder {
    folder: PathBuf,
    format: TableFormat,
    tables: Tables,
    files: Vec<TableFile>,
    error: Option<RecordError>,
}

/// The file of a table that is being written.
struct TableFile {
    path: PathBuf,
    unfinished: UnfinishedFile,
    writer: Writer,
}

enum Writer {
    Csv(CsvTable),
    Parquet(ParquetTable),
}

impl TablesRecorder {
    /// Creates tables in `folder`, which is created if it is missing. Only values of the given `fields` are recorded.
    ///
    /// # Errors
    /// If the folder cannot be created.
    pub fn create(folder: &Path, format: TableFormat, fields: Fields) -> Result<Self, RecordError> {
        match fs::create_dir(folder) {
            Err(_) if folder.exists() && !folder.is_dir() => return Err(RecordError::NotAFolder(folder.to_owned())),
            Err(error) if !folder.is_dir() => return Err(RecordError::io(folder)(error)),
            _ => {}
        }
        let tables = Tables::new(fields);
        Ok(Self { folder: folder.to_owned(), format, tables, files: Vec::new(), error: None })
    }

    fn open(&mut self, scenario: &Scenario) -> Result<(), RecordError> {
        let scenario = serde_json::to_string(scenario).unwrap_or_default();
        for (path, table) in self.format.files(&self.folder).zip(&self.tables.tables) {
            let file = TableFile::create(&path, self.format, table, &scenario).map_err(RecordError::io(&path))?;
            self.files.push(file);
        }
        Ok(())
    }

    /// Writes the rows of tables that have `least` rows or more.
    fn write(&mut self, least: usize) -> Result<(), RecordError> {
        for (file, table) in self.files.iter_mut().zip(&mut self.tables.tables) {
            if table.rows() >= least {
                file.write(table).map_err(RecordError::io(&file.path))?;
                table.clear();
            }
        }
        Ok(())
    }

    fn add(&mut self, record: &CycleRecord) {
        if self.error.is_none() {
            self.tables.push(record);
            self.error = self.write(ROWS).err();
        }
    }

    fn close(mut self) -> Result<u64, RecordError> {
        if let Some(error) = self.error.take() {
            return Err(error);
        }
        self.write(1)?;
        let mut closed = Vec::new();
        for TableFile { path, unfinished, writer } in self.files {
            writer.close().map_err(RecordError::io(&path))?;
            closed.push((path, unfinished));
        }
        let mut bytes = 0;
        for (path, mut unfinished) in closed {
            bytes += unfinished.file().metadata().map_or(0, |there| there.len());
            unfinished.finish().map_err(RecordError::io(&path))?;
        }
        Ok(bytes)
    }
}

impl Recorder for TablesRecorder {
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, _: &mut World) {
        self.error = self.open(scenario).err();
        self.add(record);
    }

    fn record(&mut self, record: &CycleRecord, _: &mut World) {
        self.add(record);
    }

    fn has_failed(&self) -> bool {
        self.error.is_some()
    }

    fn finish(self: Box<Self>, _: &MatchEnd, _: &CycleRecord) -> Result<Option<String>, RecordError> {
        let folder = self.folder.display().to_string();
        let names = TABLES.map(|table| table.name).join(", ");
        let extension = self.format.extension();
        let bytes = self.close()?;
        Ok(Some(format!("  tables {folder}/*.{extension}, {:.1} MB: {names}\n", bytes as f64 / 1e6)))
    }
}

impl TableFile {
    fn create(path: &Path, format: TableFormat, table: &Table, scenario: &str) -> io::Result<Self> {
        let unfinished = UnfinishedFile::whole(path)?;
        let file: File = unfinished.file().try_clone()?;
        let writer = match format {
            TableFormat::Csv => Writer::Csv(CsvTable::create(file, table)?),
            TableFormat::Parquet => Writer::Parquet(ParquetTable::create(file, table, scenario)?),
        };
        Ok(Self { path: path.to_owned(), unfinished, writer })
    }

    fn write(&mut self, table: &Table) -> io::Result<()> {
        match &mut self.writer {
            Writer::Csv(writer) => writer.write(table),
            Writer::Parquet(writer) => writer.write(table),
        }
    }
}

impl Writer {
    fn close(self) -> io::Result<()> {
        match self {
            Writer::Csv(_) => Ok(()),
            Writer::Parquet(writer) => writer.close(),
        }
    }
}
