//! The modes in bands of frequencies, with their derivatives by every parameter in closed form.
//!
//! With `Q(lambda) = lambda^2 M + lambda C(p) + K(p)`, `Q x = 0` and `y^T Q = 0`, an eigenvalue changes with a parameter by
//!
//! ```text
//! d lambda / dp = -y^T (lambda dC/dp + dK/dp) x / y^T (2 lambda M + C) x
//! ```
//!
//! Of two modes with one eigenvalue, as those of a disc without its pads, the derivatives are the eigenvalues of the matrix of
//! two rows that this formula makes of both left and both right vectors. Where vectors do not exist, as where two modes
//! meet without damping, there is no derivative.

use std::f64::consts::TAU;

use thiserror::Error as ThisError;

use super::branches::{Branches, Line, Place};
use super::error::Error;
use super::model::MatrixModel;
use super::pair::{Pair, damping_ratio_slope};
use super::problem::Problem;
use super::region::{Region, damping_ratio, magnitude, square_root};
use super::terms::OverParameter;
use crate::numerics::eigenvalues::Eigenvalue;

/// Eigenvalues nearer to each other than this, relative to them, are taken as one.
const CLUSTER: f64 = 1e-7;

/// A mode of one parameter point.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// lambda: growth rate in 1/s, angular frequency in rad/s, which is not negative.
    pub eigenvalue: Eigenvalue,
    /// `d lambda / dp` for each parameter; `None` where there is no derivative.
    pub slopes: Option<Vec<Eigenvalue>>,
}

impl Mode {
    /// Frequency in Hz.
    #[must_use]
    pub fn frequency(&self) -> f64 {
        self.eigenvalue.im / TAU
    }

    /// `-Re lambda / |lambda|`.
    #[must_use]
    pub fn damping_ratio(&self) -> f64 {
        damping_ratio(self.eigenvalue)
    }

    /// The derivative of the frequency in Hz by a parameter.
    #[must_use]
    pub fn frequency_slope(&self, parameter: usize) -> Option<f64> {
        Some(self.slopes.as_ref()?.get(parameter)?.im / TAU)
    }

    /// The derivative of the damping ratio by a parameter.
    #[must_use]
    pub fn damping_ratio_slope(&self, parameter: usize) -> Option<f64> {
        Some(damping_ratio_slope(self.eigenvalue, *self.slopes.as_ref()?.get(parameter)?))
    }
}

/// Why there are no modes.
#[derive(Debug, Clone, PartialEq, ThisError)]
#[non_exhaustive]
pub enum ModesError {
    /// Pairs are not found.
    #[error(transparent)]
    Pairs(#[from] Error),
    /// A large model without a band.
    #[error(
        "a model of {size} degrees of freedom has too many modes to find all; give the criterion a band that ends, such as frequency = [1000.0, 3000.0] (Hz)"
    )]
    EndlessBand {
        /// Degrees of freedom.
        size: usize,
    },
}

impl MatrixModel {
    /// The modes with these values of the parameters whose frequencies lie in one of the regions, by rising frequency. With
    /// sparse matrices, those with damping ratios from -0.99 to 0.05 above the threshold.
    ///
    /// # Errors
    /// [`ModesError`].
    pub fn modes(&self, parameters: &[f64], regions: &[Region]) -> Result<Vec<Mode>, ModesError> {
        let unit = self.problem().unit();
        let still = Line { from: self.matrices().coefficients(parameters), direction: self.still() };
        let branches = self.problem().along(&still);
        let place = branches.at(0.0)?;
        let over = |own| OverParameter { matrices: self.matrices(), values: parameters, place: own };
        let paths: Vec<OverParameter<'_>> = (0..parameters.len()).map(over).collect();
        let branches: Vec<Box<dyn Branches + '_>> = paths.iter().map(|path| self.problem().along(path)).collect();
        let changes = branches.iter().zip(parameters).map(|(branches, value)| branches.at(*value));
        let changes: Vec<Box<dyn Place + '_>> = changes.collect::<Result<_, _>>()?;
        let scaled: Vec<Region> = regions.iter().map(|region| region.in_unit(unit)).collect();
        let pairs = self.each_region(&scaled, |region| Ok(place.pairs(region)?), |pair| pair.eigenvalue)?;
        let mut modes = Vec::new();
        for cluster in clusters(pairs) {
            // Vectors of one eigenvalue are not their own; a single mode is made exact.
            let cluster = match &cluster[..] {
                [pair] => vec![place.refine(pair).unwrap_or_else(|_| pair.clone())],
                _ => cluster,
            };
            let slopes: Option<Vec<Vec<Eigenvalue>>> =
                changes.iter().map(|change| slopes(&**change, &cluster)).collect();
            let of_mode = |i: usize| {
                slopes.as_ref().map(|slopes| slopes.iter().map(|of_parameter| of_parameter[i] * unit).collect())
            };
            let pairs = cluster.iter().enumerate();
            modes.extend(pairs.map(|(i, pair)| Mode { eigenvalue: pair.eigenvalue * unit, slopes: of_mode(i) }));
        }
        let order = |mode: &Mode| (mode.eigenvalue.im, -mode.eigenvalue.re);
        modes.sort_by(|a, b| {
            let (a, b) = (order(a), order(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        Ok(modes)
    }

    /// The eigenvalues of the same modes alone, in rad/s and in no order.
    ///
    /// # Errors
    /// [`ModesError`].
    pub fn eigenvalues(&self, parameters: &[f64], regions: &[Region]) -> Result<Vec<Eigenvalue>, ModesError> {
        let coefficients = self.matrices().coefficients(parameters);
        let of_region =
            |region: &Region| Ok(self.problem().eigenvalues(&coefficients, std::slice::from_ref(region))?);
        self.each_region(regions, of_region, |value| *value)
    }

    /// What is found in each region, each eigenvalue once where bands overlap. Dense matrices find all at once.
    fn each_region<T>(
        &self,
        regions: &[Region],
        find: impl Fn(&Region) -> Result<Vec<T>, ModesError>,
        eigenvalue: impl Fn(&T) -> Eigenvalue,
    ) -> Result<Vec<T>, ModesError> {
        let mut all = Vec::new();
        for (place, region) in regions.iter().enumerate() {
            let (before, own) = match self.problem() {
                Problem::Dense(_) if place > 0 => break,
                Problem::Dense(_) => (&regions[..0], regions),
                Problem::Sparse(_) if region.highest.is_infinite() => {
                    return Err(ModesError::EndlessBand { size: self.matrices().size() });
                }
                Problem::Sparse(_) => (&regions[..place], std::slice::from_ref(region)),
            };
            let is_in =
                |regions: &[Region], found: &T| regions.iter().any(|region| region.has_frequency_of(eigenvalue(found)));
            all.extend(find(region)?.into_iter().filter(|found| is_in(own, found) && !is_in(before, found)));
        }
        Ok(all)
    }

    /// No change of any coefficient.
    fn still(&self) -> Vec<f64> {
        vec![0.0; self.matrices().damping.len() + self.matrices().stiffness.len()]
    }
}

/// Pairs whose eigenvalues are nearly equal, together.
fn clusters(pairs: Vec<Pair>) -> Vec<Vec<Pair>> {
    let mut clusters: Vec<Vec<Pair>> = Vec::new();
    for pair in pairs {
        let is_one =
            |other: &Pair| magnitude(other.eigenvalue - pair.eigenvalue) <= CLUSTER * magnitude(pair.eigenvalue);
        match clusters.iter_mut().find(|cluster| cluster.iter().any(is_one)) {
            Some(cluster) => cluster.push(pair),
            None => clusters.push(vec![pair]),
        }
    }
    clusters
}

/// The derivatives of one or two eigenvalues along the path of a place; vectors of two are biorthogonal.
fn slopes(place: &dyn Place, cluster: &[Pair]) -> Option<Vec<Eigenvalue>> {
    let slopes = match cluster {
        [pair] => vec![place.coupling(pair, pair)],
        [a, b] => {
            let [own, other] = [place.coupling(a, a), place.coupling(b, b)];
            let (half, gap) = ((own + other) * 0.5, (own - other) * 0.5);
            let root = square_root(gap * gap + place.coupling(a, b) * place.coupling(b, a));
            vec![half - root, half + root]
        }
        _ => return None,
    };
    slopes.iter().all(|slope| slope.re.is_finite() && slope.im.is_finite()).then_some(slopes)
}

#[cfg(test)]
mod tests;
