//! The parts of a cell: groups of its samples that are counted apart.
//!
//! Most jobs have one part for each cell. Sobol points have one for each randomisation, whose scatter tells their error;
//! jobs with `until` have one for the samples between two looks, so that a decision rests on whole looks alone and is the
//! same however the work was shared or interrupted. Parts are numbered over all cells of a job.

use std::ops::Range;

use stickslip_sampler::estimate::looks::Looks;

use crate::job::{Effort, Job};

/// With looks, pieces number the parts of a cell as if there were so many: a higher limit of samples adds parts.
const STORED_PARTS: u64 = 1024;

/// The parts of all cells of a job.
#[derive(Debug, Clone)]
pub struct Parts {
    cells: u64,
    /// Samples of each part of a cell at the most.
    samples: Vec<u64>,
    looks: Option<Looks>,
}

impl Parts {
    /// Of a job.
    pub fn new(job: &Job) -> Self {
        let looks = match &job.sampling.effort {
            Effort::Until(looks) => Some(looks.clone()),
            _ => None,
        };
        Self { cells: job.cells(), samples: job.sampling.parts(), looks }
    }

    /// Of a job with one part for each cell.
    #[cfg(test)]
    pub fn plain(cells: u64, samples: u64) -> Self {
        Self { cells, samples: vec![samples], looks: None }
    }

    /// The number of parts, over all cells.
    pub fn count(&self) -> u64 {
        self.cells * self.of_a_cell() as u64
    }

    /// The number of cells.
    pub fn cells(&self) -> u64 {
        self.cells
    }

    /// The number of parts of each cell.
    pub fn of_a_cell(&self) -> usize {
        self.samples.len()
    }

    /// The looks of a job with `until`.
    pub fn looks(&self) -> Option<&Looks> {
        self.looks.as_ref()
    }

    /// The cell of a part, and its place among the parts of that cell.
    pub fn place(&self, part: u64) -> (u64, usize) {
        let parts = self.of_a_cell() as u64;
        (part / parts, (part % parts) as usize)
    }

    /// The parts of a cell.
    pub fn of(&self, cell: u64) -> Range<u64> {
        let parts = self.of_a_cell() as u64;
        cell * parts..(cell + 1) * parts
    }

    /// The number of a part in pieces.
    pub fn stored(&self, part: u64) -> u64 {
        let (cell, place) = self.place(part);
        cell * self.stored_parts() + place as u64
    }

    /// The cell of a part by its number in pieces, and the part itself, unless the job has no such part of its cells.
    pub fn locate_stored(&self, stored: u64) -> (u64, Option<u64>) {
        let (cell, place) = (stored / self.stored_parts(), stored % self.stored_parts());
        let parts = self.of_a_cell() as u64;
        (cell, (cell < self.cells && place < parts).then(|| cell * parts + place))
    }

    fn stored_parts(&self) -> u64 {
        if self.looks.is_some() { STORED_PARTS } else { self.of_a_cell() as u64 }
    }

    /// Whether the parts of a cell depend on each other, so that one process had better compute them all.
    pub fn are_decided_in_turn(&self) -> bool {
        self.looks.is_some()
    }

    /// Samples at the most of the part at `place` in its cell.
    pub fn most(&self, place: usize) -> u64 {
        self.samples[place]
    }

    /// The number by which the first sample of the part at `place` in its cell is drawn. With looks, samples are numbered over
    /// all parts of the cell; randomisations number their own.
    pub fn first_sample(&self, place: usize) -> u64 {
        match &self.looks {
            Some(looks) if place > 0 => looks.ends()[place - 1],
            _ => 0,
        }
    }

    /// The place of the part with a sample, numbered over all parts of its cell, and the sample's number in that part.
    pub fn locate(&self, sample: u64) -> (usize, u64) {
        let mut before = 0;
        for (place, &samples) in self.samples.iter().enumerate() {
            if sample < before + samples {
                return (place, sample - before);
            }
            before += samples;
        }
        (self.samples.len() - 1, sample - before)
    }
}
