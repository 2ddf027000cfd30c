//! Brakes with a criterion, prepared for samples.

use std::any::Any;

use crate::friction::measured_curve::SharedCurve;
use crate::model::decision::Decision;
use crate::model::pair_boundary::PairBoundary;
use crate::model::recorded::{NOTHING, RecordedValues};
use crate::model::verdict::{Verdict, VerdictCounts};
use crate::model::{ClosedForm, Columns, Configuration, IsStopped, ModelError};
use crate::models::pad_on_disc::criterion::time_domain::TimeDomain;
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::lanes::batch::decide_queue;
use crate::models::pad_on_disc::lanes::closed_form::VaryingClosedForm;
use crate::models::pad_on_disc::lanes::linear_stability::OwnBrake;
use crate::models::pad_on_disc::lanes::queue::QueuedSample;
use crate::models::pad_on_disc::motion::start::{GivenStart, Start};
use crate::models::pad_on_disc::motion::start_value::StartValue;
use crate::models::pad_on_disc::parameters::{EFFECTIVE_RADIUS_KEY, Scalar};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use crate::models::pad_on_disc::rigid_disc::varying_brake::{HIGHEST_FRICTION, VaryingBrake};

use super::definition::Criterion;
use super::linear_results::{LinearRecord, Sample};
use super::list::List;
use super::quantities::{configuration_scalars, error, first_of_start};

/// What differs from sample to sample, by the places of the columns.
#[derive(Debug, Clone)]
pub(super) struct Varying {
    /// Parameters other than preload and static friction, each with its column.
    scalars: Vec<(usize, &'static Scalar)>,
    /// Numbers of the start.
    starts: Vec<(usize, StartValue)>,
    /// The start, where it is given in numbers.
    given: Option<GivenStart>,
}

impl Varying {
    pub(super) fn new(varying: &[usize], given: Option<GivenStart>) -> Self {
        let scalars: Vec<&'static Scalar> = configuration_scalars().collect();
        let (mut of_brake, mut starts) = (Vec::new(), Vec::new());
        for (column, &place) in varying.iter().enumerate().skip(2) {
            match place.checked_sub(first_of_start()) {
                Some(number) => starts.push((column, StartValue::ALL[number])),
                None => of_brake.push((column, scalars[place - 2])),
            }
        }
        Self { scalars: of_brake, starts, given }
    }

    /// Whether every sample has a brake of its own.
    fn has_own_brakes(&self) -> bool {
        !self.scalars.is_empty()
    }

    /// Where the motion of a sample starts, with its `values` of what varies.
    pub(super) fn start(&self, values: &[f64]) -> Option<Start> {
        let mut start = self.given?;
        for &(column, number) in &self.starts {
            number.set(&mut start, values[column]);
        }
        Some(Start::Given(start))
    }

    /// Whether samples do not all start alike: SI units are scaled by the brake.
    pub(super) fn has_own_starts(&self) -> bool {
        !self.starts.is_empty() || self.has_own_brakes()
    }
}

/// A brake with a criterion.
pub(super) struct PadConfiguration {
    pub(super) brake: PadOnDisc,
    pub(super) varying: Varying,
    /// Where samples have brakes of their own.
    own: Option<VaryingBrake>,
    pub(super) prepared: Prepared,
    record: LinearRecord,
}

pub(super) enum Prepared {
    /// Nothing but the brake.
    Outline,
    Eigenvalue(PairBoundary, Option<Box<VaryingClosedForm>>),
    CoupledEigenvalue(Box<FlexibleBrake>),
    TimeDomain(Box<TimeDomain>),
}

impl PadConfiguration {
    pub(super) fn outline(brake: PadOnDisc, varying: Varying) -> Self {
        let scalars: Vec<_> = varying.scalars.iter().map(|(_, scalar)| *scalar).collect();
        let own = varying.has_own_brakes().then(|| VaryingBrake::new(brake.clone(), scalars));
        Self { brake, varying, own, prepared: Prepared::Outline, record: LinearRecord::default() }
    }

    pub(super) fn new(
        brake: PadOnDisc,
        varying: Varying,
        criterion: &Criterion,
        like: Option<&Self>,
    ) -> Result<Self, ModelError> {
        let outline = Self::outline(brake, varying);
        let brake = &outline.brake;
        let prepared = match (criterion, like.map(|like| &like.prepared)) {
            (Criterion::Eigenvalue { .. }, _) => {
                let own = outline.own.clone().map(|own| Box::new(VaryingClosedForm::new(own)));
                Prepared::Eigenvalue(brake.stability_boundary(), own)
            }
            (Criterion::CoupledEigenvalue { .. }, Some(Prepared::CoupledEigenvalue(like))) => {
                Prepared::CoupledEigenvalue(Box::new(like.with_brake(brake.clone()).map_err(error)?))
            }
            (Criterion::CoupledEigenvalue { modes, .. }, _) => {
                let flexible = FlexibleBrake::with_modes(brake.clone(), *modes).map_err(error)?;
                Prepared::CoupledEigenvalue(Box::new(flexible))
            }
            (Criterion::TimeDomain { .. }, Some(Prepared::TimeDomain(like))) => {
                let ready = like.with_brake(brake).map_err(error)?;
                // A start in SI units is scaled by the brake.
                let given = outline.varying.given.map(|given| ready.with_start(Start::Given(given)));
                Prepared::TimeDomain(Box::new(given.unwrap_or(ready)))
            }
            (Criterion::TimeDomain { disc, settings }, _) => {
                Prepared::TimeDomain(Box::new(TimeDomain::new(brake, disc, *settings).map_err(error)?))
            }
        };
        Ok(Self { prepared, record: criterion.linear_record(), ..outline })
    }

    pub(super) fn from_any(configuration: &dyn Configuration) -> Option<&Self> {
        let any: &dyn Any = configuration;
        any.downcast_ref()
    }

    fn inputs(samples: &Columns<'_>, sample: usize) -> RandomInputs {
        RandomInputs { preload: samples.column(0)[sample], static_friction: samples.column(1)[sample] }
    }

    /// The brake of a sample with these values of what varies, if that is not the same for all; the inner `None` if a
    /// value is not admissible.
    pub(super) fn own_brake(&self, values: &[f64]) -> Option<Option<PadOnDisc>> {
        let inputs = RandomInputs { preload: values[0], static_friction: values[1] };
        self.own.as_ref().map(|own| own.brake(inputs, |i| values[self.varying.scalars[i].0]))
    }

    /// The columns of the parameters that vary, beside the pair.
    fn scalars<'s>(&self, samples: &Columns<'s>) -> Vec<&'s [f64]> {
        self.varying.scalars.iter().map(|(column, _)| samples.column(*column)).collect()
    }

    /// The least static friction coefficients of samples that are not outside the model.
    fn least_static<'s>(&self, samples: &Columns<'s>) -> LeastStatic<'s> {
        let column = |key: &str| {
            let own = self.varying.scalars.iter().find(|(_, scalar)| scalar.key == key);
            own.map(|(column, _)| samples.column(*column))
        };
        let parameters = self.brake.parameters();
        // Without a value of its own it is the outer radius.
        let radius = match parameters.pad.effective_radius {
            None => column(EFFECTIVE_RADIUS_KEY).or_else(|| column("disc.outer_radius")),
            Some(_) => column(EFFECTIVE_RADIUS_KEY),
        };
        LeastStatic {
            shared: self.brake.friction_law().least_static_coefficient(self.brake.disc_speed()),
            curve: parameters.friction.law.table().copied(),
            kinetic: column("friction.kinetic_coefficient"),
            of_curve: [
                (radius, parameters.effective_radius()),
                (column("operating_point.rotating_speed"), parameters.operating_point.rotating_speed),
                (column("friction.band"), parameters.friction.band),
            ],
        }
    }

    /// Whether the motion of a sample, which is not outside the model for other reasons, meets a speed without friction.
    fn meets_no_friction(&self, samples: &Columns<'_>, sample: usize) -> bool {
        let Prepared::TimeDomain(criterion) = &self.prepared else { return false };
        if !self.brake.friction_law().is_table() {
            return false;
        }
        let values: Vec<f64> = samples.sample(sample).collect();
        queued(0, criterion, self, &values).is_ok_and(|queued| queued.meets_no_friction())
    }

    /// Whether a sample is outside the model.
    fn is_outside<'s>(&'s self, samples: &'s Columns<'_>) -> impl Fn(usize) -> bool + 's {
        let least = self.least_static(samples);
        move |sample| {
            Self::inputs(samples, sample).are_outside_physics(least.of(sample))
                || self.meets_no_friction(samples, sample)
        }
    }
}

/// See [`FrictionLaw::least_static_coefficient`](crate::friction::law::FrictionLaw::least_static_coefficient), of samples.
struct LeastStatic<'s> {
    /// With the expected values.
    shared: f64,
    curve: Option<SharedCurve>,
    /// What decides it for other laws, if it varies.
    kinetic: Option<&'s [f64]>,
    /// What decides it for a measured curve, its column if it varies, and its expected value: the effective radius of the
    /// pad, the rotating speed and the shift.
    of_curve: [(Option<&'s [f64]>, f64); 3],
}

impl LeastStatic<'_> {
    /// Whether it is not the same for all samples.
    fn varies(&self) -> bool {
        match self.curve {
            Some(_) => self.of_curve.iter().any(|(column, _)| column.is_some()),
            None => self.kinetic.is_some(),
        }
    }

    fn of(&self, sample: usize) -> f64 {
        match self.curve {
            Some(curve) if self.varies() => {
                let [radius, speed, shift] = self.curve_at(sample);
                curve.least_at_rest(radius * speed, shift)
            }
            Some(_) => self.shared,
            None => self.kinetic.map_or(self.shared, |column| column[sample]),
        }
    }

    /// The static friction coefficient at the edge of the model: there a measured curve is 0, which is outside, and friction
    /// of another law does not fall, which is not.
    fn edge(&self, sample: usize) -> f64 {
        match self.curve {
            Some(curve) => {
                let [radius, speed, shift] = self.curve_at(sample);
                curve.vanishes_at_rest(radius * speed, shift)
            }
            None => self.of(sample),
        }
    }

    /// Effective radius, rotating speed and shift of a sample.
    fn curve_at(&self, sample: usize) -> [f64; 3] {
        self.of_curve.map(|(column, expected)| column.map_or(expected, |column| column[sample]))
    }
}

impl PadConfiguration {
    /// What is recorded of a sample within the model that is decided by linear stability, with these values of what varies.
    fn recorded(&self, values: &[f64]) -> RecordedValues {
        let inputs = RandomInputs { preload: values[0], static_friction: values[1] };
        let brake = match self.own_brake(values) {
            None => Some(self.brake.clone()),
            Some(own) => own,
        };
        let with_inputs = |brake: PadOnDisc| {
            let mut parameters = brake.parameters().clone();
            parameters.operating_point.preload = inputs.preload;
            parameters.friction.static_coefficient = inputs.static_friction;
            PadOnDisc::of_admissible(parameters).ok()
        };
        let Some(brake) = brake.and_then(with_inputs) else { return NOTHING };
        let flexible = match &self.prepared {
            Prepared::CoupledEigenvalue(shared) => shared.with_brake(brake.clone()).ok(),
            _ => None,
        };
        let mut recorded = NOTHING;
        let sample = Sample::new(&brake, flexible.as_ref(), inputs, self.record);
        for (value, result) in recorded.iter_mut().zip(self.record.results()) {
            *value = result.value(&sample);
        }
        recorded
    }

    fn decide_all(&self, samples: &Columns<'_>, wanted: &[usize], is_stopped: IsStopped<'_>) -> Option<Vec<Decision>> {
        match &self.prepared {
            Prepared::Outline => Some(vec![Verdict::Failed.into(); wanted.len()]),
            Prepared::Eigenvalue(boundary, None) => {
                let verdict = |&sample: &usize| boundary.verdict(samples.column(0)[sample], samples.column(1)[sample]);
                Some(wanted.iter().map(verdict).map(Decision::from).collect())
            }
            Prepared::Eigenvalue(_, Some(form)) => {
                let mut verdicts = Vec::with_capacity(samples.len());
                form.decide(samples.column(0), samples.column(1), &self.scalars(samples), &mut verdicts);
                Some(wanted.iter().map(|&sample| verdicts[sample].into()).collect())
            }
            Prepared::CoupledEigenvalue(brake) if self.own.is_some() => {
                let own = |&sample: &usize| {
                    let values: Vec<f64> = samples.sample(sample).collect();
                    let brake = self.own_brake(&values).flatten()?;
                    Some(OwnBrake { brake, inputs: Self::inputs(samples, sample) })
                };
                let own: Vec<Option<OwnBrake>> = wanted.iter().map(own).collect();
                let brakes: Vec<OwnBrake> = own.iter().flatten().cloned().collect();
                let mut decided = brake.decide_own(&brakes, is_stopped)?.into_iter();
                let decision = |own: &Option<OwnBrake>| own.as_ref().and_then(|_| decided.next());
                Some(own.iter().map(decision).map(|decision| decision.unwrap_or(Verdict::Failed.into())).collect())
            }
            Prepared::CoupledEigenvalue(brake) => {
                let stability =
                    |brake: &FlexibleBrake, inputs: RandomInputs| brake.linear_stability_until(inputs, is_stopped);
                let decide = |&sample: &usize| brake.decide_with(Self::inputs(samples, sample), stability);
                wanted.iter().map(|sample| (!is_stopped()).then(|| decide(sample))).collect()
            }
            Prepared::TimeDomain(criterion) => {
                let queued = wanted.iter().enumerate().map(|(ticket, &sample)| {
                    queued(ticket as u64, criterion, self, &samples.sample(sample).collect::<Vec<f64>>())
                });
                let mut list = List::new(queued, is_stopped);
                decide_queue(&mut list);
                list.decisions()
            }
        }
    }
}

impl Configuration for PadConfiguration {
    fn decide(&self, samples: &Columns<'_>, wanted: &[usize], is_stopped: IsStopped<'_>) -> Option<Vec<Decision>> {
        let mut decisions = self.decide_all(samples, wanted, is_stopped)?;
        if !self.record.is_empty() {
            let outside = self.outside(samples)?;
            for (decision, &sample) in decisions.iter_mut().zip(wanted).filter(|(_, sample)| !outside[**sample]) {
                if is_stopped() {
                    return None;
                }
                decision.recorded = self.recorded(&samples.sample(sample).collect::<Vec<f64>>());
            }
        }
        Some(decisions)
    }

    fn outside(&self, samples: &Columns<'_>) -> Option<Vec<bool>> {
        Some((0..samples.len()).map(self.is_outside(samples)).collect())
    }

    fn count_outside(&self, samples: &Columns<'_>) -> u64 {
        let least = self.least_static(samples);
        if least.curve.is_some() && (least.varies() || matches!(self.prepared, Prepared::TimeDomain(_))) {
            return (0..samples.len()).map(self.is_outside(samples)).map(u64::from).sum();
        }
        let pairs = samples.column(0).iter().zip(samples.column(1));
        let pairs = pairs.map(|(&preload, &static_friction)| RandomInputs { preload, static_friction });
        match least.kinetic {
            // One number for all samples: the usual case, and the faster one.
            None => pairs.map(|inputs| u64::from(inputs.are_outside_physics(least.shared))).sum(),
            Some(kinetic) => {
                pairs.zip(kinetic).map(|(inputs, &least)| u64::from(inputs.are_outside_physics(least))).sum()
            }
        }
    }

    fn clamped(&self, samples: &Columns<'_>) -> Option<[Vec<f64>; 2]> {
        let least = self.least_static(samples);
        let preloads = samples.column(0).iter().map(|preload| preload.max(0.0)).collect();
        // Nothing moves a curve that no admissible static friction gives friction.
        let clamped = |(sample, friction): (usize, &f64)| {
            let edge = least.edge(sample);
            if edge <= HIGHEST_FRICTION { friction.max(edge) } else { *friction }
        };
        let frictions = samples.column(1).iter().enumerate().map(clamped).collect();
        Some([preloads, frictions])
    }

    fn map_origin(&self) -> Option<f64> {
        Some(self.brake.parameters().friction.kinetic_coefficient)
    }

    fn closed_form(&self) -> Option<&dyn ClosedForm> {
        matches!(self.prepared, Prepared::Eigenvalue(..)).then_some(self)
    }
}

impl ClosedForm for PadConfiguration {
    fn boundary(&self) -> PairBoundary {
        match &self.prepared {
            Prepared::Eigenvalue(boundary, _) => *boundary,
            _ => self.brake.stability_boundary(),
        }
    }

    fn boundary_of(&self, values: &[f64]) -> Option<PairBoundary> {
        match self.own_brake(values) {
            None => Some(self.boundary()),
            Some(own) => own.map(|brake| brake.stability_boundary()),
        }
    }

    fn count(&self, samples: &Columns<'_>) -> VerdictCounts {
        match &self.prepared {
            Prepared::Eigenvalue(_, Some(form)) => {
                form.count(samples.column(0), samples.column(1), &self.scalars(samples))
            }
            _ => self.boundary().count(samples.column(0), samples.column(1)),
        }
    }
}

/// A sample with these values of what varies, or its decision if it needs none: it fails if a value is not admissible,
/// such as a stiffness below zero. The criterion may be of another brake than the configuration.
pub(super) fn queued<'q>(
    ticket: u64,
    criterion: &'q TimeDomain,
    configuration: &PadConfiguration,
    values: &[f64],
) -> Result<QueuedSample<'q>, Decision> {
    let inputs = RandomInputs { preload: values[0], static_friction: values[1] };
    let mut queued = QueuedSample::new(ticket, criterion, inputs);
    let is_outline = matches!(configuration.prepared, Prepared::Outline);
    match configuration.own_brake(values) {
        Some(own) => queued.brake = Some(own.ok_or(Decision::FAILED)?),
        None if is_outline => queued.brake = Some(configuration.brake.clone()),
        None => {}
    }
    if is_outline || configuration.varying.has_own_starts() {
        queued.start = configuration.varying.start(values).unwrap_or(queued.start);
    }
    Ok(queued)
}
