//! The keys of `[sampling]` that have a meaning with some methods only.

use std::ops::Range;

use toml::Spanned;

use super::sampling_spec::SamplingSpec;

/// A key of `[sampling]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// `samples`.
    Samples,
    /// `until`.
    Until,
    /// `evaluate`.
    Evaluate,
    /// `audit`; of methods that look samples up, only with `evaluate = "boundary"`.
    Audit,
    /// `randomisations`.
    Randomisations,
    /// `particles`.
    Particles,
    /// `common_random_numbers`.
    CommonRandomNumbers,
    /// `confidence`.
    Confidence,
    /// `interval`.
    Interval,
    /// `simultaneous`.
    Simultaneous,
    /// `derivatives`.
    Derivatives,
    /// `sensitivity`.
    Sensitivity,
}

impl Key {
    /// All of them.
    pub const ALL: [Self; 12] = [
        Self::Samples,
        Self::Until,
        Self::Evaluate,
        Self::Audit,
        Self::Randomisations,
        Self::Particles,
        Self::CommonRandomNumbers,
        Self::Confidence,
        Self::Interval,
        Self::Simultaneous,
        Self::Derivatives,
        Self::Sensitivity,
    ];

    /// Its name, and where a job gives it.
    pub fn given(self, spec: &SamplingSpec) -> (&'static str, Option<Range<usize>>) {
        fn span<T>(value: &Option<Spanned<T>>) -> Option<Range<usize>> {
            value.as_ref().map(Spanned::span)
        }
        let wanted = |value: &Option<Spanned<bool>>| span(value).filter(|_| is_true(value));
        match self {
            Self::Samples => ("samples", span(&spec.samples)),
            Self::Until => ("until", span(&spec.until)),
            Self::Evaluate => ("evaluate", span(&spec.evaluate)),
            Self::Audit => ("audit", span(&spec.audit)),
            Self::Randomisations => ("randomisations", span(&spec.randomisations)),
            Self::Particles => ("particles", span(&spec.particles)),
            Self::CommonRandomNumbers => ("common_random_numbers", wanted(&spec.common_random_numbers)),
            Self::Confidence => ("confidence", span(&spec.confidence)),
            Self::Interval => ("interval", span(&spec.interval)),
            Self::Simultaneous => ("simultaneous", span(&spec.simultaneous)),
            Self::Derivatives => ("derivatives", wanted(&spec.derivatives)),
            Self::Sensitivity => ("sensitivity", wanted(&spec.sensitivity)),
        }
    }
}

/// Whether a key says yes.
pub fn is_true(value: &Option<Spanned<bool>>) -> bool {
    value.as_ref().is_some_and(|value| *value.get_ref())
}
