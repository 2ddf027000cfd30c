//! Limits along an axis of a job, in one combination of the other axes.

use stickslip_core::parameters::{ParameterError, Parameters, scalar};
use stickslip_core::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_core::rigid_disc::stability::StabilityBoundary;
use stickslip_core::verdict::VerdictCounts;
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::estimate::randomisations;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::integrate::verdict_map::MapRegions;
use stickslip_sampler::limits::randomised::GroupedSweeps;
use stickslip_sampler::limits::scan::{Scan, scanned_values};
use stickslip_sampler::limits::spans::{OutsidePhysics as Outside, Sample, Spans, Varied};
use stickslip_sampler::limits::sweep::{SortedSweep, Sweep};

use crate::evaluate::control::IsStopped;
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::integral::exact_probability;
use crate::evaluate::randomised;
use crate::evaluate::weighted_limits::{CombinationLimits, Ended, WeightedSearch};
use crate::job::{Effort, Job, LimitAxis, LimitMethod, OutsidePhysics};

/// Least numbers of intervals of a scan: of a probability that takes little to compute, over a map, and of samples that are
/// all evaluated at each value.
const INTERVALS: [usize; 3] = [256, 64, 32];

/// Changes of verdicts among which those are that a scan of Sobol points has besides.
const CHANGES: usize = 1024;

/// To which part of itself a limit is located: of a probability that takes little to compute, and of others.
const TOLERANCES: [f64; 2] = [1e-12, 1e-9];

/// A search for limits along an axis of a job.
pub struct LimitSearch<'a> {
    job: &'a Job,
    axis: &'a LimitAxis,
    method: LimitMethod,
    /// Confidence of the intervals of probabilities.
    confidence: f64,
    /// The regions of the verdict maps, where the method integrates over these.
    regions: &'a [MapRegions],
}

/// The values of the axis at which the probability is first estimated; none where samples have critical values.
pub fn scanned(axis: &LimitAxis, method: LimitMethod) -> Option<Vec<f64>> {
    let intervals = match method {
        LimitMethod::Integral => INTERVALS[0],
        LimitMethod::MapIntegral => INTERVALS[1],
        LimitMethod::Samples | LimitMethod::WeightedSamples => INTERVALS[2],
        LimitMethod::CriticalValues(_) => return None,
    };
    Some(scanned_values(&axis.values, intervals))
}

impl<'a> LimitSearch<'a> {
    /// A search.
    pub fn new(
        job: &'a Job,
        axis: &'a LimitAxis,
        method: LimitMethod,
        confidence: f64,
        regions: &'a [MapRegions],
    ) -> Self {
        Self { job, axis, method, confidence, regions }
    }

    /// The limits of the combination of `cell`, which has the first value of the axis.
    ///
    /// # Errors
    /// See [`Ended`].
    pub fn limits(&self, cell: u64, targets: &[f64], is_stopped: IsStopped<'_>) -> Result<CombinationLimits, Ended> {
        let go_on = || if is_stopped() { Err(Ended::Stopped) } else { Ok(()) };
        match self.method {
            LimitMethod::Integral => {
                let open = OpenCell::new(self.job, self.axis, cell)
                    .map_err(|error| Ended::NoSuchBrake(self.axis.values[0], error))?;
                let estimate = |value: f64| {
                    go_on()?;
                    open.probability(value).map_err(|error| Ended::NoSuchBrake(value, error))
                };
                self.scan(targets, TOLERANCES[0], &[], estimate)
            }
            LimitMethod::MapIntegral => {
                let (place, brake) = (self.job.grid.cell(cell), self.job.grid.brake_index(cell));
                let estimate = |value: f64| {
                    go_on()?;
                    let found = self.regions[brake].probability(&self.moved(&place, value));
                    Ok(Estimate { probability: found.value, low: found.low, high: found.high })
                };
                self.scan(targets, TOLERANCES[1], &[], estimate)
            }
            LimitMethod::CriticalValues(varied) => self.by_critical_values(cell, varied, targets, is_stopped),
            LimitMethod::WeightedSamples => {
                let search = WeightedSearch { job: self.job, axis: self.axis, cell, confidence: self.confidence };
                search.limits(&self.values(), targets, is_stopped)
            }
            LimitMethod::Samples => {
                let estimate = |value: f64| self.of_samples(cell, value, is_stopped);
                self.scan(targets, TOLERANCES[1], &[], estimate)
            }
        }
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
        estimate: impl Fn(f64) -> Result<Estimate, Ended>,
    ) -> Result<CombinationLimits, Ended> {
        let mut values = self.values();
        values.extend(further);
        values.sort_by(f64::total_cmp);
        values.dedup();
        let scan = Scan::new(&values, tolerance, &estimate)?;
        let limits = |&target: &f64| scan.limits(target, &estimate);
        Ok(CombinationLimits { ends: scan.ends(), of_targets: targets.iter().map(limits).collect::<Result<_, _>>()? })
    }

    /// The limits from the critical values of all samples.
    fn by_critical_values(
        &self,
        cell: u64,
        varied: Varied,
        targets: &[f64],
        is_stopped: IsStopped<'_>,
    ) -> Result<CombinationLimits, Ended> {
        let job = self.job;
        let evaluator = Evaluator::new(job).map_err(Ended::Failed)?;
        let sweeps = evaluator.sweeps(cell, varied, self.axis.range(), is_stopped).ok_or(Ended::Stopped)?;
        if let ([sweep], Effort::Samples(_)) = (&sweeps[..], &job.sampling.effort) {
            let interval = job.interval(self.confidence);
            let of_targets = targets.iter().map(|&target| sweep.limits(target, &interval)).collect();
            return Ok(CombinationLimits { ends: sweep.ends(), of_targets });
        }
        let sweeps = GroupedSweeps::new(&sweeps);
        let inputs = job.random.inputs.len();
        let estimate = |value: f64| Ok(randomisations::estimate(&sweeps.at(value), inputs, self.confidence));
        self.scan(targets, TOLERANCES[0], &sweeps.changes(CHANGES), estimate)
    }

    /// The estimate from the samples of a cell with another value of the axis.
    fn of_samples(&self, cell: u64, value: f64, is_stopped: IsStopped<'_>) -> Result<Estimate, Ended> {
        let no_brake = |error| Ended::NoSuchBrake(value, error);
        let job = self.axis.job_at(self.job, value);
        job.brake(job.grid.brake_index(cell)).map_err(no_brake)?;
        let evaluator = Evaluator::new(&job).map_err(Ended::Failed)?;
        let parts = evaluator.count_cell(cell, is_stopped).ok_or(Ended::Stopped)?;
        Ok(match job.sampling.effort {
            Effort::Randomisations { .. } => randomised::estimate(&job, &parts, self.confidence),
            _ => {
                let all = parts.iter().fold(VerdictCounts::default(), |sum, part| sum + part.counts);
                job.interval(self.confidence).estimate(&all)
            }
        })
    }

    /// A cell with another value of the axis, if that is preload or static friction.
    fn moved(&self, cell: &Cell, value: f64) -> Cell {
        match self.axis.varied() {
            Some(Varied::Preload) => Cell { preload: value, ..*cell },
            Some(Varied::StaticFriction) => Cell { static_friction: value, ..*cell },
            None => *cell,
        }
    }
}

/// A cell in which one parameter may have any value, for integrals.
struct OpenCell<'a> {
    job: &'a Job,
    axis: &'a LimitAxis,
    cell: Cell,
    /// Those of the brake, with the expected values of the cell.
    parameters: Parameters,
    /// The boundary of the brake, unless it depends on the parameter.
    boundary: Option<StabilityBoundary>,
}

impl<'a> OpenCell<'a> {
    /// A cell of a job.
    ///
    /// # Errors
    /// If no such brake exists.
    fn new(job: &'a Job, axis: &'a LimitAxis, cell: u64) -> Result<Self, ParameterError> {
        let cell = job.grid.cell(cell);
        let parameters = job.brakes().in_cell(&cell)?;
        let boundary = axis.varied().map(|_| PadOnDisc::new(parameters.clone())).transpose()?;
        Ok(Self { job, axis, cell, parameters, boundary: boundary.map(|brake| brake.stability_boundary()) })
    }

    /// The exact probability at a value of the parameter.
    ///
    /// # Errors
    /// If no such brake exists.
    fn probability(&self, value: f64) -> Result<Estimate, ParameterError> {
        let mut cell = self.cell;
        match self.axis.varied() {
            Some(Varied::Preload) => cell.preload = value,
            Some(Varied::StaticFriction) => cell.static_friction = value,
            None => {}
        }
        let found = match &self.boundary {
            Some(boundary) => exact_probability(self.job, boundary, &cell),
            None => {
                let mut parameters = self.parameters.clone();
                parameters.set(self.axis.scalar.key, value)?;
                exact_probability(self.job, &PadOnDisc::new(parameters)?.stability_boundary(), &cell)
            }
        };
        let [low, high] = found.bounds();
        Ok(Estimate { probability: Some(found.value), low, high })
    }
}

impl Evaluator<'_> {
    /// The samples of each part of a cell for all expected values of preload or static friction in a range; `None` if it
    /// is stopped before. The job decides in closed form.
    ///
    /// Deviates and all other inputs are those of the samples of the cell.
    fn sweeps(
        &self,
        cell: u64,
        varied: Varied,
        range: [f64; 2],
        is_stopped: IsStopped<'_>,
    ) -> Option<Vec<SortedSweep>> {
        let mut cell = self.job.grid.cell(cell);
        // Every input is its expected value times a ratio: at 1 it is the ratio.
        match varied {
            Varied::Preload => cell.preload = 1.0,
            Varied::StaticFriction => cell.static_friction = 1.0,
        }
        let outside = match self.job.outside_physics {
            OutsidePhysics::Stable => Outside::Stable,
            OutsidePhysics::Clamp => Outside::Clamped,
            OutsidePhysics::Failed => Outside::WithoutVerdict,
        };
        // Where every sample has a brake of its own, its friction must be admissible.
        let has_own_brakes = self.job.random.other().is_some();
        let limits = scalar("friction.static_coefficient").filter(|_| has_own_brakes).map(|scalar| scalar.limits);
        let most_friction = limits.map_or(f64::INFINITY, |limits| limits.maximum);
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
                    let (ratio, other) = match varied {
                        Varied::Preload => (pair.preload, pair.static_friction),
                        Varied::StaticFriction => (pair.static_friction, pair.preload),
                    };
                    let of = |boundary| Sample { boundary, ratio, other, most_friction };
                    let spans = boundary.map(|boundary| Spans::of(&of(boundary), varied, outside));
                    sweep.add(&spans.unwrap_or_else(Spans::without_verdict));
                }
            }
            sweeps.push(sweep.sorted());
        }
        Some(sweeps)
    }
}
