//! The parts of a cell: groups of its samples that are counted separately.
//!
//! Most jobs have one part in each cell. With Sobol points, each randomisation is a part, and their scatter gives the
//! error. With `until`, the samples between two looks are a part. Whether a cell stops then depends on complete parts
//! only, and not on how the work was shared or interrupted. Parts are numbered over all cells of a job.

use std::ops::Range;

use stickslip_sampler::draw::identity::BLOCK_SAMPLES;
use stickslip_sampler::estimate::looks::Looks;

use crate::job::{Audit, Effort, Job, MapUse};

/// Number of parts of a cell by which pieces number them, with looks. It leaves room for the parts that a higher limit
/// of samples adds.
const STORED_PARTS: u64 = 1024;

/// The parts of all cells of a job.
#[derive(Debug, Clone)]
pub struct Parts {
    cells: u64,
    /// Largest number of samples in each part of a cell.
    samples: Vec<u64>,
    /// Largest number of samples in a unit of work.
    unit_samples: u64,
    looks: Option<Looks>,
}

impl Parts {
    /// The parts of a job.
    pub fn new(job: &Job) -> Self {
        let looks = match &job.sampling.effort {
            Effort::Until(looks) => Some(looks.clone()),
            _ => None,
        };
        Self { cells: job.cells(), samples: job.sampling.parts(), unit_samples: job.unit_samples(), looks }
    }

    /// The audits of a job: one part in each cell, of the samples that check its integral over a map, or of the plain samples
    /// beside its probability.
    pub fn of_audits(job: &Job) -> Self {
        let samples = match job.sampling.audit {
            Audit::Samples(samples) if job.map_use() == MapUse::Integrate => samples,
            _ => job.plain_samples(),
        };
        let are_slow = job.plain_samples() > 0 && job.model().has_very_slow_samples();
        let unit_samples = if are_slow { 1 } else { BLOCK_SAMPLES };
        Self { cells: job.cells(), samples: vec![samples], unit_samples, looks: None }
    }

    /// The parts of a job that has one in each cell.
    #[cfg(test)]
    pub fn plain(cells: u64, samples: u64) -> Self {
        Self { cells, samples: vec![samples], unit_samples: BLOCK_SAMPLES, looks: None }
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

    /// The cell of a part and its index among the parts of that cell.
    pub fn place(&self, part: u64) -> (u64, usize) {
        let parts = self.of_a_cell() as u64;
        (part / parts, (part % parts) as usize)
    }

    /// The parts of a cell.
    pub fn in_cell(&self, cell: u64) -> Range<u64> {
        let parts = self.of_a_cell() as u64;
        cell * parts..(cell + 1) * parts
    }

    /// The number of a part in pieces.
    pub fn stored(&self, part: u64) -> u64 {
        let (cell, place) = self.place(part);
        cell * self.stored_parts() + place as u64
    }

    /// The cell of a part, given its number in pieces, and the part itself; `None` if the job has no such part.
    pub fn locate_stored(&self, stored: u64) -> (u64, Option<u64>) {
        let (cell, place) = (stored / self.stored_parts(), stored % self.stored_parts());
        let parts = self.of_a_cell() as u64;
        (cell, (cell < self.cells && place < parts).then(|| cell * parts + place))
    }

    fn stored_parts(&self) -> u64 {
        if self.looks.is_some() { STORED_PARTS } else { self.of_a_cell() as u64 }
    }

    /// Whether the parts of a cell are computed in order, each only if those before it were not enough. One process
    /// should then compute them all.
    pub fn are_sequential(&self) -> bool {
        self.looks.is_some()
    }

    /// The largest number of samples in the part at `place` in its cell.
    pub fn max_samples(&self, place: usize) -> u64 {
        self.samples[place]
    }

    /// Largest number of samples in a unit of work. Units start at multiples of it.
    pub fn unit_samples(&self) -> u64 {
        self.unit_samples
    }

    /// The number of units of the part at `place` in its cell.
    pub fn units(&self, place: usize) -> u64 {
        self.samples[place].div_ceil(self.unit_samples)
    }

    /// The number of units, over all cells.
    pub fn all_units(&self) -> u128 {
        let of_a_cell: u128 = (0..self.of_a_cell()).map(|place| u128::from(self.units(place))).sum();
        u128::from(self.cells) * of_a_cell
    }

    /// The number of the first sample of the part at `place` in its cell, by which it is drawn. With looks, samples are
    /// numbered over all parts of the cell; with randomisations, within each.
    pub fn first_sample(&self, place: usize) -> u64 {
        match &self.looks {
            Some(looks) if place > 0 => looks.ends()[place - 1],
            _ => 0,
        }
    }

    /// The place of the part that contains a sample, and the sample's number in it. The given number runs over all
    /// parts of the cell.
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
