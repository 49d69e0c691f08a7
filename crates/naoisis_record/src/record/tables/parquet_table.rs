//! Writes tables as Parquet, compressed with Zstandard.

use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FloatType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::fs::File;
use std::io;
use std::sync::Arc;

use super::column::{Cells, Column, ColumnKind};
use super::{Table, TableDefinition};

/// A Parquet file that is being written. It cannot be read before it is closed.
pub(super) struct ParquetTable(SerializedFileWriter<File>);

impl ParquetTable {
    /// Creates a file that has the `scenario` of the match, as JSON, in its metadata.
    pub(super) fn create(file: File, table: &Table, scenario: &str) -> io::Result<Self> {
        let properties = WriterProperties::builder()
            .set_created_by("naoisis".to_owned())
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            .set_key_value_metadata(Some(vec![KeyValue::new("naoisis.scenario".to_owned(), scenario.to_owned())]))
            .build();
        let schema = schema(table.definition()).map_err(other)?;
        SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties)).map(Self).map_err(other)
    }

    /// Writes all rows of the table as a row group.
    pub(super) fn write(&mut self, table: &Table) -> io::Result<()> {
        self.write_group(table).map_err(other)
    }

    fn write_group(&mut self, table: &Table) -> Result<(), ParquetError> {
        let mut group = self.0.next_row_group()?;
        for (definition, column) in table.definition().columns.iter().zip(table.columns()) {
            let Some(mut writer) = group.next_column()? else { break };
            let levels = definition.is_optional.then_some(column.presence.as_slice());
            match &column.cells {
                Cells::Whole(cells) => writer.typed::<Int64Type>().write_batch(cells, levels, None)?,
                Cells::Single(cells) => writer.typed::<FloatType>().write_batch(cells, levels, None)?,
                Cells::Double(cells) => writer.typed::<DoubleType>().write_batch(cells, levels, None)?,
                Cells::Text(cells) => {
                    let cells: Vec<ByteArray> = cells.iter().map(|cell| ByteArray::from(cell.as_str())).collect();
                    writer.typed::<ByteArrayType>().write_batch(&cells, levels, None)?
                }
            };
            writer.close()?;
        }
        group.close().map(drop)
    }

    pub(super) fn close(mut self) -> io::Result<()> {
        self.0.finish().map(drop).map_err(other)
    }
}

fn other(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(error) => match error.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(error) => io::Error::other(error),
        },
        error => io::Error::other(error),
    }
}

fn schema(definition: &TableDefinition) -> Result<Type, ParquetError> {
    let columns = definition.columns.iter().map(|column| field(column).map(Arc::new));
    Type::group_type_builder(definition.name).with_fields(columns.collect::<Result<_, _>>()?).build()
}

fn field(column: &Column) -> Result<Type, ParquetError> {
    let (physical, logical) = match column.kind {
        ColumnKind::Whole => (PhysicalType::INT64, None),
        ColumnKind::Single => (PhysicalType::FLOAT, None),
        ColumnKind::Double => (PhysicalType::DOUBLE, None),
        ColumnKind::Text => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
    };
    let repetition = if column.is_optional { Repetition::OPTIONAL } else { Repetition::REQUIRED };
    Type::primitive_type_builder(column.name, physical).with_logical_type(logical).with_repetition(repetition).build()
}
