//! Samples near a place where all eigenvalues and vectors are known.
//!
//! In the basis of the centre the matrix of first order of a sample is `diag(lambda) + E` with `E = sum_k delta_k E_k`, exactly. Modes
//! near a region are kept (S); the others (R) keep a distance `g_r` from all regions. With the norm
//!
//! ```text
//! rho = |G|_2,    G_rq = E_rq / sqrt(g_r g_q)
//! ```
//!
//! below 1, `z - lambda_R - E_RR` is regular for every z in a region, so that none of the others is there, and z is an eigenvalue
//! just where this is singular:
//!
//! ```text
//! lambda_S + E_SS - z + E_SR (z - lambda_R - E_RR)^-1 E_RS
//! ```
//!
//! (the Schur complement). Its last term is taken as `Q_ij = sum_r E_ir E_rj / (s_i - lambda_r)` with a place s_i of a region near
//! lambda_i, a polynomial of second order in the changes. What that leaves out is bounded, with the norms `a_i = |E_ir / sqrt(g_r)|`,
//! `b_j = |E_rj / sqrt(g_r)|` and `n_i = |E_ir / (sqrt(g_r) (s_i - lambda_r))|`, by
//!
//! ```text
//! a_i b_j rho / (1 - rho) + min(|z - s_i| n_i, 2 a_i) b_j,
//! ```
//!
//! the first for what E_RR does (a geometric series), the second for z in place of s_i. With these bounds the regions that have an
//! eigenvalue are counted ([`boundary`](super::boundary)). Nothing here is an estimate but for rounding, for which distances are made
//! smaller. rho is bounded by the fourth root of `tr((G^H G)^2)`, a polynomial of fourth order.

use faer::Mat;
use nalgebra::{Complex, DMatrix};

use super::boundary::{Bounded, on_threshold};
use super::coupled::grouped;
use super::decide::{CLEAR, CLEAR_OF_NORM, RegionSet};
use super::fast_basis::{ComplexMat, FastBasis, TYPICAL_CHANGE};
use super::quadratic::DenseQuadratic;
use super::region::{Region, magnitude};
use crate::numerics::eigenvalues::Eigenvalue;

/// Modes within this part of the highest frequency of a region from it are kept.
const KEPT: f64 = 0.3;

/// Coefficients that change at most: beyond, a centre takes the time of many samples, which grows with their fourth power.
const MOST_CHANGES: usize = 8;

/// Products of two changes times the cube of the coordinates up to which a centre takes well below a second.
const MOST_WORK: usize = 1 << 27;

/// The rounding of a term of a sum, in parts of it, and more.
const ROUNDING: f64 = 1e-12;

/// Regions with thresholds of larger damping ratios are left to all eigenvalues.
const LARGEST_RATIO: f64 = 0.9;

/// A place in the space of coefficients.
pub(super) struct Centre {
    coefficients: Vec<f64>,
    /// The coefficients that change.
    changing: Vec<usize>,
    /// lambda_S.
    kept: Vec<Eigenvalue>,
    /// s.
    places: Vec<Eigenvalue>,
    /// What rounding makes of an entry.
    rounding: f64,
    /// What is left for that of all eigenvalues, beside a part of each.
    margin: f64,
    /// E_SS for each change and Q for each product of two, by rows; real and imaginary parts.
    entries: Vec<[Vec<f64>; 2]>,
    /// The squares of a, b and n as forms in the changes.
    squares: [Forms; 3],
    /// `tr((G^H G)^2)` as a form in the products of two changes.
    fourth: DMatrix<f64>,
    /// The sum of the squares of all couplings over distances, as a form in the changes.
    couplings: Vec<f64>,
}

/// Quadratic forms in changes: a row for each product of two, in the order of [`products`], an entry for each mode.
struct Forms(Vec<Vec<f64>>);

impl Forms {
    /// The squared norms of rows of sums of these matrices.
    fn new(matrices: &[ComplexMat]) -> Self {
        let of_pair = |(k, l): (usize, usize)| {
            let twice = if k == l { 1.0 } else { 2.0 };
            let (one, other) = (&matrices[k], &matrices[l]);
            let of_row = |i: usize| (0..one.ncols()).map(|r| inner(one[(i, r)], other[(i, r)])).sum::<f64>();
            (0..one.nrows()).map(|i| twice * of_row(i)).collect()
        };
        Self(pairs(matrices.len()).map(of_pair).collect())
    }

    fn norms(&self, products: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.0.first().map_or(0, Vec::len)];
        for (row, product) in self.0.iter().zip(products) {
            sums.iter_mut().zip(row).for_each(|(sum, entry)| *sum += with_rounding(product * entry));
        }
        sums.into_iter().map(|sum: f64| sum.max(0.0).sqrt()).collect()
    }
}

/// The places of the factors of products of two of so many changes.
fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |k| (k..count).map(move |l| (k, l)))
}

/// A term of a sum that cannot be negative, where it may cancel others: larger by more than the rounding of both.
fn with_rounding(term: f64) -> f64 {
    term + ROUNDING * term.abs()
}

/// `Re(a conj(b))`.
fn inner(a: Complex<f64>, b: Complex<f64>) -> f64 {
    a.re * b.re + a.im * b.im
}

fn products(changes: &[f64]) -> Vec<f64> {
    pairs(changes.len()).map(|(k, l)| changes[k] * changes[l]).collect()
}

impl Centre {
    /// A centre at these coefficients for the changes of some of them and regions above 0; `None` where there is no basis that is
    /// good enough.
    pub(super) fn new(
        problem: &DenseQuadratic,
        coefficients: &[f64],
        changing: &[usize],
        regions: &[Region],
    ) -> Option<Self> {
        let suits = |region: &Region| {
            region.lowest > 0.0 && region.lowest <= region.highest && region.damping_ratio.abs() < LARGEST_RATIO
        };
        let work = pairs(changing.len()).count() * problem.size() * problem.size() * problem.size();
        if changing.is_empty() || changing.len() > MOST_CHANGES || work > MOST_WORK || !regions.iter().all(suits) {
            return None;
        }
        Self::in_basis(FastBasis::new(problem, coefficients, changing)?, coefficients, changing, regions)
    }

    fn in_basis(basis: FastBasis, coefficients: &[f64], changing: &[usize], regions: &[Region]) -> Option<Self> {
        let FastBasis { eigenvalues, changes, norm, rounding } = basis;
        let distance =
            |value: &Eigenvalue| regions.iter().map(|region| region.distance(*value)).fold(f64::INFINITY, f64::min);
        let distances: Vec<f64> = eigenvalues.iter().map(distance).collect();
        let largest = eigenvalues.iter().map(|value| magnitude(*value)).fold(0.0, f64::max);
        let highest = regions.iter().map(|region| region.highest.min(largest)).fold(0.0, f64::max);
        let is_kept = |i: &usize| eigenvalues[*i].im > 0.0 && distances[*i] <= KEPT * highest;
        let (own, others): (Vec<usize>, Vec<usize>) = (0..eigenvalues.len()).partition(is_kept);
        if others.iter().any(|&r| distances[r] <= 0.0) {
            return None;
        }
        let roots: Vec<f64> = others.iter().map(|&r| distances[r].sqrt()).collect();
        let places: Vec<Eigenvalue> = own.iter().map(|&i| nearest(regions, eigenvalues[i])).collect();
        // A row for each kept mode and a column for each of the others: E_SR over the roots, the same over the gaps from s, and the
        // transpose of E_RS over the roots.
        let each = |entry: &dyn Fn(&ComplexMat, usize, usize) -> Complex<f64>| -> Vec<ComplexMat> {
            changes.iter().map(|change| Mat::from_fn(own.len(), others.len(), |i, r| entry(change, i, r))).collect()
        };
        let row = |change: &ComplexMat, i: usize, r: usize| change[(own[i], others[r])] / roots[r];
        let rows = each(&row);
        let slopes = each(&|change, i, r| row(change, i, r) / (places[i] - eigenvalues[others[r]]));
        let columns = each(&|change, j, r| change[(others[r], own[j])] / roots[r]);
        let lefts =
            each(&|change, i, r| row(change, i, r) * roots[r] * roots[r] / (places[i] - eigenvalues[others[r]]));
        let mut entries: Vec<[Vec<f64>; 2]> =
            changes.iter().map(|change| by_rows(own.len(), |i, j| change[(own[i], own[j])])).collect();
        for (k, l) in pairs(changes.len()) {
            let mut product = &lefts[k] * columns[l].transpose();
            if k != l {
                product += &lefts[l] * columns[k].transpose();
            }
            entries.push(by_rows(own.len(), |i, j| product[(i, j)]));
        }
        let weighted = |change: &ComplexMat| {
            let entry = |r: usize, q: usize| change[(others[r], others[q])] / (roots[r] * roots[q]);
            Mat::from_fn(others.len(), others.len(), entry)
        };
        Some(Self {
            couplings: coupling_forms(&changes, &eigenvalues, &distances),
            fourth: fourth_norms(&changes.iter().map(weighted).collect::<Vec<_>>()),
            squares: [rows, columns, slopes].map(|matrices| Forms::new(&matrices)),
            entries,
            rounding,
            margin: CLEAR_OF_NORM * norm,
            kept: own.iter().map(|&i| eigenvalues[i]).collect(),
            places,
            changing: changing.to_vec(),
            coefficients: coefficients.to_vec(),
        })
    }

    /// How many modes it keeps.
    pub(super) fn kept(&self) -> usize {
        self.kept.len()
    }

    /// How many numbers it has, nearly.
    pub(super) fn numbers(&self) -> usize {
        self.entries.iter().flatten().map(Vec::len).sum()
    }

    /// The changes from here to a sample; `None` if others change too.
    fn changes(&self, coefficients: &[f64]) -> Option<Vec<f64>> {
        let mut all: Vec<f64> = coefficients.iter().zip(&self.coefficients).map(|(to, from)| to - from).collect();
        let changes: Vec<f64> = self.changing.iter().map(|&k| std::mem::take(&mut all[k])).collect();
        all.iter().all(|change| *change == 0.0).then_some(changes)
    }

    /// How far a sample is, measured by what the changes couple; `None` if others change too.
    pub(super) fn distance(&self, coefficients: &[f64]) -> Option<f64> {
        let products = products(&self.changes(coefficients)?);
        Some(products.iter().zip(&self.couplings).map(|(product, entry)| product * entry).sum())
    }

    /// rho.
    fn norm(&self, products: &[f64]) -> f64 {
        let form: f64 = self
            .fourth
            .column_iter()
            .zip(products)
            .map(|(column, product)| {
                column.iter().zip(products).map(|(entry, other)| with_rounding(product * entry * other)).sum::<f64>()
            })
            .sum();
        form.max(0.0).sqrt().sqrt()
    }

    /// What typical changes of all coefficients make of rho at most.
    pub(super) fn typical_norm(&self) -> f64 {
        let of_change = |place: usize| {
            let mut changes = vec![0.0; self.changing.len()];
            changes[place] = TYPICAL_CHANGE * self.coefficients[self.changing[place]];
            self.norm(&products(&changes))
        };
        (0..self.changing.len()).map(of_change).sum()
    }

    /// The regions in which a sample has an unstable pair; `None` where that is not proved.
    pub(super) fn regions(&self, coefficients: &[f64], regions: &[Region]) -> Option<RegionSet> {
        let bounded = self.bounded(coefficients)?;
        bounded.regions(regions).or_else(|| grouped(&bounded)?.regions(regions))
    }

    /// The matrix whose eigenvalues in a region are those of a sample, within bounds; `None` where that is not proved.
    fn bounded(&self, coefficients: &[f64]) -> Option<Bounded> {
        let changes = self.changes(coefficients)?;
        let products = products(&changes);
        let norm = self.norm(&products);
        if norm.is_nan() || norm >= 1.0 {
            return None;
        }
        let size = self.kept.len();
        let [mut re, mut im] = [vec![0.0; size * size], vec![0.0; size * size]];
        for ([of_re, of_im], factor) in self.entries.iter().zip(changes.iter().chain(&products)) {
            re.iter_mut().zip(of_re).for_each(|(sum, entry)| *sum += factor * entry);
            im.iter_mut().zip(of_im).for_each(|(sum, entry)| *sum += factor * entry);
        }
        let mut entries: Vec<Complex<f64>> = re.into_iter().zip(im).map(|(re, im)| Complex::new(re, im)).collect();
        let diagonal = entries.iter_mut().step_by(size + 1).zip(&self.kept);
        diagonal.for_each(|(entry, eigenvalue)| *entry += eigenvalue);
        let [most, columns, slope] = [0, 1, 2].map(|place: usize| self.squares[place].norms(&products));
        let diagonal = entries.iter().step_by(size + 1);
        Some(Bounded {
            margins: diagonal.map(|value| CLEAR * magnitude(*value) + self.margin).collect(),
            rounding: self.rounding,
            entries,
            constant: most.iter().map(|row| row * norm / (1.0 - norm)).collect(),
            slope,
            most,
            places: self.places.clone(),
            columns,
        })
    }
}

/// The place of a region that is nearest to the frequency of an eigenvalue, on the line of its threshold.
fn nearest(regions: &[Region], eigenvalue: Eigenvalue) -> Eigenvalue {
    let places = regions.iter().map(|region| on_threshold(region, eigenvalue.im.clamp(region.lowest, region.highest)));
    let away = |place: &Eigenvalue| magnitude(place - eigenvalue);
    places.min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(eigenvalue)
}

fn by_rows(size: usize, entry: impl Fn(usize, usize) -> Complex<f64>) -> [Vec<f64>; 2] {
    let all = || (0..size).flat_map(|i| (0..size).map(move |j| (i, j)));
    [all().map(|(i, j)| entry(i, j).re).collect(), all().map(|(i, j)| entry(i, j).im).collect()]
}

/// The sum of the squares of all couplings over the distances of both modes, as a form in the changes: each mode's distance from
/// the regions with that from the other mode.
fn coupling_forms(changes: &[ComplexMat], eigenvalues: &[Eigenvalue], distances: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; pairs(changes.len()).count()];
    for (j, (one, distance)) in eigenvalues.iter().zip(distances).enumerate() {
        for (i, (other, other_distance)) in eigenvalues.iter().zip(distances).enumerate().filter(|(i, _)| *i != j) {
            let gap = (other - one).norm_sqr().sqrt();
            let weight = 1.0 / ((gap + distance) * (gap + other_distance)).max(f64::MIN_POSITIVE);
            for (sum, (k, l)) in sums.iter_mut().zip(pairs(changes.len())) {
                let twice = if k == l { 1.0 } else { 2.0 };
                *sum += twice * weight * inner(changes[k][(i, j)], changes[l][(i, j)]);
            }
        }
    }
    sums
}

/// `|G^H G|^2` of sums of these matrices as a form in the products of two factors.
fn fourth_norms(matrices: &[ComplexMat]) -> DMatrix<f64> {
    let squares: Vec<ComplexMat> = pairs(matrices.len())
        .map(|(k, l)| {
            let mut square = matrices[k].adjoint() * &matrices[l];
            if k != l {
                square += matrices[l].adjoint() * &matrices[k];
            }
            square
        })
        .collect();
    let of_pair = |a: &ComplexMat, b: &ComplexMat| -> f64 {
        let of_column = |j: usize| a.col(j).iter().zip(b.col(j).iter()).map(|(a, b)| inner(*a, *b)).sum::<f64>();
        (0..a.ncols()).map(of_column).sum()
    };
    DMatrix::from_fn(squares.len(), squares.len(), |p, q| of_pair(&squares[p], &squares[q]))
}

#[cfg(test)]
pub(super) mod tests;
