//! Samples near a place where all eigenvalues and vectors are known.
//!
//! In the basis of the centre the matrix of first order of a sample is `diag(lambda) + E` with `E = sum_k delta_k E_k`, exactly. Modes
//! near a region are kept; the others keep a distance from all regions and are eliminated
//! ([`elimination`](super::elimination)). Of the matrix that remains the regions that have an eigenvalue are counted
//! ([`boundary`](super::boundary)). Nothing here is an estimate but for rounding, for which distances are made smaller.

use faer::Mat;

use super::boundary::on_threshold;
use super::coupled::grouped;
use super::decide::{CLEAR_OF_NORM, RegionSet};
use super::elimination::Elimination;
use super::fast_basis::{ComplexMat, FastBasis, TYPICAL_CHANGE};
use super::forms::{inner, pairs};
use super::isolated::isolated;
use super::quadratic::DenseQuadratic;
use super::region::{Region, magnitude};
use crate::numerics::eigenvalues::Eigenvalue;

/// Modes within this part of the highest frequency of a region from it are kept.
const KEPT: f64 = 0.3;

/// Numbers that all changes may have, 64 MiB: with more, a centre takes seconds.
const MOST_NUMBERS: usize = 1 << 23;

/// What is left for the rounding of an eigenvalue and of its damping ratio, in parts of it, beside that of the matrix.
const CLEAR: f64 = 1e-8;

/// Regions with thresholds of larger damping ratios are left to all eigenvalues.
const LARGEST_RATIO: f64 = 0.9;

/// A place in the space of coefficients.
pub(super) struct Centre {
    coefficients: Vec<f64>,
    /// Those that are looked at here: where a real eigenvalue is in one, it begins below 0, so that this is not at its edge.
    regions: Vec<Region>,
    /// The coefficients that change.
    changing: Vec<usize>,
    elimination: Elimination,
    /// What rounding makes of an entry, and the norm of the matrix.
    rounding: f64,
    norm: f64,
    /// The sum of the squares of all couplings over distances, as a form in the changes.
    couplings: Vec<f64>,
}

impl Centre {
    /// A centre at these coefficients for the changes of some of them; `None` where there is no basis that is good enough.
    pub(super) fn new(
        problem: &DenseQuadratic,
        coefficients: &[f64],
        changing: &[usize],
        regions: &[Region],
    ) -> Option<Self> {
        let suits = |region: &Region| region.lowest <= region.highest && region.damping_ratio.abs() < LARGEST_RATIO;
        let numbers = 8 * changing.len() * problem.size() * problem.size();
        if changing.is_empty() || numbers > MOST_NUMBERS || !regions.iter().all(suits) {
            return None;
        }
        Self::in_basis(FastBasis::new(problem, coefficients, changing)?, coefficients, changing, regions)
    }

    fn in_basis(basis: FastBasis, coefficients: &[f64], changing: &[usize], regions: &[Region]) -> Option<Self> {
        let FastBasis { eigenvalues, changes, norm, rounding } = basis;
        let regions = from_below(regions, &eigenvalues);
        let lowest = regions.iter().map(|region| region.lowest).fold(0.0, f64::min);
        let distance = |value: &Eigenvalue| {
            let all = regions.iter().map(|region| region.distance(*value));
            all.fold(f64::INFINITY, f64::min) - margin(*value, norm)
        };
        let distances: Vec<f64> = eigenvalues.iter().map(distance).collect();
        let largest = eigenvalues.iter().map(|value| magnitude(*value)).fold(0.0, f64::max);
        let highest = regions.iter().map(|region| region.highest.min(largest)).fold(0.0, f64::max);
        let is_kept = |i: &usize| eigenvalues[*i].im > lowest && distances[*i] <= KEPT * highest;
        let (mut order, others): (Vec<usize>, Vec<usize>) = (0..eigenvalues.len()).partition(is_kept);
        if others.iter().any(|&r| distances[r].is_nan() || distances[r] <= 0.0) {
            return None;
        }
        let places: Vec<Eigenvalue> = order.iter().map(|&i| nearest(&regions, eigenvalues[i])).collect();
        order.extend(others);
        let eigenvalues: Vec<Eigenvalue> = order.iter().map(|&i| eigenvalues[i]).collect();
        let distances: Vec<f64> = order.iter().map(|&i| distances[i].max(0.0)).collect();
        let ordered = |change: &ComplexMat| Mat::from_fn(order.len(), order.len(), |i, j| change[(order[i], order[j])]);
        let changes: Vec<ComplexMat> = changes.iter().map(ordered).collect();
        Some(Self {
            couplings: coupling_forms(&changes, &eigenvalues, &distances),
            elimination: Elimination::new(&eigenvalues, &distances, places, &changes)?,
            rounding,
            norm,
            regions,
            changing: changing.to_vec(),
            coefficients: coefficients.to_vec(),
        })
    }

    /// How many modes are kept.
    pub(super) fn kept(&self) -> usize {
        self.elimination.kept()
    }

    /// How many numbers it has, nearly.
    pub(super) fn numbers(&self) -> usize {
        self.elimination.numbers()
    }

    /// The changes from here to a sample; `None` if others change too.
    fn changes(&self, coefficients: &[f64]) -> Option<Vec<f64>> {
        let mut all: Vec<f64> = coefficients.iter().zip(&self.coefficients).map(|(to, from)| to - from).collect();
        let changes: Vec<f64> = self.changing.iter().map(|&k| std::mem::take(&mut all[k])).collect();
        all.iter().all(|change| *change == 0.0).then_some(changes)
    }

    /// How far a sample is, measured by what the changes couple; `None` if others change too.
    pub(super) fn distance(&self, coefficients: &[f64]) -> Option<f64> {
        let change = |k: usize| coefficients[k] - self.coefficients[k];
        let is_fixed = |k: &usize| !self.changing.contains(k);
        if (0..coefficients.len()).filter(is_fixed).any(|k| change(k) != 0.0) {
            return None;
        }
        let of_pair =
            |((k, l), entry): ((usize, usize), &f64)| change(self.changing[k]) * change(self.changing[l]) * entry;
        Some(pairs(self.changing.len()).zip(&self.couplings).map(of_pair).sum())
    }

    /// What typical changes of all coefficients make of rho at most.
    pub(super) fn typical_norm(&self) -> f64 {
        let of_change = |place: usize| {
            let mut changes = vec![0.0; self.changing.len()];
            changes[place] = TYPICAL_CHANGE * self.coefficients[self.changing[place]];
            self.elimination.norm(&changes)
        };
        (0..self.changing.len()).map(of_change).sum()
    }

    /// The regions in which a sample has an unstable pair; `None` where that is not proved.
    pub(super) fn regions(&self, coefficients: &[f64]) -> Option<RegionSet> {
        let margin = |value: Eigenvalue| margin(value, self.norm);
        let rounding = |largest: f64| self.rounding * (1.0 + largest / self.norm);
        let bounded = self.elimination.bounded(&self.changes(coefficients)?, margin, rounding)?;
        bounded.regions(&self.regions).or_else(|| {
            let grouped = grouped(&bounded);
            isolated(grouped.as_ref().unwrap_or(&bounded), &self.regions).or(grouped)?.regions(&self.regions)
        })
    }
}

/// The regions, of which those with a real eigenvalue begin at a frequency below 0 that no eigenvalue is near. What lies between that and
/// 0 has its conjugate in the region, so that there is an eigenvalue in the one just where there is one in the other.
fn from_below(regions: &[Region], eigenvalues: &[Eigenvalue]) -> Vec<Region> {
    let largest = eigenvalues.iter().map(|value| magnitude(*value)).fold(0.0, f64::max);
    let begin = |region: &Region| {
        let (real, complex): (Vec<_>, Vec<_>) = eigenvalues.iter().partition(|value| value.im == 0.0);
        if real.iter().all(|value| region.distance(*value) > 0.0) {
            return *region;
        }
        let away = complex.iter().map(|value| value.im.abs().max(region.distance(*value)));
        Region { lowest: -0.5 * away.fold(region.highest.min(largest), f64::min), ..*region }
    };
    regions.iter().map(begin).collect()
}

/// What is left for rounding of an eigenvalue.
fn margin(value: Eigenvalue, norm: f64) -> f64 {
    CLEAR * magnitude(value) + CLEAR_OF_NORM * norm
}

/// The place of a region that is nearest to the frequency of an eigenvalue, on the line of its threshold.
fn nearest(regions: &[Region], eigenvalue: Eigenvalue) -> Eigenvalue {
    let places = regions.iter().map(|region| on_threshold(region, eigenvalue.im.clamp(region.lowest, region.highest)));
    let away = |place: &Eigenvalue| magnitude(place - eigenvalue);
    places.min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(eigenvalue)
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

#[cfg(test)]
pub(super) mod tests;
