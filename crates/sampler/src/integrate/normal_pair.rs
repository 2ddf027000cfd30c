//! Two normal, independent inputs.

/// Two normal, independent inputs. An input is its expected value times `1 + relative_std z` with a standard normal
/// deviate `z`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalPair {
    /// The expected values.
    pub expected: [f64; 2],
    /// The relative standard deviations; 0 for an input that does not scatter.
    pub relative_std: [f64; 2],
}

impl NormalPair {
    /// The standard deviation of an input.
    pub(crate) fn spread(&self, input: usize) -> f64 {
        self.expected[input] * self.relative_std[input]
    }

    /// Whether each input scatters.
    pub(crate) fn scatter(&self) -> [bool; 2] {
        [0, 1].map(|input| self.spread(input) != 0.0)
    }
}
