//! The validated job: every value resolved and within its limits.

use stickslip_core::parameters::{self, SCALARS};
use stickslip_core::{
    FlexibleBrake, FlexibleError, PadOnDisc, ParameterError, Parameters, StabilityBoundary, TimeDomain,
};
use stickslip_sampler::{Axis, BLOCK_SAMPLES, Grid, RelativeStd, SampleStream, WilsonInterval};
use toml::Spanned;

use super::criterion::{Criterion, Deciders};
use super::diagnosis::{Complaint, nearest};
use super::spec::{
    AxisSpec, EvaluateMode, JobSpec, ModelSpec, RandomInput, RandomSpec, SECTIONS, SamplingMethod, StdSpec,
};

/// Cells at the most; their results are held in memory.
const MOST_CELLS: u64 = 1_000_000;

/// Samples in one cell at the most.
const MOST_SAMPLES: u64 = 1_000_000_000_000_000;

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
    /// Random inputs, sorted.
    pub inputs: Vec<RandomInput>,
    /// What decides.
    pub criterion: Criterion,
    /// How probabilities are found.
    pub method: SamplingMethod,
    /// Which samples are judged.
    pub evaluate: EvaluateMode,
    /// Samples in each cell.
    pub samples: u64,
    /// Seed.
    pub seed: u64,
    /// Whether cells share their deviates.
    pub common_random_numbers: bool,
    /// Confidence of the intervals.
    pub confidence: f64,
}

impl Job {
    /// Resolves a spec and checks every value of it.
    pub fn validate(spec: JobSpec) -> Result<Self, Complaint> {
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

        let inputs = validate_inputs(&spec.random)?;
        let relative_std = validate_stds(&spec.random, &inputs)?;
        let grid = Grid { rotating_speed, relative_std, preload, static_friction };
        let span = spec.name.span();
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
        let sampling = &spec.sampling;
        let samples = sampling.samples.as_ref().map_or(10_000, |samples| *samples.get_ref());
        if samples == 0 || samples > MOST_SAMPLES {
            let span = sampling.samples.as_ref().map_or(span.clone(), Spanned::span);
            let message = format!(
                "sampling.samples = {samples} is out of range: it must be at least 1 and at most {MOST_SAMPLES}"
            );
            return Err(Complaint::at(span, message));
        }
        let confidence = sampling.confidence.as_ref().map_or(0.95, |confidence| *confidence.get_ref());
        // The bounds keep the quantile of the interval finite and its definition meaningful.
        if !(0.0 < confidence && confidence <= 1.0 - 1e-12) {
            let span = sampling.confidence.as_ref().map_or(span, Spanned::span);
            let message = format!(
                "sampling.confidence = {confidence} is out of range: it must be greater than 0 and less than 1, for example 0.95"
            );
            return Err(Complaint::at(span, message));
        }
        Ok(Self {
            name,
            description: spec.description,
            parameters,
            grid,
            inputs,
            criterion,
            method: sampling.method,
            evaluate: sampling.evaluate,
            samples,
            seed: sampling.seed.as_ref().map_or(0, |seed| *seed.get_ref()),
            common_random_numbers: sampling.common_random_numbers,
            confidence,
        })
    }

    /// The number of cells.
    pub fn cells(&self) -> u64 {
        self.grid.lengths().iter().product()
    }

    /// Samples over all cells.
    pub fn total_samples(&self) -> u128 {
        u128::from(self.cells()) * u128::from(self.samples)
    }

    /// Where the samples come from.
    pub fn stream(&self) -> SampleStream {
        SampleStream {
            seed: self.seed,
            common_random_numbers: self.common_random_numbers,
            preload_is_random: self.inputs.contains(&RandomInput::Preload),
            static_friction_is_random: self.inputs.contains(&RandomInput::StaticFriction),
        }
    }

    /// The interval of the result columns.
    pub fn interval(&self) -> WilsonInterval {
        WilsonInterval::new(self.confidence)
    }

    /// The stability boundary of the eigenvalue criterion at each rotating speed of the grid, in the order of the axis.
    pub fn boundaries(&self) -> Result<Vec<StabilityBoundary>, ParameterError> {
        let boundary = |brake: PadOnDisc| brake.stability_boundary();
        Ok(brakes(&self.parameters, &self.grid)?.into_iter().map(boundary).collect())
    }

    /// What decides, ready for each rotating speed of the grid.
    pub fn deciders(&self) -> Result<Deciders, FlexibleError> {
        let brakes = brakes(&self.parameters, &self.grid)?.into_iter();
        Ok(match &self.criterion {
            Criterion::Eigenvalue => Deciders::Eigenvalue(brakes.map(|brake| brake.stability_boundary()).collect()),
            Criterion::CoupledEigenvalue { modes } => Deciders::CoupledEigenvalue(
                brakes.map(|brake| FlexibleBrake::with_modes(brake, *modes)).collect::<Result<_, _>>()?,
            ),
            Criterion::TimeDomain { disc, settings } => Deciders::TimeDomain(
                brakes.map(|brake| TimeDomain::new(&brake, disc, *settings)).collect::<Result<_, _>>()?,
            ),
        })
    }

    /// Samples of a unit of work: some milliseconds to a second, long against the cost of handing it out, short against
    /// anyone's patience after Ctrl-C. Part of how shards share a job.
    pub fn unit_samples(&self) -> u64 {
        match self.criterion {
            Criterion::Eigenvalue => 1000 * BLOCK_SAMPLES,
            Criterion::CoupledEigenvalue { .. } | Criterion::TimeDomain { .. } => BLOCK_SAMPLES,
        }
    }

    /// Whether the settled amplitude is recorded.
    pub fn records_amplitude(&self) -> bool {
        matches!(&self.criterion, Criterion::TimeDomain { settings, .. } if settings.record_amplitude)
    }
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

fn validate_inputs(random: &RandomSpec) -> Result<Vec<RandomInput>, Complaint> {
    let Some(spec) = &random.inputs else { return Ok(Vec::new()) };
    let mut inputs = spec.get_ref().clone();
    inputs.sort_unstable();
    if let Some(pair) = inputs.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(Complaint::at(spec.span(), format!("random.inputs lists \"{}\" twice", pair[0].name())));
    }
    Ok(inputs)
}

fn validate_stds(random: &RandomSpec, inputs: &[RandomInput]) -> Result<Vec<RelativeStd>, Complaint> {
    let Some(spec) = &random.relative_std else {
        if inputs.is_empty() {
            return Ok(vec![RelativeStd { preload: 0.0, static_friction: 0.0 }]);
        }
        let message = "random.relative_std is missing: how much do the inputs scatter? For example relative_std = 0.2";
        return Err(Complaint { span: random.inputs.as_ref().map(Spanned::span), message: message.to_owned() });
    };
    let complain = |message: String| Complaint::at(spec.span(), message);
    if inputs.is_empty() {
        return Err(complain(
            "random.relative_std is given, but random.inputs names no input that scatters".to_owned(),
        ));
    }
    let mut stds = Vec::new();
    for entry in &spec.get_ref().0 {
        let value = |input: RandomInput| -> Result<f64, Complaint> {
            let given = match entry {
                StdSpec::Common(value) => inputs.contains(&input).then_some(*value),
                StdSpec::Each(table) => match input {
                    RandomInput::Preload => table.preload,
                    RandomInput::StaticFriction => table.static_friction,
                },
            };
            match (given, inputs.contains(&input)) {
                (Some(std), true) if (0.0..=1.0).contains(&std) => Ok(std),
                (Some(std), true) => Err(complain(format!(
                    "random.relative_std = {std} is out of range: it must be at least 0 and at most 1 (standard deviation over expected value)"
                ))),
                (Some(_), false) => Err(complain(format!(
                    "random.relative_std gives a value for {0}, but random.inputs does not list {0}",
                    input.name()
                ))),
                (None, true) => Err(complain(format!(
                    "random.relative_std has no value for {}, which random.inputs lists",
                    input.name()
                ))),
                (None, false) => Ok(0.0),
            }
        };
        let std =
            RelativeStd { preload: value(RandomInput::Preload)?, static_friction: value(RandomInput::StaticFriction)? };
        if stds.contains(&std) {
            return Err(complain("random.relative_std lists the same value twice".to_owned()));
        }
        stds.push(std);
    }
    if stds.is_empty() {
        return Err(complain("random.relative_std is empty; it needs at least one value".to_owned()));
    }
    Ok(stds)
}
