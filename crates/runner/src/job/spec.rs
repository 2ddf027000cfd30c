//! The job spec as TOML: one struct for each table, which declares its keys once. From it come parsing, the JSON schema, the
//! reference page, the job written out in full and its identity.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Spanned;

use super::axes_spec::AxesSpec;
use super::limit_spec::LimitSpec;
use super::random_spec::RandomSpec;
use super::sampling_spec::SamplingSpec;
use super::target_spec::TargetSpec;

/// A stickslip job: the probability of instability of a model over a grid of operating points.
///
/// The tables `[model]` and `[criterion]` are read by the kind of model, see [`models`](super::models).
#[derive(Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JobSpec {
    /// Name of the run; its results go to `runs/NAME`. 1 to 100 letters, digits, `-`, `_` and `.`, not starting with
    /// `.`.
    #[schemars(with = "String")]
    pub name: Option<Spanned<String>>,
    /// What the job is for, in a sentence.
    pub description: Option<String>,
    /// What is computed: the model and its values.
    #[schemars(with = "Option<serde_json::Value>")]
    pub model: Option<toml::Value>,
    /// The grid: the job is the product of the axes. An axis that is left out has the model's one value.
    #[serde(default)]
    #[schemars(extend("default" = {}))]
    pub axes: AxesSpec,
    /// Which inputs scatter, and how.
    #[serde(default)]
    #[schemars(extend("default" = {}))]
    pub random: RandomSpec,
    /// What decides whether a sample is stable.
    #[schemars(with = "serde_json::Value")]
    pub criterion: Option<toml::Value>,
    /// How the probability is found.
    #[serde(default)]
    #[schemars(extend("default" = {}))]
    pub sampling: SamplingSpec,
    /// Which limits are sought along an axis. The surface does not depend on it.
    #[serde(skip_serializing)]
    #[schemars(with = "Option<LimitSpec>")]
    pub limit: Option<Spanned<LimitSpec>>,
    /// Which probability the summary of a run answers first. The surface does not depend on it.
    #[serde(skip_serializing)]
    #[schemars(with = "Option<TargetSpec>")]
    pub target: Option<Spanned<TargetSpec>>,
}
