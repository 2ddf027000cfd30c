//! NPZ, the archives of NumPy: a zip archive of one array in each entry, stored without compression.

use std::io::{self, Write};

use flate2::Crc;

use super::arrays::{AXES, GridArrays, NamedArray, Numbers};

/// Writes the arrays of a surface, and the names of its axes as the array `axes`.
///
/// # Errors
/// Those of `out`, and an archive of more than 4 GiB.
pub fn write(arrays: &GridArrays<'_>, out: &mut dyn Write) -> io::Result<()> {
    let mut archive = Archive { out, offset: 0, directory: Vec::new(), entries: 0 };
    archive.add(&format!("{AXES}.npy"), &text_array(&arrays.axis_names()))?;
    for array in arrays.arrays() {
        archive.add(&format!("{}.npy", array.name), &number_array(&array))?;
    }
    archive.finish()
}

/// An array of numbers in the format NPY.
fn number_array(array: &NamedArray) -> Vec<u8> {
    match &array.values {
        Numbers::Integer(values) => npy("<i8", &array.shape, values.iter().flat_map(|value| value.to_le_bytes())),
        Numbers::Real(values) => npy("<f8", &array.shape, values.iter().flat_map(|value| value.to_le_bytes())),
    }
}

/// A vector of texts in the format NPY, each filled with zeros to the length of the longest.
fn text_array(texts: &[&str]) -> Vec<u8> {
    let longest = texts.iter().map(|text| text.chars().count()).max().unwrap_or(1).max(1);
    let filled = |text: &str| text.chars().map(u32::from).chain(std::iter::repeat(0)).take(longest).collect::<Vec<_>>();
    let bytes = texts.iter().flat_map(|text| filled(text)).flat_map(u32::to_le_bytes);
    npy(&format!("<U{longest}"), &[texts.len()], bytes)
}

/// An array in the format NPY, version 1.0: a header that describes it, then its bytes.
fn npy(description: &str, shape: &[usize], bytes: impl Iterator<Item = u8>) -> Vec<u8> {
    // A tuple of one number needs a comma, and others may end with one.
    let lengths: String = shape.iter().map(|length| format!("{length}, ")).collect();
    let lengths = lengths.trim_end();
    let header = format!("{{'descr': '{description}', 'fortran_order': False, 'shape': ({lengths}), }}");
    // Spaces and a newline fill the header up, so that the data begin at a multiple of 64 bytes. Ten bytes precede it.
    let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
    let mut array = b"\x93NUMPY\x01\x00".to_vec();
    // A header of a few lengths is far shorter than 64 KiB.
    array.extend((length as u16).to_le_bytes());
    array.extend(format!("{header:<width$}\n", width = length - 1).bytes());
    array.extend(bytes);
    array
}

/// A zip archive that is being written.
struct Archive<'a> {
    out: &'a mut dyn Write,
    /// Bytes written so far.
    offset: u64,
    /// The directory, which follows the last entry.
    directory: Vec<u8>,
    entries: u16,
}

impl Archive<'_> {
    /// Adds an entry.
    fn add(&mut self, name: &str, data: &[u8]) -> io::Result<()> {
        // Names are made of a few ASCII characters.
        let name_length = name.len() as u16;
        let mut description = Vec::new();
        // Version 2.0 of the format, no flags, no compression; midnight of 1 January 1980, the first moment that zip
        // knows, so that the same surface gives the same bytes.
        for number in [20u16, 0, 0, 0, 1 << 5 | 1] {
            description.extend(number.to_le_bytes());
        }
        let length = in_32_bits(data.len() as u64)?;
        for number in [checksum(data), length, length] {
            description.extend(number.to_le_bytes());
        }
        // The length of the name, and of further fields.
        for number in [name_length, 0] {
            description.extend(number.to_le_bytes());
        }
        self.directory.extend(b"PK\x01\x02");
        self.directory.extend(20u16.to_le_bytes());
        self.directory.extend(&description);
        // No comment, the first disk, no attributes.
        self.directory.extend([0; 10]);
        self.directory.extend(in_32_bits(self.offset)?.to_le_bytes());
        self.directory.extend(name.bytes());
        self.entries += 1;
        for bytes in [b"PK\x03\x04", description.as_slice(), name.as_bytes(), data] {
            self.out.write_all(bytes)?;
            self.offset += bytes.len() as u64;
        }
        Ok(())
    }

    /// Writes the directory.
    fn finish(self) -> io::Result<()> {
        self.out.write_all(&self.directory)?;
        let mut end = b"PK\x05\x06\0\0\0\0".to_vec();
        for number in [self.entries, self.entries] {
            end.extend(number.to_le_bytes());
        }
        for number in [self.directory.len() as u64, self.offset] {
            end.extend(in_32_bits(number)?.to_le_bytes());
        }
        // No comment.
        end.extend([0, 0]);
        self.out.write_all(&end)
    }
}

/// A length or place in the archive.
fn in_32_bits(number: u64) -> io::Result<u32> {
    let too_long = "the arrays are longer than the 4 GiB that an NPZ file holds; write --format csv or mat";
    u32::try_from(number).map_err(|_| io::Error::other(too_long))
}

/// The checksum of zip, CRC-32.
fn checksum(data: &[u8]) -> u32 {
    let mut sum = Crc::new();
    sum.update(data);
    sum.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_zip() {
        // The check value of CRC-32 in the catalogues.
        assert_eq!(checksum(b"123456789"), 0xCBF4_3926);
        assert_eq!(checksum(b""), 0);
    }

    #[test]
    fn data_of_an_array_begin_at_a_multiple_of_64_bytes() {
        for shape in [vec![3], vec![1, 1, 30, 26], vec![1; 12]] {
            let array = npy("<f8", &shape, std::iter::empty());
            assert_eq!(array.len() % 64, 0);
            assert_eq!(usize::from(array[8]) + 256 * usize::from(array[9]) + 10, array.len());
            assert_eq!(array.last(), Some(&b'\n'));
        }
        assert!(String::from_utf8_lossy(&npy("<f8", &[3], std::iter::empty())).contains("'shape': (3,), }"));
        assert!(String::from_utf8_lossy(&npy("<f8", &[3, 4], std::iter::empty())).contains("'shape': (3, 4,), }"));
    }

    #[test]
    fn texts_are_filled_to_one_length() {
        let array = text_array(&["ab", "c"]);
        assert!(String::from_utf8_lossy(&array).contains("'<U2'"));
        assert_eq!(array[array.len() - 16..], *b"a\0\0\0b\0\0\0c\0\0\0\0\0\0\0");
    }
}
