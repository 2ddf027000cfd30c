//! Measured values from CSV files.

use std::path::Path;

use csv::{ErrorKind, ReaderBuilder, Trim};
use stickslip_sampler::inputs::{Empirical, EmpiricalError};

use super::keys::nearest;
use crate::files::bounded::read_file;

/// Largest number of values. All of them stand in the frozen job and in the footer of its result.
pub const MOST_VALUES: usize = 100_000;

/// Largest CSV file, in bytes. It may have many columns of which one is read.
const LARGEST: u64 = 64 << 20;

/// The bytes of a CSV file.
pub fn read_csv(path: &Path) -> Result<Vec<u8>, String> {
    read_file(path, LARGEST).map_err(|error| format!("cannot read {}: {error}", path.display()))
}

/// The distribution of a list of values.
pub fn from_values(values: &[f64]) -> Result<Empirical, String> {
    if values.len() > MOST_VALUES {
        return Err(format!("{} values are too many; the limit is {MOST_VALUES}", values.len()));
    }
    Empirical::new(values).map_err(|error: EmpiricalError| error.to_string())
}

/// The distribution of one column of a CSV file: names in the first line, decimals with a point. Says file, line and
/// value where it cannot be read.
pub fn from_csv(path: &Path, column: &str) -> Result<Empirical, String> {
    let shown = path.display();
    let bytes = read_csv(path)?;
    let mut reader = ReaderBuilder::new().trim(Trim::All).from_reader(&bytes[..]);
    let names = reader.headers().map_err(|error| unreadable(path, &error))?.clone();
    let Some(place) = names.iter().position(|name| name == column) else {
        let hint = nearest(column, &names).map_or(String::new(), |name| format!("; did you mean \"{name}\"?"));
        let there: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
        return Err(format!(
            "{shown}:1: there is no column \"{column}\"{hint} (the first line should name the columns, separated by commas; it has {})",
            there.join(", ")
        ));
    };
    if names.iter().filter(|name| *name == column).count() > 1 {
        return Err(format!("{shown}:1: two columns are named \"{column}\""));
    }
    let mut values = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| unreadable(path, &error))?;
        let line = record.position().map_or(0, csv::Position::line);
        let text = record.get(place).unwrap_or_default();
        values.push(finite_number(text, column).map_err(|message| format!("{shown}:{line}: {message}"))?);
    }
    from_values(&values).map_err(|message| format!("{shown}, column \"{column}\": {message}"))
}

/// A value in a column of a CSV file.
///
/// # Errors
/// That it is not a finite number.
pub fn finite_number(text: &str, column: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|value: &f64| value.is_finite())
        .ok_or_else(|| format!("\"{text}\" in column \"{column}\" is not a finite number, such as 0.41 or 4.1e-1"))
}

/// Why a CSV file cannot be read, with its place.
pub fn unreadable(path: &Path, error: &csv::Error) -> String {
    let shown = path.display();
    let line = error.position().map_or(String::new(), |position| format!(":{}", position.line()));
    match error.kind() {
        ErrorKind::Io(error) => format!("cannot read {shown}: {error}"),
        ErrorKind::Utf8 { .. } => format!("{shown}{line}: this is not text in UTF-8"),
        ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("{shown}{line}: there are {len} fields, but the first line has {expected_len}")
        }
        _ => format!("{shown}: {error}"),
    }
}
