//! The monitor of a rigid disc, where the tangential motion is planar and its orbits do not cross
//! ([`crate::models::pad_on_disc::rigid_disc::return_map`]).
//!
//! | state | event | then |
//! |---|---|---|
//! | any | the energy is so small that friction cannot feed the motion any more | stable |
//! | swinging | turns at the largest x: the first since the start, a release or an overtaking | this amplitude is compared with the next |
//! | | larger than the last one by more than errors of the steps | unstable |
//! | | smaller by more than these; no stable cycle inside ([`inner_cycles`](crate::models::pad_on_disc::rigid_disc::inner_cycles)) | stable |
//! | | more than 1 % smaller, where one can lie inside | swinging; this amplitude is compared with the next |
//! | | 0.1 % to 1 % smaller, at most a hundred times | the same |
//! | | in between, too slow to wait for | the return map decides |
//! | | sticks for the first time | held: until its release, which is the same for all motions that stick |
//! | | sticks a second time, or for the first time after a start at release | unstable: all later cycles are the same |
//! | | grazes the disc's speed in its first swing since the start or a release | the return map decides from that start or release |
//! | | is about to be caught in that swing, at the end of a step (exponent 1) | the return map decides from the release |
//! | | overtakes the disc | swinging, with nothing to compare with |
//! | | for the second time, and the motion after a release, which lies inside, does not come to rest | unstable |
//! | | takes more substeps than a motion may | the return map decides from there |
//! | | meets the disc's speed or passes it by as slowly as only errors of the steps may decide | the return map is asked to confirm it ([`slow_passage`](crate::models::pad_on_disc::rigid_disc::slow_passage)) |
//! | held | would stick for longer than [`LONGEST_STICK`] | the return map decides from the release |
//! | | slips | swinging |
//!
//! If the equilibrium is linearly unstable, the motion is unstable from the start and is simulated only for its
//! amplitude.

use crate::model::verdict::Verdict;
use crate::models::pad_on_disc::criterion::monitor::Monitor;
use crate::models::pad_on_disc::degree_of_freedom::DegreeOfFreedom;
use crate::models::pad_on_disc::motion::integrator::Observer;
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::rigid_disc::inner_cycles::Turns;
use crate::models::pad_on_disc::rigid_disc::planar_motion::PlanarMotion;
use crate::models::pad_on_disc::rigid_disc::return_map::Fate;

/// A relative change of amplitude over a cycle beyond all errors of the steps, whose damping is 4e-7.
const RESOLVED: f64 = 1e-5;

/// A change that is worth waiting for: a hundredfold decay takes 460 cycles at most.
const CLEAR: f64 = 1e-2;

/// Swings that shrink more slowly, but by more than this, are awaited too, so many of them: next to an unstable cycle
/// they soon shrink fast, and the return map takes longer than a hundred cycles. Those that shrink even less may be
/// about to settle on a cycle without sticking; the return map knows better than fixed steps.
const SLOW: f64 = 1e-3;
const SLOW_SWINGS: u32 = 100;

/// A longer stick than this, in scaled time, is not simulated.
const LONGEST_STICK: f64 = 100.0;

/// What is known of one motion so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RigidMonitor {
    motion: PlanarMotion,
    equilibrium: f64,
    /// Asked at every turn, so kept.
    has_no_inner_cycle: bool,
    until_settled: bool,
    /// The motion is known to be unstable, and may be simulated further for its amplitude.
    is_known_unstable: bool,
    verdict: Option<Verdict>,
    /// Amplitude of the last turning point at the largest x.
    last_top: Option<f64>,
    slow_swings: u32,
    /// The return map did not resolve that amplitude.
    is_unresolved: bool,
    last_turn: Option<f64>,
    /// How often the pad overtook the disc, where last, and the change of that place from cycle to cycle.
    overtakings: u32,
    last_overtaking: Option<f64>,
    last_change: Option<f64>,
    amplitude: f64,
    /// How often the pad stuck, a start at release included.
    sticks: u32,
    /// The state of slip at the start or the last release, until the first swing since then is over.
    started: Option<[f64; 2]>,
    /// Turning points at the largest x since then.
    tops: u32,
}

impl RigidMonitor {
    /// For a motion that starts in this state, in slip or at its release from stick.
    pub fn new(motion: PlanarMotion, until_settled: bool, (x, speed): (f64, f64), starts_at_release: bool) -> Self {
        let is_linearly_unstable = motion.damping_at_equilibrium() < 0.0;
        let mut monitor = Self {
            motion,
            equilibrium: motion.equilibrium(),
            has_no_inner_cycle: motion.has_no_inner_cycle(),
            until_settled,
            is_known_unstable: is_linearly_unstable,
            verdict: (is_linearly_unstable && !until_settled).then_some(Verdict::Unstable),
            last_top: None,
            slow_swings: 0,
            is_unresolved: false,
            last_turn: None,
            overtakings: 0,
            last_overtaking: None,
            last_change: None,
            amplitude: 0.0,
            sticks: u32::from(starts_at_release),
            started: None,
            tops: 0,
        };
        if speed == 0.0 && monitor.verdict.is_none() {
            monitor.turns(0.0, x);
        }
        monitor.started = Some([x, speed]);
        monitor.tops = 0;
        monitor
    }

    /// Notes the state of contact that a given motion starts in, at `x`.
    pub fn starts_in(&mut self, contact: ContactState, x: f64) {
        match contact {
            ContactState::Slip => {}
            // The return map knows slip alone.
            ContactState::Overtaking => self.started = None,
            ContactState::Stick => {
                self.started = None;
                self.waits_for_release(x);
            }
        }
    }

    /// The motion sticks at `x` until it is released; all motions are released in the same state.
    fn waits_for_release(&mut self, x: f64) {
        if self.verdict.is_none() && self.motion.release() - x > LONGEST_STICK * self.motion.disc_speed {
            self.conclude_from(self.motion.fate_of_release());
        }
    }

    fn becomes_unstable(&mut self) {
        self.is_known_unstable = true;
        if !self.until_settled {
            self.verdict = Some(Verdict::Unstable);
        }
    }

    /// Whether a motion without a verdict surely comes to rest.
    #[inline]
    fn comes_to_rest(&self, x: f64, speed: f64) -> bool {
        self.verdict.is_none() && !self.is_known_unstable && self.motion.comes_to_rest(x, speed)
    }

    /// Whether the motion since the start or the last release is caught, within so many swings, as the return map finds it
    /// to be, if that is in doubt. If it is not, concludes from what that finds.
    fn is_confirmed(&mut self, is_caught: bool, swings: u32, is_in_doubt: impl Fn(&PlanarMotion) -> bool) -> bool {
        let Some(state) = self.started.filter(|_| self.verdict.is_none() && is_in_doubt(&self.motion)) else {
            return true;
        };
        if self.motion.is_caught_within(swings, state) == Some(is_caught) {
            return true;
        }
        self.started = None;
        self.conclude_from(self.motion.fate_from(state));
        if self.verdict.is_none() && !self.is_known_unstable {
            self.verdict = Some(Verdict::Undecided);
        }
        false
    }

    /// Concludes from what the return map finds. A motion that is captured sticks and is released; what comes after a
    /// release is the same for all motions.
    fn conclude_from(&mut self, fate: Fate) {
        let settled = |fate: Fate| if self.until_settled { self.motion.settles(fate) } else { fate };
        let fate = match settled(fate) {
            Fate::Captured => match settled(self.motion.fate_of_release()) {
                Fate::Captured => return self.conclude_from_stick_slip(),
                released => released,
            },
            fate => fate,
        };
        match fate {
            Fate::Equilibrium if !self.is_known_unstable => self.verdict = Some(Verdict::Stable),
            Fate::Grows { .. } | Fate::Trapped { .. } | Fate::Overtakes => self.becomes_unstable(),
            Fate::SmoothCycle { amplitude } => {
                self.amplitude = amplitude;
                self.is_known_unstable = true;
                self.verdict = Some(Verdict::Unstable);
            }
            Fate::Equilibrium | Fate::Captured | Fate::Unresolved => self.is_unresolved = true,
        }
    }

    /// Unstable, with the amplitude of the cycle that follows a release. A cycle that is not resolved is simulated.
    fn conclude_from_stick_slip(&mut self) {
        self.becomes_unstable();
        if self.verdict.is_some() {
            return;
        }
        if let Some(cycle) = self.motion.stick_slip_cycle() {
            self.amplitude = 0.5 * (cycle.tangential_max - cycle.tangential_min);
            self.verdict = Some(Verdict::Unstable);
        } else {
            self.is_unresolved = true;
        }
    }

    /// Whether a place that changes geometrically from cycle to cycle is as near its limit as is resolved.
    fn has_settled(&mut self, before: f64, x: f64) -> bool {
        let change = (x - before).abs();
        let last_change = self.last_change.replace(change);
        let resolved = RESOLVED * (self.equilibrium - x).abs();
        last_change.is_some_and(|last| change <= resolved && change * change <= resolved * (last - change))
    }
}

impl Monitor for RigidMonitor {
    #[inline]
    fn verdict(&self) -> Option<Verdict> {
        self.verdict
    }

    fn is_unstable(&self) -> bool {
        self.is_known_unstable
    }

    fn amplitude(&self) -> f64 {
        self.amplitude
    }

    fn fed_by(&self) -> DegreeOfFreedom {
        DegreeOfFreedom::Tangential
    }

    #[inline]
    fn check(&mut self, x: f64, speed: f64) {
        // It may have passed the disc's speed by since its last turning point.
        if self.comes_to_rest(x, speed) && self.is_confirmed(false, self.tops + 1, |_| true) {
            self.verdict = Some(Verdict::Stable);
        }
    }

    fn is_exhausted(&mut self, x: f64, speed: f64) {
        if self.verdict.is_none() {
            self.conclude_from(self.motion.fate_in_plane([x, speed], false));
        }
    }
}

impl Observer for RigidMonitor {
    #[inline]
    fn turns(&mut self, _: f64, x: f64) {
        let last_turn = self.last_turn.replace(x);
        if let Some(before) = last_turn {
            self.amplitude = 0.5 * (x - before).abs();
        }
        let a = x - self.equilibrium;
        self.tops += u32::from(a > 0.0);
        // After its release a motion turns once before it can come to the disc's speed.
        let is_first = self.tops == 1 && self.started.is_some_and(|[_, speed]| speed == self.motion.disc_speed);
        if a > 0.0 && !is_first && !self.is_confirmed(false, self.tops, |motion| motion.passes_slowly(x)) {
            return;
        }
        if self.comes_to_rest(x, 0.0) {
            self.verdict = Some(Verdict::Stable);
        }
        if a <= 0.0 || self.verdict.is_some() {
            return;
        }
        let Some(before) = self.last_top else {
            self.last_top = Some(a);
            return;
        };
        self.started = None;
        let change = a / before - 1.0;
        if change > RESOLVED {
            self.becomes_unstable();
        } else if change < -RESOLVED && !self.is_known_unstable {
            // Tops shrink one after the other: that of the last swing was no higher than the one to compare with.
            let bottom = last_turn.map_or(f64::INFINITY, |turn| self.equilibrium - turn);
            let last_swing = Turns { top: before, bottom, next_top: a };
            if self.has_no_inner_cycle || self.motion.has_no_cycle_inside(last_swing) {
                self.verdict = Some(Verdict::Stable);
            }
        }
        if self.verdict.is_some() {
            return;
        }
        let is_awaited = change < -SLOW && !self.is_known_unstable && self.slow_swings < SLOW_SWINGS;
        if change.abs() > CLEAR || is_awaited {
            self.slow_swings += u32::from(change.abs() <= CLEAR);
            self.last_top = Some(a);
            self.is_unresolved = false;
        } else if !self.is_unresolved {
            self.conclude_from(self.motion.fate_of_swing(a));
        }
    }

    fn sticks(&mut self, _: f64, x: f64) {
        if self.verdict.is_some() || !self.is_confirmed(true, self.tops + 1, |motion| motion.meets_slowly(x)) {
            return;
        }
        self.sticks += 1;
        if self.sticks > 1 {
            self.is_known_unstable = true;
            self.verdict = Some(Verdict::Unstable);
        } else {
            self.waits_for_release(x);
        }
    }

    fn slips(&mut self, _: f64) {
        self.started = Some([self.motion.release(), self.motion.disc_speed]);
        self.tops = 0;
        self.last_top = None;
    }

    fn overtakes(&mut self, x: f64, then: ContactState) {
        // A pad that meets the disc's speed where static friction has let go of it touches it at the end of stick-slip.
        if then == ContactState::Slip && !self.is_confirmed(false, self.tops + 1, |_| true) {
            return;
        }
        self.last_top = None;
        self.started = None;
        if then != ContactState::Overtaking || self.verdict.is_some() {
            return;
        }
        let before = self.last_overtaking.replace(x);
        self.overtakings += 1;
        if self.overtakings == 2 {
            // The motion lies outside the one that follows a release, and stays there.
            match self.motion.fate_in_plane([self.motion.release(), self.motion.disc_speed], true) {
                Fate::Captured | Fate::Overtakes => return self.conclude_from_stick_slip(),
                Fate::Grows { .. } | Fate::Trapped { .. } | Fate::SmoothCycle { .. } => self.becomes_unstable(),
                Fate::Equilibrium | Fate::Unresolved => {}
            }
        }
        let has_settled = before.is_some_and(|before| self.has_settled(before, x));
        if self.is_known_unstable && has_settled {
            self.verdict = Some(Verdict::Unstable);
        }
    }

    fn grazes(&mut self) {
        if let (Some(state), None) = (self.started.take(), self.verdict) {
            self.conclude_from(self.motion.fate_from(state));
        }
    }

    fn is_caught(&mut self, x: f64) {
        let is_certain = self.is_confirmed(true, self.tops + 1, |motion| motion.meets_slowly(x));
        if is_certain && self.started.take().is_some() && self.verdict.is_none() {
            self.conclude_from(Fate::Captured);
        }
    }
}

#[cfg(test)]
mod tests;
