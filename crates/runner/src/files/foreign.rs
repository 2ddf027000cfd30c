//! Reading Parquet files that anybody may have written. Their names and checksums say nothing, as they follow from the
//! content.
//!
//! The library that reads them panics on some files, which becomes an error here, and takes fewer values than a file
//! announces for its end, so they are counted. It reserves memory for what a page announces, but uses it for what is there.

use std::fs::File;

use arrow::array::{RecordBatch, RecordBatchReader as _};
use arrow::datatypes::Schema;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReaderBuilder};
use parquet::basic::Type;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader};

use crate::panics::caught;

/// Largest number of columns.
const MOST_COLUMNS: usize = 4096;

/// Largest number of values in the columns that are read of a file without a number of rows that is known: less
/// than a gigabyte in memory.
const MOST_VALUES: u64 = 1 << 25;

/// Rows that are read at a time: one text may stand in all of them.
const ROWS: usize = 256;

/// The values of columns, in parts of some rows each.
pub type Parts<'a> = &'a mut dyn Iterator<Item = Result<RecordBatch, String>>;

/// Lets `take` read the columns of a Parquet file that are wanted: their names and types, and their values.
/// `rows` is the number of rows that the file should have, if that is known.
///
/// # Errors
/// Why the file cannot be read, whatever it holds.
pub fn read<T>(
    file: File,
    rows: Option<u64>,
    wanted: impl Fn(&str) -> bool,
    take: impl FnOnce(&Schema, Parts<'_>) -> Result<T, String>,
) -> Result<T, String> {
    caught(|| {
        // Types are those of Parquet, whatever the schema of Arrow in the file says.
        let options = ArrowReaderOptions::new().with_skip_arrow_metadata(true);
        let metadata = ArrowReaderMetadata::load(&file, options).map_err(|error| error.to_string())?;
        let (rows, places) = check(metadata.metadata(), rows, wanted)?;
        let mask = ProjectionMask::leaves(metadata.parquet_schema(), places);
        let reader = ParquetRecordBatchReaderBuilder::new_with_metadata(file, metadata)
            .with_projection(mask)
            .with_batch_size(ROWS);
        let reader = reader.build().map_err(|error| error.to_string())?;
        let mut read = 0;
        let schema = reader.schema();
        let mut parts = reader.map(|part| match part {
            Ok(part) => {
                read += part.num_rows() as u64;
                Ok(part)
            }
            Err(error) => Err(error.to_string()),
        });
        let taken = take(&schema, &mut parts)?;
        drop(parts);
        if read == rows { Ok(taken) } else { Err(format!("it holds {read} rows and says {rows}")) }
    })
}

/// The text that the description of a Parquet file holds under a key; `None` where it is none, or has no such key.
pub fn text_of_key(file: &File, key: &str) -> Option<String> {
    let read = || ParquetMetaDataReader::new().parse_and_finish(file).map_err(|error| error.to_string());
    let metadata = caught(read).ok()?;
    let mut pairs = metadata.file_metadata().key_value_metadata()?.iter();
    pairs.find(|pair| pair.key == key)?.value.clone()
}

/// Checks what a file says of itself. Returns its number of rows and the places of the columns that are wanted.
fn check(
    metadata: &ParquetMetaData,
    expected: Option<u64>,
    wanted: impl Fn(&str) -> bool,
) -> Result<(u64, Vec<usize>), String> {
    let described = metadata.file_metadata();
    let rows = u64::try_from(described.num_rows()).map_err(|_| "its number of rows is negative")?;
    let schema = described.schema_descr();
    if schema.num_columns() == 0 || schema.num_columns() > MOST_COLUMNS {
        return Err(format!("it has {} columns, and from 1 to {MOST_COLUMNS} are read", schema.num_columns()));
    }
    if !schema.root_schema().get_fields().iter().all(|field| field.is_primitive()) {
        return Err("it has columns of groups or lists, and tables of numbers and texts are read".to_owned());
    }
    let columns = schema.columns();
    let places: Vec<usize> = (0..columns.len()).filter(|&place| wanted(columns[place].name())).collect();
    for column in places.iter().map(|&place| &columns[place]) {
        match column.physical_type() {
            Type::INT64 | Type::DOUBLE | Type::BYTE_ARRAY if column.max_rep_level() == 0 => {}
            Type::INT64 | Type::DOUBLE | Type::BYTE_ARRAY => {
                return Err(format!("its column {} holds lists", column.name()));
            }
            other => {
                return Err(format!("its column {} holds {other}; INT64, DOUBLE and texts are read", column.name()));
            }
        }
    }
    let values = rows.saturating_mul(places.len() as u64);
    match expected {
        Some(expected) if rows != expected => Err(format!("it has {rows} rows, not {expected}")),
        None if values > MOST_VALUES => Err(format!("it has {values} values; the limit is {MOST_VALUES}")),
        _ => Ok((rows, places)),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use arrow::array::{ArrayRef, Int64Builder, ListBuilder, RecordBatch};
    use parquet::arrow::ArrowWriter;

    use super::*;
    use crate::files::forging::{assert_bounded, file_of};
    use crate::files::table::{TableColumn, TableValues, encoded_table};

    /// A table of numbers and texts.
    fn table(text: &str) -> Vec<u8> {
        let column = |name: &'static str, values| TableColumn {
            name: name.into(),
            unit: "1".into(),
            long_name: "".into(),
            values,
        };
        let columns = [
            column("integer", TableValues::Integer((0..3000).collect())),
            column("real", TableValues::Real((0..3000).map(|i| (i % 7 > 0).then_some(0.5 * f64::from(i))).collect())),
            column("text", TableValues::Text(vec![text.to_owned(); 3000])),
        ];
        encoded_table(&columns, &[("stickslip:key", "value".to_owned())]).unwrap()
    }

    /// The number of values in the columns that are wanted.
    fn values(bytes: &[u8], rows: Option<u64>, wanted: impl Fn(&str) -> bool) -> Result<usize, String> {
        read(file_of(bytes), rows, wanted, |_, parts| {
            parts.map(|part| part.map(|part| part.num_rows() * part.num_columns())).sum()
        })
    }

    #[test]
    fn what_is_wanted_is_read() {
        let sound = table("word");
        assert_eq!(values(&sound, Some(3000), |_| true), Ok(9000));
        assert_eq!(values(&sound, None, |name| name == "real"), Ok(3000));
        assert_eq!(values(&sound, Some(2999), |_| true), Err("it has 3000 rows, not 2999".to_owned()));
        assert_eq!(text_of_key(&file_of(&sound), "stickslip:key").as_deref(), Some("value"));
        assert_eq!(text_of_key(&file_of(b"no table, but long enough"), "stickslip:key"), None);
    }

    #[test]
    fn a_text_that_stands_in_every_row_takes_little_memory() {
        let long = table(&"x".repeat(1 << 17));
        assert!(long.len() < 1 << 17, "{}", long.len());
        let most = |part: RecordBatch| part.get_array_memory_size();
        let largest = read(
            file_of(&long),
            None,
            |_| true,
            |_, parts| parts.map(|part| part.map(most)).try_fold(0, |largest, size| size.map(|size| size.max(largest))),
        );
        assert!(largest.is_ok_and(|largest| largest < 1 << 26));
    }

    #[test]
    fn groups_and_fewer_rows_than_said_are_refused() {
        let mut lists = ListBuilder::new(Int64Builder::new());
        (0..10).for_each(|_| lists.append_value([Some(1), None]));
        let lists: ArrayRef = Arc::new(lists.finish());
        let batch = RecordBatch::try_from_iter([("lists", lists)]).unwrap();
        let mut writer = ArrowWriter::try_new(Vec::new(), batch.schema(), None).unwrap();
        writer.write(&batch).unwrap();
        let lists = writer.into_inner().unwrap();
        assert!(values(&lists, None, |_| true).is_err_and(|why| why.contains("groups or lists")));
        // 3000 as Thrift writes it in a field of 64 bits, and 3001: a file that ends before its number of rows.
        let mut fewer = table("word");
        let places: Vec<usize> = (0..fewer.len() - 2).filter(|&at| fewer[at..at + 3] == [0x16, 0xf0, 0x2e]).collect();
        assert!(places.len() >= 2, "{places:?}");
        places.iter().for_each(|at| fewer[at + 1] = 0xf2);
        assert!(values(&fewer, None, |_| true).is_err_and(|why| why.contains("3000 rows and says 3001")));
    }

    #[test]
    fn forged_tables_are_read_or_refused() {
        let sound = [table("word"), table("another")];
        assert_bounded("files::foreign::tests::forged_tables_are_read_or_refused", &sound, 3000, |bytes| {
            values(&bytes, None, |_| true).map(drop)
        });
    }
}
