//! When the verdict on a motion is certain.
//!
//! The integrator reports turning points, sticks and releases to a monitor, which also checks displacement and speed at
//! intervals.
//!
//! | module | contents |
//! |---|---|
//! | `rigid_monitor` | the monitor of a rigid disc, where motion is planar and orbits do not cross: two swings decide |
//! | `flexible_monitor` | the monitor of a flexible disc, made of the four state machines below |
//! | `swings` | whether amplitudes grow or shrink from swing to swing |
//! | `cycles` | whether stick-slip persists from cycle to cycle |
//! | `confirmation` | finer steps for a motion whose verdict may depend on errors of the steps |
//! | `settled_amplitude` | the amplitude to which stick-slip settles |
//! | `transients` | how large a change of amplitude the ringing of the other degrees of freedom can imitate |

use crate::model::verdict::Verdict;
use crate::models::pad_on_disc::degree_of_freedom::DegreeOfFreedom;
use crate::models::pad_on_disc::motion::integrator::Observer;

/// Decides a motion while it is simulated.
pub(crate) trait Monitor: Observer + Copy {
    /// The verdict, once it is certain (and once the amplitude has settled, if that is wanted).
    fn verdict(&self) -> Option<Verdict>;

    /// Whether the motion is known to be unstable, settled or not.
    fn is_unstable(&self) -> bool;

    /// The amplitude that the motion settled to, or else of its last swing: half peak to peak.
    fn amplitude(&self) -> f64;

    /// Whether its verdict may depend on errors of the steps.
    fn is_doubtful(&self) -> bool {
        false
    }

    /// What feeds the motion, if it is unstable.
    fn fed_by(&self) -> DegreeOfFreedom;

    /// The motion has taken as many substeps as it may, and is at `x` with this speed. What is known of its fate without
    /// simulating it is the verdict.
    fn is_exhausted(&mut self, _x: f64, _speed: f64) {}

    /// Checks displacement and speed, every [`STEPS_BETWEEN_CHECKS`] steps: a motion without turning points has no
    /// swings.
    fn check(&mut self, x: f64, speed: f64);
}

/// Steps from one check to the next: some ten periods of the tangential motion on a flexible disc, four on a rigid one.
/// Checks are so rare that they cost nothing, and a motion that does not turn in this time creeps.
pub(crate) const STEPS_BETWEEN_CHECKS: u64 = 256;

/// Whether a motion is checked after this many steps.
#[inline]
pub(crate) fn is_check_due(steps: u64) -> bool {
    steps.is_multiple_of(STEPS_BETWEEN_CHECKS)
}
