//! The keys of `[sampling]` that have a meaning with some methods only.

use std::ops::Range;

use toml::Spanned;

use super::{ALL, Method};
use crate::job::diagnosis::Complaint;
use crate::job::sampling_spec::{EvaluateMode, SamplingSpec};

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
    const ALL: [Self; 12] = [
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
    fn given(self, spec: &SamplingSpec) -> (&'static str, Option<Range<usize>>) {
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
            Self::CommonRandomNumbers => ("common_random_numbers", None),
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

impl SamplingSpec {
    /// The keys that have no meaning with the method of the job.
    pub fn foreign_keys(&self, method: &'static dyn Method) -> Vec<Complaint> {
        let foreign = |key: &Key| {
            let (name, span) = key.given(self);
            let span = span?;
            let option = if *key == Key::Samples { " (or --samples)" } else { "" };
            if !method.takes(*key) {
                let (asked, clause, instead) = (method.asked(), method.clause(), takers(*key, method));
                let message =
                    format!("sampling.{name} has no meaning with {asked}, {clause}; remove it{option}, or {instead}");
                return Some(Complaint::at(span, message));
            }
            let is_of_lookups = *key == Key::Audit && method.takes(Key::Evaluate);
            (is_of_lookups && self.evaluate_mode() != EvaluateMode::Boundary).then(|| {
                let message = "sampling.audit belongs to evaluate = \"boundary\" and to method = \"exact\"; remove it, or change one of these";
                Complaint::at(span, message)
            })
        };
        Key::ALL.iter().filter_map(foreign).collect()
    }
}

/// What to do for a key to have a meaning.
fn takers(key: Key, method: &dyn Method) -> String {
    let mut takers: Vec<_> = ALL.iter().filter(|taker| taker.takes(key)).map(|taker| taker.written()).collect();
    takers.dedup();
    if takers.contains(&method.written()) {
        return format!("remove {}", method.asked());
    }
    let names: Vec<String> = takers.iter().map(|taker| format!("\"{}\"", taker.name())).collect();
    format!("use method = {}", names.join(" or "))
}
