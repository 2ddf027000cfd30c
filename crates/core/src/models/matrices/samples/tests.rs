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

/// Modes at 1, 2, ... rad/s, a share of whose damping changes, with these bands.
fn samples(size: usize, bands: &[[f64; 2]]) -> Box<dyn Configuration> {
    let names = ["damping"];
    let matrices = Arc::new(Matrices {
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
    });
    let problem = Problem::new(&matrices, Solver::Dense).unwrap();
    let all: Vec<Region> =
        bands.iter().map(|&[lowest, highest]| Region { lowest, highest, damping_ratio: 0.0 }).collect();
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
