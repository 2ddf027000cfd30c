//! The quadratic eigenvalue problem of a sum of dense matrices.

use nalgebra::{Complex, DMatrix, DVector};
use thiserror::Error;

use super::region::magnitude;
use super::rigid_body::{complement, free, without_free};
use crate::numerics::eigenvalues::{Eigenvalue, EigenvalueError, eigenvalues, fast_eigenvalues};

/// The difference of two entries, over their size, that rounding makes.
const ROUNDING: f64 = 1e-14;

/// `(lambda^2 M + lambda C + K) q = 0` with `C = sum_i c_i C_i` and `K = sum_j k_j K_j`, the c_i and k_j being
/// coefficients that differ from sample to sample. M is symmetric and positive definite, and the same in all samples.
///
/// Held in coordinates in which M is the identity (M = L L^T; A becomes `L^-1 A L^-T`) and in a unit of frequency in which
/// K is near 1.
#[derive(Debug, Clone)]
pub struct DenseQuadratic {
    /// Matrices of the coefficients: first those of C, then those of K.
    terms: Vec<DMatrix<f64>>,
    /// How many belong to C.
    damping_terms: usize,
    /// rad/s of the unit of frequency.
    unit: f64,
    /// What a coordinate moves in those of the given matrices, as columns.
    displacements: DMatrix<f64>,
    /// Of so many coordinates, the first ones, no stiffness depends, whatever the coefficients: dampers alone hold them. They are
    /// no part of the state, so that it has no eigenvalues that are zero for them.
    unheld: usize,
    /// How many eigenvalues are zero with any coefficients all the same.
    zeros: usize,
}

/// Why there is no such problem.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum QuadraticError {
    /// The mass matrix has a direction without mass.
    #[error("the mass matrix is not positive definite: some motion of the model has no mass")]
    MassNotDefinite,
}

impl DenseQuadratic {
    /// The problem of these matrices, which are square and of one size. Typical coefficients, in the order of the terms
    /// of C and then those of K, fix the unit of frequency.
    ///
    /// # Errors
    /// [`QuadraticError::MassNotDefinite`].
    pub fn new(
        mass: &DMatrix<f64>,
        damping: &[DMatrix<f64>],
        stiffness: &[DMatrix<f64>],
        typical: &[f64],
    ) -> Result<Self, QuadraticError> {
        // Degrees of freedom may have different units, such as m and rad: scaled by powers of two to a mass near 1.
        let scales: Vec<f64> = mass.diagonal().iter().map(|mass| power_of_two(1.0 / mass.abs().sqrt())).collect();
        if mass.diagonal().iter().any(|mass| mass.is_nan() || *mass <= 0.0) {
            return Err(QuadraticError::MassNotDefinite);
        }
        let scaled = |matrix: &DMatrix<f64>| {
            DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |row, column| {
                matrix[(row, column)] * scales[row] * scales[column]
            })
        };
        let mass = scaled(mass);
        let mass = 0.5 * (&mass + mass.transpose());
        let factor = mass.cholesky().ok_or(QuadraticError::MassNotDefinite)?.unpack();
        let smallest = factor.diagonal().iter().fold(f64::INFINITY, |least, value| least.min(*value));
        if smallest < 1e-7 * factor.diagonal().amax() {
            return Err(QuadraticError::MassNotDefinite);
        }
        let reduced = |matrix: &DMatrix<f64>| {
            let mut left = scaled(matrix);
            factor.solve_lower_triangular_mut(&mut left);
            let mut both = left.transpose();
            factor.solve_lower_triangular_mut(&mut both);
            both.transpose()
        };
        let mut terms: Vec<DMatrix<f64>> = damping.iter().chain(stiffness).map(reduced).collect();
        let of_stiffness = terms.iter().zip(typical).skip(damping.len());
        let size = of_stiffness.map(|(term, coefficient)| term.amax() * coefficient.abs()).fold(0.0, f64::max);
        let unit = if size > 0.0 && size.is_finite() { power_of_two(size.sqrt()) } else { 1.0 };
        for (i, term) in terms.iter_mut().enumerate() {
            *term /= if i < damping.len() { unit } else { unit * unit };
        }
        let mut displacements = DMatrix::identity(scales.len(), scales.len());
        factor.tr_solve_lower_triangular_mut(&mut displacements);
        for (mut row, scale) in displacements.row_iter_mut().zip(&scales) {
            row *= *scale;
        }
        let zeros = zeros(&terms[damping.len()..], scales.len());
        Ok(Self { terms, damping_terms: damping.len(), unit, displacements, unheld: 0, zeros })
    }

    /// The problem without its rigid-body motions, which no stiffness and no damping holds, whatever the coefficients: each
    /// has two eigenvalues that are zero. With these motions, as displacements of the given coordinates. Motions that dampers alone
    /// hold become coordinates of their own, without the eigenvalue that is zero for each.
    #[must_use]
    pub fn without_rigid_body_motions(self) -> (Self, Vec<DVector<f64>>) {
        let (mut terms, motions) = without_free(self.terms);
        let motions = &self.displacements * motions;
        let motions = motions.column_iter().map(nalgebra::Matrix::into_owned).collect();
        let size = terms.first().map_or(0, DMatrix::nrows);
        let zeros = zeros(&terms[self.damping_terms..], size);
        let unheld = unheld_first(&mut terms, self.damping_terms);
        (Self { terms, unheld, zeros: zeros - unheld, ..self }, motions)
    }

    /// The number of coordinates.
    #[must_use]
    pub fn size(&self) -> usize {
        self.terms.first().map_or(0, DMatrix::nrows)
    }

    /// The number of coefficients.
    #[must_use]
    pub fn coefficients(&self) -> usize {
        self.terms.len()
    }

    /// rad/s of the unit of frequency in which eigenvalues of [`DenseQuadratic::at`] are.
    #[must_use]
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// Whether a coefficient belongs to C.
    #[must_use]
    pub(super) fn is_damping(&self, coefficient: usize) -> bool {
        coefficient < self.damping_terms
    }

    /// The matrix of a coefficient.
    #[must_use]
    pub(super) fn term(&self, coefficient: usize) -> &DMatrix<f64> {
        &self.terms[coefficient]
    }

    /// The entries of C and of K of a problem of two coordinates, by columns.
    pub(super) fn entries_of_two(&self, coefficients: &[f64]) -> [[f64; 4]; 2] {
        let mut sums = [[0.0; 4]; 2];
        for (place, (term, coefficient)) in self.terms.iter().zip(coefficients).enumerate() {
            let sums = &mut sums[usize::from(place >= self.damping_terms)];
            sums.iter_mut().zip(term.as_slice()).for_each(|(sum, value)| *sum += coefficient * value);
        }
        sums
    }

    /// The problem with these coefficients.
    #[must_use]
    pub fn at(&self, coefficients: &[f64]) -> Quadratic {
        self.sums(coefficients, |value| value)
    }

    /// The same sums of the moduli of all entries.
    pub(super) fn magnitudes_at(&self, coefficients: &[f64]) -> Quadratic {
        self.sums(coefficients, f64::abs)
    }

    fn sums(&self, coefficients: &[f64], of: impl Fn(f64) -> f64) -> Quadratic {
        let size = self.size();
        let sum = |places: std::ops::Range<usize>| {
            let mut sum = DMatrix::zeros(size, size);
            for (term, coefficient) in self.terms[places.clone()].iter().zip(&coefficients[places]) {
                if *coefficient != 0.0 {
                    for (sum, value) in sum.as_mut_slice().iter_mut().zip(term.as_slice()) {
                        *sum += coefficient * of(*value);
                    }
                }
            }
            sum
        };
        let [damping, stiffness] = [0..self.damping_terms, self.damping_terms..self.terms.len()].map(sum);
        Quadratic { damping, stiffness, unheld: self.unheld, zeros: self.zeros }
    }

    /// Whether no eigenvalue is zero with these coefficients, whatever rounding does to the entries of matrices: K is regular, with the
    /// columns of C in place of those that it does not have. `|K^-1| R` has a norm below 1 for the rounding R of the entries.
    pub(super) fn is_regular(&self, coefficients: &[f64]) -> bool {
        let forces = |Quadratic { damping, mut stiffness, unheld, .. }: Quadratic| {
            stiffness.columns_mut(0, unheld).copy_from(&damping.columns(0, unheld));
            stiffness
        };
        let Some(inverse) = forces(self.at(coefficients)).try_inverse() else { return false };
        let sizes: Vec<f64> = coefficients.iter().map(|value| ROUNDING * value.abs()).collect();
        (inverse.abs() * forces(self.magnitudes_at(&sizes))).row_iter().all(|row| row.sum() < 1.0)
    }

    /// How many eigenvalues are zero with any coefficients: of motions that no stiffness holds.
    pub(super) fn zeros(&self) -> usize {
        self.zeros
    }

    /// Of each term the norm of what keeps the spectrum from being its own mirror image: the symmetric part of C, the skew one of K.
    pub(super) fn asymmetries(&self) -> Vec<f64> {
        let sign = |index: usize| if self.is_damping(index) { 1.0 } else { -1.0 };
        let terms = self.terms.iter().enumerate();
        terms.map(|(index, term)| 0.5 * (term + sign(index) * term.transpose()).norm()).collect()
    }

    /// Whether with any coefficients each eigenvalue has its mirror image at the imaginary axis: without damping, or with symmetric
    /// stiffness and gyroscopic forces alone.
    pub(super) fn mirrored(&self) -> Mirrored {
        let (damping, stiffness) = self.terms.split_at(self.damping_terms);
        if damping.iter().all(|term| term.amax() == 0.0) {
            return Mirrored::Surely;
        }
        let with = |is: fn(&DMatrix<f64>, f64) -> bool| {
            damping.iter().all(|term| is(term, -1.0)) && stiffness.iter().all(|term| is(term, 1.0))
        };
        if with(is_its_transpose_times) {
            Mirrored::Surely
        } else if with(is_nearly_its_transpose_times) {
            Mirrored::ButForRounding
        } else {
            Mirrored::No
        }
    }
}

/// Whether a spectrum is its own mirror image at the imaginary axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mirrored {
    /// It is, whatever the coefficients.
    Surely,
    /// The matrices make it so but for their own rounding, as those do that were turned into other coordinates.
    ButForRounding,
    /// It is not.
    No,
}

fn is_its_transpose_times(term: &DMatrix<f64>, sign: f64) -> bool {
    term.iter().zip(term.transpose().iter()).all(|(a, b)| (a - sign * b).abs() <= ROUNDING * (a.abs() + b.abs()))
}

/// The same but for what rounding makes of the largest entry of a row or column.
fn is_nearly_its_transpose_times(term: &DMatrix<f64>, sign: f64) -> bool {
    let size = term.nrows();
    let largest: Vec<f64> = (0..size).map(|i| term.row(i).amax().max(term.column(i).amax())).collect();
    let is_rounding = |i: usize, j: usize| {
        (term[(i, j)] - sign * term[(j, i)]).abs() <= 8.0 * f64::EPSILON * largest[i].min(largest[j])
    };
    (0..size).all(|i| (0..=i).all(|j| is_rounding(i, j)))
}

/// `(lambda^2 + lambda C + K) q = 0`.
#[derive(Debug, Clone)]
pub struct Quadratic {
    /// C.
    pub damping: DMatrix<f64>,
    /// K.
    pub stiffness: DMatrix<f64>,
    /// Of how many coordinates, the first ones, K does not depend.
    pub unheld: usize,
    /// How many eigenvalues are known to be zero.
    pub zeros: usize,
}

impl Quadratic {
    /// The matrix `A` of `z' = A z` for `z = (q, q')`, where q is without the coordinates on which K does not depend.
    #[must_use]
    pub fn companion(&self) -> DMatrix<f64> {
        let (size, unheld) = (self.stiffness.nrows(), self.unheld);
        let held = size - unheld;
        DMatrix::from_fn(held + size, held + size, |row, column| {
            match (row.checked_sub(held), column.checked_sub(held)) {
                (None, None) => 0.0,
                (None, Some(column)) => f64::from(u8::from(unheld + row == column)),
                (Some(row), None) => -self.stiffness[(row, unheld + column)],
                (Some(row), Some(column)) => -self.damping[(row, column)],
            }
        })
    }

    /// All eigenvalues, both of each conjugate pair, without those of coordinates on which K does not depend. Others that are known to
    /// be zero are so without rounding: as many of the smallest.
    ///
    /// # Errors
    /// As [`eigenvalues`].
    pub fn eigenvalues(&self) -> Result<Vec<Eigenvalue>, EigenvalueError> {
        Ok(self.with_zeros(eigenvalues(&self.companion())?))
    }

    /// The same in any order and with last bits that depend on the processor, faster; `None` where they cannot be computed.
    pub(super) fn fast_eigenvalues(&self) -> Option<Vec<Eigenvalue>> {
        let (values, _) = fast_eigenvalues(&self.companion())?;
        Some(self.with_zeros(values))
    }

    /// All eigenvalues without the rounding of those that are known to be zero.
    fn with_zeros(&self, mut values: Vec<Eigenvalue>) -> Vec<Eigenvalue> {
        for place in self.known_zeros(&values) {
            values[place] = Eigenvalue::from(0.0);
        }
        values
    }

    /// Which of all eigenvalues are those that are known to be zero.
    pub(super) fn known_zeros(&self, values: &[Eigenvalue]) -> Vec<usize> {
        if self.zeros == 0 {
            return Vec::new();
        }
        let mut rising: Vec<usize> = (0..values.len()).collect();
        rising.sort_by(|a, b| magnitude(values[*a]).total_cmp(&magnitude(values[*b])));
        rising.truncate(self.zeros);
        rising
    }

    /// `lambda^2 + lambda C + K`.
    #[must_use]
    pub fn value(&self, eigenvalue: Eigenvalue) -> DMatrix<Complex<f64>> {
        let mut value = DMatrix::from_fn(self.stiffness.nrows(), self.stiffness.ncols(), |row, column| {
            let (damping, stiffness) = (self.damping[(row, column)], self.stiffness[(row, column)]);
            Complex::new(stiffness + eigenvalue.re * damping, eigenvalue.im * damping)
        });
        let square = eigenvalue * eigenvalue;
        (0..value.nrows()).for_each(|row| value[(row, row)] += square);
        value
    }

    /// `(2 lambda + C) x`.
    #[must_use]
    pub fn derivative_times(&self, eigenvalue: Eigenvalue, x: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
        product(&self.damping, x) + x * (eigenvalue * 2.0)
    }

    /// `(2 lambda + C)^T y`.
    #[must_use]
    pub fn transposed_derivative_times(
        &self,
        eigenvalue: Eigenvalue,
        y: &DVector<Complex<f64>>,
    ) -> DVector<Complex<f64>> {
        transposed_product(&self.damping, y) + y * (eigenvalue * 2.0)
    }

    /// The coefficients of `y^T Q(lambda) x` as a polynomial of lambda: `y^T x`, `y^T C x`, `y^T K x`.
    #[must_use]
    pub fn forms(&self, left: &DVector<Complex<f64>>, right: &DVector<Complex<f64>>) -> [Complex<f64>; 3] {
        [left.dot(right), left.dot(&product(&self.damping, right)), left.dot(&product(&self.stiffness, right))]
    }
}

/// How many eigenvalues are zero with any sum of these terms as K.
fn zeros(stiffness: &[DMatrix<f64>], size: usize) -> usize {
    let transposed: Vec<DMatrix<f64>> = stiffness.iter().map(DMatrix::transpose).collect();
    free(stiffness, size).ncols().max(free(&transposed, size).ncols())
}

/// Turns coordinates, so that K depends on none of the first of them, whatever the coefficients; how many these are. The mass stays
/// the identity.
fn unheld_first(terms: &mut [DMatrix<f64>], damping_terms: usize) -> usize {
    let size = terms.first().map_or(0, DMatrix::nrows);
    let unheld = free(&terms[damping_terms..], size);
    let number = unheld.ncols();
    if number == 0 {
        return 0;
    }
    let rest = complement(&unheld);
    let turned = DMatrix::from_fn(size, size, |row, column| match column.checked_sub(number) {
        None => unheld[(row, column)],
        Some(column) => rest[(row, column)],
    });
    for (place, term) in terms.iter_mut().enumerate() {
        *term = turned.tr_mul(&(&*term * &turned));
        if place >= damping_terms {
            term.columns_mut(0, number).fill(0.0);
        }
    }
    number
}

/// A real matrix times a complex vector.
pub(super) fn product(matrix: &DMatrix<f64>, x: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
    let mut sum = DVector::zeros(matrix.nrows());
    for (column, x) in matrix.as_slice().chunks_exact(matrix.nrows().max(1)).zip(x.iter()) {
        sum.iter_mut().zip(column).for_each(|(sum, entry)| *sum += x * *entry);
    }
    sum
}

/// The transpose of a real matrix times a complex vector.
pub(super) fn transposed_product(matrix: &DMatrix<f64>, y: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
    let (re, im) = (matrix.tr_mul(&y.map(|value| value.re)), matrix.tr_mul(&y.map(|value| value.im)));
    re.zip_map(&im, Complex::new)
}

/// The largest power of two not above a positive value.
fn power_of_two(value: f64) -> f64 {
    let (_, exponent) = libm::frexp(value);
    libm::ldexp(1.0, (exponent - 1).clamp(-500, 500))
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;

    /// A soft mode that negative damping drives, beside a stiff one.
    #[test]
    fn a_soft_mode_beside_a_stiff_one_is_not_taken_for_zero() {
        let [damping, stiffness] = [dmatrix![-0.1, 0.0; 0.0, 1.0], dmatrix![1.0, 0.0; 0.0, 1e12]];
        let problem = DenseQuadratic::new(&DMatrix::identity(2, 2), &[damping], &[stiffness], &[1.0, 1.0]).unwrap();
        let values = problem.at(&[1.0, 1.0]).eigenvalues().unwrap();
        assert_eq!(values.iter().filter(|value| value.re > 0.0).count(), 2, "{values:?}");
    }

    /// Two masses of different units: eigenvalues are those of the closed form.
    #[test]
    fn eigenvalues_are_those_of_the_generalised_problem() {
        let mass = dmatrix![4.0, 1.0; 1.0, 3e-6];
        assert!(DenseQuadratic::new(&mass, &[], &[dmatrix![1.0, 0.0; 0.0, 1.0]], &[1.0]).is_err());
        let mass = dmatrix![4.0, 1e-3; 1e-3, 3e-6];
        let stiffness = [dmatrix![5.0, -1e-3; -1e-3, 7e-3], dmatrix![0.0, 2e-3; 0.0, 0.0]];
        let problem = DenseQuadratic::new(&mass, &[], &stiffness, &[1.0, 1.0]).unwrap();
        let sum = &stiffness[0] + &stiffness[1] * 0.5;
        // det(K - w^2 M) = 0.
        let a = mass.determinant();
        let b = -(mass[(0, 0)] * sum[(1, 1)] + mass[(1, 1)] * sum[(0, 0)]
            - mass[(0, 1)] * sum[(1, 0)]
            - mass[(1, 0)] * sum[(0, 1)]);
        let c = sum.determinant();
        let root = (b * b - 4.0 * a * c).sqrt();
        let mut values = problem.at(&[1.0, 0.5]).eigenvalues().unwrap();
        values.retain(|value| value.im > 0.0);
        values.sort_by(|x, y| x.im.total_cmp(&y.im));
        for (value, sign) in values.iter().zip([-1.0, 1.0]) {
            let expected = ((-b + sign * root) / (2.0 * a)).sqrt();
            assert!((value.im * problem.unit() / expected - 1.0).abs() < 1e-12, "{value} {expected}");
        }
    }
}
