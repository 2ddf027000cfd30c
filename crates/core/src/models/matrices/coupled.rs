//! A matrix in which modes that are coupled strongly are replaced by the modes that they make together.
//!
//! With the eigenvectors U of each such group as a block, `U^-1 F U` has no couplings within groups. The bounds of its entries follow
//! from those of F with the moduli of U and of its inverse.

use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use nalgebra::Complex;

use super::boundary::Bounded;
use super::region::magnitude;

/// Modes i and j are coupled strongly where `|F_ij F_ji|` is above this part of their squared distance.
const STRONG: f64 = 0.04;

/// Modes in a group at most.
const LARGEST_GROUP: usize = 16;

/// Sums of columns of U and of rows of its inverse up to which rounding is little.
const LARGEST_SUM: f64 = 1e3;

/// The same matrix with its groups; `None` if there are none.
pub(super) fn grouped(bounded: &Bounded) -> Option<Bounded> {
    let count = bounded.margins.len();
    let mut result = bounded.clone();
    let mut rounding = 0.0_f64;
    for modes in groups(bounded) {
        let block = Mat::from_fn(modes.len(), modes.len(), |i, j| bounded.entries[modes[i] * count + modes[j]]);
        let Ok(own) = block.eigen() else { continue };
        let vectors = own.U().to_owned();
        let inverse = vectors.partial_piv_lu().inverse();
        let sum = |values: &mut dyn Iterator<Item = &Complex<f64>>| values.map(|value| magnitude(*value)).sum::<f64>();
        let places = 0..modes.len();
        let sums = places.map(|i| sum(&mut inverse.row(i).iter()).max(sum(&mut vectors.col(i).iter())));
        let sums: Vec<f64> = sums.collect();
        if sums.iter().all(|sum| *sum <= LARGEST_SUM) {
            result.transform(&modes, &vectors, &inverse);
            let largest = sums.into_iter().fold(1.0, f64::max);
            rounding = rounding.max(bounded.rounding * largest * largest);
        }
    }
    result.rounding = rounding;
    (rounding > 0.0).then_some(result)
}

impl Bounded {
    /// Replaces some modes by those that have these vectors.
    fn transform(&mut self, modes: &[usize], vectors: &Mat<Complex<f64>>, inverse: &Mat<Complex<f64>>) {
        let count = self.margins.len();
        let size = modes.len();
        let sum = |matrix: &Mat<Complex<f64>>, to: usize, of: &[Complex<f64>]| -> Complex<f64> {
            of.iter().enumerate().map(|(from, value)| matrix[(to, from)] * value).sum()
        };
        for column in 0..count {
            let old: Vec<Complex<f64>> = modes.iter().map(|&mode| self.entries[mode * count + column]).collect();
            for (to, &mode) in modes.iter().enumerate() {
                self.entries[mode * count + column] = sum(inverse, to, &old);
            }
        }
        for row in 0..count {
            let old: Vec<Complex<f64>> = modes.iter().map(|&mode| self.entries[row * count + mode]).collect();
            for (to, &mode) in modes.iter().enumerate() {
                let terms = old.iter().enumerate().map(|(from, value)| value * vectors[(from, to)]);
                self.entries[row * count + mode] = terms.sum();
            }
        }
        let of_rows = |values: &dyn Fn(usize) -> f64, to: usize| -> f64 {
            (0..size).map(|from| magnitude(inverse[(to, from)]) * values(from)).sum()
        };
        let place = self.places[modes[0]];
        let of_modes = |values: &[f64]| modes.iter().map(|&mode| values[mode]).collect::<Vec<f64>>();
        let [constant, slope, most, columns] =
            [&self.constant, &self.slope, &self.most, &self.columns].map(|values| of_modes(values));
        let margin = modes.iter().map(|&mode| self.margins[mode]).fold(0.0, f64::max);
        let away: Vec<f64> = modes.iter().map(|&mode| magnitude(self.places[mode] - place)).collect();
        for (to, &mode) in modes.iter().enumerate() {
            // The errors of a row grow from one place for the whole group.
            self.constant[mode] = of_rows(&|from| constant[from] + away[from] * slope[from], to);
            self.slope[mode] = of_rows(&|from| slope[from], to);
            self.most[mode] = of_rows(&|from| most[from], to);
            self.columns[mode] = (0..size).map(|from| columns[from] * magnitude(vectors[(from, to)])).sum();
            self.places[mode] = place;
            self.margins[mode] = margin;
        }
    }
}

/// The groups of modes that are coupled strongly, each to another of the same group; those that are too large are left out.
fn groups(bounded: &Bounded) -> Vec<Vec<usize>> {
    let count = bounded.margins.len();
    let entry = |i: usize, j: usize| bounded.entries[i * count + j];
    let is_strong = |i: usize, j: usize| {
        let gap = (entry(i, i) - entry(j, j)).norm_sqr();
        (entry(i, j) * entry(j, i)).norm_sqr() > (STRONG * gap) * (STRONG * gap)
    };
    let mut is_taken = vec![false; count];
    let mut all = Vec::new();
    for first in 0..count {
        let mut group = Vec::new();
        let mut next = vec![first];
        while let Some(mode) = next.pop() {
            if !std::mem::replace(&mut is_taken[mode], true) {
                group.push(mode);
                next.extend((0..count).filter(|&other| !is_taken[other] && is_strong(mode, other)));
            }
        }
        if (2..=LARGEST_GROUP).contains(&group.len()) {
            all.push(group);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::boundary::tests::{Tally, tried, two};
    use super::super::decide::RegionSet;
    use super::super::region::Region;
    use super::*;

    fn told_by_groups(bounded: &Bounded, regions: &[Region]) -> Option<RegionSet> {
        grouped(bounded)?.regions(regions)
    }

    #[test]
    fn groups_tell_what_all_eigenvalues_do_whatever_the_errors() {
        for errors in [[0.0, 0.0], [0.01, 0.0], [0.0, 0.2], [0.01, 0.1]] {
            let Tally { told, wrong, needed } = tried(errors, 4000, told_by_groups);
            assert_eq!(wrong, 0, "{errors:?}");
            let with_errors = errors != [0.0, 0.0];
            assert!(told > 200 && (needed > 50 || !with_errors), "{errors:?}: {told} {needed}");
        }
    }

    /// Two modes that turn into their sum and difference, with errors that grow from different places: from the first for both, with what
    /// the second has there.
    #[test]
    fn errors_of_a_group_grow_from_one_place() {
        let entry = |re: f64, im: f64| Complex::new(re, im);
        let entries = [entry(-0.1, 1.5), entry(0.0, 0.02), entry(0.0, 0.02), entry(-0.1, 1.5)];
        let bounded = two(entries, [0.0, 0.5]);
        let together = grouped(&bounded).unwrap();
        let root = 0.5_f64.sqrt();
        for mode in 0..2 {
            let bounds = [together.constant[mode], together.slope[mode], together.most[mode], together.columns[mode]];
            let expected = [(0.5 + 0.1) * root, 1.25 * root, 6.0 * root, 4.0 * root];
            assert!(bounds.iter().zip(expected).all(|(bound, expected)| (bound - expected).abs() < 1e-9), "{bounds:?}");
            assert_eq!((together.places[mode], together.margins[mode]), (bounded.places[0], 2e-9));
        }
        assert!(together.rounding >= 1e-15);
    }

    /// Two modes that damping keeps stable, coupled by more than that: where they turn is what counts.
    #[test]
    fn modes_that_are_coupled_by_more_than_their_damping_are_told_together() {
        let pair = |coupling: f64| {
            let entry = |re: f64, im: f64| Complex::new(re, im);
            Bounded {
                entries: vec![entry(-0.01, 1.5), entry(0.0, coupling), entry(0.0, coupling), entry(-0.01, 1.5001)],
                margins: vec![1e-9; 2],
                rounding: 1e-15,
                constant: vec![1e-5; 2],
                slope: vec![1e-5; 2],
                most: vec![1e-5; 2],
                places: vec![Complex::new(0.0, 1.5); 2],
                columns: vec![1.0; 2],
            }
        };
        let regions = [Region { lowest: 1.0, highest: 2.0, damping_ratio: 0.0 }];
        assert_eq!(pair(0.02).regions(&regions), None);
        assert_eq!(told_by_groups(&pair(0.02), &regions), Some(0));
        assert!(grouped(&pair(1e-9)).is_none());
    }
}
