//! Variables of a MAT file: full and sparse arrays.

use crate::matrix_files::entries::{
    Built, Entries, MOST_ENTRIES, Symmetry, from_columns, most_entries, square, too_many_entries,
};
use crate::matrix_files::error::Problem;
use crate::matrix_files::numbers::{Order, index};

use super::element::Body;

/// Longest name of a variable; MATLAB has 63 letters.
const LONGEST_NAME: u64 = 4096;

/// Most dimensions of an array.
const MOST_DIMENSIONS: u64 = 32;

const SPARSE: u8 = 5;

/// What the start of a variable says.
pub struct Head {
    pub name: String,
    class: u8,
    is_complex: bool,
    most_entries: u64,
    dimensions: Vec<u64>,
}

impl Head {
    /// The start of a variable; `None` of what is no variable, or has no name, as MATLAB keeps such for itself.
    pub fn read(body: &mut Body<'_>) -> Result<Option<Self>, Problem> {
        if !body.is_matrix() {
            return Ok(None);
        }
        let element = body.element()?;
        // Class and number of entries, in two numbers.
        let flags = body.bytes(&element, 8)?;
        let &[a, b, c, d, e, f, g, h] = &flags[..] else {
            return Err(Problem::new(format!(
                "a variable starts with {} bytes of flags, not 8; the file is damaged",
                flags.len()
            )));
        };
        let (class, marks, most_entries) = match body.order {
            Order::Little => (a, b, u32::from_le_bytes([e, f, g, h])),
            Order::Big => (d, c, u32::from_be_bytes([e, f, g, h])),
        };
        // Variables of these classes have no dimensions.
        if class == 17 {
            return Ok(None);
        }
        let mut dimensions = Vec::new();
        body.numbers("dimensions", [1, MOST_DIMENSIONS], |value| {
            dimensions.push(if value >= 0.0 { value as u64 } else { u64::MAX });
            Ok(())
        })?;
        let element = body.element()?;
        let name = body.bytes(&element, LONGEST_NAME)?;
        let name = String::from_utf8_lossy(&name).into_owned();
        let is_complex = marks & 0x08 != 0;
        let head = Self { name, class, is_complex, most_entries: most_entries.into(), dimensions };
        Ok((!head.name.is_empty()).then_some(head))
    }

    /// Why it is no matrix that can be read.
    pub fn problem(&self) -> Option<String> {
        let what = match self.class {
            1 => "a cell array; save the matrices in it as variables of their own",
            2 => {
                "a struct; save the matrices in it as variables of their own, with `save('brake.mat', '-struct', 'name', '-v7')`"
            }
            3 => "an object; save the matrices in it as variables of their own",
            4 => "a text",
            5..=15 if self.is_complex => {
                "complex; save real matrices, and structural damping as a term of its own with a factor"
            }
            5..=15 if self.dimensions.len() > 2 => "an array of more than two dimensions",
            5..=15 => return None,
            _ => "no array of numbers",
        };
        Some(format!("it is {what}"))
    }
}

/// Reads the numbers after the head, of a file of this length.
pub fn read(body: &mut Body<'_>, head: &Head, length: u64) -> Result<Built, Problem> {
    let &[rows, columns] = &head.dimensions[..] else {
        return Err(Problem::new("it has one dimension"));
    };
    let size = square(rows, columns)?;
    let most = most_entries(size, length);
    if head.class == SPARSE { sparse(body, size, head.most_entries, most) } else { full(body, size, most) }
}

fn full(body: &mut Body<'_>, size: usize, most: usize) -> Result<Built, Problem> {
    let mut entries = Entries::at_most(most);
    let count = (size as u64).saturating_mul(size as u64);
    let (mut row, mut column) = (0, 0);
    body.numbers("entries", [count, count], |value| {
        if value != 0.0 {
            entries.push(row, column, value)?;
        }
        row += 1;
        if row as usize == size {
            (row, column) = (0, column + 1);
        }
        Ok(())
    })?;
    entries.into_matrix(size, Symmetry::None)
}

fn sparse(body: &mut Body<'_>, size: usize, room: u64, most: usize) -> Result<Built, Problem> {
    if room > MOST_ENTRIES as u64 {
        return Err(too_many_entries(MOST_ENTRIES));
    }
    // There may be more room in the file than entries; MATLAB keeps room for one at least.
    let room = room.max(1);
    let mut rows = Vec::new();
    body.numbers("rows of entries", [0, room], |value| {
        if rows.len() == most {
            return Err(too_many_entries(most));
        }
        rows.push(index(value)?);
        Ok(())
    })?;
    let mut starts = Vec::new();
    let columns = size as u64 + 1;
    body.numbers("starts of columns", [columns, columns], |value| {
        starts.push(index(value)? as usize);
        Ok(())
    })?;
    let count = starts.last().copied().unwrap_or_default() as u64;
    let mut values = Vec::new();
    body.numbers("entries", [count, room], |value| {
        if values.len() == most {
            return Err(too_many_entries(most));
        }
        values.push(value);
        Ok(())
    })?;
    from_columns(size, starts, rows, values)
}
