//! Verdicts on samples, and their counts.

use std::ops::{Add, AddAssign};

/// The verdict on one sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// Steady sliding persists.
    Stable,
    /// Steady sliding does not persist: the pad sticks and slips.
    Unstable,
    /// The motion was simulated as far as the settings allow without a certain verdict.
    Undecided,
    /// The computation broke down, for example by overflow or without convergence.
    Failed,
}

impl Verdict {
    /// Whether it counts towards a probability: stable or unstable.
    #[must_use]
    pub fn is_decided(self) -> bool {
        matches!(self, Self::Stable | Self::Unstable)
    }
}

/// How many samples received each verdict. Integers, so that no sum depends on its order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct VerdictCounts {
    /// Samples decided as [`Verdict::Stable`].
    pub stable: u64,
    /// Samples decided as [`Verdict::Unstable`].
    pub unstable: u64,
    /// Samples decided as [`Verdict::Undecided`].
    pub undecided: u64,
    /// Samples decided as [`Verdict::Failed`].
    pub failed: u64,
}

impl VerdictCounts {
    /// All samples, whatever their verdict.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.stable + self.unstable + self.undecided + self.failed
    }

    /// Samples that may be either stable or unstable: undecided and failed.
    #[must_use]
    pub fn without_verdict(&self) -> u64 {
        self.undecided + self.failed
    }

    /// Samples with a verdict that counts towards a probability.
    #[must_use]
    pub fn decided(&self) -> u64 {
        self.stable + self.unstable
    }
}

impl From<Verdict> for VerdictCounts {
    fn from(verdict: Verdict) -> Self {
        let mut counts = Self::default();
        match verdict {
            Verdict::Stable => counts.stable = 1,
            Verdict::Unstable => counts.unstable = 1,
            Verdict::Undecided => counts.undecided = 1,
            Verdict::Failed => counts.failed = 1,
        }
        counts
    }
}

impl Add for VerdictCounts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            stable: self.stable + other.stable,
            unstable: self.unstable + other.unstable,
            undecided: self.undecided + other.undecided,
            failed: self.failed + other.failed,
        }
    }
}

impl AddAssign for VerdictCounts {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
