//! Rigid-body motions: what no stiffness and no damping holds, whatever the parameters.

use nalgebra::{DMatrix, DVector};

/// A motion is free of a matrix if it makes no more force than this, in parts of the largest entry.
const FREE: f64 = 1e-11;

/// In each direction the forces of a free motion cancel to this part of their sizes, unless they are rounding: a soft direction beside
/// stiff ones makes little force too, but nothing cancels there.
const CANCELLED: f64 = 1e-10;

/// Rounding of a force for each coordinate, in parts of the largest entry.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Terms in which no motion is free, nor nearly so, are told by a factorisation.
const NEARLY_FREE: f64 = 1e-10;

/// Directions that no term moves from the right (`A x = 0` for all of them), as orthonormal columns.
pub(super) fn free(terms: &[DMatrix<f64>], size: usize) -> DMatrix<f64> {
    let scaled: Vec<DMatrix<f64>> =
        terms.iter().filter(|term| term.amax() > 0.0).map(|term| term / term.amax()).collect();
    let mut sum = DMatrix::zeros(size, size);
    scaled.iter().for_each(|term| sum += term.tr_mul(term));
    let least = NEARLY_FREE * sum.amax();
    let shifted = &sum - DMatrix::identity(size, size) * least;
    if size == 0 || least > 0.0 && shifted.cholesky().is_some() {
        return DMatrix::zeros(size, 0);
    }
    // The squares in the sum would lose half of the digits.
    let rows = scaled.len() * size;
    let stacked = DMatrix::from_fn(rows.max(1), size, |row, column| {
        scaled.get(row / size).map_or(0.0, |term| term[(row % size, column)])
    });
    let triangle = if rows > size { stacked.qr().r() } else { stacked };
    // Singular vectors are as many as columns of a square matrix.
    let square = triangle.resize_vertically(size, 0.0);
    let Some(decomposed) = square.try_svd(false, true, f64::EPSILON, 60 * size) else {
        return DMatrix::zeros(size, 0);
    };
    let Some(vectors) = decomposed.v_t else { return DMatrix::zeros(size, 0) };
    let is_free = |index: &usize| decomposed.singular_values[*index] <= FREE;
    let cancels = |motion: &DVector<f64>| {
        scaled.iter().all(|term| {
            let sizes = term.abs() * motion.abs();
            let rounding = ROUNDING * size as f64;
            (term * motion).iter().zip(&sizes).all(|(force, size)| force.abs() <= CANCELLED * size + rounding)
        })
    };
    let columns = (0..size).filter(is_free).map(|index| vectors.row(index).transpose());
    let columns: Vec<DVector<f64>> = columns.filter(cancels).collect();
    if columns.is_empty() { DMatrix::zeros(size, 0) } else { DMatrix::from_columns(&columns) }
}

/// Terms without the motions that are free of all of them, in coordinates in which the mass is the identity, and these
/// motions.
///
/// With orthonormal columns `[R S]` and `A R = 0` for every term, `[R S]^T Q [R S]` is block triangular: the eigenvalues are
/// two zeros for each column of R and those of `S^T Q S`. So they are with `R^T A = 0`; friction can make one without the
/// other.
pub(super) fn without_free(mut terms: Vec<DMatrix<f64>>) -> (Vec<DMatrix<f64>>, DMatrix<f64>) {
    let size = terms.first().map_or(0, DMatrix::nrows);
    let mut kept = DMatrix::identity(size, size);
    let mut motions = DMatrix::zeros(size, 0);
    loop {
        let now = kept.ncols();
        let transposed = || terms.iter().map(DMatrix::transpose).collect::<Vec<_>>();
        let mut none_holds = free(&terms, now);
        if none_holds.ncols() == 0 {
            none_holds = free(&transposed(), now);
        }
        if none_holds.ncols() == 0 {
            return (terms, motions);
        }
        let found = &kept * &none_holds;
        motions = DMatrix::from_fn(size, motions.ncols() + found.ncols(), |row, column| {
            if column < motions.ncols() { motions[(row, column)] } else { found[(row, column - motions.ncols())] }
        });
        let rest = complement(&none_holds);
        terms = terms.iter().map(|term| rest.tr_mul(&(term * &rest))).collect();
        kept *= rest;
    }
}

/// Orthonormal columns that complete these.
pub(super) fn complement(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let (size, number) = columns.shape();
    if number == size {
        return DMatrix::zeros(size, 0);
    }
    let all = DMatrix::from_fn(size, number + size, |row, column| match column.checked_sub(number) {
        None => columns[(row, column)],
        Some(unit) => f64::from(u8::from(row == unit)),
    });
    // Of the unit vectors, those that are farthest from what is there already.
    let mut basis: Vec<DVector<f64>> = Vec::with_capacity(size);
    let mut rest: Vec<DVector<f64>> = all.column_iter().map(nalgebra::Matrix::into_owned).collect();
    while basis.len() < size && !rest.is_empty() {
        let next = if basis.len() < number {
            0
        } else {
            let longest = |a: &(usize, f64), b: &(usize, f64)| if b.1 > a.1 { *b } else { *a };
            let lengths = rest.iter().enumerate().map(|(index, vector)| (index, vector.norm_squared()));
            lengths.fold((0, -1.0), |a, b| longest(&a, &b)).0
        };
        let mut vector = rest.remove(next);
        for _ in 0..2 {
            for other in &basis {
                let share = other.dot(&vector);
                vector.axpy(-share, other, 1.0);
            }
        }
        let vector = vector.normalize();
        for other in &mut rest {
            let share = vector.dot(other);
            other.axpy(-share, &vector, 1.0);
        }
        basis.push(vector);
    }
    DMatrix::from_columns(&basis[number..])
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;

    /// Three masses in a row with springs between them, in a plane in which nothing holds them across.
    #[test]
    fn free_motions_are_found_and_the_rest_keeps_its_eigenvalues() {
        let chain = dmatrix![1.0, -1.0, 0.0; -1.0, 2.5, -1.5; 0.0, -1.5, 1.5];
        let (terms, motions) = without_free(vec![chain.clone(), chain.clone() * 0.01]);
        assert_eq!((terms[0].shape(), motions.ncols()), ((2, 2), 1));
        assert!(motions.iter().all(|entry| (entry.abs() - 1.0 / 3.0_f64.sqrt()).abs() < 1e-12), "{motions}");
        let mut expected: Vec<f64> = chain.symmetric_eigenvalues().iter().copied().collect();
        expected.sort_by(f64::total_cmp);
        let mut found: Vec<f64> = terms[0].symmetric_eigenvalues().iter().copied().collect();
        found.sort_by(f64::total_cmp);
        assert!(found.iter().zip(&expected[1..]).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} {expected:?}");
    }

    #[test]
    fn what_one_term_holds_is_not_free() {
        let grounded = dmatrix![1.0, -1.0; -1.0, 1.0];
        for other in [dmatrix![1e-6, 0.0; 0.0, 0.0], dmatrix![0.0, 1.0; 0.0, 0.0]] {
            let (terms, motions) = without_free(vec![grounded.clone(), other]);
            assert_eq!((terms[0].shape(), motions.ncols()), ((2, 2), 0));
        }
    }

    #[test]
    fn a_soft_direction_beside_stiff_ones_is_not_free() {
        for stiff in [1e11, 1e12, 1e14] {
            let (terms, motions) = without_free(vec![dmatrix![1.0, 0.0, 0.0; 0.0, 0.0, 0.0; 0.0, 0.0, stiff]]);
            assert_eq!((terms[0].shape(), motions.ncols()), ((2, 2), 1), "{stiff}");
            assert_eq!(motions[(1, 0)].abs(), 1.0);
            // Two masses on a soft spring, one of them held by a stiff one to a third, and nothing else.
            let chain = dmatrix![1.0, -1.0, 0.0; -1.0, 1.0 + stiff, -stiff; 0.0, -stiff, stiff];
            assert_eq!(without_free(vec![chain]).1.ncols(), 1, "{stiff}");
        }
    }

    /// Friction that a free mass exerts on another one without feeling it: only from the left is there nothing.
    #[test]
    fn motions_that_feel_no_force_are_free_from_the_left() {
        let stiffness = dmatrix![2.0, 0.0; 0.0, 0.0];
        let friction = dmatrix![0.0, 0.5; 0.0, 0.0];
        let (terms, motions) = without_free(vec![stiffness, friction]);
        assert_eq!((terms[0].clone(), motions.ncols()), (dmatrix![2.0], 1));
        assert_eq!(motions.column(0).amax(), 1.0);
    }

    #[test]
    fn nothing_is_left_of_a_model_without_forces() {
        let (terms, motions) = without_free(vec![DMatrix::zeros(2, 2)]);
        assert_eq!((terms[0].shape(), motions.ncols()), ((0, 0), 2));
    }
}
