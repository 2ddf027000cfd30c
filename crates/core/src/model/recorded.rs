//! What models record of samples beside their verdicts.

/// Largest number of results that a model records. Every decision has room for so many: with seven, Sobol indices take twice
/// the time.
pub const MOST_RECORDED: usize = 3;

/// The recorded values of a sample, in the order of [`Model::recorded`](super::Model::recorded); `None` where it has none.
pub type RecordedValues = [Option<f64>; MOST_RECORDED];

/// Of a sample of which nothing is recorded.
pub const NOTHING: RecordedValues = [None; MOST_RECORDED];

/// A continuous result that is recorded of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordedResult {
    /// Its name in columns of results, and in job specs.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it is called within a sentence.
    pub noun: &'static str,
    /// What it is, after a comma.
    pub meaning: &'static str,
    /// Of which samples it is recorded.
    pub of: RecordedOf,
    /// Whether values are over [`Model::length_scale`](super::Model::length_scale).
    pub is_length: bool,
    /// Whether it has a mean and a variance. Of a quotient whose divisor may vanish they are infinite, and those of samples say
    /// nothing.
    pub has_mean: bool,
}

impl RecordedResult {
    /// Whether its variance can be shared out among the inputs.
    #[must_use]
    pub fn has_indices(&self) -> bool {
        self.of == RecordedOf::All && self.has_mean
    }
}

/// Of which samples a result is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordedOf {
    /// Of unstable ones.
    Unstable,
    /// Of all that have it.
    All,
}

impl RecordedOf {
    /// A sample of these, and several of them.
    #[must_use]
    pub fn nouns(self) -> [&'static str; 2] {
        match self {
            Self::Unstable => ["an unstable sample", "unstable samples"],
            Self::All => ["a sample", "samples"],
        }
    }
}
