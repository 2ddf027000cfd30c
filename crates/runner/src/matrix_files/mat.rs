//! MAT files of MATLAB, versions 5 to 7: full and sparse real matrices, compressed or not, of this byte order.
//!
//! MATLAB MAT-File Format, The MathWorks (2023): a header of 128 bytes, then data elements, each a type, a size and its
//! bytes. An array is an element of elements: flags, dimensions, name, and its values.

use std::io::Read as _;

use flate2::read::ZlibDecoder;

use super::{Entries, Matrix};

/// Types of data elements.
const ARRAY: u32 = 14;
const COMPRESSED: u32 = 15;

/// Classes of arrays.
const CELL: u8 = 1;
const STRUCT: u8 = 2;
const TEXT: u8 = 4;
const SPARSE: u8 = 5;
const FIRST_NUMERIC: u8 = 6;
const LAST_NUMERIC: u8 = 15;

/// How many times larger than its file a compressed array may be.
const LARGEST_RATIO: u64 = 1100;

/// Reads the matrix of this name.
pub(super) fn read(bytes: &[u8], name: Option<&str>) -> Result<Matrix, String> {
    if bytes.len() < 128 || &bytes[126..128] != b"IM" {
        if bytes.len() >= 128 && &bytes[126..128] == b"MI" {
            return Err("this MAT file has the byte order of another processor; save it again on this one".to_owned());
        }
        return Err(
            "this is no file of matrices that is known: MAT files of versions 5 to 7 and Matrix Market are read"
                .to_owned(),
        );
    }
    let mut rest = &bytes[128..];
    let mut names = Vec::new();
    while !rest.is_empty() {
        let (kind, content, after) = element(rest)?;
        rest = after;
        let unpacked;
        let array = match kind {
            COMPRESSED => {
                unpacked = unpack(content)?;
                let (kind, content, _) = element(&unpacked)?;
                if kind != ARRAY {
                    continue;
                }
                content
            }
            ARRAY => content,
            _ => continue,
        };
        let array = Array::new(array)?;
        if name == Some(&array.name) {
            return array.matrix().map_err(|message| format!("matrix {}: {message}", array.name));
        }
        names.push(array.name);
    }
    match (name, &names[..]) {
        (_, []) => Err("the file has no matrices".to_owned()),
        (None, [only]) => read(bytes, Some(only)),
        (None, _) => {
            Err(format!("the file has several matrices; say which with matrix = \"...\": {}", names.join(", ")))
        }
        (Some(name), _) => Err(format!("there is no matrix `{name}` (there are {})", names.join(", "))),
    }
}

fn unpack(content: &[u8]) -> Result<Vec<u8>, String> {
    let mut unpacked = Vec::new();
    let most = LARGEST_RATIO * content.len() as u64 + 1024;
    let read = ZlibDecoder::new(content).take(most).read_to_end(&mut unpacked);
    read.map_err(|error| format!("a compressed matrix is damaged: {error}"))?;
    Ok(unpacked)
}

/// The element that begins here: its type, its bytes, and what follows.
fn element(bytes: &[u8]) -> Result<(u32, &[u8], &[u8]), String> {
    const CUT: &str = "the file ends within a matrix: it is cut off or damaged";
    let word = |at: usize| -> Result<u32, String> {
        let word = bytes.get(at..at + 4).and_then(|word| word.try_into().ok()).ok_or(CUT)?;
        Ok(u32::from_le_bytes(word))
    };
    let first = word(0)?;
    // Up to four bytes stand in the tag itself.
    if first >> 16 != 0 {
        let size = (first >> 16) as usize;
        let content = bytes.get(4..4 + size).filter(|_| size <= 4).ok_or(CUT)?;
        return Ok((first & 0xffff, content, bytes.get(8..).unwrap_or_default()));
    }
    let size = word(4)? as usize;
    let content = bytes.get(8..).and_then(|rest| rest.get(..size)).ok_or(CUT)?;
    // Compressed elements are not padded.
    let padded = if first == COMPRESSED { size } else { size.next_multiple_of(8) };
    Ok((first, content, bytes.get(8 + padded..).unwrap_or_default()))
}

/// An array of a file.
struct Array<'a> {
    class: u8,
    is_complex: bool,
    dimensions: Vec<u64>,
    name: String,
    /// The elements of its values.
    values: &'a [u8],
    entries_possible: u64,
}

impl<'a> Array<'a> {
    fn new(content: &'a [u8]) -> Result<Self, String> {
        let (_, flags, rest) = element(content)?;
        let [class, flag, ..] = flags else { return Err("a matrix has no flags: the file is damaged".to_owned()) };
        let (kind, dimensions, rest) = element(rest)?;
        let dimensions = integers(kind, dimensions)?;
        let (_, name, values) = element(rest)?;
        Ok(Self {
            class: *class,
            is_complex: flag & 8 != 0,
            dimensions,
            name: String::from_utf8_lossy(name).chars().filter(|c| !c.is_control()).collect(),
            values,
            entries_possible: values.len() as u64,
        })
    }

    fn matrix(&self) -> Result<Matrix, String> {
        match self.class {
            CELL => return Err("this is a cell array; save the matrix in it under a name of its own".to_owned()),
            STRUCT => return Err("this is a struct; save its field as a matrix of its own, K = s.K".to_owned()),
            TEXT => return Err("this is a text".to_owned()),
            SPARSE | FIRST_NUMERIC..=LAST_NUMERIC => {}
            other => return Err(format!("this is no matrix (class {other})")),
        }
        if self.is_complex {
            return Err("the matrix is complex; matrices of a model are real".to_owned());
        }
        let [rows, columns] = self.dimensions[..] else {
            return Err(format!("the array has {} dimensions; a matrix has 2", self.dimensions.len()));
        };
        let matrix = if self.class == SPARSE { self.sparse(rows, columns)? } else { self.full(rows, columns)? };
        matrix.matrix()
    }

    fn full(&self, rows: u64, columns: u64) -> Result<Entries, String> {
        let (kind, values, _) = element(self.values)?;
        let values = numbers(kind, values)?;
        let mut entries = Entries::new(rows, columns, 0, 0)?;
        if rows.checked_mul(columns) != Some(values.len() as u64) {
            return Err(format!(
                "the matrix is {rows} by {columns}, but has {} values: the file is damaged",
                values.len()
            ));
        }
        for (i, value) in values.into_iter().enumerate().filter(|(_, value)| *value != 0.0) {
            entries.add(i as u64 % rows, i as u64 / rows, value)?;
        }
        Ok(entries)
    }

    fn sparse(&self, rows: u64, columns: u64) -> Result<Entries, String> {
        let (kind, row_indices, rest) = element(self.values)?;
        let row_indices = integers(kind, row_indices)?;
        let (kind, starts, rest) = element(rest)?;
        let starts = integers(kind, starts)?;
        let (kind, values, _) = element(rest)?;
        let values = numbers(kind, values)?;
        if starts.len() as u64 != columns + 1 {
            return Err(format!(
                "the matrix has {columns} columns, but {} starts of columns: the file is damaged",
                starts.len()
            ));
        }
        let mut entries = Entries::new(rows, columns, values.len() as u64, self.entries_possible as usize)?;
        for (column, ends) in starts.windows(2).enumerate() {
            let range = usize::try_from(ends[0]).ok().zip(usize::try_from(ends[1]).ok());
            let (rows, values) = range
                .and_then(|(from, to)| Some((row_indices.get(from..to)?, values.get(from..to)?)))
                .ok_or("the columns of the matrix have more entries than there are: the file is damaged")?;
            for (row, value) in rows.iter().zip(values) {
                entries.add(*row, column as u64, *value)?;
            }
        }
        Ok(entries)
    }
}

/// Values of any type of number.
fn numbers(kind: u32, bytes: &[u8]) -> Result<Vec<f64>, String> {
    macro_rules! all {
        ($type:ty) => {{
            const SIZE: usize = size_of::<$type>();
            let chunks = bytes.chunks_exact(SIZE).filter_map(|chunk| <[u8; SIZE]>::try_from(chunk).ok());
            chunks.map(|chunk| <$type>::from_le_bytes(chunk) as f64).collect()
        }};
    }
    Ok(match kind {
        1 => all!(i8),
        2 => all!(u8),
        3 => all!(i16),
        4 => all!(u16),
        5 => all!(i32),
        6 => all!(u32),
        7 => all!(f32),
        9 => all!(f64),
        12 => all!(i64),
        13 => all!(u64),
        other => return Err(format!("values have the unknown type {other}: the file is damaged")),
    })
}

/// Values that must be whole and not negative.
fn integers(kind: u32, bytes: &[u8]) -> Result<Vec<u64>, String> {
    let whole = |value: f64| {
        let is_whole = value >= 0.0 && value.fract() == 0.0 && value < 9e15;
        is_whole.then_some(value as u64).ok_or_else(|| format!("{value} is no size or index: the file is damaged"))
    };
    numbers(kind, bytes)?.into_iter().map(whole).collect()
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use super::super::read;

    fn shipped(name: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../jobs/tu-brake").join(name)
    }

    /// The numbers of entries are those that its authors print (Graebner et al., ZAMM 96 (2016) 1388).
    #[test]
    fn the_brake_of_tu_berlin_has_the_entries_that_its_authors_print() {
        let path = shipped("tu-brake.mat");
        for (name, entries) in [
            ("M", 93_207),
            ("D1", 5683),
            ("DG", 66_643),
            ("DR", 5683),
            ("D4", 23_885),
            ("K1", 280_845),
            ("KR", 21_646),
            ("KGEO", 280_871),
        ] {
            let read = read(&path, Some(name)).unwrap();
            assert_eq!([read.nrows(), read.ncols()], [4669; 2]);
            assert_eq!(read.compute_nnz(), entries, "{name}");
        }
        let error = read(&path, Some("K7")).unwrap_err().to_string();
        assert!(error.contains("there is no matrix `K7` (there are ") && error.contains("KGEO"), "{error}");
        assert!(read(&path, None).unwrap_err().to_string().contains("say which with matrix"));
    }

    #[test]
    fn damaged_files_are_refused_and_never_end_in_a_panic() {
        let whole = std::fs::read(shipped("disk_brake100.mat")).unwrap();
        let mut state = 7_u64;
        let mut next = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        let name = super::super::mat::read(&whole, None).unwrap_err();
        let first = name.rsplit(": ").next().unwrap().split(", ").next().unwrap().to_owned();
        for _ in 0..300 {
            let mut bytes = whole.clone();
            for _ in 0..1 + next(4) {
                let at = 128 + next(bytes.len() - 128);
                bytes[at] = next(256) as u8;
            }
            bytes.truncate(bytes.len() - next(2) * next(bytes.len() / 2));
            drop(super::read(&bytes, Some(&first)));
        }
    }
}
