//! A matrix in which modes near the boundary of a region are decoupled from all others.
//!
//! With the right eigenvector `e_i + x` of mode i, `(1 - x e_i^T) F (1 + x e_i^T)` has no entries beside the diagonal in column i, and with
//! the left one `e_i + y` of what that gives, `(1 + e_i y^T) F (1 - e_i y^T)` has none in row i. Both are similar to F whatever x and y
//! are, so that these need not be exact. The bounds of entries follow with the moduli of x and y.

use nalgebra::Complex;

use super::boundary::{Bounded, length};
use super::region::Region;
use crate::numerics::eigenvalues::Eigenvalue;

/// Modes are decoupled whose distance from a boundary is below so many times what couplings shift them by.
const NEAR: f64 = 3.0;

/// Modes that are decoupled at most.
const MOST_MODES: usize = 6;

/// Steps to a vector; weak couplings gain a digit in each.
const STEPS: usize = 8;

/// The sum of the moduli of the other entries of a vector at most.
const LARGEST_SUM: f64 = 10.0;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Right,
    Left,
}

/// The same matrix with modes near the boundaries decoupled; `None` if there are none.
pub(super) fn isolated(bounded: &Bounded, regions: &[Region]) -> Option<Bounded> {
    let count = bounded.margins.len();
    let entry = |i: usize, j: usize| bounded.entries[i * count + j];
    let shift = |i: usize| -> f64 {
        let of_mode = |j: usize| length(over(entry(i, j) * entry(j, i), entry(i, i) - entry(j, j)));
        (0..count).filter(|j| *j != i).map(of_mode).sum()
    };
    let part = |i: usize| (from_boundary(regions, entry(i, i)) / shift(i), i);
    let mut near: Vec<(f64, usize)> = (0..count).map(part).filter(|(part, _)| *part < NEAR).collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.truncate(MOST_MODES);
    let mut result = bounded.clone();
    for (_, mode) in &near {
        result.decouple(*mode, Side::Right);
        result.decouple(*mode, Side::Left);
    }
    (!near.is_empty()).then_some(result)
}

/// How far a mode is from the boundary of a region at least, nearly.
fn from_boundary(regions: &[Region], value: Eigenvalue) -> f64 {
    let of_region = |region: &Region| {
        let from_edges = (value.im - region.lowest).abs().min((region.highest - value.im).abs());
        match region.contains(value) {
            true => from_edges.min(value.re + value.im * region.damping_ratio),
            false => region.distance(value),
        }
    };
    regions.iter().map(of_region).fold(f64::INFINITY, f64::min)
}

impl Bounded {
    /// Takes the entries out of the column (or row) of a mode, where it has a right (or left) vector.
    fn decouple(&mut self, mode: usize, side: Side) {
        let count = self.margins.len();
        let at = |i: usize, j: usize| if side == Side::Right { i * count + j } else { j * count + i };
        let Some(vector) = vector(|i, j| self.entries[at(i, j)], count, mode) else { return };
        let sizes: Vec<f64> = vector.iter().map(|entry| length(*entry)).collect();
        let sum: f64 = sizes.iter().sum();
        let largest = self.entries.iter().map(|entry| length(*entry)).fold(0.0, f64::max);
        for k in 0..count {
            let added: Complex<f64> = (0..count).map(|j| self.entries[at(k, j)] * vector[j]).sum();
            self.entries[at(k, mode)] += added;
        }
        for k in (0..count).filter(|k| *k != mode) {
            for j in 0..count {
                let less = vector[k] * self.entries[at(mode, j)];
                self.entries[at(k, j)] -= less;
            }
        }
        // Errors come from row to row, where they grow from another place, and from column to column.
        for k in (0..count).filter(|k| *k != mode) {
            let (from, to) = if side == Side::Right { (mode, k) } else { (k, mode) };
            let away = length(self.places[from] - self.places[to]);
            self.constant[to] += sizes[k] * (self.constant[from] + away * self.slope[from]);
            self.slope[to] += sizes[k] * self.slope[from];
            self.most[to] += sizes[k] * self.most[from];
            self.columns[from] += sizes[k] * self.columns[to];
        }
        self.rounding = (self.rounding + count as f64 * f64::EPSILON * largest) * (1.0 + sum) * (1.0 + sum);
    }
}

/// A quotient, zero where there is nothing to divide.
fn over(part: Complex<f64>, of: Complex<f64>) -> Complex<f64> {
    if part == Complex::from(0.0) { part } else { part / of }
}

/// The other entries of the right eigenvector of a mode, where weak couplings give it.
fn vector(entry: impl Fn(usize, usize) -> Complex<f64>, count: usize, mode: usize) -> Option<Vec<Complex<f64>>> {
    let mut vector = vec![Complex::from(0.0); count];
    let mut eigenvalue = entry(mode, mode);
    for _ in 0..STEPS {
        let of_row = |k: usize| {
            let others = (0..count).filter(|j| *j != k).map(|j| entry(k, j) * vector[j]).sum::<Complex<f64>>();
            over(others + entry(k, mode), eigenvalue - entry(k, k))
        };
        let next = (0..count).map(|k| if k == mode { Complex::from(0.0) } else { of_row(k) }).collect();
        vector = next;
        eigenvalue = entry(mode, mode) + (0..count).map(|j| entry(mode, j) * vector[j]).sum::<Complex<f64>>();
    }
    (vector.iter().map(|entry| length(*entry)).sum::<f64>() <= LARGEST_SUM).then_some(vector)
}

#[cfg(test)]
mod tests {
    use super::super::boundary::tests::{Tally, tried, two};
    use super::*;

    fn entry(re: f64, im: f64) -> Complex<f64> {
        Complex::new(re, im)
    }

    /// Two modes, the first near the boundary.
    fn coupled(couplings: [Complex<f64>; 2]) -> Bounded {
        two([entry(-0.001, 1.5), couplings[0], couplings[1], entry(-0.2, 1.5)], [0.1, 0.5])
    }

    const REGIONS: [Region; 1] = [Region { lowest: 1.0, highest: 2.0, damping_ratio: 0.0 }];

    #[test]
    fn isolated_modes_tell_what_all_eigenvalues_do_whatever_the_errors() {
        for errors in [[0.0, 0.0], [0.01, 0.0], [0.0, 0.2], [0.01, 0.1]] {
            let tell = |bounded: &Bounded, regions: &[Region]| isolated(bounded, regions)?.regions(regions);
            let Tally { told, wrong, needed } = tried(errors, 6000, tell);
            assert_eq!(wrong, 0, "{errors:?}");
            let with_errors = errors != [0.0, 0.0];
            assert!(told > 200 && (needed > 50 || !with_errors), "{errors:?}: {told} {needed}");
        }
    }

    /// Each way alone: the eigenvalues stay, the entries go, and errors spread by the modulus of the vector.
    #[test]
    fn errors_spread_as_the_vectors_do() {
        let couplings = [entry(0.0, 0.03), entry(0.02, 0.0)];
        let before = coupled(couplings);
        // The vector of the first mode by the roots of the characteristic equation.
        let (sum, product) = (
            before.entries[0] + before.entries[3],
            before.entries[0] * before.entries[3] - couplings[0] * couplings[1],
        );
        let eigenvalue = sum * 0.5 + (sum * sum * 0.25 - product).sqrt();
        let of_right = (eigenvalue - before.entries[0]) / couplings[0];
        let of_left = (eigenvalue - before.entries[0]) / couplings[1];
        let [mut right, mut left] = [before.clone(), before.clone()];
        right.decouple(0, Side::Right);
        left.decouple(0, Side::Left);
        for (after, size, goes) in [(&right, length(of_right), 2), (&left, length(of_left), 1)] {
            assert!(length(after.entries[0] - eigenvalue) < 1e-10 && length(after.entries[goes]) < 1e-10);
            assert!(length(after.entries[3] - (sum - eigenvalue)) < 1e-10);
            assert!(length(after.entries[3 - goes] - before.entries[3 - goes]) < 1e-10);
            let least = 1e-15 * (1.0 + size) * (1.0 + size);
            assert!(after.rounding > least && after.rounding < 100.0 * least);
            assert_eq!((&after.margins, &after.places), (&before.margins, &before.places));
        }
        let is_near = |values: &[f64], expected: [f64; 2]| {
            assert!(values.iter().zip(expected).all(|(value, expected)| (value - expected).abs() < 1e-9), "{values:?}");
        };
        let size = length(of_right);
        is_near(&right.constant, [0.1, 0.5 + size * (0.1 + 0.1 * 0.25)]);
        is_near(&right.slope, [0.25, 1.0 + size * 0.25]);
        is_near(&right.most, [2.0, 4.0 + size * 2.0]);
        is_near(&right.columns, [1.0 + size * 3.0, 3.0]);
        let size = length(of_left);
        is_near(&left.constant, [0.1 + size * (0.5 + 0.1 * 1.0), 0.5]);
        is_near(&left.slope, [0.25 + size * 1.0, 1.0]);
        is_near(&left.most, [2.0 + size * 4.0, 4.0]);
        is_near(&left.columns, [1.0, 3.0 + size * 1.0]);
    }

    /// A mode that weak couplings to many others hold just off the boundary, or push across it.
    #[test]
    fn a_mode_that_many_others_shift_is_told() {
        let count = 12;
        let matrix = |damping: f64, sign: f64| {
            let coupling = |i: usize, j: usize| match (i, j) {
                (0, j) => entry(0.0, 0.003 * j as f64),
                (i, 0) => entry(0.0, 0.003 * sign * i as f64),
                _ => entry(0.0, 0.001),
            };
            let of_place = |place: usize| match (place / count, place % count) {
                (i, j) if i == j => entry(if i == 0 { -damping } else { -0.3 }, 1.4 + 0.02 * i as f64),
                (i, j) => coupling(i, j),
            };
            Bounded {
                entries: (0..count * count).map(of_place).collect(),
                margins: vec![1e-9; count],
                rounding: 1e-15,
                constant: vec![1e-6; count],
                slope: vec![1e-6; count],
                most: vec![1e-3; count],
                places: vec![entry(0.0, 1.5); count],
                columns: vec![1.0; count],
            }
        };
        for (damping, sign, expected) in [(0.001, 1.0, Some(0)), (-0.001, -1.0, Some(1)), (0.001, -1.0, Some(1))] {
            let bounded = matrix(damping, sign);
            assert_eq!(bounded.regions(&REGIONS), None, "{damping} {sign}");
            let isolated = isolated(&bounded, &REGIONS).unwrap();
            assert_eq!(isolated.regions(&REGIONS), expected, "{damping} {sign}");
        }
    }

    #[test]
    fn modes_far_from_boundaries_and_those_without_a_vector_stay() {
        let weak = coupled([entry(0.0, 1e-4), entry(0.0, 1e-4)]);
        assert!(isolated(&weak, &REGIONS).is_none());
        // Two modes at one place that nothing couples.
        let mut same = coupled([Complex::from(0.0); 2]);
        same.entries[3] = same.entries[0];
        same.decouple(0, Side::Right);
        assert!(same.rounding > 1e-15 && same.rounding < 1e-13 && isolated(&same, &REGIONS).is_none());
        let mut strong = coupled([entry(1e-3, 0.0), entry(30.0, 0.0)]);
        let before = strong.entries.clone();
        strong.decouple(0, Side::Right);
        assert_eq!(strong.entries, before);
        // At an edge, within a region and without one.
        for (value, expected) in [
            (entry(0.3, 1.1), 0.1),
            (entry(0.3, 1.9), 0.1),
            (entry(0.05, 1.5), 0.05),
            (entry(-0.2, 1.5), 0.2),
            (entry(0.3, 2.5), 0.5),
        ] {
            assert!((from_boundary(&REGIONS, value) - expected).abs() < 1e-6, "{value}");
        }
    }
}
