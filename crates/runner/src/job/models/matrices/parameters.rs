//! The parameters of models given by matrices.

use stickslip_core::model::quantity::Limits;
use stickslip_core::models::matrices::model::BAND;
use stickslip_core::models::matrices::terms::Parameter;
use toml::Spanned;

use super::spec::{DescribedParameter, ParameterSpec};
use crate::job::diagnosis::Complaint;

/// Names that columns of results have whatever the model.
const TAKEN: [&str; 15] = [
    BAND,
    "cell",
    "p_unstable",
    "p_low",
    "p_high",
    "p_undecided",
    "p_audit",
    "p_reduction",
    "distrust",
    "sample",
    "verdict",
    "outside_physics",
    "damping_ratio",
    "growth_rate",
    "frequency",
];

/// What the names of further such columns begin with.
const BEGINNINGS: [&str; 10] = [
    "n_",
    "std_",
    "mean_",
    "scatter_",
    "dp_",
    "first_order_",
    "total_",
    "damping_ratio_",
    "growth_rate_",
    "frequency_",
];

/// A parameter of a job.
pub fn parameter(name: &Spanned<String>, spec: &Spanned<ParameterSpec>) -> Result<Parameter, Complaint> {
    let text = name.get_ref();
    check_name(text).map_err(|message| Complaint::at(name.span(), message))?;
    let described = match spec.get_ref() {
        ParameterSpec::Value(value) => DescribedParameter { value: *value, unit: None, label: None, range: None },
        ParameterSpec::Described(described) => described.clone(),
    };
    let complain = |message: String| Complaint::at(spec.span(), format!("model.parameters.{text}{message}"));
    let range = match described.range {
        None => Limits::ANY,
        Some([least, largest]) if least < largest => Limits::from(least, largest),
        Some([least, largest]) => {
            return Err(complain(format!(".range = [{least}, {largest}]: the first must be less than the second")));
        }
    };
    for (key, said) in [("unit", &described.unit), ("label", &described.label)] {
        if let Some(unfit) = said.iter().flat_map(|said| said.chars()).find(|c| is_unfit(*c)) {
            let code = u32::from(unfit);
            return Err(complain(format!(
                ".{key} has the character U+{code:04X}, which no picture can show; leave control characters out"
            )));
        }
    }
    if !described.value.is_finite() || !range.contain(described.value) {
        return Err(complain(format!(" = {} is out of range: it must be {range}", described.value)));
    }
    Ok(Parameter {
        name: text.clone(),
        value: described.value,
        unit: described.unit.unwrap_or_else(|| "1".to_owned()),
        label: described.label.unwrap_or_else(|| text.replace('_', " ")),
        range,
    })
}

/// Whether a character cannot stand in XML, which pictures are, or breaks a line.
fn is_unfit(c: char) -> bool {
    c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}')
}

/// A parameter with this value as it is written in a job.
pub fn written_parameter(parameter: &Parameter, value: f64) -> ParameterSpec {
    let range = (parameter.range != Limits::ANY).then_some([parameter.range.minimum, parameter.range.maximum]);
    let described = DescribedParameter {
        value,
        unit: (parameter.unit != "1").then(|| parameter.unit.clone()),
        label: (parameter.label != parameter.name.replace('_', " ")).then(|| parameter.label.clone()),
        range,
    };
    match described {
        DescribedParameter { unit: None, label: None, range: None, .. } => ParameterSpec::Value(value),
        _ => ParameterSpec::Described(described),
    }
}

/// Says what is wrong with a name.
fn check_name(text: &str) -> Result<(), String> {
    let is_name = text.starts_with(|c: char| c.is_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_alphanumeric() || c == '_');
    if !is_name {
        return Err(format!(
            "model.parameters: `{text}` is no name: it must have letters, digits and _ only, and begin with a letter"
        ));
    }
    if text == BAND {
        return Err(format!("model.parameters.{text}: this name is that of the bands of frequencies; choose another"));
    }
    let beginning = BEGINNINGS.into_iter().find(|beginning| text.starts_with(beginning));
    if TAKEN.contains(&text) || beginning.is_some() {
        let columns = beginning.map_or_else(
            || "a column of results has this name".to_owned(),
            |beginning| format!("names of columns of results begin with {beginning}"),
        );
        return Err(format!("model.parameters.{text}: {columns}; choose another, for example own_{text}"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_that_no_picture_can_show_are_refused() {
        let with = |label: &str| {
            let label = Some(label.to_owned());
            let described = DescribedParameter { value: 1.0, unit: None, label, range: None };
            let spec = ParameterSpec::Described(described);
            parameter(&Spanned::new(0..1, "k".to_owned()), &Spanned::new(0..1, spec))
        };
        for unfit in ["a\u{1}b", "a\nb", "\u{ffff}", "\u{fffe}", "\u{7f}"] {
            assert!(with(unfit).is_err(), "{unfit:?}");
        }
        assert_eq!(with("Steifigkeit \u{3b1} \u{1d4dd}").unwrap().label, "Steifigkeit \u{3b1} \u{1d4dd}");
    }

    #[test]
    fn names_that_results_have_are_refused() {
        for (name, message) in [
            ("cell", "a column of results has this name; choose another, for example own_cell"),
            ("p_unstable", "a column of results has this name"),
            ("std_friction", "names of columns of results begin with std_"),
            ("frequency_mean", "names of columns of results begin with frequency_"),
            ("band", "is that of the bands"),
            ("2k", "is no name"),
            ("k c", "is no name"),
        ] {
            let refused = check_name(name).unwrap_err();
            assert!(refused.contains(message), "{refused}");
        }
        for name in ["friction", "p_brake", "_k", "\u{b5}", "lining_modulus", "own_cell", "frequencies", "total"] {
            assert_eq!(check_name(name), Ok(()));
        }
    }
}
