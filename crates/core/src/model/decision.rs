//! What a model returns for a sample.

use crate::model::recorded::{NOTHING, RecordedValues};
use crate::model::verdict::Verdict;

/// What may feed an unstable motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source {
    /// Its name in columns of results.
    pub name: &'static str,
    /// Which unstable samples are counted with it.
    pub meaning: &'static str,
}

/// What is decided of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    /// The verdict.
    pub verdict: Verdict,
    /// What is recorded of it, in the order of [`Model::recorded`](super::Model::recorded).
    pub recorded: RecordedValues,
    /// Time that was simulated, in the time scale of the model; 0 where linear stability decides.
    pub time: f64,
    /// What feeds an unstable motion, by its place in [`Model::sources`](super::Model::sources).
    pub fed_by: Option<usize>,
}

impl From<Verdict> for Decision {
    /// A verdict for which nothing was simulated.
    fn from(verdict: Verdict) -> Self {
        Self { verdict, recorded: NOTHING, time: 0.0, fed_by: None }
    }
}

impl Decision {
    /// Of a sample outside the model, which is stable by definition.
    pub(crate) const OUTSIDE_PHYSICS: Self =
        Self { verdict: Verdict::Stable, recorded: NOTHING, time: 0.0, fed_by: None };
    /// Of a sample whose computation broke down.
    pub(crate) const FAILED: Self = Self { verdict: Verdict::Failed, recorded: NOTHING, time: 0.0, fed_by: None };
}
