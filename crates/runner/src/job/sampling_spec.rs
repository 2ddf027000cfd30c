//! The sampling keys of a job spec as written.

use clap::ValueEnum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Spanned;

/// Audited samples of each cell by default.
pub const AUDIT: Audit = Audit::Samples(300);

/// Sampling of the random inputs.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SamplingSpec {
    /// How probabilities are found; by default "monte-carlo".
    #[schemars(with = "Option<SamplingMethod>")]
    pub method: Option<Spanned<SamplingMethod>>,
    /// Samples in each cell, at least 1; by default 10000.
    #[schemars(with = "Option<u64>", range(min = 1))]
    pub samples: Option<Spanned<u64>>,
    /// Instead of `samples`: draw until the interval is narrow enough.
    #[schemars(with = "Option<UntilSpec>")]
    pub until: Option<Spanned<UntilSpec>>,
    /// Seed of the random numbers; by default 0. The same seed gives the same result on every machine.
    #[schemars(with = "Option<u64>")]
    pub seed: Option<Spanned<u64>>,
    /// Whether every sample is simulated ("each") or looked up in a map of the verdicts ("boundary"); by default
    /// "each".
    #[schemars(with = "Option<EvaluateMode>")]
    pub evaluate: Option<Spanned<EvaluateMode>>,
    /// With a verdict map: how many looked-up samples of each cell are simulated as a check (a whole number), or which
    /// share of them (less than 1, with evaluate = "boundary"); by default 300.
    #[schemars(with = "Option<Audit>")]
    pub audit: Option<Spanned<Audit>>,
    /// With method = "sobol", "conditional" or "importance": independent randomisations among which the samples are shared;
    /// with "subset": independent populations; by default 16.
    #[schemars(with = "Option<u64>", range(min = 2))]
    pub randomisations: Option<Spanned<u64>>,
    /// With method = "importance" or "subset": particles of a population; by default 300 and 1000.
    #[schemars(with = "Option<u64>", range(min = 50, max = 100_000))]
    pub particles: Option<Spanned<u64>>,
    /// Whether all cells draw the same deviates; by default false.
    #[serde(default)]
    pub common_random_numbers: bool,
    /// Confidence of the interval p_low to p_high, between 0 and 1; by default 0.95.
    #[schemars(with = "Option<f64>")]
    pub confidence: Option<Spanned<f64>>,
    /// The interval of Monte Carlo; by default "wilson", "clopper-pearson" where the confidence is above 0.95 or
    /// simultaneous.
    #[schemars(with = "Option<IntervalSpec>")]
    pub interval: Option<Spanned<IntervalSpec>>,
    /// Whether the intervals of all cells hold together with the confidence; by default false.
    #[schemars(with = "Option<bool>")]
    pub simultaneous: Option<Spanned<bool>>,
    /// Whether the derivatives of the probability are written, as further columns; by default false.
    #[schemars(with = "Option<bool>")]
    pub derivatives: Option<Spanned<bool>>,
    /// Whether first-order and total Sobol indices of the inputs are written, as further columns; by default false.
    #[schemars(with = "Option<bool>")]
    pub sensitivity: Option<Spanned<bool>>,
}

/// When enough samples are drawn: half_width or relative is given, or both; then the first that is reached.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a table, for example until = { half_width = 0.005 } or until = { relative = 0.05 }"
)]
pub struct UntilSpec {
    /// Half of the width of the interval that is wanted, greater than 0 and less than 0.5.
    pub half_width: Option<f64>,
    /// The same over the middle of the interval, greater than 0 and less than 1.
    pub relative: Option<f64>,
    /// Confidence of the interval; by default 0.95.
    pub confidence: Option<f64>,
    /// Largest number of samples in a cell; by default 1000000. It can be raised later.
    pub at_most: Option<u64>,
}

/// The audit of a verdict map: which of the looked-up samples are simulated as a check.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "sampling.audit is a whole number of samples of each cell, for example 300, or a share of the looked-up samples, for example 0.01"
)]
pub enum Audit {
    /// The first so many of each cell.
    Samples(u64),
    /// A share of all.
    Share(f64),
}

impl Audit {
    /// Whether there is no audit.
    pub fn is_nothing(self) -> bool {
        matches!(self, Self::Samples(0)) || self == Self::Share(0.0)
    }
}

/// How probabilities are found.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SamplingMethod {
    /// Independent samples.
    #[default]
    MonteCarlo,
    /// Scrambled Sobol points.
    Sobol,
    /// Scrambled Sobol points of all inputs but preload and static friction, over which it integrates at each of them.
    Conditional,
    /// Scrambled Sobol points of a density that is found for each cell, with weights, for rare events.
    Importance,
    /// Populations of samples that are led to rare events step by step.
    Subset,
    /// The probability of the unstable side of the boundary.
    Exact,
}

impl SamplingMethod {
    /// As written.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

/// How the verdict of a sample is found.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EvaluateMode {
    /// Every sample is simulated.
    #[default]
    Each,
    /// Looked up in a map of the verdicts; only samples within its resolution are simulated.
    Boundary,
}

/// An interval for counted verdicts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum IntervalSpec {
    /// Wilson's score interval, whose coverage is right on average.
    #[default]
    Wilson,
    /// Clopper and Pearson's, which is wider and covers at least with the confidence.
    ClopperPearson,
}
