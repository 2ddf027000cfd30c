//! What a criterion returns for a sample.

use crate::degree_of_freedom::DegreeOfFreedom;
use crate::verdict::Verdict;

/// What a criterion decides of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    /// The verdict.
    pub verdict: Verdict,
    /// Settled amplitude (half peak to peak of x, over h) of an unstable motion, if the settings record it.
    pub amplitude: Option<f64>,
    /// Scaled time that was simulated; 0 where linear stability decides.
    pub time: f64,
    /// What feeds an unstable motion: the tangential motion of the pad, or the degree of freedom that grows even
    /// without friction that falls with speed.
    pub fed_by: Option<DegreeOfFreedom>,
}

impl From<Verdict> for Decision {
    /// A verdict for which nothing was simulated.
    fn from(verdict: Verdict) -> Self {
        Self { verdict, amplitude: None, time: 0.0, fed_by: None }
    }
}

impl Decision {
    /// Of a sample that is stable by definition, see [`PadOnDisc::is_outside_physics`].
    ///
    /// [`PadOnDisc::is_outside_physics`]: crate::rigid_disc::pad_on_disc::PadOnDisc::is_outside_physics
    pub(crate) const OUTSIDE_PHYSICS: Self =
        Self { verdict: Verdict::Stable, amplitude: None, time: 0.0, fed_by: None };
    pub(crate) const FAILED: Self = Self { verdict: Verdict::Failed, amplitude: None, time: 0.0, fed_by: None };
}
