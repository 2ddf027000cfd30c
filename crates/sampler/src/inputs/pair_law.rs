//! The law of the deviates of two inputs, given those of the others.

use super::correlation::Correlation;

/// A parameter of the law of two inputs. An input is 0 for the first and 1 for the second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PairParameter {
    /// The expected value of an input, at constant relative standard deviation.
    Expected(usize),
    /// The relative standard deviation of an input.
    RelativeStd(usize),
    /// The correlation of the deviates of both.
    Correlation,
}

impl PairParameter {
    /// The parameters by which probabilities are differentiated, in the order of the sums.
    pub const DIFFERENTIATED: [Self; 4] =
        [Self::Expected(0), Self::Expected(1), Self::RelativeStd(0), Self::RelativeStd(1)];

    /// Its place among [`PairParameter::DIFFERENTIATED`].
    pub(crate) fn place(self) -> Option<usize> {
        Self::DIFFERENTIATED.iter().position(|parameter| *parameter == self)
    }
}

/// The normal law of two correlated deviates, given the deviates of all other inputs:
///
/// ```text
/// z_1 = mean_1 + factor_11 u,     z_2 = mean_2 + factor_21 u + factor_22 w
/// ```
///
/// with independent standard normal `u` and `w`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairLaw {
    /// The expected values.
    pub mean: [f64; 2],
    /// The factor of the covariance matrix: its elements 11, 21 and 22. The first and the last are positive.
    pub factor: [f64; 3],
}

impl PairLaw {
    /// Two standard normal deviates with a correlation.
    #[must_use]
    pub fn correlated(coefficient: f64) -> Self {
        let rest = ((1.0 - coefficient) * (1.0 + coefficient)).sqrt();
        Self { mean: [0.0; 2], factor: [1.0, coefficient, rest] }
    }

    /// The variance of the second deviate.
    #[must_use]
    pub fn second_variance(&self) -> f64 {
        let [_, by_first, own] = self.factor;
        by_first * by_first + own * own
    }
}

impl Correlation {
    /// The law of the last two inputs, given the independent deviates behind those before them, to which
    /// [`Correlation::apply`] gives their correlation.
    ///
    /// # Panics
    /// If the number of deviates is not that of the inputs less two.
    #[must_use]
    pub fn law_of_last_two(&self, others: &[f64]) -> PairLaw {
        assert_eq!(others.len() + 2, self.inputs(), "deviates of all inputs but two");
        if self.is_independent() {
            return PairLaw::correlated(0.0);
        }
        let given = |row: &[f64]| row.iter().zip(others).map(|(element, z)| element * z).sum();
        let [first, second] = [0, 1].map(|i| self.row(others.len() + i));
        let n = others.len();
        PairLaw { mean: [given(first), given(second)], factor: [first[n], second[n], second[n + 1]] }
    }
}

/// The law of the deviate of one input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviateLaw {
    /// Its mean.
    pub mean: f64,
    /// Its standard deviation.
    pub std: f64,
}

impl DeviateLaw {
    /// That of an input that is independent of others.
    pub const INDEPENDENT: Self = Self { mean: 0.0, std: 1.0 };
}

impl Correlation {
    /// The law of the deviate of the last input given the independent deviates of the others.
    ///
    /// # Panics
    /// If the number of deviates is not that of the inputs less one.
    #[must_use]
    pub fn law_of_last(&self, others: &[f64]) -> DeviateLaw {
        assert_eq!(others.len() + 1, self.inputs(), "deviates of all inputs but one");
        if self.is_independent() {
            return DeviateLaw::INDEPENDENT;
        }
        let row = self.row(others.len());
        DeviateLaw { mean: row.iter().zip(others).map(|(element, z)| element * z).sum(), std: row[others.len()] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_law_is_that_of_a_partitioned_covariance() {
        // The textbook's formulas, C_11 - C_12 C_22^-1 C_21 and C_12 C_22^-1 y, with one other input.
        let (a, b, c) = (0.5, -0.3, 0.4);
        let correlation = Correlation::new(3, &[(0, 1, a), (0, 2, b), (1, 2, c)]).unwrap();
        let law = correlation.law_of_last_two(&[1.7]);
        assert!((law.mean[0] - a * 1.7).abs() < 1e-15 && (law.mean[1] - b * 1.7).abs() < 1e-15);
        let [first, by_first, second] = law.factor;
        assert!((first * first - (1.0 - a * a)).abs() < 1e-15);
        assert!((first * by_first - (c - a * b)).abs() < 1e-15);
        assert!((by_first * by_first + second * second - (1.0 - b * b)).abs() < 1e-15);
        assert!((law.second_variance() - (1.0 - b * b)).abs() < 1e-15);
        assert_eq!(Correlation::independent(3).law_of_last_two(&[1.7]), PairLaw::correlated(0.0));
    }

    #[test]
    fn the_law_of_one_input_is_what_the_factor_makes() {
        let correlation = Correlation::new(3, &[(0, 1, 0.2), (0, 2, 0.5), (1, 2, -0.4)]).unwrap();
        let mut z = [0.3, -1.2, 0.8];
        let DeviateLaw { mean, std } = correlation.law_of_last(&z[..2]);
        correlation.apply(&mut z);
        assert!((mean + std * 0.8 - z[2]).abs() < 1e-15);
        assert_eq!(Correlation::independent(3).law_of_last(&[1.0, 2.0]), DeviateLaw::INDEPENDENT);
    }

    #[test]
    fn the_law_with_its_deviates_is_what_the_factor_makes() {
        let pairs = [(0, 1, 0.2), (0, 2, 0.5), (1, 2, -0.4), (0, 3, 0.3), (1, 3, 0.1), (2, 3, 0.6)];
        let correlation = Correlation::new(4, &pairs).unwrap();
        let mut z = [0.3, -1.2, 0.8, 2.0];
        let PairLaw { mean, factor } = correlation.law_of_last_two(&z[..2]);
        let [u, w] = [z[2], z[3]];
        correlation.apply(&mut z);
        assert!((mean[0] + factor[0] * u - z[2]).abs() < 1e-15);
        assert!((mean[1] + factor[1] * u + factor[2] * w - z[3]).abs() < 1e-15);
    }
}
