//! Tables other than the surface: columns of equal length, each with unit and meaning, in one Parquet file.

use std::borrow::Cow;
use std::path::Path;

use parquet::basic::Compression;
use parquet::errors::ParquetError;
use serde_json::Value;

use crate::failure::Failure;
use crate::files::column::{Field, Kind, Values};
use crate::files::encode::encoded;
use crate::files::publish::publish;

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
    let fields = columns.iter().map(|column| Field {
        name: column.name.into(),
        unit: column.unit.into(),
        long_name: column.long_name.into(),
        kind: Kind::Real,
    });
    let values = columns.iter().map(|column| Values::Real(column.values.clone()));
    let bytes = encoded(&fields.collect::<Vec<_>>(), values, &[], Compression::SNAPPY)
        .map_err(|error| Failure::writing(&directory.join(name), error))?;
    publish(directory, name, &bytes)
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

    fn field(&self, values: &Values) -> Field {
        Field {
            name: self.name.clone(),
            unit: self.unit.into(),
            long_name: self.long_name.clone(),
            kind: values.kind(),
        }
    }

    fn stored(&self) -> Values {
        match &self.values {
            TableValues::Integer(values) => Values::Integer(values.iter().map(|value| value.cast_signed()).collect()),
            TableValues::Real(values) => Values::OptionalReal(values.clone()),
            TableValues::Text(values) => Values::Text(values.clone()),
            TableValues::Word(values) => match values.iter().copied().collect::<Option<Vec<_>>>() {
                Some(words) => Values::Text(words.into_iter().map(str::to_owned).collect()),
                None => Values::OptionalText(values.clone()),
            },
        }
    }
}

/// A table of columns of equal length as the bytes of a Parquet file, with pairs of key and value in its footer.
pub fn encoded_table(columns: &[TableColumn], footer: &[(&str, String)]) -> Result<Vec<u8>, ParquetError> {
    let values: Vec<Values> = columns.iter().map(TableColumn::stored).collect();
    let fields: Vec<Field> = columns.iter().zip(&values).map(|(column, values)| column.field(values)).collect();
    encoded(&fields, values, footer, Compression::SNAPPY)
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
