//! Reading Parquet files that anybody may have written. Their names and checksums say nothing, as they follow from the
//! content.
//!
//! The library that reads them allocates what a file announces, and panics on some files. So everything that announces
//! a size is compared with the size of the file first, and a panic becomes an error.

use std::fs::File;
use std::sync::Arc;

use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder,
};
use parquet::basic::{Compression, Type};
use parquet::file::metadata::{ColumnChunkMetaData, FooterTail, ParquetMetaData, ParquetMetaDataReader};
use parquet::file::reader::{ChunkReader as _, Length as _};

use super::thrift::Structure;
use crate::panics::caught;

/// Length of the last bytes of a file: the length of its description, and a mark.
const TAIL: u64 = 8;

/// Largest number of values in the description of a file: more than a surface of [`MOST_COLUMNS`] columns has.
const MOST_DESCRIBED: usize = 1 << 20;

/// Largest number of columns.
const MOST_COLUMNS: i64 = 4096;

/// The header of a page is sought in this many bytes first, and then in as many as one may have.
const HEADERS: [u64; 2] = [4096, 1 << 20];

/// Largest ratio of a page to its compressed form: Snappy makes at most 64 bytes of three.
const TIGHTEST: i64 = 24;

/// Largest page. Ours have about a megabyte.
const LARGEST_PAGE: i64 = 1 << 28;

/// Largest page of texts, which are words: one of them may stand in every row, and 1024 rows are read at a time.
const LARGEST_PAGE_OF_TEXTS: i64 = 1 << 16;

/// Largest number of values in the columns that are read of a file without a number of rows that is known: less
/// than a gigabyte in memory.
const MOST_VALUES: u64 = 1 << 25;

/// Lets `take` read the columns of a Parquet file that are wanted, after everything that it says of itself was checked.
/// `rows` is the number of rows that it should have, if that is known.
///
/// # Errors
/// Why the file cannot be read, whatever it holds.
pub fn read<T>(
    file: File,
    rows: Option<u64>,
    wanted: impl Fn(&str) -> bool,
    take: impl FnOnce(ParquetRecordBatchReader) -> Result<T, String>,
) -> Result<T, String> {
    caught(|| {
        let metadata = description(&file)?;
        let places = check(&file, &metadata, rows, wanted)?;
        // Types are those of Parquet, whatever the schema of Arrow in the file says.
        let options = ArrowReaderOptions::new().with_skip_arrow_metadata(true);
        let metadata = ArrowReaderMetadata::try_new(Arc::new(metadata), options).map_err(|error| error.to_string())?;
        let mask = ProjectionMask::leaves(metadata.parquet_schema(), places);
        let reader = ParquetRecordBatchReaderBuilder::new_with_metadata(file, metadata).with_projection(mask);
        take(reader.build().map_err(|error| error.to_string())?)
    })
}

/// The text that the description of a Parquet file holds under a key; `None` where it is none, or has no such key.
pub fn text_of_key(file: &File, key: &str) -> Option<String> {
    let metadata = caught(|| description(file)).ok()?;
    let mut pairs = metadata.file_metadata().key_value_metadata()?.iter();
    pairs.find(|pair| pair.key == key)?.value.clone()
}

/// What a Parquet file says of itself: a table of plain columns.
fn description(file: &File) -> Result<ParquetMetaData, String> {
    let length = file.len();
    let bytes = |at: u64, length: u64| file.get_bytes(at, length as usize).map_err(|error| error.to_string());
    let start = length.checked_sub(TAIL).ok_or("it is no Parquet file")?;
    let tail = FooterTail::try_from(&bytes(start, TAIL)?[..]).map_err(|_| "it is no Parquet file")?;
    let described = tail.metadata_length() as u64;
    let start = start.checked_sub(described).ok_or("its description is longer than the file")?;
    let bytes = bytes(start, described)?;
    let structure = Structure::at_start(&bytes, MOST_DESCRIBED).ok_or("its description cannot be read")?;
    // The numbers of members in the list of columns: that of all columns, and those of columns that are groups.
    let members: Vec<i64> = structure.numbers([2, 5]).filter(|members| *members != 0).collect();
    match members[..] {
        [columns] if (1..=MOST_COLUMNS).contains(&columns) => {
            ParquetMetaDataReader::decode_metadata(&bytes).map_err(|error| error.to_string())
        }
        [_] => Err(format!("it has no columns, or more than {MOST_COLUMNS}")),
        _ => Err("it has columns of groups or lists, and tables of numbers and texts are read".to_owned()),
    }
}

/// Checks the columns of a file that are wanted, and returns their places.
fn check(
    file: &File,
    metadata: &ParquetMetaData,
    expected: Option<u64>,
    wanted: impl Fn(&str) -> bool,
) -> Result<Vec<usize>, String> {
    let described = metadata.file_metadata();
    let rows = u64::try_from(described.num_rows()).map_err(|_| "its number of rows is negative")?;
    let columns = described.schema_descr().columns();
    let places: Vec<usize> = (0..columns.len()).filter(|&place| wanted(columns[place].name())).collect();
    let values = rows.saturating_mul(places.len() as u64);
    match expected {
        Some(expected) if rows != expected => return Err(format!("it has {rows} rows, not {expected}")),
        None if values > MOST_VALUES => return Err(format!("it has {values} values; the limit is {MOST_VALUES}")),
        _ => {}
    }
    let (mut all_rows, mut bytes_left) = (0_u64, file.len());
    for group in metadata.row_groups() {
        let rows = u64::try_from(group.num_rows()).map_err(|_| "a number of rows is negative")?;
        all_rows = all_rows.saturating_add(rows);
        for &place in &places {
            let chunk = Chunk::from_metadata(group.column(place), rows)
                .map_err(|why| format!("its column {} {why}", columns[place].name()))?;
            bytes_left = bytes_left.checked_sub(chunk.bytes).ok_or("its columns are longer than the file")?;
            chunk.check_pages(file)?;
        }
    }
    if all_rows == rows { Ok(places) } else { Err("its numbers of rows do not add up".to_owned()) }
}

/// The values of a column in a group of rows.
struct Chunk {
    rows: u64,
    start: u64,
    bytes: u64,
    is_compressed: bool,
    /// Bytes that a value takes in a dictionary, at least.
    width: i64,
    largest_page: i64,
}

impl Chunk {
    fn from_metadata(described: &ColumnChunkMetaData, rows: u64) -> Result<Self, String> {
        let (width, largest_page) = match described.column_type() {
            Type::INT64 | Type::DOUBLE => (8, LARGEST_PAGE),
            Type::BYTE_ARRAY => (4, LARGEST_PAGE_OF_TEXTS),
            other => return Err(format!("holds {other}; INT64, DOUBLE and texts are read")),
        };
        let is_compressed = match described.compression() {
            Compression::UNCOMPRESSED => false,
            Compression::SNAPPY => true,
            _ => return Err("is compressed in another way than Snappy".to_owned()),
        };
        if described.file_path().is_some() || described.column_descr().max_rep_level() > 0 {
            return Err("is in another file, or holds lists".to_owned());
        }
        let (start, bytes) = described.byte_range();
        Ok(Self { rows, start, bytes, is_compressed, width, largest_page })
    }

    /// Checks that the pages fill the bytes of the column and hold a value for each row.
    fn check_pages(&self, file: &File) -> Result<(), String> {
        let (mut at, mut left, mut values) = (self.start, self.bytes, 0_u64);
        while left > 0 {
            let page = Page::at(file, at, left)?;
            let length = page.header + page.compressed;
            left = left.checked_sub(length).ok_or("a page is longer than its column")?;
            at += length;
            values = values.saturating_add(self.values_of(&page)?);
        }
        if values == self.rows { Ok(()) } else { Err("the values of its pages do not add up".to_owned()) }
    }

    /// The number of values of a page, if it is in order. A dictionary is not counted.
    fn values_of(&self, page: &Page) -> Result<u64, String> {
        let compressed = page.compressed.cast_signed();
        let (size, most) = match self.is_compressed {
            true => (page.uncompressed, compressed.saturating_mul(TIGHTEST).saturating_add(64)),
            false => (compressed, compressed),
        };
        if !(0..=most.min(self.largest_page)).contains(&size) || page.values < 0 {
            return Err("a page has an impossible size".to_owned());
        }
        // Plain, or in a dictionary.
        if !matches!(page.encoding, 0 | 2 | 8) || (page.is_dictionary && page.values.saturating_mul(self.width) > size)
        {
            return Err("a page cannot be read".to_owned());
        }
        Ok(if page.is_dictionary { 0 } else { page.values.cast_unsigned() })
    }
}

/// A page as its header describes it.
struct Page {
    /// Length of the header.
    header: u64,
    compressed: u64,
    uncompressed: i64,
    values: i64,
    encoding: i64,
    is_dictionary: bool,
}

impl Page {
    /// The page at a place, in a column of which `left` bytes are left.
    fn at(file: &File, at: u64, left: u64) -> Result<Self, String> {
        for length in HEADERS {
            let bytes = file.get_bytes(at, length.min(left) as usize).map_err(|error| error.to_string())?;
            if let Some(header) = Structure::at_start(&bytes, MOST_DESCRIBED) {
                return Self::from_header(&header).ok_or_else(|| "a page cannot be read".to_owned());
            }
            if length >= left {
                break;
            }
        }
        Err("the header of a page cannot be read".to_owned())
    }

    fn from_header(header: &Structure) -> Option<Self> {
        let kind = header.number([1, 0])?;
        let (of_kind, encoding) = match kind {
            0 => (5, 2),
            2 => (7, 2),
            3 => (8, 4),
            _ => return None,
        };
        Some(Self {
            header: header.length as u64,
            compressed: u64::try_from(header.number([3, 0])?).ok()?,
            uncompressed: header.number([2, 0])?,
            values: header.number([of_kind, 1])?,
            encoding: header.number([of_kind, encoding])?,
            is_dictionary: kind == 2,
        })
    }
}

#[cfg(test)]
mod tests {
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
        read(file_of(bytes), rows, wanted, |batches| {
            let values = |batch: RecordBatch| batch.num_rows() * batch.num_columns();
            batches.map(|batch| batch.map(values).map_err(|error| error.to_string())).sum()
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
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn what_takes_much_memory_is_refused_before_it_is_read() {
        // A text that the file holds once, and that would stand in every row.
        let long = table(&"x".repeat(1 << 17));
        assert!(long.len() < 1 << 17, "{}", long.len());
        assert!(values(&long, None, |_| true).is_err_and(|why| why.contains("impossible size")));
        assert_eq!(values(&long, None, |name| name != "text"), Ok(6000));
        // Lists may be of any length.
        let mut lists = ListBuilder::new(Int64Builder::new());
        (0..10).for_each(|_| lists.append_value([Some(1), None]));
        let lists: ArrayRef = Arc::new(lists.finish());
        let batch = RecordBatch::try_from_iter([("lists", lists)]).unwrap();
        let mut writer = ArrowWriter::try_new(Vec::new(), batch.schema(), None).unwrap();
        writer.write(&batch).unwrap();
        let lists = writer.into_inner().unwrap();
        assert!(values(&lists, None, |_| true).is_err_and(|why| why.contains("groups or lists")));
    }

    #[test]
    fn forged_tables_are_read_or_refused() {
        let sound = [table("word"), table("another")];
        assert_bounded("files::foreign::tests::forged_tables_are_read_or_refused", &sound, 3000, |bytes| {
            values(&bytes, None, |_| true).map(drop)
        });
    }
}
