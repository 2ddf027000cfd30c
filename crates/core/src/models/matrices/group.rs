//! Modes near the region that mix with each other and, less, with all others.

use std::ops::Range;

use nalgebra::{Complex, DVector, Schur};

use super::eigenbasis::ComplexMatrix;
use super::far::Followed;
use super::perturbation::Vectors;
use super::polynomial::{Monomials, Polynomial};
use super::region::{magnitude, square_root};
use crate::numerics::eigenvalues::Eigenvalue;

/// The ratio of vectors of second order to those of first up to which they serve.
const LARGEST_RATIO: f64 = 0.6;

/// By how much the ratio of later orders may exceed that of the second to the first. Next to where two modes meet, it grows as
/// that of Catalan's numbers does.
const GROWTH_OF_RATIO: f64 = 2.5;

/// What the bound of the error of the series is multiplied by, for what it leaves out.
const SAFETY: f64 = 2.0;

/// The same for eigenvalues that come from the vectors.
pub(super) const SAFETY_OF_VECTORS: f64 = 4.0;

/// The least ratio of orders that errors of these are extrapolated with.
const LEAST_RATIO: f64 = 0.05;

/// Rounding of vectors.
const ROUNDING: f64 = 1e-12;

/// What changes add to P, by orders, and to N, which is of second order.
pub(super) struct Orders<'a> {
    pub(super) p: [&'a [Complex<f64>]; 3],
    pub(super) n: &'a [Complex<f64>],
}

impl Orders<'_> {
    fn sum(&self, entry: usize) -> Complex<f64> {
        self.p[0][entry] + self.p[1][entry] + self.p[2][entry]
    }
}

/// A group of modes.
pub(super) struct Group {
    modes: Vec<usize>,
    eigenvalues: Vec<Eigenvalue>,
    /// The places of its entries in the polynomials P and N of all groups.
    pub(super) entries: Range<usize>,
    /// Vectors from the right and from the left, of first and of second order: by columns, in the basis of the origin.
    sides: [[Polynomial; 2]; 2],
    /// Their rows of the followed modes alone, which are kept where those of second order are not.
    of_followed: [[Polynomial; 2]; 2],
}

impl Group {
    /// The group of these modes, whose entries begin there, of all that are followed.
    pub(super) fn new(
        modes: Vec<usize>,
        eigenvalues: Vec<Eigenvalue>,
        first: usize,
        vectors: &[Vectors; 2],
        followed: &[usize],
        keeps_vectors: bool,
    ) -> Self {
        let entries = first..first + modes.len() * modes.len();
        let rows = |order: &Vec<ComplexMatrix>| {
            Polynomial::new(&order.iter().map(|vectors| vectors.select_rows(followed)).collect::<Vec<_>>())
        };
        let of_followed = vectors.each_ref().map(|side| [&side.first, &side.second].map(rows));
        let none = Vec::new();
        let sides = vectors.each_ref().map(|side| {
            let second = if keeps_vectors { &side.second } else { &none };
            [&side.first, second].map(Polynomial::new)
        });
        Self { modes, eigenvalues, entries, sides, of_followed }
    }

    pub(super) fn eigenvalues(&self) -> &[Eigenvalue] {
        &self.eigenvalues
    }

    /// An upper estimate of the product of both couplings of this group with another, from the norms of what its vectors of first and of
    /// second order from either side have of the others. These stand at these places among all that are followed.
    pub(super) fn coupling(&self, other: &Self, places: Range<usize>, monomials: &Monomials) -> f64 {
        let followed = self.of_followed[0][0].width() / self.modes.len();
        let mut squares = [0.0; 2];
        for (column, own) in self.eigenvalues.iter().enumerate() {
            for (place, value) in places.clone().zip(&other.eigenvalues) {
                let entry = place + followed * column;
                let shares = self.of_followed.each_ref().map(|[first, second]| {
                    magnitude(first.value(entry, &monomials.first)) + magnitude(second.value(entry, &monomials.second))
                });
                let distance = (own - value).norm_sqr();
                squares.iter_mut().zip(shares).for_each(|(square, share)| *square += share * share * distance);
            }
        }
        squares.map(f64::sqrt).iter().product()
    }

    /// From the squared norms of the vectors of first and of second order, those from the right in the real parts: a bound of
    /// the error of P, infinite where orders hardly fall; and an estimate of that error which is left in
    /// eigenvalues that come from the vectors, by extrapolation of the second and the third order to the sixth.
    fn errors(&self, orders: &Orders<'_>, squares: [Complex<f64>; 2]) -> [f64; 2] {
        let root = |square: f64| square.max(0.0).sqrt();
        let [right, left] = [squares.map(|square| root(square.re)), squares.map(|square| root(square.im))];
        if right[0] == 0.0 || left[0] == 0.0 {
            return [0.0; 2];
        }
        let [of_right, of_left] = [right, left].map(|[first, second]| second / first);
        let ratio = of_right.max(of_left);
        let size = |values: &[Complex<f64>]| values.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
        // Where changes only couple two modes of one distance, the eigenvalue is a power series in N - 1, whose coefficients are
        // Catalan's numbers: it ends at 1/4, where the modes meet.
        let coupling = size(orders.n);
        if ratio >= LARGEST_RATIO || 4.0 * coupling >= 1.0 {
            return [f64::INFINITY; 2];
        }
        let of_coupling = right[0] * left[0] * coupling * coupling / (1.0 - 4.0 * coupling);
        let rest = |ratio: f64| (1.0 - GROWTH_OF_RATIO * ratio).max(0.0);
        let bound = SAFETY * (right[1] * left[1] / (rest(of_right) * rest(of_left)) + of_coupling);
        if self.sides[0][1].width() == 0 {
            return [bound; 2];
        }
        let ratio = ratio.max(LEAST_RATIO);
        let largest = self.eigenvalues.iter().map(|value| magnitude(*value)).fold(0.0, f64::max);
        let second = size(orders.p[1]) + largest * coupling;
        let extrapolated = (second * ratio).max(size(orders.p[2])) * ratio * ratio * ratio;
        [bound, bound.min(SAFETY_OF_VECTORS * extrapolated.max(of_coupling))]
    }

    /// The eigenvalues of `N^-1 P`, each with the error of P in place of its radius, from the squared norms of the vectors; and how far
    /// they spread.
    pub(super) fn follow(
        &self,
        place: usize,
        orders: &Orders<'_>,
        squares: [Complex<f64>; 2],
        followed: &mut Vec<Followed>,
    ) -> Option<f64> {
        let own = self.modes.len();
        let [radius, radius_of_vectors] = self.errors(orders, squares);
        let mut push = |eigenvalue| followed.push(Followed { eigenvalue, radius, radius_of_vectors, group: place });
        if let ([eigenvalue], [n]) = (&self.eigenvalues[..], orders.n) {
            push((eigenvalue + orders.sum(0)) / (Complex::from(1.0) + n));
            return Some(0.0);
        }
        let [p, n] = self.pencil(orders);
        let h = n.lu().solve(&p)?;
        let mean = h.trace() / Complex::from(own as f64);
        let centred = &h - ComplexMatrix::identity(own, own) * mean;
        let spread = centred.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
        if own == 2 {
            let half = (h[(0, 0)] - h[(1, 1)]) * 0.5;
            let root = square_root(half * half + h[(0, 1)] * h[(1, 0)]);
            push(mean + root);
            push(mean - root);
        } else {
            let (_, triangle) = Schur::try_new(centred, f64::EPSILON, 60 * own)?.unpack();
            triangle.diagonal().iter().for_each(|value| push(value + mean));
        }
        Some(spread)
    }

    /// Makes radii of the errors of P with the eigenvalues of a group that spread so far. That of a single mode is its error.
    pub(super) fn bound(followed: &mut [Followed], spread: f64) {
        if followed.len() == 1 {
            return;
        }
        let eigenvalues: Vec<Eigenvalue> = followed.iter().map(|mode| mode.eigenvalue).collect();
        for (i, mode) in followed.iter_mut().enumerate() {
            for error in [&mut mode.radius, &mut mode.radius_of_vectors] {
                *error = radius(&eigenvalues, i, spread, *error);
            }
        }
    }

    /// P and N as matrices, from what the changes add to those of the origin.
    fn pencil(&self, orders: &Orders<'_>) -> [ComplexMatrix; 2] {
        let own = self.modes.len();
        let p = ComplexMatrix::from_fn(own, own, |row, column| orders.sum(row + own * column));
        [
            ComplexMatrix::from_diagonal(&DVector::from_column_slice(&self.eigenvalues)) + p,
            ComplexMatrix::identity(own, own) + ComplexMatrix::from_column_slice(own, own, orders.n),
        ]
    }

    /// The right and the left vector of an eigenvalue, in the basis of the origin, with an error of third order.
    pub(super) fn vectors(
        &self,
        orders: impl FnOnce() -> [Vec<Complex<f64>>; 4],
        eigenvalue: Eigenvalue,
        monomials: &Monomials,
    ) -> Option<[DVector<Complex<f64>>; 2]> {
        let [right, left] = self.own_vectors(orders, eigenvalue)?;
        let vector = |side: &[Polynomial; 2], own: &DVector<Complex<f64>>| {
            let mut columns = vec![Complex::from(0.0); side[0].width()];
            let all = 0..columns.len();
            side[0].add_to(&mut columns, all.clone(), &monomials.first);
            side[1].add_to(&mut columns, all, &monomials.second);
            let count = columns.len() / self.modes.len();
            let mut vector = match self.modes.len() {
                1 => DVector::from_vec(columns),
                own_modes => ComplexMatrix::from_vec(count, own_modes, columns) * own,
            };
            self.modes.iter().zip(own.iter()).for_each(|(&mode, value)| vector[mode] += value);
            vector
        };
        Some([vector(&self.sides[0], &right), vector(&self.sides[1], &left)])
    }

    /// The vectors of an eigenvalue of the pencil `P - lambda N` from both sides, by inverse iteration; 1 of a single mode.
    fn own_vectors(
        &self,
        orders: impl FnOnce() -> [Vec<Complex<f64>>; 4],
        eigenvalue: Eigenvalue,
    ) -> Option<[DVector<Complex<f64>>; 2]> {
        let own = self.modes.len();
        let start = DVector::from_element(own, Complex::from(1.0));
        if own == 1 {
            return Some([start.clone(), start]);
        }
        let orders = orders();
        let [p @ .., n] = orders.each_ref().map(Vec::as_slice);
        let [p, n] = self.pencil(&Orders { p, n });
        // Not exactly at the eigenvalue, where the matrix is singular.
        let shifted = p - n * (eigenvalue * (1.0 + ROUNDING));
        let iterate = |matrix: ComplexMatrix| {
            let solver = matrix.lu();
            let mut vector = start.clone();
            for _ in 0..3 {
                vector = solver.solve(&vector)?.normalize();
            }
            vector.iter().all(|value| value.re.is_finite() && value.im.is_finite()).then_some(vector)
        };
        Some([iterate(shifted.clone())?, iterate(shifted.transpose())?])
    }
}

/// How far an eigenvalue of a group may move if P has an error: by the error times the condition of an isolated one, and at
/// most by the root that belongs to the size of the group (L. Elsner, Linear Algebra Appl. 71 (1985) 77).
fn radius(eigenvalues: &[Eigenvalue], i: usize, spread: f64, error: f64) -> f64 {
    if error == 0.0 || error.is_infinite() {
        return error;
    }
    let own = eigenvalues.len();
    let others = eigenvalues.iter().enumerate().filter(|(j, _)| *j != i);
    let isolation = others.map(|(_, other)| magnitude(eigenvalues[i] - other)).fold(f64::INFINITY, f64::min);
    let condition = (1..own).fold(1.0, |condition, _| condition * (1.0 + 2.0 * spread / isolation));
    let linear = 2.0 * error * condition;
    if linear < 0.25 * isolation {
        return linear;
    }
    root(error, own) * (2.0 * spread + error) / root(2.0 * spread + error, own)
}

/// `value^(1/n)`.
fn root(value: f64, n: usize) -> f64 {
    if value > 0.0 && value.is_finite() { libm::exp(libm::log(value) / n as f64) } else { value }
}
