//! Samples of the inputs other than the pair of the model, or than the one input with critical values: the probability of
//! instability over these, given the others.

use std::iter;
use std::ops::Range;

use stickslip_core::model::critical_values::NoMemory;
use stickslip_core::model::verdict::Verdict;
use stickslip_core::model::{Configuration, ModelError};
use stickslip_sampler::draw::beyond::{self, RANDOMISATIONS};
use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::{Correlation, InputDistribution};
use stickslip_sampler::integrate::one_input;
use stickslip_sampler::integrate::pair::Pair;
use stickslip_sampler::rare::points::{ConditionalProbability, Integrand, Points};

use crate::job::Job;
use stickslip_core::model::IsStopped;

/// Samples between two questions whether to stop.
const AT_ONCE: u64 = 20;

/// Relative error of each integral: far below the differences between samples.
const TOLERANCE: f64 = 1e-8;

/// A probability above this counts as an unstable sample.
const HALF: f64 = 0.5;

/// What all samples of a job have in common.
pub struct Conditional {
    /// The positions of the inputs that are drawn.
    others: Vec<usize>,
    /// The position of the one input that is integrated over, where that is not the pair.
    one: Option<usize>,
    /// The correlation of the inputs that are drawn, followed by what is integrated over.
    correlation: Correlation,
}

/// What is integrated over.
enum Integrated {
    Pair {
        pair: Pair,
        /// Expected values.
        expected: [f64; 2],
    },
    One(InputDistribution),
}

/// The samples of one cell.
pub(super) struct ConditionalCell<'a> {
    conditional: &'a Conditional,
    distributions: Vec<InputDistribution>,
    integrated: Integrated,
    configuration: Box<dyn Configuration>,
}

impl Conditional {
    /// Prepares a job; `None` if it draws all inputs.
    pub fn new(job: &Job) -> Option<Self> {
        let integrated = job.integrated();
        let correlation = job.integrates_at_samples().then(|| job.random.correlation_with_last(integrated).ok())??;
        let one = integrated.and_then(|place| job.random.position(place));
        Some(Self { others: job.random.others(integrated), one, correlation })
    }

    /// The number of inputs that are drawn.
    pub(super) fn dimensions(&self) -> usize {
        self.others.len()
    }

    /// Evaluates samples of a randomisation of a cell, and hands each to `add`: its verdict, unstable where its
    /// probability is above one half, its weight, and that probability. A sample with a value that is not admissible fails, and
    /// one whose critical values leave too much open is undecided. Those that are drawn [beyond] follow, without a verdict: they
    /// are no samples. False if it is stopped before.
    pub fn evaluate(
        &self,
        job: &Job,
        cell: &Cell,
        randomisation: usize,
        samples: Range<u64>,
        is_stopped: IsStopped<'_>,
        add: &mut dyn FnMut(Option<Verdict>, f64, Option<f64>),
    ) -> bool {
        let Ok(of_cell) = ConditionalCell::new(self, job, cell) else {
            samples.for_each(|_| add(Some(Verdict::Failed), 1.0, None));
            return true;
        };
        let (inputs, randomisation) = (self.others.len(), randomisation as u64);
        let mut decide = |sample: &mut [f64]| {
            let weight = beyond::weight(&sample[..inputs]);
            match of_cell.probability(sample) {
                Ok(probability) if probability > HALF => add(Some(Verdict::Unstable), weight, Some(probability)),
                Ok(probability) => add(Some(Verdict::Stable), weight, Some(probability)),
                Err(verdict) => add(Some(verdict), weight, None),
            }
        };
        if !self.each(job, (cell.index, randomisation), samples.clone(), is_stopped, &mut decide) {
            return false;
        }
        let mut decide_beyond = |sample: &mut [f64]| {
            let weight = beyond::move_out(&mut sample[..inputs]);
            add(None, weight, of_cell.probability(sample).ok());
        };
        let far = beyond::beside(samples, randomisation);
        self.each(job, (cell.index, RANDOMISATIONS + randomisation), far, is_stopped, &mut decide_beyond)
    }

    /// Hands the independent deviates of samples of a randomisation to `visit`, followed by zeros for what is integrated over, of
    /// which only the law is asked for. False if it is stopped before.
    fn each(
        &self,
        job: &Job,
        (cell, randomisation): (u64, u64),
        samples: Range<u64>,
        is_stopped: IsStopped<'_>,
        visit: &mut dyn FnMut(&mut [f64]),
    ) -> bool {
        let stream = job.deviates(self.others.len(), job.points());
        let mut deviates = stream.start(job.stream_of(cell), randomisation, samples.start);
        let mut columns = vec![Vec::new(); self.others.len()];
        let mut sample = vec![0.0; self.correlation.inputs()];
        let mut first = samples.start;
        while first < samples.end {
            if is_stopped() {
                return false;
            }
            let count = AT_ONCE.min(samples.end - first);
            deviates.fill(count as usize, &mut columns);
            for i in 0..count as usize {
                sample.fill(0.0);
                sample.iter_mut().zip(&columns).for_each(|(deviate, column)| *deviate = column[i]);
                visit(&mut sample);
            }
            first += count;
        }
        true
    }
}

impl<'a> ConditionalCell<'a> {
    pub(super) fn new(conditional: &'a Conditional, job: &Job, cell: &Cell) -> Result<Self, ModelError> {
        let others = || conditional.others.iter();
        let (first, integrated) = match conditional.one {
            Some(position) => (vec![job.random.inputs[position]], Integrated::One(job.distribution(position, cell))),
            None => {
                let pair = job.model().pair().unwrap_or_default();
                let expected = pair.map(|place| cell.expected[place]);
                (pair.to_vec(), Integrated::Pair { pair: job.pair(cell), expected })
            }
        };
        let varying: Vec<usize> =
            first.into_iter().chain(others().map(|&position| job.random.inputs[position])).collect();
        Ok(Self {
            conditional,
            distributions: others().map(|&position| job.distribution(position, cell)).collect(),
            integrated,
            configuration: job.model().configure(&cell.expected, &varying, None)?,
        })
    }

    /// The probability of instability given the independent deviates of the other inputs, followed by zeros for what is
    /// integrated over; all are replaced.
    ///
    /// # Errors
    /// Failed if a value is not admissible, undecided if critical values leave too much open.
    pub(super) fn probability(&self, deviates: &mut [f64]) -> Result<f64, Verdict> {
        let Conditional { others, correlation, .. } = self.conditional;
        let free = deviates[..others.len()].to_vec();
        correlation.apply(deviates);
        let drawn = self.distributions.iter().zip(&*deviates).map(|(input, deviate)| input.value(*deviate));
        let probability = match &self.integrated {
            Integrated::Pair { pair, expected } => {
                let values: Vec<f64> = expected.iter().copied().chain(drawn).collect();
                let boundary = self.configuration.closed_form().and_then(|form| form.boundary_of(&values));
                let boundary = boundary.ok_or(Verdict::Failed)?;
                pair.probability(&boundary, &correlation.law_of_last_two(&free), TOLERANCE)
            }
            Integrated::One(input) => {
                let law = correlation.law_of_last(&free);
                let values: Vec<f64> = iter::once(input.value(0.0)).chain(drawn).collect();
                let places = one_input::places(&[(input.clone(), law)]);
                let critical = self.configuration.critical_values();
                let unstable = critical.and_then(|critical| critical.unstable(&values, 0, &places, &NoMemory));
                let found = one_input::probability(input, law, &unstable.ok_or(Verdict::Failed)?);
                if !found.is_resolved() {
                    return Err(Verdict::Undecided);
                }
                found.value
            }
        };
        Ok(probability)
    }
}

/// Probabilities of instability given the deviates of the inputs that are not integrated over.
pub(super) fn integrand<'a>(
    conditional: &'a Conditional,
    job: &'a Job,
    cell: &'a Cell,
    is_stopped: IsStopped<'a>,
) -> impl Integrand + 'a {
    // None if no sample of the cell is admissible.
    let of_cell = ConditionalCell::new(conditional, job, cell).ok();
    let mut sample = Vec::new();
    ConditionalProbability(move |points: &Points| {
        let mut values = Vec::with_capacity(points.len());
        for point in points.iter() {
            if is_stopped() {
                return None;
            }
            sample.clear();
            sample.extend(point.iter());
            sample.resize(conditional.correlation.inputs(), 0.0);
            values.push(of_cell.as_ref().and_then(|of_cell| of_cell.probability(&mut sample).ok()));
        }
        Some(values)
    })
}
