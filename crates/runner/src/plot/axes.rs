//! What the axes of plots are called.

use stickslip_core::parameters::scalar;

use crate::job::StartValue;
use crate::picture::scale::Scale;
use crate::picture::view::ViewAxis;
use crate::plot::panel::Axis;

/// The axis of a grid, with its symbol, name and unit.
pub fn axis(of: &ViewAxis) -> Axis {
    Axis { scale: Scale::of(&of.values), title: title(of.key()), unit: of.unit().to_owned() }
}

/// The same, with space for the cells about its values.
pub fn axis_of_cells(of: &ViewAxis) -> Axis {
    Axis { scale: Scale::with_cells(&of.values), ..axis(of) }
}

/// Symbol and name of an axis or a random input of a job.
pub fn title(key: &str) -> String {
    match key {
        "preload" => "Preload Δ".to_owned(),
        "static friction" | "static_friction" => "Static friction coefficient fₛ".to_owned(),
        "rotating speed" | "rotating_speed" => "Rotating speed Ω".to_owned(),
        "relative std" => "Relative standard deviation σ".to_owned(),
        key => {
            if let Some(number) = StartValue::from_key(key) {
                return match number {
                    StartValue::Tangential => "Tangential displacement x at the start".to_owned(),
                    StartValue::Velocity => "Tangential velocity x′ at the start".to_owned(),
                    StartValue::Normal => "Normal displacement y at the start".to_owned(),
                    StartValue::Angle => "Angle φ at the start".to_owned(),
                };
            }
            scalar(key).map_or_else(
                || key.to_owned(),
                |scalar| {
                    let name = scalar.description.split(',').next().unwrap_or(scalar.description);
                    let mut letters = name.chars();
                    let first = letters.next().map(|letter| letter.to_uppercase().to_string()).unwrap_or_default();
                    format!("{first}{} {}", letters.as_str(), symbol(scalar.symbol))
                },
            )
        }
    }
}

/// A symbol of the paper in Greek letters, where it is written out.
fn symbol(text: &str) -> &str {
    match text {
        "rho" => "ρ",
        "nu" => "ν",
        "zeta" => "ζ",
        "psi" => "ψ",
        "delta" => "δ",
        "Delta" => "Δ",
        "Omega" => "Ω",
        "f_s" => "fₛ",
        "v_s" => "vₛ",
        other => other,
    }
}
