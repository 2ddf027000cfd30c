//! Harwell-Boeing, as HBMAT of Ansys writes it in ASCII: columns of a sparse matrix in lines of fixed fields, whose
//! formats the header gives in Fortran's words. Rutherford-Boeing, which differs in the header, is read as well.

use super::entries::{Entries, MOST_ENTRIES, Symmetry, square, too_many_entries};
use super::error::{Problem, quoted};
use super::matrix::{ReadMatrix, Stored};
use super::source::Source;
use super::text::{Lines, index, number, words};

/// Widest field.
const WIDEST: usize = 256;

/// Most fields of a line.
const MOST_FIELDS: usize = 4096;

/// Whether a text has the header of such a file: a type of three letters in the third line, formats in the fourth.
pub fn is_one(text: &str) -> bool {
    let mut lines = text.lines().skip(2);
    let kind = lines.next().map(|line| line.trim().chars().take(3).collect::<String>().to_uppercase());
    let is_kind = kind.is_some_and(|kind| {
        let letters: Vec<char> = kind.chars().collect();
        matches!(letters[..], ['R' | 'C' | 'P' | 'I' | 'Q', 'S' | 'U' | 'H' | 'Z' | 'R', 'A' | 'E'])
    });
    is_kind && lines.next().is_some_and(|line| line.trim_start().starts_with('('))
}

/// How numbers stand in lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Format {
    per_line: usize,
    width: usize,
}

impl Format {
    /// A format such as (10I8), (5E16.8) or (1P,4D20.12).
    fn parsed(line: u64, text: &str) -> Result<Self, Problem> {
        let wrong = || Problem::at(line, format!("the format {} is none like (10I8) or (1P,4D20.12)", quoted(text)));
        let capitals = text.to_uppercase();
        let inside = capitals.trim().strip_prefix('(').and_then(|rest| rest.strip_suffix(')')).ok_or_else(wrong)?;
        let inside: String = inside.chars().filter(|c| !c.is_whitespace()).collect();
        // A scale such as 1P has no effect on numbers with an exponent.
        let digits = |text: &str| text.trim_start_matches('-').bytes().all(|byte| byte.is_ascii_digit());
        let rest = match inside.split_once('P') {
            Some((scale, rest)) if digits(scale) => rest.trim_start_matches(','),
            _ => &inside,
        };
        let place = rest.find(['I', 'E', 'D', 'F', 'G']).ok_or_else(wrong)?;
        let (repeat, field) = (&rest[..place], &rest[place + 1..]);
        let per_line = if repeat.is_empty() { 1 } else { repeat.parse().map_err(|_| wrong())? };
        let mut parts = field.split(['.', 'E']);
        let width = parts.next().and_then(|width| width.parse().ok()).ok_or_else(wrong)?;
        let is_sound = parts.all(digits) && (1..=MOST_FIELDS).contains(&per_line) && (1..=WIDEST).contains(&width);
        if is_sound { Ok(Self { per_line, width }) } else { Err(wrong()) }
    }

    /// Gives `count` fields to `take`.
    fn each(
        self,
        lines: &mut Lines<'_>,
        count: usize,
        what: &str,
        mut take: impl FnMut(u64, &str) -> Result<(), Problem>,
    ) -> Result<(), Problem> {
        let mut read = 0;
        while read < count {
            let (line, text) = lines.required(&format!("the {what} number {}", read + 1))?;
            if !text.is_ascii() {
                return Err(Problem::at(line, "the line has letters beside ASCII"));
            }
            let due = self.per_line.min(count - read);
            // SciPy parts numbers by blanks and does not keep to the widths that it announces.
            let apart: Vec<&str> = words(text).take(due + 1).collect();
            for at in 0..due {
                let start = (at * self.width).min(text.len());
                let field = text[start..(start + self.width).min(text.len())].trim();
                let word = if apart.len() == due { apart[at] } else { field };
                if word.is_empty() {
                    if at == 0 {
                        return Err(Problem::at(
                            line,
                            format!("the line is blank where the {what} number {} is due", read + 1),
                        ));
                    }
                    break;
                }
                take(line, word)?;
                read += 1;
            }
        }
        Ok(())
    }
}

/// Whole numbers of a line of the header.
fn counts(line: u64, text: &str) -> Result<Vec<u64>, Problem> {
    words(text)
        .map(|word| {
            word.parse()
                .map_err(|_| Problem::at(line, format!("{} is no number of lines, rows or entries", quoted(word))))
        })
        .collect()
}

fn symmetry(line: u64, kind: &str) -> Result<(Symmetry, Stored), Problem> {
    let refuse = |what: &str| {
        Err(Problem::at(line, format!("the matrix is of the type {}, {what}; RSA, RUA and RZA are read", quoted(kind))))
    };
    match kind.as_bytes() {
        [b'C', ..] => refuse("complex"),
        [b'P' | b'Q', ..] => refuse("which has no values"),
        [_, b'H', _] => refuse("hermitian"),
        [_, _, b'E'] => refuse("which is not assembled"),
        [_, b'S', _] => Ok((Symmetry::Symmetric, Stored::SymmetricTriangle)),
        [_, b'Z', _] => Ok((Symmetry::Skew, Stored::SkewTriangle)),
        _ => Ok((Symmetry::None, Stored::General)),
    }
}

pub fn read(source: &mut Source) -> Result<ReadMatrix, Problem> {
    let length = source.length;
    let mut lines = Lines::new(source)?;
    lines.required("a title")?;
    let (line, text) = lines.required("the numbers of lines")?;
    let has_right_sides = counts(line, text)?.get(4).is_some_and(|count| *count > 0);
    let (line, text) = lines.required("the type of the matrix")?;
    let text = text.trim();
    let kind: String = text.chars().take(3).collect::<String>().to_uppercase();
    let sizes =
        text.get(3..).ok_or_else(|| Problem::at(line, "the line should have type, rows, columns and entries"))?;
    let (symmetry, stored) = symmetry(line, &kind)?;
    let &[rows, columns, count, ..] = &counts(line, sizes)?[..] else {
        return Err(Problem::at(line, "the line should have type, rows, columns and entries"));
    };
    let size = square(rows, columns)?;
    if count > MOST_ENTRIES as u64 {
        return Err(too_many_entries(MOST_ENTRIES));
    }
    // A row and a value for each, of a character at least.
    if count.saturating_mul(2) > length || columns > length {
        let text = format!(
            "there should be {count} entries in {columns} columns, for which the file of {length} bytes is too short; it is cut off"
        );
        return Err(Problem::at(line, text));
    }
    let count = count as usize;
    let (line, text) = lines.required("the formats")?;
    let formats: Vec<&str> = text.split_inclusive(')').map(str::trim).filter(|text| !text.is_empty()).collect();
    let &[starts_format, rows_format, values_format, ..] = &formats[..] else {
        let text = format!("there are {} formats where those of starts, rows and values are due", formats.len());
        return Err(Problem::at(line, text));
    };
    let [starts_format, rows_format, values_format] = [
        Format::parsed(line, starts_format)?,
        Format::parsed(line, rows_format)?,
        Format::parsed(line, values_format)?,
    ];
    if has_right_sides {
        lines.required("the formats of right-hand sides")?;
    }
    let mut starts = Vec::new();
    starts_format.each(&mut lines, size + 1, "start of a column", |line, word| {
        let start = index(line, word, "start of a column", None)? as usize;
        if start > count || starts.last().map_or(start != 0, |last| start < *last) {
            let text = format!("the start of a column is {}; starts should rise from 1 to {}", start + 1, count + 1);
            return Err(Problem::at(line, text));
        }
        starts.push(start);
        Ok(())
    })?;
    let end = starts.last().copied().unwrap_or_default();
    if end != count {
        return Err(Problem::new(format!("the columns have {end} entries, but there should be {count}")));
    }
    let mut rows = Vec::new();
    rows_format.each(&mut lines, count, "row of an entry", |line, word| {
        rows.push(index(line, word, "row", Some(size))?);
        Ok(())
    })?;
    let mut entries = Entries::default();
    let (mut at, mut column) = (0, 0);
    values_format.each(&mut lines, count, "value of an entry", |line, word| {
        while starts[column + 1] <= at {
            column += 1;
        }
        entries.push(rows[at], column as u32, number(line, word)?)?;
        at += 1;
        Ok(())
    })?;
    Ok(ReadMatrix::new(entries.into_matrix(size, symmetry)?, stored))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_of_fortran_are_understood() {
        for (text, per_line, width) in [
            ("(10I8)", 10, 8),
            ("(5E16.8)", 5, 16),
            ("(1P,4D20.12)", 4, 20),
            ("(1P4E24.16E3)", 4, 24),
            ("(i14)", 1, 14),
        ] {
            assert_eq!(Format::parsed(4, text), Ok(Format { per_line, width }), "{text}");
        }
        for text in
            ["(I)", "I8", "(2(1X,I8))", "(0I8)", "(10I0)", "()", "(5E16.x)", "(99999999999I8)", "(A8)", "(I8,I9)"]
        {
            assert!(Format::parsed(4, text).is_err(), "{text}");
        }
    }
}
