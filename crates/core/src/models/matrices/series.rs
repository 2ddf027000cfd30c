//! The eigenvalues near a region as the coefficients of a problem move away from an origin, by perturbation theory.
//!
//! In the basis of the origin the problem is `diag(lambda) + E` with `E = sum_k delta_k E_k`. Modes that changes couple
//! strongly are a group c; the rest r of the modes is eliminated from it by vectors of first order, from the right and
//! from the left,
//!
//! ```text
//! X = E_rc / (lambda_c - lambda_r),    Y = E_cr / (lambda_c - lambda_r)
//! P = lambda_c + E_cc + E_cr X + Y E_rc + Y (lambda_r + E_rr) X,    N = 1 + Y X
//! ```
//!
//! and the eigenvalues of `N^-1 P` are those of the group up to terms of fourth order (Wigner's 2 n + 1 rule; T. Kato,
//! Perturbation Theory for Linear Operators, chapter II). P and N are polynomials of the delta_k, found once. The leading
//! error, `Y2 (lambda_r - lambda_c) X2` with the vectors of second order, is bounded by their norms, which are known for
//! every delta, and what follows it by the ratio of the orders.
//!
//! Modes far from the region are not followed; how far changes may go before one comes near is measured
//! ([`far`](super::far)).

use nalgebra::{Complex, DMatrix, DVector, Schur};

use super::eigenbasis::{ComplexMatrix, Eigenbasis, Split, square_root};
use super::far::{Followed, SafeChanges};
use super::pair::Pair;
use super::perturbation::{Changes, FirstOrder, SecondOrder};
use super::quadratic::DenseQuadratic;
use super::region::{Region, magnitude};
use crate::numerics::eigenvalues::Eigenvalue;

/// Modes within this part of the highest frequency of a region from it are followed closely.
pub(super) const FOLLOWED: f64 = 0.15;

/// Coefficients change by this part to tell which modes they couple.
const TYPICAL_CHANGE: f64 = 0.1;

/// Mixing of two modes by typical changes from which on they are in one group.
const STRONG_COUPLING: f64 = 0.05;

/// The ratio of vectors of one order to that before it up to which the series is used.
const LARGEST_RATIO: f64 = 0.6;

/// What the bound of the error is multiplied by, for what it leaves out.
const SAFETY: f64 = 2.0;

/// A series serves for samples about other coefficients if so many times their distance is within its reach.
const REACH: f64 = 4.0;

/// Changing coefficients up to which there is a series: beyond, it costs more than it saves.
const MOST_COEFFICIENTS: usize = 24;

/// The modes near a region, followed from an origin.
pub(super) struct ModeSeries {
    origin: Vec<f64>,
    /// The coefficients that change.
    changing: Vec<usize>,
    groups: Vec<Group>,
    safe: Option<SafeChanges>,
    basis: Eigenbasis,
    /// The terms of P of first to third order, and those of N, which are of second order, for all groups.
    p: [Polynomial; 3],
    n: Polynomial,
}

/// Modes near the region that mix with each other and, less, with all others.
struct Group {
    modes: Vec<usize>,
    eigenvalues: Vec<Eigenvalue>,
    /// The place of its first entry.
    first: usize,
    /// Squared norms of the vectors, see [`SecondOrder::norms`].
    norms: [[DMatrix<f64>; 2]; 2],
}

/// Homogeneous polynomials of the changes: a row of values for each monomial.
struct Polynomial {
    width: usize,
    coefficients: Vec<Complex<f64>>,
}

impl Polynomial {
    const fn new() -> Self {
        Self { width: 0, coefficients: Vec::new() }
    }

    /// Adds entries with a value for each monomial.
    fn push(rows: &mut Vec<Vec<Complex<f64>>>, values: Vec<ComplexMatrix>) {
        if rows.is_empty() {
            rows.resize(values.len(), Vec::new());
        }
        rows.iter_mut().zip(values).for_each(|(row, value)| row.extend_from_slice(value.as_slice()));
    }

    fn of_rows(rows: &[Vec<Complex<f64>>]) -> Self {
        let width = rows.first().map_or(0, Vec::len);
        Self { width, coefficients: rows.concat() }
    }

    fn values(&self, monomials: &[f64]) -> Vec<Complex<f64>> {
        let mut values = vec![Complex::from(0.0); self.width];
        if self.width > 0 {
            for (row, weight) in self.coefficients.chunks_exact(self.width).zip(monomials) {
                for (value, coefficient) in values.iter_mut().zip(row) {
                    value.re += weight * coefficient.re;
                    value.im += weight * coefficient.im;
                }
            }
        }
        values
    }
}

impl ModeSeries {
    /// The series about an origin in the coefficients that change; `None` where there is no basis of eigenvectors, or no
    /// coefficient changes, or too many do.
    pub(super) fn new(
        problem: &DenseQuadratic,
        origin: &[f64],
        changing: &[usize],
        regions: &[Region],
    ) -> Option<Self> {
        if changing.is_empty() || changing.len() > MOST_COEFFICIENTS {
            return None;
        }
        let basis = Eigenbasis::new(&problem.at(origin))?;
        let changes = changing.iter().map(|&k| Split::new(&basis.change(problem, k))).collect();
        let all = Changes { eigenvalues: basis.eigenvalues.clone(), changes };
        let typical: Vec<f64> = changing.iter().map(|&k| TYPICAL_CHANGE * origin[k].abs()).collect();
        let distance = |mode: usize| {
            let of_region = |region: &Region| region.distance(all.eigenvalues[mode]);
            regions.iter().map(of_region).fold(f64::INFINITY, f64::min)
        };
        let distances: Vec<f64> = (0..all.eigenvalues.len()).map(distance).collect();
        let largest = all.eigenvalues.iter().map(|value| magnitude(*value)).fold(0.0, f64::max);
        let highest = regions.iter().map(|region| region.highest.min(largest)).fold(0.0, f64::max);
        let near: Vec<usize> = (0..distances.len()).filter(|&mode| distances[mode] <= FOLLOWED * highest).collect();
        let mut series = Self {
            origin: origin.to_vec(),
            changing: changing.to_vec(),
            groups: Vec::new(),
            safe: None,
            basis,
            p: [const { Polynomial::new() }; 3],
            n: Polynomial::new(),
        };
        let (mut p, mut n) = ([const { Vec::new() }; 3], Vec::new());
        for modes in groups(&near, &all, &typical) {
            series.add_group(modes, &all, &mut p, &mut n);
        }
        series.p = p.each_ref().map(|rows| Polynomial::of_rows(rows));
        series.n = Polynomial::of_rows(&n);
        let follow = |delta: &[f64]| series.eigenvalues(delta);
        let safe = SafeChanges::measured(problem, origin, changing, regions, FOLLOWED * highest, follow);
        Some(Self { safe: Some(safe), ..series })
    }

    fn add_group(
        &mut self,
        modes: Vec<usize>,
        all: &Changes,
        p: &mut [Vec<Vec<Complex<f64>>>; 3],
        n: &mut Vec<Vec<Complex<f64>>>,
    ) {
        let count = all.changes.len();
        let first = p[0].first().map_or(0, Vec::len);
        let first_order = FirstOrder::new(all, &modes);
        let second_order = SecondOrder::new(&first_order);
        Polynomial::push(&mut p[0], (0..count).map(|k| first_order.own(k)).collect());
        Polynomial::push(&mut p[1], pairs(count, |k, l| first_order.second(k, l)));
        Polynomial::push(n, pairs(count, |k, l| first_order.norm(k, l)));
        let mut third = Vec::new();
        for k in 0..count {
            for l in k..count {
                for m in l..count {
                    let mut orders = vec![[k, l, m], [k, m, l], [l, k, m], [l, m, k], [m, k, l], [m, l, k]];
                    orders.sort_unstable();
                    orders.dedup();
                    let terms = orders.iter().map(|&[a, b, c]| second_order.third(a, b, c));
                    third.push(terms.fold(ComplexMatrix::zeros(modes.len(), modes.len()), |sum, term| sum + term));
                }
            }
        }
        Polynomial::push(&mut p[2], third);
        let eigenvalues = modes.iter().map(|&mode| all.eigenvalues[mode]).collect();
        self.groups.push(Group { modes, eigenvalues, first, norms: second_order.norms });
    }

    /// The eigenvalues that may be in a region with these coefficients, each with its radius; `None` if the series does
    /// not say so much.
    pub(super) fn follow(&self, coefficients: &[f64]) -> Option<Vec<Followed>> {
        let delta: Vec<f64> = self.changing.iter().map(|&k| coefficients[k] - self.origin[k]).collect();
        self.safe.as_ref().is_some_and(|safe| safe.contain(&delta)).then(|| self.eigenvalues(&delta))?
    }

    /// The followed eigenvalues after these changes.
    fn eigenvalues(&self, delta: &[f64]) -> Option<Vec<Followed>> {
        let count = delta.len();
        let (mut second, mut third) = (Vec::with_capacity(count * count), Vec::with_capacity(count * count * count));
        for k in 0..count {
            for l in k..count {
                second.push(delta[k] * delta[l]);
                third.extend(delta[l..].iter().map(|last| delta[k] * delta[l] * last));
            }
        }
        let [first_order, second_order] = [self.p[0].values(delta), self.p[1].values(&second)];
        let (third_order, n) = (self.p[2].values(&third), self.n.values(&second));
        let mut followed = Vec::with_capacity(2 * self.groups.len());
        for (place, group) in self.groups.iter().enumerate() {
            let entries = group.first..group.first + group.modes.len() * group.modes.len();
            let sum = |i: usize| first_order[i] + second_order[i] + third_order[i];
            let p: Vec<Complex<f64>> = entries.clone().map(sum).collect();
            let radius = group.error(delta, &second);
            for (eigenvalue, radius) in group.eigenvalues(&p, &n[entries], radius)? {
                followed.push(Followed { eigenvalue, radius, group: place });
            }
        }
        Some(followed)
    }

    /// Whether the series serves well for samples about these coefficients.
    pub(super) fn reaches_beyond(&self, coefficients: &[f64]) -> bool {
        let changing = self.changing.iter().map(|&k| REACH * (coefficients[k] - self.origin[k])).collect::<Vec<_>>();
        let mut others = (0..coefficients.len()).filter(|k| !self.changing.contains(k));
        others.all(|k| coefficients[k] == self.origin[k])
            && self.safe.as_ref().is_some_and(|safe| safe.contain(&changing))
    }

    /// Where the refinement of a followed eigenvalue starts.
    pub(super) fn start(&self, followed: &Followed) -> Pair {
        let size = self.basis.right.nrows();
        let (mut right, mut left) = (vec![Complex::default(); size], vec![Complex::default(); size]);
        for &mode in &self.groups[followed.group].modes {
            right.iter_mut().zip(self.basis.right.column(mode).iter()).for_each(|(sum, value)| *sum += value);
            left.iter_mut().zip(self.basis.left.row(mode).iter()).for_each(|(sum, value)| *sum += value);
        }
        Pair { eigenvalue: followed.eigenvalue, right, left, error: followed.radius }
    }
}

/// The values of symmetric products of two changes.
fn pairs(count: usize, of: impl Fn(usize, usize) -> ComplexMatrix) -> Vec<ComplexMatrix> {
    let pairs = (0..count).flat_map(|k| (k..count).map(move |l| (k, l)));
    pairs.map(|(k, l)| if k == l { of(k, k) } else { of(k, l) + of(l, k) }).collect()
}

/// Groups modes that typical changes couple strongly.
fn groups(modes: &[usize], all: &Changes, typical: &[f64]) -> Vec<Vec<usize>> {
    let mixing = |i: usize, j: usize| {
        let coupled =
            |(change, typical): (&Split, &f64)| magnitude(change.entry(i, j) * change.entry(j, i)) * typical * typical;
        let coupled: f64 = all.changes.iter().zip(typical).map(coupled).sum();
        coupled.sqrt() > STRONG_COUPLING * magnitude(all.eigenvalues[i] - all.eigenvalues[j])
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for &mode in modes {
        let (joined, apart): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group| group.iter().any(|&other| mixing(mode, other)));
        groups = apart;
        groups.push(joined.into_iter().flatten().chain([mode]).collect());
    }
    groups
}

/// The root of a quadratic form.
fn norm(form: &DMatrix<f64>, values: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (column, value) in form.column_iter().zip(values) {
        sum += value * column.iter().zip(values).map(|(entry, value)| entry * value).sum::<f64>();
    }
    sum.max(0.0).sqrt()
}

impl Group {
    /// A bound of the error of P for these changes, given with their products; infinite where orders hardly fall.
    fn error(&self, delta: &[f64], second: &[f64]) -> f64 {
        let [right, left] = [0, 1].map(|side| [norm(&self.norms[side][0], delta), norm(&self.norms[side][1], second)]);
        let rest = |[first, second]: [f64; 2]| if second < LARGEST_RATIO * first { 1.0 - second / first } else { 0.0 };
        if right[1] == 0.0 || left[1] == 0.0 {
            return 0.0;
        }
        SAFETY * right[1] * left[1] / (rest(right) * rest(left))
    }

    /// The eigenvalues of `N^-1 P`, each with its radius if P has this error.
    fn eigenvalues(&self, p: &[Complex<f64>], n: &[Complex<f64>], error: f64) -> Option<Vec<(Eigenvalue, f64)>> {
        let own = self.modes.len();
        if let ([p], [n], [eigenvalue]) = (p, n, &self.eigenvalues[..]) {
            return Some(vec![((eigenvalue + p) / (Complex::from(1.0) + n), error)]);
        }
        let identity = ComplexMatrix::identity(own, own);
        let p = ComplexMatrix::from_diagonal(&DVector::from_column_slice(&self.eigenvalues))
            + ComplexMatrix::from_column_slice(own, own, p);
        let h = (&identity + ComplexMatrix::from_column_slice(own, own, n)).lu().solve(&p)?;
        let mean = h.trace() / Complex::from(own as f64);
        let centred = &h - identity * mean;
        let spread = centred.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
        let eigenvalues: Vec<Eigenvalue> = if own == 2 {
            let half = (h[(0, 0)] - h[(1, 1)]) * 0.5;
            let root = square_root(half * half + h[(0, 1)] * h[(1, 0)]);
            vec![mean + root, mean - root]
        } else {
            let (_, triangle) = Schur::try_new(centred, f64::EPSILON, 60 * own)?.unpack();
            triangle.diagonal().iter().map(|value| value + mean).collect()
        };
        // How far eigenvalues move: by the error times the condition of an isolated one, and at most by the root that
        // belongs to the size of the group (L. Elsner, Linear Algebra Appl. 71 (1985) 77).
        let most = root(error, own) * (2.0 * spread + error) / root(2.0 * spread + error, own);
        let radius = |i: usize| {
            let others = eigenvalues.iter().enumerate().filter(|(j, _)| *j != i);
            let isolation = others.map(|(_, other)| magnitude(eigenvalues[i] - other)).fold(f64::INFINITY, f64::min);
            let condition = (1..own).fold(1.0, |condition, _| condition * (1.0 + 2.0 * spread / isolation));
            let linear = 2.0 * error * condition;
            if linear < 0.25 * isolation { linear.min(most) } else { most }
        };
        Some((0..own).map(|i| (eigenvalues[i], if error == 0.0 { 0.0 } else { radius(i) })).collect())
    }
}

/// `value^(1/n)`.
fn root(value: f64, n: usize) -> f64 {
    if value > 0.0 && value.is_finite() { libm::exp(libm::log(value) / n as f64) } else { value }
}
