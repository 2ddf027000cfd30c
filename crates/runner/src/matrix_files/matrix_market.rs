//! Matrix Market: `%%MatrixMarket matrix coordinate real symmetric` and the like.

use super::entries::{Entries, MOST_ENTRIES, Symmetry, square, too_many_entries};
use super::error::{Problem, quoted};
use super::matrix::{ReadMatrix, Stored};
use super::source::Source;
use super::text::{Lines, index, number, words};

/// Shortest line of an entry: two numbers and a value, with their separators; and of a value alone.
const SHORTEST_ENTRY: u64 = 6;
const SHORTEST_VALUE: u64 = 2;

pub fn read(source: &mut Source) -> Result<ReadMatrix, Problem> {
    let length = source.length;
    let mut lines = Lines::new(source)?;
    let (_, header) = lines.required("the header")?;
    let (is_array, symmetry) = kind(header)?;
    let (line, sizes) = loop {
        let (line, text) = lines.required("a line with the numbers of rows and columns")?;
        if !text.trim().is_empty() && !text.trim_start().starts_with('%') {
            break (line, text.to_owned());
        }
    };
    let sizes: Vec<u64> = words(&sizes)
        .map(|word| word.parse().map_err(|_| Problem::at(line, format!("{} is no whole number", quoted(word)))))
        .collect::<Result<_, _>>()?;
    let (rows, columns, count) = match sizes[..] {
        [rows, columns] if is_array => (rows, columns, None),
        [rows, columns, count] if !is_array => (rows, columns, Some(count)),
        _ => {
            let due = if is_array { "rows and columns" } else { "rows, columns and entries" };
            return Err(Problem::at(line, format!("there are {} numbers where those of {due} are due", sizes.len())));
        }
    };
    let size = square(rows, columns)?;
    let (count, shortest) = match count {
        Some(count) => (count, SHORTEST_ENTRY),
        None => (values_of_array(size as u64, symmetry), SHORTEST_VALUE),
    };
    if count.saturating_mul(shortest) > length {
        let text = format!(
            "there should be {count} entries, for which the file of {length} bytes is too short; it is cut off"
        );
        return Err(Problem::at(line, text));
    }
    if !is_array && count > MOST_ENTRIES as u64 {
        return Err(too_many_entries(MOST_ENTRIES));
    }
    let mut entries = Entries::with_room(count as usize);
    let mut read = 0;
    let mut places = Places::new(size, symmetry);
    while let Some((line, text)) = lines.next()? {
        if text.trim().is_empty() || text.trim_start().starts_with('%') {
            continue;
        }
        if read == count {
            let why = match symmetry {
                Symmetry::Skew if is_array => "; a skew-symmetric array is stored without its diagonal, which is zero",
                _ => "",
            };
            return Err(Problem::at(line, format!("there are more than the {count} entries of the header{why}")));
        }
        let fields: Vec<&str> = words(text).take(4).collect();
        match fields[..] {
            [value] if is_array => {
                let (row, column) = places.next_place();
                let value = number(line, value)?;
                if value != 0.0 {
                    entries.push(row, column, value)?;
                }
            }
            [row, column, value] if !is_array => {
                let place = (index(line, row, "row", Some(size))?, index(line, column, "column", Some(size))?);
                entries.push(place.0, place.1, number(line, value)?)?;
            }
            _ => {
                let due = if is_array { "a value" } else { "row, column and value" };
                return Err(Problem::at(line, format!("{} is not {due}", quoted(text))));
            }
        }
        read += 1;
    }
    if read < count {
        return Err(Problem::new(format!("the file ends after {read} of {count} entries; it is cut off")));
    }
    let stored = match symmetry {
        Symmetry::None => Stored::General,
        Symmetry::Symmetric => Stored::SymmetricTriangle,
        Symmetry::Skew => Stored::SkewTriangle,
    };
    Ok(ReadMatrix::new(entries.into_matrix(size, symmetry)?, stored))
}

/// What the header says: whether every value is given, and the symmetry.
fn kind(header: &str) -> Result<(bool, Symmetry), Problem> {
    let header = header.to_lowercase();
    let wrong = |text: String| Err(Problem::at(1, text));
    let [_, object, format, field, symmetry] = header.split_whitespace().collect::<Vec<_>>()[..] else {
        return wrong("the header should be like `%%MatrixMarket matrix coordinate real general`".to_owned());
    };
    if object != "matrix" {
        return wrong(format!("the file holds a {}, not a matrix", quoted(object)));
    }
    let is_array = match format {
        "coordinate" => false,
        "array" => true,
        _ => return wrong(format!("the format {} is none of coordinate and array", quoted(format))),
    };
    match field {
        "real" | "double" | "integer" | "unsigned-integer" => {}
        "pattern" => {
            return wrong("the file holds places without values (pattern); write it with real values".to_owned());
        }
        "complex" => {
            return wrong(
                "the matrix is complex; write real matrices, and structural damping as a term of its own with a factor"
                    .to_owned(),
            );
        }
        _ => return wrong(format!("the values are {}; real and integer are read", quoted(field))),
    }
    let symmetry = match symmetry {
        "general" => Symmetry::None,
        "symmetric" => Symmetry::Symmetric,
        "skew-symmetric" => Symmetry::Skew,
        "hermitian" => {
            return wrong("the matrix is hermitian, which is for complex values; write it as symmetric".to_owned());
        }
        _ => {
            return wrong(format!(
                "the symmetry {} is none of general, symmetric and skew-symmetric",
                quoted(symmetry)
            ));
        }
    };
    Ok((is_array, symmetry))
}

fn values_of_array(size: u64, symmetry: Symmetry) -> u64 {
    match symmetry {
        Symmetry::None => size.saturating_mul(size),
        Symmetry::Symmetric => size.saturating_mul(size + 1) / 2,
        Symmetry::Skew => size.saturating_mul(size - 1) / 2,
    }
}

/// The places of the values of an array, column by column; of triangles the lower one.
struct Places {
    size: u32,
    symmetry: Symmetry,
    row: u32,
    column: u32,
}

impl Places {
    fn new(size: usize, symmetry: Symmetry) -> Self {
        let mut places = Self { size: size as u32, symmetry, row: 0, column: 0 };
        places.row = places.first_row();
        places
    }

    fn first_row(&self) -> u32 {
        match self.symmetry {
            Symmetry::None => 0,
            Symmetry::Symmetric => self.column,
            Symmetry::Skew => self.column + 1,
        }
    }

    fn next_place(&mut self) -> (u32, u32) {
        let place = (self.row, self.column);
        self.row += 1;
        if self.row >= self.size {
            self.column += 1;
            self.row = self.first_row();
        }
        place
    }
}
