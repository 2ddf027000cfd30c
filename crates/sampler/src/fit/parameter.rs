//! What is estimated, its limits, and the coordinate in which it has none.

use crate::inputs::{Marginal, PairParameter};

/// Limits of the true first input over the nominal one, and of the expected second input.
const EXPECTED_LIMITS: [[f64; 2]; 2] = [[1e-3, 1e3], [0.01, 5.0]];

/// The least relative standard deviation that is distinguished from none.
pub(super) const LEAST_STD: f64 = 2e-3;

/// The largest correlation.
const MOST_CORRELATION: f64 = 0.9999;

/// Coordinates beyond this lie at a limit, within a thousandth of the range of the logarithm.
const AT_LIMIT: f64 = 7.0;

/// All that may be estimated, in the order of coordinates and of results. The expected value of the first input is
/// estimated as its factor on the nominal one.
pub const ESTIMABLE: [PairParameter; 5] = [
    PairParameter::Expected(1),
    PairParameter::Expected(0),
    PairParameter::RelativeStd(0),
    PairParameter::RelativeStd(1),
    PairParameter::Correlation,
];

/// A value for each parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitValues {
    /// The expected first input over the nominal one, and the expected second input.
    pub expected: [f64; 2],
    /// The relative standard deviations.
    pub relative_std: [f64; 2],
    /// The correlation of the deviates of both.
    pub correlation: f64,
}

impl FitValues {
    /// One of them.
    #[must_use]
    pub fn get(&self, parameter: PairParameter) -> f64 {
        match parameter {
            PairParameter::Expected(input) => self.expected[input],
            PairParameter::RelativeStd(input) => self.relative_std[input],
            PairParameter::Correlation => self.correlation,
        }
    }

    /// Replaces one of them.
    pub fn set(&mut self, parameter: PairParameter, value: f64) {
        match parameter {
            PairParameter::Expected(input) => self.expected[input] = value,
            PairParameter::RelativeStd(input) => self.relative_std[input] = value,
            PairParameter::Correlation => self.correlation = value,
        }
    }
}

/// The range of a parameter, and its coordinate on the whole line: `low + (high - low) / (1 + exp(-y))` is the logarithm
/// of the value, or the inverse hyperbolic tangent of a correlation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Range {
    is_correlation: bool,
    low: f64,
    high: f64,
}

impl Range {
    /// The range of a parameter; the distributions of the inputs limit their standard deviations.
    pub(super) fn new(parameter: PairParameter, marginals: &[Marginal; 2]) -> Self {
        let [low, high] = match parameter {
            PairParameter::Expected(input) => EXPECTED_LIMITS[input],
            PairParameter::RelativeStd(input) => std_limits(&marginals[input]),
            PairParameter::Correlation => {
                let high = libm::atanh(MOST_CORRELATION);
                return Self { is_correlation: true, low: -high, high };
            }
        };
        Self { is_correlation: false, low: libm::log(low), high: libm::log(high) }
    }

    /// The value at a coordinate.
    pub(super) fn value(&self, y: f64) -> f64 {
        let x = self.low + (self.high - self.low) / (1.0 + libm::exp(-y));
        if self.is_correlation { libm::tanh(x) } else { libm::exp(x) }
    }

    /// The coordinate of a value; of one beyond the limits, that of a value a little within.
    pub(super) fn coordinate(&self, value: f64) -> f64 {
        let x = if self.is_correlation { libm::atanh(value) } else { libm::log(value) };
        let share = ((x - self.low) / (self.high - self.low)).clamp(0.01, 0.99);
        libm::log(share / (1.0 - share))
    }

    /// The limit at which a coordinate lies.
    pub(super) fn limit(&self, y: f64) -> Option<f64> {
        (y.abs() > AT_LIMIT).then(|| self.value(if y > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY }))
    }
}

/// The relative standard deviations that a distribution can have.
fn std_limits(marginal: &Marginal) -> [f64; 2] {
    let exists = |std: f64| marginal.check_scatter(std).is_ok();
    // One that exists, between whose neighbours and itself the ends are sought.
    let inner = [0.1, 0.03, 0.3, 0.01, 1.0].into_iter().find(|&std| exists(std)).unwrap_or(LEAST_STD);
    [LEAST_STD, 10.0].map(|end| {
        if exists(end) {
            return end;
        }
        let (mut good, mut bad) = (inner, end);
        for _ in 0..60 {
            let middle = (good * bad).sqrt();
            if exists(middle) { good = middle } else { bad = middle }
        }
        good
    })
}
