//! Limit cycles of the pad on a rigid disc, with and without sticking, and where they end.
//!
//! With constant contact force N the tangential motion is that of a mass on a moving belt,
//!
//! ```text
//! slip (x' < v):   M eta0 x'' = -(k_x + k_t2) x - c_x sqrt(eta0) x' + (k_t2 / k_t1) mu(v - x') N
//! stick (x' = v):  until the friction needed, (k_t1 / k_t2) [(k_x + k_t2) x + c_x sqrt(eta0) v], exceeds f_s N
//! ```
//!
//! Stick and slip are states with located ends, not a smoothed sign function: a switch at step ends chatters.
//!
//! Where the slip after a release does not come to the disc's speed again, its swings shrink. They come to rest, or to a
//! cycle in which the pad slides all the time, which the module `return_map` finds.

use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use crate::models::pad_on_disc::rigid_disc::planar_motion::{PlanarMotion, SlipEnd};
use crate::models::pad_on_disc::rigid_disc::return_map::{Fate, SlidingCycle};
use crate::numerics::root_location::bisect;

/// The highest admissible rotating speed, see `operating_point.rotating_speed`; the search for the saddle-node ends
/// there.
const HIGHEST_SPEED: f64 = 1e5;

/// Speeds in each decade of the scans for the ends.
const POINTS_PER_DECADE: f64 = 15.0;

/// To what share of its displacement a cycle in which the pad overtakes the disc is located.
const LOCATED: f64 = 1e-11;

/// How often the search for such a cycle doubles its range.
const MOST_DOUBLINGS: usize = 60;

/// How far above a speed below which there are limit cycles, relative to it, there has to be one too if they go on.
const BEYOND: f64 = 1e-6;

/// A limit cycle, in scaled time and length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitCycle {
    /// Duration of one cycle.
    pub period: f64,
    /// Largest tangential displacement.
    pub tangential_max: f64,
    /// Smallest tangential displacement.
    pub tangential_min: f64,
    /// Share of the period spent in stick; 0 where the pad overtakes the disc in every cycle instead, or slides all the
    /// time.
    pub stick_fraction: f64,
    /// Whether the pad comes to the disc's speed; otherwise it slides all the time, and the cycle is one without sticking.
    pub reaches_disc_speed: bool,
}

/// The rotating speeds (rad/s) above which there are no limit cycles on a rigid disc; `None` where there are none at any
/// speed, or some up to any speed, or where that is not resolved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CycleEnds {
    /// The end of stick-slip, [`PadOnDisc::saddle_node_speed`].
    pub stick_slip: Option<f64>,
    /// The end of all limit cycles, with and without sticking; the same where none goes on without sticking.
    pub any: Option<f64>,
}

impl CycleEnds {
    /// The end of all limit cycles, if there are some without sticking above the end of stick-slip.
    #[must_use]
    pub fn without_sticking(&self) -> Option<f64> {
        self.any.filter(|&any| self.stick_slip.is_none_or(|stick_slip| stick_slip < any))
    }
}

impl PadOnDisc {
    /// The limit cycle on a rigid disc with constant contact force, or `None` if there is none at this operating point.
    ///
    /// Stick-slip is simulated from the release from stick: all motions that stick leave it at the same point, by the
    /// same slip phase. Accuracy some 1e-10 (Dormand-Prince 5(4), located ends; the pad's speed may touch the disc's
    /// between two steps). A slip phase that takes more than 20 000 steps, of a pad far lighter or more damped than any
    /// brake's, counts as not recaptured.
    ///
    /// Where friction is weak beside the springs and damping that act at the disc's speed, static friction cannot hold
    /// the pad when it reaches that speed: it overtakes the disc and falls back to its speed. Then it sticks, or slips
    /// at once and overtakes in every cycle; such a cycle is one too, without a stick. Of several it is the one next to
    /// the motion after a release.
    ///
    /// Where that motion does not come to the disc's speed again, it may come to a cycle in which the pad slides all the
    /// time, with Stribeck exponents above 1 and measured curves. Of several it is the outermost one.
    #[must_use]
    pub fn limit_cycle(&self) -> Option<LimitCycle> {
        self.planar_motion().limit_cycle()
    }

    /// The tangential motion at the operating point.
    pub(crate) fn planar_motion(&self) -> PlanarMotion {
        let mass = self.scaled_mass();
        let gain = self.friction_transmission() * self.normal_force() / mass;
        PlanarMotion {
            stiffness: self.tangential_stiffness() / mass,
            damping: self.scaled_tangential_damping() / mass,
            disc_speed: self.disc_speed(),
            law: self.friction_law().times(gain),
        }
    }

    /// The rotating speed (rad/s) above which no stick-slip limit cycle exists on a rigid disc: there the slip phase
    /// released from stick just fails to reach the disc's speed again, and the limit cycle vanishes in a saddle-node
    /// bifurcation. `None` if there is no limit cycle at any speed, or up to any speed. With a measured curve that
    /// falls in several places there may be limit cycles in several ranges of speed; this is the end of the highest
    /// one, as far as it is no narrower than a sixth of its speed.
    ///
    /// Bisection to 1e-10 of the speed between neighbours of a logarithmic scan, from the highest admissible speed
    /// to far below both speeds that matter: the Stribeck velocity, and that of an oscillation as wide as the drop in
    /// friction.
    #[must_use]
    pub fn saddle_node_speed(&self) -> Option<f64> {
        let cycles = |speed: f64| self.motion_at(speed).is_some_and(|motion| motion.stick_slip_cycle().is_some());
        let scan = self.scanned_speeds(POINTS_PER_DECADE);
        // Falling speeds: the first one with a limit cycle lies below the saddle-node, the one before it above.
        let first = scan.iter().position(|&speed| cycles(speed))?;
        let (with, without) = bisect((scan[first], scan[first.checked_sub(1)?]), 1000, 1e-10, cycles);
        Some(0.5 * (with + without))
    }

    /// Where limit cycles end: stick-slip, and all of them.
    ///
    /// A cycle without sticking vanishes where its swings meet those of an unstable cycle inside it: there the largest
    /// change over a cycle passes 0. With Stribeck exponents up to 1 and the rational law none outlasts stick-slip. Elsewhere
    /// it is looked for at the scanned speeds of [`PadOnDisc::saddle_node_speed`], just above the end of stick-slip, and
    /// just above the critical speed, below which nothing comes to rest; a range of such cycles that begins elsewhere and
    /// is narrower than a sixth of its speed may be missed.
    #[must_use]
    pub fn cycle_ends(&self) -> CycleEnds {
        let stick_slip = self.saddle_node_speed();
        let is_only = self.friction_law().is_completely_monotone();
        CycleEnds { stick_slip, any: if is_only { stick_slip } else { self.end_of_cycles(stick_slip) } }
    }

    fn end_of_cycles(&self, end_of_stick_slip: Option<f64>) -> Option<f64> {
        let cycles = |speed: f64| self.motion_at(speed).is_some_and(|motion| motion.has_limit_cycle());
        let scan = self.scanned_speeds(POINTS_PER_DECADE);
        let found = scan.iter().copied().find(|&speed| cycles(speed)).unwrap_or(0.0);
        let critical = self.unstable_speeds().last().map(|range| range.to);
        let known = end_of_stick_slip.into_iter().chain(critical).fold(0.0, f64::max);
        if known >= HIGHEST_SPEED {
            return None;
        }
        let mut with = found;
        if known > found {
            with = known * (1.0 + BEYOND);
            if !cycles(with) {
                return self.is_resolved(with).then_some(known);
            }
        }
        if with <= 0.0 {
            return None;
        }
        let above = scan.iter().rev().copied().find(|&speed| speed > with)?;
        let (with, without) = bisect((with, above), 1000, 1e-10, cycles);
        let end = 0.5 * (with + without);
        self.is_resolved(end * (1.0 + BEYOND)).then_some(end)
    }

    /// Whether it is known what a motion comes to after a release at another rotating speed (rad/s).
    fn is_resolved(&self, rotating_speed: f64) -> bool {
        self.motion_at(rotating_speed).is_none_or(|motion| motion.fate_of_release() != Fate::Unresolved)
    }

    /// The tangential motion at another rotating speed (rad/s), if that is admissible.
    pub(super) fn motion_at(&self, rotating_speed: f64) -> Option<PlanarMotion> {
        let mut parameters = self.parameters().clone();
        parameters.operating_point.rotating_speed = rotating_speed;
        PadOnDisc::new(parameters).ok().map(|brake| brake.planar_motion())
    }

    /// The rotating speeds (rad/s) at which limit cycles are looked for, in falling order, so many in each decade; none
    /// where friction is the same at all speeds.
    pub(super) fn scanned_speeds(&self, points_per_decade: f64) -> Vec<f64> {
        let motion = self.planar_motion();
        let (drop, width) = motion.law.drop_and_width();
        let oscillation = self.rotating_speed(drop / motion.stiffness.sqrt());
        let stribeck = self.rotating_speed(width);
        if oscillation <= 0.0 {
            return Vec::new();
        }
        let lowest = (1e-4 * oscillation.min(stribeck)).clamp(1e-5, HIGHEST_SPEED);
        let points = 1 + (points_per_decade * libm::log10(HIGHEST_SPEED / lowest)).ceil() as u32;
        let ratio = libm::pow(HIGHEST_SPEED / lowest, 1.0 / f64::from(points));
        (0..points).scan(HIGHEST_SPEED, |speed, _| Some(std::mem::replace(speed, *speed / ratio))).collect()
    }
}

impl PlanarMotion {
    /// See [`PadOnDisc::limit_cycle`].
    pub fn limit_cycle(&self) -> Option<LimitCycle> {
        self.stick_slip_cycle().or_else(|| {
            let SlidingCycle { top, swing } = self.sliding_cycle()?;
            Some(LimitCycle {
                period: swing.duration,
                tangential_max: top,
                tangential_min: swing.smallest,
                stick_fraction: 0.0,
                reaches_disc_speed: false,
            })
        })
    }

    /// Whether some motions never come to rest. Where steady sliding is unstable, none does.
    fn has_limit_cycle(&self) -> bool {
        self.damping_at_equilibrium() < 0.0 || self.stick_slip_cycle().is_some() || self.has_sliding_cycle()
    }

    /// The limit cycle in which the pad comes to the disc's speed: it sticks, or overtakes the disc in every cycle.
    pub fn stick_slip_cycle(&self) -> Option<LimitCycle> {
        if self.release() <= 0.0 {
            return None;
        }
        let round = self.round_from(self.release())?;
        if round.caught > self.release() {
            return Some(self.overtaking_cycle(round.caught)?.closed_by(0.0));
        }
        let stick = (self.release() - round.caught) / self.disc_speed;
        (stick > 0.0).then(|| round.closed_by(stick))
    }

    /// Whether a motion comes to the disc's speed again and again, as [`PlanarMotion::stick_slip_cycle`] does; `None` where
    /// that is not resolved.
    pub fn has_stick_slip(&self) -> Option<bool> {
        if self.release() > 0.0 && self.round_from(self.release()).is_some() {
            return Some(true);
        }
        match self.fate_of_release() {
            Fate::Captured | Fate::Overtakes | Fate::Grows { .. } | Fate::Unresolved => None,
            Fate::Equilibrium | Fate::Trapped { .. } | Fate::SmoothCycle { .. } => Some(false),
        }
    }

    /// The motion from `x`, where it begins to slip with the disc's speed, until it has that speed the next time and
    /// does not overtake the disc; `None` if it is not captured, or not resolved.
    fn round_from(&self, x: f64) -> Option<Round> {
        let (out, back) = self.slip_from(x);
        let back = back.filter(|back| back.end == SlipEnd::Captured)?;
        let slipped = Round { duration: out.duration + back.duration, max: out.x, min: back.smallest, caught: back.x };
        let Some(overtaking) = self.overtaking_from(back.x) else { return Some(slipped) };
        let duration = slipped.duration + overtaking.duration;
        let round = Round { duration, caught: overtaking.x, ..slipped };
        (overtaking.end == SlipEnd::Captured).then_some(round)
    }

    /// The cycle in which the pad overtakes the disc and never sticks. Rounds from `grows` end farther out than they
    /// begin.
    ///
    /// Orbits do not cross, so the end of a round grows with its beginning. The cycle is where they are equal, between
    /// a round that ends farther out and one that does not; next to it they may approach each other slowly.
    fn overtaking_cycle(&self, grows: f64) -> Option<Round> {
        let mut grows = grows;
        let mut shrinks = self.round_from(grows)?.caught;
        for _ in 0..MOST_DOUBLINGS {
            let caught = self.round_from(shrinks)?.caught;
            if caught <= shrinks {
                let ends_farther_out = |x: f64| self.round_from(x).is_some_and(|round| round.caught > x);
                let (cycle, _) = bisect((grows, shrinks), 60, LOCATED, ends_farther_out);
                return self.round_from(cycle);
            }
            (grows, shrinks) = (shrinks, caught + 2.0 * (caught - grows));
        }
        None
    }
}

/// A motion from the disc's speed to the disc's speed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Round {
    duration: f64,
    max: f64,
    min: f64,
    /// Where it has the disc's speed again.
    caught: f64,
}

impl Round {
    /// The limit cycle of this motion and a stick of this duration.
    fn closed_by(&self, stick: f64) -> LimitCycle {
        let period = self.duration + stick;
        LimitCycle {
            period,
            tangential_max: self.max,
            tangential_min: self.min,
            stick_fraction: stick / period,
            reaches_disc_speed: true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::pad_on_disc::rigid_disc::pad_on_disc::bstab_with;

    /// G of a brake with the preset's kinetic friction.
    fn gain(motion: &PlanarMotion) -> f64 {
        motion.law.kinetic_coefficient / 0.25
    }

    #[test]
    fn limit_cycles_agree_with_an_independent_integration() {
        // Adaptive Runge-Kutta, tolerance 1e-11, located events, outside Rust; preset, Delta = 0.1, f_s = 0.39:
        // speed, period, max x, min x, share in stick.
        for (speed, period, max, min, stick) in [
            (10.0, 3.56373, 0.014309, 0.003465, 0.3756),
            (15.56, 3.21741, 0.015334, 0.002579, 0.2556),
            (20.0, 3.10909, 0.016207, 0.001879, 0.1873),
        ] {
            let cycle = PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]).limit_cycle().unwrap();
            assert!((cycle.period - period).abs() < 1e-5, "{cycle:?}");
            assert!((cycle.tangential_max - max).abs() < 1e-6, "{cycle:?}");
            assert!((cycle.tangential_min - min).abs() < 1e-6, "{cycle:?}");
            assert!((cycle.stick_fraction - stick).abs() < 1e-4, "{cycle:?}");
        }
    }

    #[test]
    fn where_friction_cannot_hold_the_pad_it_overtakes_the_disc_in_every_cycle() {
        // SciPy 1.17.1, solve_ivp with DOP853, rtol 1e-12, atol 1e-14, located events: preload, damping, speed; period,
        // max x, min x, share in stick. The first two never stick; the next two overtake the disc before they stick.
        for ([preload, damping, speed], [period, max, min, stick]) in [
            ([0.05, 0.001, 2.2], [6.283_508_258, 2.240_838_186, -2.187_323_949, 0.0]),
            ([0.1, 0.001, 1.5], [6.287_044_557, 1.580_546_679, -1.477_540_993, 0.0]),
            ([0.05, 0.001, 0.5], [6.293_495_727, 0.545_282_899, -0.486_050_533, 0.005_678_514]),
            ([0.2, 0.001, 1.0], [6.318_592_834, 1.170_766_339, -0.963_298_016, 0.038_886_183]),
            ([0.3, 0.001, 0.6], [6.431_207_074, 0.870_771_956, -0.538_073_539, 0.146_064_589]),
        ] {
            let changes = [
                ("operating_point.preload", preload),
                ("damping.tangential", damping),
                ("operating_point.rotating_speed", speed),
            ];
            let cycle = bstab_with(&changes).limit_cycle().unwrap();
            let found = [cycle.period, cycle.tangential_max, cycle.tangential_min, cycle.stick_fraction];
            let is_close =
                found.iter().zip([period, max, min, stick]).all(|(found, value)| (found - value).abs() < 1e-8);
            assert!(is_close, "{preload} {damping} {speed}: {cycle:?}");
        }
    }

    #[test]
    fn overtaking_cycles_are_found_however_slowly_motions_approach_them() {
        // SciPy 1.17.1, DOP853, rtol 1e-13, the end of a round equal to its beginning: preload, damping, speed; max x,
        // min x. The changes from cycle to cycle fall by 10 %, 0.7 % and 0.2 %.
        for ([preload, damping, speed], [max, min]) in [
            ([0.01, 0.0, 10.0], [10.031_268_061, -10.021_268_061]),
            ([0.01, 0.0, 300.0], [300.032_324_1, -300.022_324_1]),
            ([1e-4, 1e-6, 1.0], [1.014_045_505, -1.013_940_808]),
        ] {
            let changes = [
                ("operating_point.preload", preload),
                ("damping.tangential", damping),
                ("operating_point.rotating_speed", speed),
            ];
            let cycle = bstab_with(&changes).limit_cycle().unwrap();
            assert!((cycle.tangential_max / max - 1.0).abs() < 1e-8, "{preload} {damping} {speed}: {cycle:?}");
            assert!((cycle.tangential_min / min - 1.0).abs() < 1e-8, "{preload} {damping} {speed}: {cycle:?}");
            assert_eq!(cycle.stick_fraction, 0.0);
        }
        let undamped = bstab_with(&[("operating_point.preload", 0.01), ("damping.tangential", 0.0)]);
        assert_eq!(undamped.saddle_node_speed(), None);
    }

    #[test]
    fn the_saddle_node_is_where_an_independent_integration_finds_it() {
        let speed = PadOnDisc::preset_with(&[]).saddle_node_speed().unwrap();
        assert!((speed - 30.197).abs() < 0.01, "{speed}");
        assert!(PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed * 0.999)]).limit_cycle().is_some());
        assert!(PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed * 1.001)]).limit_cycle().is_none());
    }

    #[test]
    fn the_saddle_node_is_precise_where_friction_falls_infinitely_steeply_at_rest() {
        // SciPy 1.17.1, solve_ivp with DOP853, rtol 1e-13, in the square root of the sliding speed near rest, bisected to
        // 1e-10: exponent, damping, static friction, Stribeck velocity, preload; speed.
        for ([exponent, damping, friction, velocity, preload], speed) in [
            ([0.5, 200.0, 0.39, 0.72, 0.1], 44.855_302_388),
            ([0.5, 300.0, 0.5, 0.05, 0.1], 31.132_255_654),
            ([0.5, 100.0, 0.6, 0.01, 0.05], 38.619_358_008),
            ([0.5, 400.0, 0.6, 1.5, 0.2], 109.243_908_135),
            ([0.6, 300.0, 0.5, 0.1, 0.1], 33.426_329_936),
            ([0.7, 300.0, 0.5, 0.1, 0.1], 32.867_073_201),
            ([0.9, 300.0, 0.5, 0.05, 0.1], 29.598_592_150),
        ] {
            let brake = PadOnDisc::preset_with(&[
                ("friction.stribeck_exponent", exponent),
                ("damping.tangential", damping),
                ("friction.static_coefficient", friction),
                ("friction.stribeck_velocity", velocity),
                ("operating_point.preload", preload),
            ]);
            let found = brake.saddle_node_speed().unwrap();
            assert!((found / speed - 1.0).abs() < 3e-10, "{exponent} {damping}: {found} {speed}");
        }
    }

    /// A brake with exponent 2, by its tangential damping and its rotating speed.
    fn gaussian(damping: f64, speed: f64) -> PadOnDisc {
        PadOnDisc::preset_with(&[
            ("friction.stribeck_exponent", 2.0),
            ("damping.tangential", damping),
            ("operating_point.rotating_speed", speed),
        ])
    }

    #[test]
    fn a_cycle_without_sticking_is_that_of_an_independent_integration() {
        // Found outside the program, by event-accurate integration: amplitude 0.0020148 h, and the end between 7.32 and
        // 7.33 rad/s. Further digits, and the period over that of the spring and the mass, are those of a classical
        // Runge-Kutta method outside Rust, with 1700 and with 3500 steps a cycle.
        let cycle = gaussian(3000.0, 7.0).limit_cycle().unwrap();
        let amplitude = 0.5 * (cycle.tangential_max - cycle.tangential_min);
        assert!((amplitude - 0.002_014_819_75).abs() < 1e-9, "{cycle:?}");
        let frequency = gaussian(3000.0, 7.0).planar_motion().stiffness.sqrt();
        assert!((frequency * cycle.period - 6.971_429_3).abs() < 1e-6, "{cycle:?}");
        assert!(!cycle.reaches_disc_speed && cycle.stick_fraction == 0.0, "{cycle:?}");
        // Up to 7.1 rad/s steady sliding is linearly unstable, from 7.2 rad/s on it is stable.
        for (speed, is_one) in [(6.9, true), (7.32, true), (7.33, false), (8.0, false)] {
            assert_eq!(gaussian(3000.0, speed).limit_cycle().is_some(), is_one, "{speed}");
        }
        let sticking = gaussian(3000.0, 6.8).limit_cycle().unwrap();
        assert!(sticking.reaches_disc_speed && sticking.stick_fraction > 0.0, "{sticking:?}");
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn limit_cycles_end_where_they_disappear_and_not_where_they_stop_sticking() {
        // The same Runge-Kutta method: damping; the ends of stick-slip and of all cycles.
        for (damping, stick_slip, any) in
            [(2000.0, 9.2091, 9.25580), (2500.0, 7.9089, 8.10420), (3000.0, 6.8818, 7.32373)]
        {
            let ends = gaussian(damping, 7.0).cycle_ends();
            assert!((ends.stick_slip.unwrap() / stick_slip - 1.0).abs() < 1e-4, "{damping}: {ends:?}");
            assert!((ends.any.unwrap() / any - 1.0).abs() < 1e-5, "{damping}: {ends:?}");
        }
        // With less damping no cycle outlasts stick-slip.
        for damping in [369.0, 1500.0] {
            let ends = gaussian(damping, 7.0).cycle_ends();
            assert!(ends.stick_slip.is_some() && ends.any == ends.stick_slip, "{damping}: {ends:?}");
        }
    }

    #[test]
    fn up_to_exponent_one_all_limit_cycles_end_with_stick_slip() {
        for exponent in [0.7, 1.0] {
            let ends = PadOnDisc::preset_with(&[("friction.stribeck_exponent", exponent)]).cycle_ends();
            assert!(ends.stick_slip.is_some() && ends.any == ends.stick_slip, "{exponent}: {ends:?}");
        }
    }

    #[test]
    fn on_a_very_slow_disc_the_cycle_is_nearly_all_stick() {
        // The slip phase no longer depends on the disc's speed, so the stick phase lasts its width over the speed.
        let slow =
            |speed: f64| PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]).limit_cycle().unwrap();
        let reference = slow(1e-4);
        for speed in [1e-5, 1e-6] {
            let cycle = slow(speed);
            assert!((cycle.tangential_min / reference.tangential_min - 1.0).abs() < 1e-3, "{speed}: {cycle:?}");
            assert!((cycle.period * speed / (reference.period * 1e-4) - 1.0).abs() < 1e-2, "{speed}: {cycle:?}");
        }
    }

    #[test]
    fn without_falling_friction_nothing_sticks_and_slips() {
        let flat = PadOnDisc::preset_with(&[("friction.kinetic_coefficient", 0.39)]);
        assert_eq!(flat.limit_cycle(), None);
        assert_eq!(flat.saddle_node_speed(), None);
        assert_eq!(PadOnDisc::preset_with(&[("operating_point.preload", 0.0)]).limit_cycle(), None);
    }

    #[test]
    fn an_undamped_pad_sticks_and_slips_at_every_speed() {
        let undamped = PadOnDisc::preset_with(&[("damping.tangential", 0.0)]);
        assert!(undamped.limit_cycle().is_some());
        assert_eq!(undamped.saddle_node_speed(), None);
    }

    #[test]
    fn with_constant_slip_friction_the_saddle_node_is_that_of_a_damped_oscillator() {
        // Friction that drops at once: the slip phase is x_c + exp(-beta t) (A cos + B sin), and the saddle-node is the
        // disc speed that its return just reaches.
        let sharp = PadOnDisc::preset_with(&[("friction.stribeck_velocity", 1e-6)]);
        let motion = sharp.planar_motion();
        let (beta, centre) = (0.5 * motion.damping, 0.25 * gain(&motion) / motion.stiffness);
        let omega = (motion.stiffness - beta * beta).sqrt();
        let fastest_return = |speed: f64| {
            let release = (0.39 * gain(&motion) - motion.damping * speed) / motion.stiffness;
            let a = release - centre;
            let b = (speed + beta * a) / omega;
            let velocity = |t: f64| {
                (-beta * t).exp()
                    * ((b * omega - beta * a) * (omega * t).cos() - (a * omega + beta * b) * (omega * t).sin())
            };
            let period = std::f64::consts::TAU / omega;
            (0..200_000).map(|i| velocity(period * (0.4 + 0.8e-5 * f64::from(i)))).fold(f64::NEG_INFINITY, f64::max)
        };
        let (mut slow, mut fast) = (1e-6, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (slow + fast);
            if fastest_return(middle) > middle { slow = middle } else { fast = middle }
        }
        let expected = sharp.rotating_speed(slow);
        let speed = sharp.saddle_node_speed().unwrap();
        assert!((speed / expected - 1.0).abs() < 1e-3, "{speed} {expected}");
    }

    #[test]
    fn with_constant_slip_friction_the_slip_phase_is_a_harmonic_arc() {
        // A Stribeck velocity far below all speeds: friction drops at once from f_s to f_c, and without damping the
        // slip phase is an arc about x_c with amplitude sqrt((x_r - x_c)^2 + (v / omega)^2).
        let sharp = PadOnDisc::preset_with(&[
            ("damping.tangential", 0.0),
            ("friction.stribeck_velocity", 1e-7),
            ("operating_point.rotating_speed", 10.0),
        ]);
        let cycle = sharp.limit_cycle().unwrap();
        let motion = sharp.planar_motion();
        let centre = 0.25 * gain(&motion) / motion.stiffness;
        let amplitude = f64::hypot(motion.release() - centre, motion.disc_speed / motion.stiffness.sqrt());
        assert!((cycle.tangential_max - (centre + amplitude)).abs() < 1e-6, "{cycle:?}");
        assert!((cycle.tangential_min - (centre - amplitude)).abs() < 1e-6, "{cycle:?}");
    }
}
