//! What perturbation theory needs of a group of modes: vectors of first and second order, and the polynomials that its
//! eigenvalues are found from. The formulas are those of [`series`](super::series).

use nalgebra::{Complex, DMatrix};

use super::eigenbasis::{ComplexMatrix, Split};
use super::polynomial::Products;
use super::region::magnitude;
use crate::numerics::eigenvalues::Eigenvalue;

/// Eigenvalues of the origin, and what a unit of each coefficient changes in its basis.
pub(super) struct Changes {
    pub(super) eigenvalues: Vec<Eigenvalue>,
    pub(super) changes: Vec<Split>,
}

impl Changes {
    /// A row for each mode of the origin and a column for each of the group: what couples them over their distance, and zero
    /// within the group.
    fn over_gaps(&self, modes: &[usize], coupling: impl Fn(usize, usize) -> Complex<f64>) -> ComplexMatrix {
        ComplexMatrix::from_fn(self.eigenvalues.len(), modes.len(), |other, j| {
            if modes.contains(&other) {
                return Complex::from(0.0);
            }
            coupling(other, j) / (self.eigenvalues[modes[j]] - self.eigenvalues[other])
        })
    }
}

/// The vectors of first order of a group of modes for each coefficient: `X_k` by columns, `Y_k` transposed by columns, with
/// a row for each mode of the origin, zero for those of the group.
pub(super) struct FirstOrder<'a> {
    all: &'a Changes,
    modes: &'a [usize],
    right: Vec<ComplexMatrix>,
    left: Vec<ComplexMatrix>,
}

impl<'a> FirstOrder<'a> {
    pub(super) fn new(all: &'a Changes, modes: &'a [usize]) -> Self {
        let right =
            all.changes.iter().map(|change| all.over_gaps(modes, |other, j| change.entry(other, modes[j]))).collect();
        let left =
            all.changes.iter().map(|change| all.over_gaps(modes, |other, j| change.entry(modes[j], other))).collect();
        Self { all, modes, right, left }
    }

    /// Entries of the group in a change.
    pub(super) fn own(&self, k: usize) -> ComplexMatrix {
        let own = self.modes.len();
        ComplexMatrix::from_fn(own, own, |i, j| self.all.changes[k].entry(self.modes[i], self.modes[j]))
    }

    /// What two coefficients do together to P: `E_cr X + Y E_rc + Y lambda_r X`, where `E_cr = Y (lambda_c - lambda_r)`.
    pub(super) fn second(&self, k: usize, l: usize) -> ComplexMatrix {
        let (x, y) = (&self.right[l], &self.left[k]);
        let own = self.modes.len();
        ComplexMatrix::from_fn(own, own, |i, j| {
            let (to, from) = (self.all.eigenvalues[self.modes[i]], self.all.eigenvalues[self.modes[j]]);
            let terms = (0..x.nrows()).map(|r| y[(r, i)] * x[(r, j)] * (to + from - self.all.eigenvalues[r]));
            terms.fold(Complex::from(0.0), |sum, term| sum + term)
        })
    }

    /// What two coefficients do together to N: `Y X`.
    pub(super) fn norm(&self, k: usize, l: usize) -> ComplexMatrix {
        self.left[k].tr_mul(&self.right[l])
    }
}

/// The vectors of a group from one side, a matrix for each monomial.
pub(super) struct Vectors {
    pub(super) first: Vec<ComplexMatrix>,
    pub(super) second: Vec<ComplexMatrix>,
    /// Their squared norms as polynomials of the products of two and of four changes. Each row is weighted by its distance
    /// from the group.
    pub(super) squares: [Vec<f64>; 2],
}

/// The vectors of second order, and what three coefficients do together.
pub(super) struct SecondOrder {
    /// `Y E X` for three coefficients in this order.
    third: Vec<ComplexMatrix>,
    count: usize,
    right: Vec<ComplexMatrix>,
    left: Vec<ComplexMatrix>,
}

impl SecondOrder {
    pub(super) fn new(first: &FirstOrder<'_>) -> Self {
        let count = first.right.len();
        let (mut right, mut left) = (Vec::new(), Vec::new());
        let mut third = Vec::with_capacity(count * count * count);
        let first_right: Vec<Split> = first.right.iter().map(Split::new).collect();
        let first_left: Vec<Split> = first.left.iter().map(|y| Split::new(&y.transpose())).collect();
        // Products with each change.
        let moved: Vec<Vec<ComplexMatrix>> =
            first.all.changes.iter().map(|change| first_right.iter().map(|x| change.times(x)).collect()).collect();
        for k in 0..count {
            for moved in &moved {
                third.extend(moved.iter().map(|moved| first.left[k].tr_mul(moved)));
            }
        }
        for k in 0..count {
            for l in k..count {
                let of = |k: usize, l: usize| {
                    let x = &moved[k][l] - &first.right[l] * first.own(k);
                    let y = first_left[l].times(&first.all.changes[k]).transpose()
                        - &first.left[l] * first.own(k).transpose();
                    (x, y)
                };
                let (mut x, mut y) = of(k, l);
                if k != l {
                    let (more_x, more_y) = of(l, k);
                    x += more_x;
                    y += more_y;
                }
                right.push(first.all.over_gaps(first.modes, |other, j| x[(other, j)]));
                left.push(first.all.over_gaps(first.modes, |other, j| y[(other, j)]));
            }
        }
        Self { third, count, right, left }
    }

    /// The vectors of both orders, from the right and from the left.
    pub(super) fn vectors(self, first: FirstOrder<'_>, products: &[Products; 2]) -> [Vectors; 2] {
        let squares = |of: [&[ComplexMatrix]; 2]| [0, 1].map(|order| products[order].of_form(&first.gram(of[order])));
        let [right, left] = [squares([&first.right, &self.right]), squares([&first.left, &self.left])];
        [
            Vectors { first: first.right, second: self.right, squares: right },
            Vectors { first: first.left, second: self.left, squares: left },
        ]
    }

    /// What three coefficients do together to P, in this order.
    pub(super) fn third(&self, k: usize, l: usize, m: usize) -> &ComplexMatrix {
        &self.third[(k * self.count + l) * self.count + m]
    }
}

impl FirstOrder<'_> {
    /// Products of vectors with each other, weighted by the largest distance of each row from the group.
    fn gram(&self, vectors: &[ComplexMatrix]) -> DMatrix<f64> {
        let eigenvalues = &self.all.eigenvalues;
        let weights: Vec<f64> = (0..eigenvalues.len())
            .map(|other| {
                let gaps = self.modes.iter().map(|&mode| eigenvalues[mode] - eigenvalues[other]);
                gaps.map(magnitude).fold(0.0, f64::max).sqrt()
            })
            .collect();
        let rows = 2 * weights.len() * self.modes.len();
        let mut weighted = DMatrix::zeros(rows, vectors.len());
        for (mut column, vector) in weighted.column_iter_mut().zip(vectors) {
            for (i, value) in vector.iter().enumerate() {
                let weight = weights[i % weights.len()];
                column[2 * i] = weight * value.re;
                column[2 * i + 1] = weight * value.im;
            }
        }
        weighted.tr_mul(&weighted)
    }
}
