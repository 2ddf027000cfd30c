//! A segment of a boundary between two verdicts, written as polynomials.
//!
//! The segment is the graph of one coordinate of the plane, the ordinate, over an interval of the other, the abscissa.
//! On one side of it every sample has one verdict, on the other side another. Where samples of a third kind lie between
//! them (those that are undecided at the horizon), either side has a graph of its own.

use stickslip_core::model::verdict::Verdict;

/// Chebyshev nodes of a segment: one more than the degree of its polynomials.
pub const NODES: usize = 8;

/// Coordinates in the plane: the first input, and the second above its origin.
pub type Point = [f64; 2];

/// A rectangle of the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Box2 {
    /// Lower ends, along the first and the second coordinate.
    pub low: Point,
    /// Upper ends.
    pub high: Point,
}

/// The segment of a boundary in a box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundaryCurve {
    /// Which coordinate is the abscissa: 0 the first, 1 the second.
    pub abscissa: usize,
    /// The verdict where the ordinate is below the graph.
    pub below: Verdict,
    /// The verdict where it is above.
    pub above: Verdict,
    /// Chebyshev coefficients, on the box, of the highest ordinate that is known to be below.
    pub lower: [f64; NODES],
    /// Chebyshev coefficients of the lowest ordinate that is known to be above.
    pub upper: [f64; NODES],
    /// Margin of error of both.
    pub guard: f64,
}

impl BoundaryCurve {
    /// The ordinates between which the verdict is unknown, at the abscissa `coordinate`: it is `below` up to the first
    /// and `above` from the second.
    #[must_use]
    pub fn gap(&self, within: &Box2, coordinate: f64) -> (f64, f64) {
        let t = scaled(within, self.abscissa, coordinate);
        (clenshaw(&self.lower, t) - self.guard, clenshaw(&self.upper, t) + self.guard)
    }

    /// The verdict at a point of the box; `None` within the resolution of the curve.
    #[inline]
    #[must_use]
    pub(crate) fn verdict(&self, within: &Box2, point: Point) -> Option<Verdict> {
        let (low, high) = self.gap(within, point[self.abscissa]);
        let value = point[1 - self.abscissa];
        if value < low {
            Some(self.below)
        } else if value > high {
            Some(self.above)
        } else {
            None
        }
    }
}

/// The coordinate scaled to -1 to 1 across the box.
fn scaled(within: &Box2, axis: usize, coordinate: f64) -> f64 {
    (2.0 * coordinate - within.low[axis] - within.high[axis]) / (within.high[axis] - within.low[axis])
}

/// The Chebyshev series at `t`, by Clenshaw's recurrence.
fn clenshaw(coefficients: &[f64; NODES], t: f64) -> f64 {
    let (mut b1, mut b2) = (0.0, 0.0);
    for &coefficient in coefficients[1..].iter().rev() {
        (b1, b2) = (coefficient + 2.0 * t * b1 - b2, b1);
    }
    coefficients[0] + t * b1 - b2
}
