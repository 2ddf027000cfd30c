//! MAT files of level 5, which MATLAB, Octave and SciPy read, without compression.
//!
//! A file is a header and then elements: a type, a length, and data that are filled up to a multiple of 8 bytes. A
//! variable is an element that holds further ones.

use std::io::{self, Write};

use nalgebra::DMatrix;

use super::arrays::{AXES, GridArrays};
use crate::version::VERSION;

/// Types of elements.
const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;

/// Classes of variables.
const CELL_CLASS: u32 = 1;
const CHAR_CLASS: u32 = 4;
const DOUBLE_CLASS: u32 = 6;

/// Writes the arrays of a surface as numbers of type double, and the names of its axes as the cell array `axes`.
///
/// Counts are doubles too: MATLAB rounds the quotient of integers to an integer.
///
/// # Errors
/// Those of `out`, and an array of more than 4 GiB.
pub fn write(arrays: &GridArrays<'_>, out: &mut dyn Write) -> io::Result<()> {
    head(out)?;
    out.write_all(&names(&arrays.axis_names())?)?;
    for array in arrays.arrays() {
        let values = column_major(&array.shape, &array.values.into_reals());
        // Vectors are rows, as those of MATLAB's colon and `linspace`.
        let shape = if let [length] = array.shape[..] { vec![1, length] } else { array.shape };
        let data = element(DOUBLE, &bytes(values, f64::to_le_bytes))?;
        out.write_all(&variable(DOUBLE_CLASS, &array.name, &shape, &data)?)?;
    }
    Ok(())
}

/// Writes matrices with their names.
///
/// # Errors
/// Those of `out`, and a matrix of more than 4 GiB.
pub fn write_matrices(matrices: &[(String, &DMatrix<f64>)], out: &mut dyn Write) -> io::Result<()> {
    head(out)?;
    for (name, matrix) in matrices {
        let data = element(DOUBLE, &bytes(matrix.iter().copied(), f64::to_le_bytes))?;
        out.write_all(&variable(DOUBLE_CLASS, name, &[matrix.nrows(), matrix.ncols()], &data)?)?;
    }
    Ok(())
}

/// With what files of this program begin.
pub const OWN: &str = "MATLAB 5.0 MAT-file, written by stickslip ";

/// The header.
fn head(out: &mut dyn Write) -> io::Result<()> {
    // Spaces fill the text up to 116 bytes; 8 bytes of zeros say that there are no data of subsystems.
    let text = format!("{OWN}{VERSION}");
    out.write_all(format!("{text:<116.116}").as_bytes())?;
    out.write_all(&[0; 8])?;
    // Version 1.0, and the mark by which a reader knows the order of bytes: little end first.
    out.write_all(b"\x00\x01IM")
}

/// The names of the axes, a row of cells.
fn names(axes: &[&str]) -> io::Result<Vec<u8>> {
    let mut cells = Vec::new();
    for axis in axes {
        let text = element(UINT16, &bytes(axis.encode_utf16(), u16::to_le_bytes))?;
        cells.extend(variable(CHAR_CLASS, "", &[1, axis.len()], &text)?);
    }
    variable(CELL_CLASS, AXES, &[1, axes.len()], &cells)
}

/// A variable with its data, which are elements already.
fn variable(class: u32, name: &str, shape: &[usize], data: &[u8]) -> io::Result<Vec<u8>> {
    let shape =
        shape.iter().map(|&length| i32::try_from(length).map_err(|_| too_long())).collect::<Result<Vec<_>, _>>()?;
    let mut content = element(UINT32, &bytes([class, 0], u32::to_le_bytes))?;
    content.extend(element(INT32, &bytes(shape, i32::to_le_bytes))?);
    content.extend(element(INT8, name.as_bytes())?);
    content.extend(data);
    element(MATRIX, &content)
}

/// An element. Up to 4 bytes of data take the short form, in which they stand beside type and length.
fn element(kind: u32, data: &[u8]) -> io::Result<Vec<u8>> {
    let length = u32::try_from(data.len()).map_err(|_| too_long())?;
    let mut element = if let 1..=4 = length {
        (length << 16 | kind).to_le_bytes().to_vec()
    } else {
        bytes([kind, length], u32::to_le_bytes)
    };
    element.extend(data);
    element.resize(element.len().next_multiple_of(8), 0);
    Ok(element)
}

fn bytes<T, const N: usize>(values: impl IntoIterator<Item = T>, of: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    values.into_iter().flat_map(of).collect()
}

fn too_long() -> io::Error {
    io::Error::other("an array is longer than the 4 GiB that a MAT file holds; write --format csv")
}

/// Values with the last axis fastest, put in the order with the first axis fastest.
fn column_major(shape: &[usize], values: &[f64]) -> Vec<f64> {
    let value = |mut place: usize| {
        let (mut index, mut stride) = (0, values.len());
        for length in shape {
            stride /= length;
            index += place % length * stride;
            place /= length;
        }
        values[index]
    };
    (0..values.len()).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_axis_is_fastest_in_matlab() {
        // Two rows of three, then two pages of two rows of two.
        assert_eq!(column_major(&[2, 3], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), [0.0, 3.0, 1.0, 4.0, 2.0, 5.0]);
        let cube = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        assert_eq!(column_major(&[2, 2, 2], &cube), [0.0, 4.0, 2.0, 6.0, 1.0, 5.0, 3.0, 7.0]);
        assert_eq!(column_major(&[3], &[7.0, 8.0, 9.0]), [7.0, 8.0, 9.0]);
    }

    #[test]
    fn elements_are_filled_up_and_short_ones_have_their_own_form() {
        assert_eq!(element(INT8, b"abcde").unwrap(), *b"\x01\0\0\0\x05\0\0\0abcde\0\0\0");
        assert_eq!(element(INT8, b"abc").unwrap(), *b"\x01\0\x03\0abc\0");
        assert_eq!(element(INT8, b"").unwrap(), *b"\x01\0\0\0\0\0\0\0");
    }
}
