//! The matrix that remains of one of first order where some modes are eliminated, as a polynomial in changes, and what that leaves out.
//!
//! The matrix is `diag(lambda) + E` with `E = sum_k delta_k E_k`; modes S are kept, and the others R keep distances `g_r` from all places
//! z that are looked at. Where the norm
//!
//! ```text
//! rho = |G|_2,    G_rq = E_rq / sqrt(g_r g_q)
//! ```
//!
//! is below 1, `z - lambda_R - E_RR` is regular for all these z, and z is an eigenvalue just where this is singular (the Schur
//! complement):
//!
//! ```text
//! lambda_S + E_SS - z + E_SR (z - lambda_R - E_RR)^-1 E_RS
//! ```
//!
//! In its last term row i, e of E_SR, is taken at one place s and to third order:
//!
//! ```text
//! Y E_RS,    Y = y_0 + y_1,    y_0 = e (s - lambda_R)^-1,    y_1 = y_0 E_RR (s - lambda_R)^-1
//! ```
//!
//! As `e - Y (z - lambda_R - E_RR) = y_1 E_RR - (z - s) Y`, what that leaves out is exactly
//!
//! ```text
//! (y_1 E_RR - (z - s) Y) (z - lambda_R - E_RR)^-1 E_RS,
//! ```
//!
//! and, as all of the term and all of what is taken for it are bounded too, not more than the least of
//!
//! ```text
//! (|y_1 sqrt(g)| rho + |z - s| |Y / sqrt(g)|) b_j / (1 - rho),    (|e / sqrt(g)| / (1 - rho) + |Y sqrt(g)|) b_j
//! ```
//!
//! with `b_j = |E_rj / sqrt(g_r)|`. All these norms are forms in the changes; rho is bounded by the fourth root of `tr((G^H G)^2)`.

use std::collections::BTreeMap;

use faer::{Mat, MatRef};
use nalgebra::Complex;

use super::boundary::Bounded;
use super::fast_basis::ComplexMat;
use super::forms::{Forms, NormForm, pairs, products};
use crate::numerics::eigenvalues::Eigenvalue;

/// Modes that are kept and others that are eliminated.
pub(super) struct Elimination {
    /// lambda_S.
    kept: Vec<Eigenvalue>,
    /// s.
    places: Vec<Eigenvalue>,
    /// What each change, each product of two and each of three adds to the matrix, by rows; real and imaginary parts.
    terms: Vec<[Vec<f64>; 2]>,
    /// e over the roots of distances.
    rows: Forms,
    /// The same of the columns of E_RS.
    columns: Forms,
    /// y_0 times and over the roots.
    first: [Forms; 2],
    /// y_1 likewise, in products of two changes.
    second: [Forms; 2],
    norm: NormForm,
}

impl Elimination {
    /// Keeps the first modes, as many as there are places, which are at the distances from all that will be looked at. The distances
    /// of the others are above zero.
    pub(super) fn new(
        eigenvalues: &[Eigenvalue],
        distances: &[f64],
        places: Vec<Eigenvalue>,
        changes: &[ComplexMat],
    ) -> Self {
        let size = places.len();
        let others = &eigenvalues[size..];
        let roots: Vec<f64> = distances[size..].iter().map(|distance| distance.sqrt()).collect();
        let inverse_roots: Vec<f64> = roots.iter().map(|root| 1.0 / root).collect();
        let inverse_gaps = Mat::from_fn(size, others.len(), |i, r| 1.0 / (places[i] - others[r]));
        let over_gaps = |rows: MatRef<'_, Complex<f64>>| {
            Mat::from_fn(size, others.len(), |i, r| rows[(i, r)] * inverse_gaps[(i, r)])
        };
        let forms = |all: &[MatRef<'_, Complex<f64>>], factors: &[f64]| {
            let scaled =
                |rows: &MatRef<'_, Complex<f64>>| Mat::from_fn(size, others.len(), |i, r| rows[(i, r)] * factors[r]);
            Forms::new(&all.iter().map(scaled).collect::<Vec<_>>())
        };
        let count = changes.len();
        let rows = |k: usize| changes[k].as_ref().get(..size, size..);
        let columns = |k: usize| changes[k].as_ref().get(size.., ..size);
        let of_others = |k: usize| changes[k].as_ref().get(size.., size..);
        let first: Vec<ComplexMat> = (0..count).map(|k| over_gaps(rows(k))).collect();
        let sum_of_both = |(k, l): (usize, usize), product: &dyn Fn(usize, usize) -> ComplexMat| {
            if k == l { product(k, l) } else { product(k, l) + product(l, k) }
        };
        let second_of = |pair| over_gaps(sum_of_both(pair, &|k, l| &first[k] * of_others(l)).as_ref());
        let second: BTreeMap<(usize, usize), ComplexMat> = pairs(count).map(|pair| (pair, second_of(pair))).collect();
        let kept = (0..count).map(|k| changes[k].as_ref().get(..size, ..size).to_owned());
        let of_pairs = pairs(count).map(|pair| sum_of_both(pair, &|k, l| &first[k] * columns(l)));
        // Each of the different factors may be the last.
        let of_triple = |[k, l, m]: [usize; 3]| {
            let mut sum = &second[&(k, l)] * columns(m);
            if l != m {
                sum += &second[&(k, m)] * columns(l);
            }
            if k != l {
                sum += &second[&(l, m)] * columns(k);
            }
            sum
        };
        let all = kept.chain(of_pairs).chain(triples(count).map(of_triple));
        let weighted = |k: usize| {
            let block = of_others(k);
            let entry = |r: usize, q: usize| block[(r, q)] * (inverse_roots[r] * inverse_roots[q]);
            Mat::from_fn(others.len(), others.len(), entry)
        };
        let first_rows: Vec<_> = first.iter().map(Mat::as_ref).collect();
        let second_rows: Vec<_> = second.values().map(Mat::as_ref).collect();
        Self {
            terms: all.map(|term| by_rows(&term)).collect(),
            rows: forms(&(0..count).map(rows).collect::<Vec<_>>(), &inverse_roots),
            columns: forms(&(0..count).map(|k| columns(k).transpose()).collect::<Vec<_>>(), &inverse_roots),
            first: [&roots, &inverse_roots].map(|factors| forms(&first_rows, factors)),
            second: [&roots, &inverse_roots].map(|factors| forms(&second_rows, factors)),
            norm: NormForm::new(&(0..count).map(weighted).collect::<Vec<_>>()),
            kept: eigenvalues[..size].to_vec(),
            places,
        }
    }

    /// How many modes are kept.
    #[cfg(test)]
    pub(super) fn kept(&self) -> usize {
        self.kept.len()
    }

    /// How many numbers it has, nearly.
    pub(super) fn numbers(&self) -> usize {
        self.terms.iter().flatten().map(Vec::len).sum()
    }

    /// A bound of rho.
    pub(super) fn norm(&self, changes: &[f64]) -> f64 {
        self.norm.norm(&products(changes))
    }

    /// The matrix that remains after these changes, where rho is below 1. Distances are made smaller by `margin` of each entry of its
    /// diagonal, and `rounding` is that of each entry, by the largest one that changes add.
    pub(super) fn bounded(
        &self,
        changes: &[f64],
        margin: impl Fn(Eigenvalue) -> f64,
        rounding: impl Fn(f64) -> f64,
    ) -> Option<Bounded> {
        let of_two = products(changes);
        let norm = self.norm.norm(&of_two);
        if norm.is_nan() || norm >= 1.0 {
            return None;
        }
        let of_three = triples(changes.len()).map(|[k, l, m]| changes[k] * changes[l] * changes[m]);
        let factors = changes.iter().chain(&of_two).copied().chain(of_three);
        let size = self.kept.len();
        let [mut re, mut im] = [vec![0.0; size * size], vec![0.0; size * size]];
        for ([of_re, of_im], factor) in self.terms.iter().zip(factors) {
            re.iter_mut().zip(of_re).for_each(|(sum, entry)| *sum += factor * entry);
            im.iter_mut().zip(of_im).for_each(|(sum, entry)| *sum += factor * entry);
        }
        let mut entries: Vec<Complex<f64>> = re.into_iter().zip(im).map(|(re, im)| Complex::new(re, im)).collect();
        let largest = entries.iter().map(Complex::norm_sqr).fold(0.0, f64::max).sqrt();
        let diagonal = entries.iter_mut().step_by(size + 1).zip(&self.kept);
        diagonal.for_each(|(entry, eigenvalue)| *entry += eigenvalue);
        let diagonal = entries.iter().step_by(size + 1);
        let of_four = products(&of_two);
        let rest = 1.0 / (1.0 - norm);
        let [first_times, first_over] = [0, 1].map(|place: usize| self.first[place].norms(&of_two));
        let [second_times, second_over] = [0, 1].map(|place: usize| self.second[place].norms(&of_four));
        let rows = self.rows.norms(&of_two);
        Some(Bounded {
            margins: diagonal.map(|value| margin(*value)).collect(),
            rounding: rounding(largest),
            entries,
            constant: second_times.iter().map(|second| second * norm * rest).collect(),
            slope: first_over.iter().zip(&second_over).map(|(first, second)| (first + second) * rest).collect(),
            most: (0..size).map(|i| rows[i] * rest + first_times[i] + second_times[i]).collect(),
            places: self.places.clone(),
            columns: self.columns.norms(&of_two),
        })
    }
}

/// The places of the factors of products of three of so many.
fn triples(count: usize) -> impl Iterator<Item = [usize; 3]> {
    pairs(count).flat_map(move |(k, l)| (l..count).map(move |m| [k, l, m]))
}

/// The real and imaginary parts of entries by rows.
fn by_rows(matrix: &ComplexMat) -> [Vec<f64>; 2] {
    let [mut re, mut im] = [0, 1].map(|_| Vec::with_capacity(matrix.nrows() * matrix.ncols()));
    for i in 0..matrix.nrows() {
        for j in 0..matrix.ncols() {
            re.push(matrix[(i, j)].re);
            im.push(matrix[(i, j)].im);
        }
    }
    [re, im]
}

#[cfg(test)]
mod tests;
