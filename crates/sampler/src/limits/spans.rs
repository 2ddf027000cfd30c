//! Between which expected values of preload or static friction one sample is unstable, in closed form.
//!
//! Every distribution is scaled by its expected value: at the expected value `v` the input of a sample is `v r`, with a
//! ratio `r` that its deviate alone determines (for a normal input `1 + sigma z`). So a sample that is unstable above a
//! critical input `c` is unstable for expected values above `c / r`.

use stickslip_core::rigid_disc::stability::StabilityBoundary;
use stickslip_core::verdict::Verdict;

/// The input whose expected value varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Varied {
    /// The preload.
    Preload,
    /// The static friction coefficient.
    StaticFriction,
}

/// What becomes of samples without preload or with friction that rises with speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutsidePhysics {
    /// They are stable.
    Stable,
    /// The input is raised to the border, and the sample decided there.
    Clamped,
    /// They have no verdict.
    WithoutVerdict,
}

/// One sample, for every expected value of the varied input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// The boundary of its brake.
    pub boundary: StabilityBoundary,
    /// The varied input over its expected value.
    pub ratio: f64,
    /// The other one of preload and static friction.
    pub other: f64,
    /// A static friction coefficient above this has no verdict; may be infinite.
    pub most_friction: f64,
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

    /// Those of a sample.
    ///
    /// ```
    /// use stickslip_core::parameters::Parameters;
    /// use stickslip_core::rigid_disc::pad_on_disc::PadOnDisc;
    /// use stickslip_sampler::limits::spans::{OutsidePhysics, Sample, Spans, Varied};
    /// let boundary = PadOnDisc::new(Parameters::sui_ding_2018())?.stability_boundary();
    /// let sample = Sample { boundary, ratio: 1.25, other: 0.39, most_friction: f64::INFINITY };
    /// let spans = Spans::of(&sample, Varied::Preload, OutsidePhysics::Stable);
    /// assert_eq!(spans.unstable, [boundary.critical_preload(0.39) / 1.25, f64::INFINITY]);
    /// # Ok::<(), stickslip_core::parameters::ParameterError>(())
    /// ```
    #[must_use]
    pub fn of(sample: &Sample, varied: Varied, outside: OutsidePhysics) -> Self {
        match varied {
            Varied::Preload => Self::along_preload(sample, outside),
            Varied::StaticFriction => Self::along_static_friction(sample, outside),
        }
    }

    fn along_preload(sample: &Sample, outside: OutsidePhysics) -> Self {
        let Sample { boundary, ratio, other, most_friction } = *sample;
        let least = boundary.least_static_coefficient();
        let is_outside = other < least || ratio <= 0.0;
        let friction = if outside == OutsidePhysics::Clamped { other.max(least) } else { other };
        if friction > most_friction || (is_outside && outside == OutsidePhysics::WithoutVerdict) {
            return Self::without_verdict();
        }
        // Infinite for friction outside physics.
        let critical = boundary.critical_preload(friction);
        let unstable = if ratio > 0.0 { [critical / ratio, f64::INFINITY] } else { NOWHERE };
        Self { unstable, without_verdict: [NOWHERE; 2] }
    }

    fn along_static_friction(sample: &Sample, outside: OutsidePhysics) -> Self {
        let Sample { boundary, ratio, other: preload, most_friction } = *sample;
        let least = boundary.least_static_coefficient();
        if preload <= 0.0 && outside == OutsidePhysics::WithoutVerdict {
            return Self::without_verdict();
        }
        let (mut above, below) = boundary.unstable_static_friction(preload);
        if outside == OutsidePhysics::Clamped && boundary.verdict(preload, least) == Verdict::Unstable {
            above = f64::NEG_INFINITY;
        }
        let too_little = if outside == OutsidePhysics::WithoutVerdict { [f64::NEG_INFINITY, least] } else { NOWHERE };
        Self {
            unstable: scaled([above, below.min(most_friction)], ratio),
            without_verdict: [scaled(too_little, ratio), scaled([most_friction.max(least), f64::INFINITY], ratio)],
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
