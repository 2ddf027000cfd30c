//! The validated job, with what follows from its values.

use std::sync::Arc;

use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::model::quantity::{Quantity, Role};
use stickslip_core::model::{Configuration, Model, ModelError};
use stickslip_core::models::pad_on_disc::model::PadModel;
use stickslip_sampler::draw::deviates::{DeviateStream, Points};
use stickslip_sampler::draw::identity::BLOCK_SAMPLES;
use stickslip_sampler::estimate::interval::{self, BinomialInterval};
use stickslip_sampler::grid::{Cell, Grid};
use stickslip_sampler::inputs::InputDistribution;
use stickslip_sampler::integrate::NormalPair;
use stickslip_sampler::integrate::pair::Pair;

use super::limit_request::LimitRequest;
use super::method::{Answer, MapUse, Sampling};
use super::model::{JobModel, OutsidePhysics};
use super::random::RandomInputSet;
use super::reduction::Reduction;
use super::sampling_numbers::Effort;
use super::sampling_spec::Audit;
use crate::failure::Failure;

/// Largest number of verdict maps.
pub const MOST_MAPS: usize = 1000;

/// A job that can be run: everything resolved, nothing left to check.
#[derive(Debug, Clone)]
pub struct Job {
    /// Name of the run.
    pub name: String,
    /// What it is for.
    pub description: String,
    /// The model, with the criterion that decides.
    pub model: Arc<dyn JobModel>,
    /// The cells.
    pub grid: Grid,
    /// The random inputs.
    pub random: RandomInputSet,
    /// What happens to samples outside the model.
    pub outside_physics: OutsidePhysics,
    /// How probabilities are found.
    pub sampling: Sampling,
    /// Which limits are written beside the surface.
    pub limit: Option<LimitRequest>,
    /// Which probability the summary answers first.
    pub target: Option<f64>,
    /// The cell of the operating point that it answers first.
    pub operating_point: Option<u64>,
}

impl Job {
    /// The model.
    pub fn model(&self) -> &dyn Model {
        self.model.model()
    }

    /// A quantity of the model, by its place.
    pub fn quantity(&self, place: usize) -> &Quantity {
        &self.model().quantities()[place]
    }

    /// The quantity of a random input, by its position.
    pub fn quantity_of(&self, input: usize) -> &Quantity {
        self.quantity(self.random.inputs[input])
    }

    /// The names of the axes of quantities of a role, slowest first.
    pub fn axes_of(&self, role: Role) -> impl Iterator<Item = &str> {
        let quantities = self.grid.axes.iter().map(|axis| self.quantity(axis.quantity));
        quantities.filter(move |quantity| quantity.role == role).map(|quantity| &*quantity.name)
    }

    /// The pad on the disc, for commands that are about it alone.
    ///
    /// # Errors
    /// For any other kind of model.
    pub fn pad(&self) -> Result<&PadModel, Failure> {
        self.model.as_pad().ok_or_else(|| {
            Failure::Usage(format!(
                "the job \"{}\" has another model than the pad on the disc, which is all that this command knows; submit the job, and look at its surface with `stickslip plot` and `stickslip report`",
                self.name
            ))
        })
    }

    /// Whether the boundary of stability is known in closed form.
    pub fn has_closed_form(&self) -> bool {
        self.model().has_closed_form()
    }

    /// The quantities that differ from sample to sample: those of [`Role::Input`], then other random inputs and axes of
    /// the start.
    pub fn varying(&self) -> Vec<usize> {
        let role = |place: usize| self.quantity(place).role;
        let quantities = 0..self.model().quantities().len();
        let mut varying: Vec<usize> = quantities.clone().filter(|&place| role(place) == Role::Input).collect();
        let is_axis = |place: usize| self.grid.axis_of(place).is_some();
        varying.extend(quantities.filter(|&place| match role(place) {
            Role::Input => false,
            Role::Configuration => self.random.position(place).is_some(),
            Role::Start => self.random.position(place).is_some() || is_axis(place),
        }));
        varying
    }

    /// The configuration with the expected values of a cell, of which nothing varies but quantities of [`Role::Input`].
    ///
    /// # Errors
    /// If there is none.
    pub fn configuration_in(&self, cell: &Cell) -> Result<Box<dyn Configuration>, ModelError> {
        self.configuration_with(&cell.expected)
    }

    /// The same with any expected values.
    ///
    /// # Errors
    /// If there is none.
    pub fn configuration_with(&self, expected: &[f64]) -> Result<Box<dyn Configuration>, ModelError> {
        let quantities = self.model().quantities().iter().enumerate();
        let inputs: Vec<usize> =
            quantities.filter(|(_, quantity)| quantity.role == Role::Input).map(|(place, _)| place).collect();
        self.model().configure(expected, &inputs, None)
    }

    /// The boundary of stability with these expected values, if it is known in closed form.
    ///
    /// # Errors
    /// If there is no such configuration.
    pub fn boundary_with(&self, expected: &[f64]) -> Result<PairBoundary, ModelError> {
        let configuration = self.configuration_with(expected)?;
        let closed = configuration.closed_form().map(stickslip_core::model::ClosedForm::boundary);
        closed.ok_or_else(|| ModelError("the model has no boundary in closed form".to_owned()))
    }

    /// The number of cells.
    pub fn cells(&self) -> u64 {
        self.grid.lengths().iter().product()
    }

    /// Parts of each cell that are counted apart: randomisations, or the samples between two looks; 1 without either.
    pub fn parts(&self) -> u64 {
        self.sampling.parts().len() as u64
    }

    /// Largest number of samples over all cells.
    pub fn total_samples(&self) -> u128 {
        u128::from(self.cells()) * u128::from(self.sampling.samples)
    }

    /// Audited samples: looked up, and simulated as a check. About so many over all cells.
    pub fn audited_samples(&self) -> u128 {
        match self.sampling.audit {
            Audit::Samples(samples) if self.map_use() == MapUse::Integrate => {
                u128::from(self.cells()) * u128::from(samples)
            }
            Audit::Samples(samples) => u128::from(self.cells()) * u128::from(samples.min(self.sampling.samples)),
            Audit::Share(share) => (share * self.total_samples() as f64) as u128,
        }
    }

    /// Plain samples of each cell beside its probability, where that does not come from such.
    pub fn plain_samples(&self) -> u64 {
        match self.sampling.audit {
            Audit::Samples(samples) if self.sampling.has_plain_samples() => samples,
            Audit::Samples(_) | Audit::Share(_) => 0,
        }
    }

    /// How many of them there are however long a sample takes, which is not known of a model without its files.
    pub fn certain_plain_samples(&self) -> u64 {
        let Sampling { method, samples, particles, .. } = self.sampling;
        if self.sampling.audit != self.sampling.usual_audit {
            return self.plain_samples();
        }
        self.plain_samples().min(method.usual_plain_samples(samples, particles, true))
    }

    /// Samples at a limit and at each end of its axis, decided the surest way there is: plain ones, or over a verdict map
    /// those that check its integral.
    pub fn samples_beside_limits(&self) -> u64 {
        match self.sampling.audit {
            Audit::Samples(samples) if self.has_audits() => samples,
            Audit::Samples(_) | Audit::Share(_) => 0,
        }
    }

    /// Whether probabilities are checked by samples that are kept apart.
    pub fn has_audits(&self) -> bool {
        self.answer() == Answer::Integral || self.plain_samples() > 0
    }

    /// What the deviates are drawn from.
    pub fn points(&self) -> Points {
        self.sampling.method.points()
    }

    /// The stream of deviates of so many inputs.
    pub fn deviates(&self, dimensions: usize, points: Points) -> DeviateStream {
        let Sampling { seed, common_random_numbers, .. } = self.sampling;
        DeviateStream { seed, common_random_numbers, dimensions, points }
    }

    /// The number by which a cell draws its deviates: its index without the axis of what of a sample counts.
    pub fn stream_of(&self, cell: u64) -> u64 {
        self.selecting().map_or(cell, |quantity| self.grid.index_without(quantity, cell))
    }

    /// How many cells draw by the same number.
    pub fn cells_of_a_stream(&self) -> u64 {
        self.selecting().and_then(|quantity| self.grid.axis_of(quantity)).map_or(1, |axis| axis.values().len() as u64)
    }

    /// The quantity that selects what of a sample counts.
    fn selecting(&self) -> Option<usize> {
        self.model().quantities().iter().position(|quantity| quantity.only_selects)
    }

    /// Whether drawing and deciding a sample costs little more than its random numbers: only the pair
    /// of the model scatters, normal and independent.
    pub fn has_cheap_samples(&self) -> bool {
        self.answer() == Answer::Verdict
            && self.points() == Points::Random
            && self.random.other().is_none()
            && self.random.is_plain()
    }

    /// What the method returns for a sample.
    pub fn answer(&self) -> Answer {
        self.sampling.method.answer()
    }

    /// Whether samples are drawn; else probabilities are integrated.
    pub fn draws_samples(&self) -> bool {
        self.sampling.samples > 0
    }

    /// The one quantity that integrals go over, if critical values of it can be found.
    pub fn integrated(&self) -> Option<usize> {
        self.model().integrated(&self.random.inputs)
    }

    /// Whether the pair, or the one input with critical values, is integrated over at each sample of the other inputs: with
    /// `method = "conditional"`, and for samples with weights wherever the closed form makes this possible. Populations go by
    /// verdicts alone, which checks the integrals.
    pub fn integrates_at_samples(&self) -> bool {
        self.answer() == Answer::Probability
            || (self.answer() == Answer::Weight
                && self.has_closed_form()
                && self.outside_physics == OutsidePhysics::Stable
                && self.random.pair() != [None, None]
                && !self.random.others(None).is_empty()
                && self.random.correlation_with_last(None).is_ok())
    }

    /// Whether cells get as many samples as a precision takes.
    pub fn stops_by_precision(&self) -> bool {
        matches!(self.sampling.effort, Effort::Until(_))
    }

    /// What verdict maps are used for. The closed form needs none.
    pub fn map_use(&self) -> MapUse {
        if self.has_closed_form() || self.integrated().is_some() {
            return MapUse::Nothing;
        }
        self.sampling.method.map_use_with(self.sampling.evaluate)
    }

    /// Whether there are verdict maps.
    pub fn uses_maps(&self) -> bool {
        self.map_use() != MapUse::Nothing
    }

    /// The interval of counted verdicts at a confidence.
    pub fn interval(&self, confidence: f64) -> BinomialInterval {
        BinomialInterval::new(self.sampling.interval_kind(confidence), confidence)
    }

    /// The confidence of the interval of the counted verdicts of one cell. Where a part of them is known from the audit
    /// of a verdict map only, the error is shared with it.
    pub fn confidence(&self, is_audited: bool) -> f64 {
        let of_a_cell = self.confidence_of_a_cell();
        if is_audited { interval::half_of_the_error(of_a_cell) } else { of_a_cell }
    }

    /// The confidence of what the audit of a verdict map says of one cell.
    pub fn audit_confidence(&self) -> f64 {
        let of_a_cell = self.confidence_of_a_cell();
        if self.draws_samples() { interval::half_of_the_error(of_a_cell) } else { of_a_cell }
    }

    /// The confidence of `p_low` to `p_high` of one cell.
    fn confidence_of_a_cell(&self) -> f64 {
        let Sampling { confidence, simultaneous, .. } = self.sampling;
        if simultaneous { interval::simultaneous_confidence(confidence, self.cells()) } else { confidence }
    }

    /// The expected value of a random input in a cell.
    pub fn expected(&self, input: usize, cell: &Cell) -> f64 {
        cell.expected[self.random.inputs[input]]
    }

    /// The standard deviation of a random input in a cell, relative but for inputs that scatter by `random.std`.
    pub fn std(&self, input: usize, cell: &Cell) -> f64 {
        self.random.relative_stds[cell.scatter][input]
    }

    /// Whether the quantity at a place is a random input whose standard deviation is not relative to its expected value.
    pub fn is_absolute(&self, place: usize) -> bool {
        self.random.position(place).is_some_and(|position| self.random.is_absolute(position))
    }

    /// The distribution of the random input at `position` in a cell.
    pub fn distribution(&self, position: usize, cell: &Cell) -> InputDistribution {
        let is_absolute = self.random.is_absolute(position);
        let of = if is_absolute { InputDistribution::absolute } else { InputDistribution::relative };
        of(&self.random.marginals[position], self.expected(position, cell), self.std(position, cell))
    }

    /// The pair of the model in a cell, as if it were normal and independent; of a model without, two constants.
    pub fn normal_pair(&self, cell: &Cell) -> NormalPair {
        let of = |place: usize| {
            let expected = cell.expected[place];
            let relative = |input: usize| self.random.relative(input, self.std(input, cell), expected);
            (expected, self.random.position(place).map_or(0.0, relative))
        };
        let [first, second] = self.model().pair().map_or([(0.0, 0.0); 2], |pair| pair.map(of));
        NormalPair { expected: [first.0, second.0], relative_std: [first.1, second.1] }
    }

    /// The pair of the model in a cell, for integrals over both.
    pub fn pair(&self, cell: &Cell) -> Pair {
        let NormalPair { expected, .. } = self.normal_pair(cell);
        let of = |which: usize| match self.random.pair()[which] {
            Some(position) => self.distribution(position, cell),
            None => InputDistribution::fixed(expected[which]),
        };
        Pair::new(of(0), of(1))
    }

    /// Samples of a unit of work: some milliseconds to a second, long against the cost of handing it out, short against
    /// anyone's patience after Ctrl-C. Part of how shards share a job.
    pub fn unit_samples(&self) -> u64 {
        match self.has_closed_form() {
            true if self.has_cheap_samples() => 1000 * BLOCK_SAMPLES,
            true => 20 * BLOCK_SAMPLES,
            // Most of them are looked up, but each lane may keep a unit waiting for one that is simulated.
            false if self.uses_maps() => 10 * BLOCK_SAMPLES,
            false if self.model().has_slow_samples() => BLOCK_SAMPLES / 25,
            false => BLOCK_SAMPLES,
        }
    }

    /// What a user should know before the job runs, in sentences.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.model.warnings(&self.grid, &self.random);
        warnings.extend(self.random.warnings(self.model().quantities(), &self.grid));
        warnings
    }

    /// What the reduction of the model costs, where it was reduced.
    pub fn reduction(&self) -> Option<&Reduction> {
        self.model.reduction()
    }
}
