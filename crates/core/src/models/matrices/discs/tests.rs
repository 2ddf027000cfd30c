use nalgebra::DMatrix;

use super::*;
use crate::models::matrices::trial;

/// `a + b p + c p^2 + e p^3` for each coefficient.
struct Cubic(Vec<[f64; 4]>);

impl Path for Cubic {
    fn series(&self, p: f64, step: f64) -> Vec<[f64; 4]> {
        let about = |[a, b, c, e]: &[f64; 4]| {
            let beyond = e.abs() * step * step * step;
            [a + p * (b + p * (c + p * e)), b + p * (2.0 * c + p * 3.0 * e), c + 3.0 * p * e, beyond]
        };
        self.0.iter().map(about).collect()
    }
}

/// The matrix of first order in the turned basis, computed as it is defined: it is nowhere farther from the centres than `own`, and
/// outside of its diagonal nowhere larger than `outside`, over the whole interval.
#[test]
fn what_is_left_out_of_the_centres_is_bounded_over_the_interval() {
    let (mut intervals, mut with_rest, mut close) = (0, 0, 0);
    for seed in 0..200 {
        let (problem, origin, _) = trial::problem(seed);
        let mut numbers = trial::Numbers(seed);
        let has_rest = seed % 2 == 0;
        let curved = |value: &f64| {
            let [b, c, e] = [0.4, 0.6, 0.5].map(|size| size * numbers.next());
            [*value, b, c, if has_rest { e } else { 0.0 }]
        };
        let path = Cubic(origin.iter().map(curved).collect());
        let p = 0.1;
        let Some(found) = Decomposition::balanced(&problem.at(&path.coefficients(p))) else { continue };
        for step in [1.0, 0.3, 0.1, 0.03, 0.01] {
            let Some(expansion) = Expansion::new(&problem, &path, (p, step), &[]) else { continue };
            let Some(discs) = expansion.discs(step) else { continue };
            intervals += 1;
            with_rest += usize::from(has_rest);
            let [turns, direct] = expansion.turns(step);
            close += usize::from(direct.iter().any(|entry| *entry != Complex::from(0.0)));
            for part in [-1.0, -0.6, 0.5, 1.0] {
                let d = part * step;
                let companion: ComplexMatrix = problem.at(&path.coefficients(p + d)).companion().map(Complex::from);
                let turned = ComplexMatrix::identity(turns.nrows(), turns.nrows()) + &turns * Complex::from(d);
                let image = &found.inverse * companion * &found.vectors * &turned;
                let matrix = turned.try_inverse().unwrap() * image;
                for i in 0..matrix.nrows() {
                    for j in 0..matrix.ncols() {
                        let centre = discs.centres[i].iter().rev().fold(Complex::from(0.0), |sum, of| sum * d + of);
                        let (off, bound) = if i == j {
                            (matrix[(i, i)] - centre, discs.own[i])
                        } else {
                            (matrix[(i, j)], discs.outside[(i, j)])
                        };
                        assert!(magnitude(off) <= bound * (1.0 + 1e-9), "{seed} {step} {part} {i} {j}: {off} {bound}");
                    }
                }
            }
        }
    }
    assert!(intervals > 300 && with_rest > 100 && close > 50, "{intervals} {with_rest} {close}");
}

/// Without a rest, what a centre has not is of fifth order.
#[test]
fn centres_are_off_by_the_fifth_power_of_the_interval() {
    let mut compared = 0;
    for seed in 0..60 {
        let (problem, origin, _) = trial::problem(seed);
        let path = Cubic(origin.iter().map(|value| [*value, 0.3, 0.2, 0.0]).collect());
        let own = |step: f64| Some(Expansion::new(&problem, &path, (0.1, step), &[])?.discs(step)?.own);
        let [Some(wide), Some(narrow)] = [2e-2, 1e-2].map(own) else { continue };
        for (wide, narrow) in wide.iter().zip(&narrow).filter(|(_, narrow)| **narrow > 1e-12) {
            assert!(wide / narrow > 20.0, "{seed}: {wide} {narrow}");
            compared += 1;
        }
    }
    assert!(compared > 20, "{compared}");
}

/// Friction that turns all vectors towards each other, each of two by the same part: together by more than a series can say.
#[test]
fn there_are_no_discs_where_all_vectors_together_turn_too_much() {
    let size = 12;
    let square = |i: usize| (1.0 + 0.1 * i as f64) * (1.0 + 0.1 * i as f64);
    let stiffness = [
        DMatrix::from_fn(size, size, |i, j| if i == j { square(i) } else { 0.0 }),
        DMatrix::from_fn(size, size, |i, j| (square(i) - square(j)).abs()),
    ];
    let mass = DMatrix::identity(size, size);
    let problem = DenseQuadratic::new(&mass, &[mass.clone() * 0.02], &stiffness, &[1.0; 3]).unwrap();
    let path = Cubic(vec![[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]);
    let mut found = [0, 0];
    for step in [0.01, 0.02, 0.05, 0.1, 0.15, 0.2] {
        let expansion = Expansion::new(&problem, &path, (0.0, step), &[]).unwrap();
        let sizes = expansion.turns(step)[0].map(magnitude) * step;
        let radius = sizes.complex_eigenvalues().iter().map(|value| magnitude(*value)).fold(0.0, f64::max);
        assert_eq!(expansion.discs(step).is_some(), radius < 1.0, "{step}: {radius}");
        found[usize::from(radius < 1.0)] += 1;
    }
    assert!(found[0] > 0 && found[1] > 0, "{found:?}");
}
