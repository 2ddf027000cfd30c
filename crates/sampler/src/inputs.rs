//! Random inputs: what standard normal deviates become, and how they are correlated.
//!
//! Input `i` is `F_i^-1(Phi(y_i))`, where `F_i` is the distribution function of its [`Marginal`] and `y = L z` are
//! normal deviates with a given [`Correlation`], made from independent ones `z` by the Cholesky factor `L`. Inputs
//! joined in this way have a Gaussian copula (R. B. Nelsen, An Introduction to Copulas, 2nd ed. 2006, section 2.3).

use std::f64::consts::FRAC_1_SQRT_2;

use thiserror::Error;

use crate::normal;

/// Relative standard deviation of a uniform input that reaches down to zero, `1 / sqrt(3)`.
const WIDEST_UNIFORM: f64 = 0.577_350_269_189_625_8;

/// Standard deviations beyond which a truncated normal input may not be confined; the normal one would get there with
/// a probability of 6e-16.
const FARTHEST_INTERVAL: f64 = 8.0;

/// The distribution of one input of expected value `m > 0` and relative standard deviation `s >= 0`, its standard
/// deviation being `s m`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Marginal {
    /// Normal: `m (1 + s z)`. Not positive with probability `Phi(-1 / s)`.
    Normal,
    /// Lognormal, with exactly this expected value and standard deviation: `m exp(t z - t^2 / 2)`,
    /// `t^2 = ln(1 + s^2)`.
    Lognormal,
    /// Uniform from `m (1 - s sqrt(3))` to `m (1 + s sqrt(3))`, for `s <= 1 / sqrt(3)`.
    Uniform,
    /// Normal of expected value `m` and standard deviation `s m` before it is confined to the values from
    /// `m (1 + s low)` to `m (1 + s high)`.
    ///
    /// What is cut off shifts and narrows it: with `P = Phi(high) - Phi(low)` and
    /// `d = (phi(low) - phi(high)) / P`, its expected value is `m (1 + s d)`, which is `m` if `low = -high`, and its
    /// variance `(s m)^2 (1 + (low phi(low) - high phi(high)) / P - d^2)` (N. L. Johnson, S. Kotz, N. Balakrishnan,
    /// Continuous Univariate Distributions, vol. 1, 2nd ed. 1994, section 13.10.1).
    TruncatedNormal {
        /// Lower end, in standard deviations from the expected value; may be minus infinity.
        low: f64,
        /// Upper end, in standard deviations from the expected value; may be infinity.
        high: f64,
    },
}

/// Why a marginal distribution was refused.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum MarginalError {
    /// The expected value is zero, negative, infinite or NaN.
    #[error("the expected value is {value}; it must be positive and finite")]
    Expected {
        /// The expected value.
        value: f64,
    },
    /// The relative standard deviation is negative, infinite or NaN.
    #[error("the relative standard deviation is {value}; it must be 0 or more, and finite")]
    RelativeStd {
        /// The relative standard deviation.
        value: f64,
    },
    /// A uniform distribution that includes negative values.
    #[error(
        "a uniform input with a relative standard deviation of {value} would become negative; \
         the largest possible is 1/sqrt(3) = 0.57735"
    )]
    UniformTooWide {
        /// The relative standard deviation.
        value: f64,
    },
    /// The ends of a truncated normal distribution in the wrong order, equal or NaN.
    #[error("nothing lies between low = {low} and high = {high}; low must be less than high")]
    NoInterval {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// A truncated normal distribution confined to where the normal one never gets.
    #[error(
        "the interval from {low} to {high} is more than 8 standard deviations away from the expected value; \
         low and high count standard deviations, not values of the input"
    )]
    IntervalTooFar {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
}

impl Marginal {
    /// Whether the distribution exists with this expected value and relative standard deviation.
    ///
    /// # Errors
    /// [`MarginalError`] if it does not.
    pub fn check(&self, expected: f64, relative_std: f64) -> Result<(), MarginalError> {
        if !(expected > 0.0 && expected.is_finite()) {
            return Err(MarginalError::Expected { value: expected });
        }
        if !(relative_std >= 0.0 && relative_std.is_finite()) {
            return Err(MarginalError::RelativeStd { value: relative_std });
        }
        match *self {
            Self::Uniform if relative_std > WIDEST_UNIFORM => {
                Err(MarginalError::UniformTooWide { value: relative_std })
            }
            Self::TruncatedNormal { low, high } if low.is_nan() || high.is_nan() || low >= high => {
                Err(MarginalError::NoInterval { low, high })
            }
            Self::TruncatedNormal { low, high } if low > FARTHEST_INTERVAL || high < -FARTHEST_INTERVAL => {
                Err(MarginalError::IntervalTooFar { low, high })
            }
            Self::Normal | Self::Lognormal | Self::Uniform | Self::TruncatedNormal { .. } => Ok(()),
        }
    }

    /// The input that the standard normal deviate `z` becomes, for `|z| <= 37`; it rises with `z`.
    ///
    /// Only meaningful where [`Marginal::check`] finds no error.
    ///
    /// ```
    /// use stickslip_sampler::Marginal;
    /// assert_eq!(Marginal::Normal.value(0.4, 0.1, 1.5), 0.4 * (1.0 + 0.1 * 1.5));
    /// assert_eq!(Marginal::Uniform.value(0.4, 0.1, 0.0), 0.4);
    /// ```
    #[inline]
    #[must_use]
    pub fn value(&self, expected: f64, relative_std: f64, z: f64) -> f64 {
        self.transform(relative_std).value(expected, z)
    }

    /// Replaces each standard normal deviate by the input that it becomes, as [`Marginal::value`] does one by one,
    /// but what does not depend on the deviate is computed once.
    #[inline]
    pub fn apply(&self, expected: f64, relative_std: f64, deviates: &mut [f64]) {
        let transform = self.transform(relative_std);
        for deviate in deviates {
            *deviate = transform.value(expected, *deviate);
        }
    }

    #[inline]
    fn transform(&self, relative_std: f64) -> Transform {
        match *self {
            Self::Normal => Transform::Normal { relative_std },
            Self::Lognormal => {
                let log_variance = libm::log1p(relative_std * relative_std);
                Transform::Lognormal { log_std: log_variance.sqrt(), shift: 0.5 * log_variance }
            }
            Self::Uniform => Transform::Uniform { half_width: relative_std * 3.0_f64.sqrt() },
            Self::TruncatedNormal { low, high } => Transform::TruncatedNormal {
                relative_std,
                low,
                high,
                below: [normal::upper_tail(-low), normal::upper_tail(-high)],
                above: [normal::upper_tail(low), normal::upper_tail(high)],
            },
        }
    }
}

/// A marginal distribution with its constants.
#[derive(Debug, Clone, Copy)]
enum Transform {
    Normal {
        relative_std: f64,
    },
    Lognormal {
        log_std: f64,
        shift: f64,
    },
    Uniform {
        /// Half of the interval, over the expected value.
        half_width: f64,
    },
    TruncatedNormal {
        relative_std: f64,
        low: f64,
        high: f64,
        /// Probabilities below the two ends, of the normal distribution.
        below: [f64; 2],
        /// Probabilities above the two ends.
        above: [f64; 2],
    },
}

impl Transform {
    #[inline]
    fn value(&self, expected: f64, z: f64) -> f64 {
        match *self {
            Self::Normal { relative_std } => expected * (1.0 + relative_std * z),
            Self::Lognormal { log_std, shift } => expected * libm::exp(log_std * z - shift),
            Self::Uniform { half_width } => {
                let x = z * FRAC_1_SQRT_2;
                // 2 Phi(z) - 1 = erf(x) = erfc(-x) - 1. Near the lower end, which may be zero, only the latter leaves
                // the small distance from it exact; the upper end is never small.
                if z < -1.0 {
                    expected * ((1.0 - half_width) + half_width * libm::erfc(-x))
                } else {
                    expected * (1.0 + half_width * libm::erf(x))
                }
            }
            Self::TruncatedNormal { relative_std, low, high, below, above } => {
                // Phi(x) = Phi(low) + (Phi(high) - Phi(low)) Phi(z) and 1 - Phi(x), each as a sum without
                // cancellation; the smaller of them gives x.
                let tail = normal::upper_tail(z.abs());
                let [upper, lower] = if z < 0.0 { [1.0 - tail, tail] } else { [tail, 1.0 - tail] };
                let probability = below[0] * upper + below[1] * lower;
                let complement = above[0] * upper + above[1] * lower;
                let x = if probability < complement {
                    normal::quantile(probability)
                } else {
                    -normal::quantile(complement)
                };
                expected * (1.0 + relative_std * x.clamp(low, high))
            }
        }
    }
}

/// Why a correlation was refused. Inputs are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum CorrelationError {
    /// An input that does not exist.
    #[error("there is no input {input}; the {inputs} inputs are numbered from 0")]
    NoInput {
        /// The number given.
        input: usize,
        /// How many inputs there are.
        inputs: usize,
    },
    /// An input correlated with itself.
    #[error("input {input} is paired with itself; a correlation joins two different inputs")]
    SameInput {
        /// The input.
        input: usize,
    },
    /// A coefficient that is not between -1 and 1, or NaN.
    #[error("the correlation of inputs {first} and {second} is {coefficient}; it must lie between -1 and 1")]
    OutOfRange {
        /// One input.
        first: usize,
        /// The other.
        second: usize,
        /// The coefficient given.
        coefficient: f64,
    },
    /// The same pair twice, in whichever order.
    #[error("the correlation of inputs {first} and {second} is given twice")]
    Repeated {
        /// One input.
        first: usize,
        /// The other.
        second: usize,
    },
    /// Coefficients that contradict each other.
    #[error(
        "the correlations contradict each other: no input {input} can have those given for it and the inputs before \
         it (the matrix is not positive definite)"
    )]
    NotPositiveDefinite {
        /// The first input at which the matrix fails.
        input: usize,
    },
}

/// Correlation of the normal deviates behind the inputs, as the Cholesky factor of its matrix.
///
/// The coefficients are those of the deviates. Normal inputs inherit them; others are correlated a little less, by
/// `(exp(rho t_1 t_2) - 1) / (s_1 s_2)` if both are lognormal. The rank correlation is `6 asin(rho / 2) / pi`
/// whatever the marginals (W. H. Kruskal, Ordinal measures of association, J. Am. Stat. Assoc. 53 (1958) 814-861).
///
/// ```
/// let correlation = stickslip_sampler::Correlation::new(2, &[(0, 1, 0.6)])?;
/// let mut deviates = [1.0, 0.5];
/// correlation.apply(&mut deviates);
/// assert_eq!(deviates, [1.0, 0.6 * 1.0 + 0.8 * 0.5]);
/// # Ok::<(), stickslip_sampler::CorrelationError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Correlation {
    inputs: usize,
    /// Row by row, each up to its diagonal; nothing for the unit matrix.
    factor: Vec<f64>,
}

/// Where row `row` of a packed lower triangle begins.
fn row_start(row: usize) -> usize {
    row * (row + 1) / 2
}

impl Correlation {
    /// Square of the smallest diagonal element of the factor; below, rounding could have made it.
    const SMALLEST_PIVOT: f64 = 1e-14;

    /// No correlation.
    #[must_use]
    pub fn independent(inputs: usize) -> Self {
        Self { inputs, factor: Vec::new() }
    }

    /// Correlates pairs `(i, j, rho)` of inputs, counted from 0; pairs not given are uncorrelated.
    ///
    /// # Errors
    /// [`CorrelationError`] if a pair is impossible or given twice, or the matrix not positive definite.
    pub fn new(inputs: usize, pairs: &[(usize, usize, f64)]) -> Result<Self, CorrelationError> {
        let mut factor = vec![0.0; row_start(inputs)];
        let mut given = vec![false; factor.len()];
        for row in 0..inputs {
            factor[row_start(row) + row] = 1.0;
        }
        for &(first, second, coefficient) in pairs {
            if let Some(&input) = [first, second].iter().find(|&&input| input >= inputs) {
                return Err(CorrelationError::NoInput { input, inputs });
            }
            if first == second {
                return Err(CorrelationError::SameInput { input: first });
            }
            if coefficient.is_nan() || coefficient.abs() >= 1.0 {
                return Err(CorrelationError::OutOfRange { first, second, coefficient });
            }
            let position = row_start(first.max(second)) + first.min(second);
            if given[position] {
                return Err(CorrelationError::Repeated { first, second });
            }
            given[position] = true;
            factor[position] = coefficient;
        }
        if factor.iter().filter(|&&element| element != 0.0).count() == inputs {
            return Ok(Self::independent(inputs));
        }
        factorise(inputs, &mut factor)?;
        Ok(Self { inputs, factor })
    }

    /// How many inputs there are.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Whether no inputs are correlated, so that [`Correlation::apply`] does nothing.
    #[must_use]
    pub fn is_independent(&self) -> bool {
        self.factor.is_empty()
    }

    /// Replaces the independent standard normal deviates `z` of the inputs by correlated ones, `L z`. Those of
    /// independent inputs stay as they are, bit for bit.
    ///
    /// # Panics
    /// If `z` is not as long as there are inputs.
    #[inline]
    pub fn apply(&self, z: &mut [f64]) {
        assert_eq!(z.len(), self.inputs, "deviates of one sample");
        if self.factor.is_empty() {
            return;
        }
        // From the last on: each needs only itself and those before it.
        for row in (0..self.inputs).rev() {
            let elements = &self.factor[row_start(row)..=row_start(row) + row];
            z[row] = elements.iter().zip(&*z).map(|(element, z)| element * z).sum();
        }
    }
}

/// Cholesky's factorisation in place, row by row.
fn factorise(inputs: usize, matrix: &mut [f64]) -> Result<(), CorrelationError> {
    for row in 0..inputs {
        let (before, current) = matrix.split_at_mut(row_start(row));
        for column in 0..=row {
            // On the diagonal the row meets itself.
            let known: f64 = if column < row {
                let other = &before[row_start(column)..][..column];
                current[..column].iter().zip(other).map(|(a, b)| a * b).sum()
            } else {
                current[..row].iter().map(|a| a * a).sum()
            };
            let rest = current[column] - known;
            current[column] = if column < row {
                rest / before[row_start(column) + column]
            } else if rest > Correlation::SMALLEST_PIVOT {
                rest.sqrt()
            } else {
                return Err(CorrelationError::NotPositiveDefinite { input: row });
            };
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_xoshiro::Xoshiro256PlusPlus;

    const EXPECTED: f64 = 0.39;

    const DEVIATES: [f64; 9] = [-8.0, -3.0, -1.0, -0.1, 0.0, 0.5, 2.0, 6.0, 8.0];

    fn truncated(low: f64, high: f64) -> Marginal {
        Marginal::TruncatedNormal { low, high }
    }

    /// Compares the inputs at `DEVIATES` with quantiles at `Phi(z)` computed by mpmath 1.3 to 60 digits, those at -3,
    /// 0.5 and 2 also with scipy.stats of SciPy 1.17.1, which has fewer.
    fn assert_quantiles(marginal: Marginal, relative_std: f64, quantiles: [f64; 9]) {
        for (z, quantile) in DEVIATES.into_iter().zip(quantiles) {
            let value = marginal.value(EXPECTED, relative_std, z);
            assert!((value - quantile).abs() < 1e-15 * f64::max(1.0, quantile), "{marginal:?}, {z}: {value}");
        }
    }

    #[test]
    fn normal_inputs_are_the_plain_formula() {
        for z in DEVIATES {
            assert_eq!(Marginal::Normal.value(EXPECTED, 0.25, z), EXPECTED * (1.0 + 0.25 * z));
        }
    }

    #[test]
    fn quantiles_agree_with_independent_ones() {
        assert_quantiles(
            Marginal::Lognormal,
            0.25,
            [
                0.05277665810715353,
                0.18076039992555734,
                0.29577935413774864,
                0.3691534312664431,
                0.37835557505667944,
                0.4279236392727117,
                0.619105554484107,
                1.657653771038709,
                2.712429060699983,
            ],
        );
        assert_quantiles(
            Marginal::Uniform,
            0.25,
            [
                0.2211250462620347,
                0.22158097419731948,
                0.27471084359795445,
                0.37654815164471706,
                0.39,
                0.454666428580412,
                0.5511910987774028,
                0.5588749534047457,
                0.5588749537379654,
            ],
        );
        assert_quantiles(
            truncated(-2.0, 3.0),
            0.25,
            [
                0.1950000000000011,
                0.19732296717838843,
                0.2998495449526639,
                0.3831101485812436,
                0.39261538214760017,
                0.4404428139254967,
                0.5835734162074699,
                0.6824999788183126,
                0.6824999999999867,
            ],
        );
        assert_quantiles(
            truncated(f64::NEG_INFINITY, 1.0),
            0.25,
            [
                -0.3920713020737859,
                0.09240731015397476,
                0.28176787294971434,
                0.3620448178644518,
                0.3704830655987281,
                0.4101233869186256,
                0.48007022652292575,
                0.4874999996655344,
                0.4874999999999998,
            ],
        );
        // Confined to one tail of the normal distribution, where the other probability is 1 to rounding.
        assert_quantiles(
            truncated(4.0, 6.0),
            0.25,
            [
                0.78,
                0.7800311659633633,
                0.7839676991245881,
                0.7939974993475779,
                0.7957069736537863,
                0.8063276682627708,
                0.85985003784252,
                0.9749994986098935,
                0.9749999999996839,
            ],
        );
        assert_quantiles(
            truncated(-6.0, -5.5),
            0.25,
            [
                -0.19499999999999984,
                -0.19461462661839307,
                -0.17308299281818565,
                -0.15844538280214185,
                -0.1571902473694312,
                -0.1521679558766739,
                -0.14662472257839987,
                -0.14625000001607974,
                -0.14625000000000002,
            ],
        );
    }

    #[test]
    fn a_uniform_input_down_to_zero_keeps_its_small_values() {
        // EXPECTED * 2 * scipy.stats.norm.cdf(z), SciPy 1.17.1.
        for (z, quantile) in [
            (-8.2, 9.375094203333874e-17),
            (-6.0, 7.695383631294018e-10),
            (-3.0, 0.001052920464671473),
            (-1.5, 0.0521096169897093),
            (-0.5, 0.24065928020626978),
        ] {
            let value = Marginal::Uniform.value(EXPECTED, WIDEST_UNIFORM, z);
            assert!((value / quantile - 1.0).abs() < 1e-13, "{z}: {value}");
        }
    }

    /// Mean and standard deviation by the trapezoidal rule over z, which converges exponentially for these smooth
    /// integrands.
    fn moments(marginal: Marginal, relative_std: f64) -> (f64, f64) {
        const STEP: f64 = 1.0 / 64.0;
        let integral = |power: i32, centre: f64| -> f64 {
            (-12 * 64..=12 * 64)
                .map(|i| {
                    let z = f64::from(i) * STEP;
                    (marginal.value(EXPECTED, relative_std, z) - centre).powi(power) * normal::density(z) * STEP
                })
                .sum()
        };
        let mean = integral(1, 0.0);
        (mean, integral(2, mean).sqrt())
    }

    #[test]
    fn inputs_have_the_stated_expected_value_and_standard_deviation() {
        for (marginal, stds) in [
            (Marginal::Normal, &[0.0, 0.05, 0.5, 1.0][..]),
            (Marginal::Lognormal, &[0.0, 0.05, 0.5, 1.0]),
            (Marginal::Uniform, &[0.0, 0.05, 0.5, WIDEST_UNIFORM]),
        ] {
            for &relative_std in stds {
                let (mean, std) = moments(marginal, relative_std);
                assert!((mean - EXPECTED).abs() < 1e-10, "{marginal:?}, {relative_std}: mean {mean}");
                let stated = relative_std * EXPECTED;
                assert!((std - stated).abs() < 1e-10, "{marginal:?}, {relative_std}: standard deviation {std}");
            }
        }
    }

    #[test]
    fn truncation_shifts_and_narrows() {
        // scipy.stats.truncnorm(low, high, loc=0.39, scale=0.0975).mean() and .std(), SciPy 1.17.1, with the last
        // digits from mpmath 1.3.
        for (low, high, mean, std) in [
            (-2.0, 3.0, 0.3949513414933007, 0.09110636233966429),
            (-4.0, 4.0, 0.39, 0.09744778892619027),
            (1.0, 2.0, 0.5248589820465764, 0.02629661691156946),
            (4.0, 6.0, 0.8019908258511043, 0.02103768004605845),
            (f64::NEG_INFINITY, 1.0, 0.36195900283343013, 0.07736895536430523),
            (-6.0, -5.5, -0.16036001339883596, 0.011683969176994368),
            (f64::NEG_INFINITY, f64::INFINITY, 0.39, 0.0975),
        ] {
            let (computed_mean, computed_std) = moments(truncated(low, high), 0.25);
            assert!((computed_mean - mean).abs() < 1e-10, "{low}, {high}: mean {computed_mean}");
            assert!((computed_std - std).abs() < 1e-10, "{low}, {high}: standard deviation {computed_std}");
        }
    }

    #[test]
    fn inputs_rise_with_the_deviate_and_stay_inside_their_interval() {
        for marginal in [
            Marginal::Normal,
            Marginal::Lognormal,
            Marginal::Uniform,
            truncated(-2.0, 3.0),
            truncated(-0.1, 0.1),
            truncated(5.0, f64::INFINITY),
        ] {
            let mut previous = f64::NEG_INFINITY;
            for i in -8000_i32..=8000 {
                let value = marginal.value(EXPECTED, 0.25, f64::from(i) * 1e-3);
                // Values next to an end are equal to rounding.
                assert!(value > previous - 1e-15, "{marginal:?} at {i}: {value} after {previous}");
                assert!(i.abs() > 5000 || value > previous, "{marginal:?} at {i}: {value} after {previous}");
                if let Marginal::TruncatedNormal { low, high } = marginal {
                    assert!(value >= EXPECTED * (1.0 + 0.25 * low) && value <= EXPECTED * (1.0 + 0.25 * high));
                }
                previous = value;
            }
        }
    }

    #[test]
    fn rounding_leads_to_no_value_outside_the_interval() {
        for i in 1..=100 {
            let [low, high] = [-0.05 * f64::from(i), 0.07 * f64::from(i)];
            for z in [-37.0, 37.0] {
                let value = truncated(low, high).value(EXPECTED, 0.25, z);
                let ends = [low, high].map(|end| EXPECTED * (1.0 + 0.25 * end));
                assert!((ends[0]..=ends[1]).contains(&value), "{low}, {high}: {value} at {z}");
            }
        }
    }

    #[test]
    fn many_deviates_become_what_each_would() {
        for marginal in [Marginal::Normal, Marginal::Lognormal, Marginal::Uniform, truncated(-2.0, 3.0)] {
            let mut values = DEVIATES;
            marginal.apply(EXPECTED, 0.25, &mut values);
            assert_eq!(values, DEVIATES.map(|z| marginal.value(EXPECTED, 0.25, z)));
        }
    }

    #[test]
    fn impossible_marginals_are_refused() {
        use MarginalError as E;
        for value in [0.0, -1.0, f64::INFINITY] {
            assert_eq!(Marginal::Normal.check(value, 0.1), Err(E::Expected { value }));
        }
        assert!(matches!(Marginal::Normal.check(f64::NAN, 0.1), Err(E::Expected { .. })));
        assert_eq!(Marginal::Lognormal.check(1.0, -0.1), Err(E::RelativeStd { value: -0.1 }));
        assert!(matches!(Marginal::Lognormal.check(1.0, f64::NAN), Err(E::RelativeStd { .. })));
        assert_eq!(Marginal::Lognormal.check(1.0, 3.0), Ok(()));
        assert_eq!(Marginal::Uniform.check(1.0, 1.0 / 3f64.sqrt()), Ok(()));
        assert_eq!(Marginal::Uniform.check(1.0, 0.578), Err(E::UniformTooWide { value: 0.578 }));
        assert_eq!(truncated(3.0, 3.0).check(1.0, 0.1), Err(E::NoInterval { low: 3.0, high: 3.0 }));
        assert!(matches!(truncated(f64::NAN, 3.0).check(1.0, 0.1), Err(E::NoInterval { .. })));
        assert_eq!(truncated(10.0, 20.0).check(1.0, 0.1), Err(E::IntervalTooFar { low: 10.0, high: 20.0 }));
        assert_eq!(truncated(f64::NEG_INFINITY, f64::INFINITY).check(1.0, 0.1), Ok(()));
    }

    #[test]
    fn independent_deviates_stay_as_they_are() {
        let deviates = [-0.0, 1e-320, f64::INFINITY, -1.5];
        for correlation in [Correlation::independent(4), Correlation::new(4, &[(0, 3, 0.0)]).unwrap()] {
            let mut z = deviates;
            correlation.apply(&mut z);
            assert!(correlation.is_independent());
            assert_eq!(z.map(f64::to_bits), deviates.map(f64::to_bits));
        }
    }

    #[test]
    fn the_factor_agrees_with_numpy() {
        // numpy.linalg.cholesky of numpy 2, times (0.7, -1.1, 0.4).
        let correlation = Correlation::new(3, &[(1, 0, 0.5), (0, 2, -0.3), (2, 1, 0.2)]).unwrap();
        let mut z = [0.7, -1.1, 0.4];
        correlation.apply(&mut z);
        for (z, expected) in z.into_iter().zip([0.7, -0.6026279441628826, -0.30892020336092596]) {
            assert!((z - expected).abs() < 1e-15, "{z}");
        }
    }

    #[test]
    fn impossible_correlations_are_refused() {
        use CorrelationError as E;
        let refused = |pairs: &[(usize, usize, f64)]| Correlation::new(3, pairs).unwrap_err();
        assert_eq!(refused(&[(0, 3, 0.5)]), E::NoInput { input: 3, inputs: 3 });
        assert_eq!(refused(&[(1, 1, 0.5)]), E::SameInput { input: 1 });
        for coefficient in [1.0, -1.0, f64::INFINITY] {
            assert_eq!(refused(&[(0, 1, coefficient)]), E::OutOfRange { first: 0, second: 1, coefficient });
        }
        assert!(matches!(refused(&[(0, 1, f64::NAN)]), E::OutOfRange { .. }));
        assert_eq!(refused(&[(0, 1, 0.5), (1, 0, 0.5)]), E::Repeated { first: 1, second: 0 });
        assert_eq!(refused(&[(0, 1, 0.9), (1, 2, 0.9), (0, 2, -0.9)]), E::NotPositiveDefinite { input: 2 });
        // Singular: the third is the sum of the other two, scaled.
        let half = 0.5f64.sqrt();
        assert_eq!(refused(&[(0, 2, half), (1, 2, half)]), E::NotPositiveDefinite { input: 2 });
        assert!(Correlation::new(2, &[(0, 1, 0.999_999)]).is_ok());
    }

    /// Pearson's coefficient.
    fn correlation_of(a: &[f64], b: &[f64]) -> f64 {
        let n = a.len() as f64;
        let [mean_a, mean_b] = [a, b].map(|values| values.iter().sum::<f64>() / n);
        let sum =
            |f: &dyn Fn(f64, f64) -> f64| -> f64 { a.iter().zip(b).map(|(a, b)| f(a - mean_a, b - mean_b)).sum() };
        sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt()
    }

    #[test]
    fn drawn_inputs_have_the_correlation_asked_for() {
        const SAMPLES: usize = 200_000;
        let coefficients = [(0, 1, 0.5), (0, 2, -0.3), (1, 2, 0.2)];
        let correlation = Correlation::new(3, &coefficients).unwrap();
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(2018);
        let mut columns = [const { Vec::new() }; 3];
        for _ in 0..SAMPLES {
            let mut z: [f64; 3] = std::array::from_fn(|_| generator.sample(StandardNormal));
            correlation.apply(&mut z);
            for (column, z) in columns.iter_mut().zip(z) {
                column.push(z);
            }
        }
        let tolerance = 4.0 / (SAMPLES as f64).sqrt();
        for column in &columns {
            let variance = column.iter().map(|z| z * z).sum::<f64>() / SAMPLES as f64;
            assert!((variance - 1.0).abs() < std::f64::consts::SQRT_2 * tolerance, "{variance}");
        }
        let drawn = |marginal: Marginal, i: usize| -> Vec<f64> {
            let mut values = columns[i].clone();
            marginal.apply(EXPECTED, 0.25, &mut values);
            values
        };
        for (i, j, coefficient) in coefficients {
            let normal = correlation_of(&drawn(Marginal::Normal, i), &drawn(Marginal::Normal, j));
            assert!((normal - coefficient).abs() < tolerance, "{i}, {j}: {normal}");
            // Uniform inputs are ranks.
            let rank = correlation_of(&drawn(Marginal::Uniform, i), &drawn(Marginal::Uniform, j));
            let expected = 6.0 / std::f64::consts::PI * (0.5 * coefficient).asin();
            assert!((rank - expected).abs() < tolerance, "{i}, {j}: rank correlation {rank}");
            let lognormal = correlation_of(&drawn(Marginal::Lognormal, i), &drawn(Marginal::Lognormal, j));
            let expected = ((coefficient * 0.0625f64.ln_1p()).exp() - 1.0) / 0.0625;
            assert!((lognormal - expected).abs() < tolerance, "{i}, {j}: lognormal {lognormal}");
        }
    }
}
