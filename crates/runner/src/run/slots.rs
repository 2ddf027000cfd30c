//! Slots: the parts of a cell that are counted apart, and how many samples each still wants.
//!
//! Most jobs have one slot for each cell. Sobol points have one for each randomisation, whose scatter tells their error;
//! jobs with `until` have one for the samples between two looks, so that a decision rests on whole looks alone and comes out
//! the same however the work was shared or interrupted.

use std::ops::Range;

use stickslip_core::VerdictCounts;
use stickslip_sampler::{Estimate, Looks};

use super::tally::Tally;
use crate::job::{Effort, Job};

/// The slots of a job.
#[derive(Debug, Clone)]
pub struct Slots {
    cells: u64,
    /// Samples of each part of a cell at the most.
    parts: Vec<u64>,
    until: Option<(f64, Looks)>,
}

impl Slots {
    /// Of a job.
    pub fn new(job: &Job) -> Self {
        let until = match &job.sampling.effort {
            Effort::Until { half_width, looks } => Some((*half_width, looks.clone())),
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
            Some((_, looks)) if part > 0 => looks.ends()[part - 1],
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
    /// last look that is complete with the counts there.
    fn standing(&self, tally: &Tally, cell: u64) -> (usize, Option<(usize, VerdictCounts)>) {
        let Some((half_width, looks)) = &self.until else { return (self.parts.len(), None) };
        let mut counts = VerdictCounts::default();
        let mut last = None;
        for (part, slot) in self.of(cell).enumerate() {
            if !tally.is_complete(slot, self.parts[part]) {
                return (part + 1, last);
            }
            counts += tally.counts(slot);
            last = Some((part, counts));
            // Samples beyond a look are only there because it was not enough; that need not be found out again.
            let went_on = part + 1 < self.parts.len() && tally.counts(slot + 1).total() > 0;
            if !went_on && looks.is_enough(part, &counts, *half_width) {
                return (part + 1, last);
            }
        }
        (self.parts.len(), last)
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
        let (_, looks) = self.until.as_ref()?;
        let (_, last) = self.standing(tally, cell);
        let nothing = Estimate { probability: None, low: 0.0, high: 1.0 };
        Some(last.map_or(nothing, |(look, counts)| looks.interval(look, &counts)))
    }
}
