//! Polynomials of the changes of coefficients.

use std::ops::Range;

use nalgebra::Complex;

use super::eigenbasis::ComplexMatrix;

/// The products of one, two and three changes, each in the order of its factors.
pub(super) struct Monomials {
    pub(super) first: Vec<f64>,
    pub(super) second: Vec<f64>,
    pub(super) third: Vec<f64>,
}

impl Monomials {
    pub(super) fn new(changes: Vec<f64>) -> Self {
        let count = changes.len();
        let mut second = Vec::with_capacity(count * (count + 1) / 2);
        let mut third = Vec::with_capacity(count * (count + 1) * (count + 2) / 6);
        for k in 0..count {
            for l in k..count {
                let product = changes[k] * changes[l];
                second.push(product);
                third.extend(changes[l..].iter().map(|last| product * last));
            }
        }
        Self { first: changes, second, third }
    }
}

/// Homogeneous polynomials: a row of values for each monomial.
#[derive(Default)]
pub(super) struct Polynomial {
    rows: Vec<Vec<Complex<f64>>>,
}

impl Polynomial {
    /// Adds entries with a matrix of values for each monomial.
    pub(super) fn push<'a>(&mut self, values: impl IntoIterator<Item = &'a ComplexMatrix>) {
        for (place, values) in values.into_iter().enumerate() {
            if place == self.rows.len() {
                self.rows.push(Vec::new());
            }
            self.rows[place].extend_from_slice(values.as_slice());
        }
    }

    /// The number of entries.
    pub(super) fn width(&self) -> usize {
        self.rows.first().map_or(0, Vec::len)
    }

    /// Adds the values of the entries in a range.
    pub(super) fn add_to(&self, sums: &mut [Complex<f64>], range: Range<usize>, monomials: &[f64]) {
        for (row, weight) in self.rows.iter().zip(monomials) {
            for (sum, coefficient) in sums.iter_mut().zip(&row[range.clone()]) {
                sum.re += weight * coefficient.re;
                sum.im += weight * coefficient.im;
            }
        }
    }
}
