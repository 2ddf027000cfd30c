//! A basis of eigenvectors in which changes of a problem are written, found fast: its last bits depend on the processor.

use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, MatRef};
use nalgebra::{Complex, DMatrix};

use super::quadratic::DenseQuadratic;
use crate::numerics::eigenvalues::Eigenvalue;

/// Coefficients change by this part where nothing says by how much.
pub(super) const TYPICAL_CHANGE: f64 = 0.1;

/// Sweeps that balance the couplings of modes, and by how much they scale each at most.
const SWEEPS: usize = 10;
const LARGEST_SCALE: f64 = 30.0;

/// What rounding is taken to be over what shows of it, and up to which part of the norm there is a basis.
const SAFETY: f64 = 10.0;
const LARGEST_ROUNDING: f64 = 1e-9;

pub(super) type ComplexMat = Mat<Complex<f64>>;

/// The eigenvalues of the matrix A of first order of a problem, and what changes of coefficients add to `diag(lambda)`: with the right
/// vectors V and the left ones W, `W V = 1`, these are `W (dA / dc_k) V`.
pub(super) struct FastBasis {
    pub(super) eigenvalues: Vec<Eigenvalue>,
    /// For each coefficient that changes. Modes are scaled so that typical changes couple each to the others as much as these to it.
    pub(super) changes: Vec<ComplexMat>,
    /// `|A|`.
    pub(super) norm: f64,
    /// What rounding makes of an entry of `diag(lambda)` and of changes whose entries are not larger than `|A|`, here and where all
    /// eigenvalues are found.
    pub(super) rounding: f64,
}

impl FastBasis {
    /// The basis at these coefficients for changes of some of them; `None` if there is none, as where vectors are nearly parallel.
    pub(super) fn new(problem: &DenseQuadratic, coefficients: &[f64], changing: &[usize]) -> Option<Self> {
        let companion = problem.at(coefficients).companion();
        let norm = companion.norm();
        let (eigenvalues, right, left) = eigenvectors(&companion)?;
        let mut changes: Vec<ComplexMat> = changing.iter().map(|&k| change(problem, k, &left, &right)).collect();
        let typical: Vec<f64> = changing.iter().map(|&k| TYPICAL_CHANGE * coefficients[k].abs()).collect();
        let scales = scales(&changes, &typical);
        changes.iter_mut().for_each(|change| scale(change, &scales));
        // What A V and W V differ by from what they should be shows whether all of this is so.
        let count = eigenvalues.len();
        let matrix = MatRef::from_column_major_slice(companion.as_slice(), count, count);
        let mut off = real_times(matrix, right.as_ref());
        for (j, value) in eigenvalues.iter().enumerate() {
            off.col_mut(j).iter_mut().zip(right.col(j).iter()).for_each(|(sum, entry)| *sum -= entry * value);
        }
        let of_columns = (0..count).map(|j| norm_of(off.col(j).iter()) * scales[j]);
        let of_rows = largest((0..count).map(|i| norm_of(left.row(i).iter()) / scales[i]));
        let of_vectors = largest((0..count).map(|j| norm_of(right.col(j).iter()) * scales[j]));
        // Those who find all eigenvalues do so for a matrix that differs from A by rounding.
        let backward = count as f64 * f64::EPSILON * norm * of_rows * of_vectors;
        let of_values = of_rows * largest(of_columns);
        let mut unit = &left * &right;
        unit.diagonal_mut().column_vector_mut().iter_mut().for_each(|entry| *entry -= Complex::from(1.0));
        scale(&mut unit, &scales);
        let of_unit = largest((0..count).map(|j| largest(unit.col(j).iter().map(|entry| entry.norm_sqr().sqrt()))));
        let rounding = SAFETY * (of_values + of_unit * norm + backward);
        (rounding <= LARGEST_ROUNDING * norm).then_some(Self { eigenvalues, changes, norm, rounding })
    }
}

/// All eigenvalues of a matrix with right vectors as columns and left ones as rows.
fn eigenvectors(matrix: &DMatrix<f64>) -> Option<(Vec<Eigenvalue>, ComplexMat, ComplexMat)> {
    if matrix.iter().any(|entry| !entry.is_finite()) {
        return None;
    }
    let found = MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols()).eigen().ok()?;
    let right = found.U().to_owned();
    let left = right.partial_piv_lu().inverse();
    Some((found.S().column_vector().iter().copied().collect(), right, left))
}

/// `W (dA / dc) V` for a coefficient c.
fn change(problem: &DenseQuadratic, coefficient: usize, left: &ComplexMat, right: &ComplexMat) -> ComplexMat {
    let term = problem.term(coefficient);
    let size = term.nrows();
    let held = right.nrows() - size;
    // Displacements are the first coordinates of the state, but for those that dampers alone hold; rates are the last.
    let (first, moved) = match problem.is_damping(coefficient) {
        true => (0, right.as_ref().subrows(held, size)),
        false => (size - held, right.as_ref().subrows(0, held)),
    };
    let term = Mat::from_fn(size, size - first, |i, j| -term[(i, first + j)]);
    left.as_ref().subcols(held, size) * real_times(term.as_ref(), moved)
}

/// The product of a real and a complex matrix.
fn real_times(real: MatRef<'_, f64>, complex: MatRef<'_, Complex<f64>>) -> ComplexMat {
    let part = |of: &dyn Fn(Complex<f64>) -> f64| {
        real * Mat::from_fn(complex.nrows(), complex.ncols(), |i, j| of(complex[(i, j)]))
    };
    let [re, im] = [part(&|entry| entry.re), part(&|entry| entry.im)];
    Mat::from_fn(re.nrows(), re.ncols(), |i, j| Complex::new(re[(i, j)], im[(i, j)]))
}

fn norm_of<'a>(entries: impl Iterator<Item = &'a Complex<f64>>) -> f64 {
    entries.map(Complex::norm_sqr).sum::<f64>().sqrt()
}

/// The largest of some numbers, or NaN if one is.
fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, |largest: f64, number| if largest.is_nan() || number <= largest { largest } else { number })
}

/// Scales of modes with which typical changes couple each to the others as much as these to it.
fn scales(changes: &[ComplexMat], typical: &[f64]) -> Vec<f64> {
    let count = changes.first().map_or(0, Mat::nrows);
    let mut sums = DMatrix::<f64>::zeros(count, count);
    for (change, size) in changes.iter().zip(typical) {
        for (j, mut column) in sums.column_iter_mut().enumerate() {
            column
                .iter_mut()
                .enumerate()
                .filter(|(i, _)| *i != j)
                .for_each(|(i, sum)| *sum += size * change[(i, j)].norm_sqr().sqrt());
        }
    }
    let across = sums.transpose();
    let mut scales = vec![1.0_f64; count];
    for _ in 0..SWEEPS {
        for i in 0..count {
            let row: f64 = across.column(i).iter().zip(&scales).map(|(entry, scale)| entry * scale).sum();
            let column: f64 = sums.column(i).iter().zip(&scales).map(|(entry, scale)| entry / scale).sum();
            if row > 0.0 && column > 0.0 {
                scales[i] = (row / column).sqrt().clamp(1.0 / LARGEST_SCALE, LARGEST_SCALE);
            }
        }
    }
    scales
}

fn scale(matrix: &mut ComplexMat, scales: &[f64]) {
    for j in 0..scales.len() {
        for i in 0..scales.len() {
            matrix[(i, j)] *= scales[j] / scales[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use crate::models::matrices::region::magnitude;

    use super::*;

    #[test]
    fn what_is_not_a_number_is_the_largest_wherever_it_is() {
        for numbers in [[f64::NAN, 1.0, 2.0], [1.0, f64::NAN, 2.0], [1.0, 2.0, f64::NAN]] {
            assert!(largest(numbers.into_iter()).is_nan());
        }
        assert_eq!(largest([1.0, 3.0, 2.0].into_iter()), 3.0);
    }

    /// Two modes of which a change couples one to the other a hundred times as strongly as back.
    #[test]
    fn modes_are_scaled_so_that_they_couple_both_ways_alike() {
        let stiffness = [dmatrix![1.0, 0.0; 0.0, 4.0], dmatrix![0.3, 10.0; 0.1, 0.2]];
        let damping = [dmatrix![0.02, 0.0; 0.0, 0.03]];
        let problem = DenseQuadratic::new(&DMatrix::identity(2, 2), &damping, &stiffness, &[1.0; 3]).unwrap();
        let coefficients = [1.0, 1.0, 1e-3];
        let FastBasis { eigenvalues, changes, norm, rounding } = FastBasis::new(&problem, &coefficients, &[2]).unwrap();
        assert!(rounding > 0.0 && rounding < 1e-12 * norm, "{rounding}");
        let count = eigenvalues.len();
        let coupling = |i: usize, j: usize| if i == j { 0.0 } else { magnitude(changes[0][(i, j)]) };
        for i in 0..count {
            let sums = [(0..count).map(|j| coupling(i, j)).sum::<f64>(), (0..count).map(|j| coupling(j, i)).sum()];
            assert!((sums[0] / sums[1] - 1.0).abs() < 0.01, "{i}: {sums:?}");
        }
        // The diagonal of a change is the derivative of each eigenvalue.
        let step = 1e-7;
        let moved = problem.at(&[1.0, 1.0, 1e-3 + step]).eigenvalues().unwrap();
        for (i, eigenvalue) in eigenvalues.iter().enumerate() {
            let expected = eigenvalue + changes[0][(i, i)] * step;
            let nearest = moved.iter().map(|value| magnitude(value - expected)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-11, "{i} {nearest}");
        }
    }
}
