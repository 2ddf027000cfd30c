//! Between which expected values of one of two inputs a sample is unstable, in closed form.
//!
//! Every distribution is scaled by its expected value: at the expected value `v` the input of a sample is `v r`, with a
//! ratio `r` that its deviate alone determines (for a normal input `1 + sigma z`). So a sample that is unstable above a
//! critical input `c` is unstable for expected values above `c / r`.

use stickslip_core::model::pair_boundary::PairBoundary;

/// What happens to samples outside the model: whose first input is not positive, or whose second is below the least.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutsidePhysics {
    /// They are stable, where they are or moved to the edge of the model: nothing is unstable there.
    Stable,
    /// They have no verdict.
    WithoutVerdict,
}

/// One sample, for every expected value of the varied input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Its boundary of stability.
    pub boundary: PairBoundary,
    /// The varied input over its expected value.
    pub ratio: f64,
    /// The other input.
    pub other: f64,
    /// A second input above this has no verdict; may be infinite.
    pub most_second: f64,
}

/// An open interval of expected values; it is empty if it does not begin before it ends.
pub type Span = [f64; 2];

/// Nowhere.
const NOWHERE: Span = [0.0, 0.0];

/// Everywhere.
const EVERYWHERE: Span = [f64::NEG_INFINITY, f64::INFINITY];

/// Where a sample is unstable, and where it has no verdict, for expected values above 0. These do not overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spans {
    /// Where it is unstable.
    pub unstable: Span,
    /// Where it has no verdict.
    pub without_verdict: [Span; 2],
}

impl Spans {
    /// Those of a sample without a verdict anywhere.
    #[must_use]
    pub fn without_verdict() -> Self {
        Self { unstable: NOWHERE, without_verdict: [EVERYWHERE, NOWHERE] }
    }

    /// Those of a sample along the expected value of the input `varied`: the first (0) or the second (1).
    ///
    /// ```
    /// use stickslip_core::model::pair_boundary::PairBoundary;
    /// use stickslip_sampler::limits::spans::{OutsidePhysics, Sample, Spans};
    /// let boundary = PairBoundary { critical_product: 0.01, by_second: 1.0, offset: -0.25, least_second: 0.25 };
    /// let sample = Sample { boundary, ratio: 1.25, other: 0.39, most_second: f64::INFINITY };
    /// let spans = Spans::new(&sample, 0, OutsidePhysics::Stable);
    /// assert_eq!(spans.unstable, [boundary.critical_first(0.39) / 1.25, f64::INFINITY]);
    /// ```
    #[must_use]
    pub fn new(sample: &Sample, varied: usize, outside: OutsidePhysics) -> Self {
        if varied == 0 { Self::along_first(sample, outside) } else { Self::along_second(sample, outside) }
    }

    fn along_first(sample: &Sample, outside: OutsidePhysics) -> Self {
        let Sample { boundary, ratio, other, most_second } = *sample;
        let least = boundary.least_second;
        let is_outside = other < least || ratio <= 0.0;
        if other > most_second || (is_outside && outside == OutsidePhysics::WithoutVerdict) {
            return Self::without_verdict();
        }
        // Infinite for second inputs outside the model.
        let critical = boundary.critical_first(other);
        let unstable = if ratio > 0.0 { [critical / ratio, f64::INFINITY] } else { NOWHERE };
        Self { unstable, without_verdict: [NOWHERE; 2] }
    }

    fn along_second(sample: &Sample, outside: OutsidePhysics) -> Self {
        let Sample { boundary, ratio, other: first, most_second } = *sample;
        let least = boundary.least_second;
        if first <= 0.0 && outside == OutsidePhysics::WithoutVerdict {
            return Self::without_verdict();
        }
        let (above, below) = boundary.unstable_second(first);
        let too_little = if outside == OutsidePhysics::WithoutVerdict { [f64::NEG_INFINITY, least] } else { NOWHERE };
        Self {
            unstable: scaled([above, below.min(most_second)], ratio),
            without_verdict: [scaled(too_little, ratio), scaled([most_second.max(least), f64::INFINITY], ratio)],
        }
    }
}

/// The expected values at which `ratio` times them lies in a span.
fn scaled([from, to]: Span, ratio: f64) -> Span {
    if from >= to {
        NOWHERE
    } else if ratio > 0.0 {
        [from / ratio, to / ratio]
    } else if ratio < 0.0 {
        [to / ratio, from / ratio]
    } else if from < 0.0 && 0.0 < to {
        EVERYWHERE
    } else {
        NOWHERE
    }
}

#[cfg(test)]
mod tests;
