//! What is estimated, its limits, and the coordinate in which it has none.

use crate::inputs::Marginal;

/// Limits of the static friction coefficient, and of the true preload over the nominal one.
const FRICTION_LIMITS: [f64; 2] = [0.01, 5.0];
const FACTOR_LIMITS: [f64; 2] = [1e-3, 1e3];

/// The least relative standard deviation that is told from none.
pub(super) const LEAST_STD: f64 = 2e-3;

/// The largest correlation.
const MOST_CORRELATION: f64 = 0.9999;

/// Coordinates beyond this lie at a limit, within a thousandth of the range of the logarithm.
const AT_LIMIT: f64 = 7.0;

/// Something that may be estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FitParameter {
    /// The expected static friction coefficient.
    StaticFriction,
    /// The expected preload over the nominal one.
    PreloadFactor,
    /// The relative standard deviation of the preload.
    PreloadStd,
    /// The relative standard deviation of the static friction coefficient.
    StaticFrictionStd,
    /// The correlation of the deviates of both.
    Correlation,
}

/// A value for each of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitValues {
    /// See [`FitParameter::StaticFriction`].
    pub static_friction: f64,
    /// See [`FitParameter::PreloadFactor`].
    pub preload_factor: f64,
    /// See [`FitParameter::PreloadStd`].
    pub preload_std: f64,
    /// See [`FitParameter::StaticFrictionStd`].
    pub static_friction_std: f64,
    /// See [`FitParameter::Correlation`].
    pub correlation: f64,
}

impl FitParameter {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::StaticFriction, Self::PreloadFactor, Self::PreloadStd, Self::StaticFrictionStd, Self::Correlation];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::StaticFriction => "static_friction",
            Self::PreloadFactor => "preload_factor",
            Self::PreloadStd => "std.preload",
            Self::StaticFrictionStd => "std.static_friction",
            Self::Correlation => "correlation",
        }
    }
}

impl FitValues {
    /// One of them.
    #[must_use]
    pub fn get(&self, parameter: FitParameter) -> f64 {
        match parameter {
            FitParameter::StaticFriction => self.static_friction,
            FitParameter::PreloadFactor => self.preload_factor,
            FitParameter::PreloadStd => self.preload_std,
            FitParameter::StaticFrictionStd => self.static_friction_std,
            FitParameter::Correlation => self.correlation,
        }
    }

    /// Replaces one of them.
    pub fn set(&mut self, parameter: FitParameter, value: f64) {
        match parameter {
            FitParameter::StaticFriction => self.static_friction = value,
            FitParameter::PreloadFactor => self.preload_factor = value,
            FitParameter::PreloadStd => self.preload_std = value,
            FitParameter::StaticFrictionStd => self.static_friction_std = value,
            FitParameter::Correlation => self.correlation = value,
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
    /// The range of a parameter; the distributions of preload and static friction limit their standard deviations.
    pub(super) fn new(parameter: FitParameter, [preload, static_friction]: &[Marginal; 2]) -> Self {
        let [low, high] = match parameter {
            FitParameter::StaticFriction => FRICTION_LIMITS,
            FitParameter::PreloadFactor => FACTOR_LIMITS,
            FitParameter::PreloadStd => std_limits(preload),
            FitParameter::StaticFrictionStd => std_limits(static_friction),
            FitParameter::Correlation => {
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
