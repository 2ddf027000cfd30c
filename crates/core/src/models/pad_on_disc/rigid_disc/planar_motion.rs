//! The tangential motion on a rigid disc, by an adaptive method.
//!
//! Slip is a plane autonomous system, with all forces over the mass and in scaled time:
//!
//! ```text
//! x'' = G mu(v - x') - K x - C x',        x' < v
//! ```
//!
//! Steps are those of Dormand and Prince's method, adaptive, with a local error of 1e-12 of the motion's own size, or of a
//! rounding of x where that is larger. Ends of slip and turning points are located by bisection.
//!
//! Next to the disc's speed friction with a Stribeck exponent below 1 falls infinitely steeply, and the square root of the
//! sliding speed takes the place of the speed ([`near_rest`](crate::models::pad_on_disc::rigid_disc::near_rest)).
//!
//! Where friction rises so steeply that it damps a speed within a hundredth of a radian of the natural oscillation, the
//! pad creeps, and the motion is stiff: an explicit method would take steps as short as that damping, up to millions of
//! them. There, steps are those of a Rosenbrock method ([`crate::numerics::rosenbrock`]).

use crate::friction::law::FrictionLaw;
use crate::models::pad_on_disc::rigid_disc::near_rest::{NearRest, PassageEnd};
use crate::numerics::dormand_prince;
use crate::numerics::root_location::bisect;
use crate::numerics::rosenbrock::{self, Slopes};

/// Local error allowed in one step, relative to the size of the motion; and in a first, rough simulation that takes a
/// sixth of the time.
const TOLERANCE: f64 = 1e-12;
const ROUGH_TOLERANCE: f64 = 1e-8;

/// A pad that meets the disc at more than this share of the disc's speed times the natural frequency is caught,
/// whatever the errors of a rough simulation; they are relative to its size, which must not be larger than this many
/// times the disc's speed over the natural frequency.
const CLEAR_RATE: f64 = 3e-2;
const CLEAR_SIZE: f64 = 1e3;

/// The damping of speeds over the natural frequency beyond which a motion is stiff; and how much larger errors are
/// allowed then. They only shift the creep in time: across the one curve in the plane of x and x' along which the pad
/// creeps, they die away.
const STIFF: f64 = 100.0;
const STIFF_EASE: f64 = 1e3;

/// Largest number of steps of one slip phase; some hundred are usual. Only a pad so light or so damped that its motion
/// is stiff needs more; an explicit method is the wrong one for it.
const MOST_STEPS: usize = 20_000;

/// Steps between checks whether a motion surely returns to the equilibrium, some ten times those of a swing: a creeping
/// motion does not turn.
const STEPS_BETWEEN_CHECKS: usize = 1024;

/// The tangential motion of one sample on a rigid disc; forces over the mass, scaled time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlanarMotion {
    /// K.
    pub stiffness: f64,
    /// C.
    pub damping: f64,
    /// v.
    pub disc_speed: f64,
    /// G mu: the friction law with its coefficients multiplied by G.
    pub law: FrictionLaw,
}

/// How a slip phase ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum SlipEnd {
    /// At a turning point, the largest x of a swing.
    Turned,
    /// The pad has reached the disc's speed.
    Captured,
    /// It comes to rest without turning again.
    Equilibrium,
    /// Too many steps, or numbers out of range.
    Unresolved,
}

/// A slip phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slip {
    pub end: SlipEnd,
    pub duration: f64,
    /// x at its end, and the smallest x on the way.
    pub x: f64,
    pub smallest: f64,
}

/// A phase in which the pad is faster than the disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Overtaking {
    /// [`SlipEnd::Captured`] is the usual one.
    pub end: SlipEnd,
    pub duration: f64,
    /// x at its end.
    pub x: f64,
}

/// The last of some swings, or the first that does not end where it turns.
pub(super) fn last_swing(swings: u32, state: [f64; 2], slip: impl Fn([f64; 2]) -> Slip) -> Slip {
    (1..swings).fold(slip(state), |last, _| if last.end == SlipEnd::Turned { slip([last.x, 0.0]) } else { last })
}

impl PlanarMotion {
    /// Steady sliding, x0.
    pub fn equilibrium(&self) -> f64 {
        self.law.coefficient(self.disc_speed) / self.stiffness
    }

    /// Where static friction can hold the pad no longer.
    pub fn release(&self) -> f64 {
        (self.law.at_rest() - self.damping * self.disc_speed) / self.stiffness
    }

    /// The damping of small motions about steady sliding; negative where friction feeds them.
    pub fn damping_at_equilibrium(&self) -> f64 {
        self.damping - self.law.fall(self.disc_speed)
    }

    /// Whether a motion that moves at speeds up to `fastest`, if it keeps its energy, surely comes to rest.
    pub fn comes_to_rest_from(&self, fastest: f64) -> bool {
        let slope = if self.law.never_falls() {
            // Friction that rises with speed damps; at least it does not feed.
            0.0
        } else if fastest >= self.disc_speed {
            return false;
        } else {
            // Rounding may leave the speed of a motion at rest below 0.
            self.law.steepest_chord(self.disc_speed, fastest.max(0.0))
        };
        self.damping > slope
    }

    /// Whether the friction law bends nowhere within the speeds of a swing of the amplitude `a`: a measured curve bends
    /// at its rows. Only then does a change near that of the linearised motion say something of smaller amplitudes.
    pub fn is_smooth_within(&self, a: f64) -> bool {
        let (v, reach) = (self.disc_speed, 2.0 * a * self.stiffness.sqrt());
        self.law.knots_between(v - reach, v + reach).next().is_none()
    }

    /// Whether the motion in a state of slip surely comes to rest.
    pub fn comes_to_rest(&self, x: f64, speed: f64) -> bool {
        let distance = x - self.equilibrium();
        self.comes_to_rest_from((speed * speed + self.stiffness * distance * distance).sqrt())
    }

    /// The derivatives of x and x' in a state of slip.
    pub(super) fn rate(&self, [x, speed]: [f64; 2]) -> [f64; 2] {
        [speed, self.law.coefficient(self.disc_speed - speed) - self.stiffness * x - self.damping * speed]
    }

    /// The damping of the pad's speed in a state, if it makes the motion stiff there.
    fn stiff_damping(&self, [_, speed]: [f64; 2]) -> Option<f64> {
        let stiff = STIFF * self.stiffness.sqrt();
        let may_rise = self.law.is_table();
        if !may_rise && self.damping + self.law.additional / self.law.speed_scale <= stiff {
            return None;
        }
        let damping =
            self.damping - self.law.fall((self.disc_speed - speed).abs()) * (self.disc_speed - speed).signum();
        (damping > stiff).then_some(damping)
    }

    /// One step of the method; the second value is the estimate of its error, over what is allowed of it elsewhere.
    pub fn step(&self, state: [f64; 2], h: f64) -> ([f64; 2], [f64; 2]) {
        let rate = |state| self.rate(state);
        match self.stiff_damping(state) {
            None => dormand_prince::step(rate, state, h),
            Some(damping) => {
                let slopes = Slopes { by_x: -self.stiffness, by_u: -damping };
                let (next, error) = rosenbrock::step(rate, slopes, state, h);
                (next, error.map(|error| error / STIFF_EASE))
            }
        }
    }

    /// The part of a step at whose end `event` vanishes; it is positive at its beginning, not at its end.
    fn locate(&self, state: [f64; 2], h: f64, event: impl Fn([f64; 2]) -> f64) -> (f64, [f64; 2]) {
        let (_, late) = bisect((0.0, h), 100, 0.0, |part| event(self.step(state, part).0) > 0.0);
        (late, self.step(state, late).0)
    }

    /// Simulates slip from a state until the pad reaches the disc's speed, or x its largest value again. Errors are
    /// relative to the amplitude `size`.
    pub fn slip(&self, from: [f64; 2], size: f64) -> Slip {
        self.slip_within(TOLERANCE, from, size)
    }

    /// The same, rough and fast.
    pub fn rough_slip(&self, from: [f64; 2], size: f64) -> Slip {
        self.slip_within(ROUGH_TOLERANCE, from, size)
    }

    /// The size of a motion in a state of slip: errors are relative to it.
    pub fn size_of(&self, state: [f64; 2]) -> f64 {
        (state[0] - self.equilibrium()).abs().max(self.disc_speed / self.stiffness.sqrt())
    }

    fn slip_within(&self, tolerance: f64, from: [f64; 2], size: f64) -> Slip {
        let frequency = self.stiffness.sqrt();
        let sliding = |state: [f64; 2]| self.disc_speed - state[1];
        let near_rest = NearRest {
            stiffness: self.stiffness,
            damping: self.damping,
            disc_speed: self.disc_speed,
            law: &self.law,
            release: self.release(),
        };
        // Below the rounding of x no tolerance can be met: steps would shrink until their number ends them.
        let size = size.max(f64::EPSILON / tolerance * self.equilibrium().abs());
        let mut state = from;
        let mut slip = Slip { end: SlipEnd::Unresolved, duration: 0.0, x: from[0], smallest: from[0] };
        let mut h = 1e-3 / frequency;
        let shortest = 1e-9 * h;
        for count in 1..=MOST_STEPS {
            if near_rest.includes(state) {
                let passage = near_rest.pass(state, tolerance);
                slip.duration += passage.duration;
                (state, slip.x) = ([passage.x, passage.speed], passage.x);
                match passage.end {
                    PassageEnd::Left => continue,
                    PassageEnd::Captured => return Slip { end: SlipEnd::Captured, ..slip },
                    PassageEnd::Unresolved => return slip,
                }
            }
            let (next, error) = self.step(state, h);
            let error = (error[0].abs() / size).max(error[1].abs() / (size * frequency)) / tolerance;
            if error.is_nan() {
                return slip;
            }
            if error > 1.0 {
                h *= dormand_prince::growth(error);
                continue;
            }
            if sliding(state) == 0.0 && sliding(next) <= 0.0 && h > shortest {
                // It leaves the disc for less than this step, if at all.
                h *= 0.1;
                continue;
            }
            let captured = (sliding(state) > 0.0 || h <= shortest).then(|| self.capture(state, next, h)).flatten();
            let part = captured.unwrap_or(h);
            if state[1] < 0.0 && self.step(state, part).0[1] >= 0.0 {
                slip.smallest = slip.smallest.min(self.locate(state, part, |state| -state[1]).1[0]);
            }
            if captured.is_some() {
                let (part, caught) = self.locate(state, part, sliding);
                return Slip { end: SlipEnd::Captured, duration: slip.duration + part, x: caught[0], ..slip };
            }
            if state[1] > 0.0 && next[1] <= 0.0 {
                let (part, turned) = self.locate(state, h, |state| state[1]);
                return Slip { end: SlipEnd::Turned, duration: slip.duration + part, x: turned[0], ..slip };
            }
            slip.duration += h;
            slip.x = next[0];
            state = next;
            if count % STEPS_BETWEEN_CHECKS == 0 && self.comes_to_rest(state[0], state[1]) {
                return Slip { end: SlipEnd::Equilibrium, ..slip };
            }
            h *= dormand_prince::growth(error);
        }
        slip
    }

    /// Whether a motion in a state of slip is caught before it has completed a swing, by a margin that a rough
    /// simulation resolves. False also where only a precise one can decide: `is_in_doubt` says that of the x at which it
    /// meets the disc's speed.
    pub fn is_clearly_caught(&self, from: [f64; 2], size: f64, is_in_doubt: impl Fn(f64) -> bool) -> bool {
        if size * self.stiffness.sqrt() > CLEAR_SIZE * self.disc_speed {
            return false;
        }
        let slip = last_swing(2, from, |state| self.rough_slip(state, size));
        slip.end == SlipEnd::Captured && self.is_clear_capture(&slip, size) && !is_in_doubt(slip.x)
    }

    /// Whether a capture in a rough simulation is as fast as to be clear.
    pub fn is_clear_capture(&self, slip: &Slip, size: f64) -> bool {
        let rate = self.rate([slip.x, self.disc_speed])[1];
        let frequency = self.stiffness.sqrt();
        size * frequency <= CLEAR_SIZE * self.disc_speed && rate > CLEAR_RATE * self.disc_speed * frequency
    }

    /// A time within the step `h` from `state` to `next` at which the pad is not slower than the disc, if there is one:
    /// at its end, or where its speed has a maximum in between.
    fn capture(&self, state: [f64; 2], next: [f64; 2], h: f64) -> Option<f64> {
        if self.disc_speed - next[1] <= 0.0 {
            return Some(h);
        }
        if self.rate(state)[1] <= 0.0 || self.rate(next)[1] >= 0.0 {
            return None;
        }
        let (part, fastest) = self.locate(state, h, |state| self.rate(state)[1]);
        (self.disc_speed - fastest[1] <= 0.0).then_some(part)
    }

    /// The slip phase that begins at `x` with the disc's speed, to its first turning point and on from there; `None` in
    /// place of the second where the first does not turn.
    pub fn slip_from(&self, x: f64) -> (Slip, Option<Slip>) {
        let size = x.abs().max(self.disc_speed / self.stiffness.sqrt());
        let first = self.slip([x, self.disc_speed], size);
        let second = (first.end == SlipEnd::Turned).then(|| self.slip([first.x, 0.0], size));
        (first, second)
    }

    /// The least x at which static friction holds a pad with the disc's speed; below it the pad overtakes the disc.
    pub fn last_hold(&self) -> f64 {
        -self.release() - 2.0 * self.damping * self.disc_speed / self.stiffness
    }

    /// The phase in which the pad is faster than the disc, from `x` with the disc's speed until it has that speed
    /// again; `None` where static friction holds the pad.
    pub fn overtaking_from(&self, x: f64) -> Option<Overtaking> {
        let size = x.abs().max(self.disc_speed / self.stiffness.sqrt());
        (x < self.last_hold()).then(|| self.overtaking([x, self.disc_speed], size))
    }

    /// The same from any state in which the pad is not slower than the disc. In a mirror it slips on a disc of speed
    /// -v.
    pub fn overtaking(&self, [x, speed]: [f64; 2], size: f64) -> Overtaking {
        let mirrored = Self { disc_speed: -self.disc_speed, ..*self }.slip([-x, -speed], size);
        Overtaking { end: mirrored.end, duration: mirrored.duration, x: -mirrored.x }
    }
}
