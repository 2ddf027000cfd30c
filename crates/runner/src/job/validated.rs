//! The validated job: every value resolved and within its limits.

use std::path::Path;

use stickslip_core::criterion::validity;
use stickslip_core::criterion::validity::Uncovered;
use stickslip_core::parameters;
use stickslip_core::parameters::SCALARS;
use stickslip_core::parameters::{ParameterError, Parameters};
use stickslip_core::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_core::rigid_disc::stability::StabilityBoundary;
use stickslip_sampler::draw::deviates::Points;
use stickslip_sampler::draw::identity::BLOCK_SAMPLES;
use stickslip_sampler::estimate::interval;
use stickslip_sampler::estimate::interval::{BinomialInterval, IntervalKind};
use stickslip_sampler::grid::{Axis, Grid};
use toml::Spanned;

use crate::output::note;

use super::criterion::Criterion;
use super::criterion_spec::{CriterionSpec, ModesSpec, OutsidePhysics};
use super::diagnosis::{Complaint, nearest};
use super::random::RandomInputSet;
use super::sampling::{Effort, Sampling};
use super::sampling_spec::{Audit, EvaluateMode, SamplingMethod};
use super::spec::{AxisSpec, JobSpec, ModelSpec, SECTIONS};

/// Cells at the most; their results are held in memory.
const MOST_CELLS: u64 = 1_000_000;

/// Parts of cells that are counted apart, at the most.
const MOST_PARTS: u64 = 2_000_000;

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
}

impl Job {
    /// Resolves a spec and checks every value of it. Files that it names are sought in `folder`.
    pub fn validate(spec: JobSpec, folder: &Path) -> Result<Self, Complaint> {
        let name = validate_name(&spec.name)?;
        let mut parameters = validate_model(&spec.model)?;
        let axes = &spec.axes;
        let rotating_speed = validate_axis("rotating_speed", axes.rotating_speed.as_ref(), &parameters)?;
        let preload = validate_axis("preload", axes.preload.as_ref(), &parameters)?;
        let static_friction = validate_axis("static_friction", axes.static_friction.as_ref(), &parameters)?;
        // An axis replaces the model's own value, so that value must not contradict anything.
        let lowest = static_friction.values().iter().copied().fold(f64::INFINITY, f64::min);
        if axes.static_friction.is_some() {
            parameters.friction.static_coefficient = lowest;
        }
        parameters.validate().map_err(|error| model_complaint(&spec, &error))?;

        let random = RandomInputSet::validate(&spec.random, folder)?;
        let grid = Grid { rotating_speed, relative_std: random.axis(), preload, static_friction };
        random.check_expected(&spec.random, &parameters, &grid)?;
        match grid.checked_len() {
            Some(cells) if cells <= MOST_CELLS => {}
            cells => {
                let cells = cells.map_or("more than 2^64".to_owned(), |cells| cells.to_string());
                return Err(Complaint {
                    span: None,
                    message: format!("the axes make {cells} cells; the limit is {MOST_CELLS}"),
                });
            }
        }

        let criterion = Criterion::validate(&spec.criterion, &parameters, &grid)?;
        let sampling = Sampling::validate(&spec.sampling, &random, &criterion, grid.checked_len().unwrap_or(u64::MAX))?;
        let disc_modes = spec.criterion.disc_modes.as_ref().map(Spanned::get_ref);
        let modes_are_given = matches!(disc_modes, Some(ModesSpec::Given(_)));
        let outside_physics = validate_outside_physics(&spec.criterion, &sampling)?;
        let description = spec.description;
        let job =
            Self { name, description, parameters, grid, random, criterion, outside_physics, sampling, modes_are_given };
        if job.uses_maps()
            && let Some((speed, rate)) = job.criterion.growth_without_fall(&job.parameters, &job.grid)
        {
            let span = spec.sampling.evaluate.as_ref().map(Spanned::span);
            return Err(Complaint {
                span: span.or(spec.sampling.method.as_ref().map(Spanned::span)),
                message: format!(
                    "a verdict map takes friction that rises with speed for stable, but at {speed} rad/s this brake is unstable even without falling friction (growth rate {rate:+.2e}). Use evaluate = \"each\", which counts what feeds each unstable sample"
                ),
            });
        }
        let sums = job.cells().saturating_mul(job.parts());
        if sums > MOST_PARTS {
            let message = format!(
                "{} cells with {} parts each (randomisations, or looks of until) make {sums} sums to keep; the limit is {MOST_PARTS}: ask for fewer cells at a time, fewer randomisations, or a smaller at_most",
                job.cells(),
                job.parts()
            );
            return Err(Complaint { span: None, message });
        }
        Ok(job)
    }

    /// Says on standard error if the number of disc modes is given and too small.
    pub fn warn_of_few_modes(&self) {
        if self.modes_are_given
            && let Some(check) = self.criterion.too_few_modes(&self.parameters, &self.grid)
        {
            note(format_args!("warning: {check}; use disc_modes = \"auto\""));
        }
    }

    /// The number of cells.
    pub fn cells(&self) -> u64 {
        self.grid.lengths().iter().product()
    }

    /// Parts of each cell that are counted apart: randomisations, or the samples between two looks; 1 without either.
    pub fn parts(&self) -> u64 {
        self.sampling.parts().len() as u64
    }

    /// Samples over all cells, at the most.
    pub fn total_samples(&self) -> u128 {
        u128::from(self.cells()) * u128::from(self.sampling.samples)
    }

    /// Verdicts that counting its samples takes, at the most, if each is simulated: of a sample with Sobol indices also those
    /// of the second sample and of the mixed ones.
    pub fn verdicts_of_samples(&self) -> u128 {
        let of_a_sample = if self.sampling.sensitivity { 2 + self.random.inputs.len() } else { 1 };
        self.total_samples() * of_a_sample as u128
    }

    /// Samples that are looked up and simulated all the same, about so many over all cells.
    pub fn audited_samples(&self) -> u128 {
        match self.sampling.audit {
            Audit::Samples(samples) if self.is_integrated() => u128::from(self.cells()) * u128::from(samples),
            Audit::Samples(samples) => u128::from(self.cells()) * u128::from(samples.min(self.sampling.samples)),
            Audit::Share(share) => (share * self.total_samples() as f64) as u128,
        }
    }

    /// What the deviates are drawn from.
    pub fn points(&self) -> Points {
        if self.sampling.method == SamplingMethod::Sobol { Points::Sobol } else { Points::Random }
    }

    /// Whether drawing and deciding a sample costs little more than its random numbers: only preload and static friction scatter,
    /// normal and independent.
    pub fn has_cheap_samples(&self) -> bool {
        self.sampling.method == SamplingMethod::MonteCarlo && self.random.other().is_none() && self.random.is_plain()
    }

    /// Whether probabilities are integrated, without samples.
    pub fn is_integrated(&self) -> bool {
        self.sampling.method == SamplingMethod::Exact
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

    /// The interval of counted verdicts at a confidence.
    pub fn interval(&self, confidence: f64) -> BinomialInterval {
        BinomialInterval::new(self.sampling.interval_kind(confidence), confidence)
    }

    /// The confidence of the interval of the counted verdicts of one cell. Where a part of them is known from the audit of
    /// a verdict map only, the error is shared with it.
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

    /// The stability boundary of the eigenvalue criterion at each rotating speed of the grid, in the order of the axis.
    pub fn boundaries(&self) -> Result<Vec<StabilityBoundary>, ParameterError> {
        let boundary = |brake: PadOnDisc| brake.stability_boundary();
        Ok(brakes(&self.parameters, &self.grid)?.into_iter().map(boundary).collect())
    }

    /// The brake at each rotating speed of the grid, in the order of the axis.
    pub fn brakes(&self) -> Result<Vec<PadOnDisc>, ParameterError> {
        brakes(&self.parameters, &self.grid)
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

    /// Says on standard error what of the cells lies outside the range over which verdicts in time were tested, and what
    /// to do. The scatter of the inputs is not looked at.
    pub fn warn_of_validity(&self) {
        for uncovered in self.uncovered() {
            note(format_args!(
                "warning: {uncovered}, the limit up to which verdicts in time were tested (cargo doc, page stickslip_core::criterion::validity). They may be right beyond it; look at single samples with `stickslip trajectory`, and compare the run with one of a tenfold criterion.horizon (`stickslip compare`)"
            ));
        }
    }

    /// Says on standard error which normal inputs do not scatter in some cell.
    pub fn warn_of_missing_scatter(&self) {
        for sentence in self.random.without_scatter(&self.parameters, &self.grid) {
            note(format_args!("warning: {sentence}"));
        }
    }

    /// What of the extremes of the axes lies outside that range, each value once.
    fn uncovered(&self) -> Vec<Uncovered> {
        let Criterion::TimeDomain { disc, .. } = &self.criterion else { return Vec::new() };
        let mut found: Vec<Uncovered> = Vec::new();
        for speed in ends(&self.grid.rotating_speed) {
            for static_friction in ends(&self.grid.static_friction) {
                let mut parameters = self.parameters.clone();
                parameters.operating_point.rotating_speed = speed;
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

/// The smallest and the largest value of an axis.
fn ends(axis: &Axis) -> [f64; 2] {
    let values = axis.values().iter().copied();
    [values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max)]
}

/// The brake at each rotating speed.
fn brakes(parameters: &Parameters, grid: &Grid) -> Result<Vec<PadOnDisc>, ParameterError> {
    let brake = |&speed: &f64| {
        let mut parameters = parameters.clone();
        parameters.operating_point.rotating_speed = speed;
        PadOnDisc::new(parameters)
    };
    grid.rotating_speed.values().iter().map(brake).collect()
}

/// What becomes of samples outside physics; an integral has none.
fn validate_outside_physics(spec: &CriterionSpec, sampling: &Sampling) -> Result<OutsidePhysics, Complaint> {
    let Some(policy) = &spec.outside_physics else { return Ok(OutsidePhysics::default()) };
    if sampling.method == SamplingMethod::Exact && *policy.get_ref() != OutsidePhysics::Stable {
        let message = "criterion.outside_physics: method = \"exact\" draws no samples that could fail or be clamped; it takes what is outside physics for stable. Remove the key, or use method = \"monte-carlo\" or \"sobol\"";
        return Err(Complaint::at(policy.span(), message.to_owned()));
    }
    Ok(*policy.get_ref())
}

fn validate_name(name: &Spanned<String>) -> Result<String, Complaint> {
    let text = name.get_ref();
    let allowed = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    if text.is_empty() || text.len() > 100 || text.starts_with('.') || !text.chars().all(allowed) {
        let message = format!(
            "name = {text:?} cannot name a run directory: use 1 to 100 letters, digits, '-', '_' and '.', not starting with '.'"
        );
        return Err(Complaint::at(name.span(), message));
    }
    Ok(text.clone())
}

fn validate_model(model: &ModelSpec) -> Result<Parameters, Complaint> {
    if let Some(preset) = &model.preset
        && preset.get_ref() != "sui-ding-2018"
    {
        let message = format!("unknown preset {:?}; there is \"sui-ding-2018\"", preset.get_ref());
        return Err(Complaint::at(preset.span(), message));
    }
    let mut parameters = Parameters::sui_ding_2018();
    for (section, overrides) in model.sections() {
        for (name, value) in overrides {
            let key = format!("{section}.{}", name.get_ref());
            parameters.set(&key, *value.get_ref()).map_err(|error| match error {
                ParameterError::Unknown { .. } => Complaint::at(name.span(), unknown_parameter(&key)),
                other => Complaint::at(value.span(), format!("model.{other}")),
            })?;
        }
    }
    Ok(parameters)
}

/// The complaint about a parameter that does not exist.
pub fn unknown_parameter(key: &str) -> String {
    let (section, name) = key.split_once('.').unwrap_or(("", key));
    let names: Vec<&str> =
        SCALARS.iter().filter(|scalar| scalar.section() == section).map(parameters::Scalar::name).collect();
    if names.is_empty() {
        let known = SCALARS.iter().map(|scalar| scalar.key);
        let by_name = SCALARS.iter().find(|scalar| scalar.name() == name).map(|scalar| scalar.key);
        let hint =
            by_name.or_else(|| nearest(key, known)).map_or(String::new(), |key| format!("; did you mean `{key}`?"));
        return format!("unknown parameter `{key}`{hint} (sections: {})", SECTIONS.join(", "));
    }
    let hint = nearest(name, names.iter().copied()).map_or(String::new(), |name| format!("; did you mean `{name}`?"));
    format!("unknown key `{name}` in {section}{hint} (it has {})", names.join(", "))
}

/// A contradiction between two values, pointed at the place in the text that brought it about.
fn model_complaint(spec: &JobSpec, error: &ParameterError) -> Complaint {
    let message = error.to_string();
    if let ParameterError::Contradiction { key, other_key, .. } = error {
        let involves_friction = [*key, *other_key].contains(&"friction.static_coefficient");
        if let (true, Some(axis)) = (involves_friction, &spec.axes.static_friction) {
            let message = format!("axes.static_friction contradicts the friction law: {message}");
            return Complaint::at(axis.span(), message);
        }
        for wanted in [*key, *other_key] {
            for (section, overrides) in spec.model.sections() {
                for (name, value) in overrides {
                    if wanted.split_once('.') == Some((section, name.get_ref())) {
                        return Complaint::at(value.span(), format!("model: {message}"));
                    }
                }
            }
        }
    }
    Complaint { span: None, message: format!("model: {message}") }
}

fn validate_axis(name: &str, axis: Option<&Spanned<AxisSpec>>, defaults: &Parameters) -> Result<Axis, Complaint> {
    let key = match name {
        "static_friction" => "friction.static_coefficient",
        "preload" => "operating_point.preload",
        _ => "operating_point.rotating_speed",
    };
    let Some(scalar) = parameters::scalar(key) else {
        return Err(Complaint { span: None, message: format!("axes.{name} has no parameter behind it") });
    };
    let complain = |message: String| Complaint { span: axis.map(Spanned::span), message };
    let built = match axis.map(Spanned::get_ref) {
        None => Axis::from_values(vec![scalar.value(defaults)]),
        Some(AxisSpec::Values(values)) => Axis::from_values(values.clone()),
        Some(AxisSpec::Range(range)) => {
            // Refused before it is filled: a slipped digit must not fill the memory.
            if u64::from(range.points) > MOST_CELLS {
                return Err(complain(format!(
                    "axes.{name}: {} points are too many; the limit is {MOST_CELLS}",
                    range.points
                )));
            }
            Axis::evenly_spaced(range.from, range.to, range.points as usize)
        }
    };
    let axis_values = built.map_err(|error| complain(format!("axes.{name}: {error}")))?;
    for &value in axis_values.values() {
        if !scalar.limits.contain(value) {
            let unit = if scalar.unit == "1" { String::new() } else { format!(" (in {})", scalar.unit) };
            return Err(complain(format!("axes.{name}: {value} is out of range: it must be {}{unit}", scalar.limits)));
        }
    }
    Ok(axis_values)
}
