//! Slots: the parts of a cell that are counted apart, and how many samples each still wants.
//!
//! Most jobs have one slot for each cell. Sobol points have one for each randomisation, whose scatter tells their error;
//! jobs with `until` have one for the samples between two looks, so that a decision rests on whole looks alone and comes out
//! the same however the work was shared or interrupted.

use std::ops::Range;

use stickslip_core::verdict::VerdictCounts;
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::estimate::sequential::Looks;

use crate::job::{Effort, Job};
use crate::store::tally::Tally;

/// With looks, pieces number the parts of a cell as if there were so many: a higher limit of samples adds parts.
const STORED_PARTS: u64 = 1024;

/// The slots of a job.
#[derive(Debug, Clone)]
pub struct Slots {
    cells: u64,
    /// Samples of each part of a cell at the most.
    parts: Vec<u64>,
    until: Option<Looks>,
}

impl Slots {
    /// Of a job.
    pub fn new(job: &Job) -> Self {
        let until = match &job.sampling.effort {
            Effort::Until(looks) => Some(looks.clone()),
            _ => None,
        };
        Self { cells: job.cells(), parts: job.sampling.parts(), until }
    }

    /// Of a job with one slot for each cell.
    #[cfg(test)]
    pub fn plain(cells: u64, samples: u64) -> Self {
        Self { cells, parts: vec![samples], until: None }
    }

    /// The number of slots.
    pub fn count(&self) -> u64 {
        self.cells * self.parts.len() as u64
    }

    /// The cell of a slot, and its part of it.
    pub fn place(&self, slot: u64) -> (u64, usize) {
        let parts = self.parts.len() as u64;
        (slot / parts, (slot % parts) as usize)
    }

    /// The number of a slot in pieces.
    pub fn stored(&self, slot: u64) -> u64 {
        let (cell, part) = self.place(slot);
        cell * self.stored_parts() + part as u64
    }

    /// The cell of a slot by its number in pieces, and the slot itself, unless the job has no such part of its cells.
    pub fn locate_stored(&self, stored: u64) -> (u64, Option<u64>) {
        let (cell, part) = (stored / self.stored_parts(), stored % self.stored_parts());
        let parts = self.parts.len() as u64;
        (cell, (cell < self.cells && part < parts).then(|| cell * parts + part))
    }

    fn stored_parts(&self) -> u64 {
        if self.until.is_some() { STORED_PARTS } else { self.parts.len() as u64 }
    }

    /// The slots of a cell.
    pub fn of(&self, cell: u64) -> Range<u64> {
        let parts = self.parts.len() as u64;
        cell * parts..(cell + 1) * parts
    }

    /// Whether the slots of a cell depend on each other, so that one process had better compute them all.
    pub fn are_decided_in_turn(&self) -> bool {
        self.until.is_some()
    }

    /// The number, in its cell, of the first sample of a part.
    pub fn first_sample(&self, part: usize) -> u64 {
        match &self.until {
            Some(looks) if part > 0 => looks.ends()[part - 1],
            _ => 0,
        }
    }

    /// The part with a sample, numbered over all parts of its cell, and its number there.
    pub fn locate(&self, sample: u64) -> (usize, u64) {
        let mut before = 0;
        for (part, &samples) in self.parts.iter().enumerate() {
            if sample < before + samples {
                return (part, sample - before);
            }
            before += samples;
        }
        (self.parts.len() - 1, sample - before)
    }

    /// Samples that a part has at the most.
    pub fn most(&self, part: usize) -> u64 {
        self.parts[part]
    }

    /// How far a cell is: the parts that are wanted, as far as can be said now (all of them, or up to the next look), and the
    /// counts at every look that is complete.
    fn standing(&self, tally: &Tally, cell: u64) -> (usize, Vec<VerdictCounts>) {
        let Some(looks) = &self.until else { return (self.parts.len(), Vec::new()) };
        let mut counts = VerdictCounts::default();
        let mut complete = Vec::new();
        for (part, slot) in self.of(cell).enumerate() {
            if !tally.is_complete(slot, self.parts[part]) {
                return (part + 1, complete);
            }
            counts += tally.counts(slot);
            complete.push(counts);
            // Samples beyond a look are only there because it was not enough; that need not be found out again.
            let went_on = part + 1 < self.parts.len() && tally.counts(slot + 1).total() > 0;
            if !went_on && looks.is_enough(part, &counts) {
                return (part + 1, complete);
            }
        }
        (self.parts.len(), complete)
    }

    /// The samples that are wanted of each slot, as far as can be said now.
    pub fn wanted(&self, tally: &Tally) -> Vec<u64> {
        let of_cell = |cell: u64| {
            let (wanted, _) = self.standing(tally, cell);
            self.parts.iter().enumerate().map(move |(part, &samples)| if part < wanted { samples } else { 0 })
        };
        (0..self.cells).flat_map(of_cell).collect()
    }

    /// Whether a cell has all its samples.
    pub fn is_complete(&self, tally: &Tally, cell: u64) -> bool {
        let (wanted, _) = self.standing(tally, cell);
        self.of(cell).take(wanted).enumerate().all(|(part, slot)| tally.is_complete(slot, self.parts[part]))
    }

    /// Cells that have all their samples.
    pub fn complete_cells(&self, tally: &Tally) -> u64 {
        (0..self.cells).filter(|&cell| self.is_complete(tally, cell)).count() as u64
    }

    /// The verdicts of a cell, over all its parts.
    pub fn counts(&self, tally: &Tally, cell: u64) -> VerdictCounts {
        self.of(cell).fold(VerdictCounts::default(), |counts, slot| counts + tally.counts(slot))
    }

    /// With `until`, the estimate at the look at which a cell stopped, or at the last one that is complete.
    pub fn estimate_at_stop(&self, tally: &Tally, cell: u64) -> Option<Estimate> {
        let looks = self.until.as_ref()?;
        Some(looks.estimate(&self.standing(tally, cell).1))
    }

    /// The share of the error that belongs to the look at which a cell stopped; all of it without looks.
    pub fn error_share_at_stop(&self, tally: &Tally, cell: u64) -> f64 {
        let Some(looks) = &self.until else { return 1.0 };
        self.standing(tally, cell).1.len().checked_sub(1).map_or(1.0, |look| looks.error_share(look))
    }
}
