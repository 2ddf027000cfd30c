//! The criterion of a job, prepared for its brakes.

use stickslip_core::criterion::decision::Decision;
use stickslip_core::criterion::time_domain::{TimeDomain, TimeDomainError};
use stickslip_core::flexible_disc::brake::FlexibleBrake;
use stickslip_core::lanes::closed_form::VaryingClosedForm;
use stickslip_core::parameters::Scalar;
use stickslip_core::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use stickslip_core::rigid_disc::stability::StabilityBoundary;
use stickslip_core::rigid_disc::varying_brake::VaryingBrake;
use stickslip_core::verdict::{Verdict, VerdictCounts};

use crate::evaluate::samples::Samples;
use crate::job::{Criterion, Job};

/// What decides the samples of a job.
pub struct Criteria {
    /// One for each rotating speed of the grid.
    by_speed: Vec<ReadyCriterion>,
    /// Which random inputs are parameters other than preload and static friction.
    others: Vec<usize>,
}

/// A criterion at one rotating speed.
pub enum ReadyCriterion {
    /// See [`Criterion::Eigenvalue`].
    Eigenvalue(StabilityBoundary),
    /// See [`Criterion::CoupledEigenvalue`].
    CoupledEigenvalue(Box<FlexibleBrake>),
    /// See [`Criterion::TimeDomain`].
    TimeDomain(Box<TimeDomain>),
    /// [`Criterion::Eigenvalue`] where parameters other than preload and static friction scatter.
    VaryingEigenvalue(Box<VaryingClosedForm>),
    /// Any other criterion there: every sample is a brake of its own.
    Varying(Box<VaryingCriterion>),
}

/// A criterion that is prepared for each sample.
pub struct VaryingCriterion {
    brake: VaryingBrake,
    criterion: Criterion,
}

impl ReadyCriterion {
    /// Prepares the criterion of a job for a brake of which no parameter scatters but preload and static friction.
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

    /// Prepares the criterion of a job for brakes that differ from sample to sample.
    fn varying(brake: VaryingBrake, criterion: &Criterion) -> Self {
        match criterion {
            Criterion::Eigenvalue => Self::VaryingEigenvalue(Box::new(VaryingClosedForm::new(brake))),
            _ => Self::Varying(Box::new(VaryingCriterion { brake, criterion: criterion.clone() })),
        }
    }

    /// Decides samples of one brake.
    pub fn decide(&self, inputs: &[RandomInputs]) -> Vec<Decision> {
        match self {
            Self::Eigenvalue(boundary) => {
                inputs.iter().map(|inputs| boundary.verdict(inputs.preload, inputs.static_friction).into()).collect()
            }
            Self::CoupledEigenvalue(brake) => {
                inputs.iter().map(|&inputs| brake.decide_with(inputs, FlexibleBrake::linear_stability)).collect()
            }
            Self::TimeDomain(criterion) => criterion.decide_all(inputs),
            // Without a value for each parameter that scatters there is no brake.
            Self::VaryingEigenvalue(_) | Self::Varying(_) => vec![Verdict::Failed.into(); inputs.len()],
        }
    }

    /// Decides the one sample of a brake.
    fn decide_one(&self, inputs: RandomInputs) -> Decision {
        match self {
            // `linear_stability` prepares for many samples of one brake, which does not pay for a single one.
            Self::CoupledEigenvalue(brake) => brake.decide_with(inputs, FlexibleBrake::by_eigenvalues),
            Self::TimeDomain(criterion) => criterion.decide(inputs),
            _ => self.decide(&[inputs]).pop().unwrap_or(Verdict::Failed.into()),
        }
    }
}

impl VaryingCriterion {
    /// Decides one sample, `value(i)` being its value of scalar `i`. It fails if a value is not admissible, such as a
    /// stiffness below zero.
    fn decide(&self, inputs: RandomInputs, value: impl Fn(usize) -> f64) -> Decision {
        let failed = Decision::from(Verdict::Failed);
        let Some(brake) = self.brake.brake(inputs, value) else { return failed };
        if inputs.preload <= 0.0 {
            return Verdict::Stable.into();
        }
        ReadyCriterion::new(brake, &self.criterion).map_or(failed, |criterion| criterion.decide_one(inputs))
    }
}

impl Criteria {
    /// Prepares the criterion of a job.
    pub fn new(job: &Job) -> Result<Self, TimeDomainError> {
        let others = job.random.inputs.iter().enumerate();
        let others = others.filter_map(|(i, input)| Some((i, input.scalar()?)));
        let (others, scalars): (Vec<usize>, Vec<&'static Scalar>) = others.unzip();
        let ready = |brake: PadOnDisc| {
            if scalars.is_empty() {
                ReadyCriterion::new(brake, &job.criterion)
            } else {
                Ok(ReadyCriterion::varying(VaryingBrake::new(brake, scalars.clone()), &job.criterion))
            }
        };
        let by_speed = job.brakes()?.into_iter().map(ready).collect::<Result<_, _>>()?;
        Ok(Self { by_speed, others })
    }

    /// The criterion at a rotating speed of the grid; `None` if every sample is a brake of its own.
    pub fn at_speed(&self, speed: usize) -> Option<&ReadyCriterion> {
        self.by_speed.get(speed).filter(|_| self.others.is_empty())
    }

    /// The stability boundary at a rotating speed of the grid, if it is known in closed form.
    pub fn boundary(&self, speed: usize) -> Option<&StabilityBoundary> {
        match self.by_speed.get(speed) {
            Some(ReadyCriterion::Eigenvalue(boundary)) => Some(boundary),
            _ => None,
        }
    }

    /// The verdict counts of samples at one rotating speed, if they are decided in closed form.
    #[inline]
    pub fn count(&self, speed: usize, samples: &Samples) -> Option<VerdictCounts> {
        match self.by_speed.get(speed)? {
            ReadyCriterion::Eigenvalue(boundary) => {
                Some(boundary.count(samples.preloads(), samples.static_frictions()))
            }
            ReadyCriterion::VaryingEigenvalue(form) => {
                let columns = self.columns(samples);
                Some(form.count(samples.preloads(), samples.static_frictions(), &columns))
            }
            _ => None,
        }
    }

    /// The values of the parameters other than preload and static friction.
    fn columns<'s>(&self, samples: &'s Samples) -> Vec<&'s [f64]> {
        self.others.iter().map(|&input| samples.values_of(input)).collect()
    }

    /// Decides some of the samples at one rotating speed.
    pub fn decide(&self, speed: usize, samples: &Samples, wanted: &[usize]) -> Vec<Decision> {
        let columns = self.columns(samples);
        match &self.by_speed[speed] {
            ReadyCriterion::VaryingEigenvalue(form) => {
                let mut verdicts = Vec::with_capacity(samples.len());
                form.decide(samples.preloads(), samples.static_frictions(), &columns, &mut verdicts);
                wanted.iter().map(|&sample| verdicts[sample].into()).collect()
            }
            ReadyCriterion::Varying(criterion) => {
                let decide = |&sample: &usize| criterion.decide(samples.pair(sample), |i| columns[i][sample]);
                wanted.iter().map(decide).collect()
            }
            one_brake => {
                let inputs: Vec<RandomInputs> = wanted.iter().map(|&sample| samples.pair(sample)).collect();
                one_brake.decide(&inputs)
            }
        }
    }

    /// The brake of a sample at one rotating speed of a job; `None` if a value is not admissible.
    pub fn brake(&self, job: &Job, rotating_speed: f64, samples: &Samples, sample: usize) -> Option<PadOnDisc> {
        let mut parameters = job.parameters.clone();
        parameters.operating_point.rotating_speed = rotating_speed;
        let brake = PadOnDisc::new(parameters).ok()?;
        if self.others.is_empty() {
            return Some(brake);
        }
        let columns = self.columns(samples);
        let scalars = self.others.iter().filter_map(|&input| job.random.inputs[input].scalar()).collect();
        VaryingBrake::new(brake, scalars).brake(samples.pair(sample), |i| columns[i][sample])
    }
}
