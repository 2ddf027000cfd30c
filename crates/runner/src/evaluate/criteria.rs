//! The criterion of a job, prepared for its brakes.

use std::sync::{Arc, OnceLock};

use stickslip_core::criterion::decision::Decision;
use stickslip_core::criterion::time_domain::{TimeDomain, TimeDomainError};
use stickslip_core::flexible_disc::brake::FlexibleBrake;
use stickslip_core::parameters::Parameters;
use stickslip_core::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use stickslip_core::rigid_disc::stability::StabilityBoundary;
use stickslip_core::verdict::{Verdict, VerdictCounts};
use stickslip_sampler::grid::Cell;

use crate::evaluate::samples::Samples;
use crate::job::{Criterion, Job, RandomInput};

/// Largest number of brakes of a grid whose criteria are kept once they are prepared; a flexible disc takes some 100 kB.
const MOST_KEPT: usize = 1000;

/// What decides the samples of a job.
pub enum Criteria {
    /// Only preload and static friction scatter. There is one criterion for each brake of the grid.
    ByBrake(BrakeCriteria),
    /// Other parameters scatter, too. Every sample is a brake of its own.
    BySample(Box<VaryingBrake>),
}

/// The criteria of the brakes of a grid. Each is prepared when it is first wanted, and kept unless there are too many.
pub struct BrakeCriteria(Vec<OnceLock<Option<Arc<ReadyCriterion>>>>);

impl BrakeCriteria {
    fn new(job: &Job) -> Self {
        let brakes = job.grid.brakes();
        let kept = if brakes <= MOST_KEPT { brakes } else { 0 };
        Self((0..kept).map(|_| OnceLock::new()).collect())
    }

    /// The criterion for a brake; `None` if it cannot be prepared, as between the extremes of the axes, where alone this was
    /// checked, no such brake may exist.
    fn get(&self, job: &Job, brake: usize) -> Option<Arc<ReadyCriterion>> {
        let prepare = || ReadyCriterion::new(job.brake(brake).ok()?, &job.criterion).ok().map(Arc::new);
        match self.0.get(brake) {
            Some(kept) => kept.get_or_init(prepare).clone(),
            None => prepare(),
        }
    }
}

/// A criterion for one brake, given everything but preload and static friction.
pub enum ReadyCriterion {
    /// See [`Criterion::Eigenvalue`].
    Eigenvalue(StabilityBoundary),
    /// See [`Criterion::CoupledEigenvalue`].
    CoupledEigenvalue(Box<FlexibleBrake>),
    /// See [`Criterion::TimeDomain`].
    TimeDomain(Box<TimeDomain>),
}

impl ReadyCriterion {
    /// Prepares the criterion of a job for a brake.
    pub fn new(brake: PadOnDisc, criterion: &Criterion) -> Result<Self, TimeDomainError> {
        Ok(match criterion {
            Criterion::Eigenvalue => Self::Eigenvalue(brake.stability_boundary()),
            Criterion::CoupledEigenvalue { modes } => {
                Self::CoupledEigenvalue(Box::new(FlexibleBrake::with_modes(brake, *modes)?))
            }
            Criterion::TimeDomain { disc, settings } => {
                Self::TimeDomain(Box::new(TimeDomain::new(&brake, disc, *settings)?))
            }
        })
    }

    /// Decides samples.
    pub fn decide(&self, inputs: &[RandomInputs]) -> Vec<Decision> {
        match self {
            Self::Eigenvalue(boundary) => {
                inputs.iter().map(|inputs| boundary.verdict(inputs.preload, inputs.static_friction).into()).collect()
            }
            Self::CoupledEigenvalue(brake) => {
                inputs.iter().map(|&inputs| brake.decide_with(inputs, FlexibleBrake::linear_stability)).collect()
            }
            Self::TimeDomain(criterion) => criterion.decide_all(inputs),
        }
    }

    /// Decides the one sample of a brake.
    fn decide_one(&self, inputs: RandomInputs) -> Decision {
        match self {
            Self::Eigenvalue(boundary) => boundary.verdict(inputs.preload, inputs.static_friction).into(),
            // `linear_stability` prepares for many samples of one brake, which does not pay for a single one.
            Self::CoupledEigenvalue(brake) => brake.decide_with(inputs, FlexibleBrake::by_eigenvalues),
            Self::TimeDomain(criterion) => criterion.decide(inputs),
        }
    }
}

/// A brake with random parameters other than preload and static friction.
pub struct VaryingBrake {
    criterion: Criterion,
    inputs: Vec<RandomInput>,
}

impl VaryingBrake {
    /// The brake of one sample; `None` if a value is not admissible. `expected` are the parameters of its cell, `values` its
    /// random inputs, in the job's order.
    fn brake(
        &self,
        expected: &Parameters,
        inputs: RandomInputs,
        values: impl Iterator<Item = f64>,
    ) -> Option<PadOnDisc> {
        let mut parameters = expected.clone();
        parameters.friction.static_coefficient = inputs.static_friction;
        for (input, value) in self.inputs.iter().zip(values) {
            if let RandomInput::Other(scalar) = input {
                parameters.set(scalar.key, value).ok()?;
            }
        }
        // A brake cannot be made with friction that rises with speed. The sample is decided with its own static
        // friction.
        let friction = &mut parameters.friction;
        friction.static_coefficient = friction.static_coefficient.max(friction.kinetic_coefficient);
        PadOnDisc::new(parameters).ok()
    }

    /// Decides one sample. It fails if a value is not admissible, such as a stiffness below zero.
    fn decide(&self, expected: &Parameters, inputs: RandomInputs, values: impl Iterator<Item = f64>) -> Decision {
        let failed = Decision::from(Verdict::Failed);
        let Some(brake) = self.brake(expected, inputs, values) else { return failed };
        if inputs.preload <= 0.0 {
            return Verdict::Stable.into();
        }
        ReadyCriterion::new(brake, &self.criterion).map_or(failed, |criterion| criterion.decide_one(inputs))
    }
}

impl Criteria {
    /// Prepares the criterion of a job.
    ///
    /// # Errors
    /// If it cannot be prepared for the first brake of the grid.
    pub fn new(job: &Job) -> Result<Self, TimeDomainError> {
        if job.random.other().is_some() {
            let inputs = job.random.inputs.clone();
            return Ok(Self::BySample(Box::new(VaryingBrake { criterion: job.criterion.clone(), inputs })));
        }
        ReadyCriterion::new(job.brake(0)?, &job.criterion)?;
        Ok(Self::ByBrake(BrakeCriteria::new(job)))
    }

    /// The criterion for a brake of the grid of a job; `None` if every sample is a brake of its own.
    pub fn for_brake(&self, job: &Job, brake: usize) -> Option<Arc<ReadyCriterion>> {
        match self {
            Self::ByBrake(criteria) => criteria.get(job, brake),
            Self::BySample(_) => None,
        }
    }

    /// The stability boundary of a brake of the grid of a job, if it is known in closed form.
    pub fn boundary(&self, job: &Job, brake: usize) -> Option<StabilityBoundary> {
        match *self.for_brake(job, brake)? {
            ReadyCriterion::Eigenvalue(boundary) => Some(boundary),
            _ => None,
        }
    }

    /// The verdict counts of samples of a brake, if the boundary is known in closed form.
    #[inline]
    pub fn count(&self, job: &Job, brake: usize, samples: &Samples) -> Option<VerdictCounts> {
        Some(self.boundary(job, brake)?.count(samples.preloads(), samples.static_frictions()))
    }

    /// Decides some of the samples of a cell.
    pub fn decide(&self, job: &Job, cell: &Cell, samples: &Samples, wanted: &[usize]) -> Vec<Decision> {
        let failed = || vec![Decision::from(Verdict::Failed); wanted.len()];
        match self {
            Self::ByBrake(criteria) => {
                let Some(criterion) = criteria.get(job, job.grid.brake_index(cell.index)) else { return failed() };
                let inputs: Vec<RandomInputs> = wanted.iter().map(|&sample| samples.pair(sample)).collect();
                criterion.decide(&inputs)
            }
            Self::BySample(varying) => {
                let Ok(expected) = job.brakes().in_cell(cell) else { return failed() };
                let decide = |&sample: &usize| varying.decide(&expected, samples.pair(sample), samples.values(sample));
                wanted.iter().map(decide).collect()
            }
        }
    }

    /// The brake of a sample of a cell; `None` if a value is not admissible.
    pub fn brake(&self, job: &Job, cell: &Cell, samples: &Samples, sample: usize) -> Option<PadOnDisc> {
        let expected = job.brakes().in_cell(cell).ok()?;
        match self {
            Self::ByBrake(_) => PadOnDisc::new(expected).ok(),
            Self::BySample(varying) => varying.brake(&expected, samples.pair(sample), samples.values(sample)),
        }
    }
}
