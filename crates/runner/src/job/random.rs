//! The random inputs of a job: which quantities scatter, how, and how they are correlated.

use std::path::Path;

use stickslip_core::model::quantity::{Quantity, Role};
use stickslip_sampler::grid::Grid;
use stickslip_sampler::inputs::{Correlation, CorrelationError, Marginal, MarginalError};
use stickslip_sampler::special_functions::normal;
use toml::Spanned;

use super::diagnosis::{Complaint, Complaints};
use super::distribution_spec::{DistributionSpec, MarginalSpec};
use super::measured;
use super::random_spec::RandomSpec;
use super::scatter::{Names, as_percentage, position, validate_stds};

/// Largest share of negative values that is plausible, of an input that has none.
const MOST_NEGATIVE: f64 = 0.01;

/// The random inputs of a job, checked, in the order in which their deviates are drawn.
#[derive(Debug, Clone)]
pub struct RandomInputSet {
    /// The inputs, as places of quantities.
    pub inputs: Vec<usize>,
    /// The distribution of each.
    pub marginals: Vec<Marginal>,
    /// Correlated pairs, by position, with their coefficient.
    pub pairs: Vec<(usize, usize, f64)>,
    /// Their correlation.
    pub correlation: Correlation,
    /// For each entry of `relative_std`, the relative standard deviation of each input; of inputs that scatter by `std` the
    /// standard deviation itself.
    pub relative_stds: Vec<Vec<f64>>,
    /// The positions of the pair of the model.
    of_pair: [Option<usize>; 2],
    /// Whether the standard deviation of each is given by `std`, and not relative to its expected value.
    is_absolute: Vec<bool>,
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
    pub fn validate(random: &RandomSpec, names: Names<'_>, folder: &Path, complaints: &mut Complaints) -> Option<Self> {
        let (before, quantities) = (complaints.len(), names.quantities);
        let inputs = validate_inputs(random, names, complaints)?;
        let marginals = validate_distributions(random, &inputs, names, folder, complaints);
        let stds =
            marginals.as_ref().and_then(|marginals| complaints.take(validate_stds(random, &inputs, names, marginals)));
        let pairs = validate_pairs(random, &inputs, names, complaints);
        let correlation = pairs.as_ref().and_then(|pairs| {
            complaints.take(Correlation::new(inputs.len(), pairs).map_err(|error| {
                let span = random.correlation.as_ref().map(Spanned::span);
                Complaint::maybe_at(span, format!("random.correlation: {}", named(&error, &inputs, quantities)))
            }))
        });
        if complaints.len() > before || complaints.has_unread(&["random"]) {
            return None;
        }
        let of_pair = quantities.iter().enumerate().filter(|(_, quantity)| quantity.role == Role::Input);
        let mut of_pair = of_pair.map(|(place, _)| inputs.iter().position(|input| *input == place));
        let (relative_stds, is_absolute) = stds?;
        Some(Self {
            of_pair: [(); 2].map(|()| of_pair.next().flatten()),
            is_absolute,
            inputs,
            marginals: marginals?,
            pairs: pairs?,
            correlation: correlation?,
            relative_stds,
        })
    }

    /// The first input in which the entries of `relative_std` differ, by its position.
    pub fn first_varied(&self) -> Option<usize> {
        let stds = &self.relative_stds;
        (0..self.inputs.len()).find(|&input| stds.iter().any(|entry| entry[input] != stds[0][input]))
    }

    /// The position of a quantity among the inputs, if it is random.
    pub fn position(&self, place: usize) -> Option<usize> {
        self.inputs.iter().position(|input| *input == place)
    }

    /// The positions of the pair of the model, where they are random.
    pub fn pair(&self) -> [Option<usize>; 2] {
        self.of_pair
    }

    /// The positions of what integrals go over: the input that is the quantity at a place, or the pair, which may be random
    /// or not.
    fn integrated(&self, one: Option<usize>) -> Vec<Option<usize>> {
        match one {
            Some(place) => vec![self.position(place)],
            None => self.of_pair.to_vec(),
        }
    }

    /// The positions of the inputs other than the quantity at a place, or else than the pair.
    pub fn others(&self, one: Option<usize>) -> Vec<usize> {
        let integrated = self.integrated(one);
        (0..self.inputs.len()).filter(|&position| !integrated.contains(&Some(position))).collect()
    }

    /// The correlation of the inputs other than the quantity at a place, or else than the pair, followed by what integrals
    /// go over.
    ///
    /// # Errors
    /// A matrix that is not positive definite in this order, as rounding may have it.
    pub fn correlation_with_last(&self, one: Option<usize>) -> Result<Correlation, CorrelationError> {
        let (others, integrated) = (self.others(one), self.integrated(one));
        let place = |position: usize| {
            let last = integrated.iter().position(|own| *own == Some(position)).map(|place| others.len() + place);
            last.or_else(|| others.iter().position(|other| *other == position)).unwrap_or_default()
        };
        let pairs: Vec<(usize, usize, f64)> =
            self.pairs.iter().map(|&(first, second, rho)| (place(first), place(second), rho)).collect();
        Correlation::new(others.len() + integrated.len(), &pairs)
    }

    /// Whether the input at a position has measured values, with a standard deviation of their own.
    pub fn is_measured(&self, position: usize) -> bool {
        matches!(self.marginals[position], Marginal::Empirical(_))
    }

    /// The first input that is not of the pair: then samples are not distinguished by these two.
    pub fn other(&self) -> Option<usize> {
        self.others(None).first().map(|&position| self.inputs[position])
    }

    /// Whether the standard deviation of the input at a position is not relative to its expected value.
    pub fn is_absolute(&self, position: usize) -> bool {
        self.is_absolute[position]
    }

    /// The positions of inputs whose standard deviation is not relative to their expected value.
    pub fn absolute(&self) -> impl Iterator<Item = usize> {
        (0..self.inputs.len()).filter(|&position| self.is_absolute(position))
    }

    /// A standard deviation of the input at a position over an expected value of it.
    pub fn relative(&self, position: usize, std: f64, expected: f64) -> f64 {
        if self.is_absolute(position) && std > 0.0 { std / expected } else { std }
    }

    /// Whether all inputs are normal and independent.
    pub fn is_plain(&self) -> bool {
        self.marginals.iter().all(|marginal| *marginal == Marginal::Normal) && self.correlation.is_independent()
    }

    /// Checks distributions that not every expected value allows, of the inputs that `is_wanted`.
    pub fn check_expected(
        &self,
        random: &RandomSpec,
        quantities: &[Quantity],
        grid: &Grid,
        is_wanted: impl Fn(Role) -> bool,
        complaints: &mut Complaints,
    ) {
        let wanted = |(_, input): &(usize, &usize)| is_wanted(quantities[**input].role);
        for (i, &input) in self.inputs.iter().enumerate().filter(wanted) {
            let (marginal, quantity) = (&self.marginals[i], &quantities[input]);
            let span = random.distribution.as_ref().map(Spanned::span);
            if let (Marginal::Empirical(_), Role::Start) = (marginal, quantity.role) {
                let message = format!(
                    "random.distribution of {}: measured values are scaled to the expected value, which a number of the start need not have; use another distribution",
                    quantity.name
                );
                complaints.push(Complaint::maybe_at(span, message));
                continue;
            }
            // Integrals over the pair of the model know it by its relative standard deviations.
            let is_of_pair = self.of_pair.contains(&Some(i));
            let check = |stds: &Vec<f64>, value: f64| match marginal {
                _ if self.is_absolute[i] && is_of_pair => marginal.check(value, stds[i] / value),
                _ if self.is_absolute[i] => marginal.check_absolute(value, stds[i]),
                // It may stand for any expected value: where that is zero, it does not scatter.
                Marginal::Normal => marginal.check_scatter(stds[i]),
                _ => marginal.check(value, stds[i]),
            };
            let expected = grid.values_of(input);
            let all = self.relative_stds.iter().flat_map(|stds| expected.iter().map(move |&value| (stds, value)));
            let refused = |(stds, value): (&Vec<f64>, f64)| check(stds, value).map_err(|error| (error, stds[i], value));
            complaints.take(all.into_iter().try_for_each(refused).map_err(|(error, std, value)| {
                let (key, span) = match error {
                    MarginalError::NoInterval { .. }
                    | MarginalError::IntervalTooFar { .. }
                    | MarginalError::Mode { .. }
                    | MarginalError::BetaEnds { .. } => ("distribution", span),
                    _ if self.is_absolute[i] => ("std", random.std.as_ref().map(Spanned::span)),
                    MarginalError::NormalTooWide { .. } => {
                        ("relative_std", random.relative_std.as_ref().map(Spanned::span))
                    }
                    _ => ("distribution", span),
                };
                let said = match error {
                    MarginalError::Expected { .. } if self.is_absolute[i] => {
                        let other = if is_of_pair { "" } else { ", or a distribution that may have any, such as normal" };
                        format!(
                            "a {} input that scatters by {std} has an expected value above 0, and here it is {value}; give it one above 0{other}, or leave it out of random.inputs",
                            marginal.name()
                        )
                    }
                    MarginalError::RelativeStd { value: relative }
                    | MarginalError::NormalTooWide { value: relative }
                    | MarginalError::UniformTooWide { value: relative }
                    | MarginalError::TruncatedTooWide { value: relative, .. }
                    | MarginalError::TriangularTooWide { value: relative, .. }
                    | MarginalError::BetaStd { value: relative, .. } => match self.is_absolute[i] {
                        true => format!("{std} is {relative:.4} times the expected value, {value}: {error}"),
                        false => format!("{error}{}", as_percentage(relative)),
                    },
                    _ => error.to_string(),
                };
                Complaint::maybe_at(span, format!("random.{key} of {}: {said}", quantity.name))
            }));
        }
    }

    /// What a user should know of the inputs, in sentences: distributions without their expected value; normal inputs that
    /// do not scatter in some cell although they are asked to, since they scatter in proportion to an expected value of
    /// zero there; normal inputs that scatter so much that many of their values are negative.
    pub fn warnings(&self, quantities: &[Quantity], grid: &Grid) -> Vec<String> {
        let mut found = Vec::new();
        for (&input, marginal) in self.inputs.iter().zip(&self.marginals) {
            if let Marginal::TruncatedNormal { low, high } = *marginal
                && !(low..=high).contains(&0.0)
            {
                let side = if low > 0.0 { "more" } else { "less" };
                found.push(format!(
                    "random.distribution of {}: truncated-normal = [{low}, {high}] excludes the expected value itself, so every sample is {side} than it. The limits are in standard deviations from the expected value, for example [-2, 3]",
                    quantities[input].name
                ));
            }
        }
        for (i, (&input, marginal)) in self.inputs.iter().zip(&self.marginals).enumerate() {
            let (expected, quantity) = (grid.values_of(input), &quantities[input]);
            let largest = self.relative_stds.iter().map(|stds| stds[i]).fold(0.0, f64::max);
            let is_normal = *marginal == Marginal::Normal;
            if is_normal && !self.is_absolute[i] && largest > 0.0 && expected.contains(&0.0) {
                let cells = if expected.len() > 1 { "the cells where it is 0" } else { "any cell" };
                let table = if grid.axis_of(input).is_some() { "axes" } else { "model" };
                found.push(format!(
                    "{name} does not scatter in {cells}: its standard deviation is relative_std = {largest} times its expected value, {table}.{name} = 0. Give it a small expected value, or leave it out of random.inputs",
                    name = quantity.name
                ));
            }
            let least = expected.iter().copied().filter(|value| *value > 0.0).fold(f64::INFINITY, f64::min);
            let negative = normal::upper_tail(1.0 / self.relative(i, largest, least));
            let is_positive = quantity.limits.minimum >= 0.0 && least.is_finite();
            if is_normal && is_positive && negative > MOST_NEGATIVE {
                let key = if self.is_absolute[i] { "std" } else { "relative_std" };
                found.push(format!(
                    "random.{key} of {name} = {largest} is not plausible: {:.1} % of its values are negative (usually less than 1 %, with a standard deviation up to 0.42 of the expected value). Give a smaller one, or a distribution without negative values: distribution = {{ {name:?} = \"lognormal\" }}",
                    100.0 * negative,
                    name = quantity.name
                ));
            }
        }
        found
    }
}

fn validate_inputs(random: &RandomSpec, names: Names<'_>, complaints: &mut Complaints) -> Option<Vec<usize>> {
    let Some(spec) = &random.inputs else {
        return (!complaints.has_unread(&["random", "inputs"])).then(Vec::new);
    };
    let mut inputs = Vec::new();
    for name in spec.get_ref() {
        let input = input_of(name.get_ref(), names).map_err(|message| Complaint::at(name.span(), message));
        let is_unread = complaints.has_unread_parameter(name.get_ref());
        inputs.push(if is_unread { input.ok() } else { complaints.take(input) });
    }
    let mut inputs = inputs.into_iter().collect::<Option<Vec<_>>>()?;
    inputs.sort_unstable();
    if let Some(pair) = inputs.windows(2).find(|pair| pair[0] == pair[1]) {
        let message = format!("random.inputs lists \"{}\" twice", names.quantities[pair[0]].name);
        complaints.push(Complaint::at(spec.span(), message));
        return None;
    }
    Some(inputs)
}

/// The place of the quantity that a random input is.
fn input_of(name: &str, names: Names<'_>) -> Result<usize, String> {
    let quantities = names.quantities;
    match quantities.iter().position(|quantity| quantity.name == name) {
        Some(place) if quantities[place].only_selects => {
            let Quantity { description, limits, .. } = &quantities[place];
            Err(format!(
                "random.inputs: {name} ({description}) only says what of a sample counts, and cannot scatter; remove it, which makes a cell of each value from {least} to {}, or have some as an axis, for example axes.{name} = [{least}]",
                limits.maximum,
                least = limits.minimum,
            ))
        }
        Some(place) => Ok(place),
        None => Err(match quantities.iter().find(|quantity| quantity.path == name) {
            Some(quantity) => {
                format!("random.inputs: write \"{}\" for \"{name}\", as in [axes]", quantity.name)
            }
            None => (names.unknown)(name),
        }),
    }
}

/// A complaint about a correlation, with the names of the inputs.
fn named(error: &CorrelationError, inputs: &[usize], quantities: &[Quantity]) -> String {
    let name = |input: usize| inputs.get(input).map_or("", |input| &*quantities[*input].name);
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
    inputs: &[usize],
    names: Names<'_>,
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
                let at = complaints.take(position(inputs, names, name, "distribution").map_err(complain));
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
    inputs: &[usize],
    names: Names<'_>,
    complaints: &mut Complaints,
) -> Option<Vec<(usize, usize, f64)>> {
    let mut pairs = Vec::new();
    for pair in random.correlation.iter().flat_map(Spanned::get_ref) {
        let (a, b, coefficient) = pair.get_ref();
        let [a, b] = [a, b].map(|name| {
            let position = position(inputs, names, name, "correlation");
            complaints.take(position.map_err(|message| Complaint::at(pair.span(), message)))
        });
        pairs.push(a.zip(b).map(|(a, b)| (a, b, *coefficient)));
    }
    pairs.into_iter().collect()
}
