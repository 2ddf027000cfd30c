//! Sums of products as if computed in twice the precision, in a fixed order and without fused multiply-add.
//!
//! Ogita, Rump, Oishi: Accurate sum and dot product, SIAM J. Sci. Comput. 26 (2005) 1955. Products are split as by Dekker
//! (1971). The same bits on every processor.

/// A number as an unevaluated sum of two.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Compensated {
    high: f64,
    low: f64,
}

/// Sum and its rounding error, exact.
#[inline]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// Two halves of at most 26 bits that add up to the number.
#[inline]
fn split(a: f64) -> (f64, f64) {
    let scaled = 134_217_729.0 * a;
    let high = scaled - (scaled - a);
    (high, a - high)
}

/// Product and its rounding error, exact unless it overflows or underflows.
#[inline]
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let (ah, al) = split(a);
    let (bh, bl) = split(b);
    (product, al * bl - (((product - ah * bh) - al * bh) - ah * bl))
}

impl Compensated {
    /// Adds a product of two numbers.
    #[inline]
    pub(super) fn add_product(&mut self, a: f64, b: f64) {
        let (product, error) = two_product(a, b);
        let (sum, rounding) = two_sum(self.high, product);
        self.high = sum;
        self.low += rounding + error;
    }

    /// Adds the product of an unevaluated sum and a number.
    #[inline]
    pub(super) fn add_scaled(&mut self, a: Self, b: f64) {
        self.add_product(a.high, b);
        self.low += a.low * b;
    }

    /// The sum, rounded.
    pub(super) fn value(self) -> f64 {
        self.high + self.low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cancellation_leaves_the_right_digits() {
        let mut sum = Compensated::default();
        for (a, b) in [(1e16, 1.0), (0.1, 1.0), (1e8 + 1.0, 1e8 - 1.0), (-1e8, 1e8), (-1e16, 1.0)] {
            sum.add_product(a, b);
        }
        // (1e8 + 1)(1e8 - 1) = 1e16 - 1.
        assert_eq!(sum.value(), 0.1 - 1.0);
    }
}
