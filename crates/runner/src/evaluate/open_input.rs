//! A cell in which some of what it consists of may have any value, for integrals over one input with critical values.

use stickslip_core::model::critical_values::Memory;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::{DeviateLaw, InputDistribution};
use stickslip_sampler::integrate::closed_form::ExactProbability;
use stickslip_sampler::integrate::one_input;

use crate::evaluate::open_cell::Open;
use crate::evaluate::unstable_values::UnstableValuesOfInput;
use crate::job::Job;

/// A cell of a job with one random input.
pub struct OpenInput<'a> {
    job: &'a Job,
    cell: Cell,
    /// The quantity that scatters.
    place: usize,
    /// Its distributions lie within this whatever is open.
    reach: [f64; 2],
    unstable: UnstableValuesOfInput,
}

impl<'a> OpenInput<'a> {
    /// A cell whose quantity at `place` scatters, of which some is open, between these ends.
    pub fn new(job: &'a Job, cell: u64, place: usize, open: &[Open], ends: &[[f64; 2]]) -> Self {
        let cell = job.grid.cell(cell);
        let reach = [f64::INFINITY, f64::NEG_INFINITY];
        let mut own = Self { job, cell, place, reach, unstable: UnstableValuesOfInput::default() };
        // A distribution reaches farthest where its expected value and its standard deviation have their ends.
        for corner in 0..1_usize << ends.len() {
            let at: Vec<f64> = ends.iter().enumerate().map(|(i, ends)| ends[corner >> i & 1]).collect();
            if let Some(distribution) = own.distribution(&own.with(open, &at), open, &at) {
                let [low, high] = one_input::reach(&distribution, DeviateLaw::INDEPENDENT);
                own.reach = [own.reach[0].min(low), own.reach[1].max(high)];
            }
        }
        own
    }

    /// The quantity that scatters.
    pub fn place(&self) -> usize {
        self.place
    }

    /// The probability with these values of what is open; `None` if critical values cannot be found, or `memory` ends the search.
    pub fn probability(&self, open: &[Open], values: &[f64], memory: &dyn Memory) -> Option<ExactProbability> {
        let cell = self.with(open, values);
        let distribution = self.distribution(&cell, open, values)?;
        self.unstable.with_distribution(self.job, &cell, self.place, &distribution, || self.reach, memory)
    }

    /// The cell with these values of what is open.
    fn with(&self, open: &[Open], values: &[f64]) -> Cell {
        let mut cell = self.cell.clone();
        for (open, &value) in open.iter().zip(values) {
            if let Open::Expected(place) = *open {
                cell.expected[place] = value;
            }
        }
        cell
    }

    /// The distribution of the input in a cell with these values.
    fn distribution(&self, cell: &Cell, open: &[Open], values: &[f64]) -> Option<InputDistribution> {
        let position = self.job.random.position(self.place)?;
        let std = open.iter().zip(values).find(|(open, _)| matches!(open, Open::RelativeStd(_)));
        let std = std.map_or_else(|| self.job.std(position, cell), |(_, std)| *std);
        Some(self.job.distribution_with(position, cell, std))
    }
}
