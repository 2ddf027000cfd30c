//! The probability of a cell as a function of its imprecise inputs.

use stickslip_core::parameters::ParameterError;
use stickslip_core::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_core::rigid_disc::stability::StabilityBoundary;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::imprecise::bounds::{Family, Quantity, Role};
use stickslip_sampler::inputs::{InputDistribution, PairLaw};
use stickslip_sampler::integrate::closed_form::{self, ExactProbability};
use stickslip_sampler::integrate::pair::Pair;

use crate::evaluate::control::IsStopped;
use crate::job::{ImpreciseQuantity, Job, RandomInput, Values, What};

/// The keys of the expected values that a cell has.
const PRELOAD: &str = "operating_point.preload";
const STATIC_FRICTION: &str = "friction.static_coefficient";
const ROTATING_SPEED: &str = "operating_point.rotating_speed";

/// Why there is no probability.
#[derive(Debug)]
pub enum Ended {
    /// The search was stopped.
    Stopped,
    /// There is no such brake.
    NoSuchBrake(ParameterError),
}

/// A cell of a job with some quantities known as intervals.
pub struct ImpreciseCell<'a> {
    job: &'a Job,
    cell: Cell,
    /// The quantities that are intervals, with their places among all that are imprecise.
    intervals: Vec<(usize, &'a ImpreciseQuantity, [f64; 2])>,
    /// The boundary, unless it depends on a quantity.
    boundary: Option<StabilityBoundary>,
    is_stopped: IsStopped<'a>,
}

/// A cell with values in place of its intervals.
struct Precise {
    boundary: StabilityBoundary,
    cell: Cell,
    /// The correlation of preload and static friction.
    correlation: f64,
}

impl<'a> ImpreciseCell<'a> {
    /// A cell of a job that has the lower ends of all intervals.
    ///
    /// # Errors
    /// If there is no such brake.
    pub fn new(
        job: &'a Job,
        cell: u64,
        quantities: &'a [ImpreciseQuantity],
        is_stopped: IsStopped<'a>,
    ) -> Result<Self, Ended> {
        let cell = job.grid.cell(cell);
        let interval = |(place, quantity): (usize, &'a ImpreciseQuantity)| match quantity.values {
            Values::Between(ends) => Some((place, quantity, ends)),
            Values::OneOf(_) => None,
        };
        let intervals: Vec<_> = quantities.iter().enumerate().filter_map(interval).collect();
        let mut imprecise = Self { job, cell, intervals, boundary: None, is_stopped };
        if !imprecise.has_imprecise_brake() {
            let lower: Vec<f64> = imprecise.intervals.iter().map(|(_, _, ends)| ends[0]).collect();
            imprecise.boundary = Some(imprecise.boundary(&lower)?);
        }
        Ok(imprecise)
    }

    /// The places of the intervals among all imprecise quantities.
    pub fn places(&self) -> Vec<usize> {
        self.intervals.iter().map(|(place, ..)| *place).collect()
    }

    /// What is known of the quantities that are intervals.
    pub fn quantities(&self) -> Vec<Quantity> {
        let role = |what: &What| match what {
            What::Expected(scalar) if scalar.key == PRELOAD => Role::Rising,
            What::Expected(scalar) if scalar.key == STATIC_FRICTION && self.is_unstable_above() => Role::Rising,
            What::RelativeStd(input) if input == RandomInput::Preload.name() => Role::StdOfPreload,
            What::RelativeStd(input) if input == RandomInput::StaticFriction.name() => Role::StdOfFriction,
            _ => Role::Unknown,
        };
        let quantity = |(_, quantity, interval): &(usize, &ImpreciseQuantity, [f64; 2])| Quantity {
            role: role(&quantity.what),
            interval: *interval,
        };
        self.intervals.iter().map(quantity).collect()
    }

    /// Whether more static friction is never stable where less is unstable, whatever the other quantities: only a
    /// measured friction curve may be otherwise.
    fn is_unstable_above(&self) -> bool {
        let is_single = self.boundary.as_ref().is_some_and(StabilityBoundary::is_unstable_above);
        is_single || self.job.parameters.friction.law.table().is_none()
    }

    /// Whether a parameter is imprecise on which the boundary depends.
    fn has_imprecise_brake(&self) -> bool {
        let is_of_brake = |what: &What| match what {
            What::Expected(scalar) => ![PRELOAD, STATIC_FRICTION].contains(&scalar.key),
            What::RelativeStd(_) | What::Distribution(_) | What::Correlation => false,
        };
        self.intervals.iter().any(|(_, quantity, _)| is_of_brake(&quantity.what))
    }

    fn boundary(&self, at: &[f64]) -> Result<StabilityBoundary, Ended> {
        if let Some(boundary) = self.boundary {
            return Ok(boundary);
        }
        let boundary = || {
            let mut parameters = self.job.brakes().in_cell(&self.cell)?;
            for ((_, quantity, _), value) in self.intervals.iter().zip(at) {
                if let What::Expected(scalar) = &quantity.what
                    && ![PRELOAD, STATIC_FRICTION].contains(&scalar.key)
                {
                    parameters.set(scalar.key, *value)?;
                }
            }
            Ok(PadOnDisc::new(parameters)?.stability_boundary())
        };
        boundary().map_err(Ended::NoSuchBrake)
    }

    /// The cell with these values of its quantities.
    fn at(&self, at: &[f64]) -> Result<Precise, Ended> {
        if (self.is_stopped)() {
            return Err(Ended::Stopped);
        }
        let mut cell = self.cell;
        let mut correlation = self.job.random.pairs.first().map_or(0.0, |&(_, _, coefficient)| coefficient);
        for ((_, quantity, _), &value) in self.intervals.iter().zip(at) {
            match &quantity.what {
                What::Expected(scalar) if scalar.key == PRELOAD => cell.preload = value,
                What::Expected(scalar) if scalar.key == STATIC_FRICTION => cell.static_friction = value,
                What::Expected(scalar) if scalar.key == ROTATING_SPEED => cell.rotating_speed = value,
                What::RelativeStd(input) if input == RandomInput::Preload.name() => cell.relative_std.preload = value,
                What::RelativeStd(_) => cell.relative_std.static_friction = value,
                What::Correlation => correlation = value,
                What::Expected(_) | What::Distribution(_) => {}
            }
        }
        Ok(Precise { boundary: self.boundary(at)?, cell, correlation })
    }

    /// Whether the inputs are normal and independent whatever the values.
    fn is_plain(&self) -> bool {
        let is_correlated = |what: &What| matches!(what, What::Correlation);
        self.job.random.is_plain() && !self.intervals.iter().any(|(_, quantity, _)| is_correlated(&quantity.what))
    }

    fn pair(&self, cell: &Cell) -> Pair {
        let random = &self.job.random;
        let of = |position: Option<usize>, expected: f64, std: f64| {
            let marginal = |position: usize| InputDistribution::relative(&random.marginals[position], expected, std);
            position.map_or(InputDistribution::fixed(expected), marginal)
        };
        let [preload, static_friction] = random.pair();
        let std = cell.relative_std;
        Pair::new(
            of(preload, cell.preload, std.preload),
            of(static_friction, cell.static_friction, std.static_friction),
        )
    }
}

impl Family for ImpreciseCell<'_> {
    type Error = Ended;

    fn probability(&self, at: &[f64]) -> Result<ExactProbability, Ended> {
        let Precise { boundary, cell, correlation } = self.at(at)?;
        if self.is_plain() {
            return Ok(closed_form::probability(&boundary, &cell));
        }
        Ok(self.pair(&cell).exact_probability(&boundary, &PairLaw::correlated(correlation)))
    }

    fn normal_cell(&self, at: &[f64]) -> Result<Option<(StabilityBoundary, Cell)>, Ended> {
        let Precise { boundary, cell, .. } = self.at(at)?;
        Ok(self.is_plain().then_some((boundary, cell)))
    }
}
