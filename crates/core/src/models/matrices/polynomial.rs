//! Polynomials of the changes of coefficients.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{Complex, DMatrix};

use super::eigenbasis::ComplexMatrix;

/// The products of one to four changes, in the order of [`factors`].
pub(super) struct Monomials {
    pub(super) first: Vec<f64>,
    pub(super) second: Vec<f64>,
    pub(super) third: Vec<f64>,
    pub(super) fourth: Vec<f64>,
}

impl Monomials {
    pub(super) fn new(changes: Vec<f64>) -> Self {
        let count = changes.len();
        let mut second = Vec::with_capacity(count * (count + 1) / 2);
        let mut third = Vec::with_capacity(count * (count + 1) * (count + 2) / 6);
        let mut fourth = Vec::with_capacity(count * (count + 1) * (count + 2) * (count + 3) / 24);
        for k in 0..count {
            for l in k..count {
                let product = changes[k] * changes[l];
                second.push(product);
                for m in l..count {
                    let product = product * changes[m];
                    third.push(product);
                    fourth.extend(changes[m..].iter().map(|last| product * last));
                }
            }
        }
        Self { first: changes, second, third, fourth }
    }
}

/// The factors of the products of as many of `count` changes, by their places, rising.
pub(super) fn factors(count: usize, number: usize) -> Vec<Vec<usize>> {
    let Some(fewer) = number.checked_sub(1) else { return vec![Vec::new()] };
    let longer = |shorter: Vec<usize>| {
        let from = shorter.last().copied().unwrap_or(0);
        (from..count).map(move |last| [shorter.as_slice(), &[last]].concat())
    };
    factors(count, fewer).into_iter().flat_map(longer).collect()
}

/// Where the products of two monomials are among those of twice as many factors.
pub(super) struct Products {
    /// For each pair of monomials, by columns.
    places: Vec<usize>,
    /// How many products there are.
    count: usize,
}

impl Products {
    /// Of monomials of as many of `count` changes.
    pub(super) fn new(count: usize, number: usize) -> Self {
        let single = factors(count, number);
        let all: BTreeMap<Vec<usize>, usize> = factors(count, 2 * number).into_iter().zip(0..).collect();
        let place = |(a, b): (&Vec<usize>, &Vec<usize>)| {
            let mut product = [a.as_slice(), b].concat();
            product.sort_unstable();
            all.get(&product).copied()
        };
        let pairs = single.iter().flat_map(|b| single.iter().map(move |a| (a, b)));
        Self { places: pairs.filter_map(place).collect(), count: all.len() }
    }

    /// A quadratic form of the monomials as a polynomial of the products.
    pub(super) fn of_form(&self, form: &DMatrix<f64>) -> Vec<f64> {
        let mut coefficients = vec![0.0; self.count];
        form.iter().zip(&self.places).for_each(|(entry, &place)| coefficients[place] += entry);
        coefficients
    }
}

/// Homogeneous polynomials: a row of values for each monomial.
#[derive(Default)]
pub(super) struct Polynomial {
    rows: Vec<Vec<Complex<f64>>>,
}

impl Polynomial {
    /// With a matrix of values for each monomial.
    pub(super) fn new(values: &Vec<ComplexMatrix>) -> Self {
        let mut polynomial = Self::default();
        polynomial.push(values);
        polynomial
    }

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

    /// The values of the entries in a range.
    pub(super) fn values(&self, range: Range<usize>, monomials: &[f64]) -> Vec<Complex<f64>> {
        let mut values = vec![Complex::from(0.0); range.len()];
        self.add_to(&mut values, range, monomials);
        values
    }

    /// The value of an entry.
    pub(super) fn value(&self, entry: usize, monomials: &[f64]) -> Complex<f64> {
        self.rows.iter().zip(monomials).map(|(row, weight)| row[entry] * *weight).sum()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::matrices::trial::Numbers;

    #[test]
    fn monomials_are_the_products_of_their_factors_and_forms_their_polynomials() {
        let changes = vec![0.5, -2.0, 3.0];
        let monomials = Monomials::new(changes.clone());
        let all = [&monomials.first, &monomials.second, &monomials.third, &monomials.fourth];
        for (values, number) in all.into_iter().zip(1..) {
            let product = |factors: &Vec<usize>| factors.iter().map(|&k| changes[k]).product::<f64>();
            let expected: Vec<f64> = factors(3, number).iter().map(product).collect();
            assert_eq!(*values, expected, "{number}");
        }
        let mut numbers = Numbers(3);
        for (number, values, products) in [(1, all[0], all[1]), (2, all[1], all[3])] {
            let form = DMatrix::from_fn(values.len(), values.len(), |_, _| numbers.next());
            let vector = nalgebra::DVector::from_column_slice(values);
            let expected = vector.dot(&(&form * &vector));
            let found: f64 = Products::new(3, number).of_form(&form).iter().zip(products).map(|(a, b)| a * b).sum();
            assert!((found - expected).abs() < 1e-12 * (1.0 + expected.abs()), "{found} {expected}");
        }
    }
}
