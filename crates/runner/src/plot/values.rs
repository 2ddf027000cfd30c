//! The numbers of a finished run, read from its `surface.parquet`.

use std::fs::File;
use std::path::Path;

use arrow::array::{Array, Float64Array, Int64Array};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use crate::failure::Failure;
use crate::job::Job;
use crate::output::quoted;
use crate::store::directory::RunDirectory;

/// A finished run with its probabilities, one for each cell.
pub struct Values {
    pub job: Job,
    /// None where no sample was decided.
    pub probability: Vec<Option<f64>>,
    /// Ends of its confidence interval.
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    /// Samples, and how many of them are unstable; 0 where the probability is integrated.
    pub samples: Vec<u64>,
    pub unstable: Vec<u64>,
}

impl Values {
    /// Reads a run.
    ///
    /// # Errors
    /// A directory that is no run, a run without its surface, and a surface that cannot be read.
    pub fn read(run: &Path) -> Result<Self, Failure> {
        let directory = RunDirectory::view(run)?;
        let job = directory.job()?;
        if !directory.has_surface_of(&job) {
            return Err(Failure::Job(format!(
                "{} has no surface yet; finish it with `stickslip resume {}`",
                run.display(),
                quoted(run)
            )));
        }
        let path = directory.surface();
        let names = ["p_unstable", "p_low", "p_high", "n_samples", "n_unstable"];
        let read = columns(&path, names).map_err(|why| broken(&path, &why));
        let [probability, low, high, samples, unstable] = read?;
        if probability.len() as u64 != job.cells() {
            return Err(broken(
                &path,
                &format!("it has {} rows, and the job {} cells", probability.len(), job.cells()),
            ));
        }
        let known = |column: Vec<Option<f64>>| column.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect();
        let counts = |column: Vec<Option<f64>>| column.into_iter().map(|value| value.unwrap_or(0.0) as u64).collect();
        let (samples, unstable) = (counts(samples), counts(unstable));
        Ok(Self { job, probability, low: known(low), high: known(high), samples, unstable })
    }

    /// The largest probability.
    pub fn largest(&self) -> f64 {
        self.probability.iter().flatten().fold(0.0, |largest: f64, p| largest.max(*p))
    }
}

/// Columns of numbers of a Parquet file, or why they cannot be read.
pub fn columns<const N: usize>(path: &Path, names: [&str; N]) -> Result<[Vec<Option<f64>>; N], String> {
    let file = File::open(path).map_err(|error| error.to_string())?;
    let wrong = |error: &dyn std::fmt::Display| error.to_string();
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|error| wrong(&error))?;
    let mask = ProjectionMask::columns(builder.parquet_schema(), names);
    let reader = builder.with_projection(mask).build().map_err(|error| wrong(&error))?;
    let mut columns: [Vec<Option<f64>>; N] = std::array::from_fn(|_| Vec::new());
    for batch in reader {
        let batch = batch.map_err(|error| wrong(&error))?;
        for (name, values) in names.iter().zip(&mut columns) {
            let Some(column) = batch.column_by_name(name) else {
                return Err(format!("it has no column {name}"));
            };
            if let Some(real) = column.as_any().downcast_ref::<Float64Array>() {
                values.extend(real);
            } else if let Some(whole) = column.as_any().downcast_ref::<Int64Array>() {
                values.extend(whole.iter().map(|value| value.map(|value| value as f64)));
            } else {
                return Err(format!("the column {name} has no numbers"));
            }
        }
    }
    Ok(columns)
}

fn broken(path: &Path, why: &str) -> Failure {
    Failure::InputOutput(format!(
        "{}: not the surface of a run: {why}; `stickslip merge` writes it again from the run's pieces",
        path.display()
    ))
}
