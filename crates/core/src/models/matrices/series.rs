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
//! These norms add what largely cancels, so the bound is often a thousand times the error. Where it does not decide, the
//! vectors themselves, of second order from both sides, give an eigenvalue with an error of sixth order: the root of
//! `y^T Q(lambda) x` with the matrices of the sample. How far that may be off is estimated by the largest of four quantities:
//! its distance from the eigenvalue of the series, the terms of second and of third order brought to the sixth by the ratio of
//! the vectors, and `Y (lambda_r - lambda_c) X (Y X)^2`. The last is the error of two modes that changes couple and move
//! alike: their vectors of second order vanish, and with them the other quantities. It is part of the bound too.
//!
//! Two groups that come near each other are a case of its own. What couples them may be little beside what couples each with
//! all others, and is not seen in these norms; but where they meet it decides. With the coupling c of two modes and the
//! distance g of their eigenvalues at the sample, these are off by some `c^2 / g`, and by no more than c. Of groups of n modes c^2 is
//! the product of the norms of both couplings, and what it does to P is larger by `(1 + 2 s / g)^(n - 1)` with the spread s of the
//! other group.
//!
//! Modes far from the region are not followed; how far changes may go before one comes near is measured
//! ([`far`](super::far)).

use std::ops::Range;

use nalgebra::Complex;

use super::eigenbasis::{ComplexMatrix, Eigenbasis, Split};
use super::far::{Followed, SafeChanges};
use super::group::{Group, Orders, SAFETY_OF_VECTORS};
use super::pair::{Pair, root_near};
use super::perturbation::{Changes, FirstOrder, SecondOrder};
use super::polynomial::{Monomials, Polynomial, Products};
use super::quadratic::{DenseQuadratic, Quadratic};
use super::region::{Region, magnitude};

/// Modes within this part of the highest frequency of a region from it are followed closely.
pub(super) const FOLLOWED: f64 = 0.15;

/// Coefficients change by this part to tell which modes they couple.
const TYPICAL_CHANGE: f64 = 0.1;

/// Mixing of two modes by typical changes from which on they are in one group.
const STRONG_COUPLING: f64 = 0.2;

/// Two groups are near each other if their distance is below this part of that at the origin.
const NEAR: f64 = 0.5;

/// What the error that their coupling makes is multiplied by.
const SAFETY_OF_COUPLING: f64 = 4.0;

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
    meetings: Vec<Meeting>,
    safe: Option<SafeChanges>,
    basis: Eigenbasis,
    /// The terms of P of first to third order, and those of N, which are of second order, for all groups.
    p: [Polynomial; 3],
    n: Polynomial,
    /// The squared norms of the vectors of first and of second order, an entry for each group: from the right the real part,
    /// from the left the imaginary one.
    squares: [Polynomial; 2],
}

/// Two groups that may come near each other.
struct Meeting {
    groups: [usize; 2],
    /// Where their eigenvalues are among all that are followed.
    followed: [Range<usize>; 2],
    /// The square of the distance below which they are near.
    near: f64,
}

impl ModeSeries {
    /// The series about an origin in the coefficients that change. It keeps vectors of second order if these have no more than
    /// as many numbers. `None` where there is no basis of eigenvectors, or no
    /// coefficient changes, or too many do.
    pub(super) fn new(
        problem: &DenseQuadratic,
        origin: &[f64],
        changing: &[usize],
        regions: &[Region],
        most_numbers: usize,
    ) -> Option<Self> {
        if changing.is_empty() || changing.len() > MOST_COEFFICIENTS {
            return None;
        }
        let here = problem.at(origin);
        let basis = Eigenbasis::new(&here)?;
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
        // What is zero whatever the coefficients is never unstable, but by rounding.
        let zeros = here.known_zeros(&all.eigenvalues);
        let is_near = |mode: &usize| distances[*mode] <= FOLLOWED * highest && !zeros.contains(mode);
        let near: Vec<usize> = (0..distances.len()).filter(is_near).collect();
        let monomials = changing.len() * (changing.len() + 3) / 2;
        let keeps_vectors = near.len() * 2 * all.eigenvalues.len() * monomials <= most_numbers;
        let products = [1, 2].map(|number| Products::new(changing.len(), number));
        let mut series = Self {
            origin: origin.to_vec(),
            changing: changing.to_vec(),
            groups: Vec::new(),
            meetings: Vec::new(),
            safe: None,
            basis,
            p: Default::default(),
            n: Polynomial::default(),
            squares: Default::default(),
        };
        let groups = groups(&near, &all, &typical);
        let followed = groups.concat();
        groups.into_iter().for_each(|modes| series.add_group(modes, &all, &products, &followed, keeps_vectors));
        series.meetings = meetings(&series.groups);
        let follow = |delta: &[f64]| series.eigenvalues(&Monomials::new(delta.to_vec()));
        let safe = SafeChanges::measured(problem, origin, changing, regions, FOLLOWED * highest, follow);
        Some(Self { safe: Some(safe), ..series })
    }

    fn add_group(
        &mut self,
        modes: Vec<usize>,
        all: &Changes,
        products: &[Products; 2],
        followed: &[usize],
        keeps_vectors: bool,
    ) {
        let count = all.changes.len();
        let first = self.p[0].width();
        let first_order = FirstOrder::new(all, &modes);
        let second_order = SecondOrder::new(&first_order);
        self.p[0].push(&(0..count).map(|k| first_order.own(k)).collect::<Vec<_>>());
        self.p[1].push(&pairs(count, |k, l| first_order.second(k, l)));
        self.n.push(&pairs(count, |k, l| first_order.norm(k, l)));
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
        self.p[2].push(&third);
        let eigenvalues = modes.iter().map(|&mode| all.eigenvalues[mode]).collect();
        let vectors = second_order.vectors(first_order, products);
        for (order, polynomial) in self.squares.iter_mut().enumerate() {
            let both = vectors[0].squares[order].iter().zip(&vectors[1].squares[order]);
            let values = both.map(|(right, left)| ComplexMatrix::from_element(1, 1, Complex::new(*right, *left)));
            polynomial.push(&values.collect::<Vec<_>>());
        }
        self.groups.push(Group::new(modes, eigenvalues, first, &vectors, followed, keeps_vectors));
    }

    /// The eigenvalues that may be in a region with these coefficients, each with its radius; `None` if the series does
    /// not say so much.
    pub(super) fn follow(&self, coefficients: &[f64]) -> Option<(Monomials, Vec<Followed>)> {
        let changes: Vec<f64> = self.changing.iter().map(|&k| coefficients[k] - self.origin[k]).collect();
        if !self.safe.as_ref()?.contain(&changes) {
            return None;
        }
        let monomials = Monomials::new(changes);
        let followed = self.eigenvalues(&monomials)?;
        Some((monomials, followed))
    }

    /// The followed eigenvalues after these changes.
    fn eigenvalues(&self, monomials: &Monomials) -> Option<Vec<Followed>> {
        let orders = self.orders(monomials, 0..self.n.width());
        let squares = self.squares(monomials);
        let mut followed = Vec::with_capacity(2 * self.groups.len());
        let mut spreads = Vec::with_capacity(self.groups.len());
        for (place, group) in self.groups.iter().enumerate() {
            let [p @ .., n] = orders.each_ref().map(|values| &values[group.entries.clone()]);
            let squares = squares.each_ref().map(|values| values[place]);
            spreads.push(group.follow(place, &Orders { p, n }, squares, &mut followed)?);
        }
        self.meetings.iter().for_each(|meeting| self.meet(meeting, &spreads, monomials, &mut followed));
        followed
            .chunk_by_mut(|a, b| a.group == b.group)
            .zip(spreads)
            .for_each(|(own, spread)| Group::bound(own, spread));
        Some(followed)
    }

    /// Adds the error of P that the coupling of two groups makes where these are near each other. `spreads` are the norms of the groups
    /// less their mean eigenvalues.
    fn meet(&self, meeting: &Meeting, spreads: &[f64], monomials: &Monomials, followed: &mut [Followed]) {
        let [of_one, of_other] = meeting.followed.clone();
        let between = |i: usize| {
            let squares =
                followed[of_other.clone()].iter().map(|mode| (mode.eigenvalue - followed[i].eigenvalue).norm_sqr());
            squares.fold(f64::INFINITY, f64::min)
        };
        let square = of_one.clone().map(between).fold(f64::INFINITY, f64::min);
        if square >= meeting.near {
            return;
        }
        let [one, other] = meeting.groups.map(|group| &self.groups[group]);
        let coupling =
            one.coupling(other, of_other.clone(), monomials).max(other.coupling(one, of_one.clone(), monomials));
        if coupling == 0.0 {
            return;
        }
        let distance = square.sqrt().max(coupling.sqrt());
        // The inverse of a group is the larger, the more its eigenvalues depend on each other (Henrici's bound).
        let [by_one, by_other] = meeting.groups.map(|group| {
            let others = 1..self.groups[group].eigenvalues().len();
            let inverse = others.fold(1.0 / distance, |inverse, _| inverse * (1.0 + 2.0 * spreads[group] / distance));
            SAFETY_OF_COUPLING * coupling * inverse
        });
        for (modes, error) in [(of_one, by_other), (of_other, by_one)] {
            for mode in &mut followed[modes] {
                mode.radius += error;
                mode.radius_of_vectors += error;
            }
        }
    }

    /// What changes add to P, by orders, and to N, for the entries in a range.
    fn orders(&self, monomials: &Monomials, entries: Range<usize>) -> [Vec<Complex<f64>>; 4] {
        let Monomials { first, second, third, .. } = monomials;
        let [p1, p2, p3] = self.p.each_ref();
        [(p1, first), (p2, second), (p3, third), (&self.n, second)]
            .map(|(polynomial, monomials)| polynomial.values(entries.clone(), monomials))
    }

    /// The squared norms of the vectors of the groups.
    fn squares(&self, monomials: &Monomials) -> [Vec<Complex<f64>>; 2] {
        let [first, second] = self.squares.each_ref();
        let groups = 0..self.groups.len();
        [first.values(groups.clone(), &monomials.second), second.values(groups, &monomials.fourth)]
    }

    /// The pair of a followed eigenvalue of the problem with these coefficients, from its vectors of second order.
    pub(super) fn pair(&self, problem: &Quadratic, monomials: &Monomials, followed: &Followed) -> Option<Pair> {
        let group = &self.groups[followed.group];
        let orders = || self.orders(monomials, group.entries.clone());
        let [right, left] = group.vectors(orders, followed.eigenvalue, monomials)?;
        let [right, left] = [self.basis.right.times_vector(&right), self.basis.left.transposed_times_vector(&left)];
        let (eigenvalue, slope) = root_near(followed.eigenvalue, problem.forms(&left, &right))?;
        let mut pair = problem.pair(eigenvalue, slope, right, &left);
        // The distance from what the series has is of a lower order than the error that is left.
        let distance = magnitude(eigenvalue - followed.eigenvalue);
        pair.error += followed.radius_of_vectors.max(SAFETY_OF_VECTORS * distance);
        Some(pair)
    }

    /// Whether the series serves well for samples about these coefficients.
    pub(super) fn reaches_beyond(&self, coefficients: &[f64]) -> bool {
        let changing = self.changing.iter().map(|&k| REACH * (coefficients[k] - self.origin[k])).collect::<Vec<_>>();
        let mut others = (0..coefficients.len()).filter(|k| !self.changing.contains(k));
        others.all(|k| coefficients[k] == self.origin[k])
            && self.safe.as_ref().is_some_and(|safe| safe.contain(&changing))
    }
}

/// All pairs of groups.
fn meetings(groups: &[Group]) -> Vec<Meeting> {
    let mut first = 0;
    let places = groups.iter().map(|group| {
        let own = first..first + group.eigenvalues().len();
        first = own.end;
        own
    });
    let places: Vec<Range<usize>> = places.collect();
    let pairs = (0..groups.len()).flat_map(|other| (0..other).map(move |one| [one, other]));
    let meeting = |pair: [usize; 2]| {
        let [one, other] = pair.map(|group| groups[group].eigenvalues());
        let distances = one.iter().flat_map(|a| other.iter().map(move |b| (a - b).norm_sqr()));
        let near = NEAR * NEAR * distances.fold(f64::INFINITY, f64::min);
        Meeting { groups: pair, followed: pair.map(|group| places[group].clone()), near }
    };
    pairs.map(meeting).collect()
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

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, dvector};

    use super::*;
    use crate::models::matrices::trial::{Numbers, close_modes};

    /// Two close modes that changes couple and move alike: vectors of second order vanish but for those of the conjugate
    /// modes, and the error is the term of the coupling alone.
    #[test]
    fn errors_hold_where_vectors_of_second_order_vanish() {
        for seed in 0..200 {
            let mut numbers = Numbers(seed);
            let gap = 0.005 + 0.02 * (1.0 + numbers.next());
            let problem = close_modes(gap, 3e-3);
            let region = Region { lowest: 0.3, highest: 3.0, damping_ratio: 0.0 }.in_unit(problem.unit());
            let series = ModeSeries::new(&problem, &[1.0, 1.0, 1e-3], &[2], &[region], 1 << 24).unwrap();
            for step in 1..25 {
                let friction = 0.02 * f64::from(step);
                let quadratic = problem.at(&[1.0, 1.0, friction]);
                let exact = quadratic.eigenvalues().unwrap();
                let off = |from| exact.iter().map(|value| magnitude(value - from)).fold(f64::INFINITY, f64::min);
                let monomials = Monomials::new(vec![friction - 1e-3]);
                for mode in series.eigenvalues(&monomials).unwrap() {
                    let by_series = off(mode.eigenvalue);
                    assert!(by_series <= mode.radius + 1e-11, "{seed} {friction} {mode:?} off by {by_series}");
                    let pair = series.pair(&quadratic, &monomials, &mode).unwrap();
                    let by_vectors = off(pair.eigenvalue);
                    assert!(by_vectors <= pair.error + 1e-11, "{seed} {friction} {pair:?} off by {by_vectors}");
                }
            }
        }
    }

    /// A mode that drives one of two others, which depend on each other, and is driven by the other one.
    #[test]
    fn errors_hold_where_a_mode_acts_on_itself_through_a_group() {
        let mut near = 0;
        for seed in 0..100 {
            let mut numbers = Numbers(seed);
            (0..5).for_each(|_| _ = numbers.next());
            let gap = 0.05 + 0.1 * (1.0 + numbers.next());
            let of_group = gap * libm::pow(10.0, -2.5 + 0.5 * numbers.next());
            let coupling = of_group * libm::pow(10.0, -1.5 + 0.5 * numbers.next());
            let strength = of_group * libm::pow(10.0, 1.0 + numbers.next());
            let origin = 1.0 + 0.2 * gap;
            let mut stiffness = DMatrix::from_diagonal(&dvector![0.0, 1.0 + gap, 1.0 + gap + of_group, 4.0]);
            let mut growing = DMatrix::zeros(4, 4);
            growing[(0, 0)] = 1.0;
            let slopes = [strength / gap, 8.0 * of_group * of_group * gap / strength];
            for ((i, j), slope) in [(1, 2), (2, 1)].into_iter().zip(slopes) {
                (growing[(i, j)], stiffness[(i, j)]) = (slope, -slope * origin);
            }
            (stiffness[(2, 0)], stiffness[(0, 1)]) = (coupling, coupling);
            let damping = DMatrix::from_diagonal(&dvector![1e-6, 0.3 * of_group, 0.3 * of_group, 0.1]);
            let problem =
                DenseQuadratic::new(&DMatrix::identity(4, 4), &[damping], &[stiffness, growing], &[1.0; 3]).unwrap();
            let region = Region { lowest: 0.3, highest: 1.5, damping_ratio: 0.0 }.in_unit(problem.unit());
            let series = ModeSeries::new(&problem, &[1.0, 1.0, origin], &[2], &[region], 1 << 24).unwrap();
            for step in -60..=60 {
                let part = f64::from(step) / 60.0;
                let growth = 1.0 + gap + 0.5 * of_group + 5.0 * of_group * part;
                let exact = problem.at(&[1.0, 1.0, growth]).eigenvalues().unwrap();
                let off = |from| exact.iter().map(|value| magnitude(value - from)).fold(f64::INFINITY, f64::min);
                for mode in series.eigenvalues(&Monomials::new(vec![growth - origin])).unwrap() {
                    let off = off(mode.eigenvalue);
                    assert!(off <= mode.radius + 1e-11, "{seed} {growth} {mode:?} off by {off}");
                    near += usize::from(10.0 * off > mode.radius);
                }
            }
        }
        assert!(near > 100, "{near}");
    }
}
