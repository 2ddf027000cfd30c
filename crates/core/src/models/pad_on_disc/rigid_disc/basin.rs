//! Which motions return to steady sliding: the basin of attraction, and how hard a knock has to be to leave it.
//!
//! A motion is a point of the plane of x and x'. Slip (x' < v) is as in the module `planar_motion`. A pad that
//! overtakes the disc (x' > v) obeys the same law with friction in the other direction; seen in a mirror, it slips on a
//! disc of speed -v. A pad with the disc's speed sticks where static friction can hold it, `|K x + C v| <= G f_s`,
//! until its release, which is the same for all of them.
//!
//! | rotating speed | steady sliding | the basin |
//! |---|---|---|
//! | below the critical speed | unstable | nothing |
//! | from there to the saddle-node of stick-slip | stable, and so is stick-slip | the inside of an unstable cycle |
//! | above | stable | every motion returns |
//!
//! With friction that is weak beside the disc's speed a motion may overtake the disc in every cycle instead of
//! sticking; then read *the cycle outside* for *stick-slip*. Likewise where friction is not convex and a cycle without
//! sticking outlasts stick-slip: then every motion returns only above the end of all cycles.

use crate::model::verdict::Verdict;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use crate::models::pad_on_disc::rigid_disc::planar_motion::{PlanarMotion, SlipEnd};
use crate::models::pad_on_disc::rigid_disc::return_map::Fate;
use crate::models::pad_on_disc::rigid_disc::unstable_cycle::{Surrounding, UnstableCycle};

/// How often a motion may meet the disc's speed before its fate is known.
const MOST_MEETINGS: usize = 1000;

/// Which motions return to steady sliding on a rigid disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Basin {
    /// None: steady sliding is linearly unstable.
    Nothing,
    /// Those that start inside an unstable cycle. Where there are several, one in the other, this is the innermost:
    /// motions from outside it never cross it.
    Inside(UnstableCycle),
    /// All.
    Everything,
    /// Not found: the motion is too stiff for the method, or changes too slowly.
    Unresolved,
}

/// The smallest knocks that a motion in steady sliding does not return from, scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knock {
    /// Smallest change of the pad's speed in the disc's direction.
    pub forward: f64,
    /// Smallest change of its speed against the disc's direction.
    pub backward: f64,
    /// Smallest displacement of the pad in the disc's direction.
    pub outward: f64,
    /// Smallest displacement of the pad against the disc's direction.
    pub inward: f64,
}

impl Knock {
    /// The smallest change of speed, in either direction.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.forward.min(self.backward)
    }

    /// The smallest displacement, in either direction.
    #[must_use]
    pub fn displacement(&self) -> f64 {
        self.outward.min(self.inward)
    }
}

impl Basin {
    /// The smallest knocks; 0 where steady sliding is unstable, `None` where every motion returns or they were not
    /// found.
    #[must_use]
    pub fn smallest_knock(&self) -> Option<Knock> {
        match *self {
            Self::Nothing => Some(Knock { forward: 0.0, backward: 0.0, outward: 0.0, inward: 0.0 }),
            Self::Inside(cycle) => Some(Knock {
                forward: cycle.forward,
                backward: -cycle.backward,
                outward: cycle.outward,
                inward: -cycle.inward,
            }),
            Self::Everything | Self::Unresolved => None,
        }
    }

    /// The area in the plane of x and x', scaled; `None` where it is infinite or was not found.
    #[must_use]
    pub fn area(&self) -> Option<f64> {
        match self {
            Self::Nothing => Some(0.0),
            Self::Inside(cycle) => Some(cycle.area),
            Self::Everything | Self::Unresolved => None,
        }
    }
}

impl PadOnDisc {
    /// The basin of attraction of steady sliding on a rigid disc with constant contact force.
    ///
    /// The unstable cycle that bounds it is found to 1e-10 of its amplitude, by bisection on the return map. Nearer
    /// than 1e-5 to the critical speed, relative to it, fewer digits are right: six at 1e-8. The amplitude vanishes
    /// there with the root of the distance.
    #[must_use]
    pub fn basin(&self) -> Basin {
        let motion = self.planar_motion();
        let damping = motion.damping_at_equilibrium();
        if damping < 0.0 {
            return Basin::Nothing;
        }
        if motion.comes_to_rest_from(f64::MAX) {
            return Basin::Everything;
        }
        match motion.fate_in_plane([motion.release(), motion.disc_speed], true) {
            Fate::Equilibrium => Basin::Everything,
            Fate::Unresolved => Basin::Unresolved,
            Fate::Grows { .. } | Fate::Trapped { .. } | Fate::SmoothCycle { .. } | Fate::Captured | Fate::Overtakes => {
                match motion.innermost_unstable_cycle() {
                    Surrounding::Cycle(cycle) => Basin::Inside(cycle),
                    Surrounding::Unresolved => Basin::Unresolved,
                }
            }
        }
    }

    /// The verdict on a motion that starts at `x` with the speed `speed`, both scaled, by the adaptive method and the
    /// return map instead of a simulation to a horizon.
    ///
    /// Stable is what returns to steady sliding, unstable what does not; undecided is a motion that was not resolved.
    #[must_use]
    pub fn verdict_on_start(&self, x: f64, speed: f64) -> Verdict {
        let motion = self.planar_motion();
        if motion.damping_at_equilibrium() < 0.0 {
            return Verdict::Unstable;
        }
        let fate = match motion.fate_in_plane([x, speed], false) {
            Fate::Captured => motion.fate_in_plane([motion.release(), motion.disc_speed], true),
            fate => fate,
        };
        match fate {
            Fate::Equilibrium => Verdict::Stable,
            Fate::Unresolved => Verdict::Undecided,
            Fate::Captured | Fate::Overtakes | Fate::Grows { .. } | Fate::Trapped { .. } | Fate::SmoothCycle { .. } => {
                Verdict::Unstable
            }
        }
    }
}

impl PlanarMotion {
    /// The fate of a motion anywhere in the plane, up to its first stick ([`Fate::Captured`]); `is_released` says that
    /// a motion with the disc's speed does not stick at its start.
    pub fn fate_in_plane(&self, start: [f64; 2], is_released: bool) -> Fate {
        let v = self.disc_speed;
        let (first, last) = (self.last_hold(), self.release());
        let size = (start[0] - self.equilibrium()).abs().max(start[1].abs().max(v) / self.stiffness.sqrt());
        let mut state = start;
        let mut may_stick = !is_released;
        let (mut last_overtaking, mut overtakings) = (f64::NEG_INFINITY, 0);
        for _ in 0..MOST_MEETINGS {
            let [x, speed] = state;
            if may_stick && speed == v && (first..=last).contains(&x) {
                return Fate::Captured;
            }
            may_stick = true;
            if speed > v || (speed == v && x < first) {
                let overtaking = self.overtaking(state, size);
                match overtaking.end {
                    SlipEnd::Captured => state = [overtaking.x, v],
                    // Only where friction never falls, and then everywhere.
                    SlipEnd::Equilibrium => return Fate::Equilibrium,
                    SlipEnd::Turned | SlipEnd::Unresolved => return Fate::Unresolved,
                }
                continue;
            }
            let out = self.slip(state, size);
            let caught = match out.end {
                SlipEnd::Equilibrium => return Fate::Equilibrium,
                SlipEnd::Unresolved => return Fate::Unresolved,
                SlipEnd::Captured => out,
                SlipEnd::Turned => {
                    let back = self.slip([out.x, 0.0], size);
                    if back.end != SlipEnd::Captured {
                        return self.fate_of_swing(out.x - self.equilibrium());
                    }
                    back
                }
            };
            if caught.x < first {
                // Orbits do not cross: a motion that overtakes no nearer to steady sliding than the time before does so
                // for ever. So does one outside the motion that follows a release, or what happens to that decides.
                if caught.x <= last_overtaking {
                    return Fate::Overtakes;
                }
                overtakings += 1;
                if overtakings == 2 && !is_released {
                    let released = self.fate_in_plane([last, v], true);
                    if !matches!(released, Fate::Equilibrium | Fate::Unresolved) {
                        return released;
                    }
                }
            }
            last_overtaking = caught.x;
            state = [caught.x, v];
        }
        Fate::Unresolved
    }
}

#[cfg(test)]
mod tests;
