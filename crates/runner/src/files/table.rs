//! Tables other than the surface: columns of equal length, each with unit and meaning, in one Parquet file.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use serde_json::Value;

use crate::failure::Failure;
use crate::files::publish::publish;

/// A field with its unit and meaning in its metadata.
pub fn described_field(name: &str, unit: &str, long_name: &str, data_type: DataType, nullable: bool) -> Field {
    let pairs = [("unit", unit), ("long_name", long_name)];
    let metadata: HashMap<String, String> = pairs.map(|(key, text)| (key.to_owned(), text.to_owned())).into();
    Field::new(name, data_type, nullable).with_metadata(metadata)
}

/// A column of real numbers, for figures.
pub struct DescribedColumn {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Meaning.
    pub long_name: &'static str,
    /// Values.
    pub values: Vec<f64>,
}

/// Writes columns of equal length as `name` into `directory`, whole or not at all.
pub fn write_columns(directory: &Path, name: &str, columns: &[DescribedColumn]) -> Result<(), Failure> {
    let field = |c: &DescribedColumn| described_field(c.name, c.unit, c.long_name, DataType::Float64, false);
    let array = |c: &DescribedColumn| -> ArrayRef { Arc::new(Float64Array::from(c.values.clone())) };
    let (fields, arrays) = (columns.iter().map(field).collect(), columns.iter().map(array).collect());
    let bytes = encoded(fields, arrays, None).map_err(|error| Failure::writing(&directory.join(name), error))?;
    publish(directory, name, &bytes)
}

/// Columns as one batch, as the bytes of a Parquet file.
fn encoded(fields: Vec<Field>, arrays: Vec<ArrayRef>, footer: Option<Vec<KeyValue>>) -> Result<Vec<u8>, ParquetError> {
    let schema = Arc::new(Schema::new(fields));
    let batch = RecordBatch::try_new(schema.clone(), arrays)?;
    let properties =
        WriterProperties::builder().set_compression(Compression::SNAPPY).set_key_value_metadata(footer).build();
    let mut writer = ArrowWriter::try_new(Vec::new(), schema, Some(properties))?;
    writer.write(&batch)?;
    writer.into_inner()
}

/// The values of a [`TableColumn`].
pub enum TableValues {
    /// Counts and indices.
    Integer(Vec<u64>),
    /// Numbers that may be unknown.
    Real(Vec<Option<f64>>),
    /// Names.
    Text(Vec<String>),
    /// One of a few words, or nothing.
    Word(Vec<Option<&'static str>>),
}

/// A column of any type.
pub struct TableColumn {
    /// Name.
    pub name: Cow<'static, str>,
    /// Unit.
    pub unit: &'static str,
    /// Meaning.
    pub long_name: Cow<'static, str>,
    /// Values.
    pub values: TableValues,
}

impl TableColumn {
    /// A value as JSON; `null` where there is none.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn value(&self, row: usize) -> Value {
        match &self.values {
            TableValues::Integer(values) => values[row].into(),
            TableValues::Real(values) => values[row].into(),
            TableValues::Text(values) => values[row].as_str().into(),
            TableValues::Word(values) => values[row].into(),
        }
    }

    fn field(&self) -> Field {
        let (data_type, nullable) = match &self.values {
            TableValues::Integer(_) => (DataType::Int64, false),
            TableValues::Real(_) => (DataType::Float64, true),
            TableValues::Text(_) => (DataType::Utf8, false),
            TableValues::Word(values) => (DataType::Utf8, values.contains(&None)),
        };
        described_field(&self.name, self.unit, &self.long_name, data_type, nullable)
    }

    fn array(&self) -> ArrayRef {
        match &self.values {
            TableValues::Integer(values) => {
                Arc::new(values.iter().map(|value| value.cast_signed()).collect::<Int64Array>())
            }
            TableValues::Real(values) => Arc::new(Float64Array::from(values.clone())),
            TableValues::Text(values) => Arc::new(StringArray::from_iter_values(values)),
            TableValues::Word(values) => Arc::new(values.iter().collect::<StringArray>()),
        }
    }
}

/// A table of columns of equal length as the bytes of a Parquet file, with pairs of key and value in its footer.
pub fn encoded_table(columns: &[TableColumn], footer: &[(&str, String)]) -> Result<Vec<u8>, ParquetError> {
    let pairs = footer.iter().map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone())).collect();
    let fields = columns.iter().map(TableColumn::field).collect();
    encoded(fields, columns.iter().map(TableColumn::array).collect(), Some(pairs))
}

/// Writes a table of columns of equal length as `name` into `directory`, whole or not at all, with pairs of key and
/// value in its footer.
pub fn write_table(
    directory: &Path,
    name: &str,
    columns: &[TableColumn],
    footer: &[(&str, String)],
) -> Result<(), Failure> {
    let bytes = encoded_table(columns, footer).map_err(|error| Failure::writing(&directory.join(name), error))?;
    publish(directory, name, &bytes)
}
