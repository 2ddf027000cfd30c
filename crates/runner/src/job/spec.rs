//! The job spec as TOML: one struct for each table, the source of parsing, of the JSON schema and of its texts.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::IgnoredAny;
use toml::Spanned;

use super::axes_spec::AxesSpec;
use super::engine::EngineSpec;
use super::limit_spec::LimitSpec;
use super::random_spec::RandomSpec;
use super::sampling_spec::SamplingSpec;

/// A stickslip job: the probability of instability of a model over a grid of operating points.
///
/// The tables `[model]` and `[criterion]` are read by the kind of model, see [`models`](super::models).
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JobSpec {
    /// Name of the run; its results go to runs/NAME. Letters, digits, '-', '_' and '.'.
    #[schemars(with = "String")]
    pub name: Option<Spanned<String>>,
    /// What the job is for, in a sentence.
    #[serde(default)]
    pub description: String,
    /// The model.
    #[serde(default, rename = "model")]
    #[schemars(with = "Option<serde_json::Value>")]
    _model: Option<IgnoredAny>,
    /// The grid; the job is the product of the axes. An axis that is left out has the model's one value.
    #[serde(default)]
    pub axes: AxesSpec,
    /// Which inputs scatter, and how much.
    #[serde(default)]
    pub random: RandomSpec,
    /// What decides whether a sample is stable.
    #[serde(rename = "criterion")]
    #[schemars(with = "serde_json::Value")]
    _criterion: Option<IgnoredAny>,
    /// How many samples are drawn, and how.
    #[serde(default)]
    pub sampling: SamplingSpec,
    /// Which limits are sought along an axis.
    #[schemars(with = "Option<LimitSpec>")]
    pub limit: Option<Spanned<LimitSpec>>,
    /// What a cluster is asked for.
    #[serde(default)]
    pub engine: EngineSpec,
}
