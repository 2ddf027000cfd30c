//! The table `[target]` of a job spec: which probability the summary of a run answers first, and at which operating
//! point.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use super::diagnosis::{Complaint, Complaints};

/// The probability of instability that must not be reached, which the summary of a run and its report say first. The
/// surface does not depend on it.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetSpec {
    /// The probability; `--target` wins over it.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub probability: Option<Spanned<f64>>,
    /// The operating point, a value of each axis of several values: `{ preload = 0.1, static_friction = 0.4 }`. `--at`
    /// wins over it.
    #[schemars(with = "Option<serde_json::Map<String, serde_json::Value>>")]
    pub at: Option<Spanned<BTreeMap<Spanned<String>, Spanned<f64>>>>,
}

impl TargetSpec {
    /// The checked probability of the table, if there is one.
    pub fn checked(spec: Option<&Spanned<Self>>, complaints: &mut Complaints) -> Option<f64> {
        let table = spec?;
        let Some(probability) = &table.get_ref().probability else {
            let message = "missing key `probability` in [target]: which probability of instability must not be reached? For example probability = 0.05";
            complaints.push(Complaint::missing("probability", Some(table.span()), message));
            return None;
        };
        let value = *probability.get_ref();
        if 0.0 < value && value < 1.0 {
            return Some(value);
        }
        let message = format!(
            "target.probability = {value} is out of range: a probability is greater than 0 and less than 1, for example 0.05 for 5 %"
        );
        complaints.push(Complaint::at(probability.span(), message));
        None
    }
}
