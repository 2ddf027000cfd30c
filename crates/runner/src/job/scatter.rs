//! How much the random inputs scatter: `random.relative_std`.

use std::collections::HashSet;

use stickslip_core::model::quantity::Quantity;
use stickslip_sampler::inputs::Marginal;
use toml::Spanned;

use super::diagnosis::Complaint;
use super::random_spec::{LARGEST_STD, RandomSpec, StdSpec};

/// The relative standard deviation that a distribution has of itself.
pub fn own_std(marginal: &Marginal) -> Option<f64> {
    match marginal {
        Marginal::Empirical(measured) => Some(measured.relative_std()),
        _ => None,
    }
}

/// The quantities that names of random inputs stand for, and what is said of other names.
#[derive(Clone, Copy)]
pub struct Names<'a> {
    /// The quantities.
    pub quantities: &'a [Quantity],
    /// The complaint about a random input that does not exist.
    pub unknown: &'a dyn Fn(&str) -> String,
    /// What to write for a name that is a quantity in another unit, if it is.
    pub instead: &'a dyn Fn(&str) -> Option<&'static str>,
}

/// The position of an input that a key other than `inputs` names.
pub fn position(inputs: &[usize], names: Names<'_>, name: &str, key: &str) -> Result<usize, String> {
    if let Some(remedy) = (names.instead)(name) {
        return Err(format!("random.{key}: {remedy}"));
    }
    inputs
        .iter()
        .position(|input| names.quantities[*input].name == name)
        .ok_or_else(|| format!("random.{key} gives a value for {name}, but random.inputs does not list {name}"))
}

/// A standard deviation that `relative_std` does not give.
#[derive(Debug, Clone, Copy)]
enum Given {
    /// That of measured values, relative.
    Measured(f64),
    /// That which `std` gives, in the unit of the input.
    Absolute(f64),
}

impl Given {
    fn value(self) -> f64 {
        let (Self::Measured(std) | Self::Absolute(std)) = self;
        std
    }
}

/// The standard deviations that `random.std` gives.
fn validate_absolute_stds(
    random: &RandomSpec,
    inputs: &[usize],
    names: Names<'_>,
    marginals: &[Marginal],
) -> Result<Vec<Option<f64>>, Complaint> {
    let quantities = names.quantities;
    let spec = random.std.as_ref().map(Spanned::get_ref);
    for (name, value) in spec.into_iter().flatten() {
        let complain = |message: String| Complaint::at(name.span(), message);
        let position = position(inputs, names, name.get_ref(), "std").map_err(complain)?;
        let input = &quantities[inputs[position]];
        // What must scatter by `std` is refused with measured values elsewhere.
        if let (Some(std), false) = (own_std(&marginals[position]), input.scatters_absolutely) {
            return Err(complain(format!(
                "random.std gives {} for {name}, but {name} has measured values and scatters as they do (by {std:.4} of its expected value); remove {name} from it",
                value.get_ref()
            )));
        }
        let std = *value.get_ref();
        if !(std >= 0.0 && std.is_finite()) {
            let message = format!("random.std of {} = {std} is out of range: it must be at least 0", input.name);
            return Err(Complaint::at(value.span(), message));
        }
    }
    let std = |input: &usize| {
        let input = &quantities[*input];
        let given = || spec?.iter().find(|(name, _)| *name.get_ref() == input.name).map(|(_, std)| *std.get_ref());
        match given() {
            None if input.scatters_absolutely => {
                let message = format!(
                    "random.std has no value for {name}, which random.inputs lists: how much does it scatter? For example std = {{ \"{name}\" = 0.05 }}, in its unit",
                    name = input.name
                );
                Err(Complaint::maybe_at(random.inputs.as_ref().map(Spanned::span), message))
            }
            given => Ok(given),
        }
    };
    inputs.iter().map(std).collect()
}

/// The relative standard deviation of each input, for each entry of `random.relative_std`, or the standard deviation that
/// `random.std` gives; and whether it is that.
pub fn validate_stds(
    random: &RandomSpec,
    inputs: &[usize],
    names: Names<'_>,
    marginals: &[Marginal],
) -> Result<(Vec<Vec<f64>>, Vec<bool>), Complaint> {
    let measured = marginals.iter().map(|marginal| own_std(marginal).map(Given::Measured));
    let absolute = validate_absolute_stds(random, inputs, names, marginals)?;
    let is_absolute = absolute.iter().map(Option::is_some).collect();
    let own: Vec<Option<Given>> =
        measured.zip(absolute).map(|(measured, absolute)| absolute.map(Given::Absolute).or(measured)).collect();
    let Some(spec) = &random.relative_std else {
        if let Some(stds) = own.iter().map(|own| own.map(Given::value)).collect() {
            return Ok((vec![stds], is_absolute));
        }
        let message = "random.relative_std is missing: how much do the inputs scatter? For example relative_std = 0.2, or std with values in units";
        return Err(Complaint::missing("relative_std", random.inputs.as_ref().map(Spanned::span), message));
    };
    let complain = |message: String| Complaint::at(spec.span(), message);
    if inputs.is_empty() {
        return Err(complain(
            "random.relative_std is given, but random.inputs names no input that scatters".to_owned(),
        ));
    }
    let (mut all, mut seen): (Vec<Vec<f64>>, HashSet<Vec<u64>>) = Default::default();
    for entry in &spec.get_ref().0 {
        let stds = stds_of(entry, inputs, names, &own).map_err(complain)?;
        let relative = stds.iter().zip(&own).filter(|(_, own)| !matches!(own, Some(Given::Absolute(_))));
        if let Some((std, _)) = relative.into_iter().find(|(std, _)| !(0.0..=LARGEST_STD).contains(*std)) {
            return Err(complain(format!(
                "random.relative_std = {std} is out of range: it must be at least 0 and at most {LARGEST_STD} (standard deviation over expected value, not per cent){}",
                as_percentage(*std)
            )));
        }
        // The sum takes the sign from a zero.
        if !seen.insert(stds.iter().map(|std| (std + 0.0).to_bits()).collect()) {
            return Err(complain("random.relative_std lists the same value twice".to_owned()));
        }
        all.push(stds);
    }
    if all.is_empty() {
        return Err(complain("random.relative_std is empty; it needs at least one value".to_owned()));
    }
    Ok((all, is_absolute))
}

/// What may have been meant by a relative standard deviation that is too large, as the end of a message.
pub fn as_percentage(std: f64) -> String {
    match 1.0 < std && std <= 100.0 {
        true => format!("; did you mean {} ({std} %)?", std / 100.0),
        false => String::new(),
    }
}

/// One entry of `relative_std`, for each input; those with measured values have their own.
fn stds_of(entry: &StdSpec, inputs: &[usize], names: Names<'_>, own: &[Option<Given>]) -> Result<Vec<f64>, String> {
    let quantities = names.quantities;
    let measured = |(input, own): (&usize, &Option<Given>)| match own {
        Some(Given::Measured(std)) => Some((&quantities[*input], *std)),
        _ => None,
    };
    match entry {
        StdSpec::Common(value) => match inputs.iter().zip(own).find_map(measured) {
            Some((measured, std)) => {
                let free = inputs.iter().zip(own).filter(|(_, own)| own.is_none());
                let table: Vec<String> =
                    free.map(|(input, _)| format!("{} = {value}", quoted_key(&quantities[*input]))).collect();
                let remedy = match &table[..] {
                    [] => "remove random.relative_std".to_owned(),
                    table => format!("write relative_std = {{ {} }}", table.join(", ")),
                };
                Err(format!(
                    "random.relative_std = {value} is for every input, but {} has measured values and scatters as they do (by {std:.4}); {remedy}",
                    measured.name
                ))
            }
            None if own.iter().all(Option::is_some) => Err(format!(
                "random.relative_std = {value} is for no input: all scatter by random.std; remove random.relative_std"
            )),
            None => Ok(own.iter().map(|own| own.map_or(*value, Given::value)).collect()),
        },
        StdSpec::Each(table) => {
            for (name, value) in table {
                let input = position(inputs, names, name, "relative_std")?;
                if let Some(Given::Absolute(_)) = own[input] {
                    return Err(format!(
                        "random.relative_std gives {value} for {name}, which scatters by random.std; remove {name} from random.relative_std"
                    ));
                }
                if let Some(Given::Measured(std)) = own[input] {
                    return Err(format!(
                        "random.relative_std gives {value} for {name}, but {name} has measured values and scatters as they do (by {std:.4}); remove {name} from it"
                    ));
                }
            }
            let value = |(input, own): (&usize, &Option<Given>)| {
                let name = &quantities[*input].name;
                own.map(Given::value)
                    .or_else(|| table.get(&**name).copied())
                    .ok_or_else(|| format!("random.relative_std has no value for {name}, which random.inputs lists"))
            };
            inputs.iter().zip(own).map(value).collect()
        }
    }
}

/// The name of an input as a key of TOML.
fn quoted_key(input: &Quantity) -> String {
    if input.name.contains('.') { format!("\"{}\"", input.name) } else { input.name.to_string() }
}
