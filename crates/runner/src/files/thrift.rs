//! How long a structure of Parquet is, and the numbers at its top. The library keeps its own reading of page headers to
//! itself, and takes every number in a description at its word.
//!
//! Parquet describes itself in the compact encoding of Thrift. Nothing is allocated here for what a file announces.

/// Deepest nesting. The description of a Parquet file has about ten levels.
const DEEPEST: u32 = 24;

/// The type of structures.
const FIELDS: u8 = 12;

/// A structure that was walked through.
pub struct Structure {
    /// Its length in bytes.
    pub length: usize,
    /// Its whole numbers and those of the structures in it, with the number of the field there and in it (0 for its own
    /// numbers). The structures of a list follow each other.
    numbers: Vec<([i16; 2], i64)>,
}

impl Structure {
    /// The structure at the start of `bytes`, of at most `most` values; `None` if it is incomplete or wrong.
    pub fn at_start(bytes: &[u8], most: usize) -> Option<Self> {
        let mut walk = Walk { rest: bytes, left: most, numbers: Vec::new() };
        walk.value(FIELDS, Some([0, 0]), 0)?;
        Some(Self { length: bytes.len() - walk.rest.len(), numbers: walk.numbers })
    }

    /// All numbers in the fields of this path.
    pub fn numbers(&self, path: [i16; 2]) -> impl Iterator<Item = i64> {
        self.numbers.iter().filter(move |(other, _)| *other == path).map(|(_, number)| *number)
    }

    /// The number in the field of this path.
    pub fn number(&self, path: [i16; 2]) -> Option<i64> {
        self.numbers(path).next()
    }
}

struct Walk<'a> {
    rest: &'a [u8],
    /// How many more values there may be.
    left: usize,
    numbers: Vec<([i16; 2], i64)>,
}

impl Walk<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (&byte, rest) = self.rest.split_first()?;
        self.rest = rest;
        Some(byte)
    }

    fn skip(&mut self, length: u64) -> Option<()> {
        self.rest = self.rest.get(usize::try_from(length).ok()?..)?;
        Some(())
    }

    /// A whole number of up to ten bytes, seven bits in each.
    fn unsigned(&mut self) -> Option<u64> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Some(number);
            }
        }
        None
    }

    fn signed(&mut self) -> Option<i64> {
        let number = self.unsigned()?;
        Some((number >> 1).cast_signed() ^ -((number & 1).cast_signed()))
    }

    /// Walks through a value of a type, whose path is not too long to be kept. Types that Parquet does not have are wrong.
    fn value(&mut self, kind: u8, path: Option<[i16; 2]>, depth: u32) -> Option<()> {
        self.left = self.left.checked_sub(1)?;
        if depth > DEEPEST {
            return None;
        }
        match kind {
            3 => self.skip(1),
            4..=6 => {
                let number = self.signed()?;
                self.numbers.extend(path.map(|path| (path, number)));
                Some(())
            }
            7 => self.skip(8),
            8 => {
                let length = self.unsigned()?;
                self.skip(length)
            }
            9 => {
                let header = self.byte()?;
                let length = if header >> 4 == 15 { self.unsigned()? } else { u64::from(header >> 4) };
                (0..length).try_for_each(|_| self.value(header & 15, path, depth + 1))
            }
            FIELDS => self.fields(path, depth),
            _ => None,
        }
    }

    /// Walks through the fields of a structure, each of which has a higher number than the one before.
    fn fields(&mut self, path: Option<[i16; 2]>, depth: u32) -> Option<()> {
        let mut number = 0_i16;
        loop {
            let header = self.byte()?;
            if header == 0 {
                return Some(());
            }
            let before = number;
            number = match header >> 4 {
                0 => i16::try_from(self.signed()?).ok().filter(|number| *number > before)?,
                step => number.checked_add(step.into())?,
            };
            // True and false are in the type.
            if !matches!(header & 15, 1 | 2) {
                let path = match path {
                    Some([0, 0]) => Some([number, 0]),
                    Some([outer, 0]) => Some([outer, number]),
                    _ => None,
                };
                self.value(header & 15, path, depth + 1)?;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_by_their_path() {
        // Field 1: -3; field 3: true; field 4: "ab"; field 5: structures with 1 and 2 in their field 2; field 30: fields
        // of which 2 is 1.
        let bytes =
            [0x15, 5, 0x21, 0x18, 2, b'a', b'b', 0x19, 0x2c, 0x25, 2, 0, 0x25, 4, 0, 0x0c, 60, 0x25, 2, 0, 0, 9];
        let structure = Structure::at_start(&bytes, 100).unwrap();
        assert_eq!(structure.length, bytes.len() - 1);
        assert_eq!(
            (structure.number([1, 0]), structure.number([30, 2]), structure.number([2, 0])),
            (Some(-3), Some(1), None)
        );
        assert_eq!(structure.numbers([5, 2]).collect::<Vec<_>>(), [1, 2]);
        assert!(Structure::at_start(&bytes, 5).is_none(), "more values than are allowed");
        assert!((0..structure.length).all(|end| Structure::at_start(&bytes[..end], 100).is_none()), "incomplete");
        assert!(Structure::at_start(&[0x15, 2, 0x05, 2, 2, 0], 100).is_none(), "a field twice");
    }

    #[test]
    fn what_is_longer_than_its_bytes_is_refused() {
        for bytes in [
            // A list of 2^31 structures, one of flags, a text of 2^40 bytes, a map, and fields and lists without end.
            vec![0x19, 0xfc, 0x80, 0x80, 0x80, 0x80, 8, 0],
            vec![0x19, 0xf1, 0x80, 0x80, 0x80, 0x80, 8, 0],
            vec![0x18, 0x80, 0x80, 0x80, 0x80, 0x80, 0x20, 0],
            vec![0x1b, 0x80, 0x80, 0x80, 0x80, 0x80, 0x20, 0],
            vec![0x1c; 100_000],
            vec![0x19; 100_000],
        ] {
            assert!(Structure::at_start(&bytes, 1 << 20).is_none());
        }
    }
}
