//! The unstable cycle around steady sliding, from the return map.
//!
//! Between the critical speed and the saddle-node of stick-slip, steady sliding is stable and stick-slip is too. A
//! cycle of slip separates them: motions that start inside it return to steady sliding, motions outside leave. No orbit
//! on it or inside it reaches the disc's speed. For the slip phase that just touches the disc's speed does so at the
//! release point, and goes on as every slip phase from there does; below the saddle-node that one is wider than the one
//! before, so swings grow already where they touch.
//!
//! The cycle repels, often so strongly that no motion forward in time stays near it for one turn. So motions are
//! followed backward in time, where it attracts. With `d = x - x0`, `w = -x'` and `F(u) = G mu(v - u)`,
//!
//! ```text
//! d' = w,   w' = F(-w) - F(0) - K d + C w,       w > -v
//! ```
//!
//! A swing from `d = a > 0`, `w = 0` comes from the amplitude Q(a) of the swing before. Inside the innermost cycle
//! `Q(a) > a`, and Q(a) is inside too; at the cycle `Q(a) = a`. Along with the motion its energy is integrated,
//!
//! ```text
//! (w^2 + K d^2)' / 2 = w (F(-w) - F(0) + C w),       Q(a)^2 = a^2 + 2 (its increase) / K
//! ```
//!
//! Near the critical speed the increase is small of third order in a, and so are its errors: the cycle, where it
//! vanishes, keeps its digits there.
//!
//! With curves that are not convex there may be several cycles, one in the other. The innermost one bounds what steady
//! sliding attracts, since orbits do not cross; it is the one that is looked for, from inside.

use crate::models::pad_on_disc::rigid_disc::planar_motion::PlanarMotion;
use crate::numerics::dormand_prince;
use crate::numerics::root_location::{bisect, false_position, rise_to_zero};

/// Local error allowed in one step, relative to the amplitude.
const TOLERANCE: f64 = 1e-13;

/// Largest number of steps of one swing; some 600 are usual, and more where friction is steep or the pad very light.
const MOST_STEPS: usize = 100_000;

/// Ratio of neighbouring amplitudes in the search, and their largest number: over 16 decades. Between three of them the
/// change over a cycle is taken to have one maximum at most.
const SCAN_RATIO: f64 = 0.9;
const MOST_SCANNED: usize = 350;

/// Changes over a cycle, relative to the amplitude, that are lost in errors.
const UNRESOLVED: f64 = 1e-12;

/// An unstable cycle of slip around steady sliding: scaled, displacements relative to x0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnstableCycle {
    /// Duration of one cycle.
    pub period: f64,
    /// Largest displacement from x0, positive.
    pub outward: f64,
    /// Smallest displacement from x0, negative.
    pub inward: f64,
    /// The pad's speed where it passes x0 in the disc's direction, positive.
    pub forward: f64,
    /// Its speed where it passes x0 against the disc's direction, negative.
    pub backward: f64,
    /// The area inside, in the plane of x and x'.
    pub area: f64,
}

/// What surrounds a linearly stable steady sliding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Surrounding {
    Cycle(UnstableCycle),
    /// Not resolved: the motion is too stiff, or changes too slowly.
    Unresolved,
}

/// A swing, backward in time.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Swing {
    /// From turning point to turning point; what it would be as a cycle, and the increase of energy.
    Turns {
        cycle: UnstableCycle,
        increase: f64,
    },
    /// It comes from the disc's speed.
    Leaves,
    Unresolved,
}

/// d, w, the increase of energy and the integral of `w^2`, which over a cycle is the area inside it.
type State = [f64; 4];

/// The four quarters of a swing: what is positive in each of them, and vanishes at its end.
const QUARTERS: [fn(&State) -> f64; 4] = [|&[d, ..]| d, |&[_, w, ..]| -w, |&[d, ..]| -d, |&[_, w, ..]| w];

impl PlanarMotion {
    /// The innermost unstable cycle around a linearly stable equilibrium that does not attract every motion.
    pub fn innermost_unstable_cycle(&self) -> Surrounding {
        let (sure, _) = bisect((0.0, self.disc_speed), 200, 1e-3, |speed| self.comes_to_rest_from(speed));
        if sure <= 0.0 {
            return Surrounding::Unresolved;
        }
        let mut inner = [(sure / self.stiffness.sqrt(), f64::INFINITY); 2];
        for _ in 0..MOST_SCANNED {
            let [before, last] = inner;
            let outer = last.0 / SCAN_RATIO;
            let increase = self.increase(outer);
            if increase.is_nan() {
                break;
            }
            if increase <= 0.0 {
                return self.unstable_cycle_between(last.0, outer);
            }
            let passes_minimum = !self.has_no_inner_cycle() && last.1 < increase && last.1 <= before.1;
            let decrease = |a| -self.increase(a);
            if passes_minimum && let Some(beyond) = rise_to_zero((before.0, outer), UNRESOLVED, decrease) {
                return self.unstable_cycle_between(before.0, beyond);
            }
            inner = [last, (outer, increase)];
        }
        Surrounding::Unresolved
    }

    /// Points of a cycle, in turn, as `(x, x')`: at least `points`, the first one at its largest x.
    #[cfg(test)]
    pub fn outline(&self, cycle: &UnstableCycle, points: usize) -> Vec<(f64, f64)> {
        let mut outline = vec![(self.equilibrium() + cycle.outward, 0.0)];
        let longest = cycle.period / points as f64;
        self.follow(cycle.outward, longest, |&[d, w, ..]| outline.push((self.equilibrium() + d, -w)));
        outline
    }

    /// The cycle between an amplitude inside it and one that is not.
    fn unstable_cycle_between(&self, inside: f64, outside: f64) -> Surrounding {
        let (amplitude, _) = bisect((inside, outside), 100, 1e-15, |a| self.increase(a) > 0.0);
        match self.follow(amplitude, f64::INFINITY, |_| {}) {
            Swing::Turns { cycle, .. } => Surrounding::Cycle(cycle),
            Swing::Leaves | Swing::Unresolved => Surrounding::Unresolved,
        }
    }

    /// `[Q(a)^2 - a^2] / a^2`; minus infinity where the pad comes from the disc's speed.
    fn increase(&self, a: f64) -> f64 {
        match self.follow(a, f64::INFINITY, |_| {}) {
            Swing::Turns { increase, .. } => 2.0 * increase / (self.stiffness * a * a),
            Swing::Leaves => f64::NEG_INFINITY,
            Swing::Unresolved => f64::NAN,
        }
    }

    /// Simulates a swing backward in time from `d = a`, `w = 0`, in steps of at most `longest`; `visit` sees every
    /// state.
    fn follow(&self, a: f64, longest: f64, mut visit: impl FnMut(&State)) -> Swing {
        let frequency = self.stiffness.sqrt();
        let at_rest = self.law.coefficient(self.disc_speed);
        let rate = |[d, w, ..]: State| {
            let pull = self.law.coefficient(self.disc_speed + w) - at_rest + self.damping * w;
            [w, pull - self.stiffness * d, pull * w, w * w]
        };
        let step = |state: State, h: f64| dormand_prince::step(rate, state, h);
        let mut state = [a, 0.0, 0.0, 0.0];
        let mut ends = [state; 4];
        let (mut quarter, mut duration) = (0, 0.0);
        let mut h = (1e-3 / frequency).min(longest);
        for _ in 0..MOST_STEPS {
            let (mut next, error) = step(state, h);
            let size = a.max(state[0].abs()).max(state[1].abs() / frequency);
            let error = (error[0].abs() / size).max(error[1].abs() / (size * frequency)) / TOLERANCE;
            if error.is_nan() {
                break;
            }
            if error > 1.0 {
                h *= dormand_prince::growth(error);
                continue;
            }
            if self.leaves_disc_speed(state, next, h, rate) {
                return Swing::Leaves;
            }
            let remaining = QUARTERS[quarter];
            if remaining(&next) <= 0.0 {
                let ends_at = ((0.0, remaining(&state)), (h, remaining(&next)));
                let at = |part| step(state, part).0;
                let (part, end) = false_position(ends_at.0, ends_at.1, next, 1e-15 * h, at, remaining);
                duration += part;
                next = end;
                ends[quarter] = end;
                quarter += 1;
            } else {
                duration += h;
                h = (h * dormand_prince::growth(error)).min(longest);
            }
            visit(&next);
            if quarter == QUARTERS.len() {
                let [forward, inward, backward, last] = ends;
                let cycle = UnstableCycle {
                    period: duration,
                    outward: a,
                    inward: inward[0],
                    forward: -forward[1],
                    backward: -backward[1],
                    area: last[3],
                };
                return Swing::Turns { cycle, increase: last[2] };
            }
            state = next;
        }
        Swing::Unresolved
    }

    /// Whether the pad is as fast as the disc in the step `h` from `state` to `next`: at its end, or where its speed
    /// has a maximum in between.
    fn leaves_disc_speed(&self, state: State, next: State, h: f64, rate: impl Fn(State) -> State) -> bool {
        let v = self.disc_speed;
        if next[1] <= -v {
            return true;
        }
        let (before, after) = (rate(state)[1], rate(next)[1]);
        if before >= 0.0 || after <= 0.0 {
            return false;
        }
        let at = |part: f64| dormand_prince::step(&rate, state, part).0;
        let slowdown = |state: &State| -rate(*state)[1];
        let (_, fastest) = false_position((0.0, -before), (h, -after), next, 1e-15 * h, at, slowdown);
        fastest[1] <= -v
    }
}

#[cfg(test)]
mod tests;
