//! The tangential motion on a rigid disc as a return map.
//!
//! Slip is a plane autonomous system,
//!
//! ```text
//! x'' = G mu(v - x') - K x - C x',        x' < v
//! ```
//!
//! whose orbits do not cross. On the section `x' = 0`, `x = x0 + a`, `a > 0` (the largest x of a swing) a motion comes
//! back with another amplitude `R(a)`, and R grows with a. That decides what waiting cannot:
//!
//! * A swing longer than the one before is followed by longer ones only; a shorter one by shorter ones.
//! * A shrinking motion comes to rest exactly if `R(s) < s` for all smaller amplitudes s. If some `R(s) >= s`, a limit
//!   cycle lies between, and the motion never gets inside it.
//! * For exponents up to 1 and a linearly stable equilibrium there is no stable cycle without sticking, and one unstable
//!   one at the most: a swing that shrinks decides by itself. Let `F(u) = G mu(v - u)` and `f = C - F'`, the damping. On
//!   both sides of `u = 0` the quotient `f / u` falls, because `u f' - f = F' - u F'' - C` is largest at `u = 0`, where it
//!   is `F'(0) - C < 0`; its derivative is `-u` times the third derivative of F, which is positive as all derivatives of
//!   `exp(-r^delta)` alternate in sign. That is the condition of Zhang's theorem on Lienard's equation (Zhang Zhifen et
//!   al., *Qualitative Theory of Differential Equations*, chapter 4) with time running backwards.
//! * The energy `u^2/2 + K (x - x0)^2/2` of a motion with speeds up to U falls as long as
//!   `C > [G mu(v - u) - G mu(v)] / u` for all `|u| <= U`: such a motion comes to rest, however slowly.
//!
//! Steps are those of Dormand and Prince's method, adaptive, with a local error of 1e-12 of the motion's own size; ends of
//! slip and turning points are located by bisection. This is the reference that the fixed steps of the time-domain
//! criterion are tested against, and its answer where a motion on a rigid disc changes too slowly to wait for.

use crate::friction::StribeckLaw;
use crate::numerics::root_location::bisect;

/// Local error allowed in one step, relative to the size of the motion.
const TOLERANCE: f64 = 1e-12;

/// Steps of one slip phase at the most; some hundred are usual. Only a pad so light or so damped that its motion is stiff
/// needs more; an explicit method is the wrong one for it.
const MOST_STEPS: usize = 20_000;

/// Steps after which it is asked whether a motion is on its way home, some ten times those of a swing: one that creeps does
/// not turn.
const STEPS_TO_LOOK: usize = 1024;

/// Ratio of neighbouring amplitudes in a scan. Between them the change over a cycle is taken to have one extremum at the
/// most; that one is searched for.
const SCAN_RATIO: f64 = 0.9;

/// Amplitudes scanned at the most: down to 1e-7 of the first.
const MOST_SCANNED: usize = 160;

/// Changes over a cycle, relative to the amplitude, that are lost in the errors of the method.
const UNRESOLVED: f64 = 1e-10;

/// How near the change over a cycle must come to that of the linearised motion for smaller amplitudes to follow it too.
const LINEAR: f64 = 0.01;

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
    pub law: StribeckLaw,
}

/// How a slip phase ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum SlipEnd {
    /// At a turning point, the largest x of a swing.
    Turned,
    /// The pad has reached the disc's speed.
    Captured,
    /// It comes to rest without turning again.
    Home,
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

/// What becomes of a motion whose swings shrink, or grow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Fate {
    /// It comes to rest relative to steady sliding.
    Home,
    /// Its swings grow from this amplitude: what they grow to, [`PlanarMotion::settles`] finds out.
    Grows { from: f64 },
    /// A limit cycle without sticking lies between these amplitudes, and the motion outside it.
    Trapped { inner: f64, outer: f64 },
    /// A limit cycle without sticking; half of its peak-to-peak displacement.
    SmoothCycle { amplitude: f64 },
    /// It reaches the disc's speed.
    Captured,
    /// Not resolved.
    Unresolved,
}

impl PlanarMotion {
    /// Steady sliding, x0.
    pub fn equilibrium(&self) -> f64 {
        self.law.coefficient(self.disc_speed) / self.stiffness
    }

    /// Where static friction can hold the pad no longer.
    pub fn release(&self) -> f64 {
        (self.law.static_coefficient - self.damping * self.disc_speed) / self.stiffness
    }

    fn falling(&self) -> f64 {
        self.law.static_coefficient - self.law.kinetic_coefficient
    }

    /// The damping of small motions about steady sliding; negative where friction feeds them.
    pub fn damping_at_equilibrium(&self) -> f64 {
        let falling = self.falling();
        // Without a fall there is nothing to multiply a slope with that may be infinite.
        if falling == 0.0 { self.damping } else { self.damping - falling * self.law.weakening(self.disc_speed) }
    }

    /// Whether a swing that shrinks without meeting the disc's speed must come to rest: see the module's documentation.
    pub fn has_no_inner_cycle(&self) -> bool {
        self.law.exponent <= 1.0 && self.damping_at_equilibrium() > 0.0
    }

    /// Whether a motion that moves at speeds up to `fastest`, if it keeps its energy, surely comes to rest.
    pub fn comes_to_rest_from(&self, fastest: f64) -> bool {
        let (v, falling) = (self.disc_speed, self.falling());
        let slope = if falling <= 0.0 {
            // Friction that rises with speed damps; at least it does not feed.
            0.0
        } else if fastest >= v {
            return false;
        } else {
            let steepest = self.law.steepest_between(v - fastest, v + fastest);
            if steepest <= v - fastest && fastest > 1e-6 * v {
                // The curve is convex there, and the chord to its upper end the steepest.
                (self.law.coefficient(v - fastest) - self.law.coefficient(v)) / fastest
            } else {
                falling * self.law.weakening(steepest)
            }
        };
        self.damping > slope
    }

    /// Whether the motion in a state of slip surely comes to rest.
    pub fn comes_to_rest(&self, x: f64, speed: f64) -> bool {
        let distance = x - self.equilibrium();
        self.comes_to_rest_from((speed * speed + self.stiffness * distance * distance).sqrt())
    }

    fn rate(&self, [x, speed]: [f64; 2]) -> [f64; 2] {
        [speed, self.law.coefficient(self.disc_speed - speed) - self.stiffness * x - self.damping * speed]
    }

    /// One step of Dormand and Prince's fifth-order method; the second value is the estimate of its error.
    fn step(&self, state: [f64; 2], h: f64) -> ([f64; 2], [f64; 2]) {
        let combine = |terms: &[(f64, [f64; 2])]| {
            let mut sum = [0.0; 2];
            for (factor, rate) in terms {
                sum[0] += factor * rate[0];
                sum[1] += factor * rate[1];
            }
            sum
        };
        let at = |terms: &[(f64, [f64; 2])]| {
            let sum = combine(terms);
            self.rate([state[0] + h * sum[0], state[1] + h * sum[1]])
        };
        let k1 = self.rate(state);
        let k2 = at(&[(1.0 / 5.0, k1)]);
        let k3 = at(&[(3.0 / 40.0, k1), (9.0 / 40.0, k2)]);
        let k4 = at(&[(44.0 / 45.0, k1), (-56.0 / 15.0, k2), (32.0 / 9.0, k3)]);
        let k5 =
            at(&[(19_372.0 / 6561.0, k1), (-25_360.0 / 2187.0, k2), (64_448.0 / 6561.0, k3), (-212.0 / 729.0, k4)]);
        let k6 = at(&[
            (9017.0 / 3168.0, k1),
            (-355.0 / 33.0, k2),
            (46_732.0 / 5247.0, k3),
            (49.0 / 176.0, k4),
            (-5103.0 / 18_656.0, k5),
        ]);
        let increment = combine(&[
            (35.0 / 384.0, k1),
            (500.0 / 1113.0, k3),
            (125.0 / 192.0, k4),
            (-2187.0 / 6784.0, k5),
            (11.0 / 84.0, k6),
        ]);
        let next = [state[0] + h * increment[0], state[1] + h * increment[1]];
        let k7 = self.rate(next);
        let error = combine(&[
            (71.0 / 57_600.0, k1),
            (-71.0 / 16_695.0, k3),
            (71.0 / 1920.0, k4),
            (-17_253.0 / 339_200.0, k5),
            (22.0 / 525.0, k6),
            (-1.0 / 40.0, k7),
        ]);
        (next, [h * error[0], h * error[1]])
    }

    /// The part of a step at whose end `event` vanishes; it is positive at its beginning, not at its end.
    fn locate(&self, state: [f64; 2], h: f64, event: impl Fn([f64; 2]) -> f64) -> (f64, [f64; 2]) {
        let (_, late) = bisect((0.0, h), 100, 0.0, |part| event(self.step(state, part).0) > 0.0);
        (late, self.step(state, late).0)
    }

    /// Follows slip from a state until the pad reaches the disc's speed, or x its largest value again. `size` is the
    /// amplitude to which errors are compared.
    pub fn slip(&self, from: [f64; 2], size: f64) -> Slip {
        let frequency = self.stiffness.sqrt();
        let sliding = |state: [f64; 2]| self.disc_speed - state[1];
        let mut state = from;
        let mut slip = Slip { end: SlipEnd::Unresolved, duration: 0.0, x: from[0], smallest: from[0] };
        let mut h = 1e-3 / frequency;
        for count in 1..=MOST_STEPS {
            let (next, error) = self.step(state, h);
            let error = (error[0].abs() / size).max(error[1].abs() / (size * frequency)) / TOLERANCE;
            if error.is_nan() {
                return slip;
            }
            if error > 1.0 {
                h *= (0.9 * libm::pow(error, -0.2)).max(0.2);
                continue;
            }
            let captured = (sliding(state) > 0.0).then(|| self.capture(state, next, h)).flatten();
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
            if count % STEPS_TO_LOOK == 0 && self.comes_to_rest(state[0], state[1]) {
                return Slip { end: SlipEnd::Home, ..slip };
            }
            h *= (0.9 * libm::pow(error.max(1e-10), -0.2)).clamp(0.2, 5.0);
        }
        slip
    }

    /// A time within the step `h` from `state` to `next` at which the pad is not slower than the disc, if there is one: at
    /// its end, or where its speed has a maximum in between.
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

    /// The slip phase that begins at release from stick, to its first turning point and on from there; `None` in place of
    /// the second where the first does not turn.
    pub fn slip_from_release(&self) -> (Slip, Option<Slip>) {
        let size = self.release().abs().max(self.disc_speed / self.stiffness.sqrt());
        let first = self.slip([self.release(), self.disc_speed], size);
        let second = (first.end == SlipEnd::Turned).then(|| self.slip([first.x, 0.0], size));
        (first, second)
    }

    /// One return, from the amplitude `a` > 0.
    fn swing(&self, a: f64) -> Slip {
        self.slip([self.equilibrium() + a, 0.0], a)
    }

    /// `ln(R(a) / a)`; infinite where the pad is captured, minus infinity where it comes to rest within the swing.
    fn change(&self, a: f64) -> f64 {
        let swing = self.swing(a);
        match swing.end {
            SlipEnd::Turned => libm::log((swing.x - self.equilibrium()) / a),
            SlipEnd::Captured => f64::INFINITY,
            SlipEnd::Home => f64::NEG_INFINITY,
            SlipEnd::Unresolved => f64::NAN,
        }
    }

    /// The change of small amplitudes over a cycle; minus infinity where they do not oscillate.
    fn linear_change(&self) -> f64 {
        let damping = self.damping_at_equilibrium();
        let square = self.stiffness - 0.25 * damping * damping;
        if square > 0.0 { -std::f64::consts::PI * damping / square.sqrt() } else { f64::NEG_INFINITY }
    }

    /// The fate of a motion that has turned at `x0 + a`, `a` > 0.
    pub fn fate_of_swing(&self, a: f64) -> Fate {
        let change = self.change(a);
        if change.is_nan() || change.abs() <= UNRESOLVED {
            Fate::Unresolved
        } else if change > 0.0 {
            Fate::Grows { from: a }
        } else {
            self.fate_of_shrinking(a)
        }
    }

    /// The fate of a motion released from stick.
    pub fn fate_of_release(&self) -> Fate {
        self.fate_from([self.release(), self.disc_speed])
    }

    /// The fate of a motion in a state of slip, up to its first capture.
    pub fn fate_from(&self, state: [f64; 2]) -> Fate {
        let size = (state[0] - self.equilibrium()).abs().max(self.disc_speed / self.stiffness.sqrt());
        let first = self.slip(state, size);
        match first.end {
            SlipEnd::Captured => Fate::Captured,
            SlipEnd::Home => Fate::Home,
            SlipEnd::Unresolved => Fate::Unresolved,
            SlipEnd::Turned => match self.slip([first.x, 0.0], size).end {
                SlipEnd::Captured => Fate::Captured,
                SlipEnd::Home => Fate::Home,
                SlipEnd::Unresolved => Fate::Unresolved,
                SlipEnd::Turned => self.fate_of_swing(first.x - self.equilibrium()),
            },
        }
    }

    /// The fate of a motion that shrinks at the amplitude `a`: is there a smaller one at which it does not?
    fn fate_of_shrinking(&self, a: f64) -> Fate {
        if self.has_no_inner_cycle() {
            return Fate::Home;
        }
        let linear = self.linear_change();
        let mut scanned = vec![(a, self.change(a))];
        let mut near_linear = 0;
        while scanned.len() < MOST_SCANNED {
            let (outer, before) = scanned[scanned.len() - 1];
            if self.damping_at_equilibrium() > 0.0 && self.comes_to_rest_from(self.stiffness.sqrt() * outer) {
                return Fate::Home;
            }
            let inner = SCAN_RATIO * outer;
            let change = self.change(inner);
            if change.is_nan() {
                return Fate::Unresolved;
            }
            if change >= 0.0 {
                return Fate::Trapped { inner, outer };
            }
            if change == f64::NEG_INFINITY {
                return Fate::Home;
            }
            scanned.push((inner, change));
            // A maximum of the change among the last three amplitudes: does it reach zero between them?
            if let [.., (first, at_first), _, _] = scanned[..]
                && before > change
                && before >= at_first
                && let Some(growing) = self.growing_between(inner, first)
            {
                return Fate::Trapped { inner: growing, outer: first };
            }
            near_linear = if (change - linear).abs() <= LINEAR * linear.abs() { near_linear + 1 } else { 0 };
            if near_linear == 2 {
                return if linear < 0.0 { Fate::Home } else { Fate::Unresolved };
            }
        }
        Fate::Unresolved
    }

    /// What a fate ends in: a cycle with its amplitude, or capture.
    pub fn settles(&self, fate: Fate) -> Fate {
        match fate {
            Fate::Grows { from } => self.fate_of_growing(from),
            Fate::Trapped { inner, outer } => self.cycle_between(inner, outer),
            settled => settled,
        }
    }

    /// The fate of a motion that grows at the amplitude `a`.
    fn fate_of_growing(&self, a: f64) -> Fate {
        let mut inner = a;
        for _ in 0..MOST_SCANNED {
            let outer = inner / SCAN_RATIO;
            match self.change(outer) {
                f64::INFINITY => return Fate::Captured,
                change if change > 0.0 => inner = outer,
                change if change <= 0.0 => return self.cycle_between(inner, outer),
                _ => break,
            }
        }
        Fate::Unresolved
    }

    /// An amplitude between two at which swings grow, where they shrink at both; by golden section towards the largest
    /// change.
    fn growing_between(&self, inner: f64, outer: f64) -> Option<f64> {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let (mut low, mut high) = (inner, outer);
        let mut left = high - GOLDEN * (high - low);
        let mut right = low + GOLDEN * (high - low);
        let (mut at_left, mut at_right) = (self.change(left), self.change(right));
        for _ in 0..40 {
            if at_left >= 0.0 {
                return Some(left);
            }
            if at_right >= 0.0 {
                return Some(right);
            }
            // Closer to its maximum the change differs by less than it is resolved.
            if (at_left - at_right).abs() <= UNRESOLVED {
                break;
            }
            if at_left > at_right {
                (high, right, at_right) = (right, left, at_left);
                left = high - GOLDEN * (high - low);
                at_left = self.change(left);
            } else {
                (low, left, at_left) = (left, right, at_right);
                right = low + GOLDEN * (high - low);
                at_right = self.change(right);
            }
        }
        None
    }

    /// The limit cycle between an amplitude at which swings grow and one at which they shrink.
    fn cycle_between(&self, inner: f64, outer: f64) -> Fate {
        let (low, _) = bisect((inner, outer), 60, 0.0, |a| self.change(a) >= 0.0);
        let swing = self.swing(low);
        Fate::SmoothCycle { amplitude: 0.5 * (self.equilibrium() + low - swing.smallest) }
    }
}

#[cfg(test)]
mod tests;
