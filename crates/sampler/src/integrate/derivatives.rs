//! Derivatives of a probability from the moments of the normal deviates where samples are unstable.
//!
//! For an input `m (1 + s z)` with a standard normal deviate `z`, the derivatives of a probability `P` by the expected
//! value `m` (at constant relative standard deviation `s`) and by `s` follow from the score of the normal density (R.
//! Y. Rubinstein, A. Shapiro, Discrete Event Systems, 1993):
//!
//! ```text
//! dP/dm = E[1_unstable (z + s (z^2 - 1))] / (m s),   dP/ds = E[1_unstable (z^2 - 1)] / s
//! ```
//!
//! The moments of the unstable region are therefore all that is needed. Over a tail `z >= t` they have a closed form:
//! `Q(t)` of 1, `phi(t)` of `z`, `t phi(t)` of `z^2 - 1`, with the normal density `phi` and upper tail `Q`.

use crate::inputs::PairParameter;
use crate::integrate::normal_pair::NormalPair;
use crate::special_functions::normal;

/// Derivatives of a probability by the parameters of two inputs, in the order of [`PairParameter::DIFFERENTIATED`].
///
/// A derivative is `None` for an input without scatter, whose score does not exist. A boundary in closed form still
/// gives the derivative by the expected value of such an input if the other input scatters.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Derivatives(pub [Option<f64>; 4]);

impl Derivatives {
    /// The derivative by a parameter.
    #[must_use]
    pub fn get(&self, parameter: PairParameter) -> Option<f64> {
        self.0[parameter.place()?]
    }

    /// The derivatives of the probability of a region with these moments.
    pub(crate) fn from_moments(inputs: &NormalPair, moments: &Moments) -> Self {
        let [_, first_of_1, first_of_2, second_of_1, second_of_2] = *moments;
        let of_input = |input: usize, first: f64, second: f64| {
            let (spread, std) = (inputs.spread(input), inputs.relative_std[input]);
            let scatters = spread != 0.0;
            (scatters.then(|| (first + std * second) / spread), scatters.then(|| second / std))
        };
        let (by_first, by_first_std) = of_input(0, first_of_1, second_of_1);
        let (by_second, by_second_std) = of_input(1, first_of_2, second_of_2);
        Self([by_first, by_second, by_first_std, by_second_std])
    }
}

/// The integrals of 1, `z1`, `z2`, `z1^2 - 1` and `z2^2 - 1` over a region, weighted with the densities of both
/// deviates: `z1` of the first input and `z2` of the second.
pub(crate) type Moments = [f64; 5];

/// The integrals of 1, `z` and `z^2 - 1` over an interval of one deviate, weighted with its density.
pub(crate) type DeviateMoments = [f64; 3];

/// The moments of a rectangle, from those of its two sides.
pub(crate) fn product(a: &DeviateMoments, b: &DeviateMoments) -> Moments {
    [a[0] * b[0], a[1] * b[0], a[0] * b[1], a[2] * b[0], a[0] * b[2]]
}

/// The density at a deviate times 1, `z` and `z^2 - 1`.
pub(crate) fn moments_at(z: f64) -> DeviateMoments {
    let density = normal::density(z);
    [density, density * z, density * (z * z - 1.0)]
}
