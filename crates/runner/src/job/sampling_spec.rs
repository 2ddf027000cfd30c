//! The sampling keys of a job spec as written.

use clap::ValueEnum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Spanned;

/// Audited samples of each cell by default.
pub const AUDIT: Audit = Audit::Samples(300);

/// The fewest plain samples beside a probability by default.
pub const LEAST_PLAIN_SAMPLES: u64 = 300;

/// The same where a sample takes long.
pub const FEW_PLAIN_SAMPLES: u64 = 16;

/// The most plain samples beside a probability by default.
pub const MOST_PLAIN_SAMPLES: u64 = 1_000_000;

/// Sampling of the random inputs.
#[derive(Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SamplingSpec {
    /// How probabilities are found.
    #[schemars(with = "Option<SamplingMethod>", extend("default" = SamplingMethod::default()))]
    pub method: Option<Spanned<SamplingMethod>>,
    /// Samples in each cell; with `"sobol"`, `"conditional"` and `"importance"` at most 2^32 for each randomisation.
    #[schemars(with = "Option<u64>", range(min = 1, max = 1_000_000_000_000_000_u64), extend("default" = 10_000))]
    pub samples: Option<Spanned<u64>>,
    /// In place of `samples`: draw until the interval is narrow enough.
    #[schemars(with = "Option<UntilSpec>")]
    pub until: Option<Spanned<UntilSpec>>,
    /// Seed of the random numbers: the same seed gives the same result on every machine. Use at most 2^63 - 1: TOML
    /// promises no more, and `--seed` takes no more.
    #[schemars(with = "Option<u64>", range(min = 0, max = u64::MAX), extend("default" = 0))]
    pub seed: Option<Spanned<u64>>,
    /// How the verdict of a sample is found.
    #[schemars(with = "Option<EvaluateMode>", extend("default" = EvaluateMode::default()))]
    pub evaluate: Option<Spanned<EvaluateMode>>,
    /// Whether all cells draw the same deviates, which makes their differences less noisy.
    #[schemars(with = "Option<bool>", extend("default" = false))]
    pub common_random_numbers: Option<Spanned<bool>>,
    /// Confidence of the interval `p_low` to `p_high`.
    #[schemars(with = "Option<f64>", extend("default" = 0.95, "exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub confidence: Option<Spanned<f64>>,
    /// Samples of each cell that check a probability, 0 or from 2 to 1e8: with a verdict map looked-up ones that are
    /// simulated as well (with `evaluate = "boundary"` also as a share, 0.0 to 1.0), else plain ones (by default a tenth
    /// of the samples that the probability comes from, at least 300, or 16 where one takes more than some 10 ms, and at
    /// most a million).
    #[schemars(with = "Option<Audit>", extend("default" = AUDIT))]
    pub audit: Option<Spanned<Audit>>,
    /// Independent randomisations that share the samples, at least 8 with `"importance"`; with `"subset"` independent
    /// populations.
    #[schemars(with = "Option<u64>", range(min = 2, max = 1000), extend("default" = 16))]
    pub randomisations: Option<Spanned<u64>>,
    /// Particles of a population, by default 300 with `"importance"` and 1000 with `"subset"`.
    #[schemars(with = "Option<u64>", range(min = 50, max = 100_000))]
    pub particles: Option<Spanned<u64>>,
    /// The interval of counted verdicts.
    #[schemars(with = "Option<IntervalSpec>", extend("default" = IntervalSpec::default()))]
    pub interval: Option<Spanned<IntervalSpec>>,
    /// Whether the intervals of all cells hold together with the confidence.
    #[schemars(with = "Option<bool>", extend("default" = false))]
    pub simultaneous: Option<Spanned<bool>>,
    /// Whether slopes of the probability are written.
    #[schemars(with = "Option<bool>", extend("default" = false))]
    pub derivatives: Option<Spanned<bool>>,
    /// Whether first-order and total Sobol indices of the inputs are written.
    #[schemars(with = "Option<bool>", extend("default" = false))]
    pub sensitivity: Option<Spanned<bool>>,
}

/// When enough samples are drawn: half_width or relative is given, or both; then the first that is reached.
#[derive(Debug, Clone, Deserialize, Serialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a table, for example until = { half_width = 0.005 } or until = { relative = 0.05 }"
)]
pub struct UntilSpec {
    /// Half of the width of `p_low` to `p_high`. This key or `relative` is required; with both, the first that is
    /// reached counts.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 0.5))]
    pub half_width: Option<f64>,
    /// The same over the middle of the interval.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub relative: Option<f64>,
    /// Confidence of the interval.
    #[schemars(extend("default" = 0.95, "exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub confidence: Option<f64>,
    /// Most samples in a cell; it can be raised later.
    #[schemars(range(min = 1, max = 1_000_000_000_000_000_u64), extend("default" = 1_000_000))]
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
    /// An integral over preload and static friction, of matrices over the friction parameter, at samples of the other inputs.
    Conditional,
    /// Weighted points from where instability is frequent, for rare events.
    Importance,
    /// Populations that are led to the rare event.
    Subset,
    /// An integral over the unstable side of the boundary.
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
    /// Each sample is decided by itself.
    #[default]
    Each,
    /// Looked up in a map of verdicts; samples within its resolution are simulated.
    Boundary,
}

/// An interval for counted verdicts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum IntervalSpec {
    /// Wilson's score interval, whose coverage is right on average.
    #[default]
    Wilson,
    /// Clopper and Pearson's, whose coverage is never below the confidence.
    ClopperPearson,
}
