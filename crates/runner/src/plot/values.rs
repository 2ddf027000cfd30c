//! The numbers of a finished run, read from its `surface.parquet`.

use std::path::Path;

use crate::failure::Failure;
use crate::job::Job;
use crate::tables::finished::FinishedSurface;

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
        let surface = FinishedSurface::open(run)?;
        let names = ["p_unstable", "p_low", "p_high", "n_samples", "n_unstable"];
        let [probability, low, high, samples, unstable] = surface.numbers(names)?;
        let known = |column: Vec<Option<f64>>| column.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect();
        let counts = |column: Vec<Option<f64>>| column.into_iter().map(|value| value.unwrap_or(0.0) as u64).collect();
        let (samples, unstable) = (counts(samples), counts(unstable));
        Ok(Self { job: surface.job, probability, low: known(low), high: known(high), samples, unstable })
    }

    /// The largest probability.
    pub fn largest(&self) -> f64 {
        self.probability.iter().flatten().fold(0.0, |largest: f64, p| largest.max(*p))
    }
}
