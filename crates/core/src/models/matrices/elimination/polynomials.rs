//! The matrix that remains, and the norms of what is left out, as polynomials in the changes.
//!
//! Rho is bounded by the fourth root of `tr((G^H G)^2)`.

use std::collections::BTreeMap;

use faer::{Mat, MatRef};
use nalgebra::Complex;

use super::super::fast_basis::ComplexMat;
use super::super::forms::{Forms, NormForm, pairs, products};
use super::changed::{Changed, Modes, is_regular};

pub(super) struct Polynomials {
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

impl Polynomials {
    pub(super) fn new(modes: &Modes<'_>) -> Self {
        let Modes { changes, kept: size, roots, inverse_roots, inverse_gaps } = modes;
        let (size, others) = (*size, roots.len());
        let over_gaps =
            |rows: MatRef<'_, Complex<f64>>| Mat::from_fn(size, others, |i, r| rows[(i, r)] * inverse_gaps[(i, r)]);
        let forms = |all: &[MatRef<'_, Complex<f64>>], factors: &[f64]| {
            let scaled = |rows: &MatRef<'_, Complex<f64>>| Mat::from_fn(size, others, |i, r| rows[(i, r)] * factors[r]);
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
            Mat::from_fn(others, others, entry)
        };
        let first_rows: Vec<_> = first.iter().map(Mat::as_ref).collect();
        let second_rows: Vec<_> = second.values().map(Mat::as_ref).collect();
        Self {
            terms: all.map(|term| by_rows(&term)).collect(),
            rows: forms(&(0..count).map(rows).collect::<Vec<_>>(), inverse_roots),
            columns: forms(&(0..count).map(|k| columns(k).transpose()).collect::<Vec<_>>(), inverse_roots),
            first: [roots, inverse_roots].map(|factors| forms(&first_rows, factors)),
            second: [roots, inverse_roots].map(|factors| forms(&second_rows, factors)),
            norm: NormForm::new(&(0..count).map(weighted).collect::<Vec<_>>()),
        }
    }

    pub(super) fn numbers(&self) -> usize {
        self.terms.iter().flatten().map(Vec::len).sum()
    }

    pub(super) fn norm(&self, changes: &[f64]) -> f64 {
        self.norm.norm(&products(changes))
    }

    /// What changes make, where rho is below 1.
    pub(super) fn after(&self, changes: &[f64]) -> Option<Changed> {
        let of_two = products(changes);
        let norm = self.norm.norm(&of_two);
        if !is_regular(norm) {
            return None;
        }
        let of_three = triples(changes.len()).map(|[k, l, m]| changes[k] * changes[l] * changes[m]);
        let factors = changes.iter().chain(&of_two).copied().chain(of_three);
        let [mut re, mut im] =
            [0, 1].map(|part: usize| vec![0.0; self.terms.first().map_or(0, |term| term[part].len())]);
        for ([of_re, of_im], factor) in self.terms.iter().zip(factors) {
            re.iter_mut().zip(of_re).for_each(|(sum, entry)| *sum += factor * entry);
            im.iter_mut().zip(of_im).for_each(|(sum, entry)| *sum += factor * entry);
        }
        let of_four = products(&of_two);
        Some(Changed {
            entries: re.into_iter().zip(im).map(|(re, im)| Complex::new(re, im)).collect(),
            norm,
            rows: self.rows.norms(&of_two),
            columns: self.columns.norms(&of_two),
            first: [0, 1].map(|place: usize| self.first[place].norms(&of_two)),
            second: [0, 1].map(|place: usize| self.second[place].norms(&of_four)),
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
