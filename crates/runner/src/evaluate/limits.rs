//! Limits along an axis of a job, in one combination of the other axes.

use std::sync::atomic::AtomicU64;

use stickslip_core::model::quantity::Role;
use stickslip_core::model::verdict::VerdictCounts;
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::estimate::randomisations;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::integrate::NormalPair;
use stickslip_sampler::integrate::verdict_map::MapRegions;
use stickslip_sampler::limits::randomised::GroupedSweeps;
use stickslip_sampler::limits::scan::{Scan, scanned_values};
use stickslip_sampler::limits::spans::{OutsidePhysics as Outside, Sample, Spans};
use stickslip_sampler::limits::sweep::{SortedSweep, Sweep};

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::integral::exact_probability;
use crate::evaluate::limits_found::{Beside, CombinationLimits, Ended, Intervals, each_once};
use crate::evaluate::randomised;
use crate::evaluate::remembered_intervals::RememberedIntervals;
use crate::evaluate::remembering::{Asked, Keeper};
use crate::evaluate::unstable_values::UnstableValuesOfInput;
use crate::evaluate::weighted_limits::WeightedSearch;
use crate::failure::Failure;
use crate::job::{Answer, Effort, Job, LimitAxis, LimitMethod, OutsidePhysics};
use stickslip_core::model::IsStopped;

/// Least numbers of intervals of a scan: of a probability that takes little to compute, over a map, and of samples that are
/// all evaluated at each value.
const INTERVALS: [usize; 3] = [256, 64, 32];

/// Changes of verdicts among which those are that a scan of Sobol points has besides.
const CHANGES: usize = 1024;

/// To which part of itself a limit is located: of a probability that takes little to compute, and of others.
const TOLERANCES: [f64; 2] = [1e-12, 1e-9];

/// Estimates about a limit and both ends of its interval, besides those of the scan: 6 to 17 are usual.
const ESTIMATES: f64 = 12.0;

/// A search for limits along an axis of a job.
pub struct LimitSearch<'a> {
    pub job: &'a Job,
    pub axis: &'a LimitAxis,
    pub method: LimitMethod,
    /// Confidence of the intervals of probabilities.
    pub confidence: f64,
    /// The regions of the verdict maps, where the method integrates over these.
    pub regions: &'a [MapRegions],
    /// Where estimates are kept.
    pub keeper: Option<&'a dyn Keeper>,
    /// Counts the values at which the probability was estimated.
    pub estimated: &'a AtomicU64,
}

/// The values of the axis at which the probability is first estimated; none where samples have critical values.
pub fn scanned(axis: &LimitAxis, method: LimitMethod) -> Option<Vec<f64>> {
    let intervals = match method {
        LimitMethod::Integral => INTERVALS[0],
        LimitMethod::MapIntegral => INTERVALS[1],
        LimitMethod::OneInput | LimitMethod::Samples | LimitMethod::WeightedSamples => INTERVALS[2],
        LimitMethod::CriticalValues(_) => return None,
    };
    Some(scanned_values(&axis.values, intervals))
}

/// At about how many values of the axis the probability is estimated in a combination, each in the time of a cell. It passes
/// each of so many targets once.
pub fn expected_estimates(job: &Job, axis: &LimitAxis, method: LimitMethod, targets: usize) -> f64 {
    match method {
        LimitMethod::Integral | LimitMethod::MapIntegral => 0.0,
        LimitMethod::CriticalValues(_) => 1.0,
        // Its values are found once, whatever is expected of it.
        LimitMethod::OneInput if job.integrated() == Some(axis.quantity) => 1.0,
        LimitMethod::OneInput | LimitMethod::Samples | LimitMethod::WeightedSamples => {
            let scanned = scanned(axis, method).map_or(0, |values| values.len());
            scanned as f64 + ESTIMATES * targets as f64
        }
    }
}

impl LimitSearch<'_> {
    /// The limits of the combination of `cell`, which has the first value of the axis.
    ///
    /// # Errors
    /// See [`Ended`].
    pub fn limits(&self, cell: u64, targets: &[f64], is_stopped: IsStopped<'_>) -> Result<CombinationLimits, Ended> {
        let mut found = self.found(cell, targets, is_stopped)?;
        found.audit((self.job, self.axis, cell), &Asked::new(self.keeper, (cell, 1)), is_stopped)?;
        Ok(found)
    }

    /// The limits without plain samples.
    fn found(&self, cell: u64, targets: &[f64], is_stopped: IsStopped<'_>) -> Result<CombinationLimits, Ended> {
        let go_on = || if is_stopped() { Err(Ended::Stopped) } else { Ok(()) };
        let asked = Asked::new(self.keeper, (cell, 0));
        match self.method {
            LimitMethod::Integral => {
                let quantity = self.axis.quantity;
                let boundary = |cell: &Cell| {
                    let no_such = |error| Ended::NoSuchConfiguration(cell.expected[quantity], error);
                    self.job.boundary_with(&cell.expected).map_err(no_such)
                };
                let of_first = self.job.grid.cell(cell);
                // One boundary, unless it depends on the axis.
                let is_common = self.job.quantity(quantity).role != Role::Configuration;
                let common = if is_common { Some(boundary(&of_first)?) } else { None };
                let estimate = |value: f64| {
                    go_on()?;
                    let mut cell = of_first.clone();
                    cell.expected[quantity] = value;
                    let boundary = common.map_or_else(|| boundary(&cell), Ok)?;
                    let found = exact_probability(self.job, &boundary, &self.job.normal_pair(&cell));
                    let [low, high] = found.bounds();
                    Ok(Estimate { probability: Some(found.value), low, high })
                };
                self.scan(targets, TOLERANCES[0], &[], |value| asked.estimate(|| estimate(value)).map(Intervals::from))
            }
            LimitMethod::OneInput => {
                let unstable = UnstableValuesOfInput::default();
                let input = self.job.integrated().unwrap_or_default();
                let memory = RememberedIntervals { asked: &asked, is_stopped };
                let estimate = |value: f64| {
                    let mut place = self.job.grid.cell(cell);
                    place.expected[self.axis.quantity] = value;
                    let found = unstable.estimate(self.job, &place, input, &memory);
                    go_on()?;
                    self.beside_targets(value, targets, found)?;
                    Ok(Intervals::from(found))
                };
                self.scan(targets, TOLERANCES[1], &[], estimate)
            }
            LimitMethod::MapIntegral => {
                let (place, index) = (self.job.grid.cell(cell), self.job.grid.configuration_index(cell));
                let estimate = |value: f64| {
                    go_on()?;
                    let found = self.regions[index].probability(&self.moved(&place, value));
                    Ok(Intervals::from(Estimate { probability: found.value, low: found.low, high: found.high }))
                };
                self.scan(targets, TOLERANCES[1], &[], estimate)
            }
            LimitMethod::CriticalValues(varied) => self.by_critical_values(cell, varied, targets, is_stopped),
            LimitMethod::WeightedSamples => {
                let (job, axis, confidence) = (self.job, self.axis, self.confidence);
                let search = WeightedSearch { job, axis, cell, confidence, asked: &asked, estimated: self.estimated };
                search.limits(&self.values(), targets, is_stopped)
            }
            LimitMethod::Samples => {
                let estimate = |value: f64| {
                    let found = self.of_samples(cell, value, &asked, is_stopped)?;
                    if self.job.answer() == Answer::Probability {
                        self.beside_targets(value, targets, found.estimate)?;
                    }
                    Ok(found)
                };
                self.scan(targets, TOLERANCES[1], &[], estimate)
            }
        }
    }

    /// Requires that an estimate over critical values has a probability, or bounds on one side of every target.
    ///
    /// # Errors
    /// A target between bounds that leave the probability open.
    fn beside_targets(&self, value: f64, targets: &[f64], found: Estimate) -> Result<(), Ended> {
        let Estimate { probability: None, low, high } = found else { return Ok(()) };
        let Some(target) = targets.iter().find(|&&target| low <= target && target < high) else { return Ok(()) };
        let name = &self.axis.name;
        Err(Ended::Failed(Failure::Job(format!(
            "with {name} = {value} the probability is left open between {low:.6} and {high:.6}, and the target {target} is between these: critical values could not be told apart. Use sampling.method = \"importance\", or leave such values out of axes.{name}"
        ))))
    }

    /// The values of the axis at which the probability is first estimated.
    fn values(&self) -> Vec<f64> {
        scanned(self.axis, self.method).unwrap_or_else(|| scanned_values(&self.axis.values, INTERVALS[0]))
    }

    /// The limits from a scan over the values of the axis and `further` ones.
    fn scan(
        &self,
        targets: &[f64],
        tolerance: f64,
        further: &[f64],
        estimate: impl Fn(f64) -> Result<Intervals, Ended>,
    ) -> Result<CombinationLimits, Ended> {
        let mut values = self.values();
        values.extend(further);
        values.sort_by(f64::total_cmp);
        values.dedup();
        let estimate = each_once(self.estimated, estimate);
        let usual = |value: f64| estimate(value).map(|found| found.estimate);
        let scan = Scan::new(&values, tolerance, usual)?;
        let limits = |&target: &f64| scan.limits(target, usual);
        let of_targets = targets.iter().map(limits).collect::<Result<_, _>>()?;
        CombinationLimits::new(&scan, of_targets, estimate)
    }

    /// The limits from the critical values of all samples.
    fn by_critical_values(
        &self,
        cell: u64,
        varied: usize,
        targets: &[f64],
        is_stopped: IsStopped<'_>,
    ) -> Result<CombinationLimits, Ended> {
        let job = self.job;
        let evaluator = Evaluator::new(job).map_err(Ended::Failed)?;
        let sweeps = evaluator.sweeps(cell, varied, self.axis.range(), is_stopped).ok_or(Ended::Stopped)?;
        if let ([sweep], Effort::Samples(_)) = (&sweeps[..], &job.sampling.effort) {
            let interval = job.interval(self.confidence);
            let unaudited = |limit| (limit, None);
            let limits = |&target: &f64| sweep.limits(target, &interval).into_iter().map(unaudited).collect();
            let ([from, to], [first, last]) = (self.axis.range(), sweep.ends());
            let ends = [Beside::unchecked(from, first), Beside::unchecked(to, last)];
            return Ok(CombinationLimits { ends, of_targets: targets.iter().map(limits).collect() });
        }
        let sweeps = GroupedSweeps::new(&sweeps);
        let inputs = job.random.inputs.len();
        let estimate = |value: f64| {
            let counts = sweeps.at(value);
            Ok(Intervals::new(self.confidence, |confidence| randomisations::estimate(&counts, inputs, confidence)))
        };
        self.scan(targets, TOLERANCES[0], &sweeps.changes(CHANGES), estimate)
    }

    /// The estimate from the samples of a cell with another value of the axis.
    fn of_samples(
        &self,
        cell: u64,
        value: f64,
        asked: &Asked<'_>,
        is_stopped: IsStopped<'_>,
    ) -> Result<Intervals, Ended> {
        let job = self.axis.job_at(self.job, value);
        job.configuration_in(&job.grid.cell(cell)).map_err(|error| Ended::NoSuchConfiguration(value, error))?;
        let evaluator = Evaluator::new(&job).map_err(Ended::Failed)?;
        let parts = evaluator.count_cell(cell, asked, is_stopped).ok_or(Ended::Stopped)?;
        Ok(Intervals::new(self.confidence, |confidence| match job.sampling.effort {
            Effort::Randomisations { .. } => randomised::estimate(&job, &parts, confidence),
            _ => {
                let all = parts.iter().fold(VerdictCounts::default(), |sum, part| sum + part.counts);
                job.interval(confidence).estimate(&all)
            }
        }))
    }

    /// The pair in a cell with another value of the axis.
    fn moved(&self, cell: &Cell, value: f64) -> NormalPair {
        let mut cell = cell.clone();
        cell.expected[self.axis.quantity] = value;
        self.job.normal_pair(&cell)
    }
}

impl Evaluator<'_> {
    /// The samples of each part of a cell for all expected values of one of the pair in a range; `None` if it
    /// is stopped before. The job decides in closed form.
    ///
    /// Deviates and all other inputs are those of the samples of the cell.
    fn sweeps(&self, cell: u64, varied: usize, range: [f64; 2], is_stopped: IsStopped<'_>) -> Option<Vec<SortedSweep>> {
        let mut cell = self.job.grid.cell(cell);
        // Every input is its expected value times a ratio: at 1 it is the ratio.
        let pair = self.job.model().pair()?;
        cell.expected[pair[varied]] = 1.0;
        let outside = match self.job.outside_physics {
            // At the edge of the model nothing is pressed, friction does not fall, or there is none: all is stable.
            OutsidePhysics::Stable | OutsidePhysics::Clamp => Outside::Stable,
            OutsidePhysics::Failed => Outside::WithoutVerdict,
        };
        // Where every sample has a configuration of its own, its second quantity must be admissible.
        let has_own = self.job.random.other().is_some();
        let most_second = if has_own { self.job.quantity(pair[1]).limits.maximum } else { f64::INFINITY };
        let mut sweeps = Vec::with_capacity(self.parts.of_a_cell());
        for place in 0..self.parts.of_a_cell() {
            let mut sweep = Sweep::new(range);
            let mut drawing = self.draw(&cell, place, &(0..self.parts.max_samples(place)), self.job.points());
            while let Some(samples) = drawing.next_chunk(self.chunk) {
                if is_stopped() {
                    return None;
                }
                let boundaries = self.criteria.boundaries(self.job, &cell, samples);
                for (i, boundary) in boundaries.into_iter().enumerate() {
                    let pair = samples.pair(i);
                    let (ratio, other) = (pair[varied], pair[1 - varied]);
                    let of = |boundary| Sample { boundary, ratio, other, most_second };
                    let spans = boundary.map(|boundary| Spans::new(&of(boundary), varied, outside));
                    sweep.add(&spans.unwrap_or_else(Spans::without_verdict));
                }
            }
            sweeps.push(sweep.sorted());
        }
        Some(sweeps)
    }
}
