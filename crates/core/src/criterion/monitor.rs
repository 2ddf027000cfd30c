//! When a motion has shown what it will do.
//!
//! # What stable and unstable mean
//!
//! *Stable* is a motion that comes to rest relative to steady sliding: it converges to the sliding equilibrium of the
//! model in use. *Unstable* is one that does not, because it sticks and slips for ever or because it keeps to a cycle
//! without sticking, however small. Near the equilibrium that is the same as to say that it leaves every neighbourhood
//! of steady sliding. All criteria, discs and starts share this meaning:
//!
//! * An equilibrium that is **linearly unstable** attracts nothing. Whatever the start, such a sample is unstable, and no
//!   motion needs to be followed for that (only for its settled amplitude).
//! * With a **linearly stable** equilibrium the start decides, and the motion is followed: a displacement from the
//!   equilibrium that lies outside an unstable cycle around it does not come back, however small it is.
//!
//! *Undecided* is a motion that shows neither before the horizon; *failed* one whose computation broke down.
//!
//! # How it is seen
//!
//! A monitor is told of turning points, of sticking and of release (by the integrator), and is asked to
//! look at the motion itself from time to time.
//!
//! | module | what it knows |
//! |---|---|
//! | `planar` | the monitor of a rigid disc, where motion is planar and orbits do not cross: two swings decide |
//! | `coupled` | the monitor of a flexible disc, made of the four machines below |
//! | `swings` | whether amplitudes grow or shrink from swing to swing |
//! | `cycles` | whether stick-slip comes back cycle after cycle |
//! | `settled` | the amplitude that stick-slip settles to |
//! | `transients` | how much of a change the ringing of the other degrees of freedom may feign |

use crate::degree_of_freedom::DegreeOfFreedom;
use crate::motion::integrator::Observer;
use crate::verdict::Verdict;

/// What follows from a motion so far.
pub(crate) trait Monitor: Observer + Copy {
    /// The verdict, once it is certain (and, where asked for, once the amplitude has settled).
    fn verdict(&self) -> Option<Verdict>;

    /// Whether the motion is known to be unstable, settled or not.
    fn is_unstable(&self) -> bool;

    /// The amplitude that the motion settled to, or else of its last swing: half peak to peak.
    fn amplitude(&self) -> f64;

    /// What feeds the motion, if it is unstable.
    fn fed_by(&self) -> DegreeOfFreedom;

    /// Looks at the motion itself, every [`STEPS_BETWEEN_CHECKS`] steps: without turning points there are no swings to monitor.
    fn check(&mut self, x: f64, speed: f64);
}

/// Steps from one look at a motion to the next: some ten periods of the tangential motion on a flexible disc, four on a
/// rigid one. Rare enough to cost nothing, and a motion that does not turn in this time creeps.
pub(crate) const STEPS_BETWEEN_CHECKS: u64 = 256;

/// Whether a motion is looked at after this many steps.
pub(crate) fn is_check_due(steps: u64) -> bool {
    steps.is_multiple_of(STEPS_BETWEEN_CHECKS)
}
