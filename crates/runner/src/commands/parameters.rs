//! `parameters`: every parameter of the brake, with its symbol, unit, range and value.

use std::f64::consts::PI;

use serde_json::{Value, json};
use stickslip_core::model::quantity::Limits;
use stickslip_core::models::pad_on_disc::parameters::{Parameters, SCALARS, Scalar};

use super::one_brake::changed_preset;
use crate::cli::ParametersArguments;
use crate::failure::Failure;
use crate::job::friction::{CurveColumns, LAWS, SPLINE};
use crate::job::models::pad_on_disc::preload_force;
use crate::output::{broken, result};
use crate::picture::view::rounded;

/// Width of the table, and widths of its columns but the last.
const WIDTH: usize = 100;
const COLUMNS: [usize; 5] = [30, 6, 9, 11, 9];

/// What the keys of friction are that have no number.
const LAW: &str = "friction law: stribeck, rational or table";
const TABLE: &str = "measured curve of the law table, a CSV file";
const SMOOTHING: &str = "smoothing of the measured curve: spline";

/// The keys that `--set` takes.
pub fn keys() -> impl Iterator<Item = &'static str> {
    let others = [preload_force::KEY, "friction.law", "friction.table", "friction.smoothing"];
    SCALARS.iter().map(|scalar| scalar.key).chain(others)
}

/// `stickslip parameters`.
pub fn parameters(arguments: &ParametersArguments) -> Result<(), Failure> {
    let brake = changed_preset(&arguments.set)?;
    let values = brake.parameters();
    result(&if arguments.json { format!("{:#}\n", as_json(values)) } else { as_text(values) })
}

fn as_json(values: &Parameters) -> Value {
    let preset = Parameters::sui_ding_2018();
    let numbers = SCALARS.iter().map(|scalar| {
        let Limits { minimum, includes_minimum, maximum, includes_maximum } = scalar.limits;
        json!({
            "key": scalar.key,
            "section": scalar.section(),
            "symbol": scalar.symbol,
            "unit": scalar.unit,
            "minimum": minimum,
            "includes_minimum": includes_minimum,
            "maximum": maximum,
            "includes_maximum": includes_maximum,
            "preset": scalar.value(&preset),
            "value": scalar.value(values),
            "description": scalar.description,
        })
    });
    let law = &values.friction.law;
    json!({
        "parameters": numbers.collect::<Vec<_>>(),
        "friction.law": { "laws": LAWS, "preset": preset.friction.law.name(), "value": law.name(), "description": LAW },
        "friction.table": {
            "preset": null,
            "value": law.table().map(|curve| json!(CurveColumns::from(&**curve))),
            "description": TABLE,
        },
        "friction.smoothing": {
            "preset": null,
            "value": is_smoothed(values).then_some(SPLINE),
            "description": SMOOTHING,
        },
    })
}

/// Whether friction is a measured curve that is smoothed.
fn is_smoothed(values: &Parameters) -> bool {
    values.friction.law.table().is_some_and(|curve| curve.smoothing().is_some())
}

/// A table of one section after the other.
fn as_text(values: &Parameters) -> String {
    let preset = Parameters::sui_ding_2018();
    let mut text = row(["key", "symbol", "unit", "range", "value"], "what it is");
    let mut section = "";
    let mut is_changed = false;
    let mut marked = |value: String, changed: bool| {
        is_changed |= changed;
        if changed { format!("{value}*") } else { value }
    };
    for scalar in &SCALARS {
        if scalar.section() != section {
            section = scalar.section();
            text.push('\n');
            if section == "friction" {
                let law = &values.friction.law;
                let rows =
                    law.table().map_or_else(|| "none".to_owned(), |curve| format!("{} rows", curve.speeds().len()));
                let name = marked(law.name().to_owned(), *law != preset.friction.law);
                text += &row(["friction.law", "", "", "", &name], LAW);
                text += &row(["friction.table", "", "", "", &marked(rows, law.table().is_some())], TABLE);
                let is_smoothed = is_smoothed(values);
                let smoothing = marked(if is_smoothed { SPLINE } else { "none" }.to_owned(), is_smoothed);
                text += &row(["friction.smoothing", "", "", "", &smoothing], SMOOTHING);
            }
        }
        let value = scalar.value(values);
        let shown = marked(rounded(value), value.to_bits() != scalar.value(&preset).to_bits());
        text += &row([scalar.key, scalar.symbol, scalar.unit, &range(scalar), &shown], scalar.description);
    }
    text += "\nChange a value with --set KEY=VALUE, and in a job under [model]. Ranges are far beyond any brake.\n";
    if is_changed {
        text += "* not the value of the preset\n";
    }
    text
}

/// The admissible values, as short as possible.
fn range(scalar: &Scalar) -> String {
    let Limits { minimum, includes_minimum, maximum, includes_maximum } = scalar.limits;
    let number = |value: f64| match value {
        PI => "pi".to_owned(),
        _ if value == 0.0 || (1e-2..1e5).contains(&value.abs()) => value.to_string(),
        _ => format!("{value:e}"),
    };
    let above = if includes_minimum { "" } else { ">" };
    let below = if includes_maximum { "" } else { "<" };
    format!("{above}{} to {below}{}", number(minimum), number(maximum))
}

/// A row of the table. What does not fit into the last column goes on below.
fn row(columns: [&str; 5], last: &str) -> String {
    let mut line = String::new();
    for (column, width) in columns.iter().zip(COLUMNS) {
        line += &format!("{column:width$} ");
    }
    let indent = line.len();
    let description = broken(last, WIDTH - indent).join(&format!("\n{:indent$}", ""));
    format!("{}\n", (line + &description).trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_is_wide_enough() {
        for scalar in &SCALARS {
            let range = range(scalar);
            for (text, width) in [scalar.key, scalar.symbol, scalar.unit, &range].into_iter().zip(COLUMNS) {
                assert!(text.len() <= width, "{text}");
            }
        }
    }
}
