//! A cell in which some of what it consists of may have any value, for integrals over one input with critical values.

use stickslip_core::model::critical_values::Memory;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::{DeviateLaw, InputDistribution};
use stickslip_sampler::integrate::closed_form::ExactProbability;
use stickslip_sampler::integrate::one_input;

use crate::evaluate::open_cell::Open;
use crate::evaluate::unstable_values::UnstableValuesOfInput;
use crate::job::Job;

/// Values of what is open whose distributions say where searches begin: of one that is open alone, of each of several.
const MANY: usize = 65;
const FEW: usize = 9;

/// A cell of a job with one random input.
pub struct OpenInput<'a> {
    job: &'a Job,
    cell: Cell,
    /// The quantity that scatters.
    place: usize,
    /// Where searches begin, whatever is open.
    places: Vec<f64>,
    unstable: UnstableValuesOfInput,
}

impl<'a> OpenInput<'a> {
    /// A cell whose quantity at `place` scatters, of which some is open, between these ends.
    pub fn new(job: &'a Job, cell: u64, place: usize, open: &[Open], ends: &[[f64; 2]]) -> Self {
        let cell = job.grid.cell(cell);
        let mut own = Self { job, cell, place, places: Vec::new(), unstable: UnstableValuesOfInput::default() };
        // Between the ends, so many values that distributions about neighbouring ones overlap or nearly so.
        let values = if ends.len() > 1 { FEW } else { MANY };
        let mut inputs = Vec::new();
        for number in 0..values.pow(u32::try_from(ends.len()).unwrap_or(0)) {
            let share = |i: usize| (number / values.pow(i as u32) % values) as f64 / (values - 1) as f64;
            let at: Vec<f64> = ends.iter().enumerate().map(|(i, [low, high])| low + (high - low) * share(i)).collect();
            inputs.extend(own.distribution(&own.with(open, &at), open, &at).map(|own| (own, DeviateLaw::INDEPENDENT)));
        }
        own.places = one_input::places(&inputs);
        own
    }

    /// The quantity that scatters.
    pub fn place(&self) -> usize {
        self.place
    }

    /// The probability with these values of what is open; `None` if critical values cannot be found or leave
    /// too much open, or `memory` ends the search.
    pub fn probability(&self, open: &[Open], values: &[f64], memory: &dyn Memory) -> Option<ExactProbability> {
        let cell = self.with(open, values);
        let distribution = self.distribution(&cell, open, values)?;
        let places = || self.places.clone();
        let found = self.unstable.with_distribution(self.job, &cell, self.place, &distribution, places, memory);
        found.filter(ExactProbability::is_resolved)
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
