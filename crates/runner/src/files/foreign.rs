//! Parquet files that anybody may have written. Their names and checksums say nothing, as they follow from the content.
//!
//! The library that decodes them allocates what a file announces, and panics on some files. So everything that announces
//! a size is compared with the size of the file first, and a panic becomes an error.

use std::collections::VecDeque;
use std::fs::File;

use bytes::Bytes;
use parquet::file::reader::ChunkReader;

use super::decode::ReadTable;
use super::thrift::{Value, fields};
use crate::panics::caught;

/// The first and the last bytes of a Parquet file.
const MAGIC: &[u8; 4] = b"PAR1";

/// Length of the last bytes: the length of the description, and [`MAGIC`].
const TAIL: u64 = 8;

/// Largest number of values in the description of a file: more than a surface of [`MOST_COLUMNS`] columns has.
const MOST_DESCRIBED: usize = 1 << 23;

/// Largest number of columns, and of groups of columns around them.
const MOST_COLUMNS: usize = 10_000;

/// Deepest nesting of columns. A list has two levels.
const DEEPEST: usize = 8;

/// The header of a page is sought in this many bytes first, and then in as many as one may have.
const HEADERS: [u64; 2] = [4096, 1 << 20];

/// Largest number of values of a byte of the file: repeated ones take a small part of a byte.
const DENSEST: u64 = 256;

/// Largest ratio of a page to its compressed form: Snappy makes at most 64 bytes of three.
const TIGHTEST: i64 = 24;

/// Largest page. Ours have about a megabyte.
const LARGEST_PAGE: i64 = 1 << 28;

/// Largest number of values in the columns that are read of a file without a number of rows that is known: less
/// than a gigabyte in memory.
const MOST_VALUES: u64 = 1 << 25;

/// Largest number of values in a row of a surface.
const WIDEST: u64 = 4096;

/// What is known of a file before it is read.
#[derive(Debug, Clone, Copy)]
pub enum Known {
    /// Pieces: nothing but the types of their columns.
    Piece,
    /// Tables, whose columns have descriptions: the number of rows, if that is known.
    Table(Option<u64>),
}

/// Reads the columns of a Parquet file that are wanted, after everything that it says of itself was checked.
///
/// # Errors
/// Why the file cannot be read, whatever it holds.
pub fn read<R: ChunkReader + 'static>(
    file: R,
    known: Known,
    wanted: impl Fn(&str) -> bool,
) -> Result<ReadTable, String> {
    caught(|| {
        let columns = check(&file, known, &wanted)?;
        ReadTable::read(file, &columns)
    })
}

/// The text that the description of a Parquet file holds under a key; `None` where it is none, or has no such key.
pub fn text_of_key(file: &File, key: &str) -> Option<String> {
    let description = description(file).ok()?;
    let (description, _) = fields(&description, MOST_DESCRIBED)?;
    let pair = description.list(5).iter().find(|pair| pair.bytes(1) == Some(key.as_bytes()))?;
    String::from_utf8(pair.bytes(2)?.to_vec()).ok()
}

/// The bytes in which a Parquet file describes itself.
fn description<R: ChunkReader>(file: &R) -> Result<Bytes, String> {
    let length = file.len();
    let start = TAIL + MAGIC.len() as u64;
    if length < start {
        return Err("it is no Parquet file".to_owned());
    }
    let bytes = |at: u64, length: u64| file.get_bytes(at, length as usize).map_err(|error| error.to_string());
    let tail = bytes(length - TAIL, TAIL)?;
    if bytes(0, 4)?[..] != MAGIC[..] || tail[4..] != MAGIC[..] {
        return Err("it is no Parquet file".to_owned());
    }
    let described = tail[..4].iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte));
    if described > length - start {
        return Err("its description is longer than the file".to_owned());
    }
    bytes(length - TAIL - described, described)
}

/// Checks a file, and returns the places of the wanted columns.
fn check<R: ChunkReader>(file: &R, known: Known, wanted: &impl Fn(&str) -> bool) -> Result<Vec<usize>, String> {
    let length = file.len();
    let bytes = description(file)?;
    let (described, _) = fields(&bytes, MOST_DESCRIBED).ok_or("its description cannot be read")?;
    if described.field(8).is_some() {
        return Err("it is encrypted".to_owned());
    }
    let leaves = leaves(described.list(2)).ok_or("the description of its columns cannot be read")?;
    let rows = described.number(3).and_then(|rows| u64::try_from(rows).ok()).ok_or("its number of rows is negative")?;
    let (most_rows, most_values) = match known {
        Known::Table(Some(rows)) => (rows, rows.saturating_mul(WIDEST)),
        Known::Table(None) | Known::Piece => (length.saturating_mul(DENSEST), MOST_VALUES),
    };
    if rows > most_rows {
        return Err(match known {
            Known::Table(Some(expected)) => format!("it has {rows} rows, not {expected}"),
            _ => format!("it has {rows} rows in {length} bytes, which is not possible"),
        });
    }
    let (mut all_rows, mut all_values, mut all_bytes) = (0_u64, 0_u64, 0_u64);
    for group in described.list(4) {
        let chunks = group.list(1);
        let rows = group.number(3).and_then(|rows| u64::try_from(rows).ok()).ok_or("a number of rows is negative")?;
        all_rows = all_rows.checked_add(rows).ok_or("its numbers of rows do not add up")?;
        if chunks.len() != leaves.len() {
            return Err("a group of rows does not have every column".to_owned());
        }
        for (chunk, leaf) in chunks.iter().zip(&leaves) {
            let column = Column::of(chunk, leaf, rows, length)?;
            all_bytes = all_bytes.saturating_add(column.bytes);
            if wanted(leaf.root_name) {
                all_values = all_values.saturating_add(column.values);
                column.check_pages(file)?;
            }
        }
    }
    if all_rows != rows {
        return Err("its numbers of rows do not add up".to_owned());
    }
    if all_bytes > length {
        return Err("its columns are longer than the file".to_owned());
    }
    if all_values > most_values {
        return Err(format!("it has {all_values} values; the limit is {most_values}"));
    }
    let mut places: Vec<usize> = leaves.iter().filter(|leaf| wanted(leaf.root_name)).map(|leaf| leaf.root).collect();
    places.dedup();
    Ok(places)
}

/// A column as the description of a file gives it.
struct Leaf<'a> {
    /// The place of the outermost group that it is in, or its own.
    root: usize,
    /// The name of that.
    root_name: &'a str,
    /// The number of its type.
    kind: i64,
    /// Whether a row may have several values.
    is_repeated: bool,
}

/// The columns of a description: each group of columns is followed by its members. `None` if they do not fit together.
fn leaves<'a>(elements: &'a [Value<'a>]) -> Option<Vec<Leaf<'a>>> {
    let (root, elements) = elements.split_first()?;
    if elements.len() > MOST_COLUMNS {
        return None;
    }
    let roots = root.number(5)?;
    // How many members are still to come of each group around, and whether they are repeated.
    let mut around: VecDeque<(i64, bool)> = VecDeque::from([(roots, false)]);
    let mut leaves = Vec::new();
    let mut outermost = (0, "");
    let mut next = 0;
    for element in elements {
        while around.back().is_some_and(|(left, _)| *left == 0) {
            around.pop_back();
        }
        let depth = around.len();
        let (left, is_repeated) = around.back_mut()?;
        *left = left.checked_sub(1).filter(|left| *left >= 0)?;
        let is_repeated = *is_repeated || element.number(3) == Some(2);
        if depth == 1 {
            outermost = (next, std::str::from_utf8(element.bytes(4)?).ok()?);
            next += 1;
        }
        match element.number(5).unwrap_or(0) {
            0 => leaves.push(Leaf { root: outermost.0, root_name: outermost.1, kind: element.number(1)?, is_repeated }),
            members if members > 0 && depth < DEEPEST => around.push_back((members, is_repeated)),
            _ => return None,
        }
    }
    around.iter().all(|(left, _)| *left == 0).then_some(leaves)
}

/// The values of a column in a group of rows.
struct Column {
    values: u64,
    start: u64,
    bytes: u64,
    is_compressed: bool,
    /// Bytes that a value takes without compression, at least.
    width: i64,
}

impl Column {
    fn of(chunk: &Value<'_>, leaf: &Leaf<'_>, rows: u64, length: u64) -> Result<Self, String> {
        let wrong = || format!("column {} cannot be read", leaf.root_name);
        let described = chunk.field(3).ok_or_else(wrong)?;
        let number = |field: i16| described.number(field).and_then(|number| u64::try_from(number).ok());
        let is_elsewhere = chunk.field(1).is_some() || chunk.field(8).is_some() || chunk.field(9).is_some();
        let codec = described.number(4).ok_or_else(wrong)?;
        if is_elsewhere || described.number(1) != Some(leaf.kind) {
            return Err(wrong());
        }
        if !(0..=1).contains(&codec) {
            return Err(format!("column {} is compressed in another way than Snappy", leaf.root_name));
        }
        let (values, bytes) = (number(5).ok_or_else(wrong)?, number(7).ok_or_else(wrong)?);
        let first = number(9).ok_or_else(wrong)?;
        let start = match described.field(11) {
            Some(_) => number(11).ok_or_else(wrong)?,
            None => first,
        };
        let is_inside = start.checked_add(bytes).is_some_and(|end| end <= length - TAIL) && start <= first;
        let is_consistent = if leaf.is_repeated { values >= rows } else { values == rows };
        if !is_inside || !is_consistent {
            return Err(wrong());
        }
        let width = match leaf.kind {
            // Bits, and texts of a length that stands in the description.
            0 | 7 => 0,
            1 | 4 | 6 => 4,
            2 | 5 => 8,
            3 => 12,
            _ => return Err(wrong()),
        };
        Ok(Self { values, start, bytes, is_compressed: codec == 1, width })
    }

    /// Checks that the pages fill the bytes of the column and hold as many values as they should.
    fn check_pages<R: ChunkReader>(&self, file: &R) -> Result<(), String> {
        let (mut at, mut left, mut values, mut is_first) = (self.start, self.bytes, 0_u64, true);
        while left > 0 {
            let page = Page::at(file, at, left)?;
            let length = page.header + page.compressed;
            if length > left {
                return Err("a page is longer than its column".to_owned());
            }
            values = values.saturating_add(self.values_of(&page, is_first)?);
            (at, left, is_first) = (at + length, left - length, false);
        }
        if values == self.values { Ok(()) } else { Err("the values of its pages do not add up".to_owned()) }
    }

    /// The number of values of a page, if it is in order. A dictionary is not counted.
    fn values_of(&self, page: &Page, is_first: bool) -> Result<u64, String> {
        let wrong = || "a page cannot be read".to_owned();
        let size = page.uncompressed;
        let compressed = page.compressed.cast_signed();
        let fits = match self.is_compressed {
            true => size <= compressed.saturating_mul(TIGHTEST).saturating_add(64),
            false => size == compressed,
        };
        if !fits || !(0..=LARGEST_PAGE).contains(&size) || page.values < 0 {
            return Err("a page has an impossible size".to_owned());
        }
        let is_known = if page.is_dictionary {
            is_first && matches!(page.encoding, 0 | 2) && page.values.saturating_mul(self.width) <= size
        } else {
            // Plain, or in a dictionary; and lengths of runs, for bits.
            matches!(page.encoding, 0 | 2 | 3 | 8)
        };
        if !is_known {
            return Err(wrong());
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
    fn at<R: ChunkReader>(file: &R, at: u64, left: u64) -> Result<Self, String> {
        for length in HEADERS {
            let bytes = file.get_bytes(at, length.min(left) as usize).map_err(|error| error.to_string())?;
            if let Some((header, length)) = fields(&bytes, MOST_DESCRIBED) {
                return Self::of(&header, length as u64).ok_or_else(|| "a page cannot be read".to_owned());
            }
            if length >= left {
                break;
            }
        }
        Err("the header of a page cannot be read".to_owned())
    }

    fn of(header: &Value<'_>, length: u64) -> Option<Self> {
        const RUNS: Option<i64> = Some(3);
        let (kind, is_dictionary) = (header.number(1)?, header.number(1)? == 2);
        let of_kind = header.field(match kind {
            0 => 5,
            2 => 7,
            3 => 8,
            _ => return None,
        })?;
        let encoding = of_kind.number(if kind == 3 { 4 } else { 2 })?;
        let are_levels_known = match kind {
            0 => of_kind.number(3) == RUNS && of_kind.number(4) == RUNS,
            3 => {
                let lengths = [of_kind.number(5)?, of_kind.number(6)?];
                let sum = lengths[0].checked_add(lengths[1])?;
                lengths.iter().all(|length| *length >= 0) && sum <= header.number(2)? && sum <= header.number(3)?
            }
            _ => true,
        };
        are_levels_known.then_some(Self {
            header: length,
            compressed: u64::try_from(header.number(3)?).ok()?,
            uncompressed: header.number(2)?,
            values: of_kind.number(1)?,
            encoding,
            is_dictionary,
        })
    }
}
