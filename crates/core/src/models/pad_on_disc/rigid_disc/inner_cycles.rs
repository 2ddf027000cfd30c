//! Which swings have no stable limit cycle inside them: there, a swing that shrinks comes to rest.
//!
//! With the sliding speed `s = v - u` of a pad that moves at `u = x'`, slip about a linearly stable equilibrium is
//! `u' = F(u) - F(0) - C u - K (x - x0)`, `F(u) = G mu(v - u)`. Let `f = C - F'` be its damping. If
//!
//! ```text
//! g(u) = F'(u) - u F''(u) - C  <=  0        at all speeds of a swing and of what lies inside it,
//! ```
//!
//! then `f / u` falls on both sides of `u = 0`, because its derivative is `g / u^2`. That is the condition of Zhang's
//! theorem on Lienard's equation (Zhang Zhifen et al., *Qualitative Theory of Differential Equations*, chapter 4) with
//! time running backwards: there is one cycle at most, and it repels. A motion that shrinks stays inside its own swing,
//! and ends at rest or on a cycle that attracts; there is none, so it comes to rest. Outside the speeds of the swing,
//! friction can be replaced by any other for which `f / u` falls, so only these speeds count.
//!
//! * For `u = 0` the condition is linear stability, and the derivative of g is `-u F'''`. All derivatives of
//!   `exp(-r^delta)` for exponents up to 1 and of `1 / (1 + r)` alternate in sign, so that `F''' > 0` and the condition
//!   holds at any speed. A viscous term `k |s|` adds the constant `-G k` to F': it is damping.
//! * For exponents above 1, `F'''` is positive where `p = r^delta` exceeds
//!   `[3 (delta - 1) + sqrt((delta - 1) (5 delta - 1))] / (2 delta)`, negative below that, and for exponents above 2 it
//!   is positive again below the same with the other sign of the root. A disc slower than the first of these is left to
//!   the return map: then `F''' < 0` at `u = 0`, and g rises on the other side.
//! * In every cubic of a measured curve `F'''` is constant, and g is largest at one of its ends or, in the one around
//!   the disc's speed, at `u = 0`, where the condition is linear stability.
//!
//! The speeds of a swing from `x0 + a` to `x0 - b` and on to `x0 + a'` are bounded by its energy. Say the pad moves up,
//! no faster than U, and up to this speed friction exceeds that of steady sliding by `P` at most and falls below it by
//! `D - C U` at most. Its energy about `x0 + P / K` does not grow after the bottom, and its top speed is passed at
//! `K (x - x0) >= -D`, from where it loses no more than D times the distance to the top:
//!
//! ```text
//! u  <=  sqrt(K) (b + P / K),      u^2  <=  K a'^2 + 2 D (a' + D / K)
//! ```
//!
//! The same holds for the way down with a and b in place of b and a'.

use crate::friction::law::FrictionLaw;
use crate::friction::shape::Shape;
use crate::models::pad_on_disc::rigid_disc::planar_motion::PlanarMotion;

/// How often a bound of the speeds is improved by what friction can do at these speeds.
const IMPROVEMENTS: usize = 4;

/// A swing by the distances of its turning points from the equilibrium: two at the largest x, and the one between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Turns {
    pub top: f64,
    pub bottom: f64,
    pub next_top: f64,
}

impl PlanarMotion {
    /// Whether no stable cycle lies inside any swing that does not meet the disc's speed.
    pub fn has_no_inner_cycle(&self) -> bool {
        self.law.is_completely_monotone() && self.damping_at_equilibrium() > 0.0
    }

    /// Whether no stable cycle lies inside a swing that has not met the disc's speed; false also where that is not
    /// known.
    pub fn has_no_cycle_inside(&self, swing: Turns) -> bool {
        let is_stable = self.damping_at_equilibrium() > 0.0 && self.damping >= 0.0;
        if !is_stable || self.law.is_completely_monotone() {
            return is_stable;
        }
        match self.law.shape {
            Shape::Table(_) => self.table_has_no_cycle_inside(swing),
            _ => self.stribeck_has_no_cycle_inside(swing),
        }
    }

    /// g at the sliding speed `s`, with the slope and the curvature of friction there.
    fn condition(&self, s: f64, slope: f64, curvature: f64) -> f64 {
        -slope - (self.disc_speed - s) * curvature - self.damping
    }

    /// A bound of the speed of a half swing from one turning point to the next, `at_most` at most; `friction` bounds P
    /// and D for speeds up to its argument.
    fn fastest(&self, (start, end): (f64, f64), at_most: f64, friction: impl Fn(f64) -> (f64, f64)) -> f64 {
        let k = self.stiffness;
        (0..IMPROVEMENTS).fold(at_most, |fastest: f64, _| {
            let (push, drag) = friction(fastest);
            let from_start = k.sqrt() * (start + push / k);
            let to_end = (k * end * end + 2.0 * drag * (end + drag / k)).sqrt();
            fastest.min(from_start).min(to_end)
        })
    }

    /// For Stribeck's law with an exponent above 1.
    fn stribeck_has_no_cycle_inside(&self, swing: Turns) -> bool {
        let (law, v, delta) = (self.law, self.disc_speed, self.law.exponent);
        let root = ((delta - 1.0) * (5.0 * delta - 1.0)).sqrt();
        let change_of_sign = |root: f64| {
            law.speed_scale * libm::pow(((3.0 * (delta - 1.0) + root) / (2.0 * delta)).max(0.0), 1.0 / delta)
        };
        let outer = change_of_sign(root);
        if v <= outer || law.falling() < 0.0 {
            return false;
        }
        let falling = FrictionLaw { additional: 0.0, ..law };
        let at_v = falling.coefficient(v);
        let drag = self.damping + law.additional / law.speed_scale;
        let up = |speed: f64| (falling.coefficient(v - speed) - at_v, drag * speed);
        let least = v - self.fastest((swing.bottom, swing.next_top), v, up);
        if least >= outer {
            return true;
        }
        let steepest = if delta > 2.0 { least.max(change_of_sign(-root)) } else { least };
        steepest > 0.0 && self.condition(steepest, -law.fall(steepest), law.curvature(steepest)) <= 0.0
    }

    fn table_has_no_cycle_inside(&self, swing: Turns) -> bool {
        let (law, v, c) = (self.law, self.disc_speed, self.damping);
        let at_v = law.coefficient(v);
        let scale = law.speed_scale;
        // Each piece, as far as it lies between two sliding speeds.
        let between = |from: f64, to: f64| {
            law.pieces_between(from, to).filter_map(move |piece| {
                let (from, to) = (piece.from.max(from / scale), piece.to.min(to / scale));
                (from < to).then_some((piece, from, to))
            })
        };
        // How far friction rises and falls from its value at v.
        let range = |from: f64, to: f64| {
            between(from, to).fold((0.0_f64, 0.0_f64), |(rise, fall), (piece, from, to)| {
                let (least, most) = piece.bounds(from, to);
                (rise.max(most - at_v), fall.max(at_v - least))
            })
        };
        let up = |speed: f64| {
            let (rise, fall) = range(v - speed, v);
            (rise, fall + c * speed)
        };
        let down = |speed: f64| {
            let (rise, fall) = range(v, v + speed);
            (fall, rise + c * speed)
        };
        let least = v - self.fastest((swing.bottom, swing.next_top), v, up);
        let most = v + self.fastest((swing.top, swing.bottom), f64::MAX, down);
        between(least, most).all(|(piece, from, to)| {
            [from, to]
                .into_iter()
                .all(|r| self.condition(r * scale, piece.slope(r) / scale, piece.curvature(r) / (scale * scale)) <= 0.0)
        })
    }
}

#[cfg(test)]
mod tests;
