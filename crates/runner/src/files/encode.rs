//! Writing Parquet tables, one group of rows after the other.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;

use super::arrow_schema::{self, ELEMENT};
use super::column::{Field, Kind, Lists, Values};

/// A Parquet file that is being written, whatever to: the library's code is then built once.
pub struct TableWriter<'a> {
    writer: SerializedFileWriter<&'a mut (dyn Write + Send)>,
}

impl<'a> TableWriter<'a> {
    /// A file without rows yet, with pairs of key and value in its footer.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(
        out: &'a mut (dyn Write + Send),
        fields: &[Field],
        footer: &[(&str, String)],
        compression: Compression,
    ) -> Result<Self, ParquetError> {
        let arrow = (arrow_schema::KEY, arrow_schema::encoded(fields));
        let pairs = footer.iter().chain([&arrow]);
        let pairs = pairs.map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone())).collect();
        let properties =
            WriterProperties::builder().set_compression(compression).set_key_value_metadata(Some(pairs)).build();
        let columns = fields.iter().map(|field| column_type(field).map(Arc::new)).collect::<Result<_, _>>()?;
        let schema = Type::group_type_builder("arrow_schema").with_fields(columns).build()?;
        let writer = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))?;
        Ok(Self { writer })
    }

    /// Writes a group of rows: the values of every column, in the order of the fields and of their types.
    ///
    /// # Errors
    /// If it cannot be written, and columns of different lengths.
    pub fn write(&mut self, columns: impl IntoIterator<Item = Values>) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        for values in columns {
            let missing = || ParquetError::General("there are more columns than fields".to_owned());
            let mut column = group.next_column()?.ok_or_else(missing)?;
            match values {
                Values::Integer(values) => write_all::<Int64Type>(&mut column, &values)?,
                Values::Real(values) => write_all::<DoubleType>(&mut column, &values)?,
                Values::OptionalReal(values) => write_optional::<DoubleType>(&mut column, &values)?,
                Values::Text(texts) => {
                    let texts: Vec<ByteArray> = texts.into_iter().map(|text| text.into_bytes().into()).collect();
                    write_all::<ByteArrayType>(&mut column, &texts)?;
                }
                Values::OptionalText(texts) => {
                    let texts: Vec<Option<ByteArray>> = texts.into_iter().map(|text| text.map(Into::into)).collect();
                    write_optional::<ByteArrayType>(&mut column, &texts)?;
                }
                Values::Integers(lists) => write_lists::<Int64Type>(&mut column, &lists)?,
                Values::Reals(lists) => write_lists::<DoubleType>(&mut column, &lists)?,
            }
            column.close()?;
        }
        group.close()?;
        Ok(())
    }

    /// Writes the footer.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(self) -> Result<(), ParquetError> {
        self.writer.into_inner().map(drop)
    }
}

/// A table of one group of rows as the bytes of a Parquet file.
///
/// # Errors
/// Columns of different lengths.
pub fn encoded(
    fields: &[Field],
    columns: impl IntoIterator<Item = Values>,
    footer: &[(&str, String)],
    compression: Compression,
) -> Result<Vec<u8>, ParquetError> {
    let mut bytes = Vec::new();
    let mut writer = TableWriter::new(&mut bytes, fields, footer, compression)?;
    writer.write(columns)?;
    writer.finish()?;
    Ok(bytes)
}

/// A column as Parquet describes it.
fn column_type(field: &Field) -> Result<Type, ParquetError> {
    let of = |name: &str, physical: PhysicalType, logical: Option<LogicalType>, repetition: Repetition| {
        Type::primitive_type_builder(name, physical).with_logical_type(logical).with_repetition(repetition).build()
    };
    let list = |element: PhysicalType| {
        let element = of(ELEMENT, element, None, Repetition::REQUIRED)?;
        let repeated = Type::group_type_builder("list")
            .with_repetition(Repetition::REPEATED)
            .with_fields(vec![Arc::new(element)])
            .build()?;
        Type::group_type_builder(&field.name)
            .with_repetition(Repetition::REQUIRED)
            .with_logical_type(Some(LogicalType::List))
            .with_fields(vec![Arc::new(repeated)])
            .build()
    };
    match field.kind {
        Kind::Integer => of(&field.name, PhysicalType::INT64, None, Repetition::REQUIRED),
        Kind::Real => of(&field.name, PhysicalType::DOUBLE, None, Repetition::REQUIRED),
        Kind::OptionalReal => of(&field.name, PhysicalType::DOUBLE, None, Repetition::OPTIONAL),
        Kind::Text => of(&field.name, PhysicalType::BYTE_ARRAY, Some(LogicalType::String), Repetition::REQUIRED),
        Kind::OptionalText => {
            of(&field.name, PhysicalType::BYTE_ARRAY, Some(LogicalType::String), Repetition::OPTIONAL)
        }
        Kind::Integers => list(PhysicalType::INT64),
        Kind::Reals => list(PhysicalType::DOUBLE),
    }
}

fn write_all<T: DataType>(column: &mut SerializedColumnWriter<'_>, values: &[T::T]) -> Result<(), ParquetError> {
    column.typed::<T>().write_batch(values, None, None).map(drop)
}

/// Writes the values that are there, and level 0 where there is none.
fn write_optional<T: DataType>(
    column: &mut SerializedColumnWriter<'_>,
    values: &[Option<T::T>],
) -> Result<(), ParquetError> {
    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let values: Vec<T::T> = values.iter().flatten().cloned().collect();
    column.typed::<T>().write_batch(&values, Some(&levels), None).map(drop)
}

/// Writes lists: a value is there (1) or its list is empty (0), and goes on a list (1) or begins one (0).
fn write_lists<T: DataType>(column: &mut SerializedColumnWriter<'_>, lists: &Lists<T::T>) -> Result<(), ParquetError>
where
    T::T: Copy,
{
    let (mut present, mut repeated) = (Vec::new(), Vec::new());
    for list in lists.rows() {
        present.extend(std::iter::repeat_n(1, list.len()));
        repeated.extend((0..list.len()).map(|place| i16::from(place > 0)));
        if list.is_empty() {
            present.push(0);
            repeated.push(0);
        }
    }
    column.typed::<T>().write_batch(lists.values(), Some(&present), Some(&repeated)).map(drop)
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use arrow_array::builder::{Int64Builder, ListBuilder};
    use arrow_array::cast::AsArray as _;
    use arrow_array::types::{Float64Type, Int64Type as ArrowInt64};
    use arrow_array::{Array as _, ArrayRef, Float64Array, RecordBatch};
    use bytes::Bytes;
    use parquet::arrow::ArrowWriter;
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

    use super::*;
    use crate::files::decode::{ReadTable, ReadValues};

    /// A table with columns of every type.
    fn table() -> (Vec<Field>, Vec<Values>) {
        let mut integers = Lists::default();
        [&[1, -2][..], &[], &[i64::MAX]].into_iter().for_each(|list| integers.push(list.iter().copied()));
        let mut reals = Lists::default();
        [&[][..], &[0.1, f64::NEG_INFINITY], &[]].into_iter().for_each(|list| reals.push(list.iter().copied()));
        let columns = vec![
            Values::Integer(vec![i64::MIN, 0, 7]),
            Values::Real(vec![0.1, -0.0, f64::MAX]),
            Values::OptionalReal(vec![None, Some(1e-300), None]),
            Values::Text(vec!["Größe".to_owned(), String::new(), "z".to_owned()]),
            Values::OptionalText(vec![Some("a"), None, Some("")]),
            Values::Integers(integers),
            Values::Reals(reals),
        ];
        let names = ["integer", "real", "optional_real", "text", "optional_text", "integers", "reals"];
        let fields = names.iter().zip(&columns).map(|(name, values)| Field {
            name: (*name).into(),
            unit: "m/s".into(),
            long_name: format!("meaning of {name}").into(),
            kind: values.kind(),
        });
        (fields.collect(), columns)
    }

    fn written() -> Bytes {
        let (fields, columns) = table();
        let footer = [("stickslip:key", "value".to_owned())];
        Bytes::from(encoded(&fields, columns, &footer, Compression::SNAPPY).unwrap())
    }

    #[test]
    fn arrow_reads_what_is_written_with_units_and_meanings() {
        let reader = ParquetRecordBatchReaderBuilder::try_new(written()).unwrap();
        let types: Vec<String> =
            reader.schema().fields().iter().map(|field| format!("{:?}", field.data_type())).collect();
        assert_eq!(types[..5], ["Int64", "Float64", "Float64", "Utf8", "Utf8"]);
        assert!(types[5].starts_with("List(") && types[5].contains("Int64"), "{}", types[5]);
        assert!(types[6].starts_with("List(") && types[6].contains("Float64"), "{}", types[6]);
        let nullable: Vec<bool> = reader.schema().fields().iter().map(|field| field.is_nullable()).collect();
        assert_eq!(nullable, [false, false, true, false, true, false, false]);
        for field in reader.schema().fields() {
            let meaning = format!("meaning of {}", field.name());
            let expected =
                [("unit", "m/s"), ("long_name", &meaning)].map(|(key, text)| (key.to_owned(), text.to_owned()));
            assert_eq!(*field.metadata(), HashMap::from(expected));
        }
        let pairs = reader.metadata().file_metadata().key_value_metadata().unwrap();
        assert!(pairs.iter().any(|pair| pair.key == "stickslip:key" && pair.value.as_deref() == Some("value")));
        let batch = reader.build().unwrap().next().unwrap().unwrap();
        assert_eq!(batch.column(0).as_primitive::<ArrowInt64>().values(), &[i64::MIN, 0, 7]);
        assert_eq!(batch.column(1).as_primitive::<Float64Type>().values(), &[0.1, -0.0, f64::MAX]);
        let optional: Vec<Option<f64>> = batch.column(2).as_primitive::<Float64Type>().iter().collect();
        assert_eq!(optional, [None, Some(1e-300), None]);
        let texts: Vec<Option<&str>> = batch.column(3).as_string::<i32>().iter().collect();
        assert_eq!(texts, [Some("Größe"), Some(""), Some("z")]);
        let texts: Vec<Option<&str>> = batch.column(4).as_string::<i32>().iter().collect();
        assert_eq!(texts, [Some("a"), None, Some("")]);
        let lists = batch.column(5).as_list::<i32>();
        let rows: Vec<ArrayRef> = (0..3).map(|row| lists.value(row)).collect();
        assert_eq!(rows[0].as_primitive::<ArrowInt64>().values(), &[1, -2]);
        assert_eq!((rows[1].len(), rows[2].as_primitive::<ArrowInt64>().value(0)), (0, i64::MAX));
        assert_eq!(
            batch.column(6).as_list::<i32>().value(1).as_primitive::<Float64Type>().values(),
            &[0.1, f64::NEG_INFINITY]
        );
    }

    #[test]
    fn a_table_reads_back_as_written() {
        let read = ReadTable::read(written(), &[0, 1, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!((read.rows, read.pair("stickslip:key")), (3, Some("value")));
        assert_eq!(read.integers("integer").unwrap(), [i64::MIN, 0, 7]);
        assert_eq!(read.reals("real").unwrap(), [0.1, -0.0, f64::MAX]);
        assert!(read.reals("optional_real").is_err_and(|why| why.contains("missing")));
        assert!(matches!(read.column("optional_real"), Some(ReadValues::Real(v)) if *v == [None, Some(1e-300), None]));
        let text = |text: &str| Some(text.to_owned());
        assert!(matches!(read.column("text"), Some(ReadValues::Text(v)) if *v == [text("Größe"), text(""), text("z")]));
        assert!(matches!(read.column("optional_text"), Some(ReadValues::Text(v)) if *v == [text("a"), None, text("")]));
        let Values::Integers(integers) = &table().1[5] else { panic!() };
        assert!(matches!(read.column("integers"), Some(ReadValues::Integers(lists)) if lists == integers));
        let Values::Reals(reals) = &table().1[6] else { panic!() };
        assert!(matches!(read.column("reals"), Some(ReadValues::Reals(lists)) if lists == reals));
    }

    #[test]
    fn some_columns_and_several_groups_of_rows_are_read() {
        let (fields, _) = table();
        let mut bytes = Vec::new();
        let mut writer = TableWriter::new(&mut bytes, &fields, &[], Compression::UNCOMPRESSED).unwrap();
        (0..3).for_each(|_| writer.write(table().1).unwrap());
        writer.finish().unwrap();
        let read = ReadTable::read(Bytes::from(bytes), &[0, 5]).unwrap();
        assert_eq!((read.rows, read.columns.len()), (9, 2));
        assert_eq!(read.integers("integer").unwrap(), [i64::MIN, 0, 7].repeat(3));
        let Some(ReadValues::Integers(lists)) = read.column("integers") else { panic!() };
        assert_eq!(
            (lists.len(), lists.row(3), lists.row(4), lists.row(8)),
            (9, &[1, -2][..], &[][..], &[i64::MAX][..])
        );
    }

    #[test]
    fn a_long_text_in_every_row_is_refused() {
        let (fields, mut columns) = table();
        columns[3] = Values::Text(vec!["x".repeat(1 << 14); 5000]);
        let bytes = encoded(&fields[3..4], columns.drain(3..4), &[], Compression::SNAPPY).unwrap();
        assert!(bytes.len() < 1 << 20, "{}", bytes.len());
        assert!(ReadTable::read(Bytes::from(bytes), &[0]).is_err_and(|why| why.contains("longer than")));
    }

    #[test]
    fn lists_that_arrow_wrote_are_read_and_gaps_in_them_refused() {
        let of = |gap: Option<i64>| {
            let mut lists = ListBuilder::new(Int64Builder::new());
            lists.append_value([Some(1), Some(2)]);
            lists.append_value([]);
            lists.append_value([Some(3), gap]);
            let columns: [(&str, ArrayRef); 2] = [
                ("lists", Arc::new(lists.finish())),
                ("numbers", Arc::new(Float64Array::from(vec![Some(0.5), None, Some(2.0)]))),
            ];
            let batch = RecordBatch::try_from_iter(columns).unwrap();
            let mut writer = ArrowWriter::try_new(Vec::new(), batch.schema(), None).unwrap();
            writer.write(&batch).unwrap();
            ReadTable::read(Bytes::from(writer.into_inner().unwrap()), &[0, 1])
        };
        let read = of(Some(4)).unwrap();
        let Some(ReadValues::Integers(lists)) = read.column("lists") else { panic!() };
        assert_eq!(lists.rows().collect::<Vec<_>>(), [&[1, 2][..], &[], &[3, 4]]);
        assert!(matches!(read.column("numbers"), Some(ReadValues::Real(v)) if *v == [Some(0.5), None, Some(2.0)]));
        assert!(of(None).is_err_and(|why| why.contains("missing in a list")));
    }
}
