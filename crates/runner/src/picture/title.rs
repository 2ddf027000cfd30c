//! What quantities are called in plots.

use stickslip_core::model::quantity::Quantity;

/// Name and symbol of a quantity.
pub fn title(quantity: &Quantity) -> String {
    if let Some(title) = &quantity.title {
        return title.to_string();
    }
    if let Some(name) = own_name(quantity) {
        return name.to_owned();
    }
    let name = capitalised(quantity.noun());
    if quantity.symbol == quantity.name { name } else { format!("{name} {}", symbol(&quantity.symbol)) }
}

/// What a job calls a parameter of its own, by its label or its name, which stays as it is written.
pub fn own_name(quantity: &Quantity) -> Option<&str> {
    let Quantity { name, label, symbol, description, .. } = quantity;
    let is_own = symbol == name && description == label;
    is_own.then_some(if **label == name.replace('_', " ") { &**name } else { &**label })
}

/// A noun as the beginning of a title.
pub fn capitalised(noun: &str) -> String {
    let mut letters = noun.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// A symbol in Greek letters, where it is written out. Plots set its index.
fn symbol(text: &str) -> &str {
    match text {
        "rho" => "ρ",
        "nu" => "ν",
        "zeta" => "ζ",
        "psi" => "ψ",
        "delta" => "δ",
        "Delta" => "Δ",
        "Omega" => "Ω",
        other => other,
    }
}
