//! What quantities are called in plots.

use stickslip_core::model::quantity::Quantity;

/// Name and symbol of a quantity.
pub fn title(quantity: &Quantity) -> String {
    if let Some(title) = &quantity.title {
        return title.to_string();
    }
    let name = capitalised(quantity.noun());
    if quantity.symbol == quantity.name { name } else { format!("{name} {}", symbol(&quantity.symbol)) }
}

/// A noun as the beginning of a title.
pub fn capitalised(noun: &str) -> String {
    let mut letters = noun.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// A symbol in Greek letters and with its index, where it is written out.
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
