//! A random input as a coordinate of the map.

use crate::integrate::derivatives::DeviateMoments;
use crate::special_functions::normal;

/// A normal input as a coordinate of the plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Input {
    pub(super) expected: f64,
    /// Standard deviation; 0 for an input that does not scatter.
    pub(super) spread: f64,
}

impl Input {
    /// Whether it scatters.
    pub(super) fn scatters(&self) -> bool {
        self.spread != 0.0
    }

    /// The deviate at a coordinate.
    pub(super) fn deviate(&self, coordinate: f64) -> f64 {
        // Clamped, as zero times infinity is not zero.
        ((coordinate - self.expected) / self.spread).clamp(-40.0, 40.0)
    }

    /// The coordinate at a deviate.
    pub(super) fn coordinate(&self, deviate: f64) -> f64 {
        self.expected + self.spread * deviate
    }

    /// The probabilities and moments on both sides of a coordinate.
    pub(super) fn edge(&self, coordinate: f64) -> Edge {
        if !self.scatters() {
            // All probability is at one point, which belongs to the box that begins there.
            let above = self.expected >= coordinate;
            let (lower, upper) = if above { (0.0, 1.0) } else { (1.0, 0.0) };
            return Edge { deviate: lower - upper, lower, upper, first: 0.0, second: 0.0 };
        }
        let deviate = self.deviate(coordinate);
        let tail = normal::upper_tail(deviate.abs());
        let (lower, upper) = if deviate > 0.0 { (1.0 - tail, tail) } else { (tail, 1.0 - tail) };
        let density = normal::density(deviate);
        Edge { deviate, lower, upper, first: density, second: deviate * density }
    }
}

/// A boundary between two intervals of an input.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    pub(super) deviate: f64,
    /// Probability below it.
    lower: f64,
    /// Probability above it.
    upper: f64,
    /// The integrals of `z` and of `z^2 - 1` above it: `phi(z)` and `z phi(z)`.
    first: f64,
    second: f64,
}

impl Edge {
    pub(super) const START: Self = Self { deviate: -40.0, lower: 0.0, upper: 1.0, first: 0.0, second: 0.0 };
    pub(super) const END: Self = Self { deviate: 40.0, lower: 1.0, upper: 0.0, first: 0.0, second: 0.0 };

    /// The probability between this edge and a higher one, from the tails in which nothing cancels.
    pub(super) fn mass_to(&self, end: &Self) -> f64 {
        if self.deviate > 0.0 { self.upper - end.upper } else { end.lower - self.lower }
    }

    /// The moments between this edge and a higher one.
    pub(super) fn moments_to(&self, end: &Self) -> DeviateMoments {
        [self.mass_to(end), self.first - end.first, self.second - end.second]
    }
}
