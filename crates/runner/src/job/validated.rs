//! The validated job, with what follows from its values.

use stickslip_core::criterion::validity;
use stickslip_core::criterion::validity::Uncovered;
use stickslip_core::parameters::{ParameterError, Parameters, scalar};
use stickslip_core::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_sampler::draw::deviates::{DeviateStream, Points};
use stickslip_sampler::draw::identity::BLOCK_SAMPLES;
use stickslip_sampler::estimate::interval;
use stickslip_sampler::estimate::interval::{BinomialInterval, IntervalKind};
use stickslip_sampler::grid::{Cell, Grid};
use stickslip_sampler::inputs::InputDistribution;
use stickslip_sampler::integrate::pair::Pair;

use super::axes::Brakes;
use super::criterion::Criterion;
use super::criterion_spec::OutsidePhysics;
use super::engine::EngineSettings;
use super::limit_request::LimitRequest;
use super::plausibility;
use super::random::RandomInputSet;
use super::random_input::RandomInput;
use super::sampling::{Effort, Sampling};
use super::sampling_spec::{Audit, EvaluateMode, SamplingMethod};
use super::start_value::StartValue;

/// Largest number of verdict maps.
pub const MOST_MAPS: usize = 1000;

/// A job that can be run: everything resolved, nothing left to check.
#[derive(Debug, Clone)]
pub struct Job {
    /// Name of the run.
    pub name: String,
    /// What it is for.
    pub description: String,
    /// The brake; operating point and static friction are those of each cell.
    pub parameters: Parameters,
    /// The cells.
    pub grid: Grid,
    /// The random inputs.
    pub random: RandomInputSet,
    /// What decides.
    pub criterion: Criterion,
    /// What becomes of samples outside physics.
    pub outside_physics: OutsidePhysics,
    /// How probabilities are found.
    pub sampling: Sampling,
    /// Whether the spec itself says how many disc modes are kept.
    pub modes_are_given: bool,
    /// Which limits are written beside the surface.
    pub limit: Option<LimitRequest>,
    /// What a cluster is asked for.
    pub engine: EngineSettings,
}

impl Job {
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

    /// Verdicts that counting its samples takes, at most, if each is simulated: of a sample with Sobol indices also
    /// those of the second sample and of the mixed ones.
    pub fn verdicts_of_samples(&self) -> u128 {
        let of_a_sample = if self.sampling.sensitivity { 2 + self.random.inputs.len() } else { 1 };
        self.total_samples() * of_a_sample as u128
    }

    /// Audited samples: looked up, and simulated as a check. About so many over all cells.
    pub fn audited_samples(&self) -> u128 {
        match self.sampling.audit {
            Audit::Samples(samples) if self.is_integrated() => u128::from(self.cells()) * u128::from(samples),
            Audit::Samples(samples) => u128::from(self.cells()) * u128::from(samples.min(self.sampling.samples)),
            Audit::Share(share) => (share * self.total_samples() as f64) as u128,
        }
    }

    /// What the deviates are drawn from.
    pub fn points(&self) -> Points {
        match self.sampling.method {
            SamplingMethod::Sobol | SamplingMethod::Conditional | SamplingMethod::Importance => Points::Sobol,
            SamplingMethod::MonteCarlo | SamplingMethod::Subset | SamplingMethod::Exact => Points::Random,
        }
    }

    /// The stream of deviates of so many inputs.
    pub fn deviates(&self, dimensions: usize, points: Points) -> DeviateStream {
        let Sampling { seed, common_random_numbers, .. } = self.sampling;
        DeviateStream { seed, common_random_numbers, dimensions, points }
    }

    /// Whether drawing and deciding a sample costs little more than its random numbers: only preload and static
    /// friction scatter, normal and independent.
    pub fn has_cheap_samples(&self) -> bool {
        self.sampling.method == SamplingMethod::MonteCarlo && self.random.other().is_none() && self.random.is_plain()
    }

    /// Whether probabilities are integrated, without samples.
    pub fn is_integrated(&self) -> bool {
        self.sampling.method == SamplingMethod::Exact
    }

    /// Whether a sample stands for the inputs other than preload and static friction, over which it is integrated.
    pub fn is_conditional(&self) -> bool {
        self.sampling.method == SamplingMethod::Conditional
    }

    /// Whether samples are drawn where instability is frequent, and have weights.
    pub fn is_weighted(&self) -> bool {
        matches!(self.sampling.method, SamplingMethod::Importance | SamplingMethod::Subset)
    }

    /// Whether preload and static friction are integrated over at each sample of the other inputs: with
    /// `method = "conditional"`, and for rare events wherever this is possible.
    pub fn integrates_pair(&self) -> bool {
        self.is_conditional()
            || (self.is_weighted()
                && matches!(self.criterion, Criterion::Eigenvalue)
                && self.outside_physics == OutsidePhysics::Stable
                && self.random.pair() != [None, None]
                && !self.random.others().is_empty()
                && self.random.correlation_with_pair_last().is_ok())
    }

    /// Whether every sample has a verdict of its own, which can be looked at again.
    pub fn has_verdicts(&self) -> bool {
        !self.is_integrated() && !self.is_conditional() && !self.is_weighted()
    }

    /// Whether cells get as many samples as a precision takes.
    pub fn stops_by_precision(&self) -> bool {
        matches!(self.sampling.effort, Effort::Until(_))
    }

    /// Whether samples are looked up in verdict maps, or integrated over them. The closed form needs none.
    pub fn uses_maps(&self) -> bool {
        let wanted = self.sampling.evaluate == EvaluateMode::Boundary || self.sampling.method == SamplingMethod::Exact;
        wanted && !matches!(self.criterion, Criterion::Eigenvalue)
    }

    /// Whether verdict maps can hold the verdicts: motions from one start, and not too many brakes.
    pub fn fits_maps(&self) -> bool {
        self.grid.of_start.is_empty() && self.grid.brakes() <= MOST_MAPS
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
        if self.is_integrated() { of_a_cell } else { interval::half_of_the_error(of_a_cell) }
    }

    /// The confidence of `p_low` to `p_high` of one cell.
    fn confidence_of_a_cell(&self) -> f64 {
        let Sampling { confidence, simultaneous, .. } = self.sampling;
        if simultaneous { interval::simultaneous_confidence(confidence, self.cells()) } else { confidence }
    }

    /// Whether what is made of counted verdicts differs from what the first version made of them: all but one plain
    /// interval for each cell.
    pub fn has_later_estimates(&self) -> bool {
        let Sampling { derivatives, sensitivity, .. } = self.sampling;
        let is_plain = matches!(self.sampling.effort, Effort::Samples(_));
        let is_closed = self.is_integrated() && !self.uses_maps();
        let interval = self.sampling.interval_kind(self.confidence_of_a_cell());
        let is_given = self.sampling.interval.is_some();
        self.uses_maps()
            || (derivatives && !is_closed)
            || sensitivity
            || !(is_plain || is_closed)
            || (interval == IntervalKind::ClopperPearson && !is_given && !is_closed)
    }

    /// The parameters of the brakes of the grid.
    pub fn brakes(&self) -> Brakes<'_> {
        Brakes { parameters: &self.parameters, grid: &self.grid }
    }

    /// The value in a cell of a parameter, but for those that have an axis in every job, or of a number of the start;
    /// `None` if the start leaves it out.
    pub fn value_in(&self, key: &str, cell: &Cell) -> Option<f64> {
        if let Some(axis) = self.grid.further().position(|further| further.name == key) {
            return Some(self.grid.further_values(cell.index)[axis]);
        }
        match StartValue::from_key(key) {
            Some(number) => number.of(&self.criterion.given_start()?),
            None => scalar(key).map(|scalar| scalar.value(&self.parameters)),
        }
    }

    /// The expected value of a random input in a cell.
    pub fn expected(&self, input: RandomInput, cell: &Cell) -> f64 {
        match input {
            RandomInput::Preload => cell.preload,
            RandomInput::StaticFriction => cell.static_friction,
            RandomInput::Other(_) if input.is_rotating_speed() => cell.rotating_speed,
            // A random number of the start has an expected value: this is checked.
            other => self.value_in(other.name(), cell).unwrap_or(f64::NAN),
        }
    }

    /// The distribution of the random input at `position` in a cell.
    pub fn distribution(&self, position: usize, cell: &Cell) -> InputDistribution {
        let input = self.random.inputs[position];
        let std = self.random.relative_stds[self.grid.relative_std_index(cell.index)][position];
        let of = if input.scatters_absolutely() { InputDistribution::absolute } else { InputDistribution::relative };
        of(&self.random.marginals[position], self.expected(input, cell), std)
    }

    /// Preload and static friction in a cell, for integrals over both.
    pub fn pair(&self, cell: &Cell) -> Pair {
        let of = |position: Option<usize>, expected: f64| {
            position.map_or(InputDistribution::fixed(expected), |position| self.distribution(position, cell))
        };
        let [preload, static_friction] = self.random.pair();
        Pair::new(of(preload, cell.preload), of(static_friction, cell.static_friction))
    }

    /// The brake of a cell, by its index in the grid, with the expected values of everything that scatters.
    pub fn brake(&self, brake: usize) -> Result<PadOnDisc, ParameterError> {
        PadOnDisc::new(self.brakes().parameters_of(brake)?)
    }

    /// Samples of a unit of work: some milliseconds to a second, long against the cost of handing it out, short against
    /// anyone's patience after Ctrl-C. Part of how shards share a job.
    pub fn unit_samples(&self) -> u64 {
        match self.criterion {
            Criterion::Eigenvalue if self.has_cheap_samples() => 1000 * BLOCK_SAMPLES,
            Criterion::Eigenvalue => 20 * BLOCK_SAMPLES,
            // Most of them are looked up.
            _ if self.uses_maps() => 100 * BLOCK_SAMPLES,
            Criterion::CoupledEigenvalue { .. } | Criterion::TimeDomain { .. } => BLOCK_SAMPLES,
        }
    }

    /// What a user should know before the job runs, in sentences.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = plausibility::of_job(&self.parameters, &self.grid, &self.random);
        if let Criterion::TimeDomain { settings, .. } = &self.criterion {
            warnings.extend(plausibility::of_displacement("criterion.displacement", settings.displacement));
        }
        if self.modes_are_given
            && let Some(check) = self.criterion.too_few_modes(&self.parameters, &self.grid)
        {
            warnings.push(format!("{check}; use disc_modes = \"auto\""));
        }
        // The scatter of the inputs is not looked at.
        warnings.extend(self.uncovered().iter().map(|uncovered| format!(
            "{uncovered}, the limit up to which verdicts in time were tested (cargo doc, page stickslip_core::criterion::validity). They may be right beyond it; look at single samples with `stickslip trajectory`, and compare the run with one of a tenfold criterion.horizon (`stickslip compare`)"
        )));
        warnings.extend(self.random.without_scatter(&self.parameters, &self.grid));
        warnings
    }

    /// What of the extremes of the axes lies outside the range over which verdicts in time were tested, each value
    /// once.
    fn uncovered(&self) -> Vec<Uncovered> {
        let Criterion::TimeDomain { disc, .. } = &self.criterion else { return Vec::new() };
        let mut found: Vec<Uncovered> = Vec::new();
        let Ok(corners) = self.brakes().at_extremes(&self.grid.rotating_speed.extremes()) else { return found };
        for corner in corners {
            for static_friction in self.grid.static_friction.extremes() {
                let mut parameters = corner.clone();
                parameters.friction.static_coefficient = static_friction;
                let Ok(brake) = PadOnDisc::new(parameters) else { continue };
                for uncovered in validity::uncovered(&brake, disc) {
                    if !found.contains(&uncovered) {
                        found.push(uncovered);
                    }
                }
            }
        }
        found
    }

    /// Whether other degrees of freedom than the pad's tangential motion may become unstable.
    pub fn has_flexible_disc(&self) -> bool {
        self.criterion.has_flexible_disc()
    }

    /// Whether the settled amplitude is recorded.
    pub fn records_amplitude(&self) -> bool {
        self.criterion.records_amplitude()
    }
}
