//! What limits along an axis are found from: the probability at any value, and samples over all values at once.

use stickslip_core::parameters::{ParameterError, Parameters, Scalar, scalar};
use stickslip_core::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_core::rigid_disc::stability::StabilityBoundary;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::integrate::closed_form::ExactProbability;
use stickslip_sampler::limits::spans::{OutsidePhysics as Outside, Sample, Spans, Varied};
use stickslip_sampler::limits::sweep::Sweep;

use crate::evaluate::control::IsStopped;
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::integral::exact_probability;
use crate::job::{Job, OutsidePhysics};

/// Preload or static friction, if the parameter is one of these.
pub fn varied(scalar: &Scalar) -> Option<Varied> {
    match scalar.key {
        "operating_point.preload" => Some(Varied::Preload),
        "friction.static_coefficient" => Some(Varied::StaticFriction),
        _ => None,
    }
}

/// A cell in which one parameter may have any value.
pub struct OpenCell<'a> {
    job: &'a Job,
    cell: Cell,
    scalar: &'static Scalar,
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
    pub fn new(job: &'a Job, cell: u64, scalar: &'static Scalar) -> Result<Self, ParameterError> {
        let cell = job.grid.cell(cell);
        let parameters = job.brakes().in_cell(&cell)?;
        let is_shared = varied(scalar).is_some();
        let boundary = is_shared.then(|| PadOnDisc::new(parameters.clone())).transpose()?;
        Ok(Self { job, cell, scalar, parameters, boundary: boundary.map(|brake| brake.stability_boundary()) })
    }

    /// The exact probability at a value of the parameter.
    ///
    /// # Errors
    /// If no such brake exists.
    pub fn probability(&self, value: f64) -> Result<ExactProbability, ParameterError> {
        let mut cell = self.cell;
        match varied(self.scalar) {
            Some(Varied::Preload) => cell.preload = value,
            Some(Varied::StaticFriction) => cell.static_friction = value,
            None => {}
        }
        if let Some(boundary) = &self.boundary {
            return Ok(exact_probability(self.job, boundary, &cell));
        }
        let mut parameters = self.parameters.clone();
        parameters.set(self.scalar.key, value)?;
        Ok(exact_probability(self.job, &PadOnDisc::new(parameters)?.stability_boundary(), &cell))
    }
}

impl Evaluator<'_> {
    /// The samples of a cell for all expected values of preload or static friction in a range; `None` if it is stopped
    /// before. The job decides in closed form.
    ///
    /// Deviates and all other inputs are those of the samples of the cell.
    pub fn sweep(&self, cell: u64, varied: Varied, range: [f64; 2], is_stopped: IsStopped<'_>) -> Option<Sweep> {
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
        let mut sweep = Sweep::new(range);
        for place in 0..self.parts.of_a_cell() {
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
        }
        Some(sweep)
    }
}
