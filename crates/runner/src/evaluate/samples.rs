//! Consecutive samples of one cell: their deviates, and the inputs that these become.

use std::ops::Range;

use stickslip_core::rigid_disc::pad_on_disc::RandomInputs;
use stickslip_sampler::draw::deviates::{DeviateStream, Deviates, Points};
use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::InputColumns;

use crate::job::{Job, RandomInput};

/// Some consecutive samples of one cell, in columns.
#[derive(Debug, Clone)]
pub struct Samples {
    len: usize,
    /// Independent standard normal deviates, one column for each random input.
    deviates: Vec<Vec<f64>>,
    /// What they become, likewise.
    values: Vec<Vec<f64>>,
    /// Of preload and static friction: the column, or what stands in it for an input that does not scatter.
    columns: [Column; 2],
}

#[derive(Debug, Clone)]
enum Column {
    Random(usize),
    Fixed(Vec<f64>),
}

impl Samples {
    /// How many samples there are.
    pub fn len(&self) -> usize {
        self.len
    }

    /// The preload of each sample.
    pub fn preloads(&self) -> &[f64] {
        self.column(0)
    }

    /// The static friction coefficient of each sample.
    pub fn static_frictions(&self) -> &[f64] {
        self.column(1)
    }

    fn column(&self, which: usize) -> &[f64] {
        match &self.columns[which] {
            Column::Random(input) => &self.values[*input],
            Column::Fixed(values) => &values[..self.len],
        }
    }

    /// Preload and static friction of one sample.
    pub fn pair(&self, sample: usize) -> RandomInputs {
        RandomInputs { preload: self.preloads()[sample], static_friction: self.static_frictions()[sample] }
    }

    /// Every random input of one sample, in the order of the job's.
    pub fn values(&self, sample: usize) -> impl Iterator<Item = f64> + '_ {
        self.values.iter().map(move |column| column[sample])
    }

    /// The deviates of preload and static friction of one sample, where they scatter.
    pub fn deviates(&self, sample: usize) -> [Option<f64>; 2] {
        self.columns.each_ref().map(|column| match column {
            Column::Random(input) => Some(self.deviates[*input][sample]),
            Column::Fixed(_) => None,
        })
    }

    /// These samples with one input each taken from others.
    pub fn with_input_of(&self, input: usize, others: &Self) -> Self {
        let mut mixed = self.clone();
        mixed.values[input].clone_from(&others.values[input]);
        mixed
    }
}

/// Draws the samples of a range, chunk by chunk.
pub struct Drawing<'a> {
    deviates: Deviates,
    inputs: InputColumns<'a>,
    left: u64,
    /// Those drawn last; their memory is used again.
    samples: Samples,
}

impl<'a> Drawing<'a> {
    /// Samples `range` of the part at `place` of a cell, as [`Parts::first_sample`](super::parts::Parts::first_sample) numbers
    /// them.
    pub fn new(job: &'a Job, cell: &Cell, place: usize, range: Range<u64>, points: Points) -> Self {
        let random = &job.random;
        let stream = DeviateStream {
            seed: job.sampling.seed,
            common_random_numbers: job.sampling.common_random_numbers,
            dimensions: random.inputs.len(),
            points,
        };
        let expected: Vec<f64> = random.inputs.iter().map(|input| input.expected(cell, &job.parameters)).collect();
        let stds = &random.relative_stds[job.grid.relative_std_index(cell.index)];
        let column = |wanted: fn(&RandomInput) -> bool| match random.inputs.iter().position(wanted) {
            Some(input) => Column::Random(input),
            None => Column::Fixed(Vec::new()),
        };
        let fixed = |column: Column, value: f64| match column {
            Column::Fixed(_) => Column::Fixed(vec![value]),
            random @ Column::Random(_) => random,
        };
        Self {
            deviates: stream.start(cell.index, place as u64, range.start),
            inputs: InputColumns::new(&random.marginals, &random.correlation, &expected, stds),
            left: range.end - range.start,
            samples: Samples {
                len: 0,
                deviates: vec![Vec::new(); random.inputs.len()],
                values: vec![Vec::new(); random.inputs.len()],
                columns: [
                    fixed(column(|input| matches!(input, RandomInput::Preload)), cell.preload),
                    fixed(column(|input| matches!(input, RandomInput::StaticFriction)), cell.static_friction),
                ],
            },
        }
    }

    /// The next samples, `most` of them or as many as are left; `None` after the last.
    #[inline]
    pub fn next_chunk(&mut self, most: usize) -> Option<&Samples> {
        let len = self.left.min(most as u64) as usize;
        if len == 0 {
            return None;
        }
        self.left -= len as u64;
        let samples = &mut self.samples;
        samples.len = len;
        self.deviates.fill(len, &mut samples.deviates);
        for (values, deviates) in samples.values.iter_mut().zip(&samples.deviates) {
            values.clone_from(deviates);
        }
        self.inputs.apply(&mut samples.values);
        for column in &mut samples.columns {
            if let Column::Fixed(values) = column
                && let Some(&value) = values.first()
                && values.len() < len
            {
                values.resize(len, value);
            }
        }
        Some(samples)
    }
}
