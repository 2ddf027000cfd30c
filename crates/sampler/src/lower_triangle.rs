//! Lower triangular matrices, packed row by row, each row up to its diagonal.

/// Square of the smallest diagonal element of a factor; a smaller one may be a rounding error.
const SMALLEST_PIVOT: f64 = 1e-14;

/// The position at which row `row` begins.
pub(crate) fn row_start(row: usize) -> usize {
    row * (row + 1) / 2
}

/// A row up to its diagonal.
pub(crate) fn row(matrix: &[f64], row: usize) -> &[f64] {
    &matrix[row_start(row)..=row_start(row) + row]
}

/// Cholesky's factorisation in place of the lower half of a symmetric matrix, row by row.
///
/// # Errors
/// The first row at which the matrix is not positive definite.
pub(crate) fn factorise(size: usize, matrix: &mut [f64]) -> Result<(), usize> {
    for row in 0..size {
        let (before, current) = matrix.split_at_mut(row_start(row));
        for column in 0..=row {
            // On the diagonal, the row times itself.
            let known: f64 = if column < row {
                let other = &before[row_start(column)..][..column];
                current[..column].iter().zip(other).map(|(a, b)| a * b).sum()
            } else {
                current[..row].iter().map(|a| a * a).sum()
            };
            let rest = current[column] - known;
            current[column] = if column < row {
                rest / before[row_start(column) + column]
            } else if rest > SMALLEST_PIVOT {
                rest.sqrt()
            } else {
                return Err(row);
            };
        }
    }
    Ok(())
}

/// Replaces `z` by `L z`.
#[inline]
pub(crate) fn multiply(factor: &[f64], z: &mut [f64]) {
    // From the last row back: each needs only itself and those before it.
    for i in (0..z.len()).rev() {
        z[i] = row(factor, i).iter().zip(&*z).map(|(element, z)| element * z).sum();
    }
}

/// Replaces `x` by the solution `z` of `L z = x`.
pub(crate) fn solve(factor: &[f64], x: &mut [f64]) {
    for i in 0..x.len() {
        let row = row(factor, i);
        let known: f64 = row[..i].iter().zip(&*x).map(|(element, z)| element * z).sum();
        x[i] = (x[i] - known) / row[i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_is_undone_by_its_solution() {
        // numpy.linalg.cholesky([[4, 2, 0.6], [2, 10, 1.5], [0.6, 1.5, 1]]).
        let mut matrix = vec![4.0, 2.0, 10.0, 0.6, 1.5, 1.0];
        factorise(3, &mut matrix).unwrap();
        for (element, expected) in matrix.iter().zip([2.0, 1.0, 3.0, 0.3, 0.4, 0.866_025_403_784_438_6]) {
            assert!((element - expected).abs() < 1e-15);
        }
        let mut z = vec![0.3, -1.2, 2.5];
        multiply(&matrix, &mut z);
        solve(&matrix, &mut z);
        for (z, expected) in z.iter().zip([0.3, -1.2, 2.5]) {
            assert!((z - expected).abs() < 1e-14);
        }
        assert_eq!(factorise(2, &mut [1.0, 1.0, 1.0]), Err(1));
    }
}
