//! The result of a unit of work.

use std::ops::Range;

use stickslip_core::model::verdict::VerdictCounts;
use stickslip_sampler::estimate::distribution::Distribution;

/// The verdict counts of consecutive samples of one part: what a thread returns and a piece holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FinishedUnit {
    /// The part, numbered over all cells.
    pub part: u64,
    /// Its samples, numbered from 0 within the part.
    pub samples: Range<u64>,
    /// Their verdicts.
    pub counts: VerdictCounts,
    /// Settled amplitudes of the unstable samples that settled, if the job records them.
    pub amplitudes: Distribution,
    /// Further sums, see [`SumLayout`](crate::evaluate::sums::SumLayout).
    pub sums: Vec<i64>,
}

impl FinishedUnit {
    /// The number of samples.
    pub fn len(&self) -> u64 {
        self.samples.end - self.samples.start
    }

    /// Adds the samples of `next`, which follow those of this unit in the same part, to this unit.
    pub fn append(&mut self, next: &Self) {
        debug_assert!(self.is_followed_by(next), "samples that do not follow");
        self.samples.end = next.samples.end;
        self.counts += next.counts;
        self.amplitudes.add_all(&next.amplitudes);
        self.sums.iter_mut().zip(&next.sums).for_each(|(sum, more)| *sum += more);
    }

    /// Whether the samples of `next` follow those of this unit in the same part.
    pub fn is_followed_by(&self, next: &Self) -> bool {
        self.part == next.part && self.samples.end == next.samples.start
    }

    /// Whether the counts can belong to the samples.
    pub fn is_consistent(&self) -> bool {
        let VerdictCounts { stable, unstable, undecided, failed } = self.counts;
        let total = [stable, unstable, undecided, failed].into_iter().try_fold(0_u64, u64::checked_add);
        self.samples.start < self.samples.end && total == Some(self.len()) && self.amplitudes.count() <= unstable
    }
}
