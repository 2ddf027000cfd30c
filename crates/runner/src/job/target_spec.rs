//! The table `[target]` of a job spec: which probability the summary of a run answers first.

use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use super::diagnosis::{Complaint, Complaints};

/// The probability of instability that must not be reached, which the summary of a run says first. The surface does not
/// depend on it.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetSpec {
    /// The probability, above 0 and below 1. `--target` of `submit` wins over it.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub probability: Option<Spanned<f64>>,
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
