//! Values of the parameters as a job spec gives them.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};
use stickslip_core::model::quantity::Limits;
use stickslip_core::models::pad_on_disc::parameters::SCALARS;
use toml::Spanned;

use super::preload_force;

/// Values of one section of the parameters, by name.
pub type Overrides = BTreeMap<Spanned<String>, Spanned<f64>>;

/// The JSON schema of a number within limits.
pub fn number_within(limits: Limits, description: &str) -> Value {
    let lower = if limits.includes_minimum { "minimum" } else { "exclusiveMinimum" };
    let upper = if limits.includes_maximum { "maximum" } else { "exclusiveMaximum" };
    json!({ "type": "number", lower: limits.minimum, upper: limits.maximum, "description": description })
}

/// The numbers of one section, from the parameter list of the core.
pub fn section_properties(section: &str) -> Map<String, Value> {
    let mut properties = Map::new();
    for scalar in SCALARS.iter().filter(|scalar| scalar.section() == section) {
        let description = format!("{} ({}), unit {}", scalar.description, scalar.symbol, scalar.unit);
        properties.insert(scalar.name().to_owned(), number_within(scalar.limits, &description));
    }
    if let Some((_, name)) = preload_force::KEY.split_once('.').filter(|(of, _)| *of == section) {
        let description = "contact force in place of the preload, unit N";
        properties.insert(name.to_owned(), json!({ "type": "number", "minimum": 0.0, "description": description }));
    }
    properties
}
