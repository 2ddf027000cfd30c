//! The boundary of stability in two quantities, in closed form.

use crate::model::verdict::{Verdict, VerdictCounts};

/// The largest limit state.
const FARTHEST: f64 = 700.0;

/// The hyperbola `a (b - b_0) = critical_product` that separates stable from unstable samples in the plane of two
/// quantities `a` and `b`, called the first and the second. For a pad or an oscillator with friction these are what
/// presses, and the static friction coefficient.
///
/// Unstable is `a (by_second b + offset) > critical_product` where `a` is positive and `b` at least `least_second`.
/// Other samples are outside the model, and stable by definition. (The bare product would call "both negative" unstable.)
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairBoundary {
    /// `a (b - b_0)` on the boundary; non-negative, infinite where nothing is ever unstable.
    pub critical_product: f64,
    /// 1 where samples are unstable above the boundary in the second quantity, -1 where below, 0 where it has no effect.
    pub by_second: f64,
    /// `-b_0` times `by_second`.
    pub offset: f64,
    /// Below it the second quantity is outside the model.
    pub least_second: f64,
}

impl PairBoundary {
    /// `b_0`, the second quantity to which the boundary tends as the first grows.
    #[must_use]
    pub fn asymptote(&self) -> f64 {
        if self.by_second == 0.0 { f64::INFINITY } else { -self.offset / self.by_second }
    }

    /// Whether instability lies above the boundary in the second quantity.
    #[must_use]
    pub fn is_unstable_above(&self) -> bool {
        self.by_second > 0.0
    }

    /// The second quantity on the boundary at a given first one; infinite for first ones that are not positive, and
    /// where there is none above which samples are unstable.
    #[must_use]
    pub fn critical_second(&self, first: f64) -> f64 {
        if first > 0.0 && self.is_unstable_above() {
            (self.critical_product / first - self.offset).max(self.least_second)
        } else {
            f64::INFINITY
        }
    }

    /// The second quantities with which samples are unstable at a given first one: those above the first number and
    /// below the second. Both are infinite if there are none.
    #[must_use]
    pub fn unstable_second(&self, first: f64) -> (f64, f64) {
        const NONE: (f64, f64) = (f64::INFINITY, f64::INFINITY);
        if self.by_second > 0.0 || first.is_nan() || first <= 0.0 {
            return (self.critical_second(first), f64::INFINITY);
        }
        let needed = self.critical_product / first;
        let highest = if self.by_second < 0.0 {
            self.offset - needed
        } else if self.offset > needed {
            f64::INFINITY
        } else {
            return NONE;
        };
        if highest > self.least_second { (self.least_second, highest) } else { NONE }
    }

    /// The first quantity on the boundary at a given second one, above which samples are unstable; infinite where none
    /// is.
    #[must_use]
    pub fn critical_first(&self, second: f64) -> f64 {
        let driving = self.driving(second);
        if driving > 0.0 && second >= self.least_second { self.critical_product / driving } else { f64::INFINITY }
    }

    /// The derivative of [`PairBoundary::critical_first`]; zero where that is infinite.
    #[must_use]
    pub fn critical_first_slope(&self, second: f64) -> f64 {
        let critical = self.critical_first(second);
        if critical.is_finite() { -critical * self.by_second / self.driving(second) } else { 0.0 }
    }

    /// What the first quantity is multiplied by.
    #[inline]
    fn driving(&self, second: f64) -> f64 {
        self.by_second * second + self.offset
    }

    /// The verdict on one sample.
    #[inline]
    #[must_use]
    pub fn verdict(&self, first: f64, second: f64) -> Verdict {
        if self.is_unstable(first, second) { Verdict::Unstable } else { Verdict::Stable }
    }

    #[inline]
    fn is_unstable(&self, first: f64, second: f64) -> bool {
        let driving = first * self.driving(second);
        // `&`, not `&&`: the loop over samples then has no branches and runs in vector registers.
        (first > 0.0) & (second >= self.least_second) & (driving > self.critical_product)
    }

    /// A limit state: `ln(critical_product / (a (by_second b + offset)))`, below zero where samples are unstable, from -700
    /// to 700. Samples outside the model have 700.
    #[must_use]
    pub fn limit_state(&self, first: f64, second: f64) -> f64 {
        let driving = self.driving(second);
        if !(first > 0.0 && second >= self.least_second && driving > 0.0) {
            return FARTHEST;
        }
        libm::log(self.critical_product / (first * driving)).clamp(-FARTHEST, FARTHEST)
    }

    /// The verdicts on samples `(firsts[i], seconds[i])`, counted.
    ///
    /// # Panics
    /// If the slices differ in length.
    #[inline]
    #[must_use]
    pub fn count(&self, firsts: &[f64], seconds: &[f64]) -> VerdictCounts {
        assert_eq!(firsts.len(), seconds.len());
        let unstable = firsts.iter().zip(seconds).map(|(&a, &b)| u64::from(self.is_unstable(a, b))).sum();
        VerdictCounts { stable: firsts.len() as u64 - unstable, unstable, ..VerdictCounts::default() }
    }
}
