use faer::Mat;
use nalgebra::Complex;

use super::*;
use crate::models::matrices::trial::Numbers;

fn number(numbers: &mut Numbers) -> Complex<f64> {
    Complex::new(numbers.next(), numbers.next())
}

/// The eigenvalues of a matrix by its entries.
fn eigenvalues(size: usize, entry: impl Fn(usize, usize) -> Complex<f64>) -> Vec<Eigenvalue> {
    Mat::from_fn(size, size, entry).eigenvalues().unwrap()
}

/// Two bands that meet, the upper one without an end in every third case.
fn bands(case: usize) -> [Region; 2] {
    let damping_ratio = [0.0, 0.05, -0.03][case % 3];
    let end = if case.is_multiple_of(3) { f64::INFINITY } else { 2.0 };
    [[0.5, 1.0], [1.0, end]].map(|[lowest, highest]| Region { lowest, highest, damping_ratio })
}

fn containing(regions: &[Region], values: &[Eigenvalue]) -> RegionSet {
    let of_region = |(place, region): (usize, &Region)| {
        if values.iter().any(|value| region.contains(*value)) { region_at(place) } else { 0 }
    };
    regions.iter().enumerate().map(of_region).fold(0, |all, region| all | region)
}

/// Two modes with these entries, whose errors grow from different places.
pub(in super::super) fn two(entries: [Complex<f64>; 4], constant: [f64; 2]) -> Bounded {
    Bounded {
        entries: entries.to_vec(),
        margins: vec![1e-9, 2e-9],
        rounding: 1e-15,
        constant: constant.to_vec(),
        slope: vec![0.25, 1.0],
        most: vec![2.0, 4.0],
        places: vec![Eigenvalue::new(0.0, 1.5), Eigenvalue::new(0.0, 1.6)],
        columns: vec![1.0, 3.0],
    }
}

/// How often regions were told, of those how often wrong, and how often they would be wrong without what bounds allow.
#[derive(Debug, Default, PartialEq)]
pub(in super::super) struct Tally {
    pub(in super::super) told: usize,
    pub(in super::super) wrong: usize,
    pub(in super::super) needed: usize,
}

/// Random matrices with entries of some size, which have errors as large as the bounds allow, told in some way.
pub(in super::super) fn tried(
    [constant, slope]: [f64; 2],
    cases: usize,
    tell: impl Fn(&Bounded, &[Region]) -> Option<RegionSet>,
) -> Tally {
    let mut tally = Tally::default();
    let mut numbers = Numbers(7);
    for case in 0..cases {
        let size = 1 + case % 9;
        let size_of_entries = [0.003, 0.03, 0.2][case / 9 % 3];
        let diagonal: Vec<Eigenvalue> =
            (0..size).map(|_| Eigenvalue::new(0.1 * numbers.next() - 0.03, 1.1 + 0.9 * numbers.next())).collect();
        let entries: Vec<Complex<f64>> = (0..size * size).map(|_| number(&mut numbers) * size_of_entries).collect();
        let entry = |i: usize, j: usize| if i == j { diagonal[i] } else { entries[i * size + j] };
        let phases: Vec<Complex<f64>> =
            (0..size * size).map(|_| number(&mut numbers)).map(|z| z / magnitude(z)).collect();
        let positive =
            |numbers: &mut Numbers, most: f64| (0..size).map(|_| most * numbers.next().abs()).collect::<Vec<f64>>();
        let columns = positive(&mut numbers, 1.0);
        let constants = positive(&mut numbers, constant);
        let slopes = positive(&mut numbers, slope);
        let places: Vec<Eigenvalue> = diagonal.iter().map(|value| Eigenvalue::new(0.0, value.im)).collect();
        // D + F + R = z with R = c b + (z - s) n b.
        let turned = |i: usize, j: usize| phases[i * size + j] * columns[j];
        let unit = |i: usize, j: usize| Complex::from(f64::from(u8::from(i == j)));
        let matrix = Mat::from_fn(size, size, |i, j| {
            entry(i, j) + turned(i, j) * constants[i] - turned(i, j) * places[i] * slopes[i]
        });
        let factor = Mat::from_fn(size, size, |i, j| unit(i, j) - turned(i, j) * slopes[i]);
        let inverse = faer::linalg::solvers::DenseSolveCore::inverse(&factor.partial_piv_lu());
        let exact = (inverse * matrix).eigenvalues().unwrap();
        let bounded = Bounded {
            margins: vec![1e-9; size],
            rounding: 1e-15,
            entries: (0..size * size).map(|place| entry(place / size, place % size)).collect(),
            constant: constants.clone(),
            slope: slopes.clone(),
            // Less than what the error is only where no eigenvalue can be.
            most: vec![0.6; size],
            places: places.clone(),
            columns: columns.clone(),
        };
        let regions = bands(case);
        let truth = containing(&regions, &exact);
        if let Some(told) = tell(&bounded, &regions) {
            tally.told += 1;
            tally.wrong += usize::from(told != truth);
        } else {
            tally.needed += usize::from(containing(&regions, &eigenvalues(size, entry)) != truth);
        }
    }
    tally
}

#[test]
fn regions_are_those_of_all_eigenvalues() {
    let Tally { told, wrong, .. } = tried([0.0, 0.0], 4000, Bounded::regions);
    assert_eq!(wrong, 0);
    assert!(told > 1500, "{told}");
}

#[test]
fn errors_as_large_as_the_bounds_change_nothing_that_is_told() {
    for (constant, slope) in [(0.02, 0.0), (0.0, 0.3), (0.02, 0.2)] {
        let Tally { told, wrong, needed } = tried([constant, slope], 4000, Bounded::regions);
        assert_eq!(wrong, 0, "{constant} {slope}");
        assert!(told > 500 && needed > 100, "{constant} {slope}: {told} {needed}");
    }
}

/// Two entries that meet, as at the onset of flutter, and are far from the boundary: what couples them does no harm.
#[test]
fn strong_coupling_far_from_the_boundary_is_harmless_and_near_it_is_not_told() {
    let pair = |growth: f64| Bounded {
        entries: [[growth, 1.5], [0.01, 0.0], [0.01, 0.0], [growth, 1.5]].map(|[re, im]| Complex::new(re, im)).to_vec(),
        margins: vec![1e-9; 2],
        rounding: 1e-15,
        constant: vec![0.0; 2],
        slope: vec![0.0; 2],
        most: vec![0.0; 2],
        places: vec![Eigenvalue::new(0.0, 1.5); 2],
        columns: vec![0.0; 2],
    };
    let regions = bands(1);
    assert_eq!(pair(-0.05 - 0.1).regions(&regions), Some(0));
    assert_eq!(pair(0.011).regions(&regions), Some(2));
    assert_eq!(pair(-0.0711).regions(&regions), None);
}

/// What grows fast is told as well, and what comes from above a band without an end.
#[test]
fn nothing_is_lost_far_to_the_right_or_far_above() {
    let one = |value: Eigenvalue, error: f64| Bounded {
        entries: vec![value],
        margins: vec![1e-9],
        rounding: 1e-15,
        constant: vec![error],
        slope: vec![0.0],
        most: vec![0.0],
        places: vec![Eigenvalue::new(0.0, 1.5)],
        columns: vec![1.0],
    };
    let region = |highest: f64| [Region { lowest: 1.0, highest, damping_ratio: 0.0 }];
    for (re, im, highest, error, expected) in [
        (0.5, -1.5, 2.0, 0.4, Some(0)),
        (7.0, 2.5, 2.0, 0.6, None),
        (7.0, 1.5, 2.0, 0.4, Some(1)),
        (7.0, 1.5, 2.0, 0.6, None),
        (7.0, 2.5, 2.0, 0.4, Some(0)),
        (7.0, 0.5, 2.0, 0.6, None),
        (0.5, 40.0, f64::INFINITY, 0.4, Some(1)),
        (0.5, 40.0, f64::INFINITY, 0.6, None),
        (-0.5, 40.0, f64::INFINITY, 0.4, Some(0)),
        (-0.5, 40.0, f64::INFINITY, 0.6, None),
        (0.5, 40.0, 1e9, 0.4, Some(1)),
        (0.5, 0.5, 1e9, 0.4, Some(0)),
    ] {
        assert_eq!(
            one(Eigenvalue::new(re, im), error).regions(&region(highest)),
            expected,
            "{re} {im} {highest} {error}"
        );
    }
}

/// An error that grows away from a place, up to a limit; a margin; and what comes from far above.
#[test]
fn the_limit_of_an_error_and_margins_count() {
    let one = |value: Eigenvalue, place: Eigenvalue, slope: f64, most: f64, margin: f64, constant: f64| Bounded {
        entries: vec![value],
        margins: vec![margin],
        rounding: 1e-15,
        constant: vec![constant],
        slope: vec![slope],
        most: vec![most],
        places: vec![place],
        columns: vec![1.0],
    };
    let region = [Region { lowest: 1.0, highest: 2.0, damping_ratio: 0.0 }];
    let (inside, place) = (Eigenvalue::new(0.5, 1.5), Eigenvalue::new(0.0, 1.5));
    assert_eq!(one(inside, place, 10.0, 0.4, 1e-9, 0.0).regions(&region), Some(1));
    assert_eq!(one(inside, place, 10.0, 0.6, 1e-9, 0.0).regions(&region), None);
    assert_eq!(one(inside, place, 0.0, 0.0, 1e-9, 0.4).regions(&region), Some(1));
    assert_eq!(one(inside, place, 0.0, 0.0, 0.2, 0.4).regions(&region), None);
    // An eigenvalue at 178 i is within the bounds.
    let unlimited = [Region { highest: f64::INFINITY, damping_ratio: 0.99, ..region[0] }];
    assert_eq!(one(Eigenvalue::new(0.0, 40.0), 0.0.into(), 0.8, 140.0, 1e-9, 0.0).regions(&unlimited), None);
}

/// Rounding of entries counts with the weights of all modes.
#[test]
fn rounding_of_all_entries_counts() {
    let matrix = |rounding: f64| Bounded {
        entries: vec![Eigenvalue::new(-0.1, 1.5), 0.0.into(), 0.0.into(), Eigenvalue::new(-0.1, 1.5)],
        margins: vec![1e-9; 2],
        rounding,
        constant: vec![0.0; 2],
        slope: vec![0.0; 2],
        most: vec![0.0; 2],
        places: vec![Eigenvalue::new(0.0, 1.5); 2],
        columns: vec![0.0; 2],
    };
    let region = [Region { lowest: 1.0, highest: 2.0, damping_ratio: 0.0 }];
    assert_eq!(matrix(0.04).regions(&region), Some(0));
    assert_eq!(matrix(0.06).regions(&region), None);
}

/// Regions that begin below 0: real eigenvalues that grow, and those between that and 0, are inside, those below it are not. None is told
/// where the matrix has an eigenvalue on the other side of the boundary than its diagonal.
#[test]
fn regions_that_begin_below_zero_have_what_is_above_their_lower_end() {
    let mut numbers = Numbers(17);
    let mut tally = [0; 3];
    for case in 0..4000 {
        let lowest = [-0.3, 0.0][case % 2];
        let region =
            Region { lowest, highest: [1.0, f64::INFINITY][case / 2 % 2], damping_ratio: [0.0, 0.05][case / 4 % 2] };
        let size = 1 + case % 5;
        let coupling = [0.003, 0.05][case / 8 % 2];
        let diagonal: Vec<Eigenvalue> =
            (0..size).map(|_| Eigenvalue::new(0.3 * numbers.next(), 0.7 * numbers.next())).collect();
        let entries: Vec<Complex<f64>> = (0..size * size).map(|_| number(&mut numbers) * coupling).collect();
        let entry = |i: usize, j: usize| if i == j { diagonal[i] } else { entries[i * size + j] };
        let bounded = Bounded {
            margins: vec![1e-9; size],
            rounding: 1e-15,
            entries: (0..size * size).map(|place| entry(place / size, place % size)).collect(),
            constant: vec![0.0; size],
            slope: vec![0.0; size],
            most: vec![0.0; size],
            places: diagonal.clone(),
            columns: vec![0.0; size],
        };
        let is_inside = |value: &Eigenvalue| {
            let ratio = -value.re / magnitude(*value);
            value.im > lowest && value.im <= region.highest && ratio < region.damping_ratio - RESOLUTION
        };
        let truth = u64::from(eigenvalues(size, entry).iter().any(is_inside));
        match bounded.regions(&[region]) {
            Some(told) => {
                assert_eq!(told, truth, "{region:?} {diagonal:?}");
                tally[told as usize] += 1;
            }
            None => tally[2] += 1,
        }
    }
    assert!(tally.iter().all(|count| *count > 200), "{tally:?}");
}
