//! Elements of a MAT file: a type, a length, and that many bytes.

use std::fs::File;
use std::io::{BufReader, Read, Take};

use flate2::bufread::ZlibDecoder;

use crate::matrix_files::error::Problem;
use crate::matrix_files::numbers::{self, Kind, Order, TIGHTEST, ended};
use crate::matrix_files::source::Source;

const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// Length of type and length of an element.
const TAG: u64 = 8;

/// The content of the element of a variable.
pub struct Body<'a> {
    from: Box<dyn Read + 'a>,
    /// Bytes that it should still have.
    left: u64,
    pub order: Order,
    is_compressed: bool,
    is_matrix: bool,
}

/// An element inside a variable.
pub struct Element {
    pub kind: u32,
    pub length: u64,
    /// The content of a short element is in its tag.
    packed: Option<[u8; 4]>,
}

impl<'a> Body<'a> {
    /// The variable at a place of the file, and the place of the next.
    ///
    /// # Errors
    /// An element that is longer than the file.
    pub fn at(source: &'a mut Source, place: u64, order: Order) -> Result<(Self, u64), Problem> {
        let most = source.length.saturating_sub(place).saturating_sub(TAG);
        source.seek(place)?;
        let file: Take<&File> = (&source.file).take(most.saturating_add(TAG));
        let mut from = BufReader::with_capacity(1 << 16, file);
        let [kind, length] = pair(&mut from, order)?;
        check_length(u64::from(length), most)?;
        let next = place + TAG + u64::from(length);
        if kind != COMPRESSED {
            let from = Box::new(from);
            let body = Self { from, left: length.into(), order, is_compressed: false, is_matrix: kind == MATRIX };
            return Ok((body, next));
        }
        let mut from = ZlibDecoder::new(from.take(length.into()));
        let [kind, inside] = pair(&mut from, order)?;
        check_length(u64::from(inside), u64::from(length).saturating_mul(TIGHTEST))?;
        let body =
            Self { from: Box::new(from), left: inside.into(), order, is_compressed: true, is_matrix: kind == MATRIX };
        Ok((body, next))
    }

    /// Whether it is a variable at all.
    pub fn is_matrix(&self) -> bool {
        self.is_matrix
    }

    /// The next element inside.
    pub fn element(&mut self) -> Result<Element, Problem> {
        self.take(TAG)?;
        let [first, second] = pair(&mut self.from, self.order)?;
        if first >> 16 == 0 {
            check_length(second.into(), self.left)?;
            return Ok(Element { kind: first, length: second.into(), packed: None });
        }
        let packed = match self.order {
            Order::Little => second.to_le_bytes(),
            Order::Big => second.to_be_bytes(),
        };
        check_length((first >> 16).into(), 4)?;
        Ok(Element { kind: first & 0xffff, length: (first >> 16).into(), packed: Some(packed) })
    }

    /// The bytes of a short element.
    pub fn bytes(&mut self, element: &Element, most: u64) -> Result<Vec<u8>, Problem> {
        if element.length > most {
            return Err(Problem::new(format!(
                "a part of {} bytes should have {most} at most; the file is damaged",
                element.length
            )));
        }
        if let Some(packed) = element.packed {
            return Ok(packed[..element.length as usize].to_vec());
        }
        self.take(element.length)?;
        let mut bytes = vec![0; element.length as usize];
        self.from.read_exact(&mut bytes).map_err(|error| ended(&error))?;
        self.pad(element.length)?;
        Ok(bytes)
    }

    /// Gives the numbers of an element to `each`, at least `least` and at most `most` of them.
    pub fn numbers(
        &mut self,
        what: &str,
        [least, most]: [u64; 2],
        each: impl FnMut(f64) -> Result<(), Problem>,
    ) -> Result<(), Problem> {
        let element = self.element()?;
        let kind = kind(element.kind).ok_or_else(|| {
            Problem::new(format!("the {what} have numbers of the unknown type {}; the file is damaged", element.kind))
        })?;
        let width = kind.width() as u64;
        let count = element.length / width;
        if !element.length.is_multiple_of(width) || count < least || count > most {
            let range = if least == most { format!("{least}") } else { format!("{least} to {most}") };
            return Err(Problem::new(format!("there are {count} {what} where {range} are due; the file is damaged")));
        }
        if let Some(packed) = element.packed {
            return numbers::each(&mut &packed[..], kind, self.order, count, each);
        }
        self.take(element.length)?;
        numbers::each(&mut self.from, kind, self.order, count, each)?;
        self.pad(element.length)
    }

    fn take(&mut self, bytes: u64) -> Result<(), Problem> {
        check_length(bytes, self.left)?;
        self.left -= bytes;
        Ok(())
    }

    /// Skips what fills an element up to eight bytes. The last one may go without.
    fn pad(&mut self, length: u64) -> Result<(), Problem> {
        let padding = (length.next_multiple_of(TAG) - length).min(self.left);
        self.left -= padding;
        let mut bytes = [0; TAG as usize];
        self.from.read_exact(&mut bytes[..padding as usize]).map_err(|error| ended(&error))
    }

    /// Reads up to the end of compressed bytes, where their checksum is.
    pub fn finish(mut self) -> Result<(), Problem> {
        if !self.is_compressed {
            return Ok(());
        }
        let mut bytes = [0; 4096];
        loop {
            match self.from.read(&mut bytes).map_err(|error| ended(&error))? {
                0 => return Ok(()),
                read => self.take(read as u64)?,
            }
        }
    }
}

fn pair(from: &mut impl Read, order: Order) -> Result<[u32; 2], Problem> {
    let mut bytes = [[0; 4]; 2];
    from.read_exact(bytes.as_flattened_mut()).map_err(|error| ended(&error))?;
    Ok(bytes.map(|bytes| match order {
        Order::Little => u32::from_le_bytes(bytes),
        Order::Big => u32::from_be_bytes(bytes),
    }))
}

fn check_length(length: u64, most: u64) -> Result<(), Problem> {
    if length <= most {
        return Ok(());
    }
    Err(Problem::new(format!(
        "a part of the file should have {length} bytes, but there can be {most} at most; it is cut off or damaged"
    )))
}

fn kind(number: u32) -> Option<Kind> {
    Some(match number {
        1 => Kind::I8,
        2 => Kind::U8,
        3 => Kind::I16,
        4 => Kind::U16,
        5 => Kind::I32,
        6 => Kind::U32,
        7 => Kind::F32,
        9 => Kind::F64,
        12 => Kind::I64,
        13 => Kind::U64,
        _ => return None,
    })
}
