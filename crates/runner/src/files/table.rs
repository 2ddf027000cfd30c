//! Tables of results: columns with unit and meaning, as record batches of Arrow in Parquet files.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use arrow::array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow::datatypes::{DataType, Field, Schema, SchemaRef};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use serde_json::Value;

use crate::failure::Failure;
use crate::files::publish::publish;

/// The keys of a column's unit and meaning.
pub const UNIT: &str = "unit";
pub const LONG_NAME: &str = "long_name";

/// Declares a column: every table is made of these. The unit of a pure number is `1`; values that may be missing are
/// optional.
pub fn column(name: &str, unit: &str, long_name: &str, kind: DataType, is_optional: bool) -> Field {
    let meaning = [(UNIT, unit), (LONG_NAME, long_name)].map(|(key, text)| (key.to_owned(), text.to_owned()));
    Field::new(name, kind, is_optional).with_metadata(HashMap::from(meaning))
}

/// A Parquet file that is being written, whatever to: the library's code is then built once.
pub struct TableWriter<'a> {
    schema: SchemaRef,
    writer: ArrowWriter<&'a mut (dyn Write + Send)>,
}

impl<'a> TableWriter<'a> {
    /// A file without rows yet, with pairs of key and value in its footer.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(
        out: &'a mut (dyn Write + Send),
        columns: Vec<Field>,
        footer: &[(&str, String)],
    ) -> Result<Self, ParquetError> {
        let schema = Arc::new(Schema::new(columns));
        let pairs = footer.iter().map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone())).collect();
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_key_value_metadata(Some(pairs))
            .build();
        let writer = ArrowWriter::try_new(out, schema.clone(), Some(properties))?;
        Ok(Self { schema, writer })
    }

    /// Writes a group of rows: the values of every column.
    ///
    /// # Errors
    /// If it cannot be written, and values of other types or of different lengths.
    pub fn write(&mut self, values: Vec<ArrayRef>) -> Result<(), ParquetError> {
        self.writer.write(&RecordBatch::try_new(self.schema.clone(), values)?)?;
        self.writer.flush()
    }

    /// Writes the footer.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(self) -> Result<(), ParquetError> {
        self.writer.close().map(drop)
    }
}

/// A table of one group of rows as the bytes of a Parquet file.
fn encoded(columns: Vec<(Field, ArrayRef)>, footer: &[(&str, String)]) -> Result<Vec<u8>, ParquetError> {
    let mut bytes = Vec::new();
    let (fields, values) = columns.into_iter().unzip();
    let mut writer = TableWriter::new(&mut bytes, fields, footer)?;
    writer.write(values)?;
    writer.finish()?;
    Ok(bytes)
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
    let columns = columns.iter().map(|DescribedColumn { name, unit, long_name, values }| {
        let values: ArrayRef = Arc::new(Float64Array::from_iter_values(values.iter().copied()));
        (column(name, unit, long_name, DataType::Float64, false), values)
    });
    let bytes = encoded(columns.collect(), &[]).map_err(|error| Failure::writing(&directory.join(name), error))?;
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
    pub unit: Cow<'static, str>,
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

    /// A value as text; nothing where there is none.
    fn text(&self, row: usize) -> Cow<'_, str> {
        match &self.values {
            TableValues::Integer(values) => values[row].to_string().into(),
            TableValues::Real(values) => values[row].map_or_else(String::new, |value| value.to_string()).into(),
            TableValues::Text(values) => (&*values[row]).into(),
            TableValues::Word(values) => values[row].unwrap_or_default().into(),
        }
    }

    /// The column and its values as they are stored. Words are optional only where one is missing.
    fn stored(&self) -> (Field, ArrayRef) {
        let (values, is_optional): (ArrayRef, bool) = match &self.values {
            TableValues::Integer(values) => (Arc::new(integers(values.iter().copied())), false),
            TableValues::Real(values) => (Arc::new(Float64Array::from_iter(values)), true),
            TableValues::Text(values) => (Arc::new(StringArray::from_iter_values(values)), false),
            TableValues::Word(values) => (Arc::new(StringArray::from_iter(values)), values.iter().any(Option::is_none)),
        };
        (column(&self.name, &self.unit, &self.long_name, values.data_type().clone(), is_optional), values)
    }
}

/// The names of columns as a line of CSV.
pub fn csv_names(columns: &[TableColumn]) -> String {
    csv_line(columns.iter().map(|column| &*column.name))
}

/// A row of columns as a line of CSV. A missing value is an empty field.
///
/// # Panics
/// If there is no such row.
pub fn csv_row(columns: &[TableColumn], row: usize) -> String {
    csv_line(columns.iter().map(|column| column.text(row)))
}

fn csv_line(fields: impl Iterator<Item = impl AsRef<str>>) -> String {
    let field = |field: &str| match field.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", field.replace('"', "\"\"")),
        false => field.to_owned(),
    };
    fields.map(|text| field(text.as_ref())).collect::<Vec<_>>().join(",") + "\n"
}

/// Counts as they are stored. They stay far below 2^63, see the limit on samples.
pub fn integers(values: impl Iterator<Item = u64>) -> Int64Array {
    values.map(u64::cast_signed).collect()
}

/// A table of columns of equal length as the bytes of a Parquet file, with pairs of key and value in its footer.
pub fn encoded_table(columns: &[TableColumn], footer: &[(&str, String)]) -> Result<Vec<u8>, ParquetError> {
    encoded(columns.iter().map(TableColumn::stored).collect(), footer)
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

#[cfg(test)]
mod tests {
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

    use super::*;
    use crate::files::forging::file_of;

    #[test]
    fn columns_have_their_types_units_and_meanings() {
        let column = |name: &'static str, values| TableColumn {
            name: name.into(),
            unit: "m/s".into(),
            long_name: format!("meaning of {name}").into(),
            values,
        };
        let columns = [
            column("integer", TableValues::Integer(vec![0, 7])),
            column("real", TableValues::Real(vec![Some(-0.0), None])),
            column("text", TableValues::Text(vec!["Größe".to_owned(), String::new()])),
            column("word", TableValues::Word(vec![Some("a"), Some("b")])),
            column("optional_word", TableValues::Word(vec![Some(""), None])),
        ];
        assert_eq!(csv_names(&columns), "integer,real,text,word,optional_word\n");
        assert_eq!([0, 1].map(|row| csv_row(&columns, row)), ["0,-0,Größe,a,\n", "7,,,b,\n"]);
        assert_eq!(csv_line(["a,b", "c\"d", "e"].into_iter()), "\"a,b\",\"c\"\"d\",e\n");
        let bytes = encoded_table(&columns, &[("stickslip:key", "value".to_owned())]).unwrap();
        let reader = ParquetRecordBatchReaderBuilder::try_new(file_of(&bytes)).unwrap();
        let types = [DataType::Int64, DataType::Float64, DataType::Utf8, DataType::Utf8, DataType::Utf8];
        let are_optional = [false, true, false, false, true];
        for ((field, kind), is_optional) in reader.schema().fields().iter().zip(types).zip(are_optional) {
            assert_eq!((field.data_type(), field.is_nullable()), (&kind, is_optional), "{}", field.name());
            assert_eq!(field.metadata().len(), 2);
            assert_eq!(field.metadata()[UNIT], "m/s");
            assert_eq!(field.metadata()[LONG_NAME], format!("meaning of {}", field.name()));
        }
        let pairs = reader.metadata().file_metadata().key_value_metadata().unwrap();
        assert!(pairs.iter().any(|pair| pair.key == "stickslip:key" && pair.value.as_deref() == Some("value")));
        let batch = reader.build().unwrap().next().unwrap().unwrap();
        let expected = columns.iter().map(|column| column.stored().1).collect::<Vec<_>>();
        assert_eq!(batch.columns(), expected);
    }
}
