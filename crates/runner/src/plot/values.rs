//! The numbers of a finished run, read from its `surface.parquet`.

use std::path::Path;

use stickslip_sampler::estimate::audit::PlainSamples;
use stickslip_sampler::estimate::interval::Estimate;

use crate::failure::Failure;
use crate::job::Job;
use crate::picture::asked_cell::KnownCell;
use crate::picture::exceptions::Exceptions;
use crate::plot::levels::Levels;
use crate::tables::finished::{FinishedSurface, FinishedValues};
use crate::tables::limits::FinishedLimits;

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
    /// Samples without a certain verdict, and samples that failed.
    pub undecided: Vec<u64>,
    pub failed: Vec<u64>,
    /// Samples outside the model; 0 where these are not counted.
    pub outside: Vec<u64>,
    /// Why a cell has no probability, as the column of that name; 0 where there is none.
    pub distrust: Vec<u64>,
    /// Plain samples beside each probability, where there are some.
    pub plain: Option<Vec<PlainSamples>>,
    /// The largest share of wrong looked-up verdicts that the audit does not exclude, where there is an audit.
    pub unaudited: Option<Vec<Option<f64>>>,
    /// Its limits, if it has some.
    pub limits: Option<FinishedLimits>,
}

impl Values {
    /// Reads a run.
    ///
    /// # Errors
    /// A directory that is no run, a run without its surface, and a surface or limits that cannot be read.
    pub fn read(run: &Path) -> Result<Self, Failure> {
        let surface = FinishedSurface::open(run)?;
        surface.note_other_version();
        let names = ["p_unstable", "p_low", "p_high", "n_samples", "n_unstable", "n_undecided", "n_failed"];
        let [probability, low, high, samples, unstable, undecided, failed] = surface.numbers(names)?;
        // Not all runs have them: those that integrate, over all inputs or over one, count no samples outside the model.
        let cells = probability.len();
        let counts_of = |wanted: &str| -> Result<Vec<u64>, Failure> {
            Ok(match surface.columns(|name| name == wanted)?.pop().map(|column| column.values) {
                Some(FinishedValues::Integer(counts)) => {
                    counts.into_iter().map(|count| count.unwrap_or(0) as u64).collect()
                }
                _ => vec![0; cells],
            })
        };
        let (outside, distrust) = (counts_of("n_outside_physics")?, counts_of("distrust")?);
        let plain = match surface.job.plain_samples() {
            0 => None,
            _ => Some(counts_of("n_audit")?.into_iter().zip(counts_of("n_audit_unstable")?)),
        };
        let plain = plain.map(|counts| counts.map(|(decided, unstable)| PlainSamples { decided, unstable }).collect());
        let unaudited = match surface.columns(|name| name == "p_audit")?.pop().map(|column| column.values) {
            Some(FinishedValues::Real(shares)) => Some(shares),
            _ => None,
        };
        let known = |column: Vec<Option<f64>>| column.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect();
        let counts = |column: Vec<Option<f64>>| column.into_iter().map(|value| value.unwrap_or(0.0) as u64).collect();
        let [samples, unstable, undecided, failed] = [samples, unstable, undecided, failed].map(counts);
        let (low, high) = (known(low), known(high));
        let limits = FinishedLimits::read(run, &surface.job)?;
        let job = surface.job;
        Ok(Self {
            job,
            probability,
            low,
            high,
            samples,
            unstable,
            undecided,
            failed,
            outside,
            distrust,
            plain,
            unaudited,
            limits,
        })
    }

    /// What is known of a cell.
    pub fn known(&self, cell: u64) -> KnownCell {
        let cell = cell as usize;
        KnownCell {
            estimate: Estimate { probability: self.probability[cell], low: self.low[cell], high: self.high[cell] },
            samples: self.samples[cell],
            unstable: self.unstable[cell],
            without_verdict: self.undecided[cell] + self.failed[cell],
            outside: self.outside[cell],
            plain: self.plain.as_ref().map(|plain| plain[cell]),
            unaudited: self.unaudited.as_ref().and_then(|shares| shares[cell]),
            distrust: self.distrust[cell],
        }
    }

    /// Whether nothing scatters, so that all samples of a cell have one verdict.
    pub fn is_certain(&self) -> bool {
        self.job.random.scatters_nothing()
    }

    /// The samples that need a word.
    pub fn exceptions(&self) -> Exceptions {
        let mut exceptions = Exceptions::default();
        for cell in 0..self.samples.len() {
            exceptions.add(self.samples[cell], self.undecided[cell], self.failed[cell], self.outside[cell]);
            exceptions.add_distrust(self.distrust[cell]);
        }
        exceptions
    }

    /// The probabilities that have a line on an area: some levels, and the target of the job; none where nothing scatters.
    pub fn lines(&self) -> Vec<f64> {
        if self.is_certain() {
            return Vec::new();
        }
        let levels = Levels::up_to(self.largest()).lines();
        let target = self.job.target.filter(|target| !levels.contains(target));
        levels.iter().copied().chain(target).collect()
    }

    /// The largest probability.
    pub fn largest(&self) -> f64 {
        self.probability.iter().flatten().fold(0.0, |largest: f64, p| largest.max(*p))
    }
}
