//! The compact encoding of Thrift, in which Parquet files describe themselves, read into a tree. What is announced must
//! be there: nothing is allocated for a list that is longer than the bytes that hold it.

/// Deepest nesting. The footer of a Parquet file has about ten levels.
const DEEPEST: u32 = 24;

/// A value.
#[derive(Debug)]
pub enum Value<'a> {
    /// True or false; which of them does not matter here.
    Flag,
    /// A whole number of any width.
    Number(i64),
    /// A text, or bytes.
    Bytes(&'a [u8]),
    /// A list or a set.
    List(Vec<Value<'a>>),
    /// Fields by their numbers.
    Fields(Vec<(i16, Value<'a>)>),
    /// Something that nobody asks for.
    Other,
}

impl<'a> Value<'a> {
    /// The field with this number.
    pub fn field(&self, number: i16) -> Option<&Self> {
        let Self::Fields(fields) = self else { return None };
        // Of fields of the same number, a reader keeps the last.
        fields.iter().rev().find(|(field, _)| *field == number).map(|(_, value)| value)
    }

    /// The whole number in a field.
    pub fn number(&self, field: i16) -> Option<i64> {
        match self.field(field)? {
            Self::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// The list in a field; an empty one if there is none.
    pub fn list(&self, field: i16) -> &[Self] {
        match self.field(field) {
            Some(Self::List(list)) => list,
            _ => &[],
        }
    }

    /// The bytes in a field.
    pub fn bytes(&self, field: i16) -> Option<&'a [u8]> {
        match self.field(field)? {
            Self::Bytes(bytes) => Some(bytes),
            _ => None,
        }
    }
}

/// Reads the fields at the start of `bytes`, of at most `values` values all together, and returns them with their length
/// in bytes; `None` if they are incomplete or wrong.
pub fn fields(bytes: &[u8], values: usize) -> Option<(Value<'_>, usize)> {
    let mut reader = Reader { rest: bytes, values };
    let fields = reader.value(FIELDS, 0)?;
    Some((fields, bytes.len() - reader.rest.len()))
}

const FIELDS: u8 = 12;

struct Reader<'a> {
    rest: &'a [u8],
    /// How many more values there may be.
    values: usize,
}

impl<'a> Reader<'a> {
    fn byte(&mut self) -> Option<u8> {
        let (&byte, rest) = self.rest.split_first()?;
        self.rest = rest;
        Some(byte)
    }

    fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(length)?;
        self.rest = rest;
        Some(taken)
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

    /// A length that the bytes left can hold, as everything takes a byte at least.
    fn length(&mut self) -> Option<usize> {
        usize::try_from(self.unsigned()?).ok().filter(|&length| length <= self.rest.len())
    }

    fn value(&mut self, kind: u8, depth: u32) -> Option<Value<'a>> {
        self.values = self.values.checked_sub(1)?;
        if depth > DEEPEST {
            return None;
        }
        Some(match kind {
            3 => Value::Number(self.byte()?.cast_signed().into()),
            4..=6 => Value::Number(self.signed()?),
            7 => self.take(8).map(|_| Value::Other)?,
            8 => {
                let length = self.length()?;
                Value::Bytes(self.take(length)?)
            }
            9 | 10 => self.list(depth)?,
            11 => self.map(depth)?,
            FIELDS => self.fields(depth)?,
            13 => self.take(16).map(|_| Value::Other)?,
            _ => return None,
        })
    }

    /// An element of a list or of a map, where true and false take a byte.
    fn element(&mut self, kind: u8, depth: u32) -> Option<Value<'a>> {
        match kind {
            1 | 2 => {
                self.values = self.values.checked_sub(1)?;
                self.byte().map(|_| Value::Flag)
            }
            kind => self.value(kind, depth + 1),
        }
    }

    fn list(&mut self, depth: u32) -> Option<Value<'a>> {
        let header = self.byte()?;
        let length = match header >> 4 {
            15 => self.length()?,
            length => length.into(),
        };
        // Elements are added as they are read: their bytes may be fewer than their number says.
        let mut list = Vec::new();
        for _ in 0..length {
            list.push(self.element(header & 15, depth)?);
        }
        Some(Value::List(list))
    }

    fn map(&mut self, depth: u32) -> Option<Value<'a>> {
        let length = self.length()?;
        if length > 0 {
            let kinds = self.byte()?;
            for _ in 0..length {
                self.element(kinds >> 4, depth)?;
                self.element(kinds & 15, depth)?;
            }
        }
        Some(Value::Other)
    }

    fn fields(&mut self, depth: u32) -> Option<Value<'a>> {
        let (mut fields, mut number) = (Vec::new(), 0_i16);
        loop {
            let header = self.byte()?;
            let kind = header & 15;
            if kind == 0 {
                return Some(Value::Fields(fields));
            }
            number = match header >> 4 {
                0 => i16::try_from(self.signed()?).ok()?,
                step => number.checked_add(step.into())?,
            };
            let value = match kind {
                1 | 2 => Value::Flag,
                kind => self.value(kind, depth + 1)?,
            };
            fields.push((number, value));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_read_with_their_length() {
        // Field 1: -3; field 3: true; field 4: "ab"; field 5: a list of 7 and 8; field 30: fields of which 2 is 1.
        let bytes = [0x15, 5, 0x21, 0x18, 2, b'a', b'b', 0x19, 0x25, 14, 16, 0x0c, 60, 0x25, 2, 0, 0, 99];
        let (value, length) = fields(&bytes, 100).unwrap();
        assert_eq!(length, bytes.len() - 1);
        assert_eq!((value.number(1), value.bytes(4), value.number(2)), (Some(-3), Some(&b"ab"[..]), None));
        assert!(matches!(value.list(5), [Value::Number(7), Value::Number(8)]));
        assert!(matches!(value.field(3), Some(Value::Flag)));
        assert_eq!(value.field(30).unwrap().number(2), Some(1));
        assert!(fields(&bytes, 5).is_none(), "more values than are allowed");
        assert!((0..length).all(|end| fields(&bytes[..end], 100).is_none()), "incomplete");
    }

    #[test]
    fn what_is_longer_than_its_bytes_is_refused() {
        for bytes in [
            // A list of 2^31 fields, a text of 2^40 bytes, a map of as many, and nested fields without end.
            vec![0x19, 0xfc, 0x80, 0x80, 0x80, 0x80, 8, 0],
            vec![0x18, 0x80, 0x80, 0x80, 0x80, 0x80, 0x20, 0],
            vec![0x1b, 0x80, 0x80, 0x80, 0x80, 0x80, 0x20, 0],
            vec![0x1c; 100_000],
        ] {
            assert!(fields(&bytes, 1 << 20).is_none());
        }
    }
}
