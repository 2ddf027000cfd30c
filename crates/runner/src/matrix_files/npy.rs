//! Arrays of NumPy, in files of their own (.npy) and inside .npz.

use std::io::{BufReader, Read};

use super::entries::{Entries, Symmetry, most_entries, square};
use super::error::{Problem, quoted};
use super::matrix::{ReadMatrix, Stored};
use super::numbers::{self, Kind, Order, ended};
use super::source::Source;

/// The first bytes.
pub const MAGIC: &[u8] = b"\x93NUMPY";

/// Longest header.
const LONGEST_HEADER: usize = 1 << 16;

/// Most dimensions.
const MOST_DIMENSIONS: usize = 32;

/// What an array has in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Content {
    Numbers(Kind, Order),
    /// Text of so many characters, of so many bytes each.
    Text {
        characters: u64,
        width: u64,
    },
    Other(String),
}

/// What the header of an array says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    pub content: Content,
    pub is_by_columns: bool,
    pub shape: Vec<u64>,
    /// Bytes before the numbers.
    length: u64,
}

impl Header {
    /// Reads the header of an array that should have `most` bytes at most.
    pub fn read(from: &mut dyn Read, most: u64) -> Result<Self, Problem> {
        let mut start = [0; 8];
        from.read_exact(&mut start).map_err(|error| ended(&error))?;
        let mut width = [0; 4];
        let counted = match (start.starts_with(MAGIC), start[6]) {
            (true, 1) => 2,
            (true, 2 | 3) => 4,
            (true, version) => return Err(Problem::new(format!("the array is of version {version}; 1 to 3 are read"))),
            _ => return Err(Problem::new("this is no array of NumPy")),
        };
        from.read_exact(&mut width[..counted]).map_err(|error| ended(&error))?;
        let length = u32::from_le_bytes(width) as usize;
        if length > LONGEST_HEADER {
            let text = format!("the header of the array has {length} bytes; the limit is {LONGEST_HEADER}");
            return Err(Problem::new(text));
        }
        let mut text = vec![0; length];
        from.read_exact(&mut text).map_err(|error| ended(&error))?;
        let header = Self::parsed(&String::from_utf8_lossy(&text), (8 + counted + length) as u64)?;
        let due = header.bytes();
        if most.checked_sub(header.length).is_none_or(|most| due.is_some_and(|due| due > most)) {
            let text = format!(
                "an array of shape {:?} does not fit {most} bytes; the file is cut off or damaged",
                header.shape
            );
            return Err(Problem::new(text));
        }
        Ok(header)
    }

    /// A header is a dictionary of Python with three keys.
    fn parsed(text: &str, length: u64) -> Result<Self, Problem> {
        let wrong = || Problem::new(format!("the header of the array is not understood: {}", quoted(text.trim())));
        let after = |key: &str| {
            let (_, rest) = text.split_once(&format!("'{key}'"))?;
            Some(rest.trim_start().strip_prefix(':')?.trim_start())
        };
        let order = after("fortran_order").ok_or_else(wrong)?;
        let is_by_columns = order.starts_with("True");
        let descr = after("descr").ok_or_else(wrong)?;
        let content = match descr.strip_prefix('\'').and_then(|rest| rest.split_once('\'')) {
            Some((name, _)) => content(name),
            None => Content::Other("fields with names".to_owned()),
        };
        let shape = after("shape").and_then(|rest| rest.strip_prefix('(')?.split_once(')')).ok_or_else(wrong)?.0;
        let sizes = shape.split(',').map(|size| size.trim().trim_end_matches('L')).filter(|size| !size.is_empty());
        let shape: Vec<u64> = sizes.map(|size| size.parse().map_err(|_| wrong())).collect::<Result<_, _>>()?;
        if shape.len() > MOST_DIMENSIONS {
            return Err(wrong());
        }
        Ok(Self { content, is_by_columns, shape, length })
    }

    /// The number of elements.
    pub fn count(&self) -> u64 {
        self.shape.iter().fold(1, |product, size| product.saturating_mul(*size))
    }

    fn bytes(&self) -> Option<u64> {
        match self.content {
            Content::Numbers(kind, _) => Some(self.count().saturating_mul(kind.width() as u64)),
            Content::Text { characters, width } => Some(self.count().saturating_mul(characters).saturating_mul(width)),
            Content::Other(_) => None,
        }
    }

    /// Why it is no matrix.
    pub fn problem(&self) -> Option<String> {
        match &self.content {
            Content::Other(what) => Some(format!("it has {what}, not real numbers")),
            Content::Text { .. } => Some("it is a text".to_owned()),
            Content::Numbers(..) if self.shape.len() != 2 => {
                Some(format!("it has {} dimensions, not the two of a matrix", self.shape.len()))
            }
            Content::Numbers(..) => None,
        }
    }

    /// Gives all numbers to `take`, in the order of the file.
    pub fn each(&self, from: &mut dyn Read, take: impl FnMut(f64) -> Result<(), Problem>) -> Result<(), Problem> {
        match &self.content {
            Content::Numbers(kind, order) => numbers::each(from, *kind, *order, self.count(), take),
            _ => Err(Problem::new(self.problem().unwrap_or_default())),
        }
    }
}

fn content(name: &str) -> Content {
    let (order, rest) = match name.as_bytes() {
        [b'>', ..] => (Order::Big, name.get(1..)),
        [b'<' | b'|' | b'=', ..] => (Order::Little, name.get(1..)),
        _ => (Order::Little, Some(name)),
    };
    let kind = match rest.unwrap_or_default() {
        "i1" => Kind::I8,
        "u1" | "b1" => Kind::U8,
        "i2" => Kind::I16,
        "u2" => Kind::U16,
        "i4" => Kind::I32,
        "u4" => Kind::U32,
        "i8" => Kind::I64,
        "u8" => Kind::U64,
        "f4" => Kind::F32,
        "f8" => Kind::F64,
        text if text.starts_with(['S', 'U', 'a']) => {
            return match text[1..].parse() {
                Ok(characters) => Content::Text { characters, width: if text.starts_with('U') { 4 } else { 1 } },
                Err(_) => Content::Other(format!("elements of the type {}", quoted(name))),
            };
        }
        "c8" | "c16" => return Content::Other("complex numbers".to_owned()),
        "O" => return Content::Other("objects of Python".to_owned()),
        _ => return Content::Other(format!("elements of the type {}", quoted(name))),
    };
    Content::Numbers(kind, order)
}

/// The matrix of a .npy file.
pub fn read_file(source: &mut Source) -> Result<ReadMatrix, Problem> {
    source.seek(0)?;
    read(&mut BufReader::new(&source.file), source.length, source.length)
}

/// A full matrix in an array of `most` bytes, from a file of this length.
pub fn read(from: &mut dyn Read, most: u64, length: u64) -> Result<ReadMatrix, Problem> {
    let header = Header::read(from, most)?;
    let (None, &[rows, columns]) = (header.problem(), &header.shape[..]) else {
        return Err(Problem::new(header.problem().unwrap_or_default()));
    };
    let size = square(rows, columns)?;
    let mut entries = Entries::at_most(most_entries(size, length));
    // The index that runs first.
    let (mut fast, mut slow) = (0, 0);
    header.each(from, |value| {
        if value != 0.0 {
            let (row, column) = if header.is_by_columns { (fast, slow) } else { (slow, fast) };
            entries.push(row, column, value)?;
        }
        fast += 1;
        if fast as usize == size {
            (fast, slow) = (0, slow + 1);
        }
        Ok(())
    })?;
    Ok(ReadMatrix::new(entries.into_matrix(size, Symmetry::None)?, Stored::General))
}
