//! The random inputs of many samples at once, in columns.

use super::correlation::Correlation;
use super::marginal::Marginal;
use super::transform::Transform;

/// The transform of independent normal deviates of a cell's samples into inputs, one column for each input.
///
/// Input `i` of a sample is `F_i^-1(Phi(y_i))` with `y = L z`, see the [module](super); for a normal input that is
/// `expected (1 + relative_std y_i)`. Values outside physics are neither clipped nor redrawn.
#[derive(Debug, Clone)]
pub struct InputColumns<'a> {
    correlation: &'a Correlation,
    /// Expected value and distribution of each input.
    inputs: Vec<(f64, Transform)>,
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
        let inputs = inputs.map(|((marginal, &expected), &std)| (expected, Transform::new(marginal, std))).collect();
        Self { correlation, inputs }
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
        for (column, (expected, transform)) in columns.iter_mut().zip(&self.inputs) {
            transform.apply(*expected, column);
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
    fn without_inputs_there_are_no_columns() {
        let correlation = Correlation::independent(0);
        let mut columns: [Vec<f64>; 0] = [];
        InputColumns::new(&[], &correlation, &[], &[]).apply(&mut columns);
    }
}
