//! Samples of the inputs other than preload and static friction: the probability of instability over these two, given
//! the others.

use std::ops::Range;

use stickslip_core::parameters::ParameterError;
use stickslip_core::rigid_disc::pad_on_disc::RandomInputs;
use stickslip_core::rigid_disc::stability::StabilityBoundary;
use stickslip_core::rigid_disc::varying_brake::VaryingBrake;
use stickslip_core::verdict::Verdict;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::{Correlation, InputDistribution};
use stickslip_sampler::integrate::pair::Pair;

use crate::evaluate::control::IsStopped;
use crate::job::Job;

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
    /// The correlation of these, followed by preload and static friction.
    correlation: Correlation,
}

/// The samples of one cell.
pub(super) struct ConditionalCell<'a> {
    conditional: &'a Conditional,
    distributions: Vec<InputDistribution>,
    pair: Pair,
    varying: VaryingBrake,
    expected: RandomInputs,
}

impl Conditional {
    /// Prepares a job; `None` if it draws preload and static friction.
    pub fn new(job: &Job) -> Option<Self> {
        let correlation = job.integrates_pair().then(|| job.random.correlation_with_pair_last().ok())??;
        Some(Self { others: job.random.others(), correlation })
    }

    /// The number of inputs that are drawn.
    pub(super) fn dimensions(&self) -> usize {
        self.others.len()
    }

    /// Evaluates samples of a randomisation of a cell, and hands each to `add`: its verdict, unstable where its
    /// probability is above one half, and that probability. A sample of which no brake can be made fails. False if it is
    /// stopped before.
    pub fn evaluate(
        &self,
        job: &Job,
        cell: &Cell,
        randomisation: usize,
        samples: Range<u64>,
        is_stopped: IsStopped<'_>,
        add: &mut dyn FnMut(Verdict, f64),
    ) -> bool {
        let Ok(of_cell) = ConditionalCell::new(self, job, cell) else {
            samples.for_each(|_| add(Verdict::Failed, 0.0));
            return true;
        };
        let stream = job.deviates(self.others.len(), job.points());
        let mut deviates = stream.start(cell.index, randomisation as u64, samples.start);
        let mut columns = vec![Vec::new(); self.others.len()];
        // Two zeros stand for preload and static friction, of which only the law is asked for.
        let mut sample = vec![0.0; self.others.len() + 2];
        let mut first = samples.start;
        while first < samples.end {
            if is_stopped() {
                return false;
            }
            let count = AT_ONCE.min(samples.end - first);
            deviates.fill(count as usize, &mut columns);
            for i in 0..count as usize {
                for (deviate, column) in sample.iter_mut().zip(&columns) {
                    *deviate = column[i];
                }
                match of_cell.probability(&mut sample) {
                    Some(probability) if probability > HALF => add(Verdict::Unstable, probability),
                    Some(probability) => add(Verdict::Stable, probability),
                    None => add(Verdict::Failed, 0.0),
                }
            }
            first += count;
        }
        true
    }
}

impl<'a> ConditionalCell<'a> {
    pub(super) fn new(conditional: &'a Conditional, job: &Job, cell: &Cell) -> Result<Self, ParameterError> {
        let others = || conditional.others.iter();
        let brake = job.brake(job.grid.brake_index(cell.index))?;
        let scalars = others().filter_map(|&position| job.random.inputs[position].scalar()).collect();
        Ok(Self {
            conditional,
            distributions: others().map(|&position| job.distribution(position, cell)).collect(),
            pair: job.pair(cell),
            varying: VaryingBrake::new(brake, scalars),
            expected: RandomInputs { preload: cell.preload, static_friction: cell.static_friction },
        })
    }

    /// The probability of instability given the independent deviates of the other inputs, followed by two zeros for
    /// preload and static friction; all are replaced. `None` if a value is not admissible.
    pub(super) fn probability(&self, deviates: &mut [f64]) -> Option<f64> {
        let Conditional { others, correlation } = self.conditional;
        let law = correlation.law_of_last_two(&deviates[..others.len()]);
        correlation.apply(deviates);
        let value = |i: usize| self.distributions[i].value(deviates[i]);
        let boundary: StabilityBoundary = self.varying.brake(self.expected, value)?.stability_boundary();
        deviates[others.len()..].fill(0.0);
        Some(self.pair.probability(&boundary, &law, TOLERANCE))
    }
}
