//! Consecutive samples of one cell: their deviates, and the inputs that these are transformed to.

use std::ops::Range;

use stickslip_core::rigid_disc::pad_on_disc::RandomInputs;
use stickslip_sampler::draw::deviates::{Deviates, Points};
use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::InputColumns;

use crate::job::{Job, RandomInput};

/// Consecutive samples of one cell, in columns.
#[derive(Debug, Clone)]
pub struct Samples {
    /// Their numbers in the stream of deviates.
    numbers: Range<u64>,
    /// Independent standard normal deviates, one column for each random input.
    deviates: Vec<Vec<f64>>,
    /// The values of the random inputs, likewise.
    values: Vec<Vec<f64>>,
    /// Preload, static friction, and the static friction below which a sample is outside physics.
    columns: [Column; 3],
}

/// Where the values of a parameter are stored.
#[derive(Debug, Clone)]
enum Column {
    /// In the column of a random input.
    Random(usize),
    /// Here, as the parameter does not scatter: one value for each sample, perhaps more.
    Fixed(Vec<f64>),
    /// Here, a multiple of a random input.
    Multiple { input: usize, factor: f64, values: Vec<f64> },
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
            Column::Fixed(values) | Column::Multiple { values, .. } => &values[..self.len()],
        }
    }

    /// Whether a sample is outside physics, see [`RandomInputs::are_outside_physics`].
    pub fn is_outside_physics(&self, sample: usize) -> bool {
        self.pair(sample).are_outside_physics(self.column(2)[sample])
    }

    /// The number of samples outside physics.
    #[inline]
    pub fn count_outside_physics(&self) -> u64 {
        let pairs = self.preloads().iter().zip(self.static_frictions());
        let pairs = pairs.map(|(&preload, &static_friction)| RandomInputs { preload, static_friction });
        // One number for all samples: the usual case, and the faster one.
        if let Column::Fixed(values) = &self.columns[2] {
            let least = values.first().copied().unwrap_or(0.0);
            return pairs.map(|inputs| u64::from(inputs.are_outside_physics(least))).sum();
        }
        pairs.zip(self.column(2)).map(|(inputs, &least)| u64::from(inputs.are_outside_physics(least))).sum()
    }

    /// A copy in which preload is at least 0, and static friction not outside physics.
    pub fn clamped(&self) -> Self {
        let mut clamped = self.clone();
        let preloads = self.preloads().iter().map(|preload| preload.max(0.0)).collect();
        let frictions = self.static_frictions().iter().zip(self.column(2)).map(|(f, least)| f.max(*least)).collect();
        for (which, values) in [(0, preloads), (1, frictions)] {
            match &mut clamped.columns[which] {
                Column::Random(input) => clamped.values[*input] = values,
                fixed => *fixed = Column::Fixed(values),
            }
        }
        clamped
    }

    /// Preload and static friction of one sample.
    pub fn pair(&self, sample: usize) -> RandomInputs {
        RandomInputs { preload: self.preloads()[sample], static_friction: self.static_frictions()[sample] }
    }

    /// Every random input of one sample, in the job's order.
    pub fn values(&self, sample: usize) -> impl Iterator<Item = f64> + '_ {
        self.values.iter().map(move |column| column[sample])
    }

    /// The values of one random input.
    pub fn values_of(&self, input: usize) -> &[f64] {
        &self.values[input]
    }

    /// The deviates of preload and static friction of one sample; `None` for one that does not scatter.
    pub fn deviates(&self, sample: usize) -> [Option<f64>; 2] {
        [0, 1].map(|which| match &self.columns[which] {
            Column::Random(input) => Some(self.deviates[*input][sample]),
            Column::Fixed(_) | Column::Multiple { .. } => None,
        })
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
            match column {
                Column::Random(_) => {}
                Column::Fixed(values) => {
                    if let (Some(&value), true) = (values.first(), values.len() < len) {
                        values.resize(len, value);
                    }
                }
                Column::Multiple { input, factor, values } => {
                    values.clear();
                    values.extend(self.values[*input].iter().map(|value| *factor * value));
                }
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
        let expected: Vec<f64> = random.inputs.iter().map(|input| job.expected(*input, cell)).collect();
        let stds = &random.relative_stds[job.grid.relative_std_index(cell.index)];
        let mut relative_stds = stds.clone();
        random.absolute().for_each(|input| relative_stds[input] = 0.0);
        let mut inputs = InputColumns::new(&random.marginals, &random.correlation, &expected, &relative_stds);
        for input in random.absolute() {
            inputs.scatter_absolutely(input, &random.marginals[input], expected[input], stds[input]);
        }
        let column = |wanted: fn(&RandomInput) -> bool, fixed: f64| match random.inputs.iter().position(wanted) {
            Some(input) => Column::Random(input),
            None => Column::Fixed(vec![fixed]),
        };
        // See `FrictionLaw::least_static_coefficient`.
        let (decisive, factor) = match job.parameters.friction.law.table() {
            Some(curve) => ("friction.band", -curve.deviation(0.0)),
            None => ("friction.kinetic_coefficient", 1.0),
        };
        let least = match random.inputs.iter().position(|input| input.name() == decisive) {
            Some(input) if factor == 1.0 => Column::Random(input),
            Some(input) => Column::Multiple { input, factor, values: Vec::new() },
            None => {
                let value = job.value_in(decisive, cell).unwrap_or(f64::NAN);
                Column::Fixed(vec![factor * value])
            }
        };
        Self {
            deviates: stream.start(cell.index, place as u64, range.start),
            inputs,
            end: range.end,
            samples: Samples {
                numbers: range.start..range.start,
                deviates: vec![Vec::new(); random.inputs.len()],
                values: vec![Vec::new(); random.inputs.len()],
                columns: [
                    column(|input| matches!(input, RandomInput::Preload), cell.preload),
                    column(|input| matches!(input, RandomInput::StaticFriction), cell.static_friction),
                    least,
                ],
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
