//! Correlation of the normal deviates behind the inputs.

use thiserror::Error;

use crate::lower_triangle::{self, factorise, row_start};

/// Why a correlation was refused. Inputs are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum CorrelationError {
    /// An input that does not exist.
    #[error("there is no input {input}; the {inputs} inputs are numbered from 0")]
    NoInput {
        /// The number given.
        input: usize,
        /// The number of inputs.
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
    /// The same pair twice, in either order.
    #[error("the correlation of inputs {first} and {second} is given twice")]
    Repeated {
        /// One input.
        first: usize,
        /// The other.
        second: usize,
    },
    /// Coefficients that contradict each other: their matrix is not positive definite.
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
/// The coefficients `rho` are those of the deviates. Normal inputs have the same ones. Others are correlated a little
/// less: the coefficient of two lognormal inputs is `(exp(rho t_1 t_2) - 1) / (s_1 s_2)` with `t_i^2 = ln(1 + s_i^2)`.
/// The rank correlation is `6 asin(rho / 2) / pi` for all marginals (W. H. Kruskal, Ordinal measures of association, J.
/// Am. Stat. Assoc. 53 (1958) 814-861).
///
/// ```
/// let correlation = stickslip_sampler::inputs::Correlation::new(2, &[(0, 1, 0.6)])?;
/// let mut deviates = [1.0, 0.5];
/// correlation.apply(&mut deviates);
/// assert_eq!(deviates, [1.0, 0.6 * 1.0 + 0.8 * 0.5]);
/// # Ok::<(), stickslip_sampler::inputs::CorrelationError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Correlation {
    inputs: usize,
    /// Row by row, each up to its diagonal; empty for the unit matrix.
    factor: Vec<f64>,
}

impl Correlation {
    /// Independent inputs.
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
        factorise(inputs, &mut factor).map_err(|input| CorrelationError::NotPositiveDefinite { input })?;
        Ok(Self { inputs, factor })
    }

    /// Whether no inputs are correlated, so that [`Correlation::apply`] changes nothing.
    #[must_use]
    pub fn is_independent(&self) -> bool {
        self.factor.is_empty()
    }

    /// The number of inputs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// A row of the factor, up to its diagonal; inputs must be correlated.
    pub(super) fn row(&self, row: usize) -> &[f64] {
        lower_triangle::row(&self.factor, row)
    }

    /// Replaces the independent standard normal deviates `z` of the inputs by correlated ones, `L z`. Without
    /// correlation they keep every bit.
    ///
    /// # Panics
    /// If the length of `z` is not the number of inputs.
    #[inline]
    pub fn apply(&self, z: &mut [f64]) {
        assert_eq!(z.len(), self.inputs, "deviates of one sample");
        if self.factor.is_empty() {
            return;
        }
        lower_triangle::multiply(&self.factor, z);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::Marginal;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_xoshiro::Xoshiro256PlusPlus;

    const EXPECTED: f64 = 0.39;

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
