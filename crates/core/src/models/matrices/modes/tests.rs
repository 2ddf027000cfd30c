//! Derivatives against differences and closed forms, by dense and by sparse matrices.

use std::sync::Arc;

use faer::sparse::{SparseColMat, Triplet};

use super::*;
use crate::model::quantity::Limits;
use crate::models::matrices::factor::Factor;
use crate::models::matrices::model::ComplexEigenvalue;
use crate::models::matrices::pair::Complex;
use crate::models::matrices::problem::Solver;
use crate::models::matrices::terms::{Matrices, Matrix, Parameter, Term};

const ALL: Region = Region { lowest: 0.0, highest: f64::INFINITY, damping_ratio: 0.0 };

fn matrix(rows: &[&[f64]]) -> Arc<Matrix> {
    let entries = rows.iter().enumerate().flat_map(|(row, values)| {
        values.iter().enumerate().map(move |(col, &val)| Triplet { row, col, val }).collect::<Vec<_>>()
    });
    Arc::new(SparseColMat::try_new_from_triplets(rows.len(), rows.len(), &entries.collect::<Vec<_>>()).unwrap())
}

fn model(
    mass: &[&[f64]],
    damping: &[(&[&[f64]], &str)],
    stiffness: &[(&[&[f64]], &str)],
    names: &[&str],
) -> [MatrixModel; 2] {
    let terms = |terms: &[(&[&[f64]], &str)]| {
        let term = |(rows, factor): &(&[&[f64]], &str)| Term {
            matrix: matrix(rows),
            factor: Factor::parse(factor, names).unwrap(),
        };
        terms.iter().map(term).collect()
    };
    let parameter = |name: &&str| Parameter {
        name: (*name).to_owned(),
        value: 1.0,
        unit: "1".to_owned(),
        label: String::new(),
        range: Limits::ANY,
    };
    let matrices = Arc::new(Matrices {
        mass: matrix(mass),
        damping: terms(damping),
        stiffness: terms(stiffness),
        parameters: names.iter().map(parameter).collect(),
    });
    let criterion =
        ComplexEigenvalue { bands: vec![[0.0, f64::INFINITY]], damping_ratio: 0.0, counts_rigid_body_motions: false };
    [Solver::Dense, Solver::Sparse].map(|solver| MatrixModel::new(matrices.clone(), criterion.clone(), solver).unwrap())
}

/// Hulten's brake, with friction-induced damping over the speed.
fn drum_brake() -> [MatrixModel; 2] {
    let [a, b] = [394_784.0, 222_066.0];
    model(
        &[&[1.0, 0.0], &[0.0, 1.0]],
        &[(&[&[628.0, 0.0], &[0.0, 471.0]], "damping"), (&[&[3.0, 1.0], &[0.0, 5.0]], "friction / speed^2")],
        &[(&[&[a, 0.0], &[0.0, b]], "1"), (&[&[0.0, -b], &[a, 0.0]], "friction")],
        &["friction", "damping", "speed"],
    )
}

/// By closed form at one point, by differences of eigenvalues; the same by the sparse solver.
#[test]
fn derivatives_of_modes_are_differences() {
    let [dense, sparse] = drum_brake();
    // Sparse matrices find damping ratios to 0.05 above the threshold.
    let band = Region { lowest: 100.0, highest: 2000.0, damping_ratio: 0.1 };
    for point in [[0.25, 0.02, 0.7], [0.4, 0.02, 2.0]] {
        let modes = dense.modes(&point, &[ALL]).unwrap();
        assert_eq!(modes.len(), 2);
        for parameter in 0..3 {
            let moved = |by: f64| {
                let mut moved = point;
                moved[parameter] *= 1.0 + by;
                dense.modes(&moved, &[ALL]).unwrap()
            };
            let (less, more) = (moved(-1e-5), moved(1e-5));
            for (mode, (less, more)) in modes.iter().zip(less.iter().zip(&more)) {
                let step = 2e-5 * point[parameter];
                let expected = (more.eigenvalue - less.eigenvalue) / Complex::from(step);
                let slope = mode.slopes.as_ref().unwrap()[parameter];
                assert!(magnitude(slope - expected) < 1e-5 * magnitude(expected), "{slope} {expected}");
                let ratio = (more.damping_ratio() - less.damping_ratio()) / step;
                assert!((mode.damping_ratio_slope(parameter).unwrap() - ratio).abs() < 1e-5 * ratio.abs());
                let frequency = (more.frequency() - less.frequency()) / step;
                assert!((mode.frequency_slope(parameter).unwrap() - frequency).abs() < 1e-4 * frequency.abs());
            }
        }
        let same = sparse.modes(&point, &[band]).unwrap();
        assert_eq!(same.len(), 2);
        for (a, b) in modes.iter().zip(&same) {
            assert!(magnitude(a.eigenvalue - b.eigenvalue) < 1e-9 * magnitude(a.eigenvalue));
            for (a, b) in a.slopes.as_ref().unwrap().iter().zip(b.slopes.as_ref().unwrap()) {
                assert!(magnitude(a - b) < 1e-9 * magnitude(*a), "{a} {b}");
            }
        }
    }
}

/// Two equal masses that a parameter couples: `lambda^2 = -(4 +- p)`, so `d lambda / dp = +-i/4` at the double eigenvalue 2i.
#[test]
fn modes_of_one_eigenvalue_have_the_derivatives_into_which_they_part() {
    let [dense, sparse] = model(
        &[&[1.0, 0.0], &[0.0, 1.0]],
        &[],
        &[(&[&[4.0, 0.0], &[0.0, 4.0]], "1"), (&[&[0.0, 1.0], &[1.0, 0.0]], "coupling")],
        &["coupling"],
    );
    let band = Region { lowest: 1.0, highest: 3.0, damping_ratio: 0.0 };
    for (model, band) in [(dense, ALL), (sparse, band)] {
        let mut slopes: Vec<f64> = model
            .modes(&[0.0], &[band])
            .unwrap()
            .iter()
            .map(|mode| {
                assert!(magnitude(mode.eigenvalue - Complex::new(0.0, 2.0)) < 1e-9);
                mode.slopes.as_ref().unwrap()[0].im
            })
            .collect();
        slopes.sort_by(f64::total_cmp);
        assert_eq!(slopes.len(), 2);
        assert!((slopes[0] + 0.25).abs() < 1e-9 && (slopes[1] - 0.25).abs() < 1e-9, "{slopes:?}");
    }
}

/// At the friction at which two modes meet without damping there are no vectors, and no derivative that is a number.
#[test]
fn where_modes_meet_there_is_no_derivative() {
    let [masses, _] = model(
        &[&[1.0, 0.0], &[0.0, 1.0]],
        &[],
        &[(&[&[2.0, 1.0], &[1.0, 2.0]], "1"), (&[&[0.0, -1.0], &[0.0, 0.0]], "friction")],
        &["friction"],
    );
    for mode in masses.modes(&[1.0], &[ALL]).unwrap() {
        assert!((mode.eigenvalue.im - 2.0_f64.sqrt()).abs() < 1e-6);
        assert!(mode.slopes.is_none_or(|slopes| magnitude(slopes[0]) > 1e5));
    }
}

#[test]
fn a_large_model_needs_a_band_that_ends() {
    let [_, brake] = drum_brake();
    let message = brake.modes(&[0.2, 0.02, 1.0], &[ALL]).unwrap_err().to_string();
    assert!(message.contains("frequency = [1000.0, 3000.0]"), "{message}");
}
