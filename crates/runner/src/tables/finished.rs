//! The surface of a finished run, read back from its `surface.parquet`.

use std::fmt;
use std::fs::File;
use std::mem;
use std::path::Path;

use arrow::array::AsArray as _;
use arrow::datatypes::{DataType, Float64Type, Int64Type, Schema};

use crate::evaluate::sums::SumLayout;
use crate::failure::Failure;
use crate::files::bounded::open_regular;
use crate::files::foreign::{self, Parts};
use crate::files::table::{LONG_NAME, UNIT};
use crate::job::Job;
use crate::messages::{Code, Place};
use crate::output::{note, quoted};
use crate::store::directory::RunDirectory;
use crate::store::file_state::FileState;
use crate::tables::columns::{self, Column};

/// A finished run with a surface that is as it was written.
pub struct FinishedSurface {
    /// The job of the run.
    pub job: Job,
    directory: RunDirectory,
    is_of_another_version: bool,
}

/// A column with its values, one for each cell.
pub struct FinishedColumn {
    /// Name.
    pub name: String,
    /// Unit; `1` for a pure number.
    pub unit: String,
    /// Meaning.
    pub long_name: String,
    /// Values.
    pub values: FinishedValues,
}

/// The values of a column, `None` where a cell has none.
pub enum FinishedValues {
    /// Counts and indices.
    Integer(Vec<Option<i64>>),
    /// Numbers.
    Real(Vec<Option<f64>>),
}

impl FinishedSurface {
    /// Opens a run.
    ///
    /// # Errors
    /// A directory that is no run, and a run without its surface.
    pub fn open(run: &Path) -> Result<Self, Failure> {
        let directory = RunDirectory::view(run)?;
        let job = directory.job_to_read()?;
        match directory.surface_state(&job)? {
            FileState::Sound => Ok(Self { job, directory, is_of_another_version: false }),
            FileState::OfAnotherVersion => Ok(Self { job, directory, is_of_another_version: true }),
            FileState::Damaged(why) => {
                // Integrals have no pieces to write it from.
                let command = if job.draws_samples() { "verify" } else { "resume" };
                let (surface, remedy) = (directory.surface(), format!("stickslip {command} {}", quoted(run)));
                let text = format!("{} is damaged: {why}; `{remedy}` writes it again", surface.display());
                Err(Failure::InputOutput(text).coded(Code::Damaged).at(Place::file(&surface)).remedied(remedy))
            }
            FileState::Absent | FileState::OfAnotherJob if directory.in_use() => {
                let status = format!("stickslip status {}", quoted(run));
                let text = format!(
                    "{} has no surface yet: it is being computed; `{status}` shows its progress",
                    run.display()
                );
                Err(Failure::Job(text).coded(Code::Incomplete).remedied(status))
            }
            FileState::Absent | FileState::OfAnotherJob => {
                let resume = format!("stickslip resume {}", quoted(run));
                let text = format!("{} has no surface yet; finish it with `{resume}`", run.display());
                Err(Failure::Job(text).coded(Code::Incomplete).remedied(resume))
            }
        }
    }

    /// Writes a note that another version of stickslip computed the surface, if one did.
    pub fn note_other_version(&self) {
        if self.is_of_another_version {
            note(format_args!(
                "{} was computed by another version of stickslip, with another results version or format version than this one has; its values are shown as they are",
                self.directory.surface().display()
            ));
        }
    }

    /// Reads the columns whose names are wanted, in the order of the file.
    ///
    /// # Errors
    /// A file that cannot be read or is not the surface of the job, and columns that hold no numbers.
    pub fn columns(&self, wanted: impl Fn(&str) -> bool) -> Result<Vec<FinishedColumn>, Failure> {
        let mut columns = self.read(wanted)?;
        self.describe(&mut columns);
        Ok(columns)
    }

    /// As [`FinishedSurface::columns`], without units and meanings.
    fn read(&self, wanted: impl Fn(&str) -> bool) -> Result<Vec<FinishedColumn>, Failure> {
        let file = self.directory.open_surface()?.ok_or_else(|| self.broken("it is gone"))?;
        let columns = read_columns(file, Some(self.job.cells()), wanted).map_err(|why| self.broken(why))?;
        let wrong = columns.iter().map(|column| column.values.len()).find(|rows| *rows as u64 != self.job.cells());
        match wrong {
            None => Ok(columns),
            Some(rows) => Err(self.broken(format!("it has {rows} rows, and the job {} cells", self.job.cells()))),
        }
    }

    /// Gives columns the units and meanings that they have in a surface of this version. Other columns, of other
    /// versions, keep none.
    fn describe(&self, columns: &mut [FinishedColumn]) {
        let described: Vec<_> =
            columns::for_job(&self.job, SumLayout::for_job(&self.job)).iter().map(Column::field).collect();
        for column in columns {
            if let Some(field) = described.iter().find(|field| *field.name() == column.name) {
                (column.unit, column.long_name) = (field.metadata()[UNIT].clone(), field.metadata()[LONG_NAME].clone());
            }
        }
    }

    /// Reads columns of numbers by their names.
    ///
    /// # Errors
    /// As [`FinishedSurface::columns`], and a column that is missing.
    pub fn numbers<const N: usize>(&self, names: [&str; N]) -> Result<[Vec<Option<f64>>; N], Failure> {
        let columns = self.read(|name| names.contains(&name))?;
        numbers_of(columns, names).map_err(|why| self.broken(why))
    }

    /// The failure of a file that is not what its run should have.
    pub fn broken(&self, why: impl fmt::Display) -> Failure {
        let surface = self.directory.surface();
        let resume = format!("stickslip resume {}", quoted(self.directory.path()));
        Failure::InputOutput(format!(
            "{}: not the surface of a run: {why}; `{resume}` writes it again",
            surface.display()
        ))
        .coded(Code::Damaged)
        .at(Place::file(&surface))
        .remedied(resume)
    }
}

/// Reads columns of numbers of any Parquet file by their names, or says why they cannot be read.
///
/// # Errors
/// A file that is no Parquet file, and a column that is missing or holds no numbers.
pub fn read_numbers<const N: usize>(path: &Path, names: [&str; N]) -> Result<[Vec<Option<f64>>; N], String> {
    let file = open_regular(path).map_err(|error| error.to_string())?;
    numbers_of(read_columns(file, None, |name| names.contains(&name))?, names)
}

fn read_columns(file: File, rows: Option<u64>, wanted: impl Fn(&str) -> bool) -> Result<Vec<FinishedColumn>, String> {
    foreign::read(file, rows, wanted, columns_of)
}

/// All columns of a table, which hold numbers.
fn columns_of(schema: &Schema, parts: Parts<'_>) -> Result<Vec<FinishedColumn>, String> {
    let columns = schema.fields().iter().map(|field| {
        let values = match field.data_type() {
            DataType::Int64 => FinishedValues::Integer(Vec::new()),
            DataType::Float64 => FinishedValues::Real(Vec::new()),
            other => return Err(format!("its column {} holds {other}, not numbers of 64 bits", field.name())),
        };
        Ok(FinishedColumn { name: field.name().clone(), unit: String::new(), long_name: String::new(), values })
    });
    let mut columns: Vec<FinishedColumn> = columns.collect::<Result<_, _>>()?;
    for part in parts {
        let part = part?;
        for (column, array) in columns.iter_mut().zip(part.columns()) {
            match &mut column.values {
                FinishedValues::Integer(values) => values.extend(array.as_primitive::<Int64Type>()),
                FinishedValues::Real(values) => values.extend(array.as_primitive::<Float64Type>()),
            }
        }
    }
    Ok(columns)
}

/// The values of columns by their names, counts as numbers too.
fn numbers_of<const N: usize>(
    mut columns: Vec<FinishedColumn>,
    names: [&str; N],
) -> Result<[Vec<Option<f64>>; N], String> {
    let mut numbers: [Vec<Option<f64>>; N] = std::array::from_fn(|_| Vec::new());
    for (name, numbers) in names.iter().zip(&mut numbers) {
        *numbers = match columns.iter_mut().find(|column| column.name == *name).map(|column| &mut column.values) {
            Some(FinishedValues::Real(values)) => mem::take(values),
            Some(FinishedValues::Integer(values)) => {
                values.iter().map(|value| value.map(|value| value as f64)).collect()
            }
            None => return Err(format!("it has no column {name}")),
        };
    }
    Ok(numbers)
}

impl FinishedValues {
    fn len(&self) -> usize {
        match self {
            Self::Integer(values) => values.len(),
            Self::Real(values) => values.len(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::forging::{assert_bounded, file_of};
    use crate::files::table::{DescribedColumn, write_columns};

    #[test]
    fn forged_tables_are_read_or_refused() {
        let directory = tempfile::tempdir().unwrap();
        let column = |name, values: &dyn Fn(f64) -> f64| DescribedColumn {
            name,
            unit: "1",
            long_name: name,
            values: (0..300).map(|i| values(f64::from(i))).collect(),
        };
        let columns = [column("time", &|i| 0.1 * i), column("level", &|i| (i / 100.0).floor())];
        write_columns(directory.path(), "motion.parquet", &columns).unwrap();
        let path = directory.path().join("motion.parquet");
        let [time, level] = read_numbers(&path, ["time", "level"]).unwrap();
        assert_eq!((time.len(), time[3], level[299]), (300, Some(0.1 * 3.0), Some(2.0)));
        let sound = [std::fs::read(path).unwrap()];
        assert_bounded("tables::finished::tests::forged_tables_are_read_or_refused", &sound, 1500, |bytes| {
            read_columns(file_of(&bytes), None, |_| true).map(drop)
        });
    }
}
