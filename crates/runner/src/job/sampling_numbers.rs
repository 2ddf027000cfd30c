//! How many samples and randomisations a cell gets.

use stickslip_sampler::estimate::looks::Looks;
use toml::Spanned;

use super::diagnosis::Complaint;
use super::sampling_spec::SamplingSpec;

/// Samples in one cell by default.
const SAMPLES: u64 = 10_000;

/// Largest number of samples in one cell.
const MOST_SAMPLES: u64 = 1_000_000_000_000_000;

/// Independent randomisations by default, and at most.
const RANDOMISATIONS: u64 = 16;
const MOST_RANDOMISATIONS: u64 = 1000;

/// Largest number of points of one randomisation: Sobol numbers of 32 bits.
const MOST_SOBOL_POINTS: u64 = 1 << 32;

/// How many samples a cell gets, and which of them are counted apart.
#[derive(Debug, Clone, PartialEq)]
pub enum Effort {
    /// So many, counted together; none where probabilities are integrated.
    Samples(u64),
    /// Randomisations of so many Sobol points each, counted apart.
    Randomisations {
        /// How many.
        count: u64,
        /// Points of each.
        points: u64,
    },
    /// Until the interval is narrow enough, looking from time to time; the samples between two looks are counted apart.
    Until(Looks),
}

impl SamplingSpec {
    /// Largest number of samples in each cell.
    pub fn checked_samples(&self) -> Result<u64, Complaint> {
        let (key, samples, span) = match (&self.until, &self.samples) {
            (Some(until), _) => ("until.at_most", until.get_ref().at_most(), Some(until.span())),
            (None, Some(samples)) => ("samples", *samples.get_ref(), Some(samples.span())),
            (None, None) => ("samples", SAMPLES, None),
        };
        if (1..=MOST_SAMPLES).contains(&samples) {
            return Ok(samples);
        }
        let message =
            format!("sampling.{key} = {samples} is out of range: it must be at least 1 and at most {MOST_SAMPLES}");
        Err(Complaint::maybe_at(span, message))
    }

    /// The number of randomisations, or of populations.
    pub fn randomisations(&self) -> u64 {
        self.randomisations.as_ref().map_or(RANDOMISATIONS, |count| *count.get_ref())
    }

    /// Samples shared by randomisations, of which there are so many at least.
    ///
    /// # Errors
    /// Numbers out of range, and samples that randomisations cannot share.
    pub fn shared_by_randomisations(&self, samples: u64, least: u64) -> Result<Effort, Complaint> {
        let count = self.randomisations();
        let span = self.randomisations.as_ref().map(Spanned::span);
        if !(least..=MOST_RANDOMISATIONS).contains(&count) {
            let message = format!(
                "sampling.randomisations = {count} is out of range: it must be at least {least} and at most {MOST_RANDOMISATIONS}"
            );
            return Err(Complaint::maybe_at(span, message));
        }
        if samples / count > MOST_SOBOL_POINTS {
            let message = format!(
                "sampling.samples = {samples} are too many for {count} randomisations: each has at most 2^32 points, all together {}",
                count * MOST_SOBOL_POINTS
            );
            return Err(Complaint::maybe_at(self.samples.as_ref().map(Spanned::span), message));
        }
        if !samples.is_multiple_of(count) {
            let span = self.samples.as_ref().map(Spanned::span).or(span);
            let near = (samples / count).max(1).next_power_of_two() * count;
            let message = format!(
                "sampling.samples = {samples} cannot be shared by {count} randomisations of equal size; powers of two are best, for example samples = {near}"
            );
            return Err(Complaint::maybe_at(span, message));
        }
        Ok(Effort::Randomisations { count, points: samples / count })
    }
}
