//! The criterion of a job, prepared for its brakes.

use stickslip_core::criterion::decision::Decision;
use stickslip_core::criterion::time_domain::{TimeDomain, TimeDomainError};
use stickslip_core::flexible_disc::brake::FlexibleBrake;
use stickslip_core::parameters::Parameters;
use stickslip_core::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use stickslip_core::rigid_disc::stability::StabilityBoundary;
use stickslip_core::verdict::{Verdict, VerdictCounts};

use crate::evaluate::samples::Samples;
use crate::job::{Criterion, Job, RandomInput};

/// What decides the samples of a job.
pub enum Criteria {
    /// Only preload and static friction scatter. There is one brake for each rotating speed of the grid.
    BySpeed(Vec<ReadyCriterion>),
    /// Other parameters scatter, too. Every sample is a brake of its own.
    BySample(Box<VaryingBrake>),
}

/// A criterion for one brake at one rotating speed, given everything but preload and static friction.
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
    parameters: Parameters,
    criterion: Criterion,
    inputs: Vec<RandomInput>,
}

impl VaryingBrake {
    /// The brake of one sample; `None` if a value is not admissible. `values` are its random inputs, in the job's
    /// order.
    fn brake(&self, rotating_speed: f64, inputs: RandomInputs, values: impl Iterator<Item = f64>) -> Option<PadOnDisc> {
        let mut parameters = self.parameters.clone();
        parameters.operating_point.rotating_speed = rotating_speed;
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
    fn decide(&self, rotating_speed: f64, inputs: RandomInputs, values: impl Iterator<Item = f64>) -> Decision {
        let failed = Decision::from(Verdict::Failed);
        let Some(brake) = self.brake(rotating_speed, inputs, values) else { return failed };
        if inputs.preload <= 0.0 {
            return Verdict::Stable.into();
        }
        ReadyCriterion::new(brake, &self.criterion).map_or(failed, |criterion| criterion.decide_one(inputs))
    }
}

impl Criteria {
    /// Prepares the criterion of a job.
    pub fn new(job: &Job) -> Result<Self, TimeDomainError> {
        if job.random.other().is_some() {
            return Ok(Self::BySample(Box::new(VaryingBrake {
                parameters: job.parameters.clone(),
                criterion: job.criterion.clone(),
                inputs: job.random.inputs.clone(),
            })));
        }
        let ready = |brake: PadOnDisc| ReadyCriterion::new(brake, &job.criterion);
        Ok(Self::BySpeed(job.brakes()?.into_iter().map(ready).collect::<Result<_, _>>()?))
    }

    /// The criterion at a rotating speed of the grid; `None` if every sample is a brake of its own.
    pub fn at_speed(&self, speed: usize) -> Option<&ReadyCriterion> {
        match self {
            Self::BySpeed(criteria) => criteria.get(speed),
            Self::BySample(_) => None,
        }
    }

    /// The stability boundary at a rotating speed of the grid, if it is known in closed form.
    pub fn boundary(&self, speed: usize) -> Option<&StabilityBoundary> {
        match self.at_speed(speed) {
            Some(ReadyCriterion::Eigenvalue(boundary)) => Some(boundary),
            _ => None,
        }
    }

    /// The verdict counts of samples at one rotating speed, if the boundary is known in closed form.
    #[inline]
    pub fn count(&self, speed: usize, samples: &Samples) -> Option<VerdictCounts> {
        Some(self.boundary(speed)?.count(samples.preloads(), samples.static_frictions()))
    }

    /// Decides some of the samples at one rotating speed.
    pub fn decide(&self, speed: usize, rotating_speed: f64, samples: &Samples, wanted: &[usize]) -> Vec<Decision> {
        match self {
            Self::BySpeed(criteria) => {
                let inputs: Vec<RandomInputs> = wanted.iter().map(|&sample| samples.pair(sample)).collect();
                criteria[speed].decide(&inputs)
            }
            Self::BySample(varying) => {
                let decide =
                    |&sample: &usize| varying.decide(rotating_speed, samples.pair(sample), samples.values(sample));
                wanted.iter().map(decide).collect()
            }
        }
    }

    /// The brake of a sample at one rotating speed of a job; `None` if a value is not admissible.
    pub fn brake(&self, job: &Job, rotating_speed: f64, samples: &Samples, sample: usize) -> Option<PadOnDisc> {
        match self {
            Self::BySpeed(_) => {
                let mut parameters = job.parameters.clone();
                parameters.operating_point.rotating_speed = rotating_speed;
                PadOnDisc::new(parameters).ok()
            }
            Self::BySample(varying) => varying.brake(rotating_speed, samples.pair(sample), samples.values(sample)),
        }
    }
}
