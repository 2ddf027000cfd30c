//! Lines of a text and the numbers in them, as programs in C and Fortran write them.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _};

use super::entries::MOST_ROWS;
use super::error::{Problem, quoted};
use super::source::Source;

/// Longest line, in bytes.
const LONGEST_LINE: u64 = 1 << 20;

/// The lines of a text.
pub struct Lines<'a> {
    reader: BufReader<&'a File>,
    bytes: Vec<u8>,
    /// The number of the line that was read last, from 1.
    pub number: u64,
    /// Whether that line has an end, or no number that could be cut off.
    is_whole: bool,
}

impl<'a> Lines<'a> {
    /// The lines of a file from its start.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn new(source: &'a mut Source) -> Result<Self, Problem> {
        source.seek(0)?;
        let reader = BufReader::with_capacity(1 << 18, &source.file);
        Ok(Self { reader, bytes: Vec::new(), number: 0, is_whole: true })
    }

    /// The next line without its end, and its number.
    ///
    /// # Errors
    /// Lines that are too long, and what is no text.
    pub fn next(&mut self) -> Result<Option<(u64, &str)>, Problem> {
        self.bytes.clear();
        self.number += 1;
        let read = self.reader.by_ref().take(LONGEST_LINE + 1).read_until(b'\n', &mut self.bytes);
        match read.map_err(|error| Problem::of_reading(&error))? {
            0 => return Ok(None),
            length if length as u64 > LONGEST_LINE => {
                let text = format!("the line is longer than {LONGEST_LINE} bytes, the limit; is this a file of text?");
                return Err(Problem::at(self.number, text));
            }
            _ => {}
        }
        self.is_whole = self.bytes.ends_with(b"\n") || !self.bytes.iter().any(u8::is_ascii_digit);
        let text = str::from_utf8(&self.bytes).map_err(|_| Problem::at(self.number, NOT_TEXT))?;
        Ok(Some((self.number, text.trim_end_matches(['\n', '\r']))))
    }

    /// Refuses a last line with numbers and without an end, once all are read: in formats that do not say how many lines
    /// there are, a number that is cut off may be a number still.
    ///
    /// # Errors
    /// Such a line.
    pub fn whole(&self) -> Result<(), Problem> {
        if self.is_whole {
            return Ok(());
        }
        let text = "the last line has no end: the file may be cut off; put a line break at its end if it is whole";
        // The number has gone on to the line that is not there.
        Err(Problem::at(self.number - 1, text))
    }

    /// The next line, which the format asks for.
    ///
    /// # Errors
    /// As `next`, and the end of the file.
    pub fn required(&mut self, what: &str) -> Result<(u64, &str), Problem> {
        let number = self.number + 1;
        self.next()?
            .ok_or_else(|| Problem::at(number, format!("the file ends where {what} should follow; it is cut off")))
    }
}

const NOT_TEXT: &str = "this is no text of a matrix: it has bytes that are no letters or digits";

/// The words of a line, separated by blanks and commas.
pub fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty())
}

/// A finite number, also with the exponents of Fortran: `1.5D+05` and `1.5+5`.
pub fn parsed(word: &str) -> Option<f64> {
    let value = word.parse::<f64>().ok().or_else(|| {
        let bytes = word.as_bytes();
        // A sign that follows a digit or a point begins an exponent.
        let sign = (1..bytes.len()).rfind(|&at| matches!(bytes[at], b'+' | b'-'));
        let text = match sign {
            Some(at) if bytes[at - 1].is_ascii_digit() || bytes[at - 1] == b'.' => {
                format!("{}e{}", &word[..at], &word[at..])
            }
            _ => word.replace(['d', 'D'], "e"),
        };
        text.parse().ok()
    });
    // Names such as nan and inf are numbers to the parser.
    value.filter(|value: &f64| value.is_finite())
}

/// A finite number in a line.
///
/// # Errors
/// What is none.
pub fn number(line: u64, word: &str) -> Result<f64, Problem> {
    parsed(word)
        .ok_or_else(|| Problem::at(line, format!("{} is no finite number, such as 0.41 or 4.1e-1", quoted(word))))
}

/// A row or column of a matrix, which files count from 1; the result counts from 0.
///
/// # Errors
/// What is no whole number from 1 to the limit, or to the size of the matrix where that is known.
pub fn index(line: u64, word: &str, what: &str, size: Option<usize>) -> Result<u32, Problem> {
    let most = size.unwrap_or(MOST_ROWS);
    match word.parse::<u64>() {
        Ok(index) if (1..=most as u64).contains(&index) => Ok((index - 1) as u32),
        Ok(index) => {
            let limit = match size {
                Some(size) => format!("the matrix has {size} rows and columns, counted from 1"),
                None => format!("it should be from 1 to {MOST_ROWS}, the limit"),
            };
            Err(Problem::at(line, format!("the {what} is {index}, but {limit}")))
        }
        Err(_) => {
            Err(Problem::at(line, format!("the {what} is {}, which is no whole number from 1 to {most}", quoted(word))))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_fortran_and_nastran_are_read() {
        for (text, value) in [
            ("1.5", 1.5),
            ("-.5", -0.5),
            ("1.", 1.0),
            ("1.5E+05", 1.5e5),
            ("1.5d-05", 1.5e-5),
            ("-1.5D5", -1.5e5),
            ("1.5+5", 1.5e5),
            ("-2.-3", -2e-3),
            ("1.25-105", 1.25e-105),
            ("+3", 3.0),
        ] {
            assert_eq!(parsed(text), Some(value), "{text}");
        }
        for text in ["nan", "inf", "-infinity", "1e999", "", "-", "1-", "1.5+5+5", "e5", "d", "1,5", "--5", "ä+5"] {
            assert_eq!(parsed(text), None, "{text}");
        }
    }
}
