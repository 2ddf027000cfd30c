//! The random inputs of a job: which parameters scatter, how, and how they are correlated.

use std::path::Path;

use stickslip_core::motion::start::GivenStart;
use stickslip_core::parameters::Parameters;
use stickslip_sampler::grid::{Grid, RelativeStd};
use stickslip_sampler::inputs::{Correlation, CorrelationError, Marginal, MarginalError};
use toml::Spanned;

use super::diagnosis::{Complaint, Complaints};
use super::distribution_spec::{DistributionSpec, MarginalSpec};
use super::measured;
use super::random_input::{RandomInput, position};
use super::random_spec::RandomSpec;
use super::scatter::validate_stds;
use super::start_value::StartValue;

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
    /// For each entry of `relative_std`, the relative standard deviation of each input; of inputs of the start the
    /// standard deviation itself.
    pub relative_stds: Vec<Vec<f64>>,
}

impl RandomInputSet {
    /// Whether all standard deviations are 0, so that all samples of a cell have one verdict.
    pub fn scatters_nothing(&self) -> bool {
        self.relative_stds.iter().flatten().all(|std| *std == 0.0)
    }

    /// Checks every key but what depends on expected values, see [`RandomInputSet::check_expected`]. `None` if any is
    /// refused.
    ///
    /// Files of measured values are sought in `folder`.
    pub fn validate(random: &RandomSpec, folder: &Path, complaints: &mut Complaints) -> Option<Self> {
        let before = complaints.len();
        let inputs = validate_inputs(random, complaints)?;
        let marginals = validate_distributions(random, &inputs, folder, complaints);
        let relative_stds =
            marginals.as_ref().and_then(|marginals| complaints.take(validate_stds(random, &inputs, marginals)));
        let pairs = validate_pairs(random, &inputs, complaints);
        let correlation = pairs.as_ref().and_then(|pairs| {
            complaints.take(Correlation::new(inputs.len(), pairs).map_err(|error| {
                let span = random.correlation.as_ref().map(Spanned::span);
                Complaint::maybe_at(span, format!("random.correlation: {}", named(&error, &inputs)))
            }))
        });
        if complaints.len() > before || complaints.has_unread(&["random"]) {
            return None;
        }
        Some(Self {
            inputs,
            marginals: marginals?,
            pairs: pairs?,
            correlation: correlation?,
            relative_stds: relative_stds?,
        })
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

    /// The first input in which the entries of `relative_std` differ, by its position.
    pub fn first_varied(&self) -> Option<usize> {
        let stds = &self.relative_stds;
        (0..self.inputs.len()).find(|&input| stds.iter().any(|entry| entry[input] != stds[0][input]))
    }

    /// The positions of preload and static friction, where they are random.
    pub fn pair(&self) -> [Option<usize>; 2] {
        let position = |wanted: fn(&RandomInput) -> bool| self.inputs.iter().position(wanted);
        [
            position(|input| matches!(input, RandomInput::Preload)),
            position(|input| matches!(input, RandomInput::StaticFriction)),
        ]
    }

    /// The positions of the inputs other than preload and static friction.
    pub fn others(&self) -> Vec<usize> {
        let pair = self.pair();
        (0..self.inputs.len()).filter(|&position| !pair.contains(&Some(position))).collect()
    }

    /// The correlation of the inputs other than preload and static friction, followed by these two, which may be random
    /// or not.
    ///
    /// # Errors
    /// A matrix that is not positive definite in this order, as rounding may have it.
    pub fn correlation_with_pair_last(&self) -> Result<Correlation, CorrelationError> {
        let others = self.others();
        let pair = self.pair();
        let place = |position: usize| {
            let of_pair = pair.iter().position(|own| *own == Some(position)).map(|place| others.len() + place);
            of_pair.or_else(|| others.iter().position(|other| *other == position)).unwrap_or_default()
        };
        let pairs: Vec<(usize, usize, f64)> =
            self.pairs.iter().map(|&(first, second, rho)| (place(first), place(second), rho)).collect();
        Correlation::new(others.len() + 2, &pairs)
    }

    /// Whether the input at a position has measured values, with a standard deviation of their own.
    pub fn is_measured(&self, position: usize) -> bool {
        matches!(self.marginals[position], Marginal::Empirical(_))
    }

    /// Whether preload is random.
    pub fn has_preload(&self) -> bool {
        self.inputs.iter().any(|input| matches!(input, RandomInput::Preload))
    }

    /// The first input that is neither preload nor static friction: then samples are not told apart by these two.
    pub fn other(&self) -> Option<RandomInput> {
        self.inputs.iter().copied().find(|input| matches!(input, RandomInput::Other(_) | RandomInput::Start(_)))
    }

    /// The numbers of the start that scatter, each with its position among the inputs.
    pub fn start_values(&self) -> impl Iterator<Item = (usize, StartValue)> {
        let number = |(i, input): (usize, &RandomInput)| match input {
            RandomInput::Start(value) => Some((i, *value)),
            _ => None,
        };
        self.inputs.iter().enumerate().filter_map(number)
    }

    /// The positions of inputs whose standard deviation is not relative to their expected value.
    pub fn absolute(&self) -> impl Iterator<Item = usize> {
        (0..self.inputs.len()).filter(|&i| self.inputs[i].scatters_absolutely())
    }

    /// Checks the distributions of numbers of the start.
    pub fn check_start(&self, random: &RandomSpec, grid: &Grid, start: &GivenStart, complaints: &mut Complaints) {
        for (i, number) in self.start_values() {
            let axis = grid.of_start.iter().find(|further| further.name == number.key());
            let expected =
                axis.map_or_else(|| number.of(start).into_iter().collect(), |axis| axis.axis.values().to_vec());
            let marginal = &self.marginals[i];
            let span = random.distribution.as_ref().map(Spanned::span);
            if let Marginal::Empirical(_) = marginal {
                let message = format!(
                    "random.distribution of {}: measured values are scaled to the expected value, which a number of the start need not have; use another distribution",
                    number.key()
                );
                complaints.push(Complaint::maybe_at(span, message));
                continue;
            }
            let std = self.relative_stds.first().map_or(0.0, |stds| stds[i]);
            let checked = expected.iter().try_for_each(|&value| marginal.check_absolute(value, std));
            let key = number.key();
            complaints.take(
                checked.map_err(|error| Complaint::maybe_at(span, format!("random.distribution of {key}: {error}"))),
            );
        }
    }

    /// Whether all inputs are normal and independent.
    pub fn is_plain(&self) -> bool {
        self.marginals.iter().all(|marginal| *marginal == Marginal::Normal) && self.correlation.is_independent()
    }

    /// Checks distributions that not every expected value allows.
    pub fn check_expected(
        &self,
        random: &RandomSpec,
        parameters: &Parameters,
        grid: &Grid,
        complaints: &mut Complaints,
    ) {
        for (i, (input, marginal)) in self.inputs.iter().zip(&self.marginals).enumerate() {
            let (expected, _) = input.all_expected(parameters, grid);
            let check = |stds: &Vec<f64>, value: f64| match marginal {
                _ if input.scatters_absolutely() => marginal.check_absolute(value, stds[i]),
                // It may stand for any expected value: where that is zero, it does not scatter.
                Marginal::Normal => marginal.check_scatter(stds[i]),
                _ => marginal.check(value, stds[i]),
            };
            let all = self.relative_stds.iter().flat_map(|stds| expected.iter().map(move |&value| (stds, value)));
            let checked = all.into_iter().try_for_each(|(stds, value)| check(stds, value));
            complaints.take(checked.map_err(|error| {
                let (key, span) = match error {
                    MarginalError::NormalTooWide { .. } => {
                        ("relative_std", random.relative_std.as_ref().map(Spanned::span))
                    }
                    _ => ("distribution", random.distribution.as_ref().map(Spanned::span)),
                };
                Complaint::maybe_at(span, format!("random.{key} of {}: {error}", input.name()))
            }));
        }
    }

    /// The normal inputs that do not scatter in some cell although they are asked to, since they scatter in proportion
    /// to an expected value of zero there: each in a sentence.
    pub fn without_scatter(&self, parameters: &Parameters, grid: &Grid) -> Vec<String> {
        let mut found = Vec::new();
        for (i, (input, marginal)) in self.inputs.iter().zip(&self.marginals).enumerate() {
            let (expected, key) = input.all_expected(parameters, grid);
            let largest = self.relative_stds.iter().map(|stds| stds[i]).fold(0.0, f64::max);
            let is_relative = *marginal == Marginal::Normal && !input.scatters_absolutely();
            if is_relative && largest > 0.0 && expected.contains(&0.0) {
                let cells = if expected.len() > 1 { "the cells where it is 0" } else { "any cell" };
                found.push(format!(
                    "{name} does not scatter in {cells}: its standard deviation is relative_std = {largest} times its expected value, {key} = 0. Give it a small expected value, or leave it out of random.inputs",
                    name = input.name()
                ));
            }
        }
        found
    }
}

fn validate_inputs(random: &RandomSpec, complaints: &mut Complaints) -> Option<Vec<RandomInput>> {
    let Some(spec) = &random.inputs else {
        return (!complaints.has_unread(&["random", "inputs"])).then(Vec::new);
    };
    let mut inputs = Vec::new();
    for name in spec.get_ref() {
        let input = RandomInput::from_name(name.get_ref()).map_err(|message| Complaint::at(name.span(), message));
        inputs.push(complaints.take(input));
    }
    let mut inputs = inputs.into_iter().collect::<Option<Vec<_>>>()?;
    inputs.sort_by_key(|input| input.rank());
    if let Some(pair) = inputs.windows(2).find(|pair| pair[0].rank() == pair[1].rank()) {
        let message = format!("random.inputs lists \"{}\" twice", pair[0].name());
        complaints.push(Complaint::at(spec.span(), message));
        return None;
    }
    Some(inputs)
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

fn validate_distributions(
    random: &RandomSpec,
    inputs: &[RandomInput],
    folder: &Path,
    complaints: &mut Complaints,
) -> Option<Vec<Marginal>> {
    let Some(spec) = &random.distribution else {
        return (!complaints.has_unread(&["random", "distribution"])).then(|| vec![Marginal::Normal; inputs.len()]);
    };
    let complain = |message: String| Complaint::at(spec.span(), message);
    match spec.get_ref() {
        DistributionSpec::Common(_) if inputs.is_empty() => Some(Vec::new()),
        DistributionSpec::Common(marginal) => {
            let resolved = resolve(marginal, folder);
            let resolved = resolved.map_err(|message| complain(format!("random.distribution: {message}")));
            complaints.take(resolved).map(|marginal| vec![marginal; inputs.len()])
        }
        DistributionSpec::Each(table) => {
            let before = complaints.len();
            let mut marginals = vec![Marginal::Normal; inputs.len()];
            for (name, marginal) in table {
                let at = complaints.take(position(inputs, name, "distribution").map_err(complain));
                let resolved = resolve(marginal, folder)
                    .map_err(|message| complain(format!("random.distribution of {name}: {message}")));
                if let (Some(marginal), Some(at)) = (complaints.take(resolved), at) {
                    marginals[at] = marginal;
                }
            }
            (complaints.len() == before).then_some(marginals)
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

fn validate_pairs(
    random: &RandomSpec,
    inputs: &[RandomInput],
    complaints: &mut Complaints,
) -> Option<Vec<(usize, usize, f64)>> {
    let mut pairs = Vec::new();
    for pair in random.correlation.iter().flat_map(Spanned::get_ref) {
        let (a, b, coefficient) = pair.get_ref();
        let [a, b] = [a, b].map(|name| {
            let position = position(inputs, name, "correlation");
            complaints.take(position.map_err(|message| Complaint::at(pair.span(), message)))
        });
        pairs.push(a.zip(b).map(|(a, b)| (a, b, *coefficient)));
    }
    pairs.into_iter().collect()
}
