//! Numbers in binary files: their types, both orders of bytes.

use std::io::{self, Read};

use super::error::Problem;

/// Bytes that are read at a time. A multiple of the width of every type.
const CHUNK: usize = 1 << 16;

/// Largest ratio of a text to its compressed form that Deflate reaches.
pub const TIGHTEST: u64 = 1032;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    Little,
    Big,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Kind {
    /// Bytes of a number.
    pub fn width(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

/// Gives every one of `count` numbers to `take`. Nothing is allocated for numbers that do not come.
///
/// # Errors
/// A file that ends before them, and what `take` says.
pub fn each(
    from: &mut dyn Read,
    kind: Kind,
    order: Order,
    count: u64,
    mut take: impl FnMut(f64) -> Result<(), Problem>,
) -> Result<(), Problem> {
    let width = kind.width();
    let mut bytes = [0; CHUNK];
    let mut left = count;
    while left > 0 {
        let now = left.min((CHUNK / width) as u64) as usize;
        let chunk = &mut bytes[..now * width];
        from.read_exact(chunk).map_err(|error| ended(&error))?;
        chunk.chunks_exact(width).try_for_each(|bytes| take(decoded(kind, order, bytes)))?;
        left -= now as u64;
    }
    Ok(())
}

fn decoded(kind: Kind, order: Order, bytes: &[u8]) -> f64 {
    // Eight bytes, the lowest first.
    let mut lowest = [0; 8];
    match order {
        Order::Little => lowest.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from),
        Order::Big => lowest.iter_mut().zip(bytes.iter().rev()).for_each(|(to, from)| *to = *from),
    }
    let bits = u64::from_le_bytes(lowest);
    match kind {
        Kind::U8 | Kind::U16 | Kind::U32 | Kind::U64 => bits as f64,
        Kind::I8 => f64::from(bits as i8),
        Kind::I16 => f64::from(bits as i16),
        Kind::I32 => f64::from(bits as i32),
        Kind::I64 => bits as i64 as f64,
        Kind::F32 => f64::from(f32::from_bits(bits as u32)),
        Kind::F64 => f64::from_bits(bits),
    }
}

/// A row or column that counts from 0.
///
/// # Errors
/// What is none.
pub fn index(value: f64) -> Result<u32, Problem> {
    if value >= 0.0 && value < f64::from(u32::MAX) && value.fract() == 0.0 {
        return Ok(value as u32);
    }
    Err(Problem::new(format!("a row or column of an entry is {value}, counted from 0; the file is damaged")))
}

/// What is said of a file that ends too early, or whose compressed parts are damaged.
pub fn ended(error: &io::Error) -> Problem {
    if error.kind() == io::ErrorKind::UnexpectedEof {
        return Problem::new("the file ends within the matrix; it is cut off or damaged");
    }
    Problem::new(format!("the file is damaged or cannot be read: {error}"))
}
