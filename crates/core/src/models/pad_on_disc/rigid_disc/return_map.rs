//! The tangential motion on a rigid disc as a return map.
//!
//! Slip is a plane autonomous system,
//!
//! ```text
//! x'' = G mu(v - x') - K x - C x',        x' < v
//! ```
//!
//! whose orbits do not cross. On the section `x' = 0`, `x = x0 + a`, `a > 0` (the largest x of a swing) a motion
//! returns with another amplitude `R(a)`, and R grows with a. That decides motions that change too slowly to simulate:
//!
//! * A swing longer than the one before is followed by longer ones only; a shorter one by shorter ones.
//! * A shrinking motion comes to rest exactly if `R(s) < s` for all smaller amplitudes s. If some `R(s) >= s`, a limit
//!   cycle lies between, and the motion never gets inside it.
//! * Where no stable cycle can lie inside a swing ([`inner_cycles`](crate::models::pad_on_disc::rigid_disc::inner_cycles)), one that shrinks
//!   decides by itself.
//! * The energy `u^2/2 + K (x - x0)^2/2` of a motion with speeds up to U falls as long as
//!   `C > [G mu(v - u) - G mu(v)] / u` for all `|u| <= U`: such a motion comes to rest, however slowly.
//!
//! The motions are those of [`crate::models::pad_on_disc::rigid_disc::planar_motion`]. The fixed steps of the time-domain criterion are
//! tested against them, and the criterion uses the return map for motions on a rigid disc that change too slowly.

use crate::models::pad_on_disc::rigid_disc::inner_cycles::Turns;
use crate::models::pad_on_disc::rigid_disc::planar_motion::{PlanarMotion, Slip, SlipEnd};
use crate::numerics::root_location::{bisect, rise_to_zero};

/// Ratio of neighbouring amplitudes in a scan. Between them the change over a cycle is taken to have one extremum at
/// the most; that one is searched for.
const SCAN_RATIO: f64 = 0.9;

/// The first step of a scan: it shows whether the change rises inwards, to a maximum before the next amplitude.
const FIRST_RATIO: f64 = 0.999;

/// Largest number of amplitudes scanned: down to 1e-7 of the first.
const MOST_SCANNED: usize = 160;

/// Changes over a cycle, relative to the amplitude, that are lost in the errors of the method.
const UNRESOLVED: f64 = 1e-10;

/// Distances from steady sliding, relative to x0, that are lost in rounding.
const ROUNDING: f64 = 1e-14;

/// How far from a cycle, relative to its amplitude, swings show whether it attracts.
const BESIDE: f64 = 1e-6;

/// How close the widest swing that does not come to the disc's speed is located, relative to it.
const GRAZES: f64 = 1e-6;

/// How near the change over a cycle must come to that of the linearised motion, for smaller amplitudes to change like
/// it too.
const LINEAR: f64 = 0.01;

/// A limit cycle without sticking: its largest x, and the swing from there to there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SlidingCycle {
    pub top: f64,
    pub swing: Slip,
}

/// What happens to a motion whose swings shrink, or grow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Fate {
    /// It comes to rest relative to steady sliding.
    Equilibrium,
    /// Its swings grow from this amplitude; [`PlanarMotion::settles`] finds what they grow to.
    Grows { from: f64 },
    /// A limit cycle without sticking lies between these amplitudes, and the motion outside it.
    Trapped { inner: f64, outer: f64 },
    /// A limit cycle without sticking; half of its peak-to-peak displacement.
    SmoothCycle { amplitude: f64 },
    /// It reaches the disc's speed.
    Captured,
    /// It overtakes the disc in every cycle.
    Overtakes,
    /// Not resolved.
    Unresolved,
}

impl PlanarMotion {
    /// One return, from the amplitude `a` > 0.
    fn swing(&self, a: f64) -> Slip {
        self.slip([self.equilibrium() + a, 0.0], a)
    }

    /// `ln(R(a) / a)`; infinite where the pad is captured, minus infinity where it comes to rest within the swing.
    fn change(&self, a: f64) -> f64 {
        self.change_and_bottom(a).0
    }

    /// The same, with the amplitude on the other side.
    fn change_and_bottom(&self, a: f64) -> (f64, f64) {
        let swing = self.swing(a);
        let change = match swing.end {
            // A pad that creeps to rest may turn by rounding alone.
            SlipEnd::Turned if self.rests_at(swing.x) => f64::NEG_INFINITY,
            SlipEnd::Turned => libm::log((swing.x - self.equilibrium()) / a),
            SlipEnd::Captured => f64::INFINITY,
            SlipEnd::Equilibrium => f64::NEG_INFINITY,
            SlipEnd::Unresolved => f64::NAN,
        };
        (change, self.equilibrium() - swing.smallest)
    }

    /// The change of small amplitudes over a cycle; minus infinity where they do not oscillate.
    fn linear_change(&self) -> f64 {
        let damping = self.damping_at_equilibrium();
        let square = self.stiffness - 0.25 * damping * damping;
        if square > 0.0 { -std::f64::consts::PI * damping / square.sqrt() } else { f64::NEG_INFINITY }
    }

    /// The fate of a motion that has turned at `x0 + a`, `a` > 0.
    pub fn fate_of_swing(&self, a: f64) -> Fate {
        if self.rests_at(self.equilibrium() + a) {
            return Fate::Equilibrium;
        }
        let (change, bottom) = self.change_and_bottom(a);
        if change.is_nan() {
            Fate::Unresolved
        } else if change.abs() <= UNRESOLVED {
            self.fate_on_cycle(a)
        } else if change > 0.0 {
            Fate::Grows { from: a }
        } else if change == f64::NEG_INFINITY {
            Fate::Equilibrium
        } else {
            self.fate_of_shrinking(a, change, bottom)
        }
    }

    /// Whether a motion that turns at `x` is at rest, to all digits.
    fn rests_at(&self, x: f64) -> bool {
        let distance = x - self.equilibrium();
        distance <= ROUNDING * self.equilibrium().abs() && self.comes_to_rest(x, 0.0)
    }

    /// The fate of a motion that turns at `x0 + a` and, as far as is resolved, does so again. If swings a little wider
    /// shrink and those a little narrower grow, it stays between them for ever, since orbits do not cross.
    fn fate_on_cycle(&self, a: f64) -> Fate {
        let (inner, outer) = (a * (1.0 - BESIDE), a * (1.0 + BESIDE));
        let is_attracting = self.change(inner) > UNRESOLVED && self.change(outer) < -UNRESOLVED;
        if is_attracting { Fate::Trapped { inner, outer } } else { Fate::Unresolved }
    }

    /// The fate of a motion released from stick.
    pub fn fate_of_release(&self) -> Fate {
        self.fate_from([self.release(), self.disc_speed])
    }

    /// The fate of a motion in a state of slip, up to its first capture.
    pub fn fate_from(&self, state: [f64; 2]) -> Fate {
        let size = self.size_of(state);
        if self.is_clearly_caught(state, size, |x| self.meets_slowly_if_rough(x)) {
            return Fate::Captured;
        }
        let first = self.slip(state, size);
        match first.end {
            SlipEnd::Captured => Fate::Captured,
            SlipEnd::Equilibrium => Fate::Equilibrium,
            SlipEnd::Unresolved => Fate::Unresolved,
            SlipEnd::Turned => match self.slip([first.x, 0.0], size).end {
                SlipEnd::Captured => Fate::Captured,
                SlipEnd::Equilibrium => Fate::Equilibrium,
                SlipEnd::Unresolved => Fate::Unresolved,
                SlipEnd::Turned => self.fate_of_swing(first.x - self.equilibrium()),
            },
        }
    }

    /// The fate of a motion that shrinks at the amplitude `a`: is there a smaller one at which it does not?
    fn fate_of_shrinking(&self, a: f64, change: f64, mut bottom: f64) -> Fate {
        let linear = self.linear_change();
        let mut scanned = vec![(a, change)];
        let mut near_linear = 0;
        while scanned.len() < MOST_SCANNED {
            let (outer, before) = scanned[scanned.len() - 1];
            if self.has_no_cycle_inside(Turns { top: outer, bottom, next_top: outer * libm::exp(before) }) {
                return Fate::Equilibrium;
            }
            if self.damping_at_equilibrium() > 0.0 && self.comes_to_rest_from(self.stiffness.sqrt() * outer) {
                return Fate::Equilibrium;
            }
            let inner = if scanned.len() == 1 { FIRST_RATIO } else { SCAN_RATIO } * outer;
            let change;
            (change, bottom) = self.change_and_bottom(inner);
            if change.is_nan() {
                return Fate::Unresolved;
            }
            if change >= 0.0 {
                return Fate::Trapped { inner, outer };
            }
            if change == f64::NEG_INFINITY {
                return Fate::Equilibrium;
            }
            scanned.push((inner, change));
            // A maximum of the change among the last three amplitudes: does it reach zero between them?
            if let [.., (first, at_first), _, _] = scanned[..]
                && before > change
                && before >= at_first
                && let Some(growing) = rise_to_zero((inner, first), UNRESOLVED, |a| self.change(a))
            {
                return Fate::Trapped { inner: growing, outer: first };
            }
            let is_linear = (change - linear).abs() <= LINEAR * linear.abs() && self.is_smooth_within(inner);
            near_linear = if is_linear { near_linear + 1 } else { 0 };
            if near_linear == 2 {
                return if linear < 0.0 { Fate::Equilibrium } else { Fate::Unresolved };
            }
        }
        Fate::Unresolved
    }

    /// Whether there is a limit cycle without sticking, be it inside one that sticks; `None` where that is not resolved.
    pub fn has_cycle_without_sticking(&self) -> Option<bool> {
        // With these laws none outlasts stick-slip, and where steady sliding is unstable all swings grow.
        if self.law.is_completely_monotone() {
            return Some(false);
        }
        let fate = match self.fate_of_release() {
            Fate::Captured | Fate::Overtakes => self.fate_inside_release(),
            fate => fate,
        };
        match fate {
            Fate::Trapped { .. } | Fate::SmoothCycle { .. } => Some(true),
            Fate::Equilibrium | Fate::Captured => Some(false),
            Fate::Grows { .. } | Fate::Overtakes | Fate::Unresolved => None,
        }
    }

    /// What the swings come to that lie inside a motion which is captured after its release: the outermost limit cycle
    /// without sticking if there is one, else rest, or capture where all of them grow.
    fn fate_inside_release(&self) -> Fate {
        let state = [self.release(), self.disc_speed];
        let size = self.size_of(state);
        let first = self.slip(state, size);
        let widest = match first.end {
            SlipEnd::Turned => first.x - self.equilibrium(),
            // It comes to the disc's speed again before it turns, and so do all swings that are as wide as the whole of it.
            SlipEnd::Captured if self.swing(size).end == SlipEnd::Captured => size,
            _ => return Fate::Unresolved,
        };
        let turns = |a: f64| self.swing(a).end != SlipEnd::Captured;
        // Narrower ones are not asked: about an unstable node they turn by rounding alone.
        let narrow = GRAZES * widest;
        if turns(narrow) { self.fate_inside(bisect((narrow, widest), 60, GRAZES, turns).0) } else { Fate::Captured }
    }

    /// The same for the swings up to this amplitude.
    fn fate_inside(&self, outermost: f64) -> Fate {
        let linear = self.linear_change();
        let mut scanned: Vec<(f64, f64)> = Vec::new();
        let (mut near_linear, mut a) = (0, outermost);
        while scanned.len() < MOST_SCANNED {
            let (change, bottom) = self.change_and_bottom(a);
            if change.is_nan() {
                return Fate::Unresolved;
            }
            if change == f64::NEG_INFINITY {
                return Fate::Equilibrium;
            }
            if change < 0.0 {
                return self.fate_of_shrinking(a, change, bottom);
            }
            scanned.push((a, change));
            // A minimum of the change among the last three amplitudes: does it fall to zero between them?
            if let [.., (first, at_first), (_, before), (last, _)] = scanned[..]
                && before < change
                && before <= at_first
                && let Some(shrinking) = rise_to_zero((last, first), UNRESOLVED, |a| -self.change(a))
            {
                return Fate::Trapped { inner: last, outer: shrinking };
            }
            let is_linear = linear > 0.0 && (change - linear).abs() <= LINEAR * linear && self.is_smooth_within(a);
            near_linear = if is_linear { near_linear + 1 } else { 0 };
            if near_linear == 2 {
                break;
            }
            a *= if scanned.len() == 1 { FIRST_RATIO } else { SCAN_RATIO };
        }
        Fate::Captured
    }

    /// What a fate ends in: a cycle with its amplitude, or capture.
    pub fn settles(&self, fate: Fate) -> Fate {
        match fate {
            Fate::Grows { from } => self.settles(self.fate_of_growing(from)),
            Fate::Trapped { inner, outer } => {
                let cycle = self.cycle_between(inner, outer);
                Fate::SmoothCycle { amplitude: 0.5 * (cycle.top - cycle.swing.smallest) }
            }
            settled => settled,
        }
    }

    /// The limit cycle without sticking that the motion after a release comes to; `None` if it comes to something else, or
    /// is not resolved.
    ///
    /// The cycle is the outermost of its kind: at its release a motion has the disc's speed, so all of them lie inside it.
    pub fn sliding_cycle(&self) -> Option<SlidingCycle> {
        let (inner, outer) = self.trap_of_release()?;
        let cycle = self.cycle_between(inner, outer);
        (cycle.swing.end == SlipEnd::Turned).then_some(cycle)
    }

    /// Whether the motion after a release comes to a limit cycle without sticking. One that only creeps past amplitudes at which a cycle has vanished does not count: the
    /// largest change among them decides.
    pub fn has_sliding_cycle(&self) -> bool {
        self.trap_of_release().is_some()
    }

    /// The amplitudes between which that cycle lies.
    fn trap_of_release(&self) -> Option<(f64, f64)> {
        if self.has_no_inner_cycle() {
            return None;
        }
        match self.fate_of_release() {
            Fate::Trapped { inner, outer } => Some((inner, outer)),
            _ => None,
        }
    }

    /// The fate of a motion that grows at the amplitude `a`: captured, or trapped between two amplitudes.
    fn fate_of_growing(&self, a: f64) -> Fate {
        let mut inner = a;
        for _ in 0..MOST_SCANNED {
            let outer = inner / SCAN_RATIO;
            match self.change(outer) {
                f64::INFINITY => return Fate::Captured,
                change if change > 0.0 => inner = outer,
                change if change <= 0.0 => return Fate::Trapped { inner, outer },
                _ => break,
            }
        }
        Fate::Unresolved
    }

    /// The limit cycle between an amplitude at which swings grow and one at which they shrink.
    fn cycle_between(&self, inner: f64, outer: f64) -> SlidingCycle {
        let (low, _) = bisect((inner, outer), 60, 0.0, |a| self.change(a) >= 0.0);
        SlidingCycle { top: self.equilibrium() + low, swing: self.swing(low) }
    }
}

#[cfg(test)]
mod tests;
