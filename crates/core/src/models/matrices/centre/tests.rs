use nalgebra::{Complex, DMatrix, DVector, dvector};

use super::*;
use crate::models::matrices::centres::Centres;
use crate::models::matrices::decide::Decider;
use crate::models::matrices::trial::{Numbers, close_modes, problem as small_problem};

/// A structure with damping, friction that couples its modes, and gyroscopic forces. Some modes are heavily damped. Coefficients are 1.
pub(in super::super) fn structure(seed: usize, size: usize) -> (DenseQuadratic, [Region; 2]) {
    let mut numbers = Numbers(seed as u64);
    (0..5).for_each(|_| {
        numbers.next();
    });
    let mut matrix = |size_of_entries: f64| DMatrix::from_fn(size, size, |_, _| size_of_entries * numbers.next());
    let place = |i: usize| 0.3 + 1.7 * (i as f64 + 0.5) / size as f64;
    let frequencies = DVector::from_fn(size, |i, _| place(i) * place(i));
    let mut ratios = matrix(0.02).column(0).map(f64::abs);
    if seed % 3 == 1 {
        (0..size).step_by(4).for_each(|i| ratios[i] = 0.7);
    }
    let own = DMatrix::from_diagonal(&frequencies);
    let damping = DMatrix::from_diagonal(&DVector::from_fn(size, |i, _| 2.0 * ratios[i] * frequencies[i].sqrt()));
    let stiffer = matrix(0.3);
    let lining = &own * 0.5 + &stiffer + stiffer.transpose();
    let spin = matrix(0.05);
    let terms = [damping, &spin - spin.transpose(), own - &lining * 0.5, lining * 0.5, matrix(0.1)];
    let problem = DenseQuadratic::new(&DMatrix::identity(size, size), &terms[..2], &terms[2..], &[1.0; 5]).unwrap();
    let damping_ratio = [0.0, 0.004, -0.002][seed / 3 % 3];
    let top = if seed.is_multiple_of(5) { f64::INFINITY } else { 1.3 };
    let bands = [[0.6, 0.9], [0.9, top]].map(|[lowest, highest]| Region { lowest, highest, damping_ratio });
    let bands = bands.map(|band| band.in_unit(problem.unit()));
    (problem, bands)
}

/// Of samples about a centre: how many there are, how many are told, and how many of those are unstable.
#[derive(Debug, Default)]
struct Tally {
    samples: usize,
    told: usize,
    unstable: usize,
}

fn tried(problem: &DenseQuadratic, origin: &[f64], regions: &[Region], scatter: &[f64], samples: usize) -> Tally {
    let mut tally = Tally::default();
    let changing: Vec<usize> = (0..origin.len()).filter(|&k| scatter[k] != 0.0).collect();
    let Some(centre) = Centre::new(problem, origin, &changing, regions) else { return tally };
    let mut numbers = Numbers(samples as u64);
    for _ in 0..samples {
        let coefficients: Vec<f64> =
            origin.iter().zip(scatter).map(|(value, part)| value * (1.0 + part * numbers.normal())).collect();
        tally.samples += 1;
        let Some(told) = centre.regions(&coefficients) else { continue };
        let truth = Decider::of_each(problem, regions).by_all(&coefficients);
        assert_eq!(Some(told), truth, "{coefficients:?}");
        tally.told += 1;
        tally.unstable += usize::from(told != 0);
    }
    tally
}

/// Structures of 4 to 24 coordinates with 1 to 5 changing coefficients and scatter from 0.2 to 10 %.
#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn what_a_centre_tells_is_what_all_eigenvalues_tell() {
    let mut sum = Tally::default();
    for seed in 0..240 {
        let (problem, regions) = structure(seed, 4 + seed % 21);
        let size_of_scatter = [0.002, 0.01, 0.03, 0.1][seed % 4];
        let scatter: Vec<f64> = (0..5).map(|k| if (seed >> k) % 2 == 0 { size_of_scatter } else { 0.0 }).collect();
        let Tally { samples, told, unstable } = tried(&problem, &[1.0; 5], &regions, &scatter, 60);
        sum = Tally { samples: sum.samples + samples, told: sum.told + told, unstable: sum.unstable + unstable };
    }
    assert!(sum.samples > 10_000 && sum.told > 4000 && sum.unstable > 800, "{sum:?}");
}

/// One mode is driven by another that is heavily damped, less so in the sample: with terms of third order it is stable, and it is not.
#[test]
fn what_is_beyond_third_order_is_left_open() {
    let coupling = 0.011_f64.sqrt();
    let change = [[0.0, coupling], [coupling, 0.5]];
    let basis = FastBasis {
        eigenvalues: vec![Complex::new(-0.02, 1.0), Complex::new(-1.0, 1.0)],
        changes: vec![Mat::from_fn(2, 2, |i, j| Complex::from(change[i][j]))],
        norm: 1.0,
        rounding: 1e-15,
    };
    let regions = [Region { lowest: 0.5, highest: 2.0, damping_ratio: 0.0 }];
    let centre = Centre::in_basis(basis, &[0.0], &[0], &regions).unwrap();
    assert_eq!(centre.regions(&[0.9]), Some(0));
    assert_eq!(centre.regions(&[1.0]), None);
}

/// A mode that is not kept, so near to a band that rounding may bring it there; farther away it does no harm.
#[test]
fn a_mode_that_rounding_may_bring_into_a_band_is_no_distance_away() {
    let basis = || FastBasis {
        eigenvalues: vec![Complex::new(-0.02, 1.0), Complex::new(-1e-12, 0.0)],
        changes: vec![Mat::from_fn(2, 2, |i, j| Complex::from(if i == 0 && j == 0 { 1.0 } else { 0.0 }))],
        norm: 1.0,
        rounding: 1e-15,
    };
    for (lowest, is_open) in [(5e-10, true), (2e-9, false)] {
        let regions = [Region { lowest, highest: 2.0, damping_ratio: 0.0 }];
        assert_eq!(Centre::in_basis(basis(), &[0.0], &[0], &regions).is_none(), is_open, "{lowest}");
    }
}

/// One mode moves far up, which leaves less of a decimal for the other one.
#[test]
fn rounding_of_large_changes_counts_for_all_modes() {
    let regions = [Region { lowest: 0.5, highest: 2.0, damping_ratio: 0.0 }];
    let told = |change: f64| {
        let basis = FastBasis {
            eigenvalues: vec![Complex::new(-0.01, 1.0), Complex::new(-0.01, 1.5)],
            changes: vec![Mat::from_fn(2, 2, |i, j| Complex::new(0.0, if i + j == 0 { 1.0 } else { 0.0 }))],
            norm: 1.0,
            rounding: 1e-3,
        };
        Centre::in_basis(basis, &[0.0], &[0], &regions).unwrap().regions(&[change])
    };
    assert_eq!((told(0.2), told(20.0)), (Some(0), None));
}

/// Problems with strong damping of single directions, so that modes are real, and coefficients of other sizes.
#[test]
fn small_problems_of_all_kinds_agree_too() {
    let mut told = 0;
    for seed in 0..400 {
        let (problem, origin, region) = small_problem(seed);
        told += tried(&problem, &origin, &[region], &[0.05; 6], 20).told;
    }
    assert!(told > 1000, "{told}");
}

/// A mode that is not kept comes down into the band, where it is unstable: no coupling tells of it.
#[test]
fn a_mode_that_is_not_kept_and_enters_a_band_is_seen() {
    let stiffness = [DMatrix::from_diagonal(&dvector![1.0, 0.0]), DMatrix::from_diagonal(&dvector![0.0, 4.0])];
    let damping = [DMatrix::from_diagonal(&dvector![0.02, -0.01])];
    let problem = DenseQuadratic::new(&DMatrix::identity(2, 2), &damping, &stiffness, &[1.0; 3]).unwrap();
    let region = [Region { lowest: 0.9, highest: 1.1, damping_ratio: 0.0 }.in_unit(problem.unit())];
    let centre = Centre::new(&problem, &[1.0; 3], &[2], &region).unwrap();
    assert_eq!(centre.kept(), 1);
    assert_eq!(centre.regions(&[1.0, 1.0, 0.8]), Some(0));
    assert_ne!(centre.regions(&[1.0, 1.0, 0.25]), Some(0));
    // Other coefficients than those it was made for are none of its own.
    assert_eq!(centre.regions(&[1.0, 1.01, 1.0]), None);
    assert_eq!(centre.distance(&[1.0, 1.01, 1.0]), None);
}

#[test]
fn there_is_no_centre_where_nothing_changes_or_vectors_are_nearly_parallel() {
    let (problem, regions) = structure(1, 6);
    assert!(Centre::new(&problem, &[1.0; 5], &[4], &regions).is_some());
    assert!(Centre::new(&problem, &[1.0; 5], &[], &regions).is_none());
    // Two modes that friction makes one.
    let modes = close_modes(1e-2, 4e-4);
    let region = [Region { lowest: 0.5, highest: 2.0, damping_ratio: 0.0 }.in_unit(modes.unit())];
    assert!(Centre::new(&modes, &[1.0, 1.0, 0.1], &[2], &region).is_some());
    assert!(Centre::new(&modes, &[1.0, 1.0, 0.5], &[2], &region).is_none());
    let narrow = region.map(|region| Region { damping_ratio: 0.95, ..region });
    assert!(Centre::new(&modes, &[1.0, 1.0, 0.1], &[2], &narrow).is_none());
}

/// `q'' + 2 q' + k q = 0` beside two oscillators, one of them growing or not: the first diverges where k is negative, and both of its
/// eigenvalues are real below 1. Bands begin at 0, where they are.
#[test]
fn what_diverges_is_told_in_bands_from_zero() {
    let damping =
        [DMatrix::from_diagonal(&dvector![2.0, 0.04, 0.02]), DMatrix::from_diagonal(&dvector![0.0, 0.0, 1.0])];
    let stiffness =
        [DMatrix::from_diagonal(&dvector![0.0, 1.0, 9.0]), DMatrix::from_diagonal(&dvector![1.0, 0.0, 0.0])];
    let problem = DenseQuadratic::new(&DMatrix::identity(3, 3), &damping, &stiffness, &[1.0; 4]).unwrap();
    for highest in [2.0, 4.0, f64::INFINITY] {
        let region = [Region { lowest: 0.0, highest, damping_ratio: 0.0 }.in_unit(problem.unit())];
        for (k, growth, from) in
            [(0.3, 0.0, 0.2), (-0.3, 0.0, -0.5), (0.3, -0.1, 0.2), (-0.3, -0.1, -0.2), (3.0, 0.0, 2.5)]
        {
            let place = |k: f64| [1.0, growth, 1.0, k];
            let centre = Centre::new(&problem, &place(from), &[3], &region).unwrap();
            let expected = k < 0.0 || growth < 0.0 && highest > 3.0;
            assert_eq!(centre.regions(&place(k)), Some(u64::from(expected)), "{highest} {k} {growth}");
            // On the other side of zero, which is at the edge, it is told rightly or not at all.
            let other = u64::from(k > 0.0 || growth < 0.0 && highest > 3.0);
            assert!(centre.regions(&place(-k)).is_none_or(|told| told == other), "{highest} {k} {growth}");
        }
    }
}

/// A mass that a damper alone holds, and that drives another by friction: a zero whatever the coefficients, whose left vector damping
/// moves, and whose right one friction does. What couples it with others both ways counts: the mode at 1.0228 rad/s would be in the
/// band without. In a band from 0 Hz the zero is at the edge.
#[test]
fn a_zero_that_couples_both_ways_counts() {
    let matrix = |entries: [f64; 4]| DMatrix::from_row_slice(2, 2, &entries);
    let damping = [matrix([-0.05, 0.0, 0.0, 1.0]), matrix([0.0, 0.0, 1.0, 0.0])];
    let stiffness = [matrix([1.0, 0.0, 0.0, 0.0]), matrix([0.0, 1.0, 0.0, 0.0])];
    let problem = DenseQuadratic::new(&DMatrix::identity(2, 2), &damping, &stiffness, &[1.0, 0.0, 1.0, 0.0]).unwrap();
    assert_eq!(problem.zeros(), 1);
    let origin = [1.0, 0.0, 1.0, 0.0];
    let mut told = [0; 2];
    for step in 0..60 {
        let lowest = 0.9 + 0.003 * f64::from(step);
        let region = [Region { lowest, highest: 2.0, damping_ratio: 0.0 }.in_unit(problem.unit())];
        let centre = Centre::new(&problem, &origin, &[1, 3], &region).unwrap();
        for (friction, coupling) in [(0.3, 0.3), (0.2, -0.2), (-0.1, -0.1), (0.05, 0.05)] {
            let coefficients = [1.0, coupling, 1.0, friction];
            let truth = Decider::of_each(&problem, &region).by_all(&coefficients).unwrap();
            let regions = centre.regions(&coefficients);
            assert!(regions.is_none_or(|regions| regions == truth), "{lowest} {friction} {coupling}");
            told[usize::from(truth != 0)] += usize::from(regions.is_some());
        }
    }
    assert!(told.iter().all(|told| *told > 20), "{told:?}");
    let from_zero = [Region { lowest: 0.0, highest: 2.0, damping_ratio: 0.0 }.in_unit(problem.unit())];
    assert_eq!(Centre::new(&problem, &origin, &[1, 3], &from_zero).unwrap().regions(&origin), None);
    assert!(!Centres::new(from_zero.to_vec(), vec![1, 3], origin.to_vec()).serve(&problem));
}
