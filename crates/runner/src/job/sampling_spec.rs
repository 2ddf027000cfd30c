//! The sampling keys of a job spec as written.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Spanned;

/// Samples of each cell that are looked up in a verdict map and simulated all the same, unless told otherwise.
pub const AUDIT: Audit = Audit::Samples(300);

/// Sampling of the random inputs.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SamplingSpec {
    /// How probabilities are found; "monte-carlo" unless told.
    #[schemars(with = "Option<SamplingMethod>")]
    pub method: Option<Spanned<SamplingMethod>>,
    /// Samples in each cell, at least 1; 10000 unless told.
    #[schemars(with = "Option<u64>", range(min = 1))]
    pub samples: Option<Spanned<u64>>,
    /// Instead of `samples`: draw until the interval is narrow enough.
    #[schemars(with = "Option<UntilSpec>")]
    pub until: Option<Spanned<UntilSpec>>,
    /// Seed of the random numbers, 0 unless told. The same seed gives the same result on every machine.
    #[schemars(with = "Option<u64>")]
    pub seed: Option<Spanned<u64>>,
    /// Whether every sample is judged by itself ("each") or looked up in a map of the verdicts ("boundary").
    #[schemars(with = "Option<EvaluateMode>")]
    pub evaluate: Option<Spanned<EvaluateMode>>,
    /// With a verdict map: how many looked-up samples of each cell are simulated all the same (a whole number), or
    /// which share of them (less than 1, with evaluate = "boundary"); 300 unless told.
    #[schemars(with = "Option<Audit>")]
    pub audit: Option<Spanned<Audit>>,
    /// With method = "sobol": independent randomisations among which the samples are shared; 16 unless told.
    #[schemars(with = "Option<u64>", range(min = 2))]
    pub randomisations: Option<Spanned<u64>>,
    /// Whether all cells draw the same deviates; false unless told.
    #[serde(default)]
    pub common_random_numbers: bool,
    /// Confidence of the interval p_low to p_high, between 0 and 1; 0.95 unless told.
    #[schemars(with = "Option<f64>")]
    pub confidence: Option<Spanned<f64>>,
    /// The interval of Monte Carlo; "wilson" unless told, "clopper-pearson" where the confidence is above 0.95 or
    /// simultaneous.
    #[schemars(with = "Option<IntervalSpec>")]
    pub interval: Option<Spanned<IntervalSpec>>,
    /// Whether the intervals of all cells hold together with the confidence; false unless told.
    #[schemars(with = "Option<bool>")]
    pub simultaneous: Option<Spanned<bool>>,
    /// Whether the derivatives of the probability are written, as further columns; false unless told.
    #[schemars(with = "Option<bool>")]
    pub derivatives: Option<Spanned<bool>>,
    /// Whether first-order and total Sobol indices of the inputs are written, as further columns; false unless told.
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
    /// Confidence of the interval; 0.95 unless told.
    pub confidence: Option<f64>,
    /// Samples in a cell at the most; 1000000 unless told. It can be raised later.
    pub at_most: Option<u64>,
}

/// Which of the samples that a verdict map tells are simulated all the same.
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
    /// Whether none is.
    pub fn is_nothing(self) -> bool {
        matches!(self, Self::Samples(0)) || self == Self::Share(0.0)
    }
}

/// How probabilities are found.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SamplingMethod {
    /// Independent samples.
    #[default]
    MonteCarlo,
    /// Scrambled Sobol points.
    Sobol,
    /// The normal measure of the unstable side of the boundary.
    Exact,
}

/// Which samples are judged.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EvaluateMode {
    /// Every sample by itself.
    #[default]
    Each,
    /// Those within the resolution of a map of the verdicts; the others are looked up in it.
    Boundary,
}

/// An interval for counted verdicts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum IntervalSpec {
    /// Wilson's score interval: right on average.
    #[default]
    Wilson,
    /// Clopper and Pearson's: never less than the confidence, and wider.
    ClopperPearson,
}
