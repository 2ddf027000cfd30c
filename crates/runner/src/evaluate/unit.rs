//! The result of a unit of work.

use std::ops::Range;

use stickslip_core::model::recorded::{MOST_RECORDED, RecordedOf, RecordedResult};
use stickslip_core::model::verdict::VerdictCounts;
use stickslip_sampler::estimate::distribution::Distribution;

/// The distributions of what a job records, in the order of [`Model::recorded`](stickslip_core::model::Model::recorded).
pub type Recorded = [Distribution; MOST_RECORDED];

/// Adds the values of `more` to those of `recorded`.
pub fn add_recorded(recorded: &mut Recorded, more: &Recorded) {
    recorded.iter_mut().zip(more).for_each(|(own, more)| own.add_all(more));
}

/// The verdict counts of consecutive samples of one part: what a thread returns and a piece holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FinishedUnit {
    /// The part, numbered over all cells.
    pub part: u64,
    /// Its samples, numbered from 0 within the part.
    pub samples: Range<u64>,
    /// Their verdicts.
    pub counts: VerdictCounts,
    /// What is recorded of them.
    pub recorded: Recorded,
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
        add_recorded(&mut self.recorded, &next.recorded);
        self.sums.iter_mut().zip(&next.sums).for_each(|(sum, more)| *sum += more);
    }

    /// Whether the samples of `next` follow those of this unit in the same part.
    pub fn is_followed_by(&self, next: &Self) -> bool {
        self.part == next.part && self.samples.end == next.samples.start
    }

    /// Whether the counts can belong to the samples of a job that records these results.
    pub fn is_consistent(&self, recorded: &[RecordedResult]) -> bool {
        let VerdictCounts { stable, unstable, undecided, failed } = self.counts;
        let total = [stable, unstable, undecided, failed].into_iter().try_fold(0_u64, u64::checked_add);
        let most = |place: usize| match recorded.get(place).map(|result| result.of) {
            None => 0,
            Some(RecordedOf::Unstable) => unstable,
            Some(RecordedOf::All) => self.len(),
        };
        let mut counts = self.recorded.iter().map(Distribution::count).enumerate();
        self.samples.start < self.samples.end
            && total == Some(self.len())
            && counts.all(|(place, count)| count <= most(place))
            && self.recorded.iter().all(Distribution::can_be)
    }
}
