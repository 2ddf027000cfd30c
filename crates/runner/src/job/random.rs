//! The random inputs of a job: which parameters scatter, how, and how they are correlated.

use std::collections::BTreeMap;
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stickslip_core::parameters::Parameters;
use stickslip_core::parameters::{SCALARS, Scalar, scalar};
use stickslip_sampler::grid::{Cell, Grid, RelativeStd};
use stickslip_sampler::inputs::{Correlation, CorrelationError, Marginal, MarginalError};
use toml::Spanned;

use super::diagnosis::{Complaint, nearest};
use super::distribution::{DistributionSpec, MarginalSpec, NormalisedMarginal};
use super::measured;
use super::scatter::{RelativeStdSpec, own_std, validate_stds};

/// The random inputs.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomSpec {
    /// The inputs that scatter about their expected value: "preload", "static_friction", "rotating_speed", or any
    /// parameter of the model by its path, for example "stiffness.contact_normal". May be empty.
    #[schemars(with = "Option<Vec<String>>")]
    pub inputs: Option<Spanned<Vec<Spanned<String>>>>,
    /// Standard deviation over expected value, from 0 to what the distribution allows: 1 for a normal input. A list makes an
    /// axis of the grid. An input with measured values has their own, and none here.
    #[schemars(with = "Option<RelativeStdSpec>")]
    pub relative_std: Option<Spanned<RelativeStdSpec>>,
    /// The distribution of every input, or a table by input; "normal" unless told.
    #[schemars(with = "Option<DistributionSpec>")]
    pub distribution: Option<Spanned<DistributionSpec>>,
    /// Correlated pairs: [["preload", "static_friction", 0.3], ...], coefficients of the normal deviates behind them.
    #[schemars(with = "Option<Vec<(String, String, f64)>>")]
    pub correlation: Option<Spanned<Vec<PairSpec>>>,
}

/// Two inputs and their coefficient of correlation.
pub type PairSpec = Spanned<(String, String, f64)>;

/// An input that scatters.
#[derive(Debug, Clone, Copy)]
pub enum RandomInput {
    /// The preload Delta.
    Preload,
    /// The static friction coefficient f_s.
    StaticFriction,
    /// Any other parameter; its expected value is the model's, or that of the axis of rotating speeds.
    Other(&'static Scalar),
}

impl RandomInput {
    /// As in a job spec.
    pub fn name(self) -> &'static str {
        match self {
            Self::Preload => "preload",
            Self::StaticFriction => "static_friction",
            Self::Other(_) if self.is_rotating_speed() => "rotating_speed",
            Self::Other(scalar) => scalar.key,
        }
    }

    fn from_name(name: &str) -> Result<Self, String> {
        match name {
            "preload" => return Ok(Self::Preload),
            "static_friction" => return Ok(Self::StaticFriction),
            _ => {}
        }
        if let ("rotating_speed", Some(scalar)) = (name, scalar("operating_point.rotating_speed")) {
            return Ok(Self::Other(scalar));
        }
        let axis = match name {
            "friction.static_coefficient" => Some("static_friction"),
            "operating_point.preload" => Some("preload"),
            "operating_point.rotating_speed" => Some("rotating_speed"),
            _ => None,
        };
        if let Some(axis) = axis {
            return Err(format!("random.inputs: write \"{axis}\" for \"{name}\", as in [axes]"));
        }
        if let Some(scalar) = scalar(name) {
            return Ok(Self::Other(scalar));
        }
        let names = ["preload", "static_friction", "rotating_speed"];
        let by_name = SCALARS.iter().find(|scalar| scalar.name() == name).map(|scalar| scalar.key);
        let hint = by_name.or_else(|| nearest(name, names.into_iter().chain(SCALARS.iter().map(|scalar| scalar.key))));
        let hint = hint.map_or(String::new(), |hint| format!("; did you mean `{hint}`?"));
        Err(format!(
            "random.inputs: there is no input \"{name}\"{hint} (preload, static_friction, rotating_speed, or a parameter of the model as `section.name`)"
        ))
    }

    /// Its expected value in a cell.
    pub fn expected(self, cell: &Cell, parameters: &Parameters) -> f64 {
        match self {
            Self::Preload => cell.preload,
            Self::StaticFriction => cell.static_friction,
            Self::Other(_) if self.is_rotating_speed() => cell.rotating_speed,
            Self::Other(scalar) => scalar.value(parameters),
        }
    }

    /// Its expected values over all cells, and the key that has them.
    fn all_expected(self, parameters: &Parameters, grid: &Grid) -> (Vec<f64>, String) {
        match self {
            Self::Preload => (grid.preload.values().to_vec(), "axes.preload".to_owned()),
            Self::StaticFriction => (grid.static_friction.values().to_vec(), "axes.static_friction".to_owned()),
            Self::Other(_) if self.is_rotating_speed() => {
                (grid.rotating_speed.values().to_vec(), "axes.rotating_speed".to_owned())
            }
            Self::Other(scalar) => (vec![scalar.value(parameters)], format!("model.{}", scalar.key)),
        }
    }

    /// Whether it is the rotating speed, which has an axis.
    pub fn is_rotating_speed(self) -> bool {
        matches!(self, Self::Other(scalar) if scalar.key == "operating_point.rotating_speed")
    }

    /// Its place in the order in which deviates are drawn: preload, static friction, then the model's parameters.
    fn rank(self) -> usize {
        match self {
            Self::Preload => 0,
            Self::StaticFriction => 1,
            Self::Other(scalar) => 2 + SCALARS.iter().position(|other| other.key == scalar.key).unwrap_or(0),
        }
    }
}

/// The random inputs of a job, checked, in the order in which their deviates are drawn.
#[derive(Debug, Clone)]
pub struct RandomInputSet {
    /// The inputs.
    pub inputs: Vec<RandomInput>,
    /// The distribution of each.
    pub marginals: Vec<Marginal>,
    /// Correlated pairs, by position, with their coefficient.
    pub pairs: Vec<(usize, usize, f64)>,
    /// Their correlation.
    pub correlation: Correlation,
    /// For each entry of `relative_std`, the relative standard deviation of each input.
    pub relative_stds: Vec<Vec<f64>>,
}

impl RandomInputSet {
    /// Checks every key but what depends on expected values, see [`RandomInputSet::check_expected`].
    ///
    /// Files of measured values are sought in `folder`.
    pub fn validate(random: &RandomSpec, folder: &Path) -> Result<Self, Complaint> {
        let inputs = validate_inputs(random)?;
        let marginals = validate_distributions(random, &inputs, folder)?;
        let relative_stds = validate_stds(random, &inputs, &marginals)?;
        let pairs = validate_pairs(random, &inputs)?;
        let correlation = Correlation::new(inputs.len(), &pairs).map_err(|error| Complaint {
            span: random.correlation.as_ref().map(Spanned::span),
            message: format!("random.correlation: {}", named(&error, &inputs)),
        })?;
        Ok(Self { inputs, marginals, pairs, correlation, relative_stds })
    }

    /// The relative standard deviations of preload and static friction, as the grid has them.
    pub fn axis(&self) -> Vec<RelativeStd> {
        let of = |stds: &[f64], wanted: fn(&RandomInput) -> bool| {
            self.inputs.iter().position(wanted).map_or(0.0, |i| stds[i])
        };
        let entry = |stds: &Vec<f64>| RelativeStd {
            preload: of(stds, |input| matches!(input, RandomInput::Preload)),
            static_friction: of(stds, |input| matches!(input, RandomInput::StaticFriction)),
        };
        self.relative_stds.iter().map(entry).collect()
    }

    /// Whether preload is random.
    pub fn has_preload(&self) -> bool {
        self.inputs.iter().any(|input| matches!(input, RandomInput::Preload))
    }

    /// The first input that is neither preload nor static friction: then every sample is a brake of its own.
    pub fn other(&self) -> Option<RandomInput> {
        self.inputs.iter().copied().find(|input| matches!(input, RandomInput::Other(_)))
    }

    /// Whether all inputs are normal and independent.
    pub fn is_plain(&self) -> bool {
        self.marginals.iter().all(|marginal| *marginal == Marginal::Normal) && self.correlation.is_independent()
    }

    /// Checks distributions that not every expected value allows.
    pub fn check_expected(&self, random: &RandomSpec, parameters: &Parameters, grid: &Grid) -> Result<(), Complaint> {
        for (i, (input, marginal)) in self.inputs.iter().zip(&self.marginals).enumerate() {
            let (expected, _) = input.all_expected(parameters, grid);
            for stds in &self.relative_stds {
                let check = |&value: &f64| match marginal {
                    // It may stand for any expected value: where that is zero, it does not scatter.
                    Marginal::Normal => marginal.check_scatter(stds[i]),
                    _ => marginal.check(value, stds[i]),
                };
                expected.iter().try_for_each(check).map_err(|error| {
                    let (key, span) = match error {
                        MarginalError::NormalTooWide { .. } => {
                            ("relative_std", random.relative_std.as_ref().map(Spanned::span))
                        }
                        _ => ("distribution", random.distribution.as_ref().map(Spanned::span)),
                    };
                    Complaint { span, message: format!("random.{key} of {}: {error}", input.name()) }
                })?;
            }
        }
        Ok(())
    }

    /// The normal inputs that do not scatter in some cell although they are asked to, since they scatter in proportion to
    /// an expected value of zero there: each in a sentence.
    pub fn without_scatter(&self, parameters: &Parameters, grid: &Grid) -> Vec<String> {
        let mut found = Vec::new();
        for (i, (input, marginal)) in self.inputs.iter().zip(&self.marginals).enumerate() {
            let (expected, key) = input.all_expected(parameters, grid);
            let largest = self.relative_stds.iter().map(|stds| stds[i]).fold(0.0, f64::max);
            if *marginal == Marginal::Normal && largest > 0.0 && expected.contains(&0.0) {
                let cells = if expected.len() > 1 { "the cells where it is 0" } else { "any cell" };
                found.push(format!(
                    "{name} does not scatter in {cells}: its standard deviation is relative_std = {largest} times its expected value, {key} = 0. Give it a small expected value, or leave it out of random.inputs",
                    name = input.name()
                ));
            }
        }
        found
    }

    /// As a normalised job writes it.
    pub fn normalised(&self) -> NormalisedRandom {
        let name = |i: usize| self.inputs[i].name();
        let distribution = self.inputs.iter().zip(&self.marginals);
        NormalisedRandom {
            inputs: self.inputs.iter().map(|input| input.name()).collect(),
            relative_std: self
                .relative_stds
                .iter()
                .map(|stds| self.given_stds(stds))
                .filter(|stds| !stds.is_empty())
                .collect(),
            distribution: distribution
                .filter(|(_, marginal)| **marginal != Marginal::Normal)
                .map(|(input, marginal)| (input.name(), marginal.into()))
                .collect(),
            correlation: self.pairs.iter().map(|&(i, j, rho)| (name(i), name(j), rho)).collect(),
        }
    }

    /// By input, but for those with measured values, which have their own.
    fn given_stds(&self, stds: &[f64]) -> BTreeMap<&'static str, f64> {
        let inputs = self.inputs.iter().zip(&self.marginals).zip(stds);
        inputs
            .filter(|((_, marginal), _)| own_std(marginal).is_none())
            .map(|((input, _), &std)| (input.name(), std))
            .collect()
    }
}

/// The random inputs as a normalised job writes them.
#[derive(Serialize)]
pub struct NormalisedRandom {
    inputs: Vec<&'static str>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    relative_std: Vec<BTreeMap<&'static str, f64>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    correlation: Vec<(&'static str, &'static str, f64)>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    distribution: BTreeMap<&'static str, NormalisedMarginal>,
}

fn validate_inputs(random: &RandomSpec) -> Result<Vec<RandomInput>, Complaint> {
    let Some(spec) = &random.inputs else { return Ok(Vec::new()) };
    let mut inputs = Vec::new();
    for name in spec.get_ref() {
        inputs.push(RandomInput::from_name(name.get_ref()).map_err(|message| Complaint::at(name.span(), message))?);
    }
    inputs.sort_by_key(|input| input.rank());
    if let Some(pair) = inputs.windows(2).find(|pair| pair[0].rank() == pair[1].rank()) {
        return Err(Complaint::at(spec.span(), format!("random.inputs lists \"{}\" twice", pair[0].name())));
    }
    Ok(inputs)
}

/// A complaint about a correlation, with the names of the inputs.
fn named(error: &CorrelationError, inputs: &[RandomInput]) -> String {
    let name = |input: usize| inputs.get(input).map_or("", |input| input.name());
    match *error {
        CorrelationError::SameInput { input } => {
            format!("{} is paired with itself; a correlation joins two different inputs", name(input))
        }
        CorrelationError::OutOfRange { first, second, coefficient } => format!(
            "the coefficient of {} and {} is {coefficient}; it must be greater than -1 and less than 1",
            name(first),
            name(second)
        ),
        CorrelationError::Repeated { first, second } => {
            format!("{} and {} are listed twice", name(first), name(second))
        }
        CorrelationError::NotPositiveDefinite { input } => format!(
            "the coefficients contradict each other: {} cannot have those given for it (the matrix is not positive definite)",
            name(input)
        ),
        ref other => other.to_string(),
    }
}

/// The position of an input that a key other than `inputs` names.
pub fn position(inputs: &[RandomInput], name: &str, key: &str) -> Result<usize, String> {
    inputs
        .iter()
        .position(|input| input.name() == name)
        .ok_or_else(|| format!("random.{key} gives a value for {name}, but random.inputs does not list {name}"))
}

fn validate_distributions(
    random: &RandomSpec,
    inputs: &[RandomInput],
    folder: &Path,
) -> Result<Vec<Marginal>, Complaint> {
    let Some(spec) = &random.distribution else { return Ok(vec![Marginal::Normal; inputs.len()]) };
    let complain = |message: String| Complaint::at(spec.span(), message);
    match spec.get_ref() {
        DistributionSpec::Common(_) if inputs.is_empty() => Ok(Vec::new()),
        DistributionSpec::Common(marginal) => {
            let marginal =
                resolve(marginal, folder).map_err(|message| complain(format!("random.distribution: {message}")))?;
            Ok(vec![marginal; inputs.len()])
        }
        DistributionSpec::Each(table) => {
            let mut marginals = vec![Marginal::Normal; inputs.len()];
            for (name, marginal) in table {
                let at = position(inputs, name, "distribution").map_err(complain)?;
                marginals[at] = resolve(marginal, folder)
                    .map_err(|message| complain(format!("random.distribution of {name}: {message}")))?;
            }
            Ok(marginals)
        }
    }
}

/// The distribution, with measured values read.
fn resolve(spec: &MarginalSpec, folder: &Path) -> Result<Marginal, String> {
    Ok(match spec {
        MarginalSpec::Given(marginal) => marginal.clone(),
        MarginalSpec::Values(values) => {
            Marginal::Empirical(measured::from_values(values).map_err(|message| format!("values: {message}"))?)
        }
        MarginalSpec::Csv { file, column } => Marginal::Empirical(measured::from_csv(&folder.join(file), column)?),
    })
}

fn validate_pairs(random: &RandomSpec, inputs: &[RandomInput]) -> Result<Vec<(usize, usize, f64)>, Complaint> {
    let mut pairs = Vec::new();
    for pair in random.correlation.iter().flat_map(Spanned::get_ref) {
        let (a, b, coefficient) = pair.get_ref();
        let at =
            |name: &str| position(inputs, name, "correlation").map_err(|message| Complaint::at(pair.span(), message));
        pairs.push((at(a)?, at(b)?, *coefficient));
    }
    Ok(pairs)
}
