//! The samples of a job that are still wanted, and the estimates of cells that stop by precision.

use std::ops::Range;

use stickslip_core::model::verdict::VerdictCounts;
use stickslip_sampler::estimate::interval::Estimate;

use crate::evaluate::parts::Parts;
use crate::store::tally::Tally;

/// Most cells from which the number of samples of all cells is expected.
const MOST_EXPECTED_CELLS: u64 = 1000;

impl Parts {
    /// The number of parts of a cell that are wanted now (all of them, or those up to the next look), and the counts at
    /// every complete look.
    fn progress(&self, tally: &Tally, cell: u64) -> (usize, Vec<VerdictCounts>) {
        let Some(looks) = self.looks() else { return (self.of_a_cell(), Vec::new()) };
        let mut counts = VerdictCounts::default();
        let mut complete = Vec::new();
        for (place, part) in self.in_cell(cell).enumerate() {
            if !tally.is_complete(part, self.max_samples(place)) {
                return (place + 1, complete);
            }
            counts += tally.counts(part);
            complete.push(counts);
            // Samples beyond a look are there only because the look was not enough, so it need not be checked again.
            let went_on = place + 1 < self.of_a_cell() && tally.counts(part + 1).total() > 0;
            if !went_on && looks.is_enough(place, &counts) {
                return (place + 1, complete);
            }
        }
        (self.of_a_cell(), complete)
    }

    /// The samples of a cell that are wanted now and missing, by part.
    pub fn missing_of<'a>(&'a self, tally: &'a Tally, cell: u64) -> impl Iterator<Item = (u64, Range<u64>)> + 'a {
        let (wanted, _) = self.progress(tally, cell);
        self.in_cell(cell)
            .take(wanted)
            .enumerate()
            .flat_map(|(place, part)| tally.gaps(part, self.max_samples(place)).into_iter().map(move |gap| (part, gap)))
    }

    /// The number of samples that are expected to be still missing with looks, from the counts so far. `None` without
    /// looks, and before every cell has had its first.
    pub fn expected_to_be_missing(&self, tally: &Tally) -> Option<u128> {
        let looks = self.looks()?;
        // Some cells stand for all.
        let stride = self.cells().div_ceil(MOST_EXPECTED_CELLS);
        let mut missing = 0;
        for cell in (0..self.cells()).step_by(stride as usize) {
            let (_, complete) = self.progress(tally, cell);
            let counts = complete.last()?;
            let counted = self.counts(tally, cell).total();
            if !self.is_complete(tally, cell) {
                let end = looks.expected_end(complete.len(), counts);
                missing += u128::from(end.saturating_sub(counted) * stride);
            }
        }
        Some(missing)
    }

    /// Whether a cell has all its samples; never where none are drawn.
    pub fn is_complete(&self, tally: &Tally, cell: u64) -> bool {
        let (wanted, _) = self.progress(tally, cell);
        self.all_units() > 0
            && self
                .in_cell(cell)
                .take(wanted)
                .enumerate()
                .all(|(place, part)| tally.is_complete(part, self.max_samples(place)))
    }

    /// Whether every cell has all its samples.
    pub fn are_complete(&self, tally: &Tally) -> bool {
        (0..self.cells()).all(|cell| self.is_complete(tally, cell))
    }

    /// The number of cells that have all their samples.
    pub fn complete_cells(&self, tally: &Tally) -> u64 {
        (0..self.cells()).filter(|&cell| self.is_complete(tally, cell)).count() as u64
    }

    /// The verdict counts of a cell, over all its parts.
    pub fn counts(&self, tally: &Tally, cell: u64) -> VerdictCounts {
        self.in_cell(cell).fold(VerdictCounts::default(), |counts, part| counts + tally.counts(part))
    }

    /// The estimate at the look at which a cell stopped, or at its last complete look; `None` for jobs without `until`.
    pub fn estimate_at_stop(&self, tally: &Tally, cell: u64) -> Option<Estimate> {
        let looks = self.looks()?;
        Some(looks.estimate(&self.progress(tally, cell).1))
    }

    /// The share of the error probability that belongs to the look at which a cell stopped; 1 for jobs without `until`.
    pub fn error_share_at_stop(&self, tally: &Tally, cell: u64) -> f64 {
        let Some(looks) = self.looks() else { return 1.0 };
        self.progress(tally, cell).1.len().checked_sub(1).map_or(1.0, |look| looks.error_share(look))
    }
}
