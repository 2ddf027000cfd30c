//! Norms of sums of matrices as polynomials in their factors.

use nalgebra::{Complex, DMatrix};

use super::fast_basis::ComplexMat;

/// The rounding of a term of a sum, in parts of it, and more.
const ROUNDING: f64 = 1e-12;

/// Quadratic forms in factors: a row for each product of two, in the order of [`pairs`], an entry for each row of the matrices.
pub(super) struct Forms(Vec<Vec<f64>>);

impl Forms {
    /// The squared norms of rows of sums of these matrices.
    pub(super) fn new(matrices: &[ComplexMat]) -> Self {
        let of_pair = |(k, l): (usize, usize)| {
            let twice = if k == l { 1.0 } else { 2.0 };
            let mut sums = vec![0.0; matrices[k].nrows()];
            for (one, other) in matrices[k].col_iter().zip(matrices[l].col_iter()) {
                sums.iter_mut()
                    .zip(one.iter().zip(other.iter()))
                    .for_each(|(sum, (a, b))| *sum += twice * inner(*a, *b));
            }
            sums
        };
        Self(pairs(matrices.len()).map(of_pair).collect())
    }

    /// The norms for these products of two factors.
    pub(super) fn norms(&self, products: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.0.first().map_or(0, Vec::len)];
        for (row, product) in self.0.iter().zip(products) {
            sums.iter_mut().zip(row).for_each(|(sum, entry)| *sum += with_rounding(product * entry));
        }
        sums.into_iter().map(|sum| not_negative(sum).sqrt()).collect()
    }
}

/// The bound `tr((G^H G)^2)^(1/4)` of the 2-norm of sums G of matrices: its fourth power as a form in products of two factors.
pub(super) struct NormForm(DMatrix<f64>);

impl NormForm {
    pub(super) fn new(matrices: &[ComplexMat]) -> Self {
        let square = |(k, l): (usize, usize)| {
            let square = matrices[k].adjoint() * &matrices[l];
            if k == l { square } else { &square + square.adjoint() }
        };
        let squares: Vec<ComplexMat> = pairs(matrices.len()).map(square).collect();
        let of_pair = |a: &ComplexMat, b: &ComplexMat| -> f64 {
            let of_column = |j: usize| a.col(j).iter().zip(b.col(j).iter()).map(|(a, b)| inner(*a, *b)).sum::<f64>();
            (0..a.ncols()).map(of_column).sum()
        };
        let mut form = DMatrix::from_element(squares.len(), squares.len(), 0.0);
        for (p, q) in pairs(squares.len()) {
            form[(p, q)] = of_pair(&squares[p], &squares[q]);
            form[(q, p)] = form[(p, q)];
        }
        Self(form)
    }

    pub(super) fn norm(&self, products: &[f64]) -> f64 {
        let of_column = |column: &[f64], product: f64| {
            column.iter().zip(products).map(|(entry, other)| with_rounding(product * entry * other)).sum::<f64>()
        };
        let columns = self.0.as_slice().chunks(products.len().max(1)).zip(products);
        let form: f64 = columns.map(|(column, product)| of_column(column, *product)).sum();
        not_negative(form).sqrt().sqrt()
    }
}

/// The places of the factors of products of two of so many.
pub(super) fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |k| (k..count).map(move |l| (k, l)))
}

/// The products of two factors.
pub(super) fn products(factors: &[f64]) -> Vec<f64> {
    pairs(factors.len()).map(|(k, l)| factors[k] * factors[l]).collect()
}

/// `Re(a conj(b))`.
pub(super) fn inner(a: Complex<f64>, b: Complex<f64>) -> f64 {
    a.re * b.re + a.im * b.im
}

/// A sum that cannot be negative but for rounding; NaN stays.
fn not_negative(sum: f64) -> f64 {
    if sum < 0.0 { 0.0 } else { sum }
}

/// A term of a sum that cannot be negative, where it may cancel others: larger by more than the rounding of both.
fn with_rounding(term: f64) -> f64 {
    term + ROUNDING * term.abs()
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::models::matrices::trial::Numbers;

    #[test]
    fn forms_are_the_norms_of_rows_of_sums() {
        let mut numbers = Numbers(9);
        for _ in 0..50 {
            let mut number = || Complex::new(numbers.next(), numbers.next());
            let matrices: Vec<ComplexMat> = (0..3).map(|_| Mat::from_fn(4, 6, |_, _| number())).collect();
            let changes: Vec<f64> = (0..3).map(|_| numbers.next()).collect();
            let norms = Forms::new(&matrices).norms(&products(&changes));
            for (i, norm) in norms.into_iter().enumerate() {
                let entry =
                    |r: usize| matrices.iter().zip(&changes).map(|(matrix, change)| matrix[(i, r)] * change).sum();
                let square: f64 = (0..6)
                    .map(|r| {
                        let sum: Complex<f64> = entry(r);
                        sum.norm_sqr()
                    })
                    .sum();
                assert!((norm - square.sqrt()).abs() < 1e-9, "{norm} {square}");
            }
        }
        // What is not a number is no norm.
        assert!(Forms::new(&[Mat::from_fn(1, 1, |_, _| Complex::from(1.0))]).norms(&[f64::NAN])[0].is_nan());
        // What cancels is not less than nothing.
        let one = Mat::from_fn(1, 3, |_, r| Complex::new(0.1, 0.3 * r as f64));
        let other = Mat::from_fn(1, 3, |_, r| -one[(0, r)]);
        let norm = Forms::new(&[one, other]).norms(&products(&[0.7, 0.7]))[0];
        assert!((0.0..1e-5).contains(&norm), "{norm}");
    }
}
