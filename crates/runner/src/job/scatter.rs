//! How much the random inputs scatter: `random.relative_std`.

use stickslip_sampler::inputs::Marginal;
use toml::Spanned;

use super::diagnosis::Complaint;
use super::random_input::{RandomInput, position};
use super::random_spec::{LARGEST_STD, RandomSpec, StdSpec};

/// The relative standard deviation that a distribution has of itself.
pub fn own_std(marginal: &Marginal) -> Option<f64> {
    match marginal {
        Marginal::Empirical(measured) => Some(measured.relative_std()),
        _ => None,
    }
}

/// The relative standard deviation of each input, for each entry of `random.relative_std`.
pub fn validate_stds(
    random: &RandomSpec,
    inputs: &[RandomInput],
    marginals: &[Marginal],
) -> Result<Vec<Vec<f64>>, Complaint> {
    let own: Vec<Option<f64>> = marginals.iter().map(own_std).collect();
    let Some(spec) = &random.relative_std else {
        if let Some(stds) = own.iter().copied().collect() {
            return Ok(vec![stds]);
        }
        let message = "random.relative_std is missing: how much do the inputs scatter? For example relative_std = 0.2";
        return Err(Complaint::missing("relative_std", random.inputs.as_ref().map(Spanned::span), message));
    };
    let complain = |message: String| Complaint::at(spec.span(), message);
    if inputs.is_empty() {
        return Err(complain(
            "random.relative_std is given, but random.inputs names no input that scatters".to_owned(),
        ));
    }
    let mut all: Vec<Vec<f64>> = Vec::new();
    for entry in &spec.get_ref().0 {
        let stds = stds_of(entry, inputs, &own).map_err(complain)?;
        if let Some(std) = stds.iter().find(|std| !(0.0..=LARGEST_STD).contains(*std)) {
            return Err(complain(format!(
                "random.relative_std = {std} is out of range: it must be at least 0 and at most {LARGEST_STD} (standard deviation over expected value, not per cent)"
            )));
        }
        if all.contains(&stds) {
            return Err(complain("random.relative_std lists the same value twice".to_owned()));
        }
        all.push(stds);
    }
    if all.is_empty() {
        return Err(complain("random.relative_std is empty; it needs at least one value".to_owned()));
    }
    Ok(all)
}

/// One entry of `relative_std`, for each input; those with measured values have their own.
fn stds_of(entry: &StdSpec, inputs: &[RandomInput], own: &[Option<f64>]) -> Result<Vec<f64>, String> {
    match entry {
        StdSpec::Common(value) => match inputs.iter().zip(own).find_map(|(input, own)| Some((input, (*own)?))) {
            Some((measured, std)) => {
                let free = inputs.iter().zip(own).filter(|(_, own)| own.is_none());
                let table: Vec<String> = free.map(|(input, _)| format!("{} = {value}", quoted_key(*input))).collect();
                let remedy = match &table[..] {
                    [] => "remove random.relative_std".to_owned(),
                    table => format!("write relative_std = {{ {} }}", table.join(", ")),
                };
                Err(format!(
                    "random.relative_std = {value} is for every input, but {} has measured values and scatters as they do (by {std:.4}); {remedy}",
                    measured.name()
                ))
            }
            None => Ok(vec![*value; inputs.len()]),
        },
        StdSpec::Each(table) => {
            for (name, value) in table {
                if let Some(std) = own[position(inputs, name, "relative_std")?] {
                    return Err(format!(
                        "random.relative_std gives {value} for {name}, but {name} has measured values and scatters as they do (by {std:.4}); remove {name} from it"
                    ));
                }
            }
            let value = |(input, own): (&RandomInput, &Option<f64>)| {
                own.or_else(|| table.get(input.name()).copied()).ok_or_else(|| {
                    format!("random.relative_std has no value for {}, which random.inputs lists", input.name())
                })
            };
            inputs.iter().zip(own).map(value).collect()
        }
    }
}

/// The name of an input as a key of TOML.
fn quoted_key(input: RandomInput) -> String {
    if input.name().contains('.') { format!("\"{}\"", input.name()) } else { input.name().to_owned() }
}
