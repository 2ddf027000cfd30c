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

use crate::grid::Cell;
use crate::special_functions::normal;

/// Derivatives of a probability by the four parameters of a cell.
///
/// A derivative is `None` for an input without scatter, whose score does not exist. A boundary in closed form still
/// gives the derivative by the expected value of such an input if the other input scatters.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Derivatives {
    /// By the expected preload, at constant relative standard deviation.
    pub preload: Option<f64>,
    /// By the expected static friction coefficient, at constant relative standard deviation.
    pub static_friction: Option<f64>,
    /// By the relative standard deviation of the preload.
    pub std_preload: Option<f64>,
    /// By the relative standard deviation of the static friction coefficient.
    pub std_static_friction: Option<f64>,
}

impl Derivatives {
    /// The derivatives of the probability of a region with these moments, in a cell.
    pub(crate) fn of(cell: &Cell, moments: &Moments) -> Self {
        let [_, first_preload, first_friction, second_preload, second_friction] = *moments;
        let input = |expected: f64, std: f64, first: f64, second: f64| {
            let scatters = expected * std != 0.0;
            (scatters.then(|| (first + std * second) / (expected * std)), scatters.then(|| second / std))
        };
        let std = cell.relative_std;
        let (preload, std_preload) = input(cell.preload, std.preload, first_preload, second_preload);
        let (static_friction, std_static_friction) =
            input(cell.static_friction, std.static_friction, first_friction, second_friction);
        Self { preload, static_friction, std_preload, std_static_friction }
    }
}

/// The integrals of 1, `z1`, `z2`, `z1^2 - 1` and `z2^2 - 1` over a region, weighted with the densities of both
/// deviates: `z1` of the preload and `z2` of the static friction.
pub(crate) type Moments = [f64; 5];

/// The integrals of 1, `z` and `z^2 - 1` over an interval of one deviate, weighted with its density.
pub(crate) type DeviateMoments = [f64; 3];

/// The moments of a rectangle, from those of its preload and of its static friction.
pub(crate) fn product(preload: &DeviateMoments, friction: &DeviateMoments) -> Moments {
    let (p, f) = (preload, friction);
    [p[0] * f[0], p[1] * f[0], p[0] * f[1], p[2] * f[0], p[0] * f[2]]
}

/// The density at a deviate times 1, `z` and `z^2 - 1`.
pub(crate) fn moments_at(z: f64) -> DeviateMoments {
    let density = normal::density(z);
    [density, density * z, density * (z * z - 1.0)]
}
