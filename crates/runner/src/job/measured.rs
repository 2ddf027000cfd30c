//! Measured values from CSV files.

use std::path::Path;

use stickslip_sampler::inputs::{Empirical, EmpiricalError};

use super::keys::nearest;
use crate::files::csv_file::{CsvFile, MOST_ROWS, read_csv};
use crate::shell::shown;

/// Largest number of values. All of them stand in the frozen job and in the footer of its result.
const MOST_VALUES: usize = MOST_ROWS;

/// The distribution of a list of values.
pub fn from_values(values: &[f64]) -> Result<Empirical, String> {
    if values.len() > MOST_VALUES {
        return Err(format!("{} values are too many; the limit is {MOST_VALUES}", values.len()));
    }
    Empirical::new(values).map_err(|error: EmpiricalError| error.to_string())
}

/// The distribution of one column of a CSV file with names in the first line. Says file, line and value where it cannot be
/// read.
pub fn from_csv(path: &Path, column: &str) -> Result<Empirical, String> {
    let file = CsvFile::new(path, read_csv(path)?).map_err(|error| error.to_string())?;
    let refused = |line: u64, message: &str| file.error(line, message).to_string();
    let Some(place) = file.place(column) else {
        let hint = nearest(column, &file.names).map_or(String::new(), |name| format!("; did you mean \"{name}\"?"));
        let there: Vec<String> = file.names.iter().map(|name| format!("\"{name}\"")).collect();
        return Err(refused(
            1,
            &format!(
                "there is no column \"{column}\"{hint} (the first line should name the columns, separated by commas or semicolons; it has {})",
                there.join(", ")
            ),
        ));
    };
    if file.names.iter().filter(|name| *name == column).count() > 1 {
        return Err(refused(1, &format!("two columns are named \"{column}\"")));
    }
    let mut values = Vec::new();
    for row in file.rows(&[place]).map_err(|error| error.to_string())? {
        values.push(row.number(place, column).map_err(|message| refused(row.line, &message))?);
    }
    from_values(&values).map_err(|message| format!("{}, column \"{column}\": {message}", shown(path)))
}
