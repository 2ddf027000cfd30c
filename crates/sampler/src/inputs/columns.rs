//! The random inputs of many samples at once, in columns.

use super::correlation::Correlation;
use super::distribution::InputDistribution;
use super::marginal::Marginal;

/// The transform of independent normal deviates of a cell's samples into inputs, one column for each input.
///
/// Input `i` of a sample is `F_i^-1(Phi(y_i))` with `y = L z`, see the [module](super); for a normal input that is
/// `expected (1 + relative_std y_i)`. Values outside physics are neither clipped nor redrawn.
#[derive(Debug, Clone)]
pub struct InputColumns<'a> {
    correlation: &'a Correlation,
    inputs: Vec<InputDistribution>,
}

impl<'a> InputColumns<'a> {
    /// The transform for inputs with these distributions, expected values and relative standard deviations, in the same
    /// order.
    ///
    /// # Panics
    /// If the slices differ in length.
    #[must_use]
    pub fn new(marginals: &[Marginal], correlation: &'a Correlation, expected: &[f64], relative_stds: &[f64]) -> Self {
        assert!(marginals.len() == expected.len() && expected.len() == relative_stds.len(), "one of each per input");
        let inputs = marginals.iter().zip(expected).zip(relative_stds);
        let input = |((marginal, &expected), &std): ((&Marginal, &f64), &f64)| {
            InputDistribution::relative(marginal, expected, std)
        };
        Self { correlation, inputs: inputs.map(input).collect() }
    }

    /// Gives an input a standard deviation that is not relative to its expected value, which may be zero.
    ///
    /// # Panics
    /// If there is no such input.
    pub fn scatter_absolutely(&mut self, input: usize, marginal: &Marginal, expected: f64, std: f64) {
        self.inputs[input] = InputDistribution::absolute(marginal, expected, std);
    }

    /// Replaces deviates by inputs.
    ///
    /// # Panics
    /// If the number of columns is not that of the inputs, or the columns differ in length.
    #[inline]
    pub fn apply(&self, columns: &mut [Vec<f64>]) {
        assert_eq!(columns.len(), self.inputs.len(), "one column for each input");
        if !self.correlation.is_independent() {
            self.correlate(columns);
        }
        for (column, input) in columns.iter_mut().zip(&self.inputs) {
            input.apply(column);
        }
    }

    /// Replaces independent deviates by correlated ones.
    fn correlate(&self, columns: &mut [Vec<f64>]) {
        let mut sample = vec![0.0; columns.len()];
        for i in 0..columns.first().map_or(0, Vec::len) {
            for (value, column) in sample.iter_mut().zip(&*columns) {
                *value = column[i];
            }
            self.correlation.apply(&mut sample);
            for (value, column) in sample.iter().zip(&mut *columns) {
                column[i] = *value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::special_functions::normal;

    #[test]
    fn columns_have_the_inputs_of_single_samples() {
        let marginals = [Marginal::Normal, Marginal::Lognormal, Marginal::Weibull];
        let (expected, stds) = ([0.1, 0.4, 7.0], [0.2, 0.1, 0.3]);
        let correlation = Correlation::new(3, &[(0, 1, 0.5), (1, 2, -0.3)]).unwrap();
        let deviates = [[0.3, -1.2, 2.0], [0.0, 0.7, -0.4]];
        let mut columns: Vec<Vec<f64>> = (0..3).map(|i| deviates.iter().map(|z| z[i]).collect()).collect();
        InputColumns::new(&marginals, &correlation, &expected, &stds).apply(&mut columns);
        for (sample, mut z) in deviates.into_iter().enumerate() {
            correlation.apply(&mut z);
            for (i, marginal) in marginals.iter().enumerate() {
                let mut value = [z[i]];
                marginal.apply(expected[i], stds[i], &mut value);
                assert_eq!(columns[i][sample], value[0], "input {i} of sample {sample}");
            }
        }
    }

    #[test]
    fn an_absolute_standard_deviation_holds_for_any_expected_value() {
        let correlation = Correlation::independent(1);
        for (marginal, expected) in [
            (Marginal::Normal, 0.0),
            (Marginal::Normal, -3.0),
            (Marginal::Uniform, 0.0),
            (Marginal::Gumbel, 0.0),
            (Marginal::Triangular { mode: 0.2 }, -1.0),
            (Marginal::TruncatedNormal { low: -9.0, high: 9.0 }, 0.0),
            (Marginal::Lognormal, 2.0),
            (Marginal::Weibull, 2.0),
        ] {
            let mut columns = InputColumns::new(std::slice::from_ref(&marginal), &correlation, &[1.0], &[0.0]);
            columns.scatter_absolutely(0, &marginal, expected, 0.25);
            // Midpoints of equal probabilities.
            let n = 100_000;
            let deviates = (0..n).map(|i| normal::quantile((f64::from(i) + 0.5) / f64::from(n))).collect();
            let mut values = [deviates];
            columns.apply(&mut values);
            let mean = values[0].iter().sum::<f64>() / f64::from(n);
            let variance = values[0].iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / f64::from(n);
            assert!((mean - expected).abs() < 1e-4, "{marginal:?}: {mean}");
            assert!((variance.sqrt() - 0.25).abs() < 1e-3, "{marginal:?}: {}", variance.sqrt());
        }
    }

    #[test]
    fn without_inputs_there_are_no_columns() {
        let correlation = Correlation::independent(0);
        let mut columns: [Vec<f64>; 0] = [];
        InputColumns::new(&[], &correlation, &[], &[]).apply(&mut columns);
    }
}
