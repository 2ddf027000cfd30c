//! Against the singular values of the whole pencil, and by hand.

use nalgebra::{Complex, DMatrix, dmatrix};

use super::*;
use crate::model::quantity::Limits;
use crate::models::matrices::terms::Parameter;
use crate::models::matrices::trial::Numbers;
use crate::numerics::eigenvalues::eigenvalues;

fn sparse(matrix: &DMatrix<f64>) -> Arc<Matrix> {
    let places = (0..matrix.nrows()).flat_map(|i| (0..matrix.ncols()).map(move |j| (i, j)));
    let entries: Vec<Entry> = places.map(|(i, j)| (i, j, matrix[(i, j)])).collect();
    Arc::new(built(matrix.nrows(), matrix.ncols(), &entries).unwrap())
}

fn dense(matrix: &Matrix) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix.get(i, j).copied().unwrap_or(0.0))
}

fn model(mass: &DMatrix<f64>, damping: &[(&DMatrix<f64>, &str)], stiffness: &[(&DMatrix<f64>, &str)]) -> Matrices {
    let term = |(matrix, factor): &(&DMatrix<f64>, &str)| Term {
        matrix: sparse(matrix),
        factor: Factor::parse(factor, &["p", "q"]).unwrap(),
    };
    let parameter = |name: &str| Parameter {
        name: name.to_owned(),
        value: 0.7,
        unit: "1".to_owned(),
        label: name.to_owned(),
        range: Limits::from(0.0, 10.0),
    };
    Matrices {
        mass: sparse(mass),
        damping: damping.iter().map(term).collect(),
        stiffness: stiffness.iter().map(term).collect(),
        parameters: ["p", "q"].map(parameter).to_vec(),
    }
}

/// M, C and K at these values of the parameters.
fn at(matrices: &Matrices, parameters: &[f64]) -> [DMatrix<f64>; 3] {
    let sum = |terms: &[Term]| {
        let zero = DMatrix::zeros(matrices.size(), matrices.size());
        terms.iter().fold(zero, |sum, term| sum + dense(&term.matrix) * term.factor.value(parameters))
    };
    [dense(&matrices.mass), sum(&matrices.damping), sum(&matrices.stiffness)]
}

fn eigenvalues_of([m, c, k]: &[DMatrix<f64>; 3]) -> Vec<Complex<f64>> {
    let n = m.nrows();
    let inverse = m.clone().try_inverse().unwrap();
    let mut first_order = DMatrix::zeros(2 * n, 2 * n);
    first_order.view_mut((0, n), (n, n)).fill_with_identity();
    first_order.view_mut((n, 0), (n, n)).copy_from(&(-&inverse * k));
    first_order.view_mut((n, n), (n, n)).copy_from(&(-inverse * c));
    eigenvalues(&first_order).unwrap().into_iter().map(|value| Complex::new(value.re, value.im)).collect()
}

/// The least singular value of `s^2 M + s C + K`, over the largest.
fn singular([m, c, k]: &[DMatrix<f64>; 3], s: Complex<f64>) -> f64 {
    let pencil =
        DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| s * s * m[(i, j)] + s * c[(i, j)] + Complex::new(k[(i, j)], 0.0));
    let values = pencil.try_svd(false, false, f64::EPSILON, 1000).unwrap().singular_values;
    values.min() / values.max()
}

#[test]
fn a_joint_without_mass_is_two_springs_in_a_row() {
    let mass = DMatrix::from_diagonal(&nalgebra::dvector![1.0, 0.0, 1.0]);
    let chain = dmatrix![2.0, -1.0, 0.0; -1.0, 2.0, -1.0; 0.0, -1.0, 2.0];
    let found = condensed(&model(&mass, &[], &[(&chain, "p")])).unwrap().unwrap();
    assert_eq!(dense(&found.matrices.mass), DMatrix::identity(2, 2));
    assert_eq!(dense(&found.matrices.stiffness[0].matrix), dmatrix![1.5, -0.5; -0.5, 1.5]);
    assert_eq!(dense(&found.displacements), dmatrix![1.0, 0.0; 0.5, 0.5; 0.0, 1.0]);
}

#[test]
fn models_with_mass_everywhere_are_left_alone() {
    let stiffness = dmatrix![2.0, -1.0; -1.0, 2.0];
    for mass in [dmatrix![1.0, 0.0; 0.0, 1e-12], dmatrix![2.0, 1.0; 1.0, 2.0], dmatrix![1.0, 2.0; 2.0, 1.0]] {
        assert!(condensed(&model(&mass, &[], &[(&stiffness, "1")])).unwrap().is_none());
    }
    // Between a motion with little mass and one with none there is no telling.
    let near = dmatrix![1.0, 1.0 - 1e-6; 1.0 - 1e-6, 1.0];
    assert!(condensed(&model(&near, &[], &[(&stiffness, "1")])).unwrap().is_none());
}

/// Masses with an offset from their nodes, rotations without inertia, friction and damping between those with mass, a damping of
/// the joints like their stiffness: at other values of the parameters too, every eigenvalue of what is left is one of the whole.
#[test]
fn what_is_left_has_the_eigenvalues_of_the_whole() {
    let mut numbers = Numbers(7);
    let mut random = move || 0.5 * (numbers.next() + 1.0);
    let mut worst = 0.0_f64;
    for _ in 0..40 {
        let n = 8;
        let mut mass = DMatrix::zeros(n, n);
        for node in 0..3 {
            let (m, offset) = (0.5 + random(), 0.2 * random() + 0.05);
            let own = [(0, 0, m), (0, 1, m * offset), (1, 0, m * offset), (1, 1, m * offset * offset)];
            own.into_iter().for_each(|(i, j, value)| mass[(2 * node + i, 2 * node + j)] = value);
        }
        mass[(6, 6)] = 0.3;
        let springs = DMatrix::from_fn(n, n, |_, _| random() - 0.5);
        let held = springs.tr_mul(&springs) + DMatrix::identity(n, n) * 0.3;
        // Between motions with mass alone: by the accelerations that are left, M x.
        let with_mass = |of: DMatrix<f64>| &mass * of * &mass;
        let friction = with_mass(DMatrix::from_fn(n, n, |_, _| random() - 0.5));
        let damper = with_mass(DMatrix::identity(n, n));
        let structural = &held * 0.003;
        let whole = model(
            &mass,
            &[(&damper, "0.02 * q"), (&structural, "1")],
            &[(&friction, "q"), (&held, "p"), (&held, "-0.1 * p")],
        );
        let found = condensed(&whole).unwrap().unwrap();
        assert_eq!((found.matrices.size(), found.displacements.nrows()), (4, 8));
        for parameters in [[0.7, 0.7], [2.0, 0.1], [0.3, 1.9]] {
            let full = at(&whole, &parameters);
            let own = eigenvalues_of(&at(&found.matrices, &parameters));
            assert_eq!(own.len(), 8);
            for s in own {
                worst = worst.max(singular(&full, s));
            }
        }
    }
    assert!(worst < 1e-11, "{worst}");
}

#[test]
fn what_cannot_be_condensed_is_said() {
    let mass = dmatrix![1.0, 0.0; 0.0, 0.0];
    let refused = |damping: &[(&DMatrix<f64>, &str)], stiffness: &[(&DMatrix<f64>, &str)]| {
        condensed(&model(&mass, damping, stiffness)).unwrap_err()
    };
    let held = dmatrix![2.0, -1.0; -1.0, 1.0];
    for other in [dmatrix![2.0, 0.0; 0.0, 0.0], dmatrix![2.0, 1.0; -1.0, 0.0], dmatrix![2.0, -1.0; -1.0, -1.0]] {
        assert_eq!(refused(&[], &[(&other, "1")]), CondensationError::NotHeld { place: 1 });
    }
    let damper = dmatrix![1.0, 0.0; 0.0, 1.0];
    assert_eq!(
        refused(&[(&damper, "1")], &[(&held, "1")]),
        CondensationError::Changing { place: 1, terms: vec![0, 1] }
    );
    let friction = dmatrix![0.0, 0.3; 0.0, 0.0];
    assert_eq!(
        refused(&[], &[(&held, "1"), (&friction, "p")]),
        CondensationError::Changing { place: 1, terms: vec![0, 1] }
    );
    // With one factor, or in the same proportions, it can be.
    for (other, factor) in [(&friction, "2"), (&held, "p")] {
        let found = condensed(&model(&mass, &[], &[(&held, "1"), (other, factor)])).unwrap().unwrap();
        assert_eq!(found.matrices.size(), 1);
    }
    let size = MOST + 2;
    let mass = DMatrix::from_fn(size, size, |i, j| f64::from(u8::from(i == 0 && j == 0)));
    let chain = DMatrix::from_fn(size, size, |i, j| match i.abs_diff(j) {
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    });
    let many = condensed(&model(&mass, &[], &[(&chain, "1")])).unwrap_err();
    assert_eq!(many, CondensationError::TooMany { place: 1, count: MOST + 1 });
}
