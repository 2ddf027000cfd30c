//! Consecutive samples of one cell: their deviates, and the values that these are transformed to.

use std::ops::Range;

use stickslip_sampler::draw::deviates::{Deviates, Points};
use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::InputColumns;

use crate::job::Job;

/// Consecutive samples of one cell, in columns.
#[derive(Debug, Clone)]
pub struct Samples {
    /// Their numbers in the stream of deviates.
    numbers: Range<u64>,
    /// Independent standard normal deviates, one column for each random input.
    deviates: Vec<Vec<f64>>,
    /// The values of the random inputs, likewise.
    values: Vec<Vec<f64>>,
    /// The quantities that vary, see [`Job::varying`].
    columns: Vec<Column>,
    /// Which random inputs the pair of the model are.
    pair: [Option<usize>; 2],
}

/// Where the values of a quantity are stored.
#[derive(Debug, Clone)]
enum Column {
    /// In the column of a random input.
    Random(usize),
    /// Here, as the quantity does not scatter: one value for each sample, perhaps more.
    Fixed(Vec<f64>),
}

impl Samples {
    /// How many samples there are.
    pub fn len(&self) -> usize {
        (self.numbers.end - self.numbers.start) as usize
    }

    /// Their numbers, as [`Parts::first_sample`](super::parts::Parts::first_sample) counts them.
    pub fn numbers(&self) -> Range<u64> {
        self.numbers.clone()
    }

    /// The columns of the quantities that vary.
    pub fn columns(&self) -> Vec<&[f64]> {
        let of = |column| match column {
            &Column::Random(input) => &self.values[input][..],
            Column::Fixed(values) => &values[..self.len()],
        };
        self.columns.iter().map(of).collect()
    }

    /// A copy with other values of the pair.
    pub fn with_pair(&self, pair: [Vec<f64>; 2]) -> Self {
        let mut changed = self.clone();
        for (column, values) in changed.columns.iter_mut().zip(pair) {
            match column {
                Column::Random(input) => changed.values[*input] = values,
                fixed => *fixed = Column::Fixed(values),
            }
        }
        changed
    }

    /// The values of the quantities that vary in one sample.
    pub fn of_sample(&self, sample: usize) -> impl Iterator<Item = f64> {
        self.columns.iter().map(move |column| match column {
            &Column::Random(input) => self.values[input][sample],
            Column::Fixed(values) => values[sample],
        })
    }

    /// The values of the pair in one sample; of a model without, nothing of meaning.
    pub fn pair(&self, sample: usize) -> [f64; 2] {
        let mut values = self.of_sample(sample);
        [(); 2].map(|()| values.next().unwrap_or(f64::NAN))
    }

    /// Every random input of one sample, in the job's order.
    pub fn values(&self, sample: usize) -> impl Iterator<Item = f64> + '_ {
        self.values.iter().map(move |column| column[sample])
    }

    /// The deviates of the pair in one sample; `None` for a quantity that does not scatter.
    pub fn deviates(&self, sample: usize) -> [Option<f64>; 2] {
        self.pair.map(|input| input.map(|input| self.deviates[input][sample]))
    }

    /// A copy of some of the samples, by their places here.
    pub fn part(&self, places: Range<usize>) -> Self {
        let of = |columns: &[Vec<f64>]| columns.iter().map(|column| column[places.clone()].to_vec()).collect();
        let start = self.numbers.start + places.start as u64;
        let mut part = Self {
            numbers: start..start + places.len() as u64,
            deviates: of(&self.deviates),
            values: of(&self.values),
            columns: self.columns.clone(),
            pair: self.pair,
        };
        part.complete_columns();
        part
    }

    /// A copy with the values of one input taken from other samples.
    pub fn with_input_of(&self, input: usize, others: &Self) -> Self {
        let mut mixed = self.clone();
        mixed.values[input].clone_from(&others.values[input]);
        mixed.complete_columns();
        mixed
    }

    /// Gives the columns that are no random inputs a value for each sample.
    #[inline]
    fn complete_columns(&mut self) {
        let len = self.len();
        for column in &mut self.columns {
            if let Column::Fixed(values) = column
                && let (Some(&value), true) = (values.first(), values.len() < len)
            {
                values.resize(len, value);
            }
        }
    }
}

/// Draws the samples of a range, chunk by chunk.
pub struct Drawing<'a> {
    deviates: Deviates,
    inputs: InputColumns<'a>,
    /// The number after the last sample.
    end: u64,
    /// The samples drawn last; their memory is used again.
    samples: Samples,
}

impl<'a> Drawing<'a> {
    /// Starts to draw the samples `range` of the part at `place` in a cell, numbered as by
    /// [`Parts::first_sample`](super::parts::Parts::first_sample).
    pub fn new(job: &'a Job, cell: &Cell, place: usize, range: Range<u64>, points: Points) -> Self {
        let random = &job.random;
        let stream = job.deviates(random.inputs.len(), points);
        let expected: Vec<f64> = random.inputs.iter().map(|input| cell.expected[*input]).collect();
        let stds = &random.relative_stds[cell.scatter];
        let mut relative_stds = stds.clone();
        random.absolute().for_each(|input| relative_stds[input] = 0.0);
        let mut inputs = InputColumns::new(&random.marginals, &random.correlation, &expected, &relative_stds);
        for input in random.absolute() {
            inputs.scatter_absolutely(input, &random.marginals[input], expected[input], stds[input]);
        }
        let column = |place: usize| match random.position(place) {
            Some(input) => Column::Random(input),
            None => Column::Fixed(vec![cell.expected[place]]),
        };
        Self {
            deviates: stream.start(job.stream_of(cell.index), place as u64, range.start),
            inputs,
            end: range.end,
            samples: Samples {
                numbers: range.start..range.start,
                deviates: vec![Vec::new(); random.inputs.len()],
                values: vec![Vec::new(); random.inputs.len()],
                columns: job.varying().into_iter().map(column).collect(),
                pair: random.pair(),
            },
        }
    }

    /// The next `most` samples, or as many as are left; `None` after the last.
    #[inline]
    pub fn next_chunk(&mut self, most: usize) -> Option<&Samples> {
        let samples = &mut self.samples;
        samples.numbers = samples.numbers.end..self.end.min(samples.numbers.end + most as u64);
        let len = samples.len();
        if len == 0 {
            return None;
        }
        self.deviates.fill(len, &mut samples.deviates);
        Some(self.transform())
    }

    /// Samples of given deviates instead of drawn ones, one after the other.
    pub fn of_deviates<'p>(&mut self, deviates: impl ExactSizeIterator<Item = &'p [f64]>) -> &Samples {
        self.samples.numbers = 0..deviates.len() as u64;
        self.samples.deviates.iter_mut().for_each(Vec::clear);
        for deviates in deviates {
            self.samples.deviates.iter_mut().zip(deviates).for_each(|(column, deviate)| column.push(*deviate));
        }
        self.transform()
    }

    /// The samples of the deviates that they have.
    #[inline]
    fn transform(&mut self) -> &Samples {
        let samples = &mut self.samples;
        for (values, deviates) in samples.values.iter_mut().zip(&samples.deviates) {
            values.clone_from(deviates);
        }
        self.inputs.apply(&mut samples.values);
        samples.complete_columns();
        samples
    }
}
