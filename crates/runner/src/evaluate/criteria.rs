//! The criterion of a job, prepared for its brakes.

use std::sync::{Arc, OnceLock};

use stickslip_core::criterion::decision::Decision;
use stickslip_core::criterion::time_domain::{TimeDomain, TimeDomainError};
use stickslip_core::flexible_disc::brake::FlexibleBrake;
use stickslip_core::lanes::closed_form::VaryingClosedForm;
use stickslip_core::motion::start::{GivenStart, Start};
use stickslip_core::parameters::Scalar;
use stickslip_core::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use stickslip_core::rigid_disc::stability::StabilityBoundary;
use stickslip_core::rigid_disc::varying_brake::VaryingBrake;
use stickslip_core::verdict::{Verdict, VerdictCounts};
use stickslip_sampler::grid::Cell;

use crate::evaluate::samples::Samples;
use crate::job::{Criterion, Job, StartValue};

/// Largest number of brakes of a grid whose criteria are kept once they are prepared; a flexible disc takes some 100 kB.
const MOST_KEPT: usize = 1000;

/// What decides the samples of a job.
pub struct Criteria {
    /// One for each brake of the grid. It is prepared when it is first wanted, and kept unless there are too many. `None`
    /// if it cannot be prepared: between the extremes of the axes, where alone this was checked, no such brake may exist.
    kept: Vec<OnceLock<Option<Arc<ReadyCriterion>>>>,
    /// The one for the first brake; others share with it what does not differ.
    first: Arc<ReadyCriterion>,
    /// Which random inputs are parameters other than preload and static friction.
    others: Vec<usize>,
    /// These parameters.
    scalars: Vec<&'static Scalar>,
}

/// A criterion for one brake of a grid.
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

    /// Prepares the criterion of a job for brakes that differ from `brake` in `scalars`, sample by sample.
    fn with_scatter(
        brake: PadOnDisc,
        criterion: &Criterion,
        scalars: &[&'static Scalar],
    ) -> Result<Self, TimeDomainError> {
        if scalars.is_empty() {
            return Self::new(brake, criterion);
        }
        let brake = VaryingBrake::new(brake, scalars.to_vec());
        Ok(match criterion {
            Criterion::Eigenvalue => Self::VaryingEigenvalue(Box::new(VaryingClosedForm::new(brake))),
            _ => Self::Varying(Box::new(VaryingCriterion { brake, criterion: criterion.clone() })),
        })
    }

    /// The same criterion for another brake, if that takes less than to prepare it anew.
    fn with_brake(&self, brake: &PadOnDisc) -> Option<Result<Self, TimeDomainError>> {
        match self {
            Self::CoupledEigenvalue(first) => {
                let other = first.with_brake(brake.clone()).map_err(TimeDomainError::from);
                Some(other.map(|brake| Self::CoupledEigenvalue(Box::new(brake))))
            }
            _ => None,
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
    /// Decides one sample, `value(i)` being its value of scalar `i`, and `start` where its motion starts if that is not for
    /// all the same. It fails if a value is not admissible, such as a stiffness below zero.
    fn decide(&self, inputs: RandomInputs, value: impl Fn(usize) -> f64, start: Option<Start>) -> Decision {
        let failed = Decision::from(Verdict::Failed);
        let Some(brake) = self.brake.brake(inputs, value) else { return failed };
        if inputs.preload <= 0.0 {
            return Verdict::Stable.into();
        }
        match (ReadyCriterion::new(brake, &self.criterion), start) {
            (Ok(ReadyCriterion::TimeDomain(criterion)), Some(start)) => criterion.with_start(start).decide(inputs),
            (Ok(criterion), _) => criterion.decide_one(inputs),
            (Err(_), _) => failed,
        }
    }
}

/// Where the motions of a cell start, in a job in which they do not all start alike.
struct Starts {
    /// In numbers, but for those that scatter.
    given: GivenStart,
    /// The numbers that scatter, each with its position among the random inputs.
    random: Vec<(usize, StartValue)>,
}

impl Starts {
    fn of(job: &Job, cell: &Cell) -> Option<Self> {
        let random: Vec<_> = job.random.start_values().collect();
        let varies = !(random.is_empty() && job.grid.of_start.is_empty());
        let given = job.criterion.given_start().filter(|_| varies)?;
        Some(Self { given: job.brakes().start_in_cell(given, cell), random })
    }

    fn of_sample(&self, samples: &Samples, sample: usize) -> Start {
        let mut start = self.given;
        for &(input, number) in &self.random {
            number.set(&mut start, samples.values_of(input)[sample]);
        }
        Start::Given(start)
    }
}

impl Criteria {
    /// Prepares the criterion of a job.
    ///
    /// # Errors
    /// If it cannot be prepared for the first brake of the grid.
    pub fn new(job: &Job) -> Result<Self, TimeDomainError> {
        let others = job.random.inputs.iter().enumerate();
        let (others, scalars): (Vec<usize>, Vec<_>) =
            others.filter_map(|(i, input)| Some((i, input.scalar()?))).unzip();
        let first = Arc::new(ReadyCriterion::with_scatter(job.brake(0)?, &job.criterion, &scalars)?);
        let brakes = job.grid.brakes();
        let kept = if brakes <= MOST_KEPT { brakes } else { 0 };
        Ok(Self { kept: (0..kept).map(|_| OnceLock::new()).collect(), first, others, scalars })
    }

    /// The criterion for a brake of the grid of a job; `None` if there is no such brake.
    pub fn for_brake(&self, job: &Job, brake: usize) -> Option<Arc<ReadyCriterion>> {
        if brake == 0 {
            return Some(Arc::clone(&self.first));
        }
        let prepare = || {
            let brake = job.brake(brake).ok()?;
            let shared = self.first.with_brake(&brake);
            let ready = shared.unwrap_or_else(|| ReadyCriterion::with_scatter(brake, &job.criterion, &self.scalars));
            ready.ok().map(Arc::new)
        };
        match self.kept.get(brake) {
            Some(kept) => kept.get_or_init(prepare).clone(),
            None => prepare(),
        }
    }

    /// The stability boundary of a brake of the grid of a job, if it is known in closed form.
    pub fn boundary(&self, job: &Job, brake: usize) -> Option<StabilityBoundary> {
        match *self.for_brake(job, brake)? {
            ReadyCriterion::Eigenvalue(boundary) => Some(boundary),
            _ => None,
        }
    }

    /// The verdict counts of samples of a brake, if they are decided in closed form.
    #[inline]
    pub fn count(&self, job: &Job, brake: usize, samples: &Samples) -> Option<VerdictCounts> {
        match &*self.for_brake(job, brake)? {
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

    /// Decides some of the samples of a cell.
    pub fn decide(&self, job: &Job, cell: &Cell, samples: &Samples, wanted: &[usize]) -> Vec<Decision> {
        let Some(criterion) = self.for_brake(job, job.grid.brake_index(cell.index)) else {
            return vec![Verdict::Failed.into(); wanted.len()];
        };
        let columns = self.columns(samples);
        let starts = Starts::of(job, cell);
        let start = |sample: usize| starts.as_ref().map(|starts| starts.of_sample(samples, sample));
        match &*criterion {
            ReadyCriterion::VaryingEigenvalue(form) => {
                let mut verdicts = Vec::with_capacity(samples.len());
                form.decide(samples.preloads(), samples.static_frictions(), &columns, &mut verdicts);
                wanted.iter().map(|&sample| verdicts[sample].into()).collect()
            }
            ReadyCriterion::Varying(criterion) => {
                let decide =
                    |&sample: &usize| criterion.decide(samples.pair(sample), |i| columns[i][sample], start(sample));
                wanted.iter().map(decide).collect()
            }
            one_brake => {
                let inputs: Vec<RandomInputs> = wanted.iter().map(|&sample| samples.pair(sample)).collect();
                match (one_brake, &starts) {
                    (ReadyCriterion::TimeDomain(criterion), Some(Starts { given, random })) if random.is_empty() => {
                        criterion.with_start(Start::Given(*given)).decide_all(&inputs)
                    }
                    (ReadyCriterion::TimeDomain(criterion), Some(starts)) => {
                        let decide = |(&sample, &inputs): (&usize, &RandomInputs)| {
                            criterion.with_start(starts.of_sample(samples, sample)).decide(inputs)
                        };
                        wanted.iter().zip(&inputs).map(decide).collect()
                    }
                    _ => one_brake.decide(&inputs),
                }
            }
        }
    }

    /// Where the motion of a sample of a cell starts, if that is not for all the same.
    pub fn start(&self, job: &Job, cell: &Cell, samples: &Samples, sample: usize) -> Option<Start> {
        Starts::of(job, cell).map(|starts| starts.of_sample(samples, sample))
    }

    /// The brake of a sample of a cell; `None` if a value is not admissible.
    pub fn brake(&self, job: &Job, cell: &Cell, samples: &Samples, sample: usize) -> Option<PadOnDisc> {
        let brake = job.brake(job.grid.brake_index(cell.index)).ok()?;
        if self.others.is_empty() {
            return Some(brake);
        }
        let columns = self.columns(samples);
        VaryingBrake::new(brake, self.scalars.clone()).brake(samples.pair(sample), |i| columns[i][sample])
    }
}
