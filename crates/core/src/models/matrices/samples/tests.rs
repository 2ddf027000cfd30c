use faer::sparse::Triplet;

use super::*;
use crate::models::matrices::factor::Factor;
use crate::models::matrices::problem::Solver;
use crate::models::matrices::terms::{Matrix, Parameter};

fn diagonal(entries: &[f64]) -> Arc<Matrix> {
    let entry = |(i, entry): (usize, &f64)| Triplet::new(i, i, *entry);
    let entries: Vec<_> = entries.iter().enumerate().map(entry).collect();
    Arc::new(Matrix::try_new_from_triplets(entries.len(), entries.len(), &entries).unwrap())
}

/// Modes at 1, 2, ... rad/s, a share of whose damping changes.
fn matrices(size: usize) -> Arc<Matrices> {
    let names = ["damping"];
    Arc::new(Matrices {
        mass: diagonal(&vec![1.0; size]),
        damping: vec![Term {
            matrix: diagonal(&(0..size).map(|i| 0.01 * (i as f64 + 1.0)).collect::<Vec<_>>()),
            factor: Factor::parse("damping", &names).unwrap(),
        }],
        stiffness: vec![Term {
            matrix: diagonal(&(0..size).map(|i| (i as f64 + 1.0) * (i as f64 + 1.0)).collect::<Vec<_>>()),
            factor: Factor::number(1.0),
        }],
        parameters: vec![Parameter {
            name: names[0].to_owned(),
            value: 1.0,
            unit: "1".to_owned(),
            label: names[0].to_owned(),
            range: Limits::ANY,
        }],
    })
}

fn regions(bands: &[[f64; 2]]) -> Vec<Region> {
    bands.iter().map(|&[lowest, highest]| Region { lowest, highest, damping_ratio: 0.0 }).collect()
}

/// The samples of such a model in all of these bands.
fn samples(size: usize, bands: &[[f64; 2]]) -> Box<dyn Configuration> {
    let matrices = matrices(size);
    let problem = Problem::new(&matrices, Solver::Dense).unwrap();
    let all = regions(bands);
    let bands = Bands { own: all.clone(), places: (1 << all.len()) - 1, all };
    Samples::boxed(&matrices, &problem, bands, &[], &[1.0], &[0], None)
}

/// A series of perturbation theory was wrong where a mode came into a band from above, on one of a million samples. Where there is a
/// proof it is not asked, nor made.
#[test]
fn large_models_are_proved_and_no_series_is_made() {
    for (size, bands, is_proved) in [
        (20, &[[2.5, 4.5]][..], true),
        (20, &[[2.5, 4.5], [4.5, 6.5]], true),
        (20, &[[0.0, 4.5]], true),
        (20, &[[0.0, f64::INFINITY]], false),
        (8, &[[2.5, 4.5]], false),
    ] {
        let samples = samples(size, bands);
        let samples = Samples::from_any(&*samples).unwrap();
        for (damping, expected) in [(0.9, Verdict::Stable), (-0.2, Verdict::Unstable)] {
            assert_eq!(samples.verdict(&[damping, 1.0], true), Some(expected), "{size} {bands:?} {damping}");
        }
        assert_eq!(samples.shared.series.get().is_none(), is_proved, "{size} {bands:?}");
        let told = samples.together.as_ref().map_or(0, |together| together.centres.told());
        assert_eq!(told, if is_proved { 2 } else { 0 }, "{size} {bands:?}");
    }
}

/// Of full matrices each band is searched for itself, and once: whether the cell of any band comes before or after its own.
#[test]
fn full_matrices_are_searched_once_in_each_band() {
    let matrices = matrices(20);
    let problem = Problem::new(&matrices, Solver::Sparse).unwrap();
    let sample = [-0.2, 1.0];
    // Two modes, none, and one; and a band without an end, in which nothing can be searched.
    let bands = [[2.5, 4.5], [4.6, 4.9], [6.5, 7.5], [8.5, f64::INFINITY]];
    let cell = |count: usize, band: usize, like: Option<&dyn Configuration>| {
        let all = regions(&bands[..count]);
        let is_own = |place: &usize| band == 0 || band == place + 1;
        let places = (0..count).filter(is_own);
        let own = places.clone().map(|place| all[place]).collect();
        let bands = Bands { all, own, places: places.map(region_at).sum() };
        Samples::boxed(&matrices, &problem, bands, &[], &[1.0], &[0], like)
    };
    let verdict = |cell: &dyn Configuration| Samples::from_any(cell).unwrap().verdict(&sample, true).unwrap();
    for order in [&[0][..], &[1, 2, 3], &[2, 0], &[3, 1, 2, 0]] {
        let first = cell(3, order[0], None);
        for &band in order {
            let expected = if band == 2 { Verdict::Stable } else { Verdict::Unstable };
            assert_eq!(verdict(&*cell(3, band, Some(&*first))), expected, "{order:?} {band}");
        }
        let together = Samples::from_any(&*first).unwrap().together.as_ref().unwrap();
        for band in (0..=3).filter(|band| !order.contains(band)) {
            let own = if band == 0 { 0b111 } else { region_at(band - 1) };
            let asked = together.decided.as_ref().unwrap().ask(&sample, own);
            assert!(matches!(asked, Asked::Decided(0b101)), "{order:?} {band}");
        }
    }
    for (band, expected) in [(1, Verdict::Unstable), (2, Verdict::Stable), (4, Verdict::Failed), (0, Verdict::Failed)] {
        assert_eq!(verdict(&*cell(4, band, None)), expected, "{band}");
    }
    // What is known of a band is not searched for again: here that would fail.
    let any = cell(4, 0, None);
    let together = Samples::from_any(&*any).unwrap().together.as_ref().unwrap();
    match together.decided.as_ref().unwrap().ask(&sample, 0b1000) {
        Asked::Unknown(undecided) => undecided.decided(Found { known: 0b1000, unstable: 0 }),
        Asked::Decided(_) | Asked::InWork => panic!("it is known"),
    };
    assert_eq!(verdict(&*any), Verdict::Unstable);
}
