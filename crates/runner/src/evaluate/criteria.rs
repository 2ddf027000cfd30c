//! The criterion of a job, prepared for its brakes.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use stickslip_core::criterion::decision::Decision;
use stickslip_core::criterion::time_domain::{TimeDomain, TimeDomainError};
use stickslip_core::flexible_disc::brake::FlexibleBrake;
use stickslip_core::lanes::batch::decide_queue;
use stickslip_core::lanes::closed_form::VaryingClosedForm;
use stickslip_core::lanes::linear_stability::OwnBrake;
use stickslip_core::lanes::queue::{QueuedSample, SampleQueue};
use stickslip_core::motion::start::{GivenStart, Start};
use stickslip_core::parameters::Scalar;
use stickslip_core::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use stickslip_core::rigid_disc::stability::StabilityBoundary;
use stickslip_core::rigid_disc::varying_brake::VaryingBrake;
use stickslip_core::verdict::{Verdict, VerdictCounts};
use stickslip_sampler::grid::Cell;

use crate::evaluate::control::IsStopped;
use crate::evaluate::samples::Samples;
use crate::job::{Criterion, Job, StartValue};

/// Largest number of brakes of a grid whose criteria are kept once they are prepared; a flexible disc takes some 100
/// kB.
const MOST_KEPT: usize = 1000;

/// What decides the samples of a job.
pub struct Criteria {
    /// One for each brake of the grid. It is prepared when it is first wanted, and kept unless there are too many.
    /// `None` if it cannot be prepared: between the extremes of the axes, where alone this was checked, no such brake
    /// may exist.
    kept: Vec<OnceLock<Option<Arc<ReadyCriterion>>>>,
    /// The one for the first brake; others share with it what does not differ.
    first: Arc<ReadyCriterion>,
    /// Which random inputs are parameters other than preload and static friction.
    others: Vec<usize>,
    /// These parameters.
    scalars: Vec<&'static Scalar>,
}

/// A criterion for one brake of a grid. Where parameters other than preload and static friction scatter, every sample
/// has a brake of its own, which `varying` makes.
pub enum ReadyCriterion {
    /// See [`Criterion::Eigenvalue`].
    Eigenvalue(StabilityBoundary),
    /// [`Criterion::Eigenvalue`] where other parameters scatter.
    VaryingEigenvalue(Box<VaryingClosedForm>),
    /// See [`Criterion::CoupledEigenvalue`].
    CoupledEigenvalue { brake: Box<FlexibleBrake>, varying: Option<Box<VaryingBrake>> },
    /// See [`Criterion::TimeDomain`].
    TimeDomain { criterion: Box<TimeDomain>, varying: Option<Box<VaryingBrake>> },
}

impl ReadyCriterion {
    /// Prepares the criterion of a job for brakes that differ from `brake` in `scalars`, sample by sample.
    fn new(brake: PadOnDisc, criterion: &Criterion, scalars: &[&'static Scalar]) -> Result<Self, TimeDomainError> {
        let varying = (!scalars.is_empty()).then(|| VaryingBrake::new(brake.clone(), scalars.to_vec()));
        Ok(match (criterion, varying) {
            (Criterion::Eigenvalue, None) => Self::Eigenvalue(brake.stability_boundary()),
            (Criterion::Eigenvalue, Some(varying)) => {
                Self::VaryingEigenvalue(Box::new(VaryingClosedForm::new(varying)))
            }
            (Criterion::CoupledEigenvalue { modes }, varying) => Self::CoupledEigenvalue {
                brake: Box::new(FlexibleBrake::with_modes(brake, *modes)?),
                varying: varying.map(Box::new),
            },
            (Criterion::TimeDomain { disc, settings }, varying) => Self::TimeDomain {
                criterion: Box::new(TimeDomain::new(&brake, disc, *settings)?),
                varying: varying.map(Box::new),
            },
        })
    }

    /// The same criterion for another brake; what the geometry of the disc alone determines is not computed again.
    fn with_brake(
        &self,
        other: PadOnDisc,
        criterion: &Criterion,
        scalars: &[&'static Scalar],
    ) -> Result<Self, TimeDomainError> {
        let varying = (!scalars.is_empty()).then(|| Box::new(VaryingBrake::new(other.clone(), scalars.to_vec())));
        match self {
            Self::CoupledEigenvalue { brake, .. } => {
                Ok(Self::CoupledEigenvalue { brake: Box::new(brake.with_brake(other)?), varying })
            }
            Self::TimeDomain { criterion: first, .. } => {
                let ready = first.with_brake(&other)?;
                // A start in SI units is scaled by the brake.
                let given = criterion.given_start().map(|given| ready.with_start(Start::Given(given)));
                Ok(Self::TimeDomain { criterion: Box::new(given.unwrap_or(ready)), varying })
            }
            Self::Eigenvalue(_) | Self::VaryingEigenvalue(_) => Self::new(other, criterion, scalars),
        }
    }

    /// Decides samples of one brake, until `is_stopped`: those after it have no decision. Where every sample has a
    /// brake of its own, they fail.
    pub fn decide(&self, inputs: &[RandomInputs], is_stopped: IsStopped<'_>) -> Vec<Option<Decision>> {
        match self {
            Self::Eigenvalue(boundary) => {
                let verdict = |inputs: &RandomInputs| boundary.verdict(inputs.preload, inputs.static_friction);
                inputs.iter().map(|inputs| Some(verdict(inputs).into())).collect()
            }
            Self::CoupledEigenvalue { brake, varying: None } => {
                let stability =
                    |brake: &FlexibleBrake, inputs: RandomInputs| brake.linear_stability_until(inputs, is_stopped);
                let decide = |&inputs: &RandomInputs| brake.decide_with(inputs, stability);
                inputs.iter().map(|inputs| (!is_stopped()).then(|| decide(inputs))).collect()
            }
            Self::TimeDomain { criterion, varying: None } => criterion.decide_until(inputs, is_stopped),
            Self::VaryingEigenvalue(_) | Self::CoupledEigenvalue { .. } | Self::TimeDomain { .. } => {
                vec![Some(Verdict::Failed.into()); inputs.len()]
            }
        }
    }
}

/// What simulates the samples of a cell in time.
pub(super) struct Motions<'q> {
    criterion: &'q TimeDomain,
    brakes: Brakes<'q>,
    starts: Option<Starts>,
}

/// The brakes of the samples of a cell.
enum Brakes<'q> {
    /// That of the criterion.
    Shared,
    /// Another one, of all samples.
    Own(Box<PadOnDisc>),
    /// Every sample has its own.
    Varying(Cow<'q, Box<VaryingBrake>>),
}

/// Where the motions of a cell start, in a job in which they do not all start alike.
struct Starts {
    /// In numbers, but for those that scatter.
    given: GivenStart,
    /// The numbers that scatter, each with its position among the random inputs.
    random: Vec<(usize, StartValue)>,
}

impl Starts {
    /// `None` if all motions of a job start alike.
    fn of(job: &Job, cell: &Cell) -> Option<Self> {
        let random: Vec<_> = job.random.start_values().collect();
        // A start in SI units is scaled by the brake.
        let varies = !(random.is_empty() && job.grid.of_start.is_empty()) || job.random.other().is_some();
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
        let first = Arc::new(ReadyCriterion::new(job.brake(0)?, &job.criterion, &scalars)?);
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
            let ready = self.first.with_brake(job.brake(brake).ok()?, &job.criterion, &self.scalars);
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

    /// The stability boundary of the brake of each sample of a cell; `None` for a sample with a value that is not
    /// admissible, and for other criteria than [`Criterion::Eigenvalue`].
    pub fn boundaries(&self, job: &Job, cell: &Cell, samples: &Samples) -> Vec<Option<StabilityBoundary>> {
        let brake = job.grid.brake_index(cell.index);
        if self.scalars.is_empty() || !matches!(job.criterion, Criterion::Eigenvalue) {
            return vec![self.boundary(job, brake); samples.len()];
        }
        let Ok(brake) = job.brake(brake) else { return vec![None; samples.len()] };
        let varying = VaryingBrake::new(brake, self.scalars.clone());
        // A boundary holds for any preload and static friction.
        let inputs = RandomInputs { preload: 0.0, static_friction: 0.0 };
        let own = |sample: usize| varying.brake(inputs, |i| samples.values_of(self.others[i])[sample]);
        (0..samples.len()).map(|sample| own(sample).map(|brake| brake.stability_boundary())).collect()
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

    /// Decides some of the samples of a cell; `None` if it is stopped before.
    pub fn decide(
        &self,
        job: &Job,
        cell: &Cell,
        samples: &Samples,
        wanted: &[usize],
        is_stopped: IsStopped<'_>,
    ) -> Option<Vec<Decision>> {
        let failed = || Some(vec![Verdict::Failed.into(); wanted.len()]);
        if let ReadyCriterion::TimeDomain { .. } = *self.first {
            let Some(motions) = self.motions(job, cell) else { return failed() };
            let wanted = wanted.iter().enumerate();
            let queued = wanted.map(|(ticket, &sample)| self.queued(&motions, samples, sample, ticket as u64));
            return decide_all(queued, is_stopped);
        }
        let Some(ready) = self.for_brake(job, job.grid.brake_index(cell.index)) else { return failed() };
        match &*ready {
            ReadyCriterion::VaryingEigenvalue(form) => {
                let mut verdicts = Vec::with_capacity(samples.len());
                form.decide(samples.preloads(), samples.static_frictions(), &self.columns(samples), &mut verdicts);
                Some(wanted.iter().map(|&sample| verdicts[sample].into()).collect())
            }
            ReadyCriterion::CoupledEigenvalue { brake, varying: Some(varying) } => {
                let own_brake = |&sample: &usize| {
                    let inputs = samples.pair(sample);
                    Some(OwnBrake { brake: self.brake_of(varying, samples, sample)?, inputs })
                };
                let own: Vec<Option<OwnBrake>> = wanted.iter().map(own_brake).collect();
                let mut decided = brake.decide_own(&own.iter().flatten().cloned().collect::<Vec<_>>()).into_iter();
                let decision = |own: &Option<OwnBrake>| own.as_ref().and_then(|_| decided.next());
                Some(own.iter().map(decision).map(|decision| decision.unwrap_or(Verdict::Failed.into())).collect())
            }
            one_brake => {
                let inputs: Vec<RandomInputs> = wanted.iter().map(|&sample| samples.pair(sample)).collect();
                one_brake.decide(&inputs, is_stopped).into_iter().collect()
            }
        }
    }

    /// What simulates the samples of a cell in time; `None` if there is no such brake, or if the criterion is another.
    pub(super) fn motions(&self, job: &Job, cell: &Cell) -> Option<Motions<'_>> {
        let ReadyCriterion::TimeDomain { criterion: of_first, .. } = &*self.first else { return None };
        let starts = Starts::of(job, cell);
        let brake = job.grid.brake_index(cell.index);
        let kept = if brake == 0 {
            Some(&*self.first)
        } else if brake < self.kept.len() {
            self.for_brake(job, brake)?;
            self.kept[brake].get()?.as_deref()
        } else {
            None
        };
        if let Some(ReadyCriterion::TimeDomain { criterion, varying }) = kept {
            let brakes = varying.as_ref().map_or(Brakes::Shared, |varying| Brakes::Varying(Cow::Borrowed(varying)));
            return Some(Motions { criterion, brakes, starts });
        }
        // Too many brakes to keep their criteria: each sample takes its brake along.
        let brake = job.brake(brake).ok()?;
        let starts = starts.or_else(|| Some(Starts { given: job.criterion.given_start()?, random: Vec::new() }));
        let brakes = if self.scalars.is_empty() {
            Brakes::Own(Box::new(brake))
        } else {
            Brakes::Varying(Cow::Owned(Box::new(VaryingBrake::new(brake, self.scalars.clone()))))
        };
        Some(Motions { criterion: of_first, brakes, starts })
    }

    /// A sample for simulation in time, or its decision if it needs none. It fails if a value is not admissible, such
    /// as a stiffness below zero.
    pub(super) fn queued<'q>(
        &self,
        motions: &Motions<'q>,
        samples: &Samples,
        sample: usize,
        ticket: u64,
    ) -> Result<QueuedSample<'q>, Decision> {
        let mut queued = QueuedSample::new(ticket, motions.criterion, samples.pair(sample));
        match &motions.brakes {
            Brakes::Shared => {}
            Brakes::Own(brake) => queued.brake = Some((**brake).clone()),
            Brakes::Varying(varying) => {
                queued.brake = Some(self.brake_of(varying, samples, sample).ok_or(Decision::from(Verdict::Failed))?);
            }
        }
        if let Some(starts) = &motions.starts {
            queued.start = starts.of_sample(samples, sample);
        }
        Ok(queued)
    }

    /// The brake of a sample; `None` if a value is not admissible.
    fn brake_of(&self, varying: &VaryingBrake, samples: &Samples, sample: usize) -> Option<PadOnDisc> {
        varying.brake(samples.pair(sample), |i| samples.values_of(self.others[i])[sample])
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
        self.brake_of(&VaryingBrake::new(brake, self.scalars.clone()), samples, sample)
    }
}

/// Decides samples, some of which are decided already, in their order; `None` if it is stopped before.
fn decide_all<'q>(
    samples: impl Iterator<Item = Result<QueuedSample<'q>, Decision>>,
    is_stopped: IsStopped<'_>,
) -> Option<Vec<Decision>> {
    let mut list = List { samples, is_stopped, decisions: Vec::new() };
    decide_queue(&mut list);
    if list.is_cut_short() { None } else { list.decisions.into_iter().collect() }
}

/// Samples whose tickets are their places in a list.
struct List<'s, I> {
    samples: I,
    is_stopped: IsStopped<'s>,
    decisions: Vec<Option<Decision>>,
}

impl<I: Iterator> List<'_, I> {
    /// Whether samples were left when it was stopped.
    fn is_cut_short(&mut self) -> bool {
        self.samples.next().is_some()
    }
}

impl<'q, I: Iterator<Item = Result<QueuedSample<'q>, Decision>>> SampleQueue<'q> for List<'_, I> {
    fn next(&mut self) -> Option<QueuedSample<'q>> {
        while !self.is_stopped() {
            match self.samples.next()? {
                Ok(queued) => {
                    self.decisions.push(None);
                    return Some(queued);
                }
                Err(decision) => self.decisions.push(Some(decision)),
            }
        }
        None
    }

    fn decided(&mut self, ticket: u64, decision: Decision) {
        if let Some(place) = self.decisions.get_mut(ticket as usize) {
            *place = Some(decision);
        }
    }

    fn is_stopped(&self) -> bool {
        (self.is_stopped)()
    }
}
