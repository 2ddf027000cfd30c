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

use nalgebra::{Complex, DMatrix, DVector};
use thiserror::Error;

use super::eigenbasis::{Eigenbasis, square_root};
use super::full::Error as FullError;
use super::full::band::{Band, KrylovLimit};
use super::full::pair::{Pair as SparsePair, damping_ratio_slope, dot};
use super::full::quadratic::{Coefficients, Point, Side, SparseQuadratic};
use super::model::{ComplexEigenvalue, Matrices};
use super::quadratic::{DenseQuadratic, Quadratic, QuadraticError};
use super::refine::Pair;
use super::region::{Region, damping_ratio, magnitude};
use crate::numerics::eigenvalues::{Eigenvalue, EigenvalueError};

/// Degrees of freedom up to which all modes are computed by dense matrices.
pub const MOST_DENSE: usize = 400;

/// Damping ratios between which the modes of larger models are looked for, next to the threshold below and zero above.
pub const DAMPING_RATIOS: [f64; 2] = [-0.3, 0.1];

/// Eigenvalues nearer to each other than this, relative to them, are taken as one.
const CLUSTER: f64 = 1e-7;

/// The regions of a criterion in rad/s: those of all bands for `band` 0, else that of one, counted from 1.
#[must_use]
pub fn regions(criterion: &ComplexEigenvalue, band: usize) -> Vec<Region> {
    let chosen = criterion.bands.iter().enumerate().filter(|(place, _)| band == 0 || band == place + 1);
    let region = |(_, [lowest, highest]): (usize, &[f64; 2])| Region {
        lowest: TAU * lowest,
        highest: TAU * highest,
        damping_ratio: criterion.damping_ratio,
    };
    chosen.map(region).collect()
}

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
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ModesError {
    /// The mass matrix is none.
    #[error(transparent)]
    Mass(#[from] QuadraticError),
    /// All eigenvalues do not converge.
    #[error(transparent)]
    Eigenvalues(#[from] EigenvalueError),
    /// The sparse solver failed.
    #[error(transparent)]
    Full(#[from] FullError),
    /// A large model without a band.
    #[error(
        "a model of {size} degrees of freedom has too many modes to find all; give the criterion a band that ends, such as frequency = [1000.0, 3000.0] (Hz); up to {MOST_DENSE} degrees of freedom need none"
    )]
    EndlessBand {
        /// Degrees of freedom.
        size: usize,
    },
}

/// The eigenvalue problem of a model at any values of its parameters.
#[derive(Debug)]
pub struct Modes<'a> {
    matrices: &'a Matrices,
    solver: Solver,
}

#[derive(Debug)]
enum Solver {
    Dense(DenseQuadratic),
    Sparse(Box<SparseQuadratic>),
}

impl<'a> Modes<'a> {
    /// Of given matrices: dense ones up to [`MOST_DENSE`] degrees of freedom, else sparse ones.
    ///
    /// # Errors
    /// As [`DenseQuadratic::new`] and [`SparseQuadratic::new`].
    pub fn new(matrices: &'a Matrices) -> Result<Self, ModesError> {
        if matrices.size() <= MOST_DENSE {
            return Ok(Self { matrices, solver: Solver::Dense(matrices.dense()?) });
        }
        Self::sparse(matrices)
    }

    /// The same with the sparse solver, whatever the size.
    ///
    /// # Errors
    /// As [`SparseQuadratic::new`].
    pub fn sparse(matrices: &'a Matrices) -> Result<Self, ModesError> {
        let of = |terms: &[super::model::Term]| terms.iter().map(|term| (*term.matrix).clone()).collect::<Vec<_>>();
        let sparse = SparseQuadratic::new(&matrices.mass, &of(&matrices.damping), &of(&matrices.stiffness))?;
        Ok(Self { matrices, solver: Solver::Sparse(Box::new(sparse)) })
    }

    /// The modes with these values of the parameters whose frequencies lie in one of the regions, by rising frequency.
    /// Those of sparse matrices have damping ratios in [`DAMPING_RATIOS`] about the threshold.
    ///
    /// # Errors
    /// [`ModesError`].
    pub fn at(&self, parameters: &[f64], regions: &[Region]) -> Result<Vec<Mode>, ModesError> {
        let mut modes = match &self.solver {
            Solver::Dense(problem) => self.dense(problem, parameters, regions)?,
            Solver::Sparse(problem) => self.by_krylov(problem, parameters, regions)?,
        };
        let frequency = |mode: &Mode| (mode.eigenvalue.im, -mode.eigenvalue.re);
        modes.sort_by(|a, b| {
            let (a, b) = (frequency(a), frequency(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        Ok(modes)
    }

    /// The eigenvalues alone, as verdicts by all eigenvalues find them.
    ///
    /// # Errors
    /// [`ModesError`].
    pub fn eigenvalues_at(&self, parameters: &[f64], regions: &[Region]) -> Result<Vec<Eigenvalue>, ModesError> {
        match &self.solver {
            Solver::Dense(problem) => {
                let values = problem.at(&self.matrices.coefficients(parameters)).eigenvalues()?;
                let scaled = values.into_iter().map(|value| value * problem.unit());
                Ok(scaled.filter(|value| is_wanted(*value, regions)).collect())
            }
            Solver::Sparse(_) => Ok(self.at(parameters, regions)?.iter().map(|mode| mode.eigenvalue).collect()),
        }
    }

    fn dense(&self, problem: &DenseQuadratic, parameters: &[f64], regions: &[Region]) -> Result<Vec<Mode>, ModesError> {
        let unit = problem.unit();
        let quadratic = problem.at(&self.matrices.coefficients(parameters));
        let Some(basis) = Eigenbasis::new(&quadratic) else {
            let values = quadratic.eigenvalues()?.into_iter().map(|value| value * unit);
            let wanted = values.filter(|value| is_wanted(*value, regions));
            return Ok(wanted.map(|eigenvalue| Mode { eigenvalue, slopes: None }).collect());
        };
        let in_unit: Vec<Region> = regions.iter().map(|region| region.in_unit(unit)).collect();
        let places = (0..basis.eigenvalues.len()).filter(|&i| is_wanted(basis.eigenvalues[i], &in_unit));
        let vectors = places.map(|i| Pair {
            eigenvalue: basis.eigenvalues[i],
            right: basis.right.column(i).into_owned(),
            left: basis.left.row(i).transpose(),
        });
        let changes = self.changes(parameters);
        let mut modes = Vec::new();
        for cluster in clusters(vectors.collect(), |pair: &Pair| pair.eigenvalue) {
            // Vectors of one eigenvalue are not their own; a single mode is made exact.
            let cluster = match cluster.len() {
                1 => cluster.into_iter().map(|pair| pair.clone().refined(&quadratic).unwrap_or(pair)).collect(),
                _ => cluster,
            };
            let form = |row: &Pair, of: &DVector<Complex<f64>>| row.left.dot(of);
            let gram =
                small(&cluster, |row, column| form(row, &quadratic.derivative_times(column.eigenvalue, &column.right)));
            let of_parameter = |change: &Vec<f64>| {
                // Without M: the identity of `lambda^2` does not change.
                let Quadratic { damping, stiffness } = problem.at(change);
                let slopes = small(&cluster, |row, column| {
                    let by_damping = super::quadratic::product(&damping, &column.right) * column.eigenvalue;
                    form(row, &(by_damping + super::quadratic::product(&stiffness, &column.right)))
                });
                slopes_of(&gram, &slopes)
            };
            let slopes: Option<Vec<Vec<Eigenvalue>>> = changes.iter().map(of_parameter).collect();
            modes.extend(with_slopes(cluster.iter().map(|pair| pair.eigenvalue), slopes.as_deref(), unit));
        }
        modes.retain(|mode| is_wanted(mode.eigenvalue, regions));
        Ok(modes)
    }

    fn by_krylov(
        &self,
        problem: &SparseQuadratic,
        parameters: &[f64],
        regions: &[Region],
    ) -> Result<Vec<Mode>, ModesError> {
        let point = problem.at(&self.split(&self.matrices.coefficients(parameters)))?;
        let changes = self.changes(parameters);
        let changes: Vec<Point<'_>> =
            changes.iter().map(|change| problem.at(&self.split(change))).collect::<Result<_, _>>()?;
        let mut pairs: Vec<SparsePair> = Vec::new();
        for region in regions {
            if region.highest.is_infinite() {
                return Err(ModesError::EndlessBand { size: self.matrices.size() });
            }
            let band = Band {
                low: region.lowest,
                high: region.highest,
                least_damping: (region.damping_ratio + DAMPING_RATIOS[0]).max(-0.9),
                most_damping: (region.damping_ratio + DAMPING_RATIOS[1]).clamp(DAMPING_RATIOS[1], 0.9),
            };
            let found = point.pairs_in(band, KrylovLimit::default())?;
            // Bands may overlap.
            let is_new = |pair: &SparsePair| !pairs.iter().any(|known| is_one(known.eigenvalue, pair.eigenvalue));
            let new: Vec<SparsePair> = found.into_iter().filter(is_new).collect();
            pairs.extend(new);
        }
        let one = Complex::from(1.0);
        let mut modes = Vec::new();
        for cluster in clusters(pairs, |pair: &SparsePair| pair.eigenvalue) {
            let gram = small(&cluster, |row, column| {
                let mut image = vec![Complex::default(); column.right.len()];
                let factors = [column.eigenvalue * 2.0, one, Complex::default()];
                point.combine(factors, &column.right, Side::Right, &mut image);
                dot(&row.left, &image)
            });
            let of_parameter = |change: &Point<'_>| {
                let slopes = small(&cluster, |row, column| {
                    let [_, damping, stiffness] = change.forms(&row.left, &column.right);
                    column.eigenvalue * damping + stiffness
                });
                slopes_of(&gram, &slopes)
            };
            let slopes: Option<Vec<Vec<Eigenvalue>>> = changes.iter().map(of_parameter).collect();
            modes.extend(with_slopes(cluster.iter().map(|pair| pair.eigenvalue), slopes.as_deref(), 1.0));
        }
        Ok(modes)
    }

    /// The derivatives of all coefficients by each parameter.
    fn changes(&self, parameters: &[f64]) -> Vec<Vec<f64>> {
        let terms = || self.matrices.damping.iter().chain(&self.matrices.stiffness);
        let by = |place: usize| terms().map(|term| term.factor.derivative(place).value(parameters)).collect();
        (0..self.matrices.parameters.len()).map(by).collect()
    }

    fn split(&self, coefficients: &[f64]) -> Coefficients {
        let (damping, stiffness) = coefficients.split_at(self.matrices.damping.len());
        Coefficients { damping: damping.to_vec(), stiffness: stiffness.to_vec() }
    }
}

/// Whether an eigenvalue is the one that is shown of its pair, and in a band.
fn is_wanted(eigenvalue: Eigenvalue, regions: &[Region]) -> bool {
    eigenvalue.im >= 0.0 && regions.iter().any(|region| region.has_frequency_of(eigenvalue))
}

fn is_one(a: Eigenvalue, b: Eigenvalue) -> bool {
    magnitude(a - b) <= CLUSTER * magnitude(a)
}

/// Pairs whose eigenvalues are nearly equal, together.
fn clusters<P>(pairs: Vec<P>, eigenvalue: impl Fn(&P) -> Eigenvalue) -> Vec<Vec<P>> {
    let mut clusters: Vec<Vec<P>> = Vec::new();
    for pair in pairs {
        let value = eigenvalue(&pair);
        match clusters.iter_mut().find(|cluster| cluster.iter().any(|other| is_one(eigenvalue(other), value))) {
            Some(cluster) => cluster.push(pair),
            None => clusters.push(vec![pair]),
        }
    }
    clusters
}

/// The matrix of a number for each two pairs of a cluster.
fn small<P>(cluster: &[P], entry: impl Fn(&P, &P) -> Complex<f64>) -> DMatrix<Complex<f64>> {
    DMatrix::from_fn(cluster.len(), cluster.len(), |row, column| entry(&cluster[row], &cluster[column]))
}

/// The eigenvalues of `-gram^-1 change`, for one or two modes.
fn slopes_of(gram: &DMatrix<Complex<f64>>, change: &DMatrix<Complex<f64>>) -> Option<Vec<Eigenvalue>> {
    let slopes = match gram.nrows() {
        1 => vec![-change[(0, 0)] / gram[(0, 0)]],
        2 => {
            let matrix = -(gram.clone().try_inverse()? * change);
            let half = (matrix[(0, 0)] + matrix[(1, 1)]) * 0.5;
            let gap = (matrix[(0, 0)] - matrix[(1, 1)]) * 0.5;
            let root = square_root(gap * gap + matrix[(0, 1)] * matrix[(1, 0)]);
            vec![half - root, half + root]
        }
        _ => return None,
    };
    slopes.iter().all(|slope| slope.re.is_finite() && slope.im.is_finite()).then_some(slopes)
}

/// The modes of a cluster, from a slope of each for each parameter; everything in this unit.
fn with_slopes(
    eigenvalues: impl Iterator<Item = Eigenvalue>,
    slopes: Option<&[Vec<Eigenvalue>]>,
    unit: f64,
) -> Vec<Mode> {
    let of_mode = |i: usize| slopes.map(|slopes| slopes.iter().map(|of_parameter| of_parameter[i] * unit).collect());
    eigenvalues.enumerate().map(|(i, value)| Mode { eigenvalue: value * unit, slopes: of_mode(i) }).collect()
}

#[cfg(test)]
mod tests;
