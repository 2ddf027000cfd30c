//! Samples as lists: the random inputs of consecutive samples of a cell, whatever their number and distribution.

use std::ops::Range;

use stickslip_core::rigid_disc::pad_on_disc::RandomInputs;
use stickslip_sampler::draw::deviates::{DeviateStream, Points};
use stickslip_sampler::grid::Cell;

use crate::job::{Job, RandomInput};
use crate::schedule::slots::Slots;

/// The random inputs of some samples of one cell.
#[derive(Debug, Clone)]
pub struct Batch {
    samples: usize,
    /// Random inputs of each sample.
    dimensions: usize,
    /// Independent standard normal deviates, sample by sample.
    deviates: Vec<f64>,
    /// What they become, likewise.
    values: Vec<f64>,
    expected: RandomInputs,
    preload: Option<usize>,
    static_friction: Option<usize>,
}

impl Batch {
    /// One sample of a cell, numbered over all its parts.
    pub fn of_sample(job: &Job, cell: &Cell, sample: u64) -> Self {
        let slots = Slots::new(job);
        let (part, index) = slots.locate(sample);
        let first = slots.first_sample(part) + index;
        Self::draw(job, cell, part, first..first + 1, job.points())
    }

    /// Draws samples `range` of part `part` of a cell.
    pub fn draw(job: &Job, cell: &Cell, part: usize, range: Range<u64>, points: Points) -> Self {
        let dimensions = job.random.inputs.len();
        let samples = (range.end - range.start) as usize;
        let stream = DeviateStream {
            seed: job.sampling.seed,
            common_random_numbers: job.sampling.common_random_numbers,
            dimensions,
            points,
        };
        let deviates = stream.draw(cell.index, part as u64, range);
        let mut batch = Self {
            samples,
            dimensions,
            values: deviates.clone(),
            deviates,
            expected: RandomInputs { preload: cell.preload, static_friction: cell.static_friction },
            preload: job.random.inputs.iter().position(|input| matches!(input, RandomInput::Preload)),
            static_friction: job.random.inputs.iter().position(|input| matches!(input, RandomInput::StaticFriction)),
        };
        batch.transform(job, cell);
        batch
    }

    /// Deviates become inputs.
    fn transform(&mut self, job: &Job, cell: &Cell) {
        if self.dimensions == 0 {
            return;
        }
        if !job.random.correlation.is_independent() {
            self.values.chunks_exact_mut(self.dimensions).for_each(|sample| job.random.correlation.apply(sample));
        }
        let stds = &job.random.relative_stds[job.grid.relative_std_index(cell.index)];
        let mut column = vec![0.0; self.samples];
        for (i, (input, marginal)) in job.random.inputs.iter().zip(&job.random.marginals).enumerate() {
            let expected = input.expected(cell, &job.parameters);
            for (value, sample) in column.iter_mut().zip(self.values.chunks_exact(self.dimensions)) {
                *value = sample[i];
            }
            marginal.apply(expected, stds[i], &mut column);
            for (value, sample) in column.iter().zip(self.values.chunks_exact_mut(self.dimensions)) {
                sample[i] = *value;
            }
        }
    }

    /// How many samples there are.
    pub fn len(&self) -> usize {
        self.samples
    }

    /// Every random input of one sample, in the order of the job's.
    pub fn values(&self, sample: usize) -> &[f64] {
        &self.values[sample * self.dimensions..(sample + 1) * self.dimensions]
    }

    /// Preload and static friction of one sample.
    pub fn inputs(&self, sample: usize) -> RandomInputs {
        let value = |place: Option<usize>, expected: f64| place.map_or(expected, |i| self.values(sample)[i]);
        RandomInputs {
            preload: value(self.preload, self.expected.preload),
            static_friction: value(self.static_friction, self.expected.static_friction),
        }
    }

    /// The deviates of preload and static friction of one sample, where they scatter.
    pub fn deviates(&self, sample: usize) -> (Option<f64>, Option<f64>) {
        let deviate = |place: Option<usize>| place.map(|i| self.deviates[sample * self.dimensions + i]);
        (deviate(self.preload), deviate(self.static_friction))
    }

    /// These samples with one input each taken from another batch.
    pub fn with_input_of(&self, input: usize, other: &Self) -> Self {
        let mut mixed = self.clone();
        for sample in 0..self.samples {
            let place = sample * self.dimensions + input;
            mixed.values[place] = other.values[place];
        }
        mixed
    }
}
