//! CSV files whose first line names the columns, as programs and spreadsheets write them.
//!
//! Commas, semicolons or tabs separate columns. Numbers have a decimal point, or a decimal comma where commas do not
//! separate columns: where the comma is the decimal mark, Excel separates columns by semicolons. Which of them a file has
//! is found out from the file; one that can be read in two ways is refused. A byte order mark (UTF-8) is skipped.

use std::fmt;
use std::path::{Path, PathBuf};

use csv::{ErrorKind, Reader, ReaderBuilder, StringRecord, Trim};

use super::bounded::{open_regular, read};
use crate::shell::shown;

/// Largest file, in bytes. It may have many columns of which one is read.
const LARGEST: u64 = 64 << 20;

/// Most rows that callers take.
pub const MOST_ROWS: usize = 100_000;

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// What is said of bytes that are no text.
const NOT_TEXT: &str = "this is not text in UTF-8; save the file as \"CSV UTF-8\"";

/// Why a file is refused: the text names file and line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CsvError {
    pub line: Option<u64>,
    text: String,
}

impl fmt::Display for CsvError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.text)
    }
}

/// A file with its names of columns.
#[derive(Debug)]
pub struct CsvFile {
    path: PathBuf,
    bytes: Vec<u8>,
    separator: u8,
    /// The first line.
    pub names: StringRecord,
}

/// A row of a file.
#[derive(Debug)]
pub struct Row {
    pub line: u64,
    fields: StringRecord,
    separator: u8,
    has_decimal_commas: bool,
}

/// The bytes of a CSV file.
///
/// # Errors
/// That it cannot be read.
pub fn read_csv(path: &Path) -> Result<Vec<u8>, String> {
    let bytes = open_regular(path).and_then(|mut file| read(&mut file, LARGEST));
    bytes.map_err(|error| format!("cannot read {}: {error}", shown(path)))
}

fn reader(bytes: &[u8], separator: u8) -> Reader<&[u8]> {
    ReaderBuilder::new().trim(Trim::All).delimiter(separator).from_reader(bytes)
}

impl CsvFile {
    /// The file that has these bytes.
    ///
    /// # Errors
    /// A first line that cannot be read, and one with commas and semicolons of which both may separate columns.
    pub fn new(path: &Path, mut bytes: Vec<u8>) -> Result<Self, CsvError> {
        if bytes.starts_with(BYTE_ORDER_MARK) {
            bytes.drain(..BYTE_ORDER_MARK.len());
        }
        let mut file = Self { path: path.to_owned(), bytes, separator: b',', names: StringRecord::new() };
        file.separator = file.separator_of_columns()?;
        file.names = reader(&file.bytes, file.separator).headers().map_err(|error| file.unreadable(&error))?.clone();
        Ok(file)
    }

    /// What separates the columns. A single column is read as if semicolons did, so that its commas are decimal ones.
    fn separator_of_columns(&self) -> Result<u8, CsvError> {
        let mut is_quoted = false;
        let is_outside = |byte: &u8| {
            is_quoted ^= *byte == b'"';
            !is_quoted
        };
        let text = self.bytes.iter().copied().skip_while(u8::is_ascii_whitespace);
        let outside: Vec<u8> = text.take_while(|byte| !b"\r\n".contains(byte)).filter(is_outside).collect();
        match [b',', b';', b'\t'].map(|separator| outside.contains(&separator)) {
            [true, true, _] => {
                // One of them may stand in a name.
                let fits =
                    [b',', b';'].map(|separator| reader(&self.bytes, separator).records().all(|row| row.is_ok()));
                match fits {
                    [true, false] => Ok(b','),
                    [false, true] => Ok(b';'),
                    _ => Err(self.error(1, "the first line has commas and semicolons, and either may separate the columns; put names that hold one of them in quotes")),
                }
            }
            [true, false, _] => Ok(b','),
            [false, false, true] => Ok(b'\t'),
            [false, ..] => Ok(b';'),
        }
    }

    /// An error in a line.
    pub fn error(&self, line: u64, message: &str) -> CsvError {
        CsvError { line: Some(line), text: format!("{}:{line}: {message}", shown(&self.path)) }
    }

    /// The place of a column.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|other| other == name)
    }

    /// A name that two columns have.
    pub fn twice(&self) -> Option<&str> {
        let count = |name: &&str| self.names.iter().filter(|other| other == name).count();
        self.names.iter().find(|name| count(name) > 1)
    }

    /// The rows but for empty ones, at most one more than [`MOST_ROWS`], with numbers in some columns.
    ///
    /// # Errors
    /// A row that cannot be read, and numbers whose commas may be decimal ones or not.
    pub fn rows(&self, numbers: &[usize]) -> Result<Vec<Row>, CsvError> {
        let mut rows = Vec::new();
        for record in reader(&self.bytes, self.separator).records() {
            let fields = record.map_err(|error| self.unreadable(&error))?;
            // Spreadsheets write empty rows as separators alone.
            if fields.len() > 1 && fields.iter().all(str::is_empty) {
                continue;
            }
            let line = self.line_of(&fields);
            rows.push(Row { line, fields, separator: self.separator, has_decimal_commas: false });
            if rows.len() > MOST_ROWS {
                break;
            }
        }
        if self.has_decimal_commas(&rows, numbers)? {
            rows.iter_mut().for_each(|row| row.has_decimal_commas = true);
        }
        Ok(rows)
    }

    /// Whether numbers have decimal commas.
    fn has_decimal_commas(&self, rows: &[Row], numbers: &[usize]) -> Result<bool, CsvError> {
        let texts = || rows.iter().flat_map(|row| numbers.iter().map(|&place| (row.line, row.text(place))));
        let with = |mark: char| texts().find(|(_, text)| text.contains(mark));
        if self.separator == b',' {
            return Ok(false);
        }
        let Some((line, comma)) = with(',') else { return Ok(false) };
        if let Some((other, point)) = with('.') {
            let message = format!(
                "commas and points are mixed: {comma:?} here and {point:?} in line {other}; write all numbers with one decimal mark, and none between thousands"
            );
            return Err(self.error(line, &message));
        }
        if texts().filter(|(_, text)| text.contains(',')).all(|(_, text)| may_have_thousands(text)) {
            let message = format!(
                "{comma:?} may be {} or {}, and no other number says which; write it with a decimal point, or without a mark between thousands",
                comma.replace(',', "."),
                comma.replace(',', "")
            );
            return Err(self.error(line, &message));
        }
        Ok(true)
    }

    /// The line of a record, whose position is before the empty lines that it follows.
    fn line_of(&self, record: &StringRecord) -> u64 {
        record.position().map_or(0, |position| {
            let rest = self.bytes.get(position.byte() as usize..).unwrap_or_default();
            let space = rest.iter().take_while(|byte| byte.is_ascii_whitespace());
            position.line() + space.filter(|byte| **byte == b'\n').count() as u64
        })
    }

    /// Why it cannot be read, with its place.
    fn unreadable(&self, error: &csv::Error) -> CsvError {
        let line = error.position().map_or(1, csv::Position::line);
        match error.kind() {
            ErrorKind::Utf8 { .. } => self.error(line, NOT_TEXT),
            ErrorKind::UnequalLengths { expected_len, len, .. } => {
                let hint = match self.separator {
                    b',' if len > expected_len => " (numbers with decimal commas need semicolons between columns)",
                    _ => "",
                };
                self.error(line, &format!("there are {len} fields, but the first line has {expected_len}{hint}"))
            }
            _ => CsvError { line: None, text: format!("{}: {error}", shown(&self.path)) },
        }
    }
}

/// Whether commas in a number may stand between its thousands: 1,250 and 1,250,000, but not 0,250 and 12,5.
fn may_have_thousands(text: &str) -> bool {
    let mut groups = text.trim_start_matches(['+', '-']).split(',');
    let are_digits = |group: &str| group.bytes().all(|byte| byte.is_ascii_digit());
    let is_first = |group: &str| (1..=3).contains(&group.len()) && !group.starts_with('0') && are_digits(group);
    groups.next().is_some_and(is_first) && groups.all(|group| group.len() == 3 && are_digits(group))
}

impl Row {
    /// The text in a column.
    pub fn text(&self, place: usize) -> &str {
        self.fields.get(place).unwrap_or_default()
    }

    /// The number in a column of this name.
    ///
    /// # Errors
    /// That it is not a finite number.
    pub fn number(&self, place: usize, column: &str) -> Result<f64, String> {
        let text = self.text(place);
        let parsed = if self.has_decimal_commas { text.replace(',', ".").parse() } else { text.parse() };
        parsed.ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| {
            let hint = if self.separator == b',' && text.contains(',') {
                "; numbers with decimal commas need semicolons between columns"
            } else {
                ""
            };
            format!("{text:?} in column {column:?} is not a finite number, such as 0.41 or 4.1e-1{hint}")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8], numbers: &[&str]) -> Result<Vec<(u64, Vec<f64>)>, String> {
        let file = CsvFile::new(Path::new("data.csv"), bytes.to_vec()).map_err(|error| error.to_string())?;
        let places: Vec<usize> = numbers
            .iter()
            .map(|name| file.place(name).ok_or_else(|| format!("no {name}")))
            .collect::<Result<_, _>>()?;
        let rows = file.rows(&places).map_err(|error| error.to_string())?;
        let of = |row: Row| {
            let values: Result<_, String> =
                places.iter().zip(numbers).map(|(&place, name)| row.number(place, name)).collect();
            Ok((row.line, values.map_err(|message| format!("{}: {message}", row.line))?))
        };
        rows.into_iter().map(of).collect()
    }

    #[test]
    fn separators_and_decimal_marks_are_found_out() {
        let expected = vec![(2, vec![12.5, 0.1]), (4, vec![1e3, -0.25])];
        for text in [
            "v,p\n12.5,0.1\n\n1e3,-.25\n",
            "v;p\n12.5;0.1\n\n1e3;-0.25\n",
            "v;p\r\n12,5;0,1\r\n\r\n1000;-0,25\r\n;\r\n;\r\n",
            "v\tp\n12,5\t0,1\n\n1000\t-0,25\n",
            "\"v\";\"p\"\n\"12,5\";\"0,1\"\n\n1,0e3 ; -0,25",
            "\u{feff}v;p\n12,5;0,1\n\n1000;-0,25\n",
            "\u{feff}v,p\n12.5,0.1\n\n1000,-0.25\n",
            // A comma in a name, as Excel writes it beside semicolons; and the other way round.
            "v;p;Kraft (N, trocken)\n12,5;0,1;x\n\n1000;-0,25;1.234,5\n",
            "v,p,force; dry\n12.5,0.1,1\n\n1000,-0.25,2\n",
            "v,p,\"force; dry\"\n12.5,0.1,1\n\n1000,-0.25,2\n",
            // No number but one tells decimal commas from those between thousands.
            "v;p\n12,500;0,100\n\n1000;-0,250\n",
        ] {
            assert_eq!(read(text.as_bytes(), &["v", "p"]).as_ref(), Ok(&expected), "{text}");
        }
        assert_eq!(read(b"v\n0,41\n0,395\n", &["v"]), Ok(vec![(2, vec![0.41]), (3, vec![0.395])]));
        // Without numbers that are read, nothing needs to be known of them.
        assert_eq!(read(b"v;p\n1;1.234,5\n", &["v"]), Ok(vec![(2, vec![1.0])]));
    }

    #[test]
    fn what_can_be_read_in_two_ways_is_refused_with_words() {
        for (text, words) in [
            ("v;p\n12,5;0.1\n", &["data.csv:2: commas and points are mixed: \"12,5\" here and \"0.1\" in line 2"][..]),
            ("v;p\n12;0,1\n13;0.1\n", &["data.csv:2", "\"0,1\" here and \"0.1\" in line 3", "one decimal mark"]),
            ("v;p\n1.234,5;0,1\n", &["data.csv:2", "between thousands"]),
            ("v;p\n12,500;1\n13,250;1\n", &["data.csv:2: \"12,500\" may be 12.500 or 12500"]),
            ("v,p;q\n1,2;3\n", &["data.csv:1: the first line has commas and semicolons"]),
            ("v,p\n12,5,0,1\n", &["data.csv:2: there are 4 fields, but the first line has 2 (numbers with decimal"]),
            ("v;p\n1;2\n1;2;3\n", &["data.csv:3: there are 3 fields, but the first line has 2"]),
            ("v,p\n1,\"0,1\"\n", &["2: \"0,1\" in column \"p\" is not a finite number", "need semicolons"]),
            ("v;p\n0,1;fast\n", &["2: \"fast\" in column \"p\""]),
            ("v;p\n0,1;0,1,2\n", &["2: \"0,1,2\" in column \"p\""]),
        ] {
            let message = read(text.as_bytes(), &["v", "p"]).unwrap_err();
            assert!(words.iter().all(|word| message.contains(word)), "{text}: {message}");
        }
        let latin1 = read(b"v;Reibw\xe4rme\n1;2\n", &["v"]).unwrap_err();
        assert!(latin1.contains("not text in UTF-8") && latin1.contains("CSV UTF-8"), "{latin1}");
        let utf16 = read(b"\xff\xfev\0;\0p\0\n\0", &["v"]).unwrap_err();
        assert!(utf16.contains("data.csv:1: this is not text in UTF-8"), "{utf16}");
    }

    #[test]
    fn thousands_are_three_digits_after_a_first_group_that_is_not_zero() {
        for text in ["1,250", "-12,500", "1,250,000", "999,999"] {
            assert!(may_have_thousands(text), "{text}");
        }
        for text in ["0,250", "12,5", "1250,125", "1,2500", ",250", "1,25e3", "1,,250", ""] {
            assert!(!may_have_thousands(text), "{text}");
        }
    }
}
