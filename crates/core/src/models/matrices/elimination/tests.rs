use nalgebra::Complex;

use super::*;
use crate::models::matrices::region::{Region, magnitude};
use crate::models::matrices::trial::Numbers;

/// With polynomials and directly.
const WAYS: [fn(&Modes<'_>) -> Option<Terms>; 2] =
    [|modes| Some(Terms::Polynomials(Polynomials::new(modes))), |modes| Some(Terms::Direct(Direct::new(modes)))];

/// The exact matrix at places of a region, the other modes eliminated, is within the bounds, and near to them in some case for each
/// of the two terms.
#[test]
fn the_eliminated_matrix_is_within_its_bounds_and_these_are_not_wide() {
    is_within_bounds_that_are_not_wide(WAYS[0], 0.5);
    is_within_bounds_that_are_not_wide(WAYS[1], 0.45);
}

fn is_within_bounds_that_are_not_wide(terms: fn(&Modes<'_>) -> Option<Terms>, least: f64) {
    let region = Region { lowest: 1.0, highest: 2.0, damping_ratio: 0.0 };
    let (kept, all) = (3, 8);
    let mut numbers = Numbers(3);
    let mut number = move || Complex::new(numbers.next(), numbers.next());
    let mut largest = [0.0_f64; 3];
    for case in 0..300 {
        let eigenvalues: Vec<Eigenvalue> = (0..all)
            .map(|i| {
                let value = number();
                // Kept ones are near the band; of the others some are near its ends, and some are strongly damped or conjugate.
                if i < kept {
                    Complex::new(-0.2 + 0.2 * value.re, 1.5 + 0.6 * value.im)
                } else {
                    Complex::new(-0.8 + 0.1 * value.re, [2.8, 0.3, -1.5, 2.9, 1.5][i - kept] + 0.1 * value.im)
                }
            })
            .collect();
        let changes: Vec<ComplexMat> = (0..4).map(|_| Mat::from_fn(all, all, |_, _| number())).collect();
        // In the first cases nothing couples the others among themselves, so that the second bound is alone.
        let is_of_others = |i: usize, j: usize| i >= kept && j >= kept;
        let keep = |i: usize, j: usize| f64::from(u8::from(case >= 100 || !is_of_others(i, j)));
        let changes: Vec<ComplexMat> =
            changes.iter().map(|change| Mat::from_fn(all, all, |i, j| change[(i, j)] * keep(i, j))).collect();
        let distances: Vec<f64> = eigenvalues.iter().map(|value| region.distance(*value)).collect();
        let places = eigenvalues[..kept].iter().map(|value| Complex::new(0.0, value.im.clamp(1.0, 2.0))).collect();
        let elimination = Elimination::with(&eigenvalues, &distances, places, &changes, terms).unwrap();
        let parts = [number() * 0.09, number() * 0.09].map(|part| [part.re, part.im]);
        let parts = parts.as_flattened();
        let Some(bounded) = elimination.bounded(parts, |_| 0.0, |_| 0.0) else { continue };
        let change = |i: usize, j: usize| -> Complex<f64> {
            changes.iter().zip(parts).map(|(change, part)| change[(i, j)] * part).sum()
        };
        let others = all - kept;
        let unit = |i: usize, j: usize| Complex::from(f64::from(u8::from(i == j)));
        let weighted = Mat::from_fn(others, others, |r, q| {
            let root = |r: usize| region.distance(eigenvalues[kept + r]).sqrt();
            change(kept + r, kept + q) / (root(r) * root(q))
        });
        let norm = weighted.singular_values().unwrap()[0];
        let bound = elimination.norm(parts);
        assert!(norm <= bound * (1.0 + 1e-9), "{norm} {bound}");
        largest[2] = largest[2].max(norm / bound);
        let at_places = bounded.places.iter().copied();
        for z in at_places.chain((0..6).map(|k| Complex::new(0.1 * f64::from(k % 3), 1.0 + 0.2 * f64::from(k)))) {
            let block = Mat::from_fn(others, others, |r, q| {
                unit(r, q) * (z - eigenvalues[kept + q]) - change(kept + r, kept + q)
            });
            let inverse = faer::linalg::solvers::DenseSolveCore::inverse(&block.partial_piv_lu());
            let right = Mat::from_fn(others, kept, |r, j| change(kept + r, j));
            let left = Mat::from_fn(kept, others, |i, r| change(i, kept + r));
            let eliminated = &left * (&inverse * &right);
            for i in 0..kept {
                for j in 0..kept {
                    let exact = unit(i, j) * eigenvalues[i] + change(i, j) + eliminated[(i, j)];
                    let off = magnitude(exact - bounded.entries[i * kept + j]);
                    let away = (magnitude(z - bounded.places[i]) * bounded.slope[i]).min(bounded.most[i]);
                    let bound = (bounded.constant[i] + away) * bounded.columns[j];
                    assert!(off <= bound * (1.0 + 1e-9) + 1e-14, "{case} {i} {j}: {off} {bound}");
                    if bound > 1e-9 {
                        let place = if case < 100 { 0 } else { 1 };
                        largest[place] = largest[place].max(off / bound);
                    }
                }
            }
        }
    }
    assert!(largest.iter().all(|part| *part > least), "{largest:?}");
}

/// What is not a number, or so large that sums cancel, is no matrix, whether modes are kept or not.
#[test]
fn changes_that_are_no_numbers_or_too_large_are_left_open() {
    let eigenvalues = [Complex::new(-0.1, 1.0), Complex::new(-0.5, 4.0)];
    let changes = [1.0, -1.0].map(|sign| Mat::from_fn(2, 2, |_, _| Complex::from(sign)));
    for (kept, terms) in [(0, WAYS[0]), (1, WAYS[0]), (0, WAYS[1]), (1, WAYS[1])] {
        let places = eigenvalues[..kept].to_vec();
        let elimination = Elimination::with(&eigenvalues, &[0.1, 2.0], places, &changes, terms).unwrap();
        let is_open = |changes: [f64; 2]| elimination.bounded(&changes, |_| 0.0, |_| 0.0).is_none();
        assert!(!is_open([0.01, 0.02]));
        assert!(is_open([f64::NAN, 0.0]) && is_open([f64::INFINITY, 0.0]) && is_open([1e80, 1e80]), "{kept}");
    }
}

/// Rounding grows with what changes add, before the diagonal is added, and margins are those of the diagonal.
#[test]
fn rounding_and_margins_are_of_what_is_there() {
    let eigenvalues = [Complex::new(-0.1, 1.0), Complex::new(-0.5, 4.0)];
    let changes = [Mat::from_fn(2, 2, |i, j| Complex::new(0.0, if i + j == 0 { 3.0 } else { 0.0 }))];
    let elimination = Elimination::new(&eigenvalues, &[0.1, 2.0], vec![eigenvalues[0]], &changes).unwrap();
    let bounded = elimination.bounded(&[0.5], |value| 0.01 * value.im, |largest| 1e-9 * largest).unwrap();
    assert!((bounded.rounding - 1.5e-9).abs() < 1e-20 && (bounded.margins[0] - 0.025).abs() < 1e-12);
}

/// One mode that is eliminated, and a place far from s and as near to it as its distance: there the second bound is nearly what is
/// left out, and far above it the last one is.
#[test]
fn bounds_are_near_to_what_is_left_out_far_from_the_place_of_a_row() {
    let at = |frequency: f64| Complex::new(0.0, frequency);
    let (eigenvalues, place) = ([at(100.0), at(0.5)], at(100.0));
    let change = [[at(0.0), at(0.1)], [at(0.2), at(0.4)]];
    let changes = [Mat::from_fn(2, 2, |i, j| change[i][j])];
    let elimination = Elimination::new(&eigenvalues, &[0.0, 0.5], vec![place], &changes).unwrap();
    let bounded = elimination.bounded(&[1.0], |_| 0.0, |_| 0.0).unwrap();
    let near = at(1.0);
    let exact = eigenvalues[0] + change[0][1] * change[1][0] / (near - eigenvalues[1] - change[1][1]);
    let off = magnitude(exact - bounded.entries[0]);
    let away = magnitude(near - place) * bounded.slope[0];
    for bound in [bounded.constant[0] + away, bounded.most[0]].map(|row| row * bounded.columns[0]) {
        assert!(off <= bound && off > 0.95 * bound, "{off} {bound}");
    }
}

/// Both ways give the same matrix and the same norms but for that of rho; few changes take polynomials, many do not.
#[test]
fn polynomials_and_sums_agree() {
    let mut numbers = Numbers(11);
    let mut number = move || Complex::new(numbers.next(), numbers.next());
    let (kept, all) = (4, 9);
    let eigenvalues: Vec<Eigenvalue> =
        (0..all).map(|i| Complex::new(-0.1, 1.0 + 0.3 * f64::from(i)) + number()).collect();
    let changes: Vec<ComplexMat> = (0..3).map(|_| Mat::from_fn(all as usize, all as usize, |_, _| number())).collect();
    let places: Vec<Eigenvalue> = (0..kept).map(|i| Complex::new(0.0, 1.0 + 0.3 * f64::from(i))).collect();
    let distances: Vec<f64> = (0..all).map(|i| 0.5 + 0.1 * f64::from(i)).collect();
    let [one, other] = WAYS.map(|terms| {
        let elimination = Elimination::with(&eigenvalues, &distances, places.clone(), &changes, terms).unwrap();
        let changed = match &elimination.terms {
            Terms::Polynomials(terms) => terms.after(&[0.02, -0.03, 0.01]),
            Terms::Direct(terms) => terms.after(&[0.02, -0.03, 0.01]),
        };
        changed.unwrap()
    });
    let are_near = |a: &[f64], b: &[f64]| {
        assert!(a.len() == 4 && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-10 * b && *b > 0.0), "{a:?} {b:?}");
    };
    assert!(one.entries.iter().zip(&other.entries).all(|(a, b)| magnitude(a - b) < 1e-14) && one.entries.len() == 16);
    are_near(&one.rows, &other.rows);
    are_near(&one.columns, &other.columns);
    for place in 0..2 {
        are_near(&one.first[place], &other.first[place]);
        are_near(&one.second[place], &other.second[place]);
    }
    let is_direct = |count: usize| {
        let changes: Vec<ComplexMat> = changes.iter().cycle().take(count).cloned().collect();
        matches!(Elimination::new(&eigenvalues, &distances, places.clone(), &changes).unwrap().terms, Terms::Direct(_))
    };
    assert_eq!([1, 2, 24].map(is_direct), [false, false, true]);
}

/// A model of 300 coordinates: polynomials of few changes would take less time for a sample, but seconds to find.
#[test]
fn polynomials_that_take_too_long_to_find_are_left_out_and_sums_do_not_replace_them() {
    let (kept, all) = (60, 600);
    let eigenvalues: Vec<Eigenvalue> = (0..all).map(|i| Complex::new(-0.1, 1.0 + f64::from(i))).collect();
    let distances = vec![0.5; 600];
    let is_there = |count: usize| {
        let changes = vec![ComplexMat::zeros(600, 600); count];
        Elimination::new(&eigenvalues, &distances, eigenvalues[..kept].to_vec(), &changes).is_some()
    };
    assert!(!is_there(3) && is_there(1));
}
