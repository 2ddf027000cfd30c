//! Limits along an axis from samples with weights.
//!
//! A first scan finds about where the limits are; at each of its values the samples are placed again. Near each limit
//! the samples are then placed once. The probability is a smooth function of the value there, so that its interval
//! bounds the limit.

use std::sync::atomic::AtomicU64;

use stickslip_sampler::estimate::audit::COMPARED;
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::estimate::weighted::{Distrust, WeightedEstimate};
use stickslip_sampler::limits::Limit;
use stickslip_sampler::limits::scan::Scan;

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::limits_found::{CombinationLimits, Ended, Intervals, each_once};
use crate::evaluate::randomised;
use crate::evaluate::remembering::Asked;
use crate::failure::Failure;
use crate::job::{Job, LimitAxis};
use stickslip_core::model::IsStopped;

/// Where an estimate is below this part of all targets, it need not be precise.
const FAR_BELOW: f64 = 1e-3;

/// To which part of itself a limit is located at first, and in the end.
const TOLERANCES: [f64; 2] = [1e-3, 1e-9];

/// Parts of a limit to each side of it within which it is located, one after the other until it lies inside with its
/// bounds.
const REACHES: [f64; 3] = [0.01, 0.05, 0.2];

/// A value nearer to zero than this part of the range counts as so large in reaches.
const SMALLEST: f64 = 0.01;

/// Intervals of a scan there.
const INTERVALS: usize = 4;

/// Limits of one combination of the other axes.
pub struct WeightedSearch<'a, 'k> {
    pub job: &'a Job,
    pub axis: &'a LimitAxis,
    /// The cell of the combination that has the first value of the axis.
    pub cell: u64,
    /// Confidence of the intervals of probabilities.
    pub confidence: f64,
    /// The samples of its estimates.
    pub asked: &'a Asked<'k>,
    /// Counts these.
    pub estimated: &'a AtomicU64,
}

impl WeightedSearch<'_, '_> {
    /// The limits, from a scan over `values` at first.
    ///
    /// # Errors
    /// See [`Ended`].
    pub fn limits(
        &self,
        values: &[f64],
        targets: &[f64],
        is_stopped: IsStopped<'_>,
    ) -> Result<CombinationLimits, Ended> {
        let found = each_once(self.estimated, |value| self.estimate(value, None, targets, is_stopped));
        let estimate = |value: f64| found(value).map(|found| found.estimate);
        let scan = Scan::new(values, TOLERANCES[0], estimate)?;
        if scan.is_unknown() {
            return Err(Ended::Failed(Failure::Job(format!(
                "nothing unstable was found at any value of {} in the combination of cell {}, so that there is no estimate to compare with a target; give a wider range of axes.{}",
                self.axis.name, self.cell, self.axis.name
            ))));
        }
        let mut of_targets = Vec::with_capacity(targets.len());
        for &target in targets {
            let mut limits = scan.limits(target, estimate)?;
            for limit in &mut limits {
                self.refine(limit, target, is_stopped)?;
            }
            of_targets.push(limits);
        }
        CombinationLimits::new(&scan, of_targets, found)
    }

    /// Locates a limit with samples that are placed once.
    fn refine(&self, limit: &mut Limit, target: f64, is_stopped: IsStopped<'_>) -> Result<(), Ended> {
        let Some(value) = limit.value else { return Ok(()) };
        let job = self.axis.job_at(self.job, value);
        let placed = Evaluator::new(&job).map_err(Ended::Failed)?;
        // Its samples have to be placed, whatever is known of them.
        self.evaluate(&job, &placed, value, &[target], &Asked::new(None, (self.cell, 0)), is_stopped)?;
        let estimate =
            |value: f64| self.estimate(value, Some(&placed), &[target], is_stopped).map(|found| found.estimate);
        let [least, most] = self.axis.range();
        for reach in REACHES {
            let width = reach * value.abs().max(SMALLEST * (most - least));
            let at = |i: usize| value + width * (2.0 * i as f64 / INTERVALS as f64 - 1.0);
            let mut near: Vec<f64> = (0..=INTERVALS).map(|i| at(i).clamp(least, most)).collect();
            near.dedup();
            if near.len() < 2 {
                break;
            }
            let found = Scan::new(&near, TOLERANCES[1], estimate)?.limits(target, estimate)?;
            let inside = |[low, high]: [f64; 2]| {
                (low > near[0] || near[0] <= least) && (high < near[near.len() - 1] || near[near.len() - 1] >= most)
            };
            if let [only] = found[..]
                && only.state == limit.state
                && only.bounds.is_some_and(inside)
            {
                *limit = only;
                return Ok(());
            }
        }
        Err(self.distrusted(value))
    }

    /// The estimate at a value of the axis, with samples placed there, or where another evaluator has placed them.
    fn estimate(
        &self,
        value: f64,
        placed: Option<&Evaluator<'_>>,
        targets: &[f64],
        is_stopped: IsStopped<'_>,
    ) -> Result<Intervals, Ended> {
        let job = self.axis.job_at(self.job, value);
        job.configuration_in(&job.grid.cell(self.cell)).map_err(|error| Ended::NoSuchConfiguration(value, error))?;
        let evaluator = Evaluator::new(&job).map_err(Ended::Failed)?;
        placed.into_iter().for_each(|placed| evaluator.place_samples_as(placed));
        self.evaluate(&job, &evaluator, value, targets, self.asked, is_stopped)
    }

    /// The estimate of the cell of a job with a value of the axis.
    fn evaluate(
        &self,
        job: &Job,
        evaluator: &Evaluator<'_>,
        value: f64,
        targets: &[f64],
        asked: &Asked<'_>,
        is_stopped: IsStopped<'_>,
    ) -> Result<Intervals, Ended> {
        let parts = evaluator.count_cell(self.cell, asked, is_stopped).ok_or(Ended::Stopped)?;
        let of_weights =
            |confidence: f64| randomised::of_weights(job, &parts, confidence).ok_or_else(|| self.distrusted(value));
        let found = of_weights(self.confidence)?;
        let probability = match found.distrust {
            None => found.estimate.probability,
            // Nothing stable: the probability is 1 as far as a limit is concerned. Without one it counts as 0.
            Some(Distrust::NothingFound) => (found.mean > 0.5).then_some(found.mean),
            // Far below all targets its digits do not matter; a population that found more has at most four times the mean.
            Some(_) if targets.iter().all(|target| found.mean < FAR_BELOW * target) => Some(found.mean),
            Some(_) => return Err(self.distrusted(value)),
        };
        let interval = |found: WeightedEstimate| Estimate { probability, ..found.estimate };
        Ok(Intervals { estimate: interval(found), compared: interval(of_weights(COMPARED)?) })
    }

    fn distrusted(&self, value: f64) -> Ended {
        let name = &self.axis.name;
        Ended::Failed(Failure::Job(format!(
            "with {name} = {value} in the combination of cell {} the probability is not to be trusted: few samples have most of it, or independent populations disagree. Give more sampling.samples or sampling.particles, or a narrower range of axes.{name}",
            self.cell
        )))
    }
}
