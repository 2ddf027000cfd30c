//! Independent randomisations, among which samples are shared.

use toml::Spanned;

use crate::job::diagnosis::Complaint;
use crate::job::sampling::Effort;
use crate::job::sampling_spec::SamplingSpec;

/// Independent randomisations by default, and at most.
const RANDOMISATIONS: u64 = 16;
const MOST_RANDOMISATIONS: u64 = 1000;

/// Largest number of points of one randomisation: Sobol numbers of 32 bits.
const MOST_SOBOL_POINTS: u64 = 1 << 32;

impl SamplingSpec {
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
